// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "volute/fds/fds_case_testing.hpp"

namespace volute {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Two meshes with a 3D slice each, at times 0 and 10, k times as thick at 10 as at 0.
void saveSlices(const ScratchFolder& folder, bool cellCentred, double thicker,
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
  const ScratchFolder folder;
  saveSlices(folder, false, 3, linear);
  FdsCase read = opened(folder / "made.smv");
  EXPECT_THAT(sentences(read.remarks()), IsEmpty());
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

TEST(FdsCase, evenSmokeDimsToTheGreyOfTheClosedForm) {
  // K of FDS's beam_detector case. A white wall behind it, seen at any distance, from any side,
  // through cells of any size.
  constexpr double kK = 0.3119;
  constexpr double kBar = 0.5;  // of 255
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (const double cell : {0.05, 0.2, 1.0}) {
    for (const bool cellCentred : {false, true}) {
      const ScratchFolder folder;
      fdswriter::Index index;
      for (int number = 1; number <= 2; ++number) {
        // The second mesh has cells half as large on y and z.
        Planes planes;
        const auto fill = [&](std::vector<double>& axis, double begin, double end, double step) {
          const int count = static_cast<int>(std::lround((end - begin) / step));
          for (int i = 0; i <= count; ++i) axis.push_back(begin + (end - begin) * i / count);
        };
        fill(planes[0], 5.0 * (number - 1), 5.0 * number, cell);
        fill(planes[1], 0, 2, cell / number);
        fill(planes[2], 0, 1, cell / number);
        index.meshes.push_back({planes, {}, {}});
        const fdswriter::Slice slice{whole(planes)};
        const auto even = [](auto...) { return kK; };
        const auto values = cellCentred ? fdswriter::inCells(planes, slice.at, even, 777.0F)
                                        : fdswriter::atNodes(planes, slice.at, even);
        const std::string name = fmt::format("made_{}.sf", number);
        fdswriter::sliceFile(slice, {{0, values}}).save(folder / name);
        index.slice(number, slice, name, cellCentred);
      }
      index.save(folder / "made.smv");
      FdsCase read = opened(folder / "made.smv");
      const FdsField field = fieldAt(read, 0);
      for (int i = 0; i < 60; ++i) {
        const Vec3 direction = Vec3(normal(random), normal(random), normal(random)).normalized();
        const double distance = 0.1 + 0.2 * i;
        const Segment line{Vec3(5.01, 1.02, 0.49) - 0.5 * distance * direction, direction, 0,
                           distance};
        const Interval inside = read.bounds().intersect(line.origin, direction);
        const double length =
            std::max(0.0, std::min(inside.end, distance) - std::max(inside.begin, 0.0));
        Radiance seen;
        field.radiance({&line, 1}, {&seen, 1});
        EXPECT_NEAR(255 * seen.transmittance, 255 * std::exp(-kK * length), kBar)
            << cell << ' ' << distance;
      }
      // Along the meshes, at the distances of FDS's verification case.
      for (double distance = 0.9; distance < 9; distance += 1) {
        const Segment line = between({0, 1, 0.5}, {distance, 1, 0.5});
        Radiance seen;
        field.radiance({&line, 1}, {&seen, 1});
        EXPECT_NEAR(255 * seen.transmittance, 255 * std::exp(-kK * distance), kBar);
      }
    }
  }
}

TEST(FdsCase, cellsAreConstantAndGhostsAreDropped) {
  const ScratchFolder folder;
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
  MadeCase made;
  // Cell 2 on z lies between 0.3 and 0.5, not at node 2.
  const fdswriter::Slice cells{{0, 5, 0, 4, 2, 2}};
  made.add(cells, "cells.sf", {{0, fdswriter::inCells(kFirst, cells.at, linear, 777.0F)}}, true);
  FdsCase read = made.open();
  const FdsField field = fieldAt(read, 0);
  EXPECT_EQ(field.bounds().min.z(), 0.3);
  EXPECT_EQ(field.bounds().max.z(), 0.5);
  EXPECT_NEAR(field.extinction({0.5, 0.5, 0.31}), linear(0.5, 0.5, 0.4), 1e-6);
  EXPECT_LT(depthOf(field, between({0.1, 0.1, 0.4}, {0.9, 0.7, 0.4})).uncovered, 1e-12);
  const FdsDepth leaving = depthOf(field, between({0.1, 0.1, 0.2}, {0.9, 0.1, 0.4}));
  EXPECT_NEAR(leaving.uncovered, 0.5 * Vec3(0.8, 0, 0.2).norm(), 1e-12);
}

TEST(FdsCase, aSliceOfNodesIsALayerRoundThem) {
  MadeCase made;
  const fdswriter::Slice nodes{{0, 5, 0, 4, 2, 2}};
  made.add(nodes, "nodes.sf", {{0, fdswriter::atNodes(kFirst, nodes.at, linear)}});
  FdsCase read = made.open();
  EXPECT_EQ(read.source().name, "slice-extinction");
  const FdsField field = fieldAt(read, 0);
  EXPECT_NEAR(field.bounds().min.z(), 0.4, 1e-12);
  EXPECT_NEAR(field.bounds().max.z(), 0.55, 1e-12);
  const Segment line = between({0.1, 0.1, 0.45}, {0.9, 0.7, 0.54});
  EXPECT_NEAR(depthOf(field, line).value,
              0.5 * (linear(0.1, 0.1, 0.5) + linear(0.9, 0.7, 0.5)) * line.end, 1e-6);
  FdsOptions volume;
  volume.volume = true;
  const auto none = FdsCase::open(made.folder / "made.smv", volume);
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().message, HasSubstr("layers only (slice-extinction)"));
}

TEST(FdsCase, theBestSourceIsTakenAndOthersByName) {
  MadeCase made;
  const auto save = [&](const std::string& quantity, const std::string& unit, double value) {
    fdswriter::Slice slice{whole(kFirst), quantity, "short", unit};
    const std::string name = fmt::format("{}.sf", value);
    made.add(slice, name,
             {{0, fdswriter::atNodes(kFirst, slice.at, [&](auto...) { return value; })}});
  };
  save("SOOT VISIBILITY", "m", 6);
  save("SOOT DENSITY", "kg/m3", 1e-4);
  save("SOOT OPTICAL DENSITY", "1/m", 0.3);
  save("SOOT EXTINCTION COEFFICIENT", "1/m", 0.7);
  const Segment line = between({0, 0.4, 0.4}, {1, 0.4, 0.4});
  FdsOptions options;
  for (const auto& [name, expected] : std::vector<std::pair<std::string, double>>{
           {"", 0.7},
           {"slice3d-extinction", 0.7},
           {"slice3d-optical-density", 0.3 * std::log(10.0)},
           {"slice3d-soot-density", 0.87},
           {"slice3d-visibility", 0.5}}) {
    options.source = name;
    FdsCase read = made.open(options);
    EXPECT_NEAR(depthOf(fieldAt(read, 0), line).value, expected, 1e-6) << name;
  }
  options.source = "slice3d-smoke";
  const auto unknown = FdsCase::open(made.folder / "made.smv", options);
  ASSERT_FALSE(unknown);
  EXPECT_THAT(unknown.error().message,
              HasSubstr("the case has slice3d-extinction, slice3d-optical-density, "
                        "slice3d-soot-density, slice3d-visibility"));
}

/// Extinction in nodes at `times` as a 3D slice, and bytes at `more`.
void saveSliceAndBytes(const ScratchFolder& folder, const std::vector<float>& times,
                       const std::vector<float>& more, const std::string& smoke = "SOOT DENSITY",
                       bool slices = true) {
  fdswriter::Index index;
  index.meshes.push_back({kFirst, {}, {}});
  const fdswriter::Slice slice{whole(kFirst)};
  std::vector<std::pair<float, std::vector<float>>> frames;
  for (const float time : times)
    frames.emplace_back(time, fdswriter::atNodes(kFirst, slice.at, linear));
  std::vector<std::pair<float, std::vector<std::uint8_t>>> bytes;
  for (const float time : more)
    bytes.emplace_back(time, std::vector<std::uint8_t>(frames.front().second.size(), 50));
  fdswriter::sliceFile(slice, frames).save(folder / "made.sf");
  fdswriter::smokeFile(cellsOf(kFirst), bytes).save(folder / "made.s3d");
  if (slices)
    index.slice(1, slice, "made.sf", false);
  index.smoke(1, "made.s3d", 7600);
  index.files.replace(index.files.find("SOOT DENSITY"), 12, smoke);
  index.save(folder / "made.smv");
}

TEST(FdsCase, manyTimesGoBeforeExactValuesAtFew) {
  const std::vector<float> few{0, 30, 60}, some{0, 15, 30, 45, 60}, many{0, 10, 20, 30, 40, 50, 60};
  const ScratchFolder folder;
  saveSliceAndBytes(folder, few, many);
  const FdsCase bytes = opened(folder / "made.smv");
  EXPECT_EQ(bytes.source().name, "s3d");
  EXPECT_THAT(sentences(bytes.remarks()),
              testing::Contains(testing::HasSubstr(
                  "s3d (7 stored times): it has 7 stored times, "
                  "slice3d-extinction only 3; the case also has slice3d-extinction")));
  EXPECT_EQ(opened(folder / "made.smv", {.source = "slice3d-extinction"}).times().size(), 3U);
  saveSliceAndBytes(folder, few, some);
  const FdsCase floats = opened(folder / "made.smv");
  EXPECT_EQ(floats.source().name, "slice3d-extinction") << "fewer than twice as many";
  EXPECT_THAT(sentences(floats.remarks()),
              testing::Contains(testing::HasSubstr("the most precise")));
}

TEST(FdsCase, aSourceWhoseFileIsMissingIsNotPassedOverInSilence) {
  const ScratchFolder folder;
  saveSliceAndBytes(folder, {0}, {0, 1, 2, 3});
  std::filesystem::remove(folder / "made.sf");
  const auto result = FdsCase::open(folder / "made.smv");
  ASSERT_FALSE(result);
  EXPECT_THAT(result.error().message, testing::HasSubstr("made.sf"));
}

TEST(FdsCase, theSmokeOfSpeciesIsToldApart) {
  for (const bool sootFirst : {true, false}) {
    MadeCase one;
    for (const bool soot : {sootFirst, !sootFirst}) {
      const fdswriter::Slice slice{
          whole(kFirst), soot ? "SOOT EXTINCTION COEFFICIENT" : "ACETONE EXTINCTION COEFFICIENT"};
      one.add(slice, soot ? "soot.sf" : "acetone.sf",
              {{0, fdswriter::atNodes(kFirst, slice.at, [&](auto...) { return soot ? 0.1 : 5; })}});
    }
    FdsCase soot = one.open();
    EXPECT_EQ(soot.source().name, "slice3d-extinction");
    EXPECT_NEAR(fieldAt(soot, 0).extinction({0.5, 0.5, 0.2}), 0.1, 1e-6);
    EXPECT_THAT(sentences(soot.remarks()),
                testing::Contains(HasSubstr("only the smoke of SOOT is seen; that of ACETONE")));
    FdsCase acetone = one.open({.source = "slice3d-extinction-acetone"});
    EXPECT_NEAR(fieldAt(acetone, 0).extinction({0.5, 0.5, 0.2}), 5, 1e-6);
    EXPECT_THAT(sentences(acetone.remarks()),
                testing::Contains(HasSubstr("only the smoke of ACETONE is seen; that of SOOT")));
  }
}

TEST(FdsCase, anySmokeWithAMassExtinctionIsSeen) {
  const ScratchFolder folder;
  saveSliceAndBytes(folder, {0}, {0}, "ASH DENSITY", false);
  FdsCase read = opened(folder / "made.smv");
  EXPECT_EQ(read.source().name, "s3d");
  EXPECT_THAT(read.source().description, testing::HasSubstr("ASH DENSITY"));
  // Bytes of opacity: K = -ln(1 - b / 254) / dx whatever the mass extinction.
  const FdsDepth depth = depthOf(fieldAt(read, 0), between({0.2, 0.4, 0.3}, {0.8, 0.4, 0.3}));
  EXPECT_NEAR(depth.value, 0.6 * -std::log1p(-50 / 254.0) / 0.2, 1e-5);
}

TEST(FdsCase, visibilityAtItsCapSaysOnlyHowThickSmokeIsAtMost) {
  MadeCase made;
  fdswriter::Slice slice{whole(kFirst), "SOOT VISIBILITY", "VIS", "m"};
  made.add(slice, "v.sf",
           {{0, fdswriter::atNodes(kFirst, slice.at, [](auto...) { return 30.0; })}});
  FdsCase read = made.open();
  EXPECT_THAT(sentences(read.remarks()), ElementsAre(HasSubstr("visibility is cut at 30 m")));
  const FdsDepth depth = depthOf(fieldAt(read, 0), between({0, 0.4, 0.4}, {1, 0.4, 0.4}));
  EXPECT_EQ(depth.low, 0);
  EXPECT_NEAR(depth.value, 0.1, 1e-6);
  EXPECT_GE(depth.high, depth.value);
}

/// A case with VISIBILITY of `value` at all nodes, and 7 at the corner.
fdswriter::Index visibilityOf(const ScratchFolder& folder, float value) {
  fdswriter::Index index;
  index.meshes.push_back({kFirst, {}, {}});
  fdswriter::Slice slice{whole(kFirst), "SOOT VISIBILITY", "VIS", "m"};
  auto values = fdswriter::atNodes(kFirst, slice.at, [&](auto...) { return value; });
  values.back() = 7;
  fdswriter::sliceFile(slice, {{0, values}}).save(folder / "v.sf");
  index.slice(1, slice, "v.sf", false);
  index.input = "made.fds";
  return index;
}

TEST(FdsCase, visibilityHasTheFactorAndCapOfTheInput) {
  const ScratchFolder folder;
  visibilityOf(folder, 50).save(folder / "made.smv");
  const auto line = between({0, 0.4, 0.4}, {1, 0.4, 0.4});
  {
    FdsCase read = opened(folder / "made.smv");
    EXPECT_THAT(sentences(read.remarks()),
                ElementsAre(AllOf(HasSubstr("C = 3 (FDS's default: no input file is read"),
                                  HasSubstr("cut at 50 m (the largest value"))));
    EXPECT_EQ(depthOf(fieldAt(read, 0), line).low, 0) << "50 m is this case's cap";
  }
  fdswriter::saveText(folder / "made.fds",
                      "&HEAD CHID='made' /\n&MISC VISIBILITY_FACTOR=8, MAXIMUM_VISIBILITY=100 /\n");
  FdsCase read = opened(folder / "made.smv");
  EXPECT_THAT(sentences(read.remarks()),
              ElementsAre(AllOf(HasSubstr("C = 8 (VISIBILITY_FACTOR of made.fds)"),
                                HasSubstr("cut at 100 m (MAXIMUM_VISIBILITY of"))));
  EXPECT_NEAR(depthOf(fieldAt(read, 0), line).value, 8.0 / 50, 1e-6);
  EXPECT_NEAR(depthOf(fieldAt(read, 0), line).low, 8.0 / 50, 1e-6);
  FdsOptions options;
  options.visibilityFactor = 3;
  FdsCase stated = opened(folder / "made.smv", options);
  EXPECT_THAT(sentences(stated.remarks()),
              ElementsAre(HasSubstr("C = 3 (as stated, although made.fds says 8)")));
  fdswriter::saveText(folder / "made.fds", "&HEAD CHID='made' /\n&MISC VISIBILITY_FACTOR=0 /\n");
  EXPECT_THAT(sentences(opened(folder / "made.smv").remarks()),
              testing::Contains(HasSubstr("C = 3 (FDS's default: no input file is read that says")))
      << "it is there, and refused";
}

TEST(FdsCase, theMassExtinctionOfSootIsTold) {
  const ScratchFolder folder;
  fdswriter::Index index;
  index.meshes.push_back({kFirst, {}, {}});
  const fdswriter::Slice slice{whole(kFirst), "SOOT DENSITY", "rho", "kg/m3"};
  fdswriter::sliceFile(slice,
                       {{0, fdswriter::atNodes(kFirst, slice.at, [](auto...) { return 1e-4; })}})
      .save(folder / "r.sf");
  index.slice(1, slice, "r.sf", false);
  index.input = "made.fds";
  index.save(folder / "made.smv");
  const auto told = [&](const std::string& reactions, const FdsOptions& options = {}) {
    if (!reactions.empty())
      fdswriter::saveText(folder / "made.fds", "&HEAD CHID='made' /\n" + reactions);
    const FdsCase read = opened(folder / "made.smv", options);
    const auto remarks = read.remarks();
    EXPECT_EQ(remarks.size(), 1U);
    return Remark(remarks.front());
  };
  const auto is = [](RemarkCode code, const std::string& text) {
    return AllOf(::testing::Field(&Remark::code, code),
                 ::testing::Field(&Remark::sentence, HasSubstr(text)));
  };
  EXPECT_THAT(told(""),
              is(RemarkCode::kAssumed, "soot is 8700 m2/kg (FDS's default: no input file is read"));
  const std::string one = "&REAC FUEL='A', MASS_EXTINCTION_COEFFICIENT=4000 /\n";
  EXPECT_THAT(told("&REAC FUEL='A' /\n"), is(RemarkCode::kNote, "8700 m2/kg (FDS's default)"));
  EXPECT_THAT(told(one), is(RemarkCode::kNote, "4000 m2/kg (MASS_EXTINCTION_COEFFICIENT of made"));
  EXPECT_THAT(told(one + one), is(RemarkCode::kNote, "4000 m2/kg"));
  EXPECT_THAT(told(one + "&REAC FUEL='B', MASS_EXTINCTION_COEFFICIENT=8000 /\n"),
              is(RemarkCode::kDoubtful, "which says 4000 in another line"));
  EXPECT_THAT(told(one, {.massExtinction = 7600}),
              is(RemarkCode::kNote, "7600 m2/kg (as stated, although made.fds says 4000)"));
}

TEST(FdsCase, negativeExtinctionIsNoClearAir) {
  for (const double k : {-1e-6, -0.2}) {
    MadeCase made;
    const fdswriter::Slice slice{whole(kFirst)};
    made.add(slice, "k.sf",
             {{3, fdswriter::atNodes(kFirst, slice.at, [&](auto...) { return k; })}});
    FdsCase read = made.open();
    const auto field = read.field(3);
    EXPECT_EQ(field.has_value(), k > -1e-4);
    if (!field) {
      EXPECT_THAT(field.error().message,
                  HasSubstr("k.sf: frame 0 (t = 3 s): value 0 is -0.2, in gas; "
                            "expected 0 or more"));
    }
  }
}

TEST(FdsCase, meshesThatFdsConnectsAreOne) {
  for (const double gap : {0.0, 2e-5, 9e-4, 4e-3}) {
    const ScratchFolder folder;
    fdswriter::Index index;
    auto second = kSecond;
    for (double& x : second[0]) x += gap;
    int number = 0;
    for (const Planes& planes : {kFirst, second}) {
      index.meshes.push_back({planes, {}, {}});
      const fdswriter::Slice slice{whole(planes)};
      const std::string file = fmt::format("k_{}.sf", ++number);
      fdswriter::sliceFile(slice,
                           {{0, fdswriter::atNodes(planes, slice.at, [](auto...) { return 1; })}})
          .save(folder / file);
      index.slice(number, slice, file, false);
    }
    index.save(folder / "made.smv");
    FdsCase read = opened(folder / "made.smv");
    const FdsDepth depth = depthOf(fieldAt(read, 0), between({0.5, 0.4, 0.4}, {1.5, 0.4, 0.4}));
    EXPECT_EQ(depth.uncovered == 0, gap <= 1e-3) << gap;
    if (gap > 1e-3) {
      EXPECT_THAT(sentences(read.remarks()), ElementsAre(HasSubstr("1 and 2 by 4 mm on x")));
    } else {
      EXPECT_NEAR(depth.value, 1, 1e-6) << gap;
      EXPECT_TRUE(read.remarks().empty());
    }
  }
}

TEST(FdsCase, withoutSmokeItIsClearWhereThatIsAskedFor) {
  MadeCase made({{1, 4, 1, 3, 0, 3}});
  fdswriter::Slice slice{whole(kFirst), "TEMPERATURE", "temp", "C"};
  const auto values = fdswriter::atNodes(kFirst, slice.at, [](auto...) { return 20; });
  made.add(slice, "t.sf", {{0, values}, {5, values}});
  made.index.save(made.folder / "made.smv");
  EXPECT_EQ(FdsCase::open(made.folder / "made.smv").error().code, ErrorCode::kNotFound);
  FdsOptions options;
  options.orClear = true;
  FdsCase read = opened(made.folder / "made.smv", options);
  EXPECT_THAT(read.times(), ElementsAre(0, 5));
  const FdsDepth depth = depthOf(fieldAt(read, 5), between({0, 0.7, 0.4}, {1, 0.7, 0.4}));
  EXPECT_EQ(depth.value, 0);
  EXPECT_EQ(depth.uncovered, 0);
}

TEST(FdsCase, solidsNeverReachTheirNeighbours) {
  // FDS writes the ambient value at nodes inside walls: soot of 1.2 kg/m3.
  MadeCase made({{1, 4, 1, 3, 0, 3}});
  fdswriter::Slice slice{whole(kFirst), "SOOT DENSITY", "rho", "kg/m3"};
  const auto inside = [](double x, double y, double) { return x > 0.3 && x < 0.7 && y == 0.4; };
  const auto soot = [&](double x, double y, double z) { return inside(x, y, z) ? 1.195 : 1e-4; };
  made.add(slice, "a.sf", {{0, fdswriter::atNodes(kFirst, slice.at, soot)}});
  FdsCase read = made.open();
  const FdsDepth depth = depthOf(fieldAt(read, 0), between({0, 0.4, 0.3}, {1, 0.4, 0.3}));
  EXPECT_NEAR(depth.insideSolids, 0.6, 1e-9);
  EXPECT_NEAR(depth.value, 0.4 * 0.87, 1e-6);
}

TEST(FdsCase, aDoorOpensTheLineOfSightAtItsTime) {
  MadeCase made({{2, 3, 0, 4, 0, 3}, {4, 4, 0, 4, 0, 3}});
  fdswriter::Slice slice{whole(kFirst)};
  const auto frame = [&](double gas, double door) {
    return fdswriter::inCells(
        kFirst, slice.at, [&](double x, double, double) { return x > 0.4 && x < 0.6 ? door : gas; },
        0.0F);
  };
  made.add(slice, "a.sf", {{0, frame(1, 999)}, {10, frame(1, 999)}, {20, frame(1, 5)}}, true);
  made.index.event("HIDE_OBST", 1, 1, 12.5);
  made.index.event("HIDE_OBST", 1, 2, 12.5);
  made.index.event("SHOW_OBST", 1, 2, 15);
  FdsCase read = made.open();
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
  MadeCase made({{2, 3, 0, 4, 0, 3}});
  fdswriter::Slice slice{whole(kFirst)};
  const auto values = fdswriter::inCells(kFirst, slice.at, linear, 0.0F);
  made.add(slice, "a.sf", {{0, values}}, true);
  made.index.event("HIDE_OBST", 1, 1, 5);
  FdsCase read = made.open();
  EXPECT_NEAR(depthOf(fieldAt(read, 5), between({0, 0.4, 0.3}, {1, 0.4, 0.3})).uncovered, 0.2,
              1e-12);
}

TEST(FdsCase, aRunningCaseIsReadAsFarAsAllItsFilesGo) {
  const ScratchFolder folder;
  saveSlices(folder, false, 2, linear);
  std::filesystem::resize_file(folder / "made_2_1.sf",
                               std::filesystem::file_size(folder / "made_2_1.sf") - 9);
  const FdsCase read = opened(folder / "made.smv");
  EXPECT_THAT(read.times(), ElementsAre(0));
  EXPECT_THAT(sentences(read.remarks()), Contains(HasSubstr("within frame 1 that begins at byte")));
  EXPECT_THAT(sentences(read.remarks()),
              Contains(HasSubstr("1 of 2 stored times are left out (10 to 10 s)")));
}

TEST(FdsCase, aMeshThatEndsBetweenFramesIsNamedWhicheverItIs) {
  for (const int mesh : {1, 2}) {
    const ScratchFolder folder;
    saveSlices(folder, false, 2, linear);
    const auto file = folder / fmt::format("made_{}_1.sf", mesh);
    const auto header = 3 * (30 + 8) + (6 * 4 + 8);
    std::filesystem::resize_file(file, header + (std::filesystem::file_size(file) - header) / 2);
    const FdsCase read = opened(folder / "made.smv");
    EXPECT_THAT(read.times(), ElementsAre(0));
    EXPECT_THAT(sentences(read.remarks()), Contains(HasSubstr("1 of 2 stored times are left out")));
    EXPECT_THAT(
        sentences(read.remarks()),
        Contains(HasSubstr(fmt::format("made_{0}_1.sf (mesh {0}) has 1, the last at 0 s", mesh))));
  }
}

// Where one mesh's file ends earlier, or begins later, the others go on, and nothing is known
// there.
TEST(FdsCase, aMeshThatEndsEarlierIsUnknownWhereThatIsAskedFor) {
  const Segment first = between({0, 0.4, 0.3}, {1, 0.4, 0.3});
  const Segment second = between({1.01, 0.4, 0.3}, {1.9, 0.4, 0.3});
  for (const int mesh : {1, 2}) {
    const ScratchFolder folder;
    saveSlices(folder, false, 2, linear);
    const auto file = folder / fmt::format("made_{}_1.sf", mesh);
    const auto header = 3 * (30 + 8) + (6 * 4 + 8);
    std::filesystem::resize_file(file, header + (std::filesystem::file_size(file) - header) / 2);
    FdsCase read = opened(folder / "made.smv", {.partly = true});
    EXPECT_THAT(read.times(), ElementsAre(0, 10));
    EXPECT_FALSE(read.isWhole());
    EXPECT_THAT(sentences(read.leftOut()),
                Contains(HasSubstr(
                    fmt::format("is stored from 0 to 10 s, but not known after 0 s in mesh {0} "
                                "(made_{0}_1.sf)",
                                mesh))));
    const Segment &cut = mesh == 1 ? first : second, &whole = mesh == 1 ? second : first;
    const double length = cut.end - cut.begin;
    for (const auto& [time, unknown] : {std::pair{0.0, 0.0}, {0.5, length}, {10, length}}) {
      const FdsField field = fieldAt(read, time);
      EXPECT_NEAR(depthOf(field, cut).uncovered, unknown, 1e-9) << time;
      EXPECT_EQ(depthOf(field, whole).uncovered, 0) << time;
      EXPECT_GT(depthOf(field, whole).value, 0) << time;
      const std::size_t number = static_cast<std::size_t>(mesh) - 1;
      EXPECT_EQ(read.knows(number, time), unknown == 0) << time;
      EXPECT_TRUE(read.knows(1 - number, time)) << time;
    }
    EXPECT_NEAR(depthOf(fieldAt(read, 0), cut).uncovered, 0, 1e-9) << "back to what is known";
  }
}

TEST(FdsCase, aMissingFileLeavesItsMeshUnknownWhereThatIsAskedFor) {
  const ScratchFolder folder;
  saveSlices(folder, false, 2, linear);
  std::filesystem::remove(folder / "made_2_1.sf");
  EXPECT_FALSE(FdsCase::open(folder / "made.smv"));
  const FdsCase read = opened(folder / "made.smv", {.partly = true});
  EXPECT_THAT(read.times(), ElementsAre(0, 10));
  EXPECT_THAT(sentences(read.leftOut()),
              Contains(AllOf(HasSubstr("made_2_1.sf"), HasSubstr("made.smv names it for mesh 2: "
                                                                 "what it holds is not known"))));
  std::filesystem::remove(folder / "made_1_1.sf");
  EXPECT_FALSE(FdsCase::open(folder / "made.smv", {.partly = true})) << "nothing is left";
}

TEST(FdsCase, aMeshWithoutAWholeFrameIsLeftOutAndNamed) {
  const ScratchFolder folder;
  saveSlices(folder, false, 2, linear);
  std::filesystem::resize_file(folder / "made_2_1.sf", 200);
  const FdsCase read = opened(folder / "made.smv");
  EXPECT_THAT(read.times(), ElementsAre(0, 10));
  EXPECT_THAT(sentences(read.remarks()), Contains(HasSubstr("does not cover 1 of 2 meshes (2)")));
}

TEST(FdsCase, valuesThatAreNoNumbersAreRefusedWhereThereIsGas) {
  const ScratchFolder folder;
  saveSlices(folder, false, 1, [](double x, double y, double z) {
    return x == 1 && y == 0.4 && z == 0.5 ? std::nan("") : 1.0;
  });
  FdsCase read = opened(folder / "made.smv");
  const auto field = read.field(0);
  ASSERT_FALSE(field);
  EXPECT_THAT(field.error().message, HasSubstr("frame 0 (t = 0 s): value"));
}

TEST(FdsCase, memoryIsBounded) {
  const ScratchFolder folder;
  saveSlices(folder, false, 1, linear);
  FdsOptions options;
  options.maxMemory = 1000;
  const auto read = FdsCase::open(folder / "made.smv", options);
  ASSERT_FALSE(read);
  EXPECT_EQ(read.error().code, ErrorCode::kTooLarge);
}

TEST(FdsCase, aMeshThatIsTooLargeIsRefusedBeforeItIsBuilt) {
  // A slice of four values in a mesh of 7e11 cells: the index alone says so.
  const ScratchFolder folder;
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
  MadeCase made;
  for (const double time : {1.0, 3.0}) {
    std::vector<float> five;
    for (int v = 0; v < 5; ++v) {
      const auto values = fdswriter::atNodes(
          kFirst, whole(kFirst),
          [&](double x, double y, double z) { return v == 1 ? time * linear(x, y, z) : -9.0; });
      five.insert(five.end(), values.begin(), values.end());
    }
    const std::string name = fmt::format("made_1_{}p00.q", time);
    fdswriter::plotFile(cellsOf(kFirst), five).save(made.folder / name);
    made.index.plot(1, time, name, "SOOT EXTINCTION COEFFICIENT");
  }
  FdsCase read = made.open();
  EXPECT_EQ(read.source().name, "plot3d-extinction");
  EXPECT_THAT(read.times(), ElementsAre(1, 3));
  EXPECT_NEAR(fieldAt(read, 2).extinction({0.5, 0.5, 0.2}), 2 * linear(0.5, 0.5, 0.2), 1e-5);
}

TEST(FdsCase, eachPlot3dFileSaysItselfWhereAQuantityIs) {
  MadeCase made;
  const auto add = [&](double time, const std::array<std::string, 5>& labels, std::size_t smoke) {
    std::vector<float> five;
    for (std::size_t v = 0; v < 5; ++v)
      five.insert(five.end(), 6 * 5 * 4, static_cast<float>(v == smoke ? time : -9));
    const std::string name = fmt::format("made_1_{}p00.q", time);
    fdswriter::plotFile(cellsOf(kFirst), five).save(made.folder / name);
    made.index.files += fmt::format("PL3D {:11.2f}{:6}\n {}\n", time, 1, name);
    for (const std::string& label : labels) made.index.files += label;
  };
  const std::string smoke = " SOOT EXTINCTION COEFFICIENT\n ext\n 1/m\n",
                    other = " TEMPERATURE\n temp\n C\n", kelvin = " TEMPERATURE\n temp\n K\n";
  add(1, {other, smoke, other, other, other}, 1);
  add(2, {smoke, other, other, other, other}, 0);
  add(3, {other, other, other, other, smoke}, 4);
  FdsCase read = made.open();
  EXPECT_THAT(read.times(), ElementsAre(1, 2, 3));
  for (const double time : {1.0, 2.0, 3.0})
    EXPECT_NEAR(fieldAt(read, time).extinction({0.5, 0.5, 0.2}), time, 1e-6);
  EXPECT_THAT(read.leftOut(), testing::IsEmpty());
  add(4, {kelvin, kelvin, kelvin, kelvin, kelvin}, 4);
  EXPECT_THAT(sentences(made.open().leftOut()),
              ElementsAre(HasSubstr("1 of 4 PLOT3D files have no SOOT EXTINCTION COEFFICIENT in "
                                    "1/m, and are left out (the first is made_1_4p00.q, of 4 s)")));
  EXPECT_THAT(sentences(made.open({.quantity = "TEMPERATURE"}).leftOut()),
              ElementsAre(HasSubstr("1 of 4 PLOT3D files have no TEMPERATURE in C")));
}

}  // namespace
}  // namespace volute
