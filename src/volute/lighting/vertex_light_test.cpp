// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/lighting/vertex_light.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "volute/base/parallel.hpp"
#include "volute/tetmesh/made_meshes.hpp"
#include "volute/tetmesh/tet_medium.hpp"

namespace volute {
namespace {

struct Hall {
  std::shared_ptr<const TetMesh> mesh = hallMesh(1.1, 3);
  std::shared_ptr<const TetLocator> locator = std::make_shared<TetLocator>(mesh);
  LampPaths paths{locator};
  std::vector<float> extinction = plume(*mesh, 0, 1);

  Hall() {
    for (float& k : extinction) k *= 0.3F;
  }
};

const Hall& hall() {
  static const Hall hall;
  return hall;
}

Lamp spot(const Vec3& position, const Vec3& target, double degrees = 360) {
  Lamp lamp;
  lamp.position = position;
  lamp.direction = (target - position).normalized();
  lamp.coneCosine = std::cos(degrees / 2 * std::numbers::pi / 180);
  return lamp;
}

Lamp sun(const Vec3& direction) {
  Lamp lamp;
  lamp.kind = Lamp::Kind::kSun;
  lamp.direction = direction.normalized();
  return lamp;
}

Vec3 vertexNear(const Vec3& point) {
  const auto points = hall().mesh->vertices();
  return *std::ranges::min_element(points, {}, [&](const Vec3& p) { return (p - point).norm(); });
}

/// In the hall, in its small room, outside, on a vertex, level with many vertices, and the sun.
std::vector<Lamp> lamps() {
  return {
      spot(Vec3(10.1, 6.3, 5.5), Vec3(14, 6, 0)), spot(Vec3(24.3, 5.7, 3.3), Vec3(20, 6, 1), 90),
      spot(Vec3(-3, -4, 9), Vec3(14, 6, 3)),      spot(vertexNear(Vec3(15, 6, 3)), Vec3(0, 0, 0)),
      spot(Vec3(1, 6, 3), Vec3(28, 6, 3)),        sun(Vec3(0.3, 0.2, -1))};
}

/// The way of the light by other means: the medium's depth, and points along the way that are in
/// no tet.
struct Reference {
  double share = 0;
  bool nearEdge = false;  ///< the way grazes a wall: two answers are right
};

Reference referenceShare(const TetMedium& medium, const Segment& way, bool lampInside) {
  const Vec3 size = medium.bounds().size();
  Segment cut = way;
  cut.end = std::min(way.end, 3 * size.maxCoeff());
  double depth = 0;
  medium.opticalDepth({&cut, 1}, {&depth, 1});
  constexpr int kProbes = 400;
  const auto dark = [&](const Vec3& aside) {
    bool outside = false;
    for (int i = 0; i < kProbes; ++i) {
      const Vec3 point = cut.at(cut.begin + (cut.end - cut.begin) * (i + 0.5) / kProbes) + aside;
      const bool here = hall().locator->find(point) >= 0;
      if (here && outside)
        return true;
      outside = !here;
    }
    return outside && lampInside;
  };
  Reference out{dark(Vec3::Zero()) ? 0 : std::exp(-depth), false};
  const double step = 3 * (cut.end - cut.begin) / kProbes;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      const Vec3 aside = sign * step * Vec3::Unit(axis);
      out.nearEdge |= dark(aside) != (out.share == 0);
    }
  }
  return out;
}

TEST(LampPaths, AgreeWithARayForEachVertex) {
  const TetMedium medium(hall().locator, hall().extinction);
  for (const Lamp& lamp : lamps()) {
    const auto shares = hall().paths.shares(hall().extinction, lamp);
    const bool inside = lamp.kind == Lamp::Kind::kSpot && hall().locator->find(lamp.position) >= 0;
    int compared = 0, lit = 0, dark = 0;
    for (std::size_t i = 0; i < shares.size(); i += 6) {
      const Vec3& point = hall().mesh->vertices()[i];
      const Segment way = lamp.towards(point);
      if (way.empty())
        continue;
      const Reference reference = referenceShare(medium, way, inside);
      if (reference.nearEdge)
        continue;
      ++compared;
      ++(reference.share > 0 ? lit : dark);
      EXPECT_NEAR(shares[i], reference.share, 1e-4) << i << " at " << point;
    }
    const Vec3& at = lamp.position;
    EXPECT_GT(compared, 20) << at;
    EXPECT_GT(lit, 10) << at << ": " << dark << " dark";
    if (inside) {
      EXPECT_GT(dark, 0) << at;
    }
  }
}

/// The walk and its slow twin, at every vertex, grazing ways as well.
TEST(LampPaths, AgreeWithTheirTwinEverywhere) {
  for (const Lamp& lamp : lamps()) {
    const auto shares = hall().paths.shares(hall().extinction, lamp);
    int different = 0;
    for (std::size_t i = 0; i < shares.size(); i += 2) {
      const Vec3& point = hall().mesh->vertices()[i];
      const double twin =
          lampShareReference(*hall().locator, hall().extinction, lamp.towards(point));
      different += !(std::abs(shares[i] - twin) <= 1e-6);
    }
    EXPECT_LE(different, 0);
  }
}

TEST(LampPaths, AreExactInASlab) {
  const auto mesh = boxMesh({Vec3(0, 0, 0), Vec3(4, 3, 2)}, {5, 4, 3}, 0.3, 9);
  const LampPaths paths(std::make_shared<TetLocator>(mesh));
  const std::vector<float> extinction(mesh->vertices().size(), 0.7F);
  const Lamp lamp = spot(Vec3(1.3, 1.1, 0.9), Vec3(4, 3, 2));
  const auto shares = paths.shares(extinction, lamp);
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const double distance = (mesh->vertices()[i] - lamp.position).norm();
    EXPECT_NEAR(shares[i], std::exp(-0.7 * distance), 1e-6);
  }
  // From above, only what lies in the slab counts.
  const auto sunlit = paths.shares(extinction, sun(Vec3(0, 0, -1)));
  for (std::size_t i = 0; i < shares.size(); ++i)
    EXPECT_NEAR(sunlit[i], std::exp(-0.7 * (2 - mesh->vertices()[i].z())), 1e-6);
}

TEST(LampPaths, DoNotDependOnThreads) {
  const auto many = hall().paths.shares(hall().extinction, lamps()[0]);
  const ThreadLimit one(1);
  EXPECT_EQ(hall().paths.shares(hall().extinction, lamps()[0]), many);
}

TEST(Lamp, ShinesInItsCone) {
  Lamp lamp = spot(Vec3(0, 0, 4), Vec3(0, 0, 0), 60);
  lamp.intensity = Rgb(8, 4, 2);
  EXPECT_TRUE(lamp.irradiance(Vec3(0, 0, 2)).isApprox(Rgb(2, 1, 0.5)));
  EXPECT_TRUE(lamp.irradiance(Vec3(1.1, 0, 2)).isApprox(lamp.intensity / (4 + 1.21)));
  EXPECT_TRUE(lamp.irradiance(Vec3(1.2, 0, 2)).isZero(0));
  EXPECT_TRUE(lamp.irradiance(Vec3(0, 0, 5)).isZero(0));
  EXPECT_TRUE(lamp.irradiance(lamp.position).isApprox(lamp.intensity / (0.05 * 0.05)));
  EXPECT_TRUE(sun(Vec3(0, 1, -1)).irradiance(Vec3(7, 8, 9)).isApprox(Rgb::Ones()));
}

TEST(ScatteredLight, IsWhatComesInTimesTheAlbedo) {
  const std::vector<Vec3> points = {Vec3(0, 0, 0), Vec3(0, 0, 2)};
  Lamp first = spot(Vec3(0, 0, 4), Vec3(0, 0, 0));
  first.intensity = Rgb(16, 8, 4);
  const std::vector<Lamp> both = {first, sun(Vec3(1, 0, -1))};
  const std::vector<std::vector<float>> shares = {{0.5F, 1}, {0, 0.25F}};
  const auto light = scatteredLight(points, both, shares, Rgb(1, 0.5, 0), Rgb::Constant(0.1));
  const double sphere = 4 * std::numbers::pi;
  EXPECT_NEAR(light[0], 0.5 / sphere + 0.1, 1e-7);
  EXPECT_NEAR(light[1], 0.5 * (0.25 / sphere + 0.1), 1e-7);
  EXPECT_EQ(light[2], 0);
  EXPECT_NEAR(light[3], (4 + 0.25) / sphere + 0.1, 1e-7);
}

}  // namespace
}  // namespace volute
