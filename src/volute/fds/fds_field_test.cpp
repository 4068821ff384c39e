// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/fds_field.hpp"

#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cmath>
#include <limits>
#include <random>

#include "volute/fds/fds_case_testing.hpp"
#include "volute/medium/conformance.hpp"

namespace volute {
namespace {

FdsLattice lattice(FdsPlanes planes, bool nodal) {
  return {0, std::move(planes), nodal};
}

/// A coarse and stretched mesh, and a finer one at its end on x, with a thin gap to a third.
std::vector<FdsLattice> meshes(bool nodal) {
  return {lattice({{{0, 0.5, 1.0, 2.0}, {0, 1, 1.5, 2}, {-1, 0, 1}}}, nodal),
          lattice({{{2, 2.25, 2.5, 2.75, 3.0}, {0, 0.5, 1, 1.5, 2}, {-1, -0.5, 0, 0.5, 1}}}, nodal),
          lattice({{{3.25, 4}, {0.5, 2}, {-1, 1}}}, nodal)};
}

FdsField fieldOf(std::vector<FdsLattice> lattices,
                 const std::function<double(const Vec3&)>& function, std::uint32_t solidSeed = 0) {
  auto grid = FdsGrid::create(std::move(lattices));
  EXPECT_TRUE(grid);
  std::vector<std::shared_ptr<const FdsValues>> values;
  std::vector<std::shared_ptr<const std::vector<FdsCell>>> cells;
  std::mt19937 random(solidSeed);
  for (const FdsLattice& one : (*grid)->lattices()) {
    auto made = std::make_shared<FdsValues>();
    const auto centre = [&](int axis, std::size_t i) {
      const auto& p = one.planes[axis];
      return one.nodal ? p[i] : 0.5 * (p[i] + p[i + 1]);
    };
    const std::size_t extra = one.nodal ? 1 : 0;
    for (std::size_t z = 0; z < one.cells(2) + extra; ++z) {
      for (std::size_t y = 0; y < one.cells(1) + extra; ++y) {
        for (std::size_t x = 0; x < one.cells(0) + extra; ++x)
          made->value.push_back(
              static_cast<float>(function({centre(0, x), centre(1, y), centre(2, z)})));
      }
    }
    auto states = std::make_shared<std::vector<FdsCell>>(one.cellCount(), FdsCell::kGas);
    for (FdsCell& state : *states) {
      if (solidSeed != 0 && random() % 5 == 0)
        state = FdsCell::kSolid;
    }
    values.push_back(std::move(made));
    cells.push_back(std::move(states));
  }
  return {*grid, std::move(values), std::move(cells)};
}

double linear(const Vec3& p) {
  return 3 + 0.5 * p.x() + 0.25 * p.y() - p.z();
}

FdsDepth checkedDepthOf(const FdsField& field, const Segment& segment) {
  const FdsDepth depth = depthOf(field, segment);
  double value = 0;
  field.opticalDepth({&segment, 1}, {&value, 1});
  EXPECT_EQ(value, depth.value);
  return depth;
}

conformance::MediumUnderTest underTest(bool nodal) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(0, 2);
  const FdsField field = fieldOf(meshes(nodal), [&](const Vec3&) { return uniform(random); }, 3);
  conformance::Traits traits;
  for (const FdsLattice& one : field.grid().lattices()) {
    for (int axis = 0; axis < 3; ++axis) {
      auto& planes = traits.planes[axis];
      planes.insert(planes.end(), one.planes[axis].begin(), one.planes[axis].end());
    }
  }
  for (auto& planes : traits.planes) {
    std::sort(planes.begin(), planes.end());
    planes.erase(std::unique(planes.begin(), planes.end()), planes.end());
  }
  // The adaptive Simpson of the suite steps over corners of cells, where solids end.
  traits.tolerance.quadrature = 5e-3;
  return conformance::underTest(field.withSource({0.5, 1, 2}), traits);
}

VOLUTE_CONFORMANCE(FdsCells, underTest(false));
VOLUTE_CONFORMANCE(FdsNodes, underTest(true));

TEST(FdsField, manyLinesAtOnceEqualOneAfterTheOther) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> uniform(0, 2);
  std::vector<Segment> lines;
  const auto point = [&] {
    return Vec3(-0.5 + 2.5 * uniform(random), 1.3 * uniform(random), uniform(random) - 1);
  };
  for (int i = 0; i < 300; ++i) lines.push_back(between(point(), point()));
  // Along planes and edges, through corners, and of no length.
  lines.push_back(between({0, 1, 0}, {4, 1, 0}));
  lines.push_back(between({4, 1.5, 0}, {0, 1.5, 0}));
  lines.push_back(between({3, 2, 1}, {2, 0, -1}));
  lines.push_back(between({0, 0, -1}, {2, 2, 1}));
  lines.push_back(between({2, 1, -1}, {2, 1, 1}));
  lines.push_back({Vec3(1, 1, 0), Vec3::UnitX(), 0.5, 0.5});
  lines.push_back({Vec3(9, 9, 9), Vec3::UnitX(), 0, 1});
  for (const bool nodal : {false, true}) {
    const FdsField field = fieldOf(meshes(nodal), [&](const Vec3&) { return uniform(random); }, 3);
    std::vector<double> expected(lines.size());
    std::vector<FdsDepth> bands(lines.size());
    field.opticalDepthReference(lines, expected);
    field.depthsReference(lines, bands);
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
      hwy::SetSupportedTargetsForTest(target);
      hwy::GetChosenTarget().Update(hwy::SupportedTargets());
      SCOPED_TRACE(hwy::TargetName(target));
      std::vector<double> depths(lines.size());
      std::vector<FdsDepth> found(lines.size());
      field.opticalDepth(lines, depths);
      field.depths(lines, found);
      for (std::size_t i = 0; i < lines.size(); ++i) {
        EXPECT_NEAR(depths[i], expected[i], 1e-12 * (1 + expected[i])) << i;
        EXPECT_EQ(found[i].value, depths[i]);
        EXPECT_EQ(found[i].high, depths[i]);
        EXPECT_NEAR(found[i].uncovered, bands[i].uncovered, 1e-12) << i;
        EXPECT_NEAR(found[i].insideSolids, bands[i].insideSolids, 1e-12) << i;
      }
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  }
}

TEST(FdsField, boundsOfManyLinesAtOnceEqualOneAfterTheOther) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> uniform(0, 2);
  std::vector<Segment> lines;
  const auto point = [&] {
    return Vec3(-0.5 + 2.5 * uniform(random), 1.3 * uniform(random), uniform(random) - 1);
  };
  for (int i = 0; i < 300; ++i) lines.push_back(between(point(), point()));
  lines.push_back(between({0, 1, 0}, {4, 1, 0}));
  for (const bool nodal : {false, true}) {
    const FdsField exact = fieldOf(meshes(nodal), [&](const Vec3&) { return uniform(random); }, 3);
    std::vector<std::shared_ptr<const FdsValues>> values;
    std::vector<std::shared_ptr<const std::vector<FdsCell>>> cells;
    for (std::size_t i = 0; i < exact.grid().lattices().size(); ++i) {
      auto banded = std::make_shared<FdsValues>(exact.values(i));
      for (const float value : banded->value) {
        banded->low.push_back(0.7F * value);
        // A byte at its end now and then.
        banded->high.push_back(random() % 60 == 0 ? std::numeric_limits<float>::infinity()
                                                  : 1.4F * value);
      }
      values.push_back(std::move(banded));
      cells.push_back(std::make_shared<std::vector<FdsCell>>(exact.cells(i)));
    }
    const FdsField field(std::make_shared<FdsGrid>(exact.grid()), values, cells);
    std::vector<FdsDepth> expected(lines.size()), got(lines.size());
    field.depthsReference(lines, expected);
    field.depths(lines, got);
    int infinite = 0;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      EXPECT_NEAR(got[i].value, expected[i].value, 1e-12 * (1 + expected[i].value)) << i;
      EXPECT_NEAR(got[i].low, expected[i].low, 1e-12 * (1 + expected[i].low)) << i;
      infinite += std::isinf(expected[i].high);
      if (std::isinf(expected[i].high)) {
        EXPECT_TRUE(std::isinf(got[i].high)) << i;
      } else {
        EXPECT_NEAR(got[i].high, expected[i].high, 1e-12 * (1 + expected[i].high)) << i;
      }
      EXPECT_NEAR(got[i].uncovered, expected[i].uncovered, 1e-12) << i;
    }
    EXPECT_GT(infinite, 5);  // some, not all
    EXPECT_LT(infinite, 280);
  }
}

TEST(FdsField, nodesAreTrilinearWithoutSeamsAcrossMeshesOfOtherCells) {
  auto lattices = meshes(true);
  lattices.pop_back();
  const FdsField field = fieldOf(lattices, linear);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> x(0, 3), y(0, 2), z(-1, 1);
  for (int i = 0; i < 200; ++i) {
    const Vec3 a(x(random), y(random), z(random));
    const Vec3 b(x(random), y(random), z(random));
    const Segment segment = between(a, b);
    const double expected = 0.5 * (linear(a) + linear(b)) * segment.end;
    const FdsDepth depth = checkedDepthOf(field, segment);
    EXPECT_NEAR(depth.value, expected, 1e-6 * expected);
    EXPECT_EQ(depth.low, depth.value);
    EXPECT_EQ(depth.high, depth.value);
    EXPECT_LT(depth.uncovered, 1e-12);
    EXPECT_NEAR(field.extinction(a), linear(a), 1e-6);
  }
}

TEST(FdsField, facesBetweenMeshesCountOnce) {
  auto lattices = meshes(false);
  lattices.pop_back();
  const FdsField field = fieldOf(lattices, [](const Vec3&) { return 1.0; });
  // Along x, in the face between the meshes, along edges, the other way.
  EXPECT_NEAR(checkedDepthOf(field, between({0, 1, 0}, {3, 1, 0})).value, 3, 1e-12);
  EXPECT_NEAR(checkedDepthOf(field, between({3, 1, 0}, {0, 1, 0})).value, 3, 1e-12);
  EXPECT_NEAR(checkedDepthOf(field, between({2, 0, 0.25}, {2, 2, 0.25})).value, 2, 1e-12);
  EXPECT_NEAR(checkedDepthOf(field, between({3, 0, 0.25}, {3, 2, 0.25})).value, 2, 1e-12);
  EXPECT_NEAR(checkedDepthOf(field, between({0, 0, -1}, {3, 2, 1})).value, Vec3(3, 2, 2).norm(),
              1e-12);
}

TEST(FdsField, planesThatFiveDecimalsMoveApartAreOne) {
  for (const double shift : {-9e-6, 9e-6}) {
    const FdsField field =
        fieldOf({lattice({{{0, 0.5, 1}, {0, 1}, {0, 1}}}, false),
                 lattice({{{1 + shift, 1.5, 2}, {shift, 1}, {0, 1 - shift}}}, false)},
                [](const Vec3&) { return 1.0; });
    const FdsDepth depth = checkedDepthOf(field, between({0, 0.5, 0.5}, {2, 0.5, 0.5}));
    EXPECT_NEAR(depth.value, 2, 1e-12);
    EXPECT_EQ(depth.uncovered, 0);
  }
}

TEST(FdsField, whereMeshesOverlapTheFinestCounts) {
  const FdsField field = fieldOf({lattice({{{0, 1, 2}, {0, 1}, {0, 1}}}, false),
                                  lattice({{{0.5, 0.75, 1, 1.25, 1.5}, {0, 1}, {0, 1}}}, false)},
                                 [](const Vec3& p) {
                                   // Centres of the coarse cells are at 0.5 and 1.5.
                                   return p.x() == 0.5 || p.x() == 1.5 ? 1.0 : 10.0;
                                 });
  EXPECT_NEAR(checkedDepthOf(field, between({0, 0.5, 0.5}, {2, 0.5, 0.5})).value, 11, 1e-12);
}

TEST(FdsField, gapsAndTheOutsideAreNotCovered) {
  const FdsField field = fieldOf(meshes(false), [](const Vec3&) { return 2.0; });
  const FdsDepth depth = checkedDepthOf(field, between({-1, 1, 0.5}, {5, 1, 0.5}));
  EXPECT_NEAR(depth.value, 2 * 3.75, 1e-12);
  EXPECT_NEAR(depth.uncovered, 1 + 0.25 + 1, 1e-12);
  EXPECT_EQ(checkedDepthOf(field, between({-1, -1, 0}, {5, -1, 0})).uncovered, 6);
  EXPECT_FALSE(field.cellAt({3.1, 1, 0}));
  EXPECT_EQ(field.cellAt({3.3, 1, 0}), FdsCell::kGas);
}

}  // namespace
}  // namespace volute
