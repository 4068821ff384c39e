// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/image/image.hpp"

namespace volute {

/// The framebuffer that is bound, as a linear picture whose bytes in a .png are those shown.
Image shownPicture(int width, int height);

}  // namespace volute
