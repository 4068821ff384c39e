// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Cases of EnSight, Exodus and OpenFOAM.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "volute/io/foam_files.hpp"
#include "volute/io/grid_cache.hpp"
#include "volute/io/mesh_case_files.hpp"
#include "volute/io/mesh_source.hpp"
#include "volute/io/netcdf_length.hpp"
#include "volute/io/testing.hpp"

namespace volute {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using namespace testing;

#if VOLUTE_HAS_VTK

/// Of netCDF's classic format, or with HDF5 inside.
/// @param more  the smoke's _FillValue, of which the second instant is, or the name of a vector of
/// 10 m along x; empty: it has none
void writeExodus(const std::filesystem::path& folder, bool hdf5 = false,
                 const std::string& more = "") {
  ASSERT_EQ(std::system(fmt::format("{} {} {} {} 2> /dev/null", hdf5 ? "EXODUS_NETCDF4=1" : "",
                                    VOLUTE_EXODUS_MAKER, (folder / "box.e").string(), more)
                            .c_str()),
            0);
  ASSERT_EQ(readBytes(folder / "box.e").substr(0, 3), hdf5 ? "\x89HD" : "CDF");
}

/// The smoke of the box, point by point.
void expectSmoke(const MeshFrame& frame, int instant) {
  ASSERT_EQ(frame.mesh->vertices().size(), 12u);
  double volume = 0;
  for (std::size_t t = 0; t < frame.mesh->tets().size(); ++t)
    volume += frame.mesh->volume(static_cast<std::int32_t>(t));
  EXPECT_NEAR(volume, 2, 1e-6);
  for (std::size_t i = 0; i < 12; ++i)
    EXPECT_NEAR(frame.values[i], smokeAt(frame.mesh->vertices()[i], instant), 1e-6);
}

TEST(MeshCases, ReadsEnsight) {
  const TempFolder folder;
  writeEnsight(folder.path());
  ASSERT_VALUE(auto source, MeshSource::open(folder / "box.case", {.field = "smoke"}));
  EXPECT_THAT(source.times(), ElementsAre(10, 20));
  for (int instant = 0; instant < 2; ++instant) {
    ASSERT_VALUE(const auto frame, source.read(static_cast<std::size_t>(instant)));
    expectSmoke(frame, instant);
  }
  ASSERT_VALUE(auto cells, MeshSource::open(folder / "box.case", {.field = "soot"}));
  ASSERT_VALUE(const auto soot, cells.read(1));
  EXPECT_FLOAT_EQ(*std::ranges::min_element(soot.values), 1);
  EXPECT_FLOAT_EQ(*std::ranges::max_element(soot.values), 3);
  ASSERT_VALUE(auto other, MeshSource::open(folder / "box.case", {.field = "sot"}));
  EXPECT_THAT(other.read(0).error().message, HasSubstr("soot"));
}

TEST(MeshCases, ReadsExodus) {
  for (const bool hdf5 : {false, true}) {
    const TempFolder folder;
    writeExodus(folder.path(), hdf5);
    ASSERT_VALUE(auto source, MeshSource::open(folder / "box.e", {.field = "smoke"}));
    EXPECT_THAT(source.times(), ElementsAre(10, 20));
    for (int instant = 0; instant < 2; ++instant) {
      ASSERT_VALUE(const auto frame, source.read(static_cast<std::size_t>(instant)));
      expectSmoke(frame, instant);
    }
  }
}

/// Values of the box at its second instant, as an Exodus file holds them.
std::string smokeBytes(bool fill) {
  std::string bytes;
  for (const Vec3& point : boxPoints())
    putBigEndian(bytes, fill ? 9.9692099683868690e+36 : smokeAt(point, 1));
  return bytes;
}

TEST(MeshCases, RecordsThatWereNeverWrittenAreNoData) {
  const TempFolder folder;
  writeExodus(folder.path());
  std::string bytes = readBytes(folder / "box.e");
  const auto at = bytes.find(smokeBytes(false));
  ASSERT_NE(at, bytes.npos);
  std::string some = bytes;
  some.replace(at, 16, smokeBytes(true).substr(0, 16));
  writeBytes(folder / "some.e", some);
  ASSERT_VALUE(auto partly, MeshSource::open(folder / "some.e", {.field = "smoke"}));
  EXPECT_THAT(partly.read(1).error().message,
              HasSubstr("at 20 s 2 of 12 values of the field 'smoke' were never written"));
  bytes.replace(at, smokeBytes(true).size(), smokeBytes(true));
  writeBytes(folder / "box.e", bytes);
  ASSERT_VALUE(auto source, MeshSource::open(folder / "box.e", {.field = "smoke"}));
  EXPECT_THAT(source.times(), ElementsAre(10));
  EXPECT_THAT(source.absentText(), HasSubstr("never written (netCDF's fill value) at 1 of 2"));
  std::string times;
  putBigEndian(times, 20.0);
  std::string fill;
  putBigEndian(fill, 9.9692099683868690e+36);
  const auto time = bytes.rfind(times, at);
  ASSERT_NE(time, bytes.npos);
  bytes.replace(time, fill.size(), fill);
  writeBytes(folder / "box.e", bytes);
  ASSERT_VALUE(auto open, MeshSource::open(folder / "box.e", {.field = "smoke"}));
  EXPECT_THAT(open.times(), ElementsAre(10));
  EXPECT_THAT(open.absentText(), HasSubstr("left out: unknown"));
}

TEST(MeshCases, AFieldsOwnFillValueIsNoData) {
  for (const std::string fill : {"-999", "1e30", "nan"}) {
    const TempFolder folder;
    writeExodus(folder.path(), false, fill);
    ASSERT_VALUE(auto source, MeshSource::open(folder / "box.e", {.field = "smoke"}));
    EXPECT_THAT(source.times(), ElementsAre(10)) << fill;
    EXPECT_THAT(source.absentText(), HasSubstr("1 of 2 times, which are left out: 20 s"));
    ASSERT_VALUE(const auto frame, source.read(0));
    expectSmoke(frame, 0);
  }
  const TempFolder folder;
  writeExodus(folder.path(), false, "1");  // of four points at the first instant, too
  ASSERT_VALUE(auto source, MeshSource::open(folder / "box.e", {.field = "smoke"}));
  EXPECT_THAT(source.read(0).error().message, HasSubstr("at 10 s 4 of 12 values"));
}

TEST(MeshCases, OnlyADisplacementMovesTheMeshOfExodus) {
  for (const auto& [name, moved] : {std::pair("distance", 0), std::pair("dissipation", 0),
                                    std::pair("disp_", 10), std::pair("DISPL", 10)}) {
    const TempFolder folder;
    writeExodus(folder.path(), false, name);
    ASSERT_VALUE(auto source, MeshSource::open(folder / "box.e", {.field = "smoke"}));
    ASSERT_VALUE(const auto frame, source.read(0));
    EXPECT_NEAR(frame.mesh->bounds().min.x(), moved, 1e-9) << name;
  }
}

TEST(MeshCases, AFirstRecordThatWasNeverWrittenIsLeftOut) {
  const TempFolder folder;
  writeExodus(folder.path());
  std::string bytes = readBytes(folder / "box.e"), first;
  for (const Vec3& point : boxPoints()) putBigEndian(first, smokeAt(point, 0));
  ASSERT_NE(bytes.find(first), bytes.npos);
  bytes.replace(bytes.find(first), first.size(), smokeBytes(true));
  writeBytes(folder / "box.e", bytes);
  ASSERT_VALUE(auto source, MeshSource::open(folder / "box.e", {.field = "smoke"}));
  EXPECT_THAT(source.times(), ElementsAre(20));
  EXPECT_THAT(source.absentText(), HasSubstr("1 of 2 times, which are left out: 10 s"));
  ASSERT_VALUE(const auto frame, source.read(0));
  expectSmoke(frame, 1);
  // None is there: that is an error, and nothing is left out.
  bytes.replace(bytes.find(smokeBytes(false)), first.size(), smokeBytes(true));
  writeBytes(folder / "box.e", bytes);
  ASSERT_VALUE(auto none, MeshSource::open(folder / "box.e", {.field = "smoke"}));
  EXPECT_EQ(none.absentText(), "");
  EXPECT_THAT(none.read(0).error().message, HasSubstr("12 of 12 values"));
}

TEST(MeshCases, ReadsLegacyVtk) {
  const TempFolder folder;
  writeLegacy(folder.path());
  ASSERT_VALUE(auto source, MeshSource::open(folder / "box.vtk", {.field = "smoke"}));
  EXPECT_THAT(source.times(), ElementsAre(0));
  ASSERT_VALUE(const auto frame, source.read(0));
  expectSmoke(frame, 0);
  ASSERT_VALUE(auto other, MeshSource::open(folder / "box.vtk", {.field = "soot"}));
  EXPECT_THAT(other.read(0).error().message, HasSubstr("smoke"));
}

TEST(MeshCases, DimensionsOfOpenFoamAreReadAndStayTheSame) {
  const TempFolder folder;
  writeFoam(folder.path());
  ASSERT_VALUE(auto source, MeshSource::open(folder / "box.foam"));
  ASSERT_VALUE(const auto frame, source.read(0));
  EXPECT_EQ(frame.dimensions, (std::array<double, 7>{1, -3, 0, 0, 0, 0, 0}));
  std::string text = readBytes(folder / "20" / "soot");
  writeBytes(folder / "20" / "soot", text.replace(text.find("[1 -3"), 5, "[0 -1"));
  const auto other = source.read(1);
  ASSERT_FALSE(other);
  EXPECT_THAT(other.error().message,
              HasSubstr("at 20 s the field 'soot' states the dimensions [0 -1 0 0 0 0 0], before "
                        "[1 -3 0 0 0 0 0]"));
  std::filesystem::remove(folder / "20" / "soot");
  ASSERT_VALUE(auto shorter, MeshSource::open(folder / "box.foam", {.field = "soot"}));
  EXPECT_THAT(shorter.times(), ElementsAre(10));
  EXPECT_THAT(shorter.absent(), ElementsAre(20));
  ASSERT_VALUE(auto all, MeshSource::open(folder / "box.foam"));
  EXPECT_THAT(all.fieldNames(), ElementsAre(::testing::Contains("soot"),
                                            ::testing::Not(::testing::Contains("soot"))));
}

TEST(MeshCases, DimensionsOfOpenFoamByUnitsNamesAreNotTakenForDamage) {
  const TempFolder folder;
  writeFoam(folder.path());
  std::string text = readBytes(folder / "20" / "soot");
  const auto open = text.find('['), close = text.find(']');
  writeBytes(folder / "20" / "soot", text.replace(open, close + 1 - open, "[kg m^-3]"));
  ASSERT_VALUE(auto source, MeshSource::open(folder / "box.foam"));
  EXPECT_THAT(
      source.read(1).error().message,
      HasSubstr("20/soot: its dimensions are units' names, [kg m^-3]; expected the powers"));
}

TEST(MeshCases, ReferenceLevelsOfOpenFoamAreRefused) {
  const TempFolder folder;
  writeFoam(folder.path());
  const std::string text = readBytes(folder / "20" / "soot");
  const auto with = [&](const std::string& level) {
    std::string other = text;
    writeBytes(folder / "20" / "soot", other.insert(other.find("internalField"), level));
    auto source = MeshSource::open(folder / "box.foam", {.field = "soot"});
    const auto frame = source->read(1);
    return frame ? "" : frame.error().message;
  };
  EXPECT_EQ(with("referenceLevel 0;\n// referenceLevel 5;\n"), "");
  EXPECT_THAT(with("referenceLevel 5;\n"), HasSubstr("20/soot: its referenceLevel, 5, is added"));
}

TEST(MeshCases, DecomposedOpenFoamSaysHowToReadIt) {
  const TempFolder folder;
  writeFoam(folder.path());
  for (const char* name : {"processor0", "processor1"})
    std::filesystem::create_directories(folder / name / "constant" / "polyMesh");
  EXPECT_TRUE(MeshSource::open(folder / "box.foam")) << "reconstructed as well";
  std::filesystem::remove_all(folder / "constant");
  const auto source = MeshSource::open(folder / "box.foam");
  ASSERT_FALSE(source);
  EXPECT_THAT(source.error().message,
              HasSubstr("box.foam: the case is decomposed into 2 processors"));
  const auto ofFolder = listLatticeFiles(folder.path());
  ASSERT_FALSE(ofFolder);
  EXPECT_THAT(ofFolder.error().message, HasSubstr("/: the case is decomposed into 2 processors"));
}

TEST(MeshCases, TimesThatProcessorsAloneHaveAreNotForgotten) {
  const TempFolder folder;
  writeFoam(folder.path());
  for (const char* name : {"processor0", "processor1"}) {
    for (const char* time : {"10", "20", "30"})
      std::filesystem::create_directories(folder / name / time);
  }
  ASSERT_VALUE(const auto some, MeshSource::open(folder / "box.foam"));
  ASSERT_EQ(some.remarks().size(), 1);
  EXPECT_THAT(some.remarks()[0].sentence,
              HasSubstr("times that its processors alone have are left out: 1 from 30 to 30 s"));
  std::filesystem::rename(folder / "10", folder / "5");
  EXPECT_TRUE(MeshSource::open(folder / "box.foam")) << "the latest time alone was reconstructed";
  std::filesystem::rename(folder / "5", folder / "10");
  std::filesystem::remove_all(folder / "20");
  const auto first = MeshSource::open(folder / "box.foam");
  ASSERT_FALSE(first);
  EXPECT_THAT(first.error().message, HasSubstr("the case itself has one of the 3 times that its 2 "
                                               "processors have until 30 s"));
}

TEST(MeshCases, WhatAnOpenFoamCaseHasBesidesIsTold) {
  const TempFolder folder;
  writeFoam(folder.path());
  ASSERT_VALUE(const auto plain, MeshSource::open(folder / "box.foam"));
  EXPECT_THAT(plain.remarks(), ::testing::IsEmpty());
  std::filesystem::create_directories(folder / "constant" / "wall" / "polyMesh");
  writeBytes(folder / "constant" / "wall" / "polyMesh" / "points", "");
  std::filesystem::create_directories(folder / "20" / "lagrangian" / "spray");
  writeBytes(folder / "constant" / "g", foamHead("uniformDimensionedVectorField", "g") +
                                            "dimensions [0 1 -2 0 0 0 0];\nvalue (0 -9.81 0);\n");
  ASSERT_VALUE(const auto source, MeshSource::open(folder / "box.foam"));
  ASSERT_EQ(source.remarks().size(), 2);
  EXPECT_THAT(source.remarks()[0].sentence,
              HasSubstr("regions besides the default one are left out: wall"));
  EXPECT_THAT(source.remarks()[1].sentence, HasSubstr("clouds of particles are left out: spray"));
  for (const Remark& remark : source.remarks()) EXPECT_EQ(remark.code, RemarkCode::kLeftOut);
  EXPECT_THAT(foamGravity(folder / "box.foam"),
              HasSubstr("constant/g is (0 -9.81 0), and z is upwards here"));
  writeBytes(folder / "constant" / "g",
             foamHead("uniformDimensionedVectorField", "g") + "value (0 0 -9.81);\n");
  EXPECT_EQ(foamGravity(folder / "box.foam"), "");
  std::filesystem::rename(folder / "constant" / "polyMesh", folder / "constant" / "air");
  std::filesystem::create_directories(folder / "constant" / "gas");
  std::filesystem::rename(folder / "constant" / "air", folder / "constant" / "gas" / "polyMesh");
  EXPECT_THAT(MeshSource::open(folder / "box.foam").error().message,
              HasSubstr("its meshes are of regions (gas, wall)"));
}

/// What createBaffles does to the face between the two hexahedra.
void makeBaffle(const std::filesystem::path& folder, std::string_view type) {
  const auto mesh = folder / "constant" / "polyMesh";
  std::string faces = readBytes(mesh / "faces");
  const std::string between = "4(1 4 10 7)\n";
  faces.replace(faces.find("11\n("), 4, "12\n(");
  faces.erase(faces.find(between), between.size());
  faces.insert(faces.rfind(')'), between + "4(1 7 10 4)\n");
  writeBytes(mesh / "faces", faces);
  writeBytes(mesh / "owner",
             foamHead("labelList", "owner") + "12\n(\n0\n1\n0\n1\n0\n1\n0\n1\n0\n1\n0\n1\n)\n");
  writeBytes(mesh / "neighbour", foamHead("labelList", "neighbour") + "0\n(\n)\n");
  writeBytes(mesh / "boundary",
             foamHead("polyBoundaryMesh", "boundary") +
                 fmt::format("2\n(\nwalls\n{{\n type wall;\n nFaces 10;\n startFace 0;\n}}\n"
                             "screen // a door leaf\n{{\n type {}; inGroups 1(wall);\n nFaces 2;\n "
                             "startFace 10;\n}}\n)\n",
                             type));
  for (const char* time : {"10", "20"}) {
    std::string soot = readBytes(folder / time / "soot");
    soot.insert(soot.rfind('}'), "screen\n{\ntype zeroGradient;\n}\n");
    writeBytes(folder / time / "soot", soot);
  }
}

TEST(MeshCases, BafflesOfOpenFoamAreWalls) {
  const TempFolder folder;
  writeFoam(folder.path());
  ASSERT_VALUE(auto plain, MeshSource::open(folder / "box.foam"));
  ASSERT_VALUE(const auto open, plain.read(0));
  EXPECT_EQ(open.walls, nullptr);
  makeBaffle(folder.path(), "wall");
  ASSERT_VALUE(auto source, MeshSource::open(folder / "box.foam"));
  ASSERT_VALUE(const auto frame, source.read(0));
  ASSERT_NE(frame.walls, nullptr);
  EXPECT_EQ(frame.walls->size(), 2);
  for (const ThinWall& wall : *frame.walls) {
    for (const Vec3& corner : wall) EXPECT_EQ(corner.x(), 1);
  }
  // Each side has its own points and its own smoke.
  ASSERT_EQ(frame.mesh->vertices().size(), 16);
  for (std::size_t i = 0; i < frame.values.size(); ++i) {
    const double x = frame.mesh->vertices()[i].x();
    if (x != 1)
      EXPECT_EQ(frame.values[i], x < 1 ? 1 : 2);
    else
      EXPECT_TRUE(frame.values[i] == 1 || frame.values[i] == 2) << frame.values[i];
  }
  ASSERT_VALUE(const auto described, source.describe(0));
  EXPECT_EQ(described.contents.walls, 1);
  const TetLocator locator(frame.mesh, frame.walls);
  const Segment through{Vec3(0.5, 0.3, 0.4), Vec3(1, 0, 0), 0, 1},
      beside{Vec3(0.5, 0.3, 0.4), Vec3(0, 1, 0), 0, 0.5};
  ASSERT_TRUE(locator.wallOn(through));
  EXPECT_NEAR(*locator.wallOn(through), 0.5, 1e-9);
  EXPECT_FALSE(locator.wallOn(beside));
  EXPECT_FALSE(locator.wallOn({through.origin, through.direction, 0, 0.5})) << "ends on it";
  EXPECT_TRUE(locator.isOnWall(Vec3(1, 0.2, 0.2)));
  EXPECT_FALSE(locator.isOnWall(Vec3(1.001, 0.2, 0.2)));
  // What lets through is none.
  const TempFolder other;
  writeFoam(other.path());
  makeBaffle(other.path(), "cyclic");
  ASSERT_VALUE(auto pair, MeshSource::open(other / "box.foam"));
  ASSERT_VALUE(const auto passable, pair.read(0));
  EXPECT_EQ(passable.walls, nullptr);
  EXPECT_EQ(passable.mesh->vertices().size(), 12);
}

/// The same with points of each side's own (mergeOrSplitBaffles -split).
TEST(MeshCases, SplitBafflesOfOpenFoamAreWalls) {
  const TempFolder folder;
  writeFoam(folder.path());
  makeBaffle(folder.path(), "wall");
  const auto mesh = folder / "constant" / "polyMesh";
  std::string points = readBytes(mesh / "points");
  points.replace(points.find("12\n("), 4, "16\n(");
  points.insert(points.rfind(')'), "(1 0 0)\n(1 1 0)\n(1 0 1)\n(1 1 1)\n");  // 12 to 15
  writeBytes(mesh / "points", points);
  std::string faces = foamHead("faceList", "faces") +
                      "12\n(\n4(0 6 9 3)\n4(2 5 11 8)\n4(0 1 7 6)\n4(12 2 8 14)\n"
                      "4(3 9 10 4)\n4(13 15 11 5)\n4(0 3 4 1)\n4(12 13 5 2)\n4(6 7 10 9)\n"
                      "4(14 8 11 15)\n4(1 4 10 7)\n4(12 14 15 13)\n)\n";
  writeBytes(mesh / "faces", faces);
  ASSERT_VALUE(auto source, MeshSource::open(folder / "box.foam"));
  ASSERT_VALUE(const auto frame, source.read(0));
  ASSERT_NE(frame.walls, nullptr);
  EXPECT_EQ(frame.walls->size(), 2);
  EXPECT_EQ(frame.mesh->vertices().size(), 16);
}

TEST(MeshCases, OtherFieldsOfOpenFoamMaySayWhatVtkDoesNotRead) {
  const TempFolder folder;
  writeFoam(folder.path());
  ASSERT_VALUE(auto wrong, MeshSource::open(folder / "box.foam", {.field = "sot"}));
  EXPECT_THAT(wrong.read(0).error().message,
              HasSubstr("no field named 'sot'; did you mean 'soot'"));
  writeBytes(folder / "20" / "p",
             foamHead("volScalarField", "p") +
                 "pp 1e5;\ndimensions [1 -1 -2 0 0 0 0];\ninternalField uniform $pp;\n"
                 "boundaryField\n{\n#includeEtc \"caseDicts/setConstraintTypes\"\n}\n");
  ASSERT_VALUE(auto source, MeshSource::open(folder / "box.foam", {.field = "soot"}));
  EXPECT_TRUE(testing::ok(source.read(1)));
  ASSERT_VALUE(auto all, MeshSource::open(folder / "box.foam"));
  EXPECT_THAT(all.read(1).error().message, HasSubstr("cannot be read: "));
}

TEST(MeshCases, OpenFoamOfAnotherByteOrderIsRefused) {
  const TempFolder folder;
  writeFoam(folder.path());
  const auto file = folder / "20" / "soot";
  const std::string text = readBytes(file);
  const auto with = [&](const char* arch) {
    std::string head = text;
    head.replace(head.find("format ascii;"), 13,
                 fmt::format("format binary;\n arch \"{};label=32;scalar=64\";", arch));
    writeBytes(file, head);
    const auto source = MeshSource::open(folder / "box.foam");
    return source ? std::string() : source.error().message;
  };
  constexpr bool kLittle = std::endian::native == std::endian::little;
  EXPECT_THAT(with(kLittle ? "MSB" : "LSB"),
              HasSubstr("20/soot: is binary in the byte order of another machine"));
  EXPECT_EQ(with(kLittle ? "LSB" : "MSB"), "");
}

TEST(MeshCases, AnEnSightFieldHasTheTimesOfItsOwnSet) {
  const TempFolder folder;
  writeEnsight(folder.path());
  std::string text = readBytes(folder / "box.case");
  text.replace(text.find("scalar per element: 1"), 21, "scalar per element: 2");
  writeBytes(folder / "box.case", text +
                                      "time set: 2\nnumber of steps: 2\nfilename start number: "
                                      "0\nfilename increment: 1\ntime values: 10 18.7\n");
  ASSERT_VALUE(auto smoke, MeshSource::open(folder / "box.case", {.field = "smoke"}));
  EXPECT_THAT(smoke.times(), ElementsAre(10, 20));
  ASSERT_VALUE(const auto frame, smoke.read(1));
  expectSmoke(frame, 1);
  ASSERT_VALUE(const auto soot, MeshSource::open(folder / "box.case", {.field = "soot"}));
  EXPECT_THAT(soot.times(), ElementsAre(10, ::testing::DoubleNear(18.7, 1e-5)));
  text.replace(text.find("model: 1"), 8, "model: 1 1");
  writeBytes(folder / "box.case", text);
  EXPECT_THAT(MeshSource::open(folder / "box.case").error().message,
              HasSubstr("has several times in one file (a file set)"));
}

TEST(MeshCases, AFieldThatNotAllBlocksHaveIsNoDamage) {
  const TempFolder folder;
  writeBinaryEnsight(folder.path());
  const auto file = folder / "two_smoke.00";
  std::string bytes = readBytes(file);
  writeBytes(file, bytes.substr(0, 80 + (bytes.size() - 80) / 2));
  ASSERT_VALUE(auto source, MeshSource::open(folder / "two.case", {.field = "smoke"}));
  EXPECT_THAT(source.read(0).error().message,
              HasSubstr("has no values of part 2 of the geometry: the field is of other parts"));
}

TEST(MeshCases, ReadsOpenFoam) {
  const TempFolder folder;
  writeFoam(folder.path());
  ASSERT_VALUE(auto source, MeshSource::open(folder / "box.foam", {.field = "soot"}));
  EXPECT_THAT(source.times(), ElementsAre(10, 20));
  ASSERT_VALUE(const auto frame, source.read(1));
  ASSERT_EQ(frame.mesh->vertices().size(), 12u);
  EXPECT_FLOAT_EQ(*std::ranges::min_element(frame.values), 1);
  EXPECT_FLOAT_EQ(*std::ranges::max_element(frame.values), 3);
}

TEST(MeshCases, NoCutOfExodusIsWhole) {
  for (const bool hdf5 : {false, true}) {
    const TempFolder folder;
    writeExodus(folder.path(), hdf5);
    const std::string whole = readBytes(folder / "box.e");
    for (const std::size_t missing : {1, 4, 80, 400, 1200, 2000, 2900, 2970}) {
      writeBytes(folder / "box.e", whole.substr(0, whole.size() - missing));
      const auto source = MeshSource::open(folder / "box.e");
      ASSERT_FALSE(source) << missing;
      EXPECT_THAT(source.error().message, HasSubstr((folder / "box.e").string()));
    }
  }
}

/// What became of a case whose file was cut or changed: how many were refused. The others give
/// frames: a changed digit is a number too.
struct Damage {
  int refused = 0, read = 0;

  void look(const std::filesystem::path& file, const std::string& field) {
    const auto source = MeshSource::open(file, {.field = field, .maxMemory = 256 << 20});
    std::string message = source ? "" : source.error().message;
    if (source) {
      auto copy = *source;
      for (std::size_t i = 0; i < copy.times().size() && message.empty(); ++i) {
        const auto frame = copy.read(i);
        if (!frame)
          message = frame.error().message;
      }
    }
    message.empty() ? ++read : ++refused;
    if (!message.empty()) {
      EXPECT_THAT(message, HasSubstr(file.parent_path().string()));
      EXPECT_GT(message.size(), file.string().size() + 10);
    }
  }
};

/// How many bits of each file are flipped: VOLUTE_TEST_FLIPS, else few.
std::size_t flipCount() {
  const char* wanted = std::getenv("VOLUTE_TEST_FLIPS");
  return wanted ? static_cast<std::size_t>(std::atoi(wanted)) : 6;
}

/// Cuts `file` of the case at a few places, then flips bits in it.
void damage(const std::filesystem::path& caseFile, const std::filesystem::path& file,
            const std::string& field, bool cutsMustFail) {
  const std::string whole = readBytes(file);
  Damage cuts, flips;
  for (int i = 0; i < 6; ++i) {
    writeBytes(file, whole.substr(0, whole.size() * static_cast<std::size_t>(i) / 6));
    cuts.look(caseFile, field);
  }
  if (cutsMustFail) {
    EXPECT_EQ(cuts.read, 0) << file;
  }
  for (std::size_t i = 0; i < flipCount(); ++i) {
    std::string flipped = whole;
    flipped[(i * 2654435761u + 97) % flipped.size()] ^= static_cast<char>(1 << (i % 8));
    writeBytes(file, flipped);
    flips.look(caseFile, field);
  }
  writeBytes(file, whole);
}

TEST(MeshCases, SurviveDamage) {
  const TempFolder folder;
  writeEnsight(folder.path());
  damage(folder / "box.case", folder / "box_smoke.01", "smoke", true);
  damage(folder / "box.case", folder / "box.geo", "smoke", true);
  writeExodus(folder.path());
  damage(folder / "box.e", folder / "box.e", "smoke", true);
  writeLegacy(folder.path());
  damage(folder / "box.vtk", folder / "box.vtk", "smoke", true);
  writeFoam(folder.path());
  damage(folder / "box.foam", folder / "20" / "soot", "soot", true);
  for (const char* name : {"points", "faces", "owner", "neighbour"})
    damage(folder / "box.foam", folder / "constant" / "polyMesh" / name, "soot", true);
  std::string soot = readBytes(folder / "20" / "soot");
  soot.replace(soot.find("ascii"), 5, "binary");
  const double values[] = {1, 3};
  soot.replace(soot.find("(\n1\n3\n)"), 7,
               "(" + std::string(reinterpret_cast<const char*>(values), sizeof values) + ")");
  writeBytes(folder / "20" / "soot", soot);
  damage(folder / "box.foam", folder / "20" / "soot", "soot", true);
}

#endif

}  // namespace
}  // namespace volute
