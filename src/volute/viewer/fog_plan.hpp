// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/gl/gl_object.hpp"
#include "volute/image/image.hpp"

namespace volute {

/// A map of fog from above, in colours, as a texture: row 0 at the largest y.
class FogPlan {
 public:
  /// The map has changed.
  void invalidate() { stale_ = true; }

  bool stale() const { return stale_; }

  /// @param map  one channel, 0..1
  void draw(const Image& map);

  GLuint texture() const { return texture_.name(); }

 private:
  GlTexture texture_;
  int width_ = 0, height_ = 0;
  bool stale_ = true;
};

}  // namespace volute
