// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Files of meshes that are cut off or say what cannot be.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <functional>

#include "volute/io/ensight_files.hpp"
#include "volute/io/mesh_case_files.hpp"
#include "volute/io/mesh_source.hpp"

namespace volute {
namespace {

using ::testing::HasSubstr;
using namespace testing;

/// Cuts a file of a case at every length; none may pass `check` whose bytes are not the whole but
/// for white space.
void cutEverywhere(const std::filesystem::path& file, const std::function<Status()>& check) {
  const std::string whole = readBytes(file);
  const Status before = check();
  ASSERT_TRUE(before) << before.error().message;
  for (std::size_t length = 0; length < whole.size(); ++length) {
    writeBytes(file, whole.substr(0, length));
    const Status checked = check();
    ASSERT_FALSE(checked) << file << " cut at " << length << " of " << whole.size();
    EXPECT_THAT(checked.error().message, HasSubstr(file.parent_path().string()));
  }
  writeBytes(file, whole);
}

TEST(MeshDamage, NoCutOfEnsightIsWhole) {
  const TempFolder folder;
  writeEnsight(folder.path());
  const auto ascii = [&](const char* field) {
    return [&folder, field] { return checkEnsight(folder / "box.case", field, 20); };
  };
  cutEverywhere(folder / "box.geo", ascii("smoke"));
  cutEverywhere(folder / "box_smoke.01", ascii("smoke"));
  cutEverywhere(folder / "box_soot.01", ascii("soot"));
  EXPECT_TRUE(checkEnsight(folder / "box.case", "smoke", 10));
  writeBinaryEnsight(folder.path());
  const auto binary = [&](const char* field) {
    return [&folder, field] { return checkEnsight(folder / "two.case", field, 20); };
  };
  cutEverywhere(folder / "two.geo", binary("smoke"));
  cutEverywhere(folder / "two_smoke.01", binary("smoke"));
  cutEverywhere(folder / "two_soot.01", binary("soot"));
}

TEST(MeshDamage, LinesOfEnsightThatAreNoNumbers) {
  const TempFolder folder;
  const auto said = [&](const char* name, const std::string& from, const std::string& to) {
    writeEnsight(folder.path());
    std::string text = readBytes(folder / name);
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    writeBytes(folder / name, text.replace(at, from.size(), to));
    const Status checked = checkEnsight(folder / "box.case", "smoke", 20);
    return checked ? std::string() : checked.error().message;
  };
  EXPECT_THAT(said("box_smoke.01", " 3.00000e+00", "     garbage"),
              HasSubstr("'garbage'; expected a number"));
  EXPECT_THAT(said("box_smoke.01", " 3.00000e+00\n", "\n"), HasSubstr("expected a number"));
  EXPECT_THAT(said("box_smoke.01", " 3.00000e+00", " 3.000e+00 4"), HasSubstr("expected a number"));
  EXPECT_THAT(said("box.geo", " 0.00000e+00", "     garbage"), HasSubstr("expected a number"));
  EXPECT_THAT(said("box.case", "VARIABLE", "VARIA@LE"), HasSubstr("line 7: 'VARIA@LE'"));
  EXPECT_THAT(said("box.geo", "hexa8\n         2", "hexa8\n 900000000"),
              HasSubstr("the end is missing"));
  EXPECT_THAT(said("box.geo", "         2         5", "         x         5"),
              HasSubstr("8 numbers"));
  EXPECT_THAT(said("box_smoke.01", "         1\n", "         2\n"), HasSubstr("part 2"));
  EXPECT_THAT(said("box.case", "10 20", "20 10"), HasSubstr("expected ascending times"));
  EXPECT_THAT(said("box.case", "10 20", "10 10"), HasSubstr("expected ascending times"));
  EXPECT_THAT(said("box.case", "steps: 2", "steps: 2000000000"), HasSubstr("2 time values"));
  EXPECT_EQ(said("box_smoke.01", " 3.00000e+00", " +3.0000E+00"), "");
}

TEST(MeshDamage, NumbersOfEnsightFilesFollowTheTimeSet) {
  const TempFolder folder;
  writeEnsight(folder.path());
  writeBytes(folder / "box_smoke.00", "smoke\n");
  EXPECT_TRUE(checkEnsight(folder / "box.case", "smoke", 20));
  EXPECT_THAT(checkEnsight(folder / "box.case", "smoke", 10).error().message,
              HasSubstr("box_smoke.00"));
}

#if VOLUTE_HAS_VTK

TEST(MeshDamage, ReadsBinaryEnsight) {
  const TempFolder folder;
  writeBinaryEnsight(folder.path());
  for (std::size_t instant = 0; instant < 2; ++instant) {
    ASSERT_VALUE(auto source, MeshSource::open(folder / "two.case", {.field = "smoke"}));
    ASSERT_VALUE(const auto frame, source.read(instant));
    ASSERT_EQ(frame.mesh->vertices().size(), 12u);
    for (std::size_t i = 0; i < 12; ++i)
      EXPECT_NEAR(frame.values[i], smokeAt(frame.mesh->vertices()[i], static_cast<int>(instant)),
                  1e-6);
  }
  const std::string whole = readBytes(folder / "two.geo");
  writeBytes(folder / "two.geo", whole.substr(0, whole.size() / 2 + 160));  // one of two parts
  ASSERT_VALUE(auto source, MeshSource::open(folder / "two.case", {.field = "smoke"}));
  EXPECT_FALSE(source.read(0));
}

std::string saidOf(const std::filesystem::path& path, const std::string& field = "") {
  auto source = MeshSource::open(path, {.field = field, .maxMemory = 256 << 20});
  for (std::size_t i = 0; source && i < source->times().size(); ++i) {
    const auto frame = source->read(i);
    if (!frame)
      return frame.error().message;
  }
  return source ? "" : source.error().message;
}

TEST(MeshDamage, PackedOpenFoamCutAnywhere) {
  const TempFolder folder;
  writeFoam(folder.path());
  const auto file = folder / "20" / "soot";
  const std::string text = readBytes(file);
  std::filesystem::remove(file);
  const std::filesystem::path packed = file.string() + ".gz";
  const gzFile out = ::gzopen(packed.c_str(), "wb");
  ::gzwrite(out, text.data(), static_cast<unsigned>(text.size()));
  ::gzclose(out);
  EXPECT_EQ(saidOf(folder / "box.foam", "soot"), "");
  const std::string whole = readBytes(packed);
  for (std::size_t missing = 1; missing <= whole.size(); missing += 8) {
    writeBytes(packed, whole.substr(0, whole.size() - missing));
    EXPECT_NE(saidOf(folder / "box.foam", "soot"), "") << missing;
  }
}

struct Vtu {
  std::string points = "0 0 0 1 0 0 0 1 0 0 0 1";
  std::string pointCount = "4", cellCount = "1";
  std::string connectivity = "0 1 2 3", offsets = "4", types = "10";
  std::string smoke = "1 2 3 4";
  std::string more = "";

  void write(const std::filesystem::path& path) const {
    const auto array = [](const char* type, const char* name, int components,
                          const std::string& numbers) {
      return fmt::format(
          R"(<DataArray type="{}" Name="{}" NumberOfComponents="{}" format="ascii">{}</DataArray>)",
          type, name, components, numbers);
    };
    writeBytes(path, R"(<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian">)"
                     "<UnstructuredGrid>\n" +
                         fmt::format(R"(<Piece NumberOfPoints="{}" NumberOfCells="{}">)",
                                     pointCount, cellCount) +
                         "<PointData>" + array("Float32", "smoke", 1, smoke) +
                         "</PointData><Points>" + array("Float64", "p", 3, points) +
                         "</Points><Cells>" + array("Int64", "connectivity", 1, connectivity) +
                         array("Int64", "offsets", 1, offsets) + array("UInt8", "types", 1, types) +
                         more + "</Cells></Piece></UnstructuredGrid></VTKFile>\n");
  }
};

TEST(MeshDamage, VtuThatSayWhatCannotBe) {
  const TempFolder folder;
  const std::filesystem::path file = folder / "a.vtu";
  const auto said = [&](const std::function<void(Vtu&)>& change) {
    Vtu vtu;
    change(vtu);
    vtu.write(file);
    const std::string message = saidOf(file);
    if (!message.empty()) {
      EXPECT_TRUE(message.starts_with(file.string())) << message;
    }
    return message;
  };
  EXPECT_EQ(said([](Vtu&) {}), "");
  for (const char* wrong : {"0 1 2 4", "0 1 2 -1", "0 1 2 4000000000000", "0 1 2"})
    EXPECT_NE(said([&](Vtu& vtu) { vtu.connectivity = wrong; }), "") << wrong;
  for (const char* wrong : {"5", "0", "-4", "4000000000000", "3"})
    EXPECT_NE(said([&](Vtu& vtu) { vtu.offsets = wrong; }), "") << wrong;
  for (const char* wrong : {"12", "42", "24", "1", "255", "0"})
    EXPECT_NE(said([&](Vtu& vtu) { vtu.types = wrong; }), "") << wrong;
  for (const char* wrong : {"0 0 0 1 0 0 0 1 0 0 0 nan", "0 0 0 1 0 0 0 1 0 0 0 inf",
                            "0 0 0 1 0 0 0 1 0 0 0 1e308", "0 0 0 1 0 0 0 1 0 0 0"})
    EXPECT_NE(said([&](Vtu& vtu) { vtu.points = wrong; }), "") << wrong;
  for (const char* wrong : {"1 2 3 nan", "1 2 3 inf", "1 2 3 1e39", "1 2 3", "1 2 3 x", ""})
    EXPECT_NE(said([&](Vtu& vtu) { vtu.smoke = wrong; }), "") << wrong;
  for (const char* wrong : {"0", "1000000000000", "-1", "5", "3"})
    EXPECT_NE(said([&](Vtu& vtu) { vtu.pointCount = wrong; }), "") << wrong;
  for (const char* wrong : {"0", "1000000000000", "-1", "2"})
    EXPECT_NE(said([&](Vtu& vtu) { vtu.cellCount = wrong; }), "") << wrong;
  // A polyhedron whose stream of faces is short, and one that names a point that is not there.
  for (const char* wrong : {"4 3 0 1 2 3 0 1 3 3 0 2 3 3 1 2", "4 3 0 1 2 3 0 1 3 3 0 2 3 3 1 2 9",
                            "4000000000 3 0 1 2", "4 300000000 0 1 2", ""}) {
    EXPECT_NE(said([&](Vtu& vtu) {
                vtu.types = "42";
                vtu.more = fmt::format(
                    R"(<DataArray type="Int64" Name="faces" format="ascii">{}</DataArray>
<DataArray type="Int64" Name="faceoffsets" format="ascii">17</DataArray>)",
                    wrong);
              }),
              "")
        << wrong;
  }
}

TEST(MeshDamage, SeriesThatSayWhatCannotBe) {
  const TempFolder folder;
  Vtu{}.write(folder / "a.vtu");
  Vtu{}.write(folder / "b.vtu");
  const auto said = [&](const std::string& sets) {
    writeBytes(folder / "s.pvd",
               "<VTKFile type=\"Collection\"><Collection>" + sets + "</Collection></VTKFile>\n");
    return saidOf(folder / "s.pvd");
  };
  EXPECT_EQ(said(R"(<DataSet timestep="1" file="a.vtu"/><DataSet timestep="2" file="b.vtu"/>)"),
            "");
  EXPECT_THAT(said(R"(<DataSet timestep="1" file="a.vtu"/><DataSet timestep="1" file="b.vtu"/>)"),
              HasSubstr("a.vtu and b.vtu are both at 1 s"));
  EXPECT_THAT(said(R"(<DataSet timestep="1" file="a.vtu"/><DataSet timestep="2" file="c.vtu"/>)"),
              HasSubstr("c.vtu"));
  EXPECT_THAT(said(R"(<DataSet timestep="1" file="a.vtu"/><DataSet timestep="2" file="c.vtm"/>)"),
              HasSubstr("c.vtm; expected a series of .vtu or .pvtu files"));
  EXPECT_NE(said(R"(<DataSet timestep="nan" file="a.vtu"/>)"), "");
  EXPECT_NE(said(""), "");
  std::filesystem::create_directory(folder / "d.vtu");
  EXPECT_THAT(saidOf(folder / "d.vtu"), HasSubstr("is a folder"));
  EXPECT_THAT(said(R"(<DataSet timestep="1" file="d.vtu"/>)"), HasSubstr("d.vtu"));
  for (const char* name : {"e.vtu", "e.pvtu", "e.pvd", "e.vtk", "e.case", "e.e", "e.foam"}) {
    writeBytes(folder / name, "");
    EXPECT_THAT(saidOf(folder / name), ::testing::StartsWith((folder / name).string())) << name;
  }
}

/// Two cubes, of one piece each, that meet at a face whose points both name; the second piece also
/// has the first one's cube as a ghost.
TEST(MeshDamage, PiecesOfParallelFiles) {
  const TempFolder folder;
  const auto cube = [](int x) {
    std::string points;
    for (int i = 0; i < 8; ++i) points += fmt::format("{} {} {} ", x + i % 2, i / 2 % 2, i / 4);
    return points;
  };
  const auto write = [&](const char* name, const std::string& points, const std::string& ghosts,
                         int cells) {
    std::string ids, offsets, types, smoke;
    for (int c = 0; c < cells; ++c) {
      for (const int id : {0, 1, 3, 2, 4, 5, 7, 6}) ids += fmt::format("{} ", 8 * c + id);
      offsets += fmt::format("{} ", 8 * (c + 1));
      types += "12 ";
      smoke += "1 2 1 2 1 2 1 2 ";
    }
    writeBytes(folder / name,
               fmt::format(
                   R"(<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian">
<UnstructuredGrid><Piece NumberOfPoints="{}" NumberOfCells="{}">
<PointData><DataArray type="Float32" Name="smoke" format="ascii">{}</DataArray></PointData>
<CellData><DataArray type="UInt8" Name="vtkGhostType" format="ascii">{}</DataArray></CellData>
<Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">{}</DataArray></Points><Cells>
<DataArray type="Int64" Name="connectivity" format="ascii">{}</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">{}</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">{}</DataArray></Cells></Piece>
</UnstructuredGrid></VTKFile>
)",
                   8 * cells, cells, smoke, ghosts, points, ids, offsets, types));
  };
  write("p0.vtu", cube(0), "0", 1);
  write("p1.vtu", cube(1) + cube(0), "0 1", 2);
  writeBytes(folder / "p.pvtu",
             R"(<VTKFile type="PUnstructuredGrid" version="0.1" byte_order="LittleEndian">
<PUnstructuredGrid GhostLevel="1"><Piece Source="p0.vtu"/><Piece Source="p1.vtu"/></PUnstructuredGrid>
</VTKFile>
)");
  writeBytes(folder / "s.pvd",
             "<VTKFile type=\"Collection\"><Collection><DataSet timestep=\"3\" "
             "file=\"p.pvtu\"/></Collection></VTKFile>\n");
  for (const char* name : {"p.pvtu", "s.pvd"}) {
    ASSERT_VALUE(auto source, MeshSource::open(folder / name));
    ASSERT_VALUE(const auto frame, source.read(0));
    EXPECT_EQ(frame.mesh->vertices().size(), 12u);
    EXPECT_EQ(frame.mesh->boundary().size(), 20u);
    double volume = 0;
    for (std::size_t t = 0; t < frame.mesh->tets().size(); ++t)
      volume += frame.mesh->volume(static_cast<std::int32_t>(t));
    EXPECT_NEAR(volume, 2, 1e-12);
  }
  std::filesystem::remove(folder / "p1.vtu");
  EXPECT_THAT(saidOf(folder / "p.pvtu"), HasSubstr("p1.vtu"));
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(MeshDamage, MisspeltNamesOfVtkXml) {
  const TempFolder folder;
  Vtu{}.write(folder / "a.vtu");
  Vtu other;
  other.points = "3 0 0 4 0 0 3 1 0 3 0 1";
  other.write(folder / "b.vtu");
  const std::string parallel =
      R"(<VTKFile type="PUnstructuredGrid" version="0.1" byte_order="LittleEndian">
<PUnstructuredGrid GhostLevel="0"><PPointData><PDataArray type="Float32" Name="smoke"/></PPointData>
<Piece Source="a.vtu"/><Piece Source="b.vtu"/></PUnstructuredGrid>
</VTKFile>
)";
  const std::string series =
      R"(<VTKFile type="Collection" version="0.1"><Collection>
<DataSet timestep="1" group="" part="0" file="a.vtu"/><DataSet timestep="2.5" file="b.vtu"/>
</Collection></VTKFile>
)";
  const auto said = [&](const std::string& kind, const std::string& from, const std::string& to) {
    const std::string& whole = kind == "pvtu" ? parallel : series;
    writeBytes(folder / ("x." + kind), from.empty() ? whole : replaced(whole, from, to));
    return saidOf(folder / ("x." + kind));
  };
  EXPECT_EQ(said("pvtu", "", ""), "");
  EXPECT_EQ(said("pvd", "", ""), "");
  EXPECT_THAT(said("pvtu", "Source=\"b", "Sousce=\"b"), HasSubstr("did you mean 'Source'?"));
  EXPECT_THAT(said("pvtu", "Source=\"b", "url=\"b"), HasSubstr("Piece: its Source is missing"));
  EXPECT_THAT(said("pvtu", "<Piece Source=\"b", "<Piexe Source=\"b"),
              HasSubstr("did you mean 'Piece'?"));
  EXPECT_THAT(said("pvd", "timestep=\"2.5\"", "timesrep=\"2.5\""),
              HasSubstr("did you mean 'timestep'?"));
  EXPECT_THAT(said("pvd", "timestep=\"2.5\"", "time=\"2.5\""),
              HasSubstr("did you mean 'timestep'?"));
  EXPECT_THAT(said("pvd", "2.5", "2,5"), HasSubstr("timestep is '2,5'; expected 1 number"));
  EXPECT_THAT(said("pvd", "2.5", "2 5"), HasSubstr("timestep is '2 5'; expected 1 number"));
  EXPECT_THAT(said("pvd", "file=\"b", "fyle=\"b"), HasSubstr("did you mean 'file'?"));
  EXPECT_THAT(said("pvd", "<DataSet timestep=\"2", "<DataXet timestep=\"2"),
              HasSubstr("did you mean 'DataSet'?"));
  // What other programs add is passed over.
  EXPECT_EQ(said("pvd", "group=\"\"", "group=\"\" comment=\"by the solver\" units=\"s\""), "");
  EXPECT_EQ(said("pvtu", "<PPointData>", "<Provenance by=\"us\"/><PPointData>"), "");
}

TEST(MeshDamage, CellsWithMoreOrFewerPointsThanTheirType) {
  const TempFolder folder;
  const auto said = [&](const char* type) {
    Vtu vtu;
    vtu.pointCount = "5";
    vtu.points += " 1 1 1";
    vtu.smoke += " 5";
    vtu.cellCount = "2";
    vtu.connectivity = "0 1 2 3 1 2 3 4";
    vtu.offsets = "4 8";
    vtu.types = fmt::format("10 {}", type);
    vtu.write(folder / "a.vtu");
    return saidOf(folder / "a.vtu");
  };
  EXPECT_EQ(said("10"), "");
  // A triangle, a line, a hexahedron: the second tetrahedron had been left out, or was refused.
  EXPECT_THAT(said("5"), HasSubstr("cell 1 is of VTK type 5 and has 4 points; expected 3"));
  EXPECT_THAT(said("3"), HasSubstr("expected 2"));
  EXPECT_THAT(said("12"), HasSubstr("expected 8"));
}

TEST(MeshDamage, VectorsAreNamedAsSuch) {
  const TempFolder folder;
  Vtu vtu;
  vtu.write(folder / "a.vtu");
  std::string text = readBytes(folder / "a.vtu");
  text.insert(text.find("</PointData>"),
              R"(<DataArray type="Float32" Name="U" NumberOfComponents="3" format="ascii">
0 0 0 0 0 0 0 0 0 3 4 0</DataArray>)");
  writeBytes(folder / "a.vtu", text);
  EXPECT_THAT(saidOf(folder / "a.vtu", "U"),
              HasSubstr("field 'U' is of type vector of 3, of points; expected a scalar; it has "
                        "smoke (scalar, of points), U (vector of 3, of points)"));
  ASSERT_VALUE(const auto source, MeshSource::open(folder / "a.vtu"));
  ASSERT_VALUE(const auto described, source.describe(0));
  ASSERT_EQ(described.fields.size(), 2u);
  EXPECT_STREQ(described.fields[1].name, "U");
  EXPECT_EQ(described.fields[1].most, 5);
  EXPECT_EQ(described.contents.size.cells, 1u);
  ASSERT_TRUE(described.mesh);
  EXPECT_EQ((*described.mesh)->tets().size(), 1u);
}

#endif

}  // namespace
}  // namespace volute
