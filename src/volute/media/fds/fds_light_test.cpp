// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fds/fds_light.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "volute/base/team_testing.hpp"
#include "volute/fds/fds_share.hpp"

namespace volute {
namespace {

constexpr double kK = 0.4;

/// Even smoke in 10 x 4 x 4 cells of 0.5 m, with a wall across x = 2 .. 2.5 up to z = 0.5.
struct Room {
  Room() {
    SmvIndex index;
    FdsMesh& mesh = index.meshes.emplace_back();
    for (int i = 0; i <= 10; ++i) mesh.planes[0].push_back(0.5 * i);
    for (int i = 0; i <= 4; ++i) mesh.planes[1].push_back(0.5 * i);
    mesh.planes[2] = mesh.planes[1];
    mesh.obstructions.push_back({.nodes = {{4, 0, 0}, {5, 4, 1}}, .colour = {}, .events = {}});
    FdsLattice lattice{.mesh = 0, .planes = mesh.planes};
    auto values = std::make_shared<FdsValues>();
    values->value.assign(lattice.cellCount(), static_cast<float>(kK));
    auto cells = std::make_shared<std::vector<FdsCell>>(lattice.cellCount(), FdsCell::kGas);
    for (int y = 0; y < 4; ++y) (*cells)[lattice.cellAt({4, y, 0})] = FdsCell::kSolid;
    grid = *FdsGrid::create({lattice});
    field =
        std::make_unique<FdsField>(grid, std::vector<std::shared_ptr<const FdsValues>>{values},
                                   std::vector<std::shared_ptr<const std::vector<FdsCell>>>{cells});
    obstructions = std::make_unique<FdsObstructions>(index, 0);
  }

  std::shared_ptr<const FdsGrid> grid;
  std::unique_ptr<FdsField> field;
  std::unique_ptr<FdsObstructions> obstructions;
};

TEST(FdsLight, ComesThroughSmokeAndStopsAtObstructions) {
  const Room room;
  Lamp lamp;
  lamp.position = Vec3(1, 1, 0.25);
  lamp.intensity = Rgb(10, 20, 30);
  const FdsLamps lamps{.light = {.lamps = {lamp}}, .albedo = Rgb(0.5, 1, 1), .density = 2};
  const auto light = fdsLight(*room.field, *room.obstructions, lamps).value();
  const FdsField lit = room.field->withLight(light);
  // A node has the mean of the cells around it.
  const Vec3 node(1, 1, 1.5);
  Rgb expected = Rgb::Zero();
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 middle = node;
    for (int axis = 0; axis < 3; ++axis) middle[axis] += (corner >> axis & 1) != 0 ? 0.25 : -0.25;
    const double distance = (middle - lamp.position).norm();
    expected += lamps.albedo * lamp.intensity * std::exp(-2 * kK * distance) /
                (distance * distance * 4 * std::numbers::pi) / 8;
  }
  const Rgb got = lit.emission(node) / kK;
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(got[c], expected[c], 1e-5 * expected[c]);
  // Behind the wall it is dark, above it not.
  EXPECT_EQ(lit.emission({4, 1, 0.4})[1], 0);
  EXPECT_GT(lit.emission({4, 1, 1.9})[1], 0);
}

TEST(FdsLight, OtherThingsStopItAndAmbientComesEverywhere) {
  const Room room;
  Lamp sun;
  sun.kind = Lamp::Kind::kSun;
  sun.direction = Vec3(0, 0, -1);
  const Blocks half = [](std::span<const Segment> ways, std::span<std::uint8_t> out) {
    for (std::size_t i = 0; i < ways.size(); ++i) out[i] = ways[i].origin.x() > 3;
  };
  const FdsLamps lamps{.light = {.lamps = {sun}, .ambient = Rgb::Constant(0.1), .blocks = half},
                       .albedo = Rgb::Constant(0.5)};
  const FdsField lit =
      room.field->withLight(fdsLight(*room.field, *room.obstructions, lamps).value());
  EXPECT_NEAR(lit.emission({4, 1, 1})[0], kK * 0.5 * 0.1, 1e-7);
  const double above = 0.5 * (std::exp(-kK * 0.75) + std::exp(-kK * 1.25));  // of both layers
  EXPECT_NEAR(lit.emission({1, 1, 1})[0], kK * 0.5 * (0.1 + above / (4 * std::numbers::pi)), 1e-7);
}

TEST(FdsLight, OfManyCellsIsLitInPartsThatMeet) {
  SmvIndex index;
  FdsMesh& mesh = index.meshes.emplace_back();
  constexpr int kCells[3] = {60, 50, 45};  // 135,000: three parts
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i <= kCells[axis]; ++i) mesh.planes[axis].push_back(0.1 * i);
  }
  const FdsLattice lattice{.mesh = 0, .planes = mesh.planes};
  auto values = std::make_shared<FdsValues>();
  values->value.assign(lattice.cellCount(), static_cast<float>(kK));
  const FdsField field(
      *FdsGrid::create({lattice}), {values},
      {std::make_shared<std::vector<FdsCell>>(lattice.cellCount(), FdsCell::kGas)});
  Lamp sun;
  sun.kind = Lamp::Kind::kSun;
  sun.direction = Vec3(0, 0, -1);
  const FdsLamps lamps{.light = {.lamps = {sun}}, .albedo = Rgb::Ones()};
  const FdsField lit = field.withLight(fdsLight(field, FdsObstructions(index, 0), lamps).value());
  for (int z = 1; z < kCells[2]; ++z) {
    for (int y = 1; y < kCells[1]; ++y) {
      const double above = 0.1 * (kCells[2] - z);
      const double expected =
          kK / (4 * std::numbers::pi) * std::exp(-kK * above) * std::cosh(kK * 0.05);
      ASSERT_NEAR(lit.emission({3, 0.1 * y, 0.1 * z})[0], expected, 1e-6) << y << " " << z;
    }
  }
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

TEST(FdsLight, RanksThatHoldAShareEachFindTheLightOfTheWhole) {
  Lamp lamp, sun;
  lamp.position = Vec3(1, 1, 0.3);
  lamp.intensity = Rgb(10, 20, 30);
  sun.kind = Lamp::Kind::kSun;
  sun.direction = Vec3(-1, 0.1, -0.2).normalized();
  sun.intensity = Rgb(1, 1, 1);
  const Illumination both{.lamps = {lamp, sun}};
  const FdsObstructions none(std::vector<FdsBox>{});
  const auto whole =
      fdsLight(threeMeshes(0, 1), none, {.light = both, .albedo = Rgb::Ones()}).value();
  for (const int ranks : {2, 3}) {
    onRanks(ranks, [&](Team& team) {
      const FdsField own = threeMeshes(team.rank(), ranks);
      const auto light =
          fdsLight(own, none, {.light = both, .albedo = Rgb::Ones(), .holders = &team});
      ASSERT_TRUE(light);
      for (std::size_t m = 0; m < 3; ++m) {
        ASSERT_EQ((*light)[m]->size(), own.grid().holds(m) ? whole[m]->size() : 0);
        for (std::size_t i = 0; i < (*light)[m]->size(); ++i)
          EXPECT_NEAR((*(*light)[m])[i], (*whole[m])[i], 1e-6);
      }
    });
  }
}

/// The room's smoke once more, as if it were another medium's.
TEST(FdsLight, PassesThroughOtherMedia) {
  const Room room;
  Lamp lamp;
  lamp.position = Vec3(1, 1, 1.75);
  lamp.intensity = Rgb(10, 20, 30);
  const auto lightOf = [&](double density, std::vector<AnyMedium> others) {
    const FdsLamps lamps{.light = {.lamps = {lamp}, .between = std::move(others)},
                         .albedo = Rgb::Ones(),
                         .density = density};
    return room.field->withLight(fdsLight(*room.field, *room.obstructions, lamps).value());
  };
  const FdsField veiled = lightOf(2, {AnyMedium(*room.field)}), expected = lightOf(3, {});
  for (const Vec3& point : {Vec3(1.5, 1, 1), Vec3(3, 1, 1.5), Vec3(4.5, 0.5, 1)}) {
    const double light = expected.emission(point)[2];
    EXPECT_GT(light, 0);
    EXPECT_NEAR(veiled.emission(point)[2], light, 5e-3 * expected.emission(Vec3(1, 1, 1.5))[2]);
  }
}

}  // namespace
}  // namespace volute
