// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>

#include "volute/gl/gl_volume.hpp"
#include "volute/render/billboard.hpp"

namespace volute {

/// Billboard's twin: a volume's picture on a rectangle that faces the camera, in order among other
/// media.
struct GlBillboard {
  GlVolume volume;
  BillboardOptions options;
};

std::shared_ptr<const GlPart> glPart(GlBillboard board);

}  // namespace volute
