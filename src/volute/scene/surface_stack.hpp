// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <vector>

#include "volute/camera/camera.hpp"
#include "volute/image/image.hpp"
#include "volute/render/sign.hpp"
#include "volute/render/surfaces.hpp"

namespace volute {

/// All that is opaque in a picture, the nearest in each pixel; empty: nothing is.
class SurfaceStack {
 public:
  /// `background`: linear radiance where there is no surface.
  SurfaceStack(const Camera& camera, const Rgb& background)
      : width_(camera.width()), height_(camera.height()), background_(background) {}

  void add(SurfaceView view);

  /// Signs are opaque, but seen through a law of their own: what they send is not added here.
  void add(std::span<const SignPixel> signs);

  std::span<const float> depth() const { return depth_; }

  /// Null while nothing is there.
  const Image* color() const { return depth_.empty() ? nullptr : &color_; }

 private:
  void begin();
  void set(std::size_t pixel, float depth, const float* color);

  int width_, height_;
  Rgb background_;
  std::vector<float> depth_;
  Image color_;
};

}  // namespace volute
