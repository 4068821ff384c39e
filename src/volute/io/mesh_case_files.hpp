// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "volute/io/testing.hpp"
#include "volute/math/vec.hpp"

/// Cases for tests, the same in each format: a box of two hexahedra, [0, 2] x [0, 1] x [0, 1], in
/// which smoke is 1 + x at instant 0 (at 10 s) and 3 + x at instant 1 (at 20 s).
namespace volute::testing {

/// Points of the box, x fastest.
inline std::vector<Vec3> boxPoints() {
  std::vector<Vec3> points;
  for (int z = 0; z < 2; ++z) {
    for (int y = 0; y < 2; ++y) {
      for (int x = 0; x < 3; ++x) points.emplace_back(x, y, z);
    }
  }
  return points;
}

inline double smokeAt(const Vec3& point, int instant) {
  return 1 + 2 * instant + point.x();
}

inline std::vector<int> hexahedron(int first) {
  return {first, first + 1, first + 4, first + 3, first + 6, first + 7, first + 10, first + 9};
}

inline void writeEnsight(const std::filesystem::path& folder) {
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

inline std::string foamHead(const char* type, const char* name) {
  return fmt::format("FoamFile\n{{\n version 2.0;\n format ascii;\n class {};\n object {};\n}}\n",
                     type, name);
}

/// Cells alone, since OpenFOAM keeps its values there.
inline void writeFoam(const std::filesystem::path& folder) {
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
inline void writeLegacy(const std::filesystem::path& folder) {
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

/// EnSight Gold in C binary: like writeEnsight(), in two parts of one hexahedron each.
inline void writeBinaryEnsight(const std::filesystem::path& folder) {
  const auto line = [](std::string text) {
    text.resize(80);
    return text;
  };
  const auto number = [](auto value) {
    return std::string(reinterpret_cast<const char*>(&value), sizeof value);
  };
  writeBytes(folder / "two.case",
             "FORMAT\ntype: ensight gold\n\nGEOMETRY\nmodel: 1 two.geo\n\nVARIABLE\n"
             "scalar per node: 1 smoke two_smoke.**\nscalar per element: 1 soot two_soot.**\n\n"
             "TIME\ntime set: 1\nnumber of steps: 2\nfilename start number: 0\n"
             "filename increment: 1\ntime values: 10 20\n");
  std::string geometry = line("C Binary") + line("box") + line("of two") + line("node id off") +
                         line("element id off");
  std::string smoke[2] = {line("smoke"), line("smoke")};
  std::string soot[2] = {line("soot"), line("soot")};
  for (int part = 0; part < 2; ++part) {
    const std::string head = line("part") + number(part + 1);
    std::vector<Vec3> points;
    for (int i = 0; i < 8; ++i) points.emplace_back(part + i % 2, i / 2 % 2, i / 4);
    geometry += head + line("a cube") + line("coordinates") + number(8);
    for (int k = 0; k < 3; ++k) {
      for (const Vec3& point : points) geometry += number(static_cast<float>(point[k]));
    }
    geometry += line("hexa8") + number(1);
    for (const int id : {1, 2, 4, 3, 5, 6, 8, 7}) geometry += number(id);
    for (int instant = 0; instant < 2; ++instant) {
      smoke[instant] += head + line("coordinates");
      for (const Vec3& point : points)
        smoke[instant] += number(static_cast<float>(smokeAt(point, instant)));
      soot[instant] += head + line("hexa8") + number(static_cast<float>(1 + part * (1 + instant)));
    }
  }
  writeBytes(folder / "two.geo", geometry);
  for (int instant = 0; instant < 2; ++instant) {
    writeBytes(folder / fmt::format("two_smoke.{:02d}", instant), smoke[instant]);
    writeBytes(folder / fmt::format("two_soot.{:02d}", instant), soot[instant]);
  }
}

}  // namespace volute::testing
