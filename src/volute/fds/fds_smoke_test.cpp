// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <random>

#include "volute/fds/fds_case_testing.hpp"

// Smoke in bytes and words: what they stand for.

namespace volute {
namespace {

/// Cells of a mesh as FDS holds them for its averages, a ring of cells outside included.
struct Cells {
  Planes planes;
  std::array<int, 3> count;
  std::vector<double> value;  // count + 2 on each axis
  std::vector<bool> gas;

  explicit Cells(const Planes& of) : planes(of), count(cellsOf(of)) {
    value.assign(static_cast<std::size_t>(count[0] + 2) * (count[1] + 2) * (count[2] + 2), 0);
    gas.assign(value.size(), false);
  }

  /// i, j, k from 0 (outside) to count + 1 (outside).
  std::size_t at(int i, int j, int k) const {
    return (static_cast<std::size_t>(k) * (count[1] + 2) + j) * (count[0] + 2) + i;
  }

  template <class Body>
  void each(Body&& body) const {
    for (int k = 1; k <= count[2]; ++k) {
      for (int j = 1; j <= count[1]; ++j) {
        for (int i = 1; i <= count[0]; ++i) body(i, j, k);
      }
    }
  }

  /// Mean over the eight cells round a node, or over those of gas.
  std::vector<double> nodes(bool gasOnly) const {
    std::vector<double> out;
    for (int k = 0; k <= count[2]; ++k) {
      for (int j = 0; j <= count[1]; ++j) {
        for (int i = 0; i <= count[0]; ++i) {
          double sum = 0;
          int cells = 0;
          for (int corner = 0; corner < 8; ++corner) {
            const std::size_t c = at(i + (corner & 1), j + ((corner >> 1) & 1), k + (corner >> 2));
            sum += gas[c] ? value[c] : 0;
            cells += gas[c];
          }
          out.push_back(gasOnly ? (cells > 0 ? sum / cells : 0) : sum / 8);
        }
      }
    }
    return out;
  }
};

/// Random smoke of up to `most` [1/m] with a block of solid cells (nodes `solid`) in it.
Cells randomCells(const Planes& planes, const Indices& solid, double most, std::uint32_t seed) {
  Cells cells(planes);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0, most);
  cells.each([&](int i, int j, int k) {
    const bool filled = i > solid.i1 && i <= solid.i2 && j > solid.j1 && j <= solid.j2 &&
                        k > solid.k1 && k <= solid.k2;
    cells.gas[cells.at(i, j, k)] = !filled;
    cells.value[cells.at(i, j, k)] = uniform(random);
  });
  return cells;
}

std::vector<std::uint8_t> opacityBytes(const std::vector<double>& k, double dx) {
  std::vector<std::uint8_t> bytes;
  for (const double one : k)
    bytes.push_back(static_cast<std::uint8_t>(std::lround(254 * (1 - std::exp(-one * dx)))));
  return bytes;
}

double mostOpaque(const std::vector<double>& k, double dx) {
  double most = 0;
  for (const double one : k) most = std::max(most, 254 * (1 - std::exp(-one * dx)));
  return most;
}

constexpr double kKm = 8700;

/// One mesh with random smoke in 8 or 16 bits, as the three generations and .s16 write it.
enum class Writing { kOpacity, kOpacityAndDensity, kDensity, kWords };

void saveSmoke(const ScratchFolder& folder, const Cells& cells, const Indices& solid,
               Writing writing) {
  const auto count = cellsOf(cells.planes);
  const auto k = cells.nodes(false);
  const std::vector<double> clear(k.size(), 0.0);
  const double dx = cells.planes[0][1] - cells.planes[0][0];
  fdswriter::Index index;
  index.meshes.push_back({cells.planes, {solid}, {}});
  index.smoke(1, "made_1_1.s3d", kKm);
  index.save(folder / "made.smv");
  std::vector<double> density;
  for (const double one : k) density.push_back(one / kKm);
  const double densest = *std::max_element(density.begin(), density.end());
  std::vector<std::uint8_t> densityBytes;
  const bool rounded = writing == Writing::kOpacityAndDensity;  // by FDS, else cut off here
  for (const double one : density)
    densityBytes.push_back(static_cast<std::uint8_t>(254 * one / densest + (rounded ? 0.5 : 0)));
  const std::vector<std::uint8_t> zeros(k.size(), 0);
  const auto opacity = opacityBytes(k, dx);
  const auto& bytes = writing == Writing::kDensity ? densityBytes : opacity;
  fdswriter::smokeFile(count, {{0, zeros}, {5, bytes}}).save(folder / "made_1_1.s3d");
  const double most = mostOpaque(k, dx);
  std::string sizes = "           0\n";
  for (const double time : {0.0, 5.0}) {
    sizes += fmt::format(" {} {} 10", time, k.size());
    const double share = time == 0 ? 0 : 1;
    switch (writing) {
      case Writing::kOpacity:
        sizes += fmt::format(" {}", share * most);
        break;
      case Writing::kOpacityAndDensity:
        sizes += fmt::format(" {} 10 {}", share * most, share * densest);
        break;
      case Writing::kDensity:
        sizes += fmt::format(" {}", share * densest);
        break;
      case Writing::kWords:
        sizes += fmt::format(" {} 10", share * most);
        break;
    }
    sizes += "\n";
  }
  fdswriter::saveText(folder / "made_1_1.s3d.sz", sizes);
  if (writing == Writing::kOpacityAndDensity)
    fdswriter::smokeFile(count, {{0, zeros}, {5, densityBytes}}).save(folder / "made_1_1.s3dd");
  if (writing == Writing::kWords)
    fdswriter::smoke16File(count, {{0, clear}, {5, density}}).save(folder / "made_1_1.s16");
}

/// The same smoke without bytes: exact at the nodes.
FdsField exactField(const FdsField& like, const std::vector<double>& k) {
  auto values = std::make_shared<FdsValues>();
  values->value.assign(k.begin(), k.end());
  auto cells = std::make_shared<const std::vector<FdsCell>>(like.cells(0));
  auto grid = FdsGrid::create({like.grid().lattices().begin(), like.grid().lattices().end()});
  return {*grid, {values}, {cells}};
}

RC_GTEST_PROP(FdsSmoke, theTrueDepthLiesWithinTheBand, ()) {
  const auto seed = *rc::gen::arbitrary<std::uint32_t>();
  const auto writing = *rc::gen::element(Writing::kOpacity, Writing::kOpacityAndDensity,
                                         Writing::kDensity, Writing::kWords);
  const double most = *rc::gen::element(0.3, 3.0, 20.0);
  const Planes& planes = *rc::gen::arbitrary<bool>() ? kFirst : kSecond;
  const Indices solid{1, 3, 1, 3, 0, 2};
  const ScratchFolder folder;
  const Cells cells = randomCells(planes, solid, most, seed);
  saveSmoke(folder, cells, solid, writing);
  FdsCase read = opened(folder / "made.smv");
  RC_ASSERT(read.source().name == (writing == Writing::kWords               ? "s16"
                                   : writing == Writing::kOpacityAndDensity ? "s3dd"
                                                                            : "s3d"));
  const FdsField field = fieldAt(read, 5);
  const FdsField truth = exactField(field, cells.nodes(true));
  std::mt19937 random(seed);
  const Box3 bounds = field.bounds();
  const auto point = [&] {
    std::uniform_real_distribution<double> uniform(0, 1);
    const Vec3 share(uniform(random), uniform(random), uniform(random));
    return Vec3(bounds.min + share.cwiseProduct(bounds.size()));
  };
  for (int i = 0; i < 50; ++i) {
    const Segment line = between(point(), point());
    const FdsDepth depth = depthOf(field, line);
    double expected = 0;
    truth.opticalDepth({&line, 1}, {&expected, 1});
    RC_ASSERT(depth.low <= depth.value);
    RC_ASSERT(depth.value <= depth.high);
    RC_ASSERT(depth.low <= expected * (1 + 1e-6));
    RC_ASSERT(depth.high >= expected * (1 - 1e-6));
  }
}

TEST(FdsSmoke, clearAirInWordsIsClear) {
  const ScratchFolder folder;
  const Indices solid{1, 3, 1, 3, 0, 2};
  saveSmoke(folder, randomCells(kFirst, solid, 3, 5), solid, Writing::kWords);
  FdsCase read = opened(folder / "made.smv");
  const FdsDepth depth = depthOf(fieldAt(read, 0), between({0.1, 0.1, 0.5}, {0.9, 0.1, 0.5}));
  EXPECT_EQ(depth.value, 0);
  EXPECT_EQ(depth.high, 0);
}

TEST(FdsSmoke, aSignOnAWallIsSeenThroughTheSmokeThatIsThere) {
  // Even smoke: FDS's means at the wall are a half, at its edges a quarter of it.
  const ScratchFolder folder;
  const Indices wall{2, 3, 0, 4, 0, 3};
  Cells cells(kFirst);
  cells.each([&](int i, int j, int k) {
    cells.gas[cells.at(i, j, k)] = i != 3;
    cells.value[cells.at(i, j, k)] = 2;
  });
  saveSmoke(folder, cells, wall, Writing::kOpacity);
  FdsCase read = opened(folder / "made.smv");
  const FdsField field = fieldAt(read, 5);
  // On the wall, from its surface to the corner of the room.
  const Segment line = between({0.4, 0.4, 0.3}, {0, 0, 0});
  const FdsDepth depth = depthOf(field, line);
  EXPECT_NEAR(depth.value, 2 * line.end, 0.05 * 2 * line.end);
  EXPECT_LE(depth.low, 2 * line.end);
  EXPECT_GE(depth.high, 2 * line.end);
  EXPECT_EQ(field.extinction({0.5, 0.4, 0.3}), 0);
  EXPECT_EQ(field.cellAt({0.5, 0.4, 0.3}), FdsCell::kSolid);
}

TEST(FdsSmoke, aSignOnAWallIsSeenAsTheFloatSliceSeesIt) {
  // Uneven smoke, both ways in one case: bytes that FDS averaged over walls too, and its slice at
  // nodes, which is the mean of the gas.
  const ScratchFolder folder;
  const Indices wall{2, 3, 0, 4, 0, 3};
  const Cells cells = randomCells(kFirst, wall, 4, 7);
  saveSmoke(folder, cells, wall, Writing::kOpacity);
  fdswriter::Index index;
  index.meshes.push_back({kFirst, {wall}, {}});
  index.smoke(1, "made_1_1.s3d", kKm);
  const fdswriter::Slice slice{whole(kFirst)};
  const auto k = cells.nodes(true);
  fdswriter::sliceFile(slice, {{0, std::vector<float>(k.size(), 0)}, {5, {k.begin(), k.end()}}})
      .save(folder / "made.sf");
  index.slice(1, slice, "made.sf", false);
  index.save(folder / "made.smv");
  FdsCase floats = opened(folder / "made.smv");
  FdsCase bytes = opened(folder / "made.smv", {.source = "s3d"});
  ASSERT_EQ(floats.source().name, "slice3d-extinction");
  const FdsField exact = fieldAt(floats, 5);
  const FdsField rounded = fieldAt(bytes, 5);
  for (const Vec3& eye : {Vec3(0, 0, 0), Vec3(0.1, 0.7, 0.5), Vec3(0.4, 0.1, 0.1)}) {
    const Segment line = between(eye, {0.4, 0.4, 0.3});  // the last one slides along the wall
    const double expected = depthOf(exact, line).value;
    const FdsDepth depth = depthOf(rounded, line);
    EXPECT_NEAR(depth.value, expected, 0.03 * expected) << eye;
    EXPECT_LE(depth.low, expected * (1 + 1e-6)) << eye;
    EXPECT_GE(depth.high, expected * (1 - 1e-6)) << eye;
  }
}

TEST(FdsSmoke, theLastByteSaysAtLeast) {
  const ScratchFolder folder;
  const Cells cells = [] {
    Cells thick(kFirst);
    thick.each([&](int i, int j, int k) {
      thick.gas[thick.at(i, j, k)] = true;
      thick.value[thick.at(i, j, k)] = 1000;
    });
    return thick;
  }();
  saveSmoke(folder, cells, {0, 0, 0, 0, 0, 0}, Writing::kOpacity);
  FdsCase read = opened(folder / "made.smv");
  const FdsDepth depth = depthOf(fieldAt(read, 5), between({0.1, 0.1, 0.1}, {0.9, 0.7, 0.5}));
  EXPECT_TRUE(std::isinf(depth.high));
  EXPECT_TRUE(std::isfinite(depth.value));
  EXPECT_GT(depth.low, 0);
}

TEST(FdsSmoke, theCellOfItsOwnMeshScalesAByte) {
  // The same byte in meshes with cells of 0.1 and 0.2 m means twice the extinction.
  const ScratchFolder folder;
  const Planes fine{{{0, 0.1, 0.2}, {0, 0.2, 0.4}, {0, 0.2, 0.4}}};
  const Planes coarse{{{0.2, 0.4, 0.6}, {0, 0.2, 0.4}, {0, 0.2, 0.4}}};
  fdswriter::Index index;
  int number = 0;
  for (const Planes& planes : {fine, coarse}) {
    index.meshes.push_back({planes, {}, {}});
    const std::string name = fmt::format("s_{}.s3d", ++number);
    fdswriter::smokeFile(
        {2, 2, 2}, {{0, std::vector<std::uint8_t>(27, 0)}, {1, std::vector<std::uint8_t>(27, 40)}})
        .save(folder / name);
    fdswriter::saveText(folder / (name + ".sz"), "0\n 0 27 3 0.0\n 1 27 3 40.2\n");
    index.smoke(number, name, kKm);
  }
  index.save(folder / "made.smv");
  FdsCase read = opened(folder / "made.smv");
  const FdsField field = fieldAt(read, 1);
  EXPECT_NEAR(field.extinction({0.1, 0.2, 0.2}), -std::log1p(-40 / 254.0) / 0.1, 1e-5);
  EXPECT_NEAR(field.extinction({0.4, 0.2, 0.2}), -std::log1p(-40 / 254.0) / 0.2, 1e-5);
}

TEST(FdsSmoke, smokeThatWasThereFromTheFirstIsNotDividedByWalls) {
  // FDS keeps the value of the first stored time in cells outside, but for those across edges.
  MadeCase made;
  made.index.smoke(1, "s.s3d", kKm);
  made.index.save(made.folder / "made.smv");
  const auto count = cellsOf(kFirst);
  std::vector<double> k;
  for (int z = 0; z <= count[2]; ++z) {
    for (int y = 0; y <= count[1]; ++y) {
      for (int x = 0; x <= count[0]; ++x) {
        const int edges =
            (x == 0 || x == count[0]) + (y == 0 || y == count[1]) + (z == 0 || z == count[2]);
        k.push_back(2.0 * (edges == 3 ? 0.5 : edges == 2 ? 0.75 : 1.0));
      }
    }
  }
  const auto bytes = opacityBytes(k, 0.2);
  fdswriter::smokeFile(count, {{0, bytes}, {5, bytes}}).save(made.folder / "s.s3d");
  fdswriter::saveText(made.folder / "s.s3d.sz",
                      fmt::format("0\n 0 1 1 {0}\n 5 1 1 {0}\n", mostOpaque(k, 0.2)));
  FdsCase read = opened(made.folder / "made.smv");
  const FdsField field = fieldAt(read, 5);
  for (const Vec3& point : {Vec3(0, 0, 0), Vec3(0, 0, 0.2), Vec3(0, 0.3, 0.2), Vec3(0.5, 0.3, 0.2)})
    EXPECT_NEAR(field.extinction(point), 2, 0.05) << point;
}

// Solids and what is behind walls keep the ambient temperature in the means, as FDS 6.7.1 writes
// them.
TEST(FdsSmoke, theTrueTemperatureLiesWithinTheBandOfItsByte) {
  for (const double ambient : {20.0, 12.0}) {
    const ScratchFolder folder;
    const Indices solid{1, 3, 1, 3, 0, 2};
    const Cells rises = randomCells(kFirst, solid, 300, 11);
    const auto bytesOf = [&](const std::vector<double>& mean) {
      std::vector<std::uint8_t> bytes;
      for (const double rise : mean)
        bytes.push_back(static_cast<std::uint8_t>(254 * std::max(0.0, ambient + rise - 20) / 1980));
      return bytes;
    };
    const auto mean = rises.nodes(false), truth = rises.nodes(true);
    fdswriter::Index index;
    index.meshes.push_back({kFirst, {solid}, {}});
    index.files += "SMOKG3D 1\n t.s3d\n TEMPERATURE\n temp\n C\n";
    index.input = "made.fds";
    index.save(folder / "made.smv");
    fdswriter::saveText(folder / "made.fds",
                        fmt::format("&HEAD CHID='made' /\n&MISC TMPA={} /\n", ambient));
    fdswriter::smokeFile(cellsOf(kFirst),
                         {{0, bytesOf(std::vector<double>(mean.size(), 0))}, {5, bytesOf(mean)}})
        .save(folder / "t.s3d");
    FdsCase read = opened(folder / "made.smv", {.quantity = std::string(kFdsTemperature)});
    EXPECT_EQ(read.source().name, "s3d-temperature");
    EXPECT_THAT(sentences(read.remarks()),
                testing::ElementsAre(testing::HasSubstr("20 to 2000 degrees C")));
    const FdsField field = fieldAt(read, 5);
    const FdsField before = fieldAt(read, 0);
    int checked = 0;
    for (std::size_t i = 0; i < truth.size(); ++i) {
      const float high = field.values(0).high[i];
      if (std::isnan(high))
        continue;
      ++checked;
      EXPECT_GE(high, ambient + truth[i] - 1e-3);
      EXPECT_LE(field.values(0).low[i], std::max(20.0, ambient + truth[i]) + 1e-3);
      EXPECT_LE(high - field.values(0).low[i], 8 * (1980 / 254.0 + 20 - ambient) + 1e-3);
      EXPECT_LE(before.values(0).value[i], 20 + 1e-3);
    }
    EXPECT_GT(checked, 60);
  }
}

}  // namespace
}  // namespace volute
