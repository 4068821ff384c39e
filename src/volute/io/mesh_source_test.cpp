// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/mesh_source.hpp"

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

TEST(MeshSource, SaysWhatIsWrong) {
  const TempFolder folder;
  write(folder / "a.vtu", vtu("0 1 -2 3 4 5"));
  EXPECT_THAT(readOne(folder / "a.vtu").error().message, HasSubstr("value 2 is -2"));
  ASSERT_VALUE(const auto clamped, readOne(folder / "a.vtu", {.negatives = Negatives::kClamp}));
  EXPECT_EQ(clamped.clamped, 1u);
  write(folder / "b.vtu", vtu("0 1 nan 3 4 5"));
  EXPECT_FALSE(readOne(folder / "b.vtu").has_value());
  write(folder / "c.vtu", vtu("0 1 2 3 4 5").substr(0, 700));
  EXPECT_THAT(readOne(folder / "c.vtu").error().message, HasSubstr("truncated"));
  EXPECT_THAT(MeshSource::open(folder / "d.vtu").error().message, HasSubstr("no such file"));
  write(folder / "e.msh", "");
  EXPECT_THAT(MeshSource::open(folder / "e.msh").error().message, HasSubstr(".pvd"));
}

#endif

}  // namespace
}  // namespace volute
