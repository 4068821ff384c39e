// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cmath>

#include "volute/camera/camera.hpp"
#include "volute/tetmesh/tet_locator.hpp"

namespace volute {

/// A vertex before the camera: its picture is at (x, y) / w pixels from the picture's centre, its
/// depth is z [m] along the view (w = z for a pinhole, 1 for an orthographic camera).
struct ScreenVertex {
  float x, y, w, z;
};

/// A camera whose eye stands inside a tet, not on a face, edge or vertex of it: moved by a
/// millionth of the tet where it does.
struct ScreenView {
  ScreenView(const Camera& camera, const TetLocator& locator);

  ScreenVertex project(const Vec3& point) const;

  /// Distance along a pixel's ray for each metre of depth.
  double rayScale(int x, int y) const {
    const double px = x + 0.5 - 0.5 * width, py = y + 0.5 - 0.5 * height;
    return orthographic ? 1 : std::sqrt(1 + (px * px + py * py) / (perPixel * perPixel));
  }

  Vec3 eye, right, down, forward;
  double perPixel;  ///< 1 / Camera::pixelSize
  bool orthographic;
  int width, height;
};

/// Which pixels a triangle may touch: the box of those in whose centres it may lie, ends included;
/// empty when none. Parts behind the eye are cut off.
struct PixelBox {
  int x0 = 0, y0 = 0, x1 = -1, y1 = -1;

  bool empty() const { return x1 < x0 || y1 < y0; }
};

PixelBox pixelBox(const ScreenView& view, const ScreenVertex& a, const ScreenVertex& b,
                  const ScreenVertex& c);

/// Where a vertex is seen.
struct PixelPlace {
  float x = 0, y = 0;  ///< from the picture's centre
  bool ahead = false;  ///< false: behind the eye or all but; x and y mean nothing
};

PixelPlace pixelPlace(const ScreenVertex& vertex);

}  // namespace volute
