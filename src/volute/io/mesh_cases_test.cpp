// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Cases of EnSight, Exodus and OpenFOAM.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>

#include "volute/io/mesh_source.hpp"
#include "volute/io/testing.hpp"

namespace volute {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::readBytes;
using testing::TempFolder;
using testing::writeBytes;

#if VOLUTE_HAS_VTK

// The same in each format: a box of two hexahedra, [0, 2] x [0, 1] x [0, 1], in which smoke is
// 1 + x at instant 0 (at 10 s) and 3 + x at instant 1 (at 20 s).

/// Points of the box, x fastest.
std::vector<Vec3> boxPoints() {
  std::vector<Vec3> points;
  for (int z = 0; z < 2; ++z) {
    for (int y = 0; y < 2; ++y) {
      for (int x = 0; x < 3; ++x) points.emplace_back(x, y, z);
    }
  }
  return points;
}

double smokeAt(const Vec3& point, int instant) {
  return 1 + 2 * instant + point.x();
}

std::vector<int> hexahedron(int first) {
  return {first, first + 1, first + 4, first + 3, first + 6, first + 7, first + 10, first + 9};
}

void writeEnsight(const std::filesystem::path& folder) {
  writeBytes(folder / "box.case",
             "FORMAT\ntype: ensight gold\n\nGEOMETRY\nmodel: 1 box.geo\n\nVARIABLE\n"
             "scalar per node: 1 smoke box_smoke.**\nscalar per element: 1 soot box_soot.**\n\n"
             "TIME\ntime set: 1\nnumber of steps: 2\nfilename start number: 0\n"
             "filename increment: 1\ntime values: 10 20\n");
  std::string geometry =
      "box\nof two\nnode id off\nelement id off\npart\n         1\nall\ncoordinates\n        12\n";
  for (int k = 0; k < 3; ++k) {
    for (const Vec3& point : boxPoints()) geometry += fmt::format("{:12.5e}\n", point[k]);
  }
  geometry += "hexa8\n         2\n";
  for (const int first : {0, 1}) {
    for (const int id : hexahedron(first)) geometry += fmt::format("{:10d}", id + 1);
    geometry += '\n';
  }
  writeBytes(folder / "box.geo", geometry);
  for (int instant = 0; instant < 2; ++instant) {
    std::string smoke = "smoke\npart\n         1\ncoordinates\n";
    for (const Vec3& point : boxPoints())
      smoke += fmt::format("{:12.5e}\n", smokeAt(point, instant));
    writeBytes(folder / fmt::format("box_smoke.{:02d}", instant), smoke);
    writeBytes(
        folder / fmt::format("box_soot.{:02d}", instant),
        fmt::format("soot\npart\n         1\nhexa8\n{:12.5e}\n{:12.5e}\n", 1.0, 2.0 + instant));
  }
}

std::string foamHead(const char* type, const char* name) {
  return fmt::format("FoamFile\n{{\n version 2.0;\n format ascii;\n class {};\n object {};\n}}\n",
                     type, name);
}

/// Cells alone, since OpenFOAM keeps its values there.
void writeFoam(const std::filesystem::path& folder) {
  const auto mesh = folder / "constant" / "polyMesh";
  std::filesystem::create_directories(mesh);
  std::filesystem::create_directories(folder / "system");
  writeBytes(folder / "box.foam", "");
  writeBytes(
      folder / "system" / "controlDict",
      foamHead("dictionary", "controlDict") +
          "application x;\nstartFrom startTime;\nstartTime 10;\nstopAt endTime;\nendTime 20;\n"
          "deltaT 10;\nwriteControl timeStep;\nwriteInterval 1;\n");
  std::string points = foamHead("vectorField", "points") + "12\n(\n";
  for (const Vec3& p : boxPoints()) points += fmt::format("({} {} {})\n", p.x(), p.y(), p.z());
  writeBytes(mesh / "points", points + ")\n");
  // The face between, then the walls; normals from the owner outwards.
  writeBytes(mesh / "faces",
             foamHead("faceList", "faces") +
                 "11\n(\n4(1 4 10 7)\n4(0 6 9 3)\n4(2 5 11 8)\n4(0 1 7 6)\n4(1 2 8 7)\n"
                 "4(3 9 10 4)\n4(4 10 11 5)\n4(0 3 4 1)\n4(1 4 5 2)\n4(6 7 10 9)\n"
                 "4(7 8 11 10)\n)\n");
  writeBytes(mesh / "owner",
             foamHead("labelList", "owner") + "11\n(\n0\n0\n1\n0\n1\n0\n1\n0\n1\n0\n1\n)\n");
  writeBytes(mesh / "neighbour", foamHead("labelList", "neighbour") + "1\n(\n1\n)\n");
  writeBytes(mesh / "boundary",
             foamHead("polyBoundaryMesh", "boundary") +
                 "1\n(\nwalls\n{\n type wall;\n nFaces 10;\n startFace 1;\n}\n)\n");
  for (int instant = 0; instant < 2; ++instant) {
    const auto time = folder / fmt::format("{}", 10 * (instant + 1));
    std::filesystem::create_directories(time);
    writeBytes(
        time / "soot",
        foamHead("volScalarField", "soot") +
            fmt::format("dimensions [1 -3 0 0 0 0 0];\ninternalField nonuniform "
                        "List<scalar>\n2\n(\n1\n{}\n)\n;\nboundaryField\n{{\nwalls\n{{\ntype "
                        "zeroGradient;\n}}\n}}\n",
                        2 + instant));
  }
}

template <class T>
void putBigEndian(std::string& out, T value) {
  char bytes[sizeof value];
  std::memcpy(bytes, &value, sizeof value);
  if constexpr (std::endian::native == std::endian::little)
    std::ranges::reverse(bytes);
  out.append(bytes, sizeof value);
}

/// VTK's legacy format in binary; it has one instant.
void writeLegacy(const std::filesystem::path& folder) {
  std::string all =
      "# vtk DataFile Version 3.0\nbox\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 12 float\n";
  for (const Vec3& point : boxPoints()) {
    for (int k = 0; k < 3; ++k) putBigEndian(all, static_cast<float>(point[k]));
  }
  all += "\nCELLS 2 18\n";
  for (const int first : {0, 1}) {
    putBigEndian(all, 8);
    for (const int id : hexahedron(first)) putBigEndian(all, id);
  }
  all += "\nCELL_TYPES 2\n";
  for (int i = 0; i < 2; ++i) putBigEndian(all, 12);
  all += "\nPOINT_DATA 12\nSCALARS smoke float 1\nLOOKUP_TABLE default\n";
  for (const Vec3& point : boxPoints()) putBigEndian(all, static_cast<float>(smokeAt(point, 0)));
  writeBytes(folder / "box.vtk", all + "\n");
}

void writeExodus(const std::filesystem::path& folder) {
  ASSERT_EQ(
      std::system(fmt::format("{} {}", VOLUTE_EXODUS_MAKER, (folder / "box.e").string()).c_str()),
      0);
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
  const TempFolder folder;
  writeExodus(folder.path());
  ASSERT_VALUE(auto source, MeshSource::open(folder / "box.e", {.field = "smoke"}));
  EXPECT_THAT(source.times(), ElementsAre(10, 20));
  for (int instant = 0; instant < 2; ++instant) {
    ASSERT_VALUE(const auto frame, source.read(static_cast<std::size_t>(instant)));
    expectSmoke(frame, instant);
  }
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
  damage(folder / "box.e", folder / "box.e", "smoke", false);
  writeLegacy(folder.path());
  damage(folder / "box.vtk", folder / "box.vtk", "smoke", true);
  writeFoam(folder.path());
  damage(folder / "box.foam", folder / "20" / "soot", "soot", false);
  damage(folder / "box.foam", folder / "constant" / "polyMesh" / "faces", "soot", true);
}

#endif

}  // namespace
}  // namespace volute
