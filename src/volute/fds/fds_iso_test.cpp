// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/fds_iso.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "volute/fds/fds_case_testing.hpp"
#include "volute/medium/medium.hpp"

namespace volute {
namespace {

/// 3D slices of a temperature, at nodes.
FdsField temperatureOf(const ScratchFolder& folder, const fdswriter::Function& value,
                       Indices solid) {
  fdswriter::Index index;
  index.meshes.push_back({kFirst, {solid}, {}});
  const fdswriter::Slice slice{whole(kFirst), "TEMPERATURE", "temp", "C"};
  fdswriter::sliceFile(slice, {{0, fdswriter::atNodes(kFirst, slice.at, value)}})
      .save(folder / "made.sf");
  index.slice(1, slice, "made.sf", false);
  index.save(folder / "made.smv");
  FdsCase read = opened(folder / "made.smv", {.quantity = "TEMPERATURE"});
  return fieldAt(read, 0);
}

TEST(FdsIso, StandsWhereAPlaneHasItsLevel) {
  const ScratchFolder folder;
  const FdsIso iso(
      temperatureOf(folder,
                    [](double x, double y, double z) { return 20 + 100 * x + 50 * y + 30 * z; },
                    {0, 0, 0, 0, 0, 0}),
      {.level = 90, .colour = Rgb(1, 0.5, 0.25), .opacity = 0.4});
  for (const auto& [from, to] : {std::pair(Vec3(0, 0.1, 0.2), Vec3(1, 0.5, 0.4)),
                                 std::pair(Vec3(1, 0.7, 0.1), Vec3(0.05, 0.02, 0.5))}) {
    const Segment line = between(from, to);
    const auto at = iso.crossings(line);
    ASSERT_EQ(at.size(), 1U);
    const Vec3 point = line.origin + at[0] * line.direction;
    EXPECT_NEAR(20 + 100 * point.x() + 50 * point.y() + 30 * point.z(), 90, 1e-4);
    Radiance seen;
    iso.radiance({&line, 1}, {&seen, 1});
    EXPECT_NEAR(seen.transmittance, 0.6, 1e-9);
    // Of a plane with this slope.
    const double up = 30 / std::sqrt(100.0 * 100 + 50 * 50 + 30 * 30);
    EXPECT_NEAR(seen.emitted[0], 0.4 * (0.55 + 0.45 * up), 1e-4);
    EXPECT_NEAR(seen.emitted[2], 0.25 * seen.emitted[0], 1e-12);
    double depth = 0;
    iso.opticalDepth({&line, 1}, {&depth, 1});
    EXPECT_NEAR(depth, -std::log(0.6), 1e-9);
  }
  const Segment along = between({0.05, 0.1, 0.1}, {0.05, 0.7, 0.1});
  EXPECT_TRUE(iso.crossings(along).empty()) << "58 at most";
}

TEST(FdsIso, ALayerIsCrossedTwiceAndSolidsHaveNone) {
  const ScratchFolder folder;
  const auto hump = [](double x, double, double) { return x > 0.35 && x < 0.65 ? 100.0 : 20.0; };
  const FdsIso open(temperatureOf(folder, hump, {0, 0, 0, 0, 0, 0}), {.level = 60});
  const Segment line = between({0, 0.3, 0.2}, {1, 0.3, 0.2});
  const auto at = open.crossings(line);
  ASSERT_EQ(at.size(), 2U);
  EXPECT_NEAR(at[0], 0.3, 1e-5);
  EXPECT_NEAR(at[1], 0.7, 1e-5);
  const ScratchFolder other;
  const FdsIso blocked(temperatureOf(other, hump, {1, 4, 0, 4, 0, 3}), {.level = 60});
  EXPECT_TRUE(blocked.crossings(line).empty()) << "all within a solid";
}

}  // namespace
}  // namespace volute
