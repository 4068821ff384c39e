// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/smv_index.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "volute/fds/fds_building.hpp"
#include "volute/fds/fds_case_testing.hpp"
#include "volute/fds/fds_input.hpp"
#include "volute/fds/obstructions.hpp"

namespace volute {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

const fdswriter::Planes kIndexPlanes{{{0, 1, 3}, {0, 1, 2}, {0, 0.5, 1}}};

fdswriter::Index made() {
  fdswriter::Index index;
  index.meshes.push_back(
      {kIndexPlanes, {{0, 1, 0, 2, 0, 1}, {1, 1, 0, 2, 0, 2}}, {{2, 2, 0, 2, 0, 2}}});
  index.meshes.push_back({{{{3, 4}, {0, 1, 2}, {0, 0.5, 1}}}, {}, {}});
  index.slice(1, {{0, 2, 0, 2, 1, 1}}, "made_1_1.sf", false);
  index.slice(2, {{0, 1, 0, 2, 1, 1}}, "made_2_1.sf", true);
  index.smoke(1, "made_1_1.s3d", 7600);
  index.plot(2, 10.06, "made_2_10p06.q", "TEMPERATURE");
  index.event("HIDE_OBST", 1, 2, 30);
  index.files += "DEVICE\n exit sign % VISIBILITY\n 1.0 2.0 3.0 0 0 -1 0 0\n";
  return index;
}

Result<SmvIndex> readText(const ScratchFolder& folder, const std::string& text) {
  fdswriter::saveText(folder / "made.smv", text);
  return SmvIndex::read(folder / "made.smv");
}

TEST(SmvIndex, leavesOutMeshesOfEvacuation) {
  const ScratchFolder folder;
  fdswriter::Index index;
  index.meshes.push_back({kIndexPlanes, {{0, 1, 0, 2, 0, 1}}, {}, true});
  index.meshes.push_back({kIndexPlanes, {}, {}, false});
  index.slice(1, {{0, 2, 0, 2, 1, 1}}, "people.sf", false);
  index.slice(2, {{0, 2, 0, 2, 1, 1}}, "smoke.sf", false);
  const auto read = readText(folder, index.text());
  ASSERT_TRUE(read) << read.error().message;
  ASSERT_THAT(read->meshes, SizeIs(1));
  EXPECT_TRUE(read->meshes[0].obstructions.empty());
  ASSERT_THAT(read->slices, SizeIs(1));
  EXPECT_EQ(read->slices[0].mesh, 0);
  EXPECT_EQ(read->slices[0].file.filename(), "smoke.sf");
  EXPECT_THAT(sentences(read->remarks), ElementsAre(HasSubstr("1 of 2 meshes are of FDS+Evac")));
  // Versions that name neighbours there have no such mark.
  std::string later = index.text();
  for (const char* mark : {"    1\n\nPDIM", "    0\n\nPDIM"})
    later.replace(later.find(mark), 5, "    1    2    0    0    0    0");
  EXPECT_THAT(readText(folder, later)->meshes, SizeIs(2));
  index.meshes.pop_back();
  index.files.clear();
  EXPECT_THAT(readText(folder, index.text()).error().message, HasSubstr("without gas"));
}

TEST(SmvIndex, aFileIsOfOneMesh) {
  const ScratchFolder folder;
  fdswriter::Index index = made();
  index.slice(1, {{0, 2, 0, 2, 1, 1}}, "made_2_1.sf", false);
  EXPECT_THAT(readText(folder, index.text()).error().message,
              HasSubstr("expected a file of mesh 1 alone; made_2_1.sf is that of mesh 2 already"));
}

TEST(SmvIndex, findsFilesThatWindowsNamed) {
  const ScratchFolder folder;
  std::filesystem::create_directory(folder / "Results");
  fdswriter::saveText(folder / "Results/MADE_1.SF", "");
  fdswriter::saveText(folder / "Results/a.sf", "");
  fdswriter::saveText(folder / "Results/A.sf", "");
  fdswriter::Index index = made();
  index.files.clear();
  index.slice(1, {{0, 2, 0, 2, 1, 1}}, "results\\made_1.sf", false);
  index.slice(1, {{0, 2, 0, 2, 1, 1}}, "results\\a.sf", false);
  index.slice(1, {{0, 2, 0, 2, 1, 1}}, "results\\A.SF", false);
  const auto read = readText(folder, index.text());
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->slices[0].file, folder / "Results/MADE_1.SF");
  EXPECT_EQ(read->slices[1].file, folder / "Results/a.sf");
  EXPECT_EQ(read->slices[2].file.filename(), "results\\A.SF")
      << "two could be meant: it is missing";
  EXPECT_THAT(sentences(read->remarks),
              ElementsAre(HasSubstr("2 names differ from those of the files")));
}

TEST(SmvIndex, readsTheInputThatItNames) {
  const ScratchFolder folder;
  fdswriter::Index index = made();
  index.input = "made.fds";
  EXPECT_TRUE(inputOf(*readText(folder, index.text())).path.empty()) << "a case without it is read";
  fdswriter::saveText(folder / "made.fds", "&HEAD CHID='made' /\n&MISC VISIBILITY_FACTOR=8 /\n");
  EXPECT_EQ(inputOf(*readText(folder, index.text())).visibilityFactor, 8);
  index.input = "/home/user/runs/made.fds";
  EXPECT_EQ(inputOf(*readText(folder, index.text())).visibilityFactor, 8)
      << "beside the index, if it is not where FDS was started";
  fdswriter::saveText(folder / "made.fds", "&HEAD CHID='other' /\n&MISC VISIBILITY_FACTOR=8 /\n");
  const auto other = readText(folder, index.text());
  EXPECT_FALSE(other->input);
  EXPECT_THAT(sentences(other->remarks),
              ElementsAre(HasSubstr("is the input of 'other', not of 'made'")));
}

TEST(SmvIndex, readsWhatAnyVersionWrites) {
  const ScratchFolder folder;
  const auto index = readText(folder, made().text());
  ASSERT_TRUE(index) << index.error().message;
  EXPECT_EQ(index->chid, "made");
  EXPECT_THAT(index->version, HasSubstr("6.7.5"));
  ASSERT_THAT(index->meshes, SizeIs(2));
  EXPECT_THAT(index->meshes[0].planes[0], ElementsAre(0, 1, 3));
  ASSERT_THAT(index->meshes[0].obstructions, SizeIs(2));
  EXPECT_EQ(index->meshes[0].obstructions[1].nodes, (FdsNodeBox{{1, 0, 0}, {1, 2, 2}}));
  EXPECT_EQ((*index->meshes[0].obstructions[0].colour)[1], 0.5F);
  EXPECT_TRUE(index->meshes[0].obstructions[1].shownAt(29.99));
  EXPECT_FALSE(index->meshes[0].obstructions[1].shownAt(30));
  EXPECT_TRUE(index->meshes[0].vents[0].open);
  ASSERT_THAT(index->slices, SizeIs(2));
  EXPECT_FALSE(index->slices[0].cellCentred);
  EXPECT_TRUE(index->slices[1].cellCentred);
  EXPECT_EQ(index->slices[1].mesh, 1);
  EXPECT_EQ(index->slices[1].labels.unit, "1/m");
  EXPECT_EQ(index->smoke[0].massExtinction, 7600);
  EXPECT_EQ(index->plots[0].time, 10.06);
  ASSERT_THAT(index->devices, SizeIs(1));
  EXPECT_EQ(index->devices[0].label, "exit sign");
  EXPECT_EQ(index->devices[0].quantity, "VISIBILITY");
  EXPECT_EQ(index->devices[0].position, Vec3(1, 2, 3));
  EXPECT_FALSE(index->fireCutoff);
  // FDS 6.5: no "# STRUCTURED", no mass extinction.
  auto old = made();
  old.files =
      "SLCF     1 &     0     2     0     2     1     1\n a.sf\n X\n x\n 1/m\n"
      "SMOKF3D     1\n b.s3d\n SOOT MASS FRACTION\n Y\n kg/kg\n";
  const auto older = readText(folder, old.text());
  ASSERT_TRUE(older);
  EXPECT_EQ(older->slices[0].nodes, (FdsNodeBox{{0, 0, 1}, {2, 2, 1}}));
  EXPECT_FALSE(older->smoke[0].massExtinction);
  // Smoke in a format that is not read is said, once.
  auto later = made();
  later.files =
      "SMOKH3D     1  8700.\n b.s3d\n SOOT DENSITY\n rho\n kg/m3\n"
      "SMOKH3D     1\n c.s3d\n HRRPUV\n hrrpuv\n kW/m3\n";
  const auto newer = readText(folder, later.text());
  ASSERT_TRUE(newer);
  EXPECT_THAT(newer->smoke, SizeIs(0));
  EXPECT_EQ(std::ranges::count_if(newer->remarks,
                                  [](const Remark& one) {
                                    return one.sentence.find("calls SMOKH3D") != one.sentence.npos;
                                  }),
            1);
}

TEST(SmvIndex, devicesAreActiveFromTheirEventsOn) {
  const ScratchFolder folder;
  auto text = made();
  text.files =
      "DEVICE\n detector % CHAMBER OBSCURATION\n 1 2 3 0 0 -1 0 0\n"
      "DEVICE\n door % TIME\n 1 1 1 0 0 -1 1 0\n"
      "DEVICE_ACT 1\n 1 31.5 1\n\nDEVICE_ACT 2\n 2 40 0\nDEVICE_ACT 2\n 2 35 1\n"
      "HRRPUVCUT\n 1\n 80.0\n";
  const auto index = readText(folder, text.text());
  ASSERT_TRUE(index) << index.error().message;
  ASSERT_THAT(index->devices, SizeIs(2));
  EXPECT_FALSE(index->devices[0].activeAt(31.4));
  EXPECT_TRUE(index->devices[0].activeAt(31.5));
  EXPECT_TRUE(index->devices[1].activeAt(0));
  EXPECT_TRUE(index->devices[1].activeAt(39));
  EXPECT_FALSE(index->devices[1].activeAt(40));
  EXPECT_EQ(index->fireCutoff, 80);
  text.files += "DEVICE_ACT 3\n 3 1 1\n";
  const auto wrong = readText(folder, text.text());
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().message, HasSubstr("the number of a device, 1 to 2, not 3"));
}

TEST(SmvIndex, wallsOfTrianglesAreNamedAndMissedWhereTheyAreNotThere) {
  const ScratchFolder folder;
  auto text = made();
  text.files += "GEOM 1\n made.ge\n FACE 0.0 0.0 0.0 0 ! 9 9 9 1.0 12\n";
  const auto without = readText(folder, text.text());
  ASSERT_TRUE(without) << without.error().message;
  ASSERT_THAT(without->remarks, SizeIs(2));
  EXPECT_THAT(without->remarks[0].sentence,
              HasSubstr("(GEOM) are not there: made.ge: they are not drawn"));
  EXPECT_TRUE(without->others.empty());
  fdswriter::geometryFile({}, {}, {}).save(folder / "made.ge");
  const auto with = readText(folder, text.text());
  ASSERT_THAT(with->others, SizeIs(1));
  ASSERT_THAT(with->remarks, SizeIs(1));
  EXPECT_THAT(with->remarks[0].sentence, HasSubstr("values beside such walls are less certain"));
}

TEST(SmvIndex, nodesThatDoNotReachTheEndsOfTheMeshAreRefused) {
  const ScratchFolder folder;
  std::string text = made().text();
  text.replace(text.find("0.00000 3.00000"), 15, "0.00000 3.50000");
  const auto wrong = readText(folder, text);
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().message,
              HasSubstr("mesh 1 goes from 0 to 3 m on x by its nodes (TRNX), and from 0 to 3.5 m"));
}

TEST(SmvIndex, meshesThatAreMovedAreRefused) {
  const ScratchFolder folder;
  std::string text = made().text();
  const std::size_t offset = text.find("OFFSET\n") + 7;
  text.replace(offset, text.find('\n', offset) - offset, " 5.0 0.0 0.0");
  const auto moved = readText(folder, text);
  ASSERT_FALSE(moved);
  EXPECT_THAT(moved.error().message, HasSubstr("expected an OFFSET of 0 0 0"));
}

TEST(SmvIndex, obstructionsLieWhereTheirNodesAre) {
  const ScratchFolder folder;
  fdswriter::Index index;
  const std::vector<double> planes{0, 1, 2, 3, 4, 5, 6, 7, 8};
  index.meshes.push_back({{{planes, planes, planes}}, {{1, 3, 1, 3, 0, 2}}, {}});
  std::string text = index.text();
  ASSERT_TRUE(readText(folder, text));
  const std::string right = "    1    3    1    3    0    2";
  const std::size_t indices = text.find(right);
  ASSERT_NE(indices, std::string::npos);
  text.replace(indices, right.size(), "    4    6    1    3    0    2");
  const auto elsewhere = readText(folder, text);
  ASSERT_FALSE(elsewhere);
  EXPECT_THAT(elsewhere.error().message,
              HasSubstr("an obstruction that lies where its nodes are, at x = 4 m by node 4, not "
                        "at 1 m"));
}

TEST(SmvIndex, moreObstructionsThanMemoryHoldsAreRefused) {
  const ScratchFolder folder;
  fdswriter::saveText(folder / "made.smv", made().text());
  EXPECT_TRUE(SmvIndex::read(folder / "made.smv", 10'000));
  const auto refused = SmvIndex::read(folder / "made.smv", 500);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kTooLarge);
  EXPECT_THAT(refused.error().message, HasSubstr("2 obstructions and vents need"));
}

TEST(SmvIndex, everyTruncationIsAnErrorWithinTheMeshesAndARemarkAfterThem) {
  const ScratchFolder folder;
  const std::string text = made().text();
  const std::size_t files = text.find("SLCF");
  const auto whole = readText(folder, text);
  for (std::size_t size = 0; size < text.size(); ++size) {
    const auto index = readText(folder, text.substr(0, size));
    if (size < text.rfind("\nVENT")) {
      ASSERT_FALSE(index) << size;
      continue;
    }
    if (!index) {
      EXPECT_LT(size, files);
      EXPECT_EQ(index.error().code, ErrorCode::kTruncated) << index.error().message;
      continue;
    }
    EXPECT_LE(index->slices.size(), whole->slices.size());
    for (std::size_t i = 0; i < index->slices.size(); ++i) {
      EXPECT_EQ(index->slices[i].file, whole->slices[i].file);
      EXPECT_EQ(index->slices[i].labels, whole->slices[i].labels);
    }
    const bool atLineEnd = size == 0 || text[size - 1] == '\n' ||
                           text.find_first_not_of(" ", text.rfind('\n', size - 1) + 1) >= size;
    if (!atLineEnd) {
      EXPECT_FALSE(index->remarks.empty()) << size;
    }
  }
}

TEST(SmvIndex, anyFlippedBitIsReadOrRefused) {
  const ScratchFolder folder;
  const std::string text = made().text();
  for (std::size_t bit = 0; bit < 8 * text.size(); bit += 3) {
    std::string flipped = text;
    flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ (1 << (bit % 8)));
    const auto index = readText(folder, flipped);
    if (!index) {
      EXPECT_THAT(index.error().message, HasSubstr("made.smv"));
    }
  }
}

/// A number that no int holds, where a surface is expected.
TEST(SmvIndex, surfacesHaveNumbers) {
  const ScratchFolder folder;
  for (const char* section : {"OBST", "VENT"}) {
    const std::string text = made().text();
    std::size_t line = text.find(section);
    ASSERT_NE(line, std::string::npos);
    for (int i = 0; i < 2; ++i) line = text.find('\n', line) + 1;
    const std::size_t end = text.find('\n', line);
    const auto index =
        readText(folder, text.substr(0, line) + " 0 1 0 2 0 1 1 1e72 0 0 0 0 0" + text.substr(end));
    ASSERT_FALSE(index) << section;
    EXPECT_THAT(index.error().message, HasSubstr("expected the number of a surface, not 1e+72"));
  }
}

TEST(SmvIndex, errorsNameTheLine) {
  const ScratchFolder folder;
  std::string text = made().text();
  text.replace(text.find("        1.00000"), 15, "        9.00000");
  const auto index = readText(folder, text);
  ASSERT_FALSE(index);
  EXPECT_THAT(index.error().message, HasSubstr("line 35: "));
  EXPECT_THAT(index.error().message, HasSubstr("expected the places of nodes to ascend"));
  const auto none = readText(folder, "hello\n");
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().message, HasSubstr("has no GRID"));
}

TEST(Obstructions, hideWhatLiesBehindThem) {
  const ScratchFolder folder;
  const auto index = readText(folder, made().text());
  const FdsObstructions now(*index, 0);
  EXPECT_THAT(now.boxes(), SizeIs(2));
  // Through the block, over it, to a sign on its face, along its face, through the thin wall.
  EXPECT_TRUE(now.blocked(between({-1, 1, 0.25}, {2, 1, 0.25})));
  EXPECT_TRUE(now.blocked(between({0.5, 1, 0.75}, {2, 1, 0.75})));  // the thin wall
  const FdsObstructions later(*index, 30);
  EXPECT_FALSE(later.blocked(between({0.5, 1, 0.75}, {2, 1, 0.75})));
  EXPECT_FALSE(later.blocked(between({2.5, 1, 0.9}, {1, 1, 0.25})));
  EXPECT_TRUE(later.blocked(between({2.5, 1, 0.9}, {0.99, 1, 0.25})));
  EXPECT_TRUE(later.blocked(between({-1, 0.5, 0.5}, {2, 0.5, 0.5})));
  EXPECT_FALSE(later.blocked(between({2, 0, 0.1}, {2, 2, 0.1})));
}

TEST(Obstructions, manyAreFoundAsOneByOne) {
  fdswriter::Index index;
  fdswriter::Planes planes;
  for (auto& axis : planes) {
    for (int i = 0; i <= 20; ++i) axis.push_back(0.1 * i);
  }
  std::srand(4);
  std::vector<fdswriter::Indices> all;
  for (int i = 0; i < 60; ++i) {
    const int x = std::rand() % 18, y = std::rand() % 18, z = std::rand() % 18;
    all.push_back({x, x + std::rand() % 3, y, y + std::rand() % 3, z, z + std::rand() % 3});
  }
  index.meshes.push_back({planes, all, {}});
  const ScratchFolder folder;
  const auto read = readText(folder, index.text());
  const FdsObstructions many(*read, 0);
  std::vector<Segment> lines;
  for (int i = 0; i < 300; ++i) {
    const auto coordinate = [] { return 2.0 * std::rand() / RAND_MAX; };
    lines.push_back(between({coordinate(), coordinate(), coordinate()},
                            {coordinate(), coordinate(), coordinate()}));
  }
  std::vector<std::uint8_t> found(lines.size());
  many.blocked(lines, found);
  int blocked = 0;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    bool expected = false;
    for (const FdsBox& box : many.boxes()) {
      double begin = 1e-3;
      double end = lines[i].end - 1e-3;
      for (int axis = 0; axis < 3; ++axis) {
        const double a = (box.bounds.min[axis] - lines[i].origin[axis]) / lines[i].direction[axis];
        const double b = (box.bounds.max[axis] - lines[i].origin[axis]) / lines[i].direction[axis];
        begin = std::max({begin, std::min(a, b)});
        end = std::min({end, std::max(a, b)});
      }
      expected = expected || begin <= end + 1e-15;
    }
    EXPECT_EQ(found[i] != 0, expected);
    blocked += expected;
  }
  EXPECT_GT(blocked, 30);
  EXPECT_LT(blocked, 270);
}

TEST(Obstructions, facesTurnOutwards) {
  const ScratchFolder folder;
  const auto index = readText(folder, made().text());
  const auto quads = FdsBuilding(*index, 0).quads();
  EXPECT_THAT(quads, SizeIs(6 + 1));  // a block, and a thin wall
  int outward = 0;
  for (const FdsQuad& quad : quads) {
    const Vec3 normal =
        (quad.corners[1] - quad.corners[0]).cross(quad.corners[2] - quad.corners[0]).normalized();
    const Vec3 middle =
        0.25 * (quad.corners[0] + quad.corners[1] + quad.corners[2] + quad.corners[3]);
    outward += normal.dot(middle - Vec3(0.5, 1, 0.25)) > 0 && middle.x() <= 1;
    EXPECT_EQ(quad.colour[1], 0.5F);
  }
  EXPECT_GE(outward, 6);
}

TEST(SmvIndex, NorthIsABearingAndMustBeANumber) {
  const ScratchFolder folder;
  fdswriter::Index made;
  made.meshes.push_back({kFirst, {}, {}});
  const std::string text = made.text();
  fdswriter::saveText(folder / "made.smv", text);
  EXPECT_FALSE(SmvIndex::read(folder / "made.smv")->north);
  for (const auto& [line, north] :
       {std::pair("30.5", 30.5), std::pair("-90", -90.0), std::pair("270", -90.0),
        std::pair("180", 180.0), std::pair("-1e9", 80.0)}) {
    fdswriter::saveText(folder / "made.smv", std::string("NORTHANGLE\n ") + line + "\n\n" + text);
    const auto index = SmvIndex::read(folder / "made.smv");
    ASSERT_TRUE(index) << line;
    EXPECT_EQ(index->north, north);
  }
  for (const char* line : {"nan", "inf", "east", ""}) {
    fdswriter::saveText(folder / "made.smv", std::string("NORTHANGLE\n ") + line + "\n\n" + text);
    EXPECT_FALSE(SmvIndex::read(folder / "made.smv")) << line;
  }
}

}  // namespace
}  // namespace volute
