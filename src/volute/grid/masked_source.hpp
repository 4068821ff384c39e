// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>

#include "volute/grid/frame_source.hpp"

namespace volute {

/// Voxels whose values are not finite are not there: not active, and the background. A source
/// without topology gets one, in which all others are active. Of several channels, one that is not
/// finite is enough.
std::unique_ptr<FrameSource> withoutHoles(std::unique_ptr<FrameSource> source);

}  // namespace volute
