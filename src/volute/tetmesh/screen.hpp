// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "volute/camera/camera.hpp"
#include "volute/tetmesh/tet_locator.hpp"

namespace volute {

/// A vertex before the camera: its picture is at (x, y) / w pixels from the view's origin, its
/// depth is z [m] along the view (w = z for a pinhole, 1 for an orthographic camera). An edge's
/// function at a pixel (px, py) is the cross product of its ends' (x - px w, y - py w): the
/// determinant of the ray's direction and both ends, whose sign says on which side the ray passes.
struct ScreenVertex {
  float x, y, w;
  float tau;  ///< extinction [1/m]
  float z;
  float r, g, b;  ///< source
};

/// What a ScreenVertex's x, y and w leave of the exact ones: near a pixel, where x - px w all but
/// cancels, they tell on which side of an edge a ray is and how far it runs in a thin tet.
struct ScreenRest {
  float x = 0, y = 0, w = 0, unused = 0;
};

/// A camera whose eye stands inside a tet, not on a face, edge or vertex of it: moved by a
/// millionth of the tet where it does.
struct ScreenView {
  ScreenView(const Camera& camera, const TetLocator& locator);

  /// x and y count from the origin, which is the picture's centre unless moved.
  ScreenVertex project(const Vec3& point) const;

  ScreenVertex project(const Vec3& point, ScreenRest& rest) const;

  /// A pixel's centre from the origin.
  double pixelX(int x) const { return x + 0.5 - originX; }

  double pixelY(int y) const { return y + 0.5 - originY; }

  /// Distance along a pixel's ray for each metre of depth.
  double rayScale(int x, int y) const;

  Vec3 eye, right, down, forward;
  double perPixel;  ///< 1 / Camera::pixelSize
  bool orthographic;
  int width, height;
  double originX, originY;   ///< [pixels]; near the pixels in question float says more of them
  std::int32_t eyeTet = -1;  ///< -1: the eye is outside, or the rays begin at -infinity
};

/// Which pixels a triangle may touch: the box of those in whose centres it may lie, ends included;
/// empty when none. Parts behind the eye are cut off.
struct PixelBox {
  int x0 = 0, y0 = 0, x1 = -1, y1 = -1;

  bool empty() const { return x1 < x0 || y1 < y0; }
};

PixelBox pixelBox(const ScreenView& view, const ScreenVertex& a, const ScreenVertex& b,
                  const ScreenVertex& c);

/// Where a vertex is seen, so that its faces need not divide.
struct PixelPlace {
  float x = 0, y = 0;  ///< from the view's origin
  bool ahead = false;  ///< false: behind the eye or all but; x and y mean nothing
};

PixelPlace pixelPlace(const ScreenVertex& vertex);

/// pixelBox for corners that are ahead, by their places.
PixelBox pixelBox(const ScreenView& view, const PixelPlace& a, const PixelPlace& b,
                  const PixelPlace& c);

}  // namespace volute
