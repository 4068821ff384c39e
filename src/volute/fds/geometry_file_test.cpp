// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/geometry_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "volute/base/program.hpp"
#include "volute/fds/fds_writer.hpp"

namespace volute {
namespace {

using ::testing::Each;
using ::testing::HasSubstr;
using ::testing::SizeIs;

class GeometryFile : public ::testing::Test {
 protected:
  Result<FdsGeometry> read(const fdswriter::Records& file) {
    file.save(folder_ / "made.ge");
    return readGeometryFile(folder_ / "made.ge");
  }

  ScratchFolder folder_;
};

TEST_F(GeometryFile, HoldsTheTrianglesThatStay) {
  const auto box = read(fdswriter::boxGeometry({1, 2, 0}, {3, 4, 2.5F}, 1));
  ASSERT_TRUE(box) << box.error().message;
  EXPECT_THAT(box->vertices, SizeIs(8));
  EXPECT_THAT(box->triangles, SizeIs(12));
  EXPECT_THAT(box->surfaces, Each(1));
  EXPECT_FALSE(box->moves);
  // Volume by the divergence theorem: positive where all face outwards.
  double volume = 0;
  for (const auto& [a, b, c] : box->triangles) {
    const auto &p = box->vertices[a], &q = box->vertices[b], &r = box->vertices[c];
    volume += (p[0] * (q[1] * r[2] - q[2] * r[1]) + p[1] * (q[2] * r[0] - q[0] * r[2]) +
               p[2] * (q[0] * r[1] - q[1] * r[0])) /
              6;
  }
  EXPECT_NEAR(volume, 2 * 2 * 2.5, 1e-5);
}

TEST_F(GeometryFile, DamageIsToldOrHarmless) {
  const auto file = fdswriter::boxGeometry({0, 0, 0}, {1, 1, 1}, 0);
  const std::size_t whole = file.bytes.size() - (8 + 4) - (8 + 12);  // without what moves
  for (std::size_t size = 0; size < file.bytes.size(); ++size) {
    auto cut = file;
    cut.bytes.resize(size);
    EXPECT_EQ(read(cut).has_value(), size >= whole) << size;
  }
  for (const auto& [begin, end] : file.guarded) {
    for (std::size_t at = begin; at < end; ++at) {
      auto flipped = file;
      flipped.bytes[at] ^= 0x40;
      EXPECT_FALSE(read(flipped)) << at;
    }
  }
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(read(fdswriter::geometryFile({0, 0, kNan}, {1, 1, 1}, {0})).error().message,
              HasSubstr("vertex 1 is at 0, 0, nan"));
  EXPECT_THAT(read(fdswriter::geometryFile({0, 0, 0}, {1, 1, 2}, {0})).error().message,
              HasSubstr("a triangle of vertex 2, where there are 1"));
}

}  // namespace
}  // namespace volute
