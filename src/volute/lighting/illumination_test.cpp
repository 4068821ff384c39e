// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/lighting/illumination.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "volute/tetmesh/made_meshes.hpp"
#include "volute/tetmesh/tet_medium.hpp"

namespace volute {
namespace {

/// Two lamps above a box, a screen at x = 1 between them.
Illumination twoLamps() {
  Illumination light;
  light.lamps.resize(2);
  light.lamps[0].position = Vec3(0, 0, 5), light.lamps[1].position = Vec3(2, 0, 5);
  light.blocks = [](std::span<const Segment> ways, std::span<std::uint8_t> blocked) {
    for (std::size_t i = 0; i < ways.size(); ++i)
      blocked[i] = (ways[i].origin.x() < 1) != (ways[i].at(ways[i].end).x() < 1);
  };
  return light;
}

AnyMedium evenCube(const Vec3& centre, double half, float extinction) {
  const Vec3 size = Vec3::Constant(half);
  const auto mesh = boxMesh({centre - size, centre + size}, {3, 3, 3}, 0, 1);
  return AnyMedium(TetMedium(std::make_shared<TetLocator>(mesh),
                             std::vector<float>(mesh->vertices().size(), extinction)));
}

TEST(ArrivingLight, SurfacesTakeAllAndOnlyOnce) {
  const ArrivingLight arriving(twoLamps(), {Vec3(-1, -1, 0), Vec3(3, 1, 1)});
  const Vec3 points[] = {Vec3(0, 0, 0.5), Vec3(2, 0, 0.5), Vec3(0.5, 0, 0.5)};
  for (const std::size_t lamp : {0, 1}) {
    std::vector<float> shares{0.5F, 0.25F, 0};
    arriving.takeFrom(lamp, points, shares, false);
    EXPECT_EQ(shares, (std::vector<float>{0.5F, 0.25F, 0}));
    arriving.takeFrom(lamp, points, shares);
    EXPECT_EQ(shares,
              (lamp == 0 ? std::vector<float>{0.5F, 0, 0} : std::vector<float>{0, 0.25F, 0}));
  }
}

TEST(ArrivingLight, OtherMediaTakeWhatTheirDepthSays) {
  Illumination light = twoLamps();
  const AnyMedium other = evenCube(Vec3(0, 0, 2.5), 0.5, 1.2F);
  light.between = {other};
  const ArrivingLight arriving(light, {Vec3(-1, -1, 0), Vec3(3, 1, 1)});
  const Vec3 points[] = {Vec3(0, 0, 0.5), Vec3(0.1, 0.05, 0.2), Vec3(-0.8, 0, 0.1)};
  std::vector<float> shares(3, 1);
  arriving.takeFrom(0, points, shares);
  for (std::size_t i = 0; i < 3; ++i) {
    const Segment way = light.lamps[0].towards(points[i]);
    double depth = 0;
    other.opticalDepth({&way, 1}, {&depth, 1});
    EXPECT_NEAR(shares[i], std::exp(-depth), 5e-3) << i;
  }
}

TEST(Illumination, ScattersOnceUnlessAskedFor) {
  Illumination light = twoLamps();
  const AnyMedium cube = evenCube(Vec3::Zero(), 0.5, 4);
  EXPECT_FALSE(light.again(cube, cube.bounds(), {Rgb::Ones()}));
  light.multiple = true;
  const auto again = light.again(cube, cube.bounds(), {Rgb::Ones()});
  ASSERT_TRUE(again);
  EXPECT_GT(again->at(Vec3::Zero())[0], 0);
  light.lamps.clear();
  EXPECT_FALSE(light.again(cube, cube.bounds(), {Rgb::Ones()}));
}

}  // namespace
}  // namespace volute
