// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/support.hpp"

#include <gtest/gtest.h>

#include <random>

namespace volute {
namespace {

/// touchedPart() cell by cell.
TouchedPart walked(const Support& support, const Segment& segment) {
  TouchedPart found;
  traverseCells(support.cells(), support.range(), segment,
                [&](const std::array<int, 3>& cell, double begin, double end) {
                  if (!support.touches(cell))
                    return;
                  if (found.empty()) {
                    found.part.begin = begin;
                    found.firstCell = cell;
                  }
                  found.part.end = end;
                });
  return found;
}

class SparseSupport : public testing::TestWithParam<Basis> {};

TEST_P(SparseSupport, IsFoundByLeapsAsByWalking) {
  const VolumeGeometry geometry{{Vec3(-1, -2, 0), Vec3(3, 2, 5)}, {31, 40, 23}};
  std::mt19937 random(5);
  std::uniform_real_distribution<double> share(0, 1);
  for (const double density : {0.0002, 0.002, 0.05}) {
    std::vector<std::uint8_t> hull(geometry.voxels());
    for (auto& voxel : hull) voxel = share(random) < density ? 1 : 0;
    hull[0] = hull.back() = 1;  // a box as large as the volume
    const Support support(geometry, GetParam(), hull);
    int met = 0;
    for (int i = 0; i < 4000; ++i) {
      const auto inside = [&] {
        const Vec3 at(share(random), share(random), share(random));
        return Vec3(geometry.bounds.min + at.cwiseProduct(geometry.bounds.size()));
      };
      const Vec3 from = 3 * inside(), to = inside();
      Vec3 direction = (to - from).normalized();
      if (i % 8 == 0)
        direction = Vec3::Unit(i / 8 % 3);  // along an axis
      const Segment segment{i % 8 == 0 ? Vec3(to - 20 * direction) : from, direction, 0, 60};
      const TouchedPart expected = walked(support, segment), got = touchedPart(support, segment);
      ASSERT_EQ(got.empty(), expected.empty()) << i;
      if (expected.empty())
        continue;
      ++met;
      EXPECT_NEAR(got.part.begin, expected.part.begin, 1e-9) << i;
      EXPECT_NEAR(got.part.end, expected.part.end, 1e-9) << i;
      EXPECT_EQ(got.firstCell, expected.firstCell) << i;
    }
    EXPECT_GT(met, 20);
  }
}

INSTANTIATE_TEST_SUITE_P(Bases, SparseSupport, testing::Values(Basis::kBox, Basis::kTrilinear),
                         [](const auto& info) {
                           return info.param == Basis::kBox ? "Box" : "Trilinear";
                         });

}  // namespace
}  // namespace volute
