// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/volume_files/volume_writer.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "volute/grid/sequence.hpp"
#include "volute/io/testing.hpp"
#include "volute/volume_files/grid_compression.hpp"
#include "volute/volume_files/volume_resampling.hpp"

namespace volute {
namespace {

using ::testing::HasSubstr;
using ::testing::UnorderedElementsAre;
using volute::testing::TempFolder;

Sequence ramp(const std::string& name, int channels) {
  Sequence sequence = makeSequence(3, 8, 8, 8, channels);
  sequence.info.name = name;
  for (std::size_t i = 0; i < sequence.values.size(); ++i)
    sequence.values[i] = static_cast<float>(i % 97);
  return sequence;
}

class VolumeWriterTest : public ::testing::Test {
 protected:
  Result<Report> write(std::vector<WrittenGrid> grids, const std::string& name) {
    Report report;
    VOLUTE_ASSIGN(auto writer, VolumeWriter::open(std::move(grids), (folder_ / name).string(),
                                                  "made here", reading_, team_));
    VOLUTE_TRY(writer.write(report));
    return report;
  }

  /// Of each grid of a file.
  std::vector<std::string> gridsOf(const std::string& name) {
    std::vector<std::string> names;
    const auto grids = VolumeGrids::open((folder_ / name).string(), {}, reading_).value();
    for (const VolumeGrid& grid : grids->grids()) names.push_back(grid.name);
    return names;
  }

  TempFolder folder_;
  Progress quiet_;
  Reading reading_{quiet_, std::uint64_t{1} << 30};
  Team team_;
  Sequence light_ = ramp("emission", 1), speed_ = ramp("velocity", 3);
  SequenceSource lightSource_{light_}, speedSource_{speed_};
};

TEST_F(VolumeWriterTest, OneGridGoesIntoAnyFormat) {
  const auto compressed = write({{&lightSource_, 0.01}}, "a.volute");
  ASSERT_TRUE(compressed) << compressed.error().message;
  EXPECT_LE(compressed->json()["relative_rms"].get<double>(), 0.01);
  EXPECT_EQ(compressed->json()["bytes"], std::filesystem::file_size(folder_ / "a.volute"));
  const auto plain = write({{&lightSource_}}, "a.npy");
  ASSERT_TRUE(plain) << plain.error().message;
  EXPECT_TRUE(plain->json().empty());
  const auto npy = openVolume((folder_ / "a.npy").string(), {}, reading_).value();
  EXPECT_EQ(readAll(*npy.source, 1 << 20).value().values, light_.values);
  const auto wrong = write({{&lightSource_}}, "a.xyz");
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error().message, HasSubstr("expected .volute, .npy"));
}

TEST_F(VolumeWriterTest, SeveralGridsGoIntoOneFileOrOneEach) {
  const std::vector<WrittenGrid> both{{&lightSource_, 0.001}, {&speedSource_, 0.02}};
  const auto compressed = write(both, "b.volute");
  ASSERT_TRUE(compressed) << compressed.error().message;
  EXPECT_LE(compressed->json()["relative_rms"].get<double>(), 0.001);
  EXPECT_LE(compressed->json()["velocity_relative_rms"].get<double>(), 0.02);
  EXPECT_GT(compressed->json()["velocity_relative_rms"].get<double>(), 0.001);
  EXPECT_THAT(gridsOf("b.volute"), UnorderedElementsAre("emission", "velocity"));
  ASSERT_TRUE(write(both, "b_{grid}.npy"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "b_emission.npy"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "b_velocity.npy"));
  EXPECT_TRUE(holdsSeveralGrids("b_%04d.vdb"));
  EXPECT_FALSE(holdsSeveralGrids("b.npy"));
}

TEST_F(VolumeWriterTest, GridsOfAFileAreCompressedAgain) {
  ASSERT_TRUE(write({{&lightSource_}, {&speedSource_}}, "c.volute"));
  const std::string file = (folder_ / "c.volute").string(), out = (folder_ / "d.volute").string();
  GridCompression how;
  how.options.target = {ErrorTarget::Kind::kRms, 0.01};
  how.rms["velocity"] = 0.05;
  const auto all = compressVolume(file, out, how, {}, reading_, team_);
  ASSERT_TRUE(all) << all.error().message;
  EXPECT_EQ(all->json()["grids"].size(), 2U);
  EXPECT_TRUE(all->json().contains("input_bytes"));
  EXPECT_THAT(gridsOf("d.volute"), UnorderedElementsAre("emission", "velocity"));

  InputOptions input;
  input.grid = "emission";
  EXPECT_THAT(compressVolume(file, out, how, input, reading_, team_).error().message,
              HasSubstr("which is not to be compressed"));
  how.rms.clear();
  how.frames = {1, std::nullopt, 1};
  const auto one = compressVolume(file, out, how, input, reading_, team_);
  ASSERT_TRUE(one) << one.error().message;
  EXPECT_EQ(one->json()["frames"], 2);
  EXPECT_FALSE(one->json().contains("input_bytes"));
  input = {};
  input.bounds = Box3{{0, 0, 0}, {1, 1, 1}};
  const auto refused = compressVolume(file, out, how, input, reading_, team_);
  EXPECT_EQ(refused.error().member, "bounds");
  EXPECT_THAT(refused.error().message, HasSubstr("is for one grid"));
}

TEST_F(VolumeWriterTest, WhatIsReadIsNotReplaced) {
  ASSERT_TRUE(write({{&lightSource_}}, "a.npy"));
  ASSERT_TRUE(write({{&lightSource_}}, "a.volute"));
  std::filesystem::create_symlink("a.volute", folder_ / "link.volute");
  const auto file = [&](const char* name) { return (folder_ / name).string(); };
  const auto expectRefused = [](const Result<Report>& done) {
    ASSERT_FALSE(done);
    EXPECT_EQ(done.error().code, ErrorCode::kInvalidArgument);
    EXPECT_THAT(done.error().message, HasSubstr("is read and would be replaced"));
  };
  const ResampleRequest request{.voxelSize = Vec3::Constant(0.25)};
  expectRefused(resampleVolume(file("a.npy"), file("a.npy"), request, reading_, team_));
  expectRefused(resampleVolume(file("a.volute"), file("link.volute"), request, reading_, team_));
  expectRefused(
      resampleVolume(file("a.npy"), file("a.volute"), {.like = file("a.volute")}, reading_, team_));
  expectRefused(compressVolume(file("link.volute"), file("a.volute"), {}, {}, reading_, team_));
  ASSERT_TRUE(write({{&lightSource_}}, "density.npy"));
  expectRefused(resampleVolume(file("density.npy"), file("{grid}.npy"), request, reading_, team_));
  EXPECT_TRUE(resampleVolume(file("a.volute"), file("b.volute"), request, reading_, team_));
}

}  // namespace
}  // namespace volute
