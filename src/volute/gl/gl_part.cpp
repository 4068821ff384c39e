// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_part.hpp"

namespace volute {

Status GlPart::drawAlone(const GlPicture&, const GlTarget&) const {
  return fail(ErrorCode::kUnsupported, "{} is marched", name());
}

GlScene GlScene::scaled(double factor) const {
  GlScene scene = *this;
  if (factor != 1) {
    for (auto& part : scene.parts) part = part->scaled(factor);
  }
  return scene;
}

}  // namespace volute
