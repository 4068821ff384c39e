// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fds/fds_sight.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <random>
#include <utility>

#include "volute/fds/fds_case_testing.hpp"
#include "volute/media/fds/fds_walls.hpp"

namespace volute {
namespace {

/// Two meshes of other cells beside each other, evenly spaced or wider along y, uneven smoke, an
/// obstruction and an unknown corner.
FdsSightSnapshot twoMeshes(bool nodal, bool even) {
  SmvIndex index;
  std::vector<FdsLattice> lattices;
  for (int m = 0; m < 2; ++m) {
    FdsMesh mesh;
    const int cells = m == 0 ? 20 : 13;
    for (int i = 0; i <= cells; ++i) mesh.planes[0].push_back(4 * m + 4.0 * i / cells);
    for (int i = 0; i <= cells; ++i) {
      const double at = static_cast<double>(i) / cells;
      mesh.planes[1].push_back(3 * (even ? at : at * (0.7 + 0.3 * at)));
    }
    for (int i = 0; i <= 9; ++i) mesh.planes[2].push_back(2.4 * i / 9);
    if (m == 0) {
      FdsObstruction obstruction;
      obstruction.nodes = {{8, 0, 0}, {10, 12, 9}};
      mesh.obstructions = {obstruction};
    }
    FdsLattice lattice;
    lattice.planes = mesh.planes;
    lattice.nodal = nodal;
    lattices.push_back(lattice);
    index.meshes.push_back(std::move(mesh));
  }
  const auto grid = FdsGrid::create(lattices).value();
  std::vector<std::shared_ptr<const FdsValues>> values;
  std::vector<std::shared_ptr<const std::vector<FdsCell>>> cells;
  for (int m = 0; m < 2; ++m) {
    const FdsLattice& lattice = lattices[static_cast<std::size_t>(m)];
    auto value = std::make_shared<FdsValues>();
    for (std::size_t i = 0; i < lattice.valueCount(); ++i) {
      const float k = 0.3F * (1.2F + std::sin(0.37F * static_cast<float>(i)));
      value->value.push_back(k);
      value->low.push_back(0.9F * k);
      value->high.push_back(1.1F * k);
    }
    auto state = std::make_shared<std::vector<FdsCell>>(lattice.cellCount(), FdsCell::kGas);
    for (int z = 0; z < lattice.cells(2); ++z) {
      for (int y = 0; y < lattice.cells(1); ++y) {
        for (int x = 0; x < lattice.cells(0); ++x) {
          FdsCell& cell = (*state)[lattice.cellAt({x, y, z})];
          if (m == 0 && x >= 8 && x < 10 && y < 12)
            cell = FdsCell::kSolid;
          if (m == 1 && x > 10 && y > 10)
            cell = FdsCell::kUnknown;
        }
      }
    }
    values.push_back(std::move(value));
    cells.push_back(std::move(state));
  }
  return FdsSightSnapshot(FdsField(grid, values, cells), FdsObstructions(index, 0), 1);
}

TEST(FdsSightSnapshot, BlocksOfCellsBoundEveryLine) {
  std::mt19937 draw(3);
  std::uniform_real_distribution<double> x(-0.2, 8.2), y(0, 3), z(0, 2.4);
  for (const auto& [nodal, even] :
       {std::pair(false, true), {true, true}, {false, false}, {true, false}}) {
    const FdsSightSnapshot snapshot = twoMeshes(nodal, even);
    std::vector<SightLine> lines;
    for (int i = 0; i < 2000; ++i)
      lines.push_back({Vec3(x(draw), y(draw), z(draw)), Vec3(x(draw), y(draw), z(draw))});
    std::vector<Sight> sights(lines.size());
    std::vector<double> low(lines.size()), high(lines.size());
    std::vector<unsigned char> blocked(lines.size());
    snapshot.look(lines, sights);
    snapshot.bounds(lines, low, high);
    snapshot.blocked(lines, blocked);
    int tight = 0, uncovered = 0;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      ASSERT_LE(low[i], sights[i].low + 1e-12);
      if (sights[i].covered)
        ASSERT_GE(high[i], sights[i].high);
      else
        ASSERT_TRUE(std::isinf(high[i]));
      ASSERT_EQ(blocked[i] != 0, sights[i].blocked);
      tight += high[i] < 6 * sights[i].high;
      uncovered += !sights[i].covered;
    }
    EXPECT_GT(tight, 1000);
    EXPECT_GT(uncovered, 50);
  }
}

TEST(FdsSight, WallsOfTrianglesBlockAndCarry) {
  const ScratchFolder folder;
  fdswriter::Index index;
  index.meshes.push_back({{{{0, 1, 2, 3, 4, 5, 6}, {0, 1, 2, 3, 4}, {0, 1, 2, 3}}}, {}, {}});
  const fdswriter::Slice slice{{0, 6, 0, 4, 0, 3}};
  fdswriter::sliceFile(slice, {{0, std::vector<float>(7 * 5 * 4, 0.1F)}}).save(folder / "k.sf");
  index.slice(1, slice, "k.sf", false);
  index.files += "GEOM 1\n made.ge\n";
  fdswriter::boxGeometry({2.2F, 1, 0}, {3.4F, 3, 1.2F}, 0).save(folder / "made.ge");
  index.save(folder / "made.smv");
  FdsCase fds = opened(folder / "made.smv");
  std::vector<Remark> remarks;
  auto mesh = fdsWalls(fds.index(), remarks).value();
  EXPECT_TRUE(remarks.empty());
  FdsSight sight(std::move(fds), "made", 1 << 30, {},
                 TriangleScene::build(mesh.triangles, mesh.materials).value());
  const auto snapshot = sight.readAt(0).value();

  const SightLine lines[] = {
      {{0.5, 2, 1}, {5, 2, 1}}, {{0.5, 2, 1.5}, {5, 2, 1.5}}, {{0.5, 0.5, 1}, {5, 0.5, 1}}};
  std::vector<Sight> sights(3);
  snapshot->look(lines, sights);
  EXPECT_TRUE(sights[0].blocked);
  EXPECT_FALSE(sights[1].blocked) << "above it";
  EXPECT_FALSE(sights[2].blocked) << "beside it";
  const Vec3 points[] = {{3, 2, 0.6}, {3, 2, 2.9}, {1, 2, 0.6}};
  std::vector<Place> places(3);
  snapshot->places(points, places);
  EXPECT_EQ(places[0], Place::kSolid);
  EXPECT_EQ(places[1], Place::kGas);
  EXPECT_EQ(places[2], Place::kGas);
  std::vector<double> z(3), k(3);
  snapshot->floors(points, 2.5, z);
  EXPECT_NEAR(z[1], 1.2, 1e-6) << "its top carries people";
  EXPECT_NEAR(z[2], 0, 1e-9);
  snapshot->extinction(points, k);
  EXPECT_TRUE(std::isnan(k[0]));
  EXPECT_NEAR(k[2], 0.1, 1e-6);
}

TEST(FdsSight, ASliceNamesTheSourceThatFillsItsMesh) {
  MadeCase made;
  const auto add = [&](const fdswriter::Slice& slice, const std::string& name) {
    made.add(slice, name, {{0, fdswriter::atNodes(kFirst, slice.at, linear)}});
    made.index.save(made.folder / "made.smv");
  };
  const auto sight = [&](const std::string& source) {
    return FdsSight(opened(made.folder / "made.smv", {.source = source}));
  };
  add({{0, 5, 0, 4, 2, 2}}, "flat.sf");
  EXPECT_EQ(sight("").tallerSource(), "");
  add({whole(kFirst)}, "whole.sf");
  EXPECT_EQ(sight("").tallerSource(), "");
  EXPECT_EQ(sight("slice-extinction").tallerSource(), "slice3d-extinction");
}

TEST(FdsSight, LayersThatLeaveOutAPartOfAHeightGiveWayToWhatFillsMeshes) {
  const ScratchFolder folder;
  // Cells of 0.2 m, and 0.3, 0.2, 0.1 m on z.
  const auto sightOf = [&](const std::vector<Indices>& layers) {
    fdswriter::Index index;
    index.meshes.push_back({kFirst, {}, {}});
    for (const Indices& at : layers) {
      const fdswriter::Slice slice{at, "SOOT VISIBILITY", "VIS", "m"};
      const std::string name = fmt::format("{}.sf", &at - layers.data());
      fdswriter::sliceFile(slice,
                           {{0, fdswriter::atNodes(kFirst, at, [](auto...) { return 9.0; })}})
          .save(folder / name);
      index.slice(1, slice, name, false);
    }
    fdswriter::smokeFile(cellsOf(kFirst), {{0, std::vector<std::uint8_t>(6 * 5 * 4, 50)}})
        .save(folder / "made.s3d");
    index.smoke(1, "made.s3d", 7600);
    index.save(folder / "made.smv");
    return FdsSight(opened(folder / "made.smv"));
  };
  const FdsSight upright = sightOf({{0, 5, 2, 2, 0, 3}});
  EXPECT_FALSE(upright.reaches(0.3)) << "a strip of it";
  EXPECT_EQ(upright.tallerSource(), "s3d");
  const FdsSight flat = sightOf({{0, 5, 0, 4, 0, 0}, {0, 5, 0, 4, 3, 3}});
  EXPECT_TRUE(flat.reaches(0.1));
  EXPECT_TRUE(flat.reaches(0.58));
  EXPECT_FALSE(flat.reaches(0.3)) << "between two layers";
  EXPECT_TRUE(flat.reaches(0.7)) << "nothing does";
  EXPECT_EQ(flat.tallerSource(), "s3d");
  EXPECT_FALSE(sightOf({{1, 5, 0, 4, 1, 1}}).reaches(0.3)) << "all but a row of cells";
  EXPECT_TRUE(sightOf({{0, 5, 0, 4, 1, 1}}).reaches(0.3));
}

TEST(FdsSight, LayersThatStandInForAWhileLeaveTheRestUnknown) {
  MadeCase made;
  const auto add = [&](const fdswriter::Slice& slice, const std::string& name,
                       const std::vector<float>& times, double value) {
    std::vector<std::pair<float, std::vector<float>>> frames;
    for (const float time : times)
      frames.emplace_back(time,
                          fdswriter::atNodes(kFirst, slice.at, [&](auto...) { return value; }));
    made.add(slice, name, frames);
  };
  add({whole(kFirst)}, "whole.sf", {10, 20}, 0.1);
  add({{0, 5, 0, 4, 1, 1}, "SOOT VISIBILITY", "VIS", "m"}, "flat.sf", {0, 10, 20}, 6);
  FdsCase fds = made.open({.source = "slice3d-extinction"});
  auto others = fillingSources(fds, {});
  ASSERT_EQ(others.size(), 1U);
  FdsSight sight(std::move(fds), "made", 1 << 30, std::move(others));
  const Vec3 points[] = {{0.5, 0.4, 0.3}, {0.5, 0.4, 0.55}};
  std::vector<Place> places(2);
  std::vector<double> k(2);
  const auto before = sight.readAt(0).value();
  before->places(points, places);
  EXPECT_EQ(places, (std::vector{Place::kGas, Place::kGas}));
  before->extinction(points, k);
  EXPECT_NEAR(k[0], 0.5, 1e-6);
  EXPECT_TRUE(std::isnan(k[1]));
  const auto after = sight.readAt(10).value();
  after->extinction(points, k);
  EXPECT_NEAR(k[0], 0.1, 1e-6);
  EXPECT_NEAR(k[1], 0.1, 1e-6);
}

// A limit that is exceeded between the times of what fills the mesh, and only then.
TEST(FdsSight, LayersWithMoreTimesServeBetweenThoseOfAVolume) {
  std::mt19937 draw(7);
  std::uniform_real_distribution<double> uniform(0.15, 1);
  constexpr double kLimit = 0.8;
  constexpr double kMean = 0.95;  // what a mean of visibilities in uneven smoke leaves of it
  constexpr int kTimes = 13;
  int missed = 0;  // by the volume alone
  for (int n = 0; n < 40; ++n) {
    const int every = 2 + n % 5;
    std::vector<double> truth(kTimes);
    for (double& k : truth) k = uniform(draw);
    truth[0] = 0.1;  // where visibilities are cut
    MadeCase made;
    const auto add = [&](const fdswriter::Slice& slice, const std::string& name, int step,
                         auto&& stored) {
      std::vector<std::pair<float, std::vector<float>>> frames;
      for (int t = 0; t < kTimes; t += step)
        frames.emplace_back(
            static_cast<float>(2 * t),
            fdswriter::atNodes(kFirst, slice.at, [&](auto...) { return stored(truth[t]); }));
      made.add(slice, name, frames);
    };
    add({whole(kFirst)}, "whole.sf", every, [](double k) { return k; });
    add({{0, 5, 0, 4, 1, 1}, "SOOT VISIBILITY", "VIS", "m"}, "flat.sf", 1,
        [](double k) { return 3 / (kMean * k); });
    FdsCase fds = made.open({.source = "slice3d-extinction"});
    auto others = fillingSources(fds, {});
    FdsSight sight(std::move(fds), "made", 1 << 30, std::move(others));
    ASSERT_EQ(sight.times().size(), kTimes);
    const Vec3 points[] = {{0.5, 0.4, 0.3}, {0.5, 0.4, 0.55}};
    std::optional<int> first, known;
    for (int t = 0; t < kTimes; ++t) {
      std::vector<double> low(2), high(2);
      const auto snapshot = sight.read(t).value();
      snapshot->extinctionBounds(points, low, high);
      const int before = t / every * every, after = before + (t > before ? every : 0);
      if (t == before) {
        EXPECT_NEAR(low[0], truth[t], 1e-5);
        EXPECT_NEAR(high[0], truth[t], 1e-5);
      } else {
        EXPECT_LE(low[0], kMean * truth[t] + 1e-5);
        EXPECT_GE(high[0], truth[t] - 1e-5) << "means leave that open";
        EXPECT_LE(high[0], 2.34 * kMean * truth[t]);
      }
      if (high[0] >= kLimit - 1e-5 && !first)
        first = t;
      if (truth[t] >= kLimit && !known)
        known = t;
      if (after >= kTimes) {
        EXPECT_TRUE(std::isnan(low[1])) << "the volume has ended";
        continue;
      }
      const auto [least, most] = std::minmax(truth[before], truth[after]);
      EXPECT_NEAR(low[1], least, 1e-5);
      EXPECT_NEAR(high[1], most, 1e-5);
    }
    EXPECT_LE(first.value_or(kTimes), known.value_or(kTimes));
    missed += known.has_value() && *known % every != 0;
  }
  EXPECT_GT(missed, 10);
}

// A mesh of stretched cells, of which 3D slices know a part well, and others the rest.
TEST(FdsSight, A3dSliceOfAPartOfAMeshLeavesTheRestToOthers) {
  const auto lineOf = [](FdsSight& sight) {
    const SightLine line{{1.05, 0.4, 0.4}, {1.95, 0.4, 0.4}};
    Sight seen;
    sight.readAt(0).value()->look({&line, 1}, {&seen, 1});
    return seen;
  };
  const auto sightOf = [](const MadeCase& made, const std::string& source) {
    FdsCase fds = made.open({.source = source});
    auto others = fillingSources(fds, {});
    return FdsSight(std::move(fds), "made", 1 << 30, std::move(others));
  };
  MadeCase made;
  made.index.meshes = {{kSecond, {}, {}}};
  const auto add = [&](const Indices& at, const std::string& quantity, const std::string& unit,
                       const std::string& name, double value) {
    const fdswriter::Slice slice{at, quantity, "short", unit};
    made.add(slice, name,
             {{0, fdswriter::atNodes(kSecond, at, [&](auto...) { return value; })},
              {9, fdswriter::atNodes(kSecond, at, [&](auto...) { return value; })}});
  };
  const std::string smoke = "SOOT EXTINCTION COEFFICIENT";
  add({2, 4, 0, 8, 0, 6}, smoke, "1/m", "part.sf", 1);  // x >= 1.3
  FdsSight alone = sightOf(made, "");
  EXPECT_FALSE(lineOf(alone).covered);
  EXPECT_NEAR(alone.bounds().min.x(), 1.3, 1e-9);
  add({0, 4, 0, 8, 3, 3}, smoke, "1/m", "flat.sf", 2);  // z = 0.4
  FdsSight withLayer = sightOf(made, "");
  EXPECT_TRUE(lineOf(withLayer).covered);
  EXPECT_NEAR(lineOf(withLayer).depth, 2 * 0.9, 1e-6) << "the layer lies over the part";
  EXPECT_THAT(sentences(withLayer.remarks()), ::testing::Contains(::testing::HasSubstr(
                                                  "slice-extinction serves where the 3D slices "
                                                  "of slice3d-extinction leave a part")));
  add(whole(kSecond), "SOOT OPTICAL DENSITY", "1/m", "whole.sf", 3 / std::log(10.0));
  const auto at = [](FdsSight& sight, const Vec3& point) {
    double k = 0;
    sight.readAt(0).value()->extinction({&point, 1}, {&k, 1});
    return k;
  };
  FdsSight all = sightOf(made, "");
  EXPECT_NEAR(at(all, {1.2, 0.4, 0.1}), 3, 1e-6) << "the whole";
  EXPECT_NEAR(at(all, {1.5, 0.4, 0.1}), 1, 1e-6) << "the better one in its part";
  EXPECT_NEAR(at(all, {1.2, 0.4, 0.4}), 2, 1e-6) << "the layer";
  EXPECT_EQ(all.bounds().min.x(), 1);
  // A volume is of one source.
  EXPECT_EQ(made.open({.volume = true}).source().name, "slice3d-optical-density");
  EXPECT_EQ(made.open().source().name, "slice3d-extinction");
}

TEST(FdsSight, ExtinctionThatNoSmokeHasIsTold) {
  MadeCase made;
  const fdswriter::Slice slice{whole(kFirst)};
  auto values = fdswriter::atNodes(kFirst, slice.at, linear), spoilt = values;
  spoilt[40] = 1e30F;
  made.add(slice, "made.sf", {{0, values}, {1, spoilt}, {2, values}});
  FdsSight sight(made.open(), "made");
  ASSERT_TRUE(sight.readAt(0));
  EXPECT_THAT(sight.remarksOn(sight.largestRead().value()), ::testing::IsEmpty());
  ASSERT_TRUE(sight.readAt(1));
  ASSERT_TRUE(sight.readAt(2));
  EXPECT_THAT(sentences(sight.remarksOn(sight.largestRead().value())),
              ::testing::ElementsAre(::testing::HasSubstr("extinction up to 1e+30/m")));
}

TEST(FdsSight, TheSmokeOfOneSpeciesDoesNotServeForThatOfAnother) {
  MadeCase made;
  for (const std::string species : {"ACETONE", "SOOT"}) {
    const fdswriter::Slice slice{whole(kFirst), species + " EXTINCTION COEFFICIENT"};
    const auto values = fdswriter::atNodes(kFirst, slice.at, linear);
    std::vector<std::pair<float, std::vector<float>>> frames{{0, values}, {1, values}};
    if (species == "ACETONE")
      frames.push_back({2, values});
    made.add(slice, species + ".sf", frames);
  }
  EXPECT_THAT(fillingSources(made.open(), {}), ::testing::IsEmpty());
}

TEST(FdsSight, AFileThatIsCutIsNamedWhetherItServesOrNot) {
  for (const bool serves : {true, false}) {
    const ScratchFolder folder;
    fdswriter::Index index;
    // Of another mesh, or in the same as a source with as many times.
    index.meshes.push_back({kFirst, {}, {}});
    index.meshes.push_back({kSecond, {}, {}});
    const auto add = [&](int mesh, const Planes& planes, const std::string& quantity,
                         const std::vector<float>& times, const std::string& name) {
      const fdswriter::Slice slice{whole(planes), quantity, "short",
                                   quantity.ends_with("Y") ? "m" : "1/m"};
      std::vector<std::pair<float, std::vector<float>>> frames;
      for (const float time : times)
        frames.emplace_back(time,
                            fdswriter::atNodes(planes, slice.at, [](auto...) { return 1.0; }));
      fdswriter::sliceFile(slice, frames).save(folder / name);
      index.slice(mesh, slice, name, false);
    };
    add(1, kFirst, "SOOT EXTINCTION COEFFICIENT", {0, 10, 20}, "a.sf");
    if (!serves)
      add(2, kSecond, "SOOT EXTINCTION COEFFICIENT", {0, 10, 20}, "b.sf");
    add(1, kFirst, "SOOT VISIBILITY", {0, 10, 20}, "c.sf");
    add(2, kSecond, "SOOT VISIBILITY", {0}, "d.sf");
    index.save(folder / "made.smv");
    FdsCase fds = opened(folder / "made.smv", {.source = "slice3d-extinction"});
    std::vector<Remark> unread;
    auto others = fillingSources(fds, {}, nullptr, &unread);
    ASSERT_EQ(others.size(), serves ? 1U : 0U);
    const FdsSight sight(std::move(fds), "made", 1 << 30, std::move(others), {}, unread);
    std::vector<std::string> said;
    for (const Remark& remark : sight.remarks()) said.push_back(remark.sentence);
    EXPECT_THAT(said,
                ::testing::Contains(::testing::HasSubstr("2 of 3 stored times are left out")));
  }
}

TEST(FdsSight, AFileThatShouldServeBesideALayerIsNamedWhenItIsMissing) {
  MadeCase made;
  const fdswriter::Slice slice{{0, 5, 0, 4, 1, 1}};
  made.add(slice, "flat.sf", {{0, fdswriter::atNodes(kFirst, slice.at, linear)}});
  made.index.smoke(1, "gone.s3d", 7600);
  const FdsCase fds = made.open({.source = "slice-extinction"});
  std::vector<Remark> unread;
  EXPECT_TRUE(fillingSources(fds, {}, nullptr, &unread).empty());
  ASSERT_EQ(unread.size(), 1U);
  EXPECT_THAT(unread[0].sentence, ::testing::HasSubstr("gone.s3d"));
  EXPECT_THAT(unread[0].sentence,
              ::testing::HasSubstr("cannot serve where slice-extinction does not"));
}

}  // namespace
}  // namespace volute
