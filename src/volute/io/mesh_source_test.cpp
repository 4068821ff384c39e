// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/mesh_source.hpp"

#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "volute/io/testing.hpp"
#include "volute/io/vtu_writer.hpp"
#include "volute/tetmesh/made_meshes.hpp"

namespace volute {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::TempFolder;

void write(const std::filesystem::path& path, const std::string& text) {
  std::ofstream(path) << text;
}

/// A tet and a pyramid beside it, and a triangle of the wall.
std::string vtu(const std::string& smoke, const std::string& cells = "") {
  return R"(<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian"><UnstructuredGrid>
<Piece NumberOfPoints="6" NumberOfCells="3">
<PointData><DataArray type="Float64" Name="smoke" format="ascii">)" +
         smoke + R"(</DataArray>
<DataArray type="Float32" Name="U" NumberOfComponents="3" format="ascii">
0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0</DataArray></PointData>
<CellData>)" +
         cells + R"(</CellData>
<Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">
0 0 0 1 0 0 1 1 0 0 1 0 0.5 0.5 1 2 0.5 1</DataArray></Points>
<Cells><DataArray type="Int32" Name="connectivity" format="ascii">0 1 2 1 2 4 5 0 1 2 3 4</DataArray>
<DataArray type="Int32" Name="offsets" format="ascii">3 7 12</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">5 10 14</DataArray></Cells>
</Piece></UnstructuredGrid></VTKFile>
)";
}

#if VOLUTE_HAS_VTK

Result<MeshFrame> readOne(const std::filesystem::path& path, const MeshOptions& options = {}) {
  VOLUTE_ASSIGN(auto source, MeshSource::open(path, options));
  return source.read(0);
}

TEST(VtuWriter, IsReadBackExactly) {
  const TempFolder folder;
  const auto mesh = hallMesh(2, 5);
  std::vector<float> values(mesh->vertices().size());
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = 0.1F * static_cast<float>(i);
  ASSERT_TRUE(testing::ok(writeVtu(folder / "a&b.vtu", *mesh, "so<ot", values)));
  const SeriesFile files[] = {{"a&b.vtu", 2.5}, {"a&b.vtu", 7}};
  ASSERT_TRUE(testing::ok(writePvd(folder / "s.pvd", files)));
  ASSERT_VALUE(auto source, MeshSource::open(folder / "s.pvd"));
  EXPECT_THAT(source.times(), ElementsAre(2.5, 7));
  ASSERT_VALUE(const auto frame, source.read(1));
  EXPECT_EQ(frame.field, "so<ot");
  ASSERT_EQ(frame.mesh->tets().size(), mesh->tets().size());
  // Read meshes are reordered in space.
  std::vector<std::pair<std::array<double, 3>, float>> written, read;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Vec3 &a = mesh->vertices()[i], &b = frame.mesh->vertices()[i];
    written.push_back({{a.x(), a.y(), a.z()}, values[i]});
    read.push_back({{b.x(), b.y(), b.z()}, frame.values[i]});
  }
  std::ranges::sort(written);
  std::ranges::sort(read);
  EXPECT_EQ(read, written);
}

std::string renamed(std::string text, const std::string& from, const std::string& to) {
  for (auto at = text.find(from); at != text.npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

TEST(MeshSource, AFieldThatIsAbsentAtATimeIsLeftOutThere) {
  const TempFolder folder;
  const std::string text = vtu("1 2 3 4 5 6");
  write(folder / "a.vtu", text);
  write(folder / "b.vtu", renamed(text, "\"smoke\"", "\"temperature\""));
  const SeriesFile files[] = {{"a.vtu", 0}, {"b.vtu", 1}, {"a.vtu", 2}};
  ASSERT_TRUE(testing::ok(writePvd(folder / "s.pvd", files)));
  for (const char* field : {"", "smoke"}) {
    ASSERT_VALUE(auto source, MeshSource::open(folder / "s.pvd", {.field = field}));
    EXPECT_THAT(source.times(), ElementsAre(0, 2));
    EXPECT_THAT(source.absent(), ElementsAre(1));
    EXPECT_EQ(source.absentText(),
              "there is no field 'smoke' at 1 of 3 times, which are left out: 1 s");
    for (std::size_t i = 0; i < 2; ++i) {
      ASSERT_VALUE(const auto frame, source.read(i));
      EXPECT_EQ(frame.field, "smoke");
      EXPECT_EQ(*std::ranges::max_element(frame.values), 6);
    }
  }
  ASSERT_VALUE(auto later, MeshSource::open(folder / "s.pvd", {.field = "temperature"}));
  EXPECT_THAT(later.times(), ElementsAre(1));
  ASSERT_VALUE(auto both, MeshSource::open(folder / "s.pvd", {.field = "smoke", .alsoField = "U"}));
  EXPECT_THAT(both.times(), ElementsAre(0, 2));
  ASSERT_VALUE(const auto neither, MeshSource::open(folder / "s.pvd", {.field = "smok"}));
  EXPECT_EQ(neither.times().size(), 3U) << "reading says what there is";
}

TEST(MeshSource, AFieldThatAPieceLacksIsRefused) {
  const TempFolder folder;
  const std::string
      text = vtu("1 2 3 4 5 6"),
      empty =
          "<Piece NumberOfPoints=\"0\" NumberOfCells=\"0\">"
          "<Points><DataArray type=\"Float32\" NumberOfComponents=\"3\"/></Points><Cells>"
          "<DataArray type=\"Int32\" Name=\"connectivity\"/><DataArray type=\"Int32\" "
          "Name=\"offsets\"/><DataArray type=\"UInt8\" Name=\"types\"/></Cells></Piece>";
  const std::size_t begin = text.find("<Piece"), end = text.find("</UnstructuredGrid>");
  const std::string piece = text.substr(begin, end - begin);
  const auto said = [&](const std::string& second, const std::string& field = "smoke") {
    write(folder / "a.vtu", text.substr(0, end) + second + text.substr(end));
    const auto read = readOne(folder / "a.vtu", {.field = field});
    return read ? std::string() : read.error().message;
  };
  const std::string cells =
      "<CellData><DataArray type=\"Int8\" Name=\"k\" format=\"ascii\">1 2 3</DataArray>";
  for (const char* field : {"", "smoke"}) {
    EXPECT_EQ(said(empty, field), "");
    EXPECT_THAT(said(renamed(piece, "\"smoke\"", "\"soot\""), field),
                HasSubstr("smoke in 1, soot in 1 of 2 blocks"));
    EXPECT_THAT(said(renamed(piece, "PointData", "FieldData"), field),
                HasSubstr("smoke in 1 of 2 blocks"));
  }
  EXPECT_THAT(said(renamed(piece, "<CellData>", cells), "k"), HasSubstr("k in 1 of 2 blocks"));
  EXPECT_THAT(said(renamed(piece, "<CellData>", cells), ""), HasSubstr("which field?"));
  EXPECT_THAT(said(renamed(piece, "Float64", "Float32")), HasSubstr("'smoke' is of 1 x Float32"));
  EXPECT_THAT(said(renamed(piece, "<Points><DataArray type=\"Float32\"",
                           "<Points><DataArray type=\"Float64\"")),
              HasSubstr("'Points' is of 3 x Float64"));
}

TEST(MeshSource, AFileThatIsThereAtTwoTimesIsTold) {
  const TempFolder folder;
  write(folder / "a.vtu", vtu("1 2 3 4 5 6"));
  write(folder / "b.vtu", vtu("1 2 3 4 5 7"));
  const SeriesFile files[] = {{"a.vtu", 0}, {"b.vtu", 1}, {"a.vtu", 2.5}};
  ASSERT_TRUE(testing::ok(writePvd(folder / "s.pvd", files)));
  ASSERT_VALUE(const auto source, MeshSource::open(folder / "s.pvd"));
  ASSERT_EQ(source.remarks().size(), 1);
  EXPECT_THAT(source.remarks()[0].sentence, HasSubstr("a.vtu: is there at 0 s and at 2.5 s"));
  ASSERT_TRUE(testing::ok(writePvd(folder / "s.pvd", std::span(files).first(2))));
  ASSERT_VALUE(const auto once, MeshSource::open(folder / "s.pvd"));
  EXPECT_THAT(once.remarks(), ::testing::IsEmpty());
}

TEST(MeshSource, FieldsOfPointsAndCellsWithOneNameAreToldApart) {
  const TempFolder folder;
  write(folder / "a.vtu", vtu("1 2 3 4 5 6",
                              "<DataArray type=\"Float32\" Name=\"smoke\" format=\"ascii\">7 8 9"
                              "</DataArray>"));
  const auto open = readOne(folder / "a.vtu", {.field = "smoke"});
  ASSERT_FALSE(open);
  EXPECT_THAT(open.error().message, HasSubstr("it has smoke (points) (scalar, of points)"));
  ASSERT_VALUE(const auto cells, readOne(folder / "a.vtu", {.field = "smoke (cells)"}));
  EXPECT_TRUE(cells.ofCells);
  ASSERT_VALUE(const auto points, readOne(folder / "a.vtu", {.field = "smoke (points)"}));
  EXPECT_FALSE(points.ofCells);
  EXPECT_EQ(*std::ranges::max_element(points.values), 6);
}

TEST(MeshSource, PointsOfSurfacesAloneAreLeftOutWithThem) {
  const TempFolder folder;
  std::string text = renamed(vtu("9 1 2 3 4 5 6"), "NumberOfPoints=\"6\"", "NumberOfPoints=\"7\"");
  text = renamed(text, "0 0 0 1 0 0 1 1 0", "9 9 9 0 0 0 1 0 0 1 1 0");
  text = renamed(text, "0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0</D",
                 "0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0</D");
  text = renamed(text, "0 1 2 1 2 4 5 0 1 2 3 4", "0 2 3 2 3 5 6 1 2 3 4 5");
  write(folder / "a.vtu", text);
  ASSERT_VALUE(const auto frame, readOne(folder / "a.vtu", {.field = "smoke"}));
  write(folder / "b.vtu", vtu("1 2 3 4 5 6"));
  ASSERT_VALUE(const auto whole, readOne(folder / "b.vtu", {.field = "smoke"}));
  EXPECT_EQ(frame.values, whole.values);
  EXPECT_EQ(frame.mesh->vertices().size(), 6);
}

TEST(MeshSource, GhostCellsAreCounted) {
  const TempFolder folder;
  write(folder / "a.vtu",
        vtu("1 2 3 4 5 6",
            "<DataArray type=\"UInt8\" Name=\"vtkGhostType\" format=\"ascii\">0 1 "
            "0</DataArray>"));
  ASSERT_VALUE(const auto frame, readOne(folder / "a.vtu", {.field = "smoke"}));
  EXPECT_EQ(frame.ghosts, 1);
}

TEST(MeshSource, ATimeThatAFileStatesOtherwiseIsTold) {
  const TempFolder folder;
  const auto writeAt = [&](const char* name, const char* array, const char* time) {
    std::string text = vtu("1 2 3 4 5 6");
    text.insert(text.find("<Piece"),
                fmt::format("<FieldData><DataArray type=\"Float64\" Name=\"{}\" "
                            "NumberOfTuples=\"1\" format=\"ascii\">{}</DataArray></FieldData>",
                            array, time));
    write(folder / name, text);
  };
  writeAt("a.vtu", "TimeValue", "0"), writeAt("b.vtu", "TIME", "10.00001");
  const auto said = [&](std::initializer_list<SeriesFile> files) {
    EXPECT_TRUE(testing::ok(writePvd(folder / "s.pvd", std::vector(files))));
    const auto source = MeshSource::open(folder / "s.pvd");
    if (!source)
      return source.error().message;
    return source->remarks().empty() ? std::string() : source->remarks().front().sentence;
  };
  EXPECT_EQ(said({{"a.vtu", 0}, {"b.vtu", 10}}), "");
  EXPECT_THAT(said({{"a.vtu", 0}, {"b.vtu", 60}}),
              HasSubstr("b.vtu: states 10 s itself; the collection's 60 s is taken"));
  EXPECT_THAT(said({{"a.vtu", 2}}), HasSubstr("a.vtu: states 0 s itself"));
  write(folder / "b.vtu", vtu("1 2 3 4 5 6"));
  EXPECT_EQ(said({{"a.vtu", 0}, {"b.vtu", 60}}), "");
}

TEST(MeshSource, AFieldOfCellsIsNotOneOfPoints) {
  const TempFolder folder;
  write(folder / "a.vtu", vtu("1 2 3 4 5 6"));
  write(folder / "b.vtu",
        renamed(vtu("1 2 3 4 5 6",
                    "<DataArray type=\"Float32\" Name=\"heat\" format=\"ascii\">1 2 3</DataArray>"),
                "\"smoke\"", "\"other\""));
  write(folder / "b.vtu", renamed(testing::readBytes(folder / "b.vtu"), "\"heat\"", "\"smoke\""));
  const SeriesFile files[] = {{"a.vtu", 0}, {"b.vtu", 1.5}};
  ASSERT_TRUE(testing::ok(writePvd(folder / "s.pvd", files)));
  ASSERT_VALUE(auto source, MeshSource::open(folder / "s.pvd"));
  ASSERT_VALUE(const auto first, source.read(0));
  const auto second = source.read(1);
  ASSERT_FALSE(second);
  EXPECT_THAT(second.error().message, HasSubstr("b.vtu: at 1.5 s the field 'smoke' is of cells"));
}

TEST(MeshSource, ReadsPointsAndCells) {
  const TempFolder folder;
  write(folder / "a.vtu",
        vtu("0 1 2 3 4 5",
            R"(<DataArray type="Float32" Name="soot" format="ascii">9 6 3</DataArray>)"));
  ASSERT_VALUE(const auto points, readOne(folder / "a.vtu", {.field = "smoke"}));
  ASSERT_EQ(points.values.size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {
    const Vec3& at = points.mesh->vertices()[i];
    const Vec3 file[] = {Vec3(0, 0, 0), Vec3(1, 0, 0),   Vec3(1, 1, 0),
                         Vec3(0, 1, 0), Vec3(.5, .5, 1), Vec3(2, .5, 1)};
    EXPECT_EQ(points.values[i], static_cast<float>(std::ranges::find(file, at) - file));
  }
  EXPECT_EQ(points.mesh->tets().size(), 3u);
  ASSERT_VALUE(const auto cells, readOne(folder / "a.vtu", {.field = "soot"}));
  EXPECT_THAT(cells.values, ::testing::Contains(::testing::FloatEq(3)).Times(2));
  EXPECT_THAT(cells.values, ::testing::Contains(::testing::FloatEq(6)).Times(1));
  EXPECT_THAT(readOne(folder / "a.vtu", {.field = "smok"}).error().message, HasSubstr("smoke"));
}

TEST(MeshSource, ReadsSeries) {
  const TempFolder folder;
  write(folder / "a.vtu", vtu("0 1 2 3 4 5"));
  write(folder / "b.vtu", vtu("1 1 1 1 1 1"));
  write(folder / "s.pvd", R"(<VTKFile type="Collection"><Collection>
<DataSet timestep="60" part="0" file="b.vtu"/><DataSet timestep="40" part="0" file="a.vtu"/>
</Collection></VTKFile>
)");
  ASSERT_VALUE(auto source, MeshSource::open(folder / "s.pvd"));
  EXPECT_THAT(source.times(), ElementsAre(40, 60));
  ASSERT_VALUE(const auto first, source.read(0));
  ASSERT_VALUE(const auto second, source.read(1));
  EXPECT_EQ(first.mesh, second.mesh);
  EXPECT_EQ(second.values[0], 1);
}

/// Five unit cubes in a row along x: a hexahedron, a polyhedron, two wedges, six pyramids round a
/// middle, a voxel. Smoke is 1 + 2 x + 3 y + 5 z.
std::string mixedCells() {
  std::vector<Vec3> points;
  for (int x = 0; x <= 5; ++x) {
    for (int i = 0; i < 4; ++i) points.emplace_back(x, i % 2, i / 2);
  }
  points.emplace_back(3.5, 0.5, 0.5);
  std::string connectivity, offsets, types, faces, faceOffsets;
  int end = 0, facesEnd = 0;
  const auto add = [&](int type, const std::vector<int>& cell,
                       const std::vector<std::vector<int>>& sides = {}) {
    for (const int v : cell) connectivity += fmt::format("{} ", v);
    offsets += fmt::format("{} ", end += static_cast<int>(cell.size()));
    types += fmt::format("{} ", type);
    if (!sides.empty()) {
      faces += fmt::format("{} ", sides.size());
      ++facesEnd;
      for (const auto& side : sides) {
        faces += fmt::format("{} {} ", side.size(), fmt::join(side, " "));
        facesEnd += 1 + static_cast<int>(side.size());
      }
    }
    faceOffsets += fmt::format("{} ", sides.empty() ? -1 : facesEnd);
  };
  // The corners of cube i in the order of a hexahedron, and its quads.
  const auto corners = [](int i) {
    const int a = 4 * i, b = a + 4;
    return std::vector<int>{a, b, b + 1, a + 1, a + 2, b + 2, b + 3, a + 3};
  };
  const auto quads = [&](int i) {
    const auto c = corners(i);
    return std::vector<std::vector<int>>{{c[0], c[1], c[2], c[3]}, {c[4], c[5], c[6], c[7]},
                                         {c[0], c[1], c[5], c[4]}, {c[1], c[2], c[6], c[5]},
                                         {c[2], c[3], c[7], c[6]}, {c[3], c[0], c[4], c[7]}};
  };
  add(12, corners(0));
  add(42, corners(1), quads(1));
  const auto c = corners(2);
  add(13, {c[0], c[1], c[2], c[4], c[5], c[6]});
  add(13, {c[0], c[2], c[3], c[4], c[6], c[7]});
  for (std::vector<int> quad : quads(3)) {
    quad.push_back(24);
    add(14, quad);
  }
  const auto v = corners(4);
  add(11, {v[0], v[1], v[3], v[2], v[4], v[5], v[7], v[6]});
  std::string coordinates, smoke;
  for (const Vec3& p : points) {
    coordinates += fmt::format("{} {} {} ", p.x(), p.y(), p.z());
    smoke += fmt::format("{} ", 1 + 2 * p.x() + 3 * p.y() + 5 * p.z());
  }
  const auto array = [](const char* type, const char* name, const std::string& numbers) {
    return fmt::format(R"(<DataArray type="{}" Name="{}" format="ascii">{}</DataArray>)", type,
                       name, numbers);
  };
  return R"(<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian">
<UnstructuredGrid><Piece NumberOfPoints="25" NumberOfCells="11"><PointData>)" +
         array("Float64", "smoke", smoke) +
         R"(</PointData><Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">)" +
         coordinates + "</DataArray></Points><Cells>" +
         array("Int64", "connectivity", connectivity) + array("Int64", "offsets", offsets) +
         array("UInt8", "types", types) + array("Int64", "faces", faces) +
         array("Int64", "faceoffsets", faceOffsets) +
         "</Cells></Piece></UnstructuredGrid></VTKFile>\n";
}

TEST(MeshSource, SplitsEveryShapeSoThatNeighboursMeet) {
  const TempFolder folder;
  write(folder / "mixed.vtu", mixedCells());
  ASSERT_VALUE(const auto frame, readOne(folder / "mixed.vtu"));
  double volume = 0;
  for (std::size_t t = 0; t < frame.mesh->tets().size(); ++t)
    volume += frame.mesh->volume(static_cast<std::int32_t>(t));
  EXPECT_NEAR(volume, 5, 1e-12);
  // A quad that was cut differently from its two sides would show as a boundary inside.
  EXPECT_EQ(frame.mesh->boundary().size(), 2u * (5 * 4 + 2));
  for (std::size_t i = 0; i < frame.values.size(); ++i)
    EXPECT_NEAR(frame.values[i], 1 + frame.mesh->vertices()[i].dot(Vec3(2, 3, 5)), 1e-6);
}

TEST(MeshSource, SeriesMayChangeTheirMesh) {
  const TempFolder folder;
  write(folder / "a.vtu", vtu("0 1 2 3 4 5"));
  write(folder / "b.vtu", mixedCells());
  write(folder / "s.pvd", R"(<VTKFile type="Collection"><Collection>
<DataSet timestep="1" part="0" file="a.vtu"/><DataSet timestep="2" part="0" file="b.vtu"/>
<DataSet timestep="3" part="0" file="a.vtu"/></Collection></VTKFile>
)");
  ASSERT_VALUE(auto source, MeshSource::open(folder / "s.pvd"));
  for (const std::size_t i : {0, 1, 2, 1}) {
    ASSERT_VALUE(const auto frame, source.read(i));
    EXPECT_EQ(frame.mesh->vertices().size(), i == 1 ? 25u : 6u);
    EXPECT_EQ(frame.values.size(), frame.mesh->vertices().size());
  }
}

/// Tets alone, with smoke of 1 at each point.
std::string tets(const std::string& points, int pointCount, const std::string& cells,
                 int cellCount) {
  std::string ones, offsets, types;
  for (int i = 0; i < pointCount; ++i) ones += "1 ";
  for (int i = 1; i <= cellCount; ++i) offsets += fmt::format("{} ", 4 * i), types += "10 ";
  return fmt::format(
      R"(<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian"><UnstructuredGrid>
<Piece NumberOfPoints="{}" NumberOfCells="{}">
<PointData><DataArray type="Float32" Name="smoke" format="ascii">{}</DataArray></PointData>
<Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">{}</DataArray></Points>
<Cells><DataArray type="Int32" Name="connectivity" format="ascii">{}</DataArray>
<DataArray type="Int32" Name="offsets" format="ascii">{}</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">{}</DataArray></Cells>
</Piece></UnstructuredGrid></VTKFile>
)",
      pointCount, cellCount, ones, points, cells, offsets, types);
}

/// ParaView's Clip leaves them, with their values.
TEST(MeshSource, PointsOfNoCellAreLeftOut) {
  const TempFolder folder;
  const std::string text =
      tets("7 7 7 0 0 0 1 0 0 0 1 0 8 8 8 0 0 1", 6, "1 2 3 5", 1);  // 0 and 4 are left over
  write(folder / "a.vtu", renamed(text, "1 1 1 1 1 1 <", "nan 1 2 3 9 4 <"));
  ASSERT_VALUE(const auto frame, readOne(folder / "a.vtu"));
  ASSERT_EQ(frame.values.size(), 4);
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3& at = frame.mesh->vertices()[i];
    EXPECT_EQ(frame.values[i], static_cast<float>(1 + at.x() + 2 * at.y() + 3 * at.z()));
  }
  EXPECT_EQ(frame.mesh->bounds().max, Vec3(1, 1, 1));
  EXPECT_EQ(frame.unused, 2);
  EXPECT_EQ(frame.unusedMost, 9);
}

TEST(MeshSource, AFrameInAnotherUnitOfLengthIsRefused) {
  const TempFolder folder;
  const auto cube = [](double low, double high) {
    return tets(fmt::format("{0} 0 0 {1} 0 0 {0} {1} 0 {0} 0 {1} ", low, high), 4, "0 1 2 3", 1);
  };
  write(folder / "metres.vtu", cube(0.25, 2));
  write(folder / "mm.vtu", cube(250, 2000));
  write(folder / "moved.vtu", cube(3, 20));
  write(folder / "s.pvd", R"(<VTKFile type="Collection"><Collection>
<DataSet timestep="1" part="0" file="metres.vtu"/><DataSet timestep="2" part="0" file="mm.vtu"/>
<DataSet timestep="3" part="0" file="moved.vtu"/></Collection></VTKFile>
)");
  ASSERT_VALUE(auto source, MeshSource::open(folder / "s.pvd"));
  ASSERT_VALUE(const auto first, source.read(0));
  ASSERT_VALUE(const auto moved, source.read(2));
  ASSERT_VALUE(const auto again, source.read(0));
  const auto other = source.read(1);
  ASSERT_FALSE(other);
  EXPECT_THAT(other.error().message,
              HasSubstr("mm.vtu: at 2 s the mesh is 1000 times as large as at a time before, in "
                        "all directions; expected one unit of length, metres, at all times"));
}

TEST(MeshSource, SaysWhatIsWrongWithAField) {
  const TempFolder folder;
  const std::string file = (folder / "a.vtu").string();
  write(file, vtu("0 1 -2 3 -4 5"));
  EXPECT_EQ(readOne(file).error().message,
            file +
                ": field 'smoke': value 2 is -2; concentrations are not negative; ask for them "
                "to be clamped to 0 if they are the solver's noise");
  ASSERT_VALUE(const auto clamped, readOne(file, {.negatives = Negatives::kClamp}));
  EXPECT_EQ(clamped.clamped, 2u);
  EXPECT_THAT(clamped.values, ::testing::Contains(0).Times(3));
  EXPECT_THAT(clamped.values, ::testing::Each(::testing::Ge(0)));
  write(file, vtu("0 1 nan 3 4 5"));
  for (const Negatives negatives : {Negatives::kRefuse, Negatives::kClamp}) {
    EXPECT_EQ(readOne(file, {.negatives = negatives}).error().message,
              file + ": field 'smoke': value 2 is nan; expected finite numbers");
  }
  const auto none = readOne(file, {.field = "soot"});
  EXPECT_THAT(none.error().message, ::testing::StartsWith(file));
  for (const char* said : {"'soot'", "smoke", "U", "vector of 3"})
    EXPECT_THAT(none.error().message, HasSubstr(said));
}

TEST(MeshSource, SaysWhatIsWrongWithAMesh) {
  const TempFolder folder;
  const std::string file = (folder / "a.vtu").string();
  const auto said = [&](const std::string& points, int pointCount, const std::string& cells,
                        int cellCount) {
    write(file, tets(points, pointCount, cells, cellCount));
    const auto frame = readOne(file);
    if (frame)
      return std::string("nothing");
    EXPECT_THAT(frame.error().message, ::testing::StartsWith(file + ": "));
    return frame.error().message.substr(file.size() + 2);
  };
  const std::string corners = "0 0 0 1 0 0 0 1 0 0 0 1 ";
  EXPECT_EQ(said(corners, 4, "0 1 2 3", 1), "nothing");
  EXPECT_EQ(said(corners, 4, "1 0 2 3", 1), "nothing");  // numbered in the other sense
  EXPECT_THAT(said(corners + "1 1 1", 5, "0 1 2 3 0 1 2 4", 2),
              ::testing::AllOf(HasSubstr("tets"), HasSubstr("one is inverted; mend the mesh")));
  EXPECT_THAT(said("0 0 0 1 0 0 0 1 0 1 1 0", 4, "0 1 2 3", 1),
              ::testing::AllOf(HasSubstr("tet 0"), HasSubstr("has no volume; mend the mesh")));
  EXPECT_THAT(said(corners, 4, "0 1 1 3", 1), HasSubstr("has no volume"));
  EXPECT_EQ(said(corners + "7 7 7", 5, "0 1 2 3", 1), "nothing");  // left by a cut
  EXPECT_THAT(said(corners + "1 1 1 -1 -1 -1", 6, "0 1 2 3 1 2 3 4 1 2 3 5", 3),
              ::testing::AllOf(HasSubstr("belongs to 3 tets"), HasSubstr("a face has one or two")));
  EXPECT_THAT(said(corners, 4, "0 1 2 9", 1), HasSubstr("vert"));
}

TEST(MeshSource, SaysWhatIsWrongWithAFile) {
  const TempFolder folder;
  write(folder / "c.vtu", vtu("0 1 2 3 4 5").substr(0, 700));
  EXPECT_THAT(readOne(folder / "c.vtu").error().message, HasSubstr("truncated"));
  EXPECT_THAT(MeshSource::open(folder / "d.vtu").error().message, HasSubstr("no such file"));
  write(folder / "e.msh", "");
  EXPECT_THAT(MeshSource::open(folder / "e.msh").error().message, HasSubstr(".pvd"));
}

#endif

}  // namespace
}  // namespace volute
