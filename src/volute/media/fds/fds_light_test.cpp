// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fds/fds_light.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

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
  const FdsLamps lamps{.lamps = {&lamp, 1}, .albedo = Rgb(0.5, 1, 1), .density = 2};
  const auto light = fdsLight(*room.field, *room.obstructions, lamps);
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
  const FdsLamps lamps{.lamps = {&sun, 1},
                       .ambient = Rgb::Constant(0.1),
                       .albedo = Rgb::Constant(0.5),
                       .blocks = half};
  const FdsField lit = room.field->withLight(fdsLight(*room.field, *room.obstructions, lamps));
  EXPECT_NEAR(lit.emission({4, 1, 1})[0], kK * 0.5 * 0.1, 1e-7);
  const double above = 0.5 * (std::exp(-kK * 0.75) + std::exp(-kK * 1.25));  // of both layers
  EXPECT_NEAR(lit.emission({1, 1, 1})[0], kK * 0.5 * (0.1 + above / (4 * std::numbers::pi)), 1e-7);
}

}  // namespace
}  // namespace volute
