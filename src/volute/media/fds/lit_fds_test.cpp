// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fds/lit_fds.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "volute/base/team_testing.hpp"
#include "volute/fds/fds_share.hpp"
#include "volute/fds/obstructions.hpp"
#include "volute/media/light_blockers.hpp"
#include "volute/medium/integrate.hpp"

namespace volute {
namespace {

constexpr double kK = 0.4;

/// Smoke in 10 x 4 x 4 cells of 0.5 m, with a wall across x = 2 .. 2.5 up to z = 0.5.
struct Room {
  explicit Room(bool even = true) {
    SmvIndex index;
    FdsMesh& mesh = index.meshes.emplace_back();
    for (int i = 0; i <= 10; ++i) mesh.planes[0].push_back(0.5 * i);
    for (int i = 0; i <= 4; ++i) mesh.planes[1].push_back(0.5 * i);
    mesh.planes[2] = mesh.planes[1];
    FdsLattice lattice{.mesh = 0, .planes = mesh.planes, .nodal = !even};
    auto values = std::make_shared<FdsValues>();
    for (std::size_t i = 0; i < lattice.valueCount(); ++i) {
      const std::size_t x = i % 11, y = i / 11 % 5, z = i / 55;  // of nodes
      const double wave = std::sin(0.8 * static_cast<double>(x) + 0.5 * static_cast<double>(y)) *
                          std::cos(0.6 * static_cast<double>(z));
      values->value.push_back(static_cast<float>(even ? kK : kK * (1 + 0.9 * wave)));
    }
    auto cells = std::make_shared<std::vector<FdsCell>>(lattice.cellCount(), FdsCell::kGas);
    for (int y = 0; y < 4; ++y) (*cells)[lattice.cellAt({4, y, 0})] = FdsCell::kSolid;
    field = std::make_unique<FdsField>(
        *FdsGrid::create({lattice}), std::vector<std::shared_ptr<const FdsValues>>{values},
        std::vector<std::shared_ptr<const std::vector<FdsCell>>>{cells});
    std::vector<Triangle> faces;
    const auto addQuad = [&](const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
      faces.push_back({{a, b, c}}), faces.push_back({{a, c, d}});
    };
    for (const double x : {2.0, 2.5}) addQuad({x, 0, 0}, {x, 2, 0}, {x, 2, 0.5}, {x, 0, 0.5});
    addQuad({2, 0, 0.5}, {2.5, 0, 0.5}, {2.5, 2, 0.5}, {2, 2, 0.5});
    surfaces = TriangleScene::build(std::move(faces)).value();
  }

  std::unique_ptr<FdsField> field;
  TriangleScene surfaces;
};

Lamp spotAt(const Vec3& place) {
  Lamp lamp;
  lamp.position = place;
  lamp.intensity = Rgb(10, 20, 30);
  return lamp;
}

/// Along a ray, from each of many places a ray to each lamp.
Rgb byBruteForce(const FdsField& field, const FdsLamps& lamps, const Segment& ray) {
  constexpr int kSteps = 4000;
  Rgb sum = Rgb::Zero();
  double passed = 1;
  const auto depthOf = [](const auto& medium, const Segment& way) {
    double depth = 0;
    medium.opticalDepth({&way, 1}, {&depth, 1});
    return depth;
  };
  for (int k = 0; k < kSteps; ++k) {
    Segment step = ray;
    step.begin = ray.begin + (ray.end - ray.begin) * k / kSteps;
    step.end = ray.begin + (ray.end - ray.begin) * (k + 1) / kSteps;
    const double depth = depthOf(field, step);
    Rgb light = lamps.light.ambient;
    for (const Lamp& lamp : lamps.light.lamps) {
      const Segment way = lamp.towards(ray.at(0.5 * (step.begin + step.end)));
      std::uint8_t blocked = 0;
      lamps.surfaces.occluded({&way, 1}, {&blocked, 1});
      double between = lamps.density * depthOf(field, way);
      for (const AnyMedium& other : lamps.light.between) between += depthOf(other, way);
      if (!blocked)
        light += std::exp(-between) / (4 * std::numbers::pi) * lamp.irradiance(way.origin);
    }
    sum += passed * -std::expm1(-depth) * lamps.albedo * light;
    passed *= std::exp(-depth);
  }
  return sum;
}

std::vector<Segment> raysThrough() {
  std::vector<Segment> rays;
  for (int i = 0; i < 24; ++i) {
    const Vec3 from(0.02, 0.3 + 0.06 * i, 0.2 + 0.07 * i), to(4.95, 1.9 - 0.07 * i, 1.7 - 0.06 * i);
    rays.push_back({from, (to - from).normalized(), 0, (to - from).norm()});
  }
  return rays;
}

/// Within 5e-3 of the brightest, by its pieces and by its steps.
void expectBruteForce(const FdsField& field, const FdsLamps& lamps) {
  const LitMedium lit = litFds(field, lamps);
  const auto rays = raysThrough();
  std::vector<Radiance> fast(rays.size()), exact(rays.size());
  lit.radiance(rays, fast);
  radianceByPieces(lit, rays, exact);
  std::vector<Rgb> expected;
  double brightest = 0;
  for (const Segment& ray : rays) {
    expected.push_back(byBruteForce(field, lamps, ray));
    brightest = std::max(brightest, expected.back().maxCoeff());
  }
  EXPECT_GT(brightest, 0.05);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    EXPECT_LE((fast[i].emitted - expected[i]).abs().maxCoeff(), 5e-3 * brightest) << i;
    EXPECT_LE((exact[i].emitted - expected[i]).abs().maxCoeff(), 5e-3 * brightest) << i;
  }
}

TEST(LitFds, ComesThroughSmokeAndStopsSharplyAtSurfaces) {
  for (const bool even : {true, false}) {
    const Room room(even);
    Lamp narrow = spotAt({1, 1, 1.9});
    narrow.coneCosine = 0.9, narrow.direction = Vec3(1, 0, -1).normalized();
    expectBruteForce(*room.field, {.light = {.lamps = {spotAt({1, 1, 0.25}), narrow}},
                                   .surfaces = room.surfaces,
                                   .albedo = Rgb(0.5, 1, 1),
                                   .density = 2});
  }
}

TEST(LitFds, SunAndLightFromEverywhere) {
  const Room room(false);
  Lamp sun;
  sun.kind = Lamp::Kind::kSun;
  sun.direction = Vec3(0.6, 0, -1).normalized();
  expectBruteForce(*room.field, {.light = {.lamps = {sun}, .ambient = Rgb::Constant(0.1)},
                                 .surfaces = room.surfaces,
                                 .albedo = Rgb::Constant(0.5)});
}

/// The room's smoke once more, as if it were another medium's.
TEST(LitFds, PassesThroughOtherMedia) {
  const Room room(false);
  expectBruteForce(*room.field,
                   {.light = {.lamps = {spotAt({1, 1, 1.75})}, .between = {AnyMedium(*room.field)}},
                    .albedo = Rgb::Ones(),
                    .density = 2});
}

/// Three meshes side by side along x, of cells of 0.5 m; those of a share have values.
FdsField threeMeshes(int share, int shares) {
  SmvIndex index;
  std::vector<FdsLattice> lattices;
  for (int m = 0; m < 3; ++m) {
    FdsMesh& mesh = index.meshes.emplace_back();
    for (int i = 0; i <= 4; ++i) mesh.planes[0].push_back(2.0 * m + 0.5 * i);
    for (int i = 0; i <= 4; ++i) mesh.planes[1].push_back(0.5 * i);
    mesh.planes[2] = mesh.planes[1];
    lattices.push_back({.mesh = m, .planes = mesh.planes});
  }
  const auto held = meshesOfShare(index, {share, shares}).value();
  std::vector<std::shared_ptr<const FdsValues>> values;
  std::vector<std::shared_ptr<const std::vector<FdsCell>>> cells;
  for (std::size_t m = 0; m < 3; ++m) {
    FdsValues own;
    for (std::size_t i = 0; held[m] && i < lattices[m].cellCount(); ++i)
      own.value.push_back(0.1F * static_cast<float>((7 * i + m) % 5));
    cells.push_back(std::make_shared<const std::vector<FdsCell>>(own.value.size(), FdsCell::kGas));
    values.push_back(std::make_shared<const FdsValues>(std::move(own)));
  }
  const auto grid = FdsGrid::create(std::move(lattices), held).value();
  return {grid, std::move(values), std::move(cells)};
}

TEST(LitFds, RanksThatHoldAShareEachFindTheLightOfTheWhole) {
  Lamp sun;
  sun.kind = Lamp::Kind::kSun;
  sun.direction = Vec3(-1, 0.1, -0.2).normalized();
  sun.intensity = Rgb(1, 1, 1);
  const Illumination both{.lamps = {spotAt({1, 1, 0.3}), sun}};
  const LitMedium whole = litFds(threeMeshes(0, 1), {.light = both, .albedo = Rgb::Ones()});
  for (const int ranks : {2, 3}) {
    onRanks(ranks, [&](Team& team) {
      const FdsField own = threeMeshes(team.rank(), ranks);
      const LitMedium lit = litFds(own, {.light = both, .albedo = Rgb::Ones(), .team = &team});
      for (int i = 0; i < 500; ++i) {
        const Vec3 point(6 * (i * 0.618 - std::floor(i * 0.618)), 2 * (i % 23 / 23.0),
                         2 * (i % 31 / 31.0));
        for (std::size_t lamp = 0; lamp < 2; ++lamp) {
          EXPECT_NEAR(lit.fields()[lamp].at(point).share, whole.fields()[lamp].at(point).share,
                      1e-6);
        }
      }
    });
  }
}

}  // namespace
}  // namespace volute
