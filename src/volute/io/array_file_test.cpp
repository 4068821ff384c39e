// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/array_file.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>

#include "volute/grid/rounding_source.hpp"
#include "volute/io/testing.hpp"
#include "volute/io/volume_sink.hpp"
#include "volute/io/volume_source.hpp"

namespace volute {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using namespace testing;

TEST(NamedArray, IsSplitWhereTheFilesNameEnds) {
  const auto text = [](const char* input) {
    const auto named = namedArray(input);
    return named ? named->file.string() + "|" + named->name : "none";
  };
  EXPECT_EQ(text("run.nc"), "run.nc|");
  EXPECT_EQ(text("a/RUN.H5:/group/soot"), "a/RUN.H5|/group/soot");
  EXPECT_EQ(text("run.zarr/"), "run.zarr|");
  EXPECT_EQ(text("we:ird.nc:so:ot"), "we:ird.nc|so:ot");
  EXPECT_EQ(text("run.nc:"), "none");
  EXPECT_EQ(text("run.npy"), "none");
}

TEST(NamedArray, OfZarr3SaysWhatReadsIt) {
  const TempFolder folder;
  std::filesystem::create_directory(folder / "three.zarr");
  writeBytes(folder / "three.zarr/zarr.json", "{\"zarr_format\": 3, \"node_type\": \"group\"}");
  const auto opened = openArrayFile({folder / "three.zarr", "soot"}, {});
  ASSERT_FALSE(opened);
  EXPECT_THAT(opened.error().message,
              AllOf(HasSubstr("format 3"), HasSubstr("[\"soot\"], \"three.volute\")")));
}

#if VOLUTE_HAS_GDAL
void makeArrays(const char* driver, const std::filesystem::path& file, const char* more) {
  ASSERT_EQ(
      std::system(
          fmt::format("{} {} '{}' {}", VOLUTE_ARRAY_MAKER, driver, file.string(), more).c_str()),
      0);
}

class ArrayFile : public ::testing::TestWithParam<std::pair<const char*, const char*>> {
 protected:
  void write(const char* more) { makeArrays(GetParam().first, file(), more); }

  std::filesystem::path file() const { return folder_ / GetParam().second; }

  TempFolder folder_;
};

INSTANTIATE_TEST_SUITE_P(Kinds, ArrayFile,
                         ::testing::Values(std::pair("netCDF", "a.nc"), std::pair("netCDF", "a.h5"),
                                           std::pair("Zarr", "a.zarr")));

TEST_P(ArrayFile, HasAxesByACommonEndingAndByWhatTheirCoordinatesState) {
  for (const char* how : {"m apart", "m axis"}) {
    std::filesystem::remove_all(file());
    write(how);
    std::vector<std::string> told;
    SourceOptions options;
    options.grid = "soot";
    options.remark = [&](const Remark& remark) { told.push_back(remark.sentence); };
    const auto opened = openSource(file(), options);
    ASSERT_TRUE(opened) << how << ": " << opened.error().message;
    const VolumeInfo& info = (*opened)->info();
    EXPECT_THAT((std::array{info.frames, info.z, info.y, info.x, info.channels}),
                ElementsAre(3, 4, 5, 2, 3))
        << how;
    EXPECT_THAT(info.times, ElementsAre(0, 60, 120)) << how;
    EXPECT_EQ(info.bounds.max, Vec3(0.75, 2.25, 1.75)) << how;
    for (const std::string& sentence : told)
      EXPECT_THAT(sentence, ::testing::Not(HasSubstr("by their order"))) << how;
  }
}

TEST_P(ArrayFile, HasAxesPlacesTimesAndScaledNumbers) {
  write("cm");
  SourceOptions options;
  options.grid = "soot";
  const auto opened = openSource(file(), options);
  ASSERT_TRUE(opened) << opened.error().message;
  FrameSource& source = **opened;
  EXPECT_EQ(source.info().name, "soot");
  EXPECT_EQ(source.info().unit, "kg/m3");
  EXPECT_THAT(source.info().times, ElementsAre(0, 60, 120));
  ASSERT_EQ(source.info().z, 4);
  ASSERT_EQ(source.info().x, 6);
  EXPECT_LT((source.info().bounds.min - Vec3::Constant(-0.0025)).norm(), 1e-9);
  EXPECT_LT((source.info().bounds.max - Vec3(0.0275, 0.0225, 0.0175)).norm(), 1e-9);
  EXPECT_THAT(source.otherGrids(), ElementsAre("flat"));
  std::vector<float> layers(2 * 5 * 6);
  ASSERT_TRUE(source.readLayers(2, 1, 3, layers));
  for (int i = 0; i < 60; ++i) {
    const int meant = 2000 + 100 * (1 + i / 30) + 10 * (i / 6 % 5) + i % 6;
    ASSERT_NEAR(layers[static_cast<std::size_t>(i)], 0.1 * meant, 1e-4) << i;
  }
  EXPECT_GT(roundingOf(source), 0);
}

TEST_P(ArrayFile, UnitsThatAreNotStatedAreTold) {
  std::vector<std::string> told;
  SourceOptions options;
  options.grid = "soot";
  options.remark = [&](const Remark& remark) { told.push_back(remark.sentence); };
  write("cm");
  ASSERT_TRUE(openSource(file(), options));
  EXPECT_THAT(told, ElementsAre());
  std::filesystem::remove_all(file());
  write("''");
  ASSERT_TRUE(openSource(file(), options));
  EXPECT_THAT(told, ElementsAre(HasSubstr("coordinates without units: x is taken in m, y is taken "
                                          "in m, z is taken in m")));
}

TEST_P(ArrayFile, AxesWithoutNamesAreTakenByOrder) {
  write("m");
  const auto opened = openSource(file().string() + ":flat", {});
  ASSERT_TRUE(opened) << opened.error().message;
  EXPECT_EQ((*opened)->info().frames, 3);
  EXPECT_EQ((*opened)->info().y, 5);
  std::vector<float> frame(120);
  ASSERT_TRUE((*opened)->readFrame(1, frame));
  EXPECT_NEAR(frame[7], 0.1 * 1311, 1e-4);  // the first layer is the topmost
}

TEST_P(ArrayFile, WhatWasNeverWrittenIsNoNumber) {
  write("m hole");
  const auto opened = openSource(file().string() + ":soot", {});
  ASSERT_TRUE(opened) << opened.error().message;
  std::vector<float> frame(120);
  ASSERT_TRUE((*opened)->readFrame(0, frame));
  EXPECT_TRUE(std::isnan(frame[3 * 30 + 7]));
}

TEST_P(ArrayFile, SaysWhatIsMissingOrUnknown) {
  write("degrees_north");
  const auto failure = [&](const SourceOptions& options, const std::string& array) {
    const auto opened = openSource(file().string() + array, options);
    return opened ? std::string("opened") : opened.error().message;
  };
  EXPECT_THAT(failure({}, ""), HasSubstr("which array?"));
  EXPECT_THAT(failure({}, ":fog"), HasSubstr("no array named 'fog'"));
  EXPECT_THAT(failure({}, ":soot"), HasSubstr("is in 'degrees_north'"));
  SourceOptions placed;
  placed.bounds = Box3{Vec3(0, 0, 0), Vec3(1, 1, 1)};
  EXPECT_EQ(failure(placed, ":soot"), "opened");
  placed.grid = "flat";
  EXPECT_THAT(failure(placed, ":soot"), HasSubstr("say one"));
}

TEST(ArrayOutput, IsReadAsItWasWritten) {
  const TempFolder folder;
  for (const auto& [name, channels, offset] :
       {std::tuple("a.nc", 1, 0.0), std::tuple("a.h5", 3, 0.0), std::tuple("b.nc", 1, 1e6)}) {
    VolumeInfo info;
    info.name = "soot";
    info.unit = "1/m";
    info.x = 5, info.y = 4, info.z = 18, info.channels = channels, info.frames = 2;
    info.bounds = {Vec3(-1, 0, 2), Vec3(1, 1, 3)};
    info.times = {0.5, 2};
    info.fillDefaults();
    std::vector<float> values(info.frameValues());
    const auto valueAt = [](int frame, std::size_t i) {
      return static_cast<float>(100 * frame) + 0.25F * static_cast<float>(i % 97);
    };
    {
      const auto sink = createSink(folder / name, info, {.offset = offset});
      ASSERT_TRUE(sink) << sink.error().message;
      for (int frame = 0; frame < 2; ++frame) {
        EXPECT_FALSE(std::filesystem::exists(folder / name));
        for (std::size_t i = 0; i < values.size(); ++i) values[i] = valueAt(frame, i);
        ASSERT_TRUE((*sink)->writeFrame(values));
      }
      ASSERT_TRUE((*sink)->finish());
    }
    const auto source = openSource(folder / name, {});
    ASSERT_TRUE(source) << source.error().message;
    const VolumeInfo& read = (*source)->info();
    EXPECT_EQ(read.name, "soot");
    EXPECT_EQ(read.unit, "1/m");
    EXPECT_EQ(read.times, info.times);
    EXPECT_EQ(read.channels, channels);
    EXPECT_LT(
        (read.bounds.min - info.bounds.min).norm() + (read.bounds.max - info.bounds.max).norm(),
        1e-12);
    ASSERT_TRUE((*source)->readFrame(1, values));
    for (std::size_t i = 0; i < values.size(); ++i)
      ASSERT_EQ(values[i], static_cast<float>(offset + valueAt(1, i))) << i;
  }
}

TEST(ArrayOutput, SaysWhyItCannotBeWritten) {
  const TempFolder folder;
  VolumeInfo info;
  info.name = "a/b";
  info.x = info.y = info.z = info.frames = info.channels = 1;
  info.fillDefaults();
  const auto sink = createSink(folder / "a.nc", info);
  ASSERT_FALSE(sink);
  EXPECT_THAT(sink.error().message, HasSubstr("a.nc"));
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(ArrayFile, NoCutFileIsReadAsClearAir) {
  const TempFolder folder;
  makeArrays("netCDF", folder / "a.nc", "m");
  const auto size = std::filesystem::file_size(folder / "a.nc");
  for (const auto part : {size / 8, size / 2, size - 1}) {
    std::filesystem::resize_file(folder / "a.nc", part);
    const auto opened = openSource((folder / "a.nc").string() + ":soot", {});
    std::vector<float> frame(120);
    EXPECT_FALSE(opened && (*opened)->readFrame(2, frame)) << part;
    makeArrays("netCDF", folder / "a.nc", "m");
  }
  // A chunk of a Zarr array that is shorter than it was.
  makeArrays("Zarr", folder / "a.zarr", "m");
  std::filesystem::resize_file(folder / "a.zarr" / "soot" / "0.0.0.0", 30);
  const auto opened = openSource((folder / "a.zarr").string() + ":soot", {});
  ASSERT_TRUE(opened) << opened.error().message;
  std::vector<float> frame(120);
  EXPECT_FALSE((*opened)->readFrame(0, frame));
}

TEST(ArrayFileOfZarr, ChunksAreThereAndWholeOrAreTheFillValue) {
  const TempFolder folder;
  makeArrays("Zarr", folder / "a.zarr", "m");
  std::filesystem::remove(folder / "a.zarr" / ".zmetadata");
  const auto array = folder / "a.zarr" / "soot";
  const std::string said = readBytes(array / ".zarray"), chunk = readBytes(array / "0.0.0.0");
  const auto readWith = [&](const std::string& old, const std::string& value) -> Result<float> {
    std::string changed = said;
    changed.replace(changed.find(old), old.size(), value);
    writeBytes(array / ".zarray", changed);
    VOLUTE_ASSIGN(const auto opened, openSource((folder / "a.zarr").string() + ":soot", {}));
    std::vector<float> frame(120);
    VOLUTE_TRY(opened->readFrame(0, frame));
    return frame[97];  // in the topmost layer, which is stored first
  };
  const auto message = [&](const std::string& old, const std::string& value) {
    const auto read = readWith(old, value);
    return read ? "read" : read.error().message;
  };
  const std::string fill = "\"fill_value\":-1";
  EXPECT_EQ(message(fill, "\"fill_value\":null"), "read");
  EXPECT_THAT(message("\"zarr_format\"", "\"dimension_separator\":\"/\",\"zarr_format\""),
              HasSubstr("named by another dimension_separator"));
  writeBytes(array / "0.0.0.0", chunk + chunk);
  EXPECT_THAT(message(fill, fill), HasSubstr("has 120 bytes; expected 60"));
  std::filesystem::remove(array / "0.0.0.0");
  EXPECT_THAT(message(fill, "\"fill_value\":null"), HasSubstr("has no chunk 0.0.0.0"));
  EXPECT_EQ(readWith(fill, "\"fill_value\":0").value(), 0);
  EXPECT_TRUE(std::isnan(readWith(fill, fill).value()));
}

#if VOLUTE_HAS_HDF5
/// What is said of a file of HDF5 of this kind while it is read, and values of its frame 1.
std::string saidOfHdf5(const char* kind) {
  const TempFolder folder;
  makeArrays("HDF5", folder / "a.h5", kind);
  std::string told;
  SourceOptions options;
  options.grid = "soot";
  options.bounds = Box3{Vec3(0, 0, 0), Vec3(1, 1, 1)};
  options.remark = [&](const Remark& remark) { told += remark.sentence + " | "; };
  const auto opened = openSource(folder / "a.h5", options);
  if (!opened)
    return opened.error().message;
  std::vector<float> frame(8);
  const auto read = (*opened)->readFrame(1, frame);
  return told + (read ? fmt::format("{}", frame[0]) : read.error().message);
}

TEST(ArrayFileOfHdf5, NumbersInOtherFilesAreNotTheFillValue) {
  EXPECT_THAT(saidOfHdf5("virtual"),
              HasSubstr("'soot' is a virtual dataset over other.h5, and no other file is read"));
  EXPECT_THAT(saidOfHdf5("external"), HasSubstr("'soot' has its numbers in other.bin"));
  EXPECT_THAT(saidOfHdf5("link"), HasSubstr("is of type a link to other.h5:/soot"));
  EXPECT_EQ(saidOfHdf5("self"), "1");
}

TEST(ArrayFileOfHdf5, WhatWasNeverWrittenIsTold) {
  EXPECT_THAT(saidOfHdf5("hole"),
              HasSubstr("'soot': 1 of 3 chunks were never written; their values are the fill "
                        "value 7 | 7"));
  EXPECT_THAT(saidOfHdf5("never"),
              HasSubstr("'soot': was never written; its values are the fill value 7 | 7"));
  EXPECT_THAT(saidOfHdf5("open"),
              HasSubstr("1 of 3 chunks of 'soot' were never written, and it has no fill value"));
}

TEST(ArrayFileOfHdf5, AFilterThatIsNotHereIsNamed) {
  EXPECT_THAT(saidOfHdf5("filter"),
              HasSubstr("'soot' is packed by the HDF5 filter 511, which is not here"));
}
#endif
#endif

}  // namespace
}  // namespace volute
