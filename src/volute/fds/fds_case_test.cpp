// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/fds_case.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <random>

#include "volute/fds/fds_writer.hpp"

namespace volute {
namespace {

using fdswriter::Folder;
using fdswriter::Indices;
using fdswriter::Planes;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const Planes kFirst{{{0, 0.2, 0.4, 0.6, 0.8, 1.0}, {0, 0.2, 0.4, 0.6, 0.8}, {0, 0.3, 0.5, 0.6}}};
/// On the other side of x = 1: cells twice as fine on y, stretched on x.
const Planes kSecond{{{1.0, 1.1, 1.3, 1.6, 2.0},
                      {0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8},
                      {0, 0.15, 0.3, 0.4, 0.5, 0.55, 0.6}}};

std::array<int, 3> cellsOf(const Planes& planes) {
  return {static_cast<int>(planes[0].size()) - 1, static_cast<int>(planes[1].size()) - 1,
          static_cast<int>(planes[2].size()) - 1};
}

Indices whole(const Planes& planes) {
  const auto cells = cellsOf(planes);
  return {0, cells[0], 0, cells[1], 0, cells[2]};
}

double linear(double x, double y, double z) {
  return 1 + 0.5 * x + 0.25 * y + z;
}

double linearAt(const Vec3& p) {
  return linear(p.x(), p.y(), p.z());
}

Segment between(const Vec3& a, const Vec3& b) {
  return {a, (b - a).normalized(), 0, (b - a).norm()};
}

FdsDepth depthOf(const FdsField& field, const Segment& segment) {
  FdsDepth depth;
  field.depths({&segment, 1}, {&depth, 1});
  return depth;
}

FdsCase opened(const std::filesystem::path& path, const FdsOptions& options = {}) {
  auto result = FdsCase::open(path, options);
  if (!result)
    throw std::runtime_error(result.error().message);
  return std::move(*result);
}

FdsField fieldAt(FdsCase& opened, double time) {
  auto field = opened.field(time);
  if (!field)
    throw std::runtime_error(field.error().message);
  return std::move(*field);
}

/// Two meshes with a 3D slice each, at times 0 and 10, k times as thick at 10 as at 0.
void saveSlices(const Folder& folder, bool cellCentred, double thicker,
                const fdswriter::Function& function) {
  fdswriter::Index index;
  int number = 0;
  for (const Planes& planes : {kFirst, kSecond}) {
    index.meshes.push_back({planes, {}, {}});
    const fdswriter::Slice slice{whole(planes)};
    std::vector<std::pair<float, std::vector<float>>> frames;
    for (const float time : {0.0F, 10.0F}) {
      const fdswriter::Function at = [&](double x, double y, double z) {
        return function(x, y, z) * (time == 0 ? 1 : thicker);
      };
      frames.emplace_back(time, cellCentred ? fdswriter::inCells(planes, slice.at, at, 777.0F)
                                            : fdswriter::atNodes(planes, slice.at, at));
    }
    const std::string name = fmt::format("made_{}_1.sf", ++number);
    fdswriter::sliceFile(slice, frames).save(folder / name);
    index.slice(number, slice, name, cellCentred);
  }
  index.save(folder / "made.smv");
}

TEST(FdsCase, nodesOfTwoMeshesGiveTheClosedFormAtAnyTime) {
  const Folder folder;
  saveSlices(folder, false, 3, linear);
  FdsCase read = opened(folder / "made.smv");
  EXPECT_THAT(read.remarks(), IsEmpty());
  EXPECT_EQ(read.source().name, "slice3d-extinction");
  EXPECT_THAT(read.times(), ElementsAre(0, 10));
  const Vec3 a(0.05, 0.7, 0.1);
  const Vec3 b(1.9, 0.1, 0.55);
  for (const auto& [time, factor] :
       {std::pair{-5.0, 1.0}, {0.0, 1.0}, {2.5, 1.5}, {10.0, 3.0}, {99.0, 3.0}}) {
    const FdsDepth depth = depthOf(fieldAt(read, time), between(a, b));
    const double expected = factor * 0.5 * (linearAt(a) + linearAt(b)) * (b - a).norm();
    EXPECT_NEAR(depth.value, expected, 1e-6 * expected) << time;
    EXPECT_LT(depth.uncovered, 1e-12);
  }
}

TEST(FdsCase, cellsAreConstantAndGhostsAreDropped) {
  const Folder folder;
  saveSlices(folder, true, 1, [](double x, double, double z) { return 10 * x + z; });
  FdsCase read = opened(folder / "made.smv");
  EXPECT_EQ(read.source().name, "slice3d-extinction-cells");
  const FdsField field = fieldAt(read, 0);
  // Along x in the cells 0.3 < z < 0.5 of both meshes (0.4 < z < 0.5 in the second).
  double expected = 0;
  for (const Planes& planes : {kFirst, kSecond}) {
    for (std::size_t i = 0; i + 1 < planes[0].size(); ++i) {
      const double x = 0.5 * (planes[0][i] + planes[0][i + 1]);
      const double z = &planes == &kFirst ? 0.4 : 0.45;
      (void)z;
      expected += (planes[0][i + 1] - planes[0][i]) * 10 * x;
    }
  }
  expected += 0.4 * 1.0 + 0.45 * 1.0;
  EXPECT_NEAR(depthOf(field, between({0, 0.35, 0.45}, {2, 0.35, 0.45})).value, expected, 1e-6);
}

TEST(FdsCase, aSliceOfCellsIsALayerOfThem) {
  const Folder folder;
  fdswriter::Index index;
  index.meshes.push_back({kFirst, {}, {}});
  // Cell 2 on z lies between 0.3 and 0.5, not at node 2.
  const fdswriter::Slice cells{{0, 5, 0, 4, 2, 2}};
  fdswriter::sliceFile(cells, {{0, fdswriter::inCells(kFirst, cells.at, linear, 777.0F)}})
      .save(folder / "cells.sf");
  index.slice(1, cells, "cells.sf", true);
  index.save(folder / "made.smv");
  FdsCase read = opened(folder / "made.smv");
  const FdsField field = fieldAt(read, 0);
  EXPECT_EQ(field.bounds().min.z(), 0.3);
  EXPECT_EQ(field.bounds().max.z(), 0.5);
  EXPECT_NEAR(field.extinction({0.5, 0.5, 0.31}), linear(0.5, 0.5, 0.4), 1e-6);
  EXPECT_LT(depthOf(field, between({0.1, 0.1, 0.4}, {0.9, 0.7, 0.4})).uncovered, 1e-12);
  const FdsDepth leaving = depthOf(field, between({0.1, 0.1, 0.2}, {0.9, 0.1, 0.4}));
  EXPECT_NEAR(leaving.uncovered, 0.5 * Vec3(0.8, 0, 0.2).norm(), 1e-12);
}

TEST(FdsCase, aSliceOfNodesIsALayerRoundThem) {
  const Folder folder;
  fdswriter::Index index;
  index.meshes.push_back({kFirst, {}, {}});
  const fdswriter::Slice nodes{{0, 5, 0, 4, 2, 2}};
  fdswriter::sliceFile(nodes, {{0, fdswriter::atNodes(kFirst, nodes.at, linear)}})
      .save(folder / "nodes.sf");
  index.slice(1, nodes, "nodes.sf", false);
  index.save(folder / "made.smv");
  FdsCase read = opened(folder / "made.smv");
  EXPECT_EQ(read.source().name, "slice-extinction");
  const FdsField field = fieldAt(read, 0);
  EXPECT_NEAR(field.bounds().min.z(), 0.4, 1e-12);
  EXPECT_NEAR(field.bounds().max.z(), 0.55, 1e-12);
  const Segment line = between({0.1, 0.1, 0.45}, {0.9, 0.7, 0.54});
  EXPECT_NEAR(depthOf(field, line).value,
              0.5 * (linear(0.1, 0.1, 0.5) + linear(0.9, 0.7, 0.5)) * line.end, 1e-6);
  FdsOptions volume;
  volume.volume = true;
  const auto none = FdsCase::open(folder / "made.smv", volume);
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().message, HasSubstr("layers only (slice-extinction)"));
}

TEST(FdsCase, theBestSourceIsTakenAndOthersByName) {
  const Folder folder;
  fdswriter::Index index;
  index.meshes.push_back({kFirst, {}, {}});
  const auto save = [&](const std::string& quantity, const std::string& unit, double value) {
    fdswriter::Slice slice{whole(kFirst), quantity, "short", unit};
    const std::string name = fmt::format("{}.sf", value);
    fdswriter::sliceFile(
        slice, {{0, fdswriter::atNodes(kFirst, slice.at, [&](auto...) { return value; })}})
        .save(folder / name);
    index.slice(1, slice, name, false);
  };
  save("SOOT VISIBILITY", "m", 6);
  save("SOOT DENSITY", "kg/m3", 1e-4);
  save("SOOT OPTICAL DENSITY", "1/m", 0.3);
  save("SOOT EXTINCTION COEFFICIENT", "1/m", 0.7);
  index.save(folder / "made.smv");
  const Segment line = between({0, 0.4, 0.4}, {1, 0.4, 0.4});
  FdsOptions options;
  for (const auto& [name, expected] : std::vector<std::pair<std::string, double>>{
           {"", 0.7},
           {"slice3d-extinction", 0.7},
           {"slice3d-optical-density", 0.3 * std::log(10.0)},
           {"slice3d-soot-density", 0.87},
           {"slice3d-visibility", 0.5}}) {
    options.source = name;
    FdsCase read = opened(folder / "made.smv", options);
    EXPECT_NEAR(depthOf(fieldAt(read, 0), line).value, expected, 1e-6) << name;
  }
  options.source = "slice3d-smoke";
  const auto unknown = FdsCase::open(folder / "made.smv", options);
  ASSERT_FALSE(unknown);
  EXPECT_THAT(unknown.error().message,
              HasSubstr("the case has slice3d-extinction, slice3d-optical-density, "
                        "slice3d-soot-density, slice3d-visibility"));
}

TEST(FdsCase, visibilityAtItsCapSaysOnlyHowThickSmokeIsAtMost) {
  const Folder folder;
  fdswriter::Index index;
  index.meshes.push_back({kFirst, {}, {}});
  fdswriter::Slice slice{whole(kFirst), "SOOT VISIBILITY", "VIS", "m"};
  fdswriter::sliceFile(slice,
                       {{0, fdswriter::atNodes(kFirst, slice.at, [](auto...) { return 30.0; })}})
      .save(folder / "v.sf");
  index.slice(1, slice, "v.sf", false);
  index.save(folder / "made.smv");
  FdsCase read = opened(folder / "made.smv");
  EXPECT_THAT(read.remarks(), ElementsAre(HasSubstr("visibility is cut at 30 m")));
  const FdsDepth depth = depthOf(fieldAt(read, 0), between({0, 0.4, 0.4}, {1, 0.4, 0.4}));
  EXPECT_EQ(depth.low, 0);
  EXPECT_NEAR(depth.value, 0.1, 1e-6);
  EXPECT_GE(depth.high, depth.value);
}

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

void saveSmoke(const Folder& folder, const Cells& cells, const Indices& solid, Writing writing) {
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
  for (const double one : density)
    densityBytes.push_back(static_cast<std::uint8_t>(254 * one / densest));
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
  const Folder folder;
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

TEST(FdsSmoke, aSignOnAWallIsSeenThroughTheSmokeThatIsThere) {
  // Even smoke: FDS's means at the wall are a half, at its edges a quarter of it.
  const Folder folder;
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

TEST(FdsSmoke, theLastByteSaysAtLeast) {
  const Folder folder;
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
  const Folder folder;
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
  // FDS keeps the first moment's value in cells outside, but for those across edges.
  const Folder folder;
  fdswriter::Index index;
  index.meshes.push_back({kFirst, {}, {}});
  index.smoke(1, "s.s3d", kKm);
  index.save(folder / "made.smv");
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
  fdswriter::smokeFile(count, {{0, bytes}, {5, bytes}}).save(folder / "s.s3d");
  fdswriter::saveText(folder / "s.s3d.sz",
                      fmt::format("0\n 0 1 1 {0}\n 5 1 1 {0}\n", mostOpaque(k, 0.2)));
  FdsCase read = opened(folder / "made.smv");
  const FdsField field = fieldAt(read, 5);
  for (const Vec3& point : {Vec3(0, 0, 0), Vec3(0, 0, 0.2), Vec3(0, 0.3, 0.2), Vec3(0.5, 0.3, 0.2)})
    EXPECT_NEAR(field.extinction(point), 2, 0.05) << point.transpose();
}

TEST(FdsCase, solidsNeverReachTheirNeighbours) {
  // FDS writes the ambient value at nodes inside walls: soot of 1.2 kg/m3.
  const Folder folder;
  fdswriter::Index index;
  index.meshes.push_back({kFirst, {{1, 4, 1, 3, 0, 3}}, {}});
  fdswriter::Slice slice{whole(kFirst), "SOOT DENSITY", "rho", "kg/m3"};
  const auto inside = [](double x, double y, double) { return x > 0.3 && x < 0.7 && y == 0.4; };
  fdswriter::sliceFile(slice, {{0, fdswriter::atNodes(kFirst, slice.at,
                                                      [&](double x, double y, double z) {
                                                        return inside(x, y, z) ? 1.195 : 1e-4;
                                                      })}})
      .save(folder / "a.sf");
  index.slice(1, slice, "a.sf", false);
  index.save(folder / "made.smv");
  FdsCase read = opened(folder / "made.smv");
  const FdsDepth depth = depthOf(fieldAt(read, 0), between({0, 0.4, 0.3}, {1, 0.4, 0.3}));
  EXPECT_NEAR(depth.insideSolids, 0.6, 1e-9);
  EXPECT_NEAR(depth.value, 0.4 * 0.87, 1e-6);
}

TEST(FdsCase, aDoorOpensTheLineOfSightAtItsTime) {
  const Folder folder;
  fdswriter::Index index;
  index.meshes.push_back({kFirst, {{2, 3, 0, 4, 0, 3}, {4, 4, 0, 4, 0, 3}}, {}});
  fdswriter::Slice slice{whole(kFirst)};
  const auto frame = [&](double gas, double door) {
    return fdswriter::inCells(
        kFirst, slice.at, [&](double x, double, double) { return x > 0.4 && x < 0.6 ? door : gas; },
        0.0F);
  };
  fdswriter::sliceFile(slice, {{0, frame(1, 999)}, {10, frame(1, 999)}, {20, frame(1, 5)}})
      .save(folder / "a.sf");
  index.slice(1, slice, "a.sf", true);
  index.event("HIDE_OBST", 1, 1, 12.5);
  index.event("HIDE_OBST", 1, 2, 12.5);
  index.event("SHOW_OBST", 1, 2, 15);
  index.save(folder / "made.smv");
  FdsCase read = opened(folder / "made.smv");
  EXPECT_THAT(obstructionEvents(read.index()), ElementsAre(12.5, 15));
  const Segment line = between({0.1, 0.4, 0.3}, {0.9, 0.4, 0.3});
  EXPECT_TRUE(read.obstructions(12.49).blocked(line));
  EXPECT_FALSE(read.obstructions(12.5).blocked(line));
  EXPECT_TRUE(read.obstructions(15).blocked(line));  // a thin one
  EXPECT_NEAR(depthOf(fieldAt(read, 12.49), line).value, 0.6, 1e-6);
  // The door's cells have no value but the one after it went.
  EXPECT_NEAR(depthOf(fieldAt(read, 12.5), line).value, 0.6 + 0.2 * 5, 1e-6);
  EXPECT_LT(depthOf(fieldAt(read, 12.5), line).uncovered, 1e-12);
}

TEST(FdsCase, gasThatNoFrameKnowsIsNotCovered) {
  const Folder folder;
  fdswriter::Index index;
  index.meshes.push_back({kFirst, {{2, 3, 0, 4, 0, 3}}, {}});
  fdswriter::Slice slice{whole(kFirst)};
  const auto values = fdswriter::inCells(kFirst, slice.at, linear, 0.0F);
  fdswriter::sliceFile(slice, {{0, values}}).save(folder / "a.sf");
  index.slice(1, slice, "a.sf", true);
  index.event("HIDE_OBST", 1, 1, 5);
  index.save(folder / "made.smv");
  FdsCase read = opened(folder / "made.smv");
  EXPECT_NEAR(depthOf(fieldAt(read, 5), between({0, 0.4, 0.3}, {1, 0.4, 0.3})).uncovered, 0.2,
              1e-12);
}

TEST(FdsCase, aRunningCaseIsReadAsFarAsAllItsFilesGo) {
  const Folder folder;
  saveSlices(folder, false, 2, linear);
  std::filesystem::resize_file(folder / "made_2_1.sf",
                               std::filesystem::file_size(folder / "made_2_1.sf") - 9);
  const FdsCase read = opened(folder / "made.smv");
  EXPECT_THAT(read.times(), ElementsAre(0));
  EXPECT_THAT(read.remarks(), Contains(HasSubstr("within frame 1 that begins at byte")));
  EXPECT_THAT(read.remarks(), Contains(HasSubstr("1 of the frames of")));
}

TEST(FdsCase, aMeshWithoutAWholeFrameIsLeftOutAndNamed) {
  const Folder folder;
  saveSlices(folder, false, 2, linear);
  std::filesystem::resize_file(folder / "made_2_1.sf", 200);
  const FdsCase read = opened(folder / "made.smv");
  EXPECT_THAT(read.times(), ElementsAre(0, 10));
  EXPECT_THAT(read.remarks(), Contains(HasSubstr("does not cover 1 of 2 meshes (2)")));
}

TEST(FdsCase, valuesThatAreNoNumbersAreRefusedWhereThereIsGas) {
  const Folder folder;
  saveSlices(folder, false, 1, [](double x, double y, double z) {
    return x == 1 && y == 0.4 && z == 0.5 ? std::nan("") : 1.0;
  });
  FdsCase read = opened(folder / "made.smv");
  const auto field = read.field(0);
  ASSERT_FALSE(field);
  EXPECT_THAT(field.error().message, HasSubstr("frame 0 (t = 0 s): value"));
}

TEST(FdsCase, memoryIsBounded) {
  const Folder folder;
  saveSlices(folder, false, 1, linear);
  FdsOptions options;
  options.maxMemory = 1000;
  const auto read = FdsCase::open(folder / "made.smv", options);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().code, ErrorCode::kTooLarge);
}

TEST(FdsCase, aMeshThatIsTooLargeIsRefusedBeforeItIsBuilt) {
  // A slice of four values in a mesh of 7e11 cells: the index alone says so.
  const Folder folder;
  fdswriter::Index index;
  Planes planes;
  for (auto& axis : planes) {
    for (int i = 0; i <= 9000; ++i) axis.push_back(0.001 * i);
  }
  index.meshes.push_back({planes, {}, {}});
  const fdswriter::Slice slice{{0, 1, 0, 1, 1, 1}};
  fdswriter::sliceFile(slice, {{0, {1, 1, 1, 1}}}).save(folder / "a.sf");
  index.slice(1, slice, "a.sf", false);
  index.save(folder / "made.smv");
  const auto read = FdsCase::open(folder / "made.smv");
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().code, ErrorCode::kTooLarge);
  EXPECT_THAT(read.error().message, HasSubstr("7.29e+11 cells"));
}

TEST(FdsCase, plot3dIsReadWhereNothingElseIs) {
  const Folder folder;
  fdswriter::Index index;
  index.meshes.push_back({kFirst, {}, {}});
  for (const double time : {1.0, 3.0}) {
    std::vector<float> five;
    for (int v = 0; v < 5; ++v) {
      const auto values = fdswriter::atNodes(
          kFirst, whole(kFirst),
          [&](double x, double y, double z) { return v == 1 ? time * linear(x, y, z) : -9.0; });
      five.insert(five.end(), values.begin(), values.end());
    }
    const std::string name = fmt::format("made_1_{}p00.q", time);
    fdswriter::plotFile(cellsOf(kFirst), five).save(folder / name);
    index.plot(1, time, name, "SOOT EXTINCTION COEFFICIENT");
  }
  index.save(folder / "made.smv");
  FdsCase read = opened(folder / "made.smv");
  EXPECT_EQ(read.source().name, "plot3d-extinction");
  EXPECT_THAT(read.times(), ElementsAre(1, 3));
  EXPECT_NEAR(fieldAt(read, 2).extinction({0.5, 0.5, 0.2}), 2 * linear(0.5, 0.5, 0.2), 1e-5);
}

}  // namespace
}  // namespace volute
