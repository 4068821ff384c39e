// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/surface_corners.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace volute {
namespace {

/// A square in the plane z, seen from above.
void addSquare(std::vector<Triangle>& triangles, double side, double z) {
  const Vec3 a(-side, -side, z), b(side, -side, z), c(side, side, z), d(-side, side, z);
  triangles.push_back({{a, b, c}, 0});
  triangles.push_back({{a, c, d}, 0});
}

/// The light that `surfaces` has at a point of the floor, whose triangles it goes through.
double shown(const GlSurfaces& surfaces, double x, double y) {
  for (std::size_t t = 0; t + 9 <= surfaces.corners.size(); t += 18) {  // fronts
    const float* p = &surfaces.corners[t];
    if (p[2] != 0 || p[5] != 0 || p[8] != 0)
      continue;
    const auto area = [](double ax, double ay, double bx, double by) { return ax * by - ay * bx; };
    const double all = area(p[3] - p[0], p[4] - p[1], p[6] - p[0], p[7] - p[1]);
    const double s = area(x - p[0], y - p[1], p[6] - p[0], p[7] - p[1]) / all;
    const double u = area(p[3] - p[0], p[4] - p[1], x - p[0], y - p[1]) / all;
    if (s < -1e-9 || u < -1e-9 || s + u > 1 + 1e-9)
      continue;
    const float* light = &surfaces.colors[t];
    return (1 - s - u) * light[0] + s * light[3] + u * light[6];
  }
  return NAN;
}

TEST(SurfaceCorners, EdgesOfShadowsAndConesAreWhereTheyAre) {
  std::vector<Triangle> triangles;
  addSquare(triangles, 5, 0);
  addSquare(triangles, 0.9, 2);
  const auto geometry = TriangleScene::build(triangles, {});
  ASSERT_TRUE(geometry);
  Lamp lamp;
  lamp.position = Vec3(0.7, 0.4, 5);
  lamp.coneCosine = std::cos(0.7);
  lamp.intensity = Rgb(30, 30, 30);
  const std::vector<Lamp> lamps{lamp};
  const SurfaceScene scene{*geometry, lamps, Rgb(0.02, 0.02, 0.02)};
  const GlSurfaces surfaces = surfaceCorners(scene);
  EXPECT_LE(surfaces.corners.size(), 40000u * 18);
  double sum = 0, brightest = 0;
  int count = 0;
  for (double y = -4.95; y < 5; y += 0.1) {
    for (double x = -4.95; x < 5; x += 0.1) {
      const Segment look{Vec3(x, y, 0.01), -Vec3::UnitZ(), 0, 1};
      const double real = lookAtSurfaces(scene, {&look, 1}).front().radiance[0];
      const double error = std::abs(shown(surfaces, x, y) - real);
      ASSERT_FALSE(std::isnan(error)) << "no triangle at " << x << ", " << y;
      brightest = std::max(brightest, real);
      sum += error;
      ++count;
    }
  }
  ASSERT_GT(brightest, 0.3);
  EXPECT_LT(sum / count, 2e-3 * brightest) << "9e-3 with pieces of one size";
}

}  // namespace
}  // namespace volute
