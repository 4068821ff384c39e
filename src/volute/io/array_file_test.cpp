// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/array_file.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>

#include "volute/grid/rounding_source.hpp"
#include "volute/io/testing.hpp"
#include "volute/io/volume_source.hpp"

namespace volute {
namespace {

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
#endif

}  // namespace
}  // namespace volute
