// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <random>
#include <set>

#include "volute/grid/grid_matrix.hpp"
#include "volute/grid/rounding_source.hpp"
#include "volute/io/sequence_testing.hpp"
#include "volute/io/testing.hpp"
#include "volute/io/volume_sink.hpp"
#include "volute/io/volume_source.hpp"

namespace volute {
namespace {

using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using namespace testing;

#if VOLUTE_HAS_VTK

Sequence makeSeries(int channels) {
  auto series = makeBlob(3, 3, 4, 5, channels);
  series.info.name = "smoke & mirrors";
  series.info.bounds = {Vec3(1, 2, 3), Vec3(2, 2.8, 3.6)};
  series.info.frameNumbers = {5, 6, 9};
  series.info.times = {0, 0.5, 2.25};
  return series;
}

TEST(Vtk, PatternAndCollectionRoundTrip) {
  for (int channels : {1, 3}) {
    const TempFolder folder;
    const auto written = makeSeries(channels);
    ASSERT_TRUE(ok(writeAll(folder / "s.pvd", written)));
    ASSERT_VALUE(const auto read, readSequence(folder / "s.pvd"));
    EXPECT_EQ(read.values, written.values);
    EXPECT_EQ(read.info.name, written.info.name);
    EXPECT_EQ(read.info.frameNumbers, written.info.frameNumbers);
    EXPECT_EQ(read.info.times, written.info.times);
    EXPECT_LT((read.info.bounds.min - written.info.bounds.min).norm(), 1e-12);
    EXPECT_LT((read.info.bounds.max - written.info.bounds.max).norm(), 1e-12);
    ASSERT_VALUE(const auto pattern, readSequence(folder / "s_%04d.vti"));
    EXPECT_EQ(pattern.values, written.values);
    EXPECT_EQ(pattern.info.times, written.info.times) << "stated by each file";
  }
}

TEST(Vtk, BoundsCropAndPad) {
  const TempFolder folder;
  const auto written = makeSeries(1);
  ASSERT_TRUE(ok(writeAll(folder / "s.pvd", written)));
  SourceOptions options;
  options.bounds = Box3{Vec3(1.2, 1.8, 3.2), Vec3(2.2, 2.4, 3.4)};
  ASSERT_VALUE(const auto read, readSequence(folder / "s.pvd", options));
  EXPECT_EQ(read.info.x, 5);
  EXPECT_EQ(read.info.y, 3);
  EXPECT_EQ(read.info.z, 1);
  EXPECT_EQ(read.view()(1, 0, 1, 0, 0), written.view()(1, 1, 0, 1, 0));
  EXPECT_EQ(read.view()(1, 0, 0, 0, 0), 0);
}

TEST(Vtk, LayersAreThoseOfTheFrame) {
  for (int channels : {1, 3}) {
    const TempFolder folder;
    const auto written = makeBlob(2, 37, 4, 5, channels);
    ASSERT_TRUE(ok(writeAll(folder / "s_%04d.vti", written)));
    SourceOptions options;
    options.byLayers = true;
    options.maxMemory = 1000;  // less than a frame
    ASSERT_VALUE(const auto source, openSource(folder / "s_%04d.vti", options));
    const std::size_t layer = 20 * static_cast<std::size_t>(channels);
    for (const auto& [first, end] : {std::pair{0, 16}, {16, 32}, {3, 4}, {13, 37}}) {
      std::vector<float> part(layer * static_cast<std::size_t>(end - first));
      ASSERT_TRUE(ok(source->readLayers(1, first, end, part)));
      EXPECT_TRUE(std::equal(part.begin(), part.end(),
                             written.frame(1).begin() + static_cast<std::ptrdiff_t>(layer * first)))
          << first << ' ' << end;
    }
  }
}

/// A file as other programs write it, with values in text.
std::string asciiFile(const std::string& attributes, const std::string& pointData,
                      const std::string& cellData) {
  return "<?xml version=\"1.0\"?>\n<VTKFile type=\"ImageData\" version=\"1.0\" "
         "byte_order=\"LittleEndian\">\n"
         "<ImageData WholeExtent=\"2 4 0 1 0 1\" Origin=\"10 0 0\" Spacing=\"0.5 1 1\"" +
         attributes +
         ">\n"
         "<Piece Extent=\"2 4 0 1 0 1\">\n<PointData>" +
         pointData + "</PointData>\n<CellData>" + cellData +
         "</CellData>\n</Piece>\n</ImageData>\n</VTKFile>\n";
}

constexpr const char* kPoints =
    "<DataArray type=\"Float64\" Name=\"t\" format=\"ascii\">0 1 2 3 4 5 6 7 8 9 10 11</DataArray>";
constexpr const char* kCells =
    "<DataArray type=\"Int32\" Name=\"k\" format=\"ascii\">7 8</DataArray>";

TEST(Vtk, PointDataAreVoxelCentres) {
  const TempFolder folder;
  writeBytes(folder / "p.vti", asciiFile("", kPoints, ""));
  ASSERT_VALUE(const auto read, readSequence(folder / "p.vti"));
  ASSERT_VALUE(const auto source, openSource(folder / "p.vti", {}));
  std::vector<float> upper(6);
  ASSERT_TRUE(ok(source->readLayers(0, 1, 2, upper)));
  EXPECT_EQ(upper, (std::vector<float>{6, 7, 8, 9, 10, 11}));
  EXPECT_EQ(read.info.x, 3);
  EXPECT_EQ(read.info.z, 2);
  EXPECT_EQ(read.info.bounds.min, Vec3(10.75, -0.5, -0.5));
  EXPECT_EQ(read.info.bounds.max, Vec3(12.25, 1.5, 1.5));
  EXPECT_EQ(read.values[11], 11);
}

TEST(Vtk, CountsTheRoundingOfDoublesAndLargeIntegers) {
  const TempFolder folder;
  const auto roundingOfType = [&](const std::string& type, const std::string& numbers) {
    writeBytes(folder / "p.vti",
               asciiFile("",
                         "<DataArray type=\"" + type + "\" Name=\"t\" format=\"ascii\">" + numbers +
                             "</DataArray>",
                         ""));
    const auto source = openSource(folder / "p.vti", {});
    EXPECT_TRUE(ok(source));
    std::vector<float> values(12);
    EXPECT_TRUE(ok((*source)->readFrame(0, values)));
    return roundingOf(**source);
  };
  EXPECT_NEAR(roundingOfType("Float64", "1000000.01 1 2 3 4 5 6 7 8 9 10 11"), 0.01, 1e-9);
  EXPECT_EQ(roundingOfType("Int64", "16777217 1 2 3 4 5 6 7 8 9 10 11"), 1);
  EXPECT_EQ(roundingOfType("UInt8", "255 1 2 3 4 5 6 7 8 9 10 11"), 0);
  EXPECT_EQ(roundingOfType("Float32", "0.1 1 2 3 4 5 6 7 8 9 10 11"), 0);
}

TEST(Vtk, CellsAreVoxelsAndArraysAreChosenByName) {
  const TempFolder folder;
  writeBytes(folder / "c.vti", asciiFile("", kPoints, kCells));
  EXPECT_THAT(openSource(folder / "c.vti", {}).error().message,
              HasSubstr("k (scalar, of cells), t (scalar, of points)"));
  SourceOptions options;
  options.grid = "k";
  ASSERT_VALUE(const auto read, readSequence(folder / "c.vti", options));
  EXPECT_EQ(read.values, (std::vector<float>{7, 8}));
  EXPECT_EQ(read.info.bounds.min, Vec3(11, 0, 0));
  EXPECT_EQ(read.info.bounds.max, Vec3(12, 1, 1));
}

TEST(Vtk, TurnedGridsHaveMatrices) {
  const TempFolder folder;
  writeBytes(folder / "d.vti", asciiFile(" Direction=\"0 1 0 -1 0 0 0 0 1\"", "", kCells));
  ASSERT_VALUE(const auto source, openSource(folder / "d.vti", {}));
  const auto& places = dynamic_cast<const PlacedFrames&>(*source).places();
  ASSERT_EQ(places.size(), 1U);
  EXPECT_LT((linearOf(places[0]).col(0) - Vec3(0, -1, 0)).norm(), 1e-12);
  EXPECT_LT((linearOf(places[0]).col(1) - Vec3(1, 0, 0)).norm(), 1e-12);
  writeBytes(folder / "e.vti", asciiFile(" Direction=\"0 1 0 0 1 0 0 0 1\"", "", kCells));
  EXPECT_THAT(openSource(folder / "e.vti", {}).error().message, HasSubstr("flat"));
}

/// What is said of a file in which `from` is `to`; empty: nothing.
std::string errorOfChanged(std::string text, const std::string& from, const std::string& to) {
  const TempFolder folder;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  writeBytes(folder / "p.vti", text.replace(at, from.size(), to));
  const auto read = readSequence(folder / "p.vti");
  return read ? std::string() : read.error().message;
}

TEST(Vtk, PiecesFillTheWholeExtent) {
  const auto said = [&](const std::string& from, const std::string& to) {
    return errorOfChanged(asciiFile("", "", kCells), from, to);
  };
  EXPECT_EQ(said("Piece", "Piece"), "");
  EXPECT_THAT(said("WholeExtent=\"2 4", "WholeExtent=\"2 9"),
              HasSubstr("the cell 4,0,0 (x,y,z) is in none of its pieces"));
  EXPECT_THAT(
      said("WholeExtent=\"2 4", "WholeExtent=\"2 3"),
      HasSubstr("its Extent along x is 2 to 4; expected it within the WholeExtent, 2 to 3"));
  EXPECT_THAT(said("Piece Extent=\"2 4", "Piece Extent=\"3 4"),
              HasSubstr("the cell 2,0,0 (x,y,z) is in none of its pieces"));
  // Two pieces.
  const std::string one =
      "<Piece Extent=\"2 3 0 1 0 1\"><CellData><DataArray type=\"Int32\" "
      "Name=\"k\" format=\"ascii\">5</DataArray></CellData></Piece>\n";
  EXPECT_EQ(said("<Piece Extent=\"2 4 0 1 0 1\">\n<PointData></PointData>\n<CellData>" +
                     std::string(kCells) + "</CellData>\n</Piece>",
                 one + "<Piece Extent=\"3 4" + one.substr(18)),
            "");
}

/// An image of the cells 0..4, 0..4, 0..4 in pieces, each of its cells with the piece's number.
std::string inPieces(const std::vector<std::array<int, 6>>& pieces) {
  std::string text =
      "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\">\n"
      "<ImageData WholeExtent=\"0 4 0 4 0 4\" Origin=\"0 0 0\" Spacing=\"1 1 1\">\n";
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const auto& e = pieces[i];
    const int cells = (e[1] - e[0]) * (e[3] - e[2]) * (e[5] - e[4]);
    text += fmt::format(
        "<Piece Extent=\"{}\"><CellData><DataArray type=\"Float32\" Name=\"k\" "
        "format=\"ascii\">",
        fmt::join(e, " "));
    for (int k = 0; k < cells; ++k) text += fmt::format("{} ", i + 1);
    text += "</DataArray></CellData></Piece>\n";
  }
  return text + "</ImageData>\n</VTKFile>\n";
}

TEST(Vtk, PiecesThatOverlapDoNotMakeUpForHoles) {
  const TempFolder folder;
  const auto said = [&](const std::vector<std::array<int, 6>>& pieces) {
    writeBytes(folder / "p.vti", inPieces(pieces));
    const auto read = readSequence(folder / "p.vti");
    return read ? std::string() : read.error().message;
  };
  const std::array<int, 6> whole = {0, 4, 0, 4, 0, 4}, lower = {0, 4, 0, 4, 0, 2},
                           upper = {0, 4, 0, 4, 2, 4}, left = {0, 2, 0, 4, 2, 4},
                           right = {2, 4, 0, 4, 2, 4};
  EXPECT_EQ(said({whole}), "");
  EXPECT_EQ(said({upper, lower}), "");
  EXPECT_EQ(said({left, lower, right}), "");
  EXPECT_THAT(said({lower, lower}), HasSubstr("the cell 0,0,0 (x,y,z) is in 2 of its pieces"));
  EXPECT_THAT(said({whole, whole}), HasSubstr("in 2 of its pieces"));
  EXPECT_THAT(said({lower, left, left}), HasSubstr("the cell 0,0,2 (x,y,z) is in 2 of its pieces"));
  EXPECT_THAT(said({lower, right}), HasSubstr("the cell 0,0,2 (x,y,z) is in none of its pieces"));
  EXPECT_THAT(said({lower, left}), HasSubstr("the cell 2,0,2 (x,y,z) is in none of its pieces"));
}

TEST(Vtk, AnArrayThatAPieceLacksIsRefused) {
  const TempFolder folder;
  const std::string text = inPieces({{0, 4, 0, 4, 0, 2}, {0, 4, 0, 4, 2, 4}});
  const std::size_t second = text.rfind("<CellData>");
  const auto said = [&](const std::string& from, const std::string& to, std::size_t after,
                        const std::string& grid = "") {
    std::string changed = text;
    const std::size_t at = changed.find(from, after);
    EXPECT_NE(at, std::string::npos) << from;
    writeBytes(folder / "p.vti", changed.replace(at, from.size(), to));
    SourceOptions options;
    options.grid = grid;
    const auto read = readSequence(folder / "p.vti", options);
    return read ? std::string() : read.error().message;
  };
  const std::string all = text.substr(second, text.find("</Piece>", second) - second);
  for (const char* grid : {"", "k"}) {
    EXPECT_EQ(said("\"k\"", "\"k\"", second, grid), "");
    for (const auto& [from, to] :
         {std::pair(std::string("\"k\""), "\"K\""), {all, ""}, {all, "<CellData/>"}}) {
      EXPECT_THAT(said(from, to, second, grid), HasSubstr("in 1 of 2 pieces")) << to;
      if (to == std::string("\"K\"")) {
        EXPECT_THAT(said(from, to, 0, grid), HasSubstr("in 1 of 2 pieces"));
      }
    }
  }
  // What is asked for is in all pieces, and the other one in none of the cells.
  EXPECT_EQ(said(
                "<CellData>",
                "<CellData><DataArray type=\"Int8\" Name=\"m\" format=\"ascii\">" +
                    [] {
                      std::string ones;
                      for (int i = 0; i < 32; ++i) ones += "1 ";
                      return ones;
                    }() +
                    "</DataArray>",
                second, "k"),
            "");
  EXPECT_THAT(said("Float32", "Float64", second),
              HasSubstr("'k' is of 1 x Float64, in a piece before it of 1 x Float32"));
  EXPECT_THAT(said("\"k\"", "\"k\" NumberOfComponents=\"3\"", second), HasSubstr("of 3 x Float32"));
  EXPECT_THAT(said("<CellData>",
                   "<CellData><DataArray type=\"UInt8\" Name=\"vtkGhostType\" format=\"ascii\">0"
                   "</DataArray>",
                   0),
              HasSubstr("'vtkGhostType' is in 1 of 2 pieces"));
}

TEST(Vtk, HiddenCellsHaveNoValue) {
  const TempFolder folder;
  std::string text = inPieces({{0, 4, 0, 4, 0, 4}}), marks;
  for (int k = 0; k < 64; ++k)
    marks += k < 3 ? "32 " : k == 3 ? "1 " : "0 ";  // 1: of another piece too
  text.insert(
      text.find("<DataArray"),
      "<DataArray type=\"UInt8\" Name=\"vtkGhostType\" format=\"ascii\">" + marks + "</DataArray>");
  text.replace(text.find(">1 ") + 1, 1, "7");  // what stands there is no value
  writeBytes(folder / "h.vti", text);
  std::vector<std::string> remarks;
  SourceOptions options;
  options.remark = [&](const Remark& remark) { remarks.push_back(remark.sentence); };
  ASSERT_VALUE(const auto read, readSequence(folder / "h.vti", options));
  for (std::size_t k = 0; k < 64; ++k) EXPECT_EQ(read.values[k], k < 3 ? 0 : 1) << k;
  EXPECT_THAT(remarks, ElementsAre(HasSubstr("3 of its values are marked as hidden")));
}

TEST(Vtk, ALaterFrameWithoutTheArrayIsRefused) {
  const TempFolder folder;
  const std::string text = inPieces({{0, 4, 0, 4, 0, 4}});
  std::string other = text;
  other.replace(other.find("\"k\""), 3, "\"K\"");
  writeBytes(folder / "a_0000.vti", text);
  writeBytes(folder / "a_0001.vti", other);
  writeBytes(folder / "a_0002.vti", text);
  const auto read = readSequence(folder / "a_%04d.vti");
  ASSERT_FALSE(read);
  EXPECT_THAT(read.error().message, HasSubstr("a_0001.vti: no"));
  EXPECT_THAT(read.error().message, HasSubstr("did you mean 'K'?"));
}

TEST(Vtk, DamagedFramesOfASequenceAreNamedTogether) {
  const TempFolder folder;
  const std::string text = inPieces({{0, 4, 0, 4, 0, 4}});
  const auto said = [&](const std::set<int>& damaged) {
    for (int i = 0; i < 4; ++i) {
      writeBytes(folder / fmt::format("a_{}.vti", i),
                 damaged.contains(i) ? text.substr(0, text.size() / 2) : text);
    }
    const auto read = readSequence(folder / "a_%d.vti");
    return read ? std::string() : read.error().message;
  };
  EXPECT_EQ(said({}), "");
  EXPECT_THAT(said({1}), EndsWith(" (frame 1); without that file the sequence has a gap there"));
  EXPECT_THAT(said({1, 3}), EndsWith(" (frame 1; nor can be used 3); without these files the "
                                     "sequence has gaps there"));
  EXPECT_THAT(said({0, 1, 2, 3}), EndsWith(" (frame 0; nor can be used 1, 2, 3)"));
}

TEST(Vtk, TheTimeThatAFileStatesIsItsTime) {
  const TempFolder folder;
  const std::string text = inPieces({{0, 4, 0, 4, 0, 4}});
  int number = 0;
  for (const auto& [name, time] :
       {std::pair("TimeValue", "0"), {"TIME", "2.5"}, {"timevalue", "10"}}) {
    std::string timed = text;
    timed.insert(timed.find("<Piece"),
                 fmt::format("<FieldData><DataArray type=\"Float64\" Name=\"{}\" "
                             "NumberOfTuples=\"1\" format=\"ascii\">{}</DataArray></FieldData>",
                             name, time));
    writeBytes(folder / fmt::format("a_{}.vti", number++), timed);
  }
  ASSERT_VALUE(const auto read, readSequence(folder / "a_%d.vti"));
  EXPECT_EQ(read.info.times, (std::vector<double>{0, 2.5, 10}));
  std::filesystem::rename(folder / "a_0.vti", folder / "a_3.vti");  // 2.5, 10, 0
  std::vector<std::string> remarks;
  SourceOptions options;
  options.remark = [&](const Remark& remark) { remarks.push_back(remark.sentence); };
  ASSERT_VALUE(const auto other, readSequence(folder / "a_%d.vti", options));
  EXPECT_EQ(other.info.times.size(), 3U);
  ASSERT_EQ(remarks.size(), 1U);
  EXPECT_THAT(remarks[0], HasSubstr("a_3.vti: states 0 s, which is not after"));

  // A collection may say otherwise, or name a file twice.
  const auto remarksOf = [&](const std::string& times) {
    remarks.clear();
    writeBytes(folder / "s.pvd",
               "<VTKFile type=\"Collection\"><Collection>" + times + "</Collection></VTKFile>");
    const auto collected = readSequence(folder / "s.pvd", options);
    return collected ? remarks : std::vector<std::string>{collected.error().message};
  };
  const std::string first = R"(<DataSet timestep="2.5" file="a_1.vti"/>)";
  EXPECT_THAT(remarksOf(first + R"(<DataSet timestep="10" file="a_2.vti"/>)"), IsEmpty());
  EXPECT_THAT(remarksOf(first + R"(<DataSet timestep="3" file="a_2.vti"/>)"),
              ElementsAre(HasSubstr("a_2.vti: states 10 s itself")));
  EXPECT_THAT(remarksOf(first + R"(<DataSet timestep="3" file="a_1.vti"/>)"),
              ElementsAre(HasSubstr("a_1.vti: is there at 2.5 s and at 3 s")));
}

TEST(Vtk, MisspeltAttributesAreRefused) {
  const auto said = [&](const std::string& from, const std::string& to) {
    return errorOfChanged(asciiFile("", kPoints, ""), from, to);
  };
  EXPECT_EQ(said("Origin", "Origin"), "");
  EXPECT_THAT(said("Spacing", "Spaci.g"),
              HasSubstr("'Spaci.g' is unknown; did you mean 'Spacing'?"));
  EXPECT_THAT(said("Origin", "Origan"), HasSubstr("did you mean 'Origin'?"));
  EXPECT_THAT(said("Origin=\"10 0 0\"", "Origin=\"-1 -100\""),
              HasSubstr("Origin is '-1 -100'; expected 3 numbers with spaces between them"));
  EXPECT_THAT(said("0.5 1 1", "0,5 1 1"), HasSubstr("Spacing is '0,5 1 1'"));
  EXPECT_THAT(said("WholeExtent=\"2 4 0 1 0 1\"", "WholeExtent=\"2 4 0 1 0 1 9\""),
              HasSubstr("expected 6 whole numbers"));
  EXPECT_THAT(said("byte_order=\"LittleEndian", "byte_order=\"LittleEndiqn"),
              HasSubstr("byte_order"));
  // Other programs add names of their own.
  EXPECT_EQ(said("Origin=", "Author=\"us\" Origin="), "");
  EXPECT_EQ(said("<DataArray ", "<DataArray unit=\"1/m\" "), "");
}

TEST(Vtk, DamagedFilesAreErrors) {
  const TempFolder folder;
  auto written = makeBlob(1, 3, 4, 5);
  ASSERT_TRUE(ok(writeAll(folder / "a.vti", written)));
  const std::string bytes = readBytes(folder / "a.vti");
  const std::size_t whole = bytes.find_last_of('>');
  expectCutsRefused(
      folder / "b.vti", bytes.substr(0, whole),
      [](const std::filesystem::path& file) { return readSequence(file); }, 1 + bytes.size() / 100);
  writeBytes(folder / "b.vti", bytes.substr(0, whole));
  EXPECT_FALSE(readSequence(folder / "b.vti"));
  std::mt19937 random(1);
  SourceOptions options;
  options.maxMemory = 16 << 20;
  for (int i = 0; i < 100; ++i) {
    writeBytes(folder / "b.vti", withFlippedBit(bytes, random() % (8 * bytes.size())));
    const auto read = readSequence(folder / "b.vti", options);
    EXPECT_TRUE(read || !read.error().message.empty());
  }
}

TEST(Vtk, DamagedCollectionsAreErrors) {
  const TempFolder folder;
  ASSERT_TRUE(ok(writeAll(folder / "s.pvd", makeSeries(1))));
  const std::string bytes = readBytes(folder / "s.pvd");
  expectCutsRefused(
      folder / "b.pvd", bytes.substr(0, bytes.find_last_of('>') + 1),
      [](const std::filesystem::path& file) { return openSource(file, {}); }, 7);
  const auto refused = [&](const std::string& from, const std::string& to) {
    std::string text = bytes;
    text.replace(text.find(from), from.size(), to);
    writeBytes(folder / "b.pvd", text);
    const auto source = openSource(folder / "b.pvd", {});
    return source ? std::string() : source.error().message;
  };
  EXPECT_THAT(refused("timestep=\"0.5\"", "timestep=\"0\""), HasSubstr("must ascend"));
  EXPECT_THAT(refused("part=\"0\"", "part=\"1\""), HasSubstr("part 1"));
  EXPECT_THAT(refused("s_0005.vti", "mesh.vtu"), HasSubstr("expected a collection of .vti"));
  EXPECT_THAT(refused("s_0005.vti", "s_0004.vti"), HasSubstr("s_0004.vti"));
  EXPECT_EQ(refused("s_0005.vti", ".\\S_0005.VTI"), "");  // as on Windows
}

TEST(Vtk, AFullDiskLeavesNothing) {
  const auto sequence = makeBlob(1, 32, 32, 32);
  expectFullDiskLeavesNothing(
      4096, [&](const TempFolder& folder) { return writeAll(folder / "a.vti", sequence); });
}

#else

TEST(Vtk, ABuildWithoutItSaysSo) {
  const TempFolder folder;
  writeBytes(folder / "a.vti", "");
  EXPECT_THAT(readSequence(folder / "a.vti").error().message, HasSubstr("this build has no VTK"));
  EXPECT_THAT(writeAll(folder / "b.pvd", makeBlob(1, 1, 1, 1)).error().message,
              HasSubstr("VOLUTE_WITH_VTK=OFF"));
}

#endif

}  // namespace
}  // namespace volute
