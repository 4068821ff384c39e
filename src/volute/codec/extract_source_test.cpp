// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/extract_source.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "volute/base/program.hpp"
#include "volute/codec/compress.hpp"
#include "volute/grid/sequence.hpp"

namespace volute {
namespace {

/// A smooth sequence of awkward sizes in a file that is gone at the end.
class ExtractSourceTest : public ::testing::Test {
 protected:
  void SetUp() override {
    original_ = makeSequence(19, 18, 21, 37);
    auto view = original_.view();
    for (int t = 0; t < 19; ++t) {
      for (int z = 0; z < 18; ++z) {
        for (int y = 0; y < 21; ++y) {
          for (int x = 0; x < 37; ++x) {
            view(t, z, y, x, 0) =
                static_cast<float>(std::sin(0.2 * x + 0.1 * t) + std::cos(0.3 * y) + 0.05 * z);
          }
        }
      }
    }
    SequenceSource source(original_);
    CompressOptions options;
    options.target = {ErrorTarget::Kind::kRms, 1e-3};
    Progress progress;
    const auto report = compress(source, path_, options, progress);
    ASSERT_TRUE(report) << report.error().message;
    auto opened = VoluteReader::open(path_);
    ASSERT_TRUE(opened) << opened.error().message;
    reader_ = std::make_shared<const VoluteReader>(std::move(*opened));
    whole_ = *readAll(*frameSource(reader_), UINT64_MAX);
  }

  Result<Sequence> extract(Extraction extraction) {
    Progress progress;
    VOLUTE_ASSIGN(auto source, ExtractSource::create(reader_, std::move(extraction), progress));
    return readAll(*source, UINT64_MAX);
  }

  const ScratchFolder folder_;
  const std::filesystem::path path_ = folder_ / "a.volute";
  Sequence original_, whole_;
  std::shared_ptr<const VoluteReader> reader_;
};

TEST_F(ExtractSourceTest, ARegionIsThatPartOfTheWhole) {
  const Region region{{5, 0, 15}, {33, 21, 17}};
  const auto part = extract({{0, 3, 15, 16, 18}, region});
  ASSERT_TRUE(part) << part.error().message;
  EXPECT_EQ(part->info.frameNumbers, (std::vector{0, 3, 15, 16, 18}));
  const std::vector<int> positions{0, 3, 15, 16, 18};
  for (int i = 0; i < part->info.frames; ++i) {
    for (int z = 0; z < region.z(); ++z) {
      for (int y = 0; y < region.y(); ++y) {
        for (int x = 0; x < region.x(); ++x) {
          ASSERT_EQ(part->view()(i, z, y, x, 0), whole_.view()(positions[i], z + 15, y, x + 5, 0));
        }
      }
    }
  }
  const Vec3 voxel = whole_.info.voxelSize();
  EXPECT_TRUE(
      part->info.bounds.min.isApprox(whole_.info.bounds.min + voxel.cwiseProduct(Vec3(5, 0, 15))));
  EXPECT_TRUE(part->info.voxelSize().isApprox(voxel));
}

TEST_F(ExtractSourceTest, LevelsKeepTheIntegralOfWholeBlocks) {
  const auto coarse = extract({{4}, {{0, 0, 0}, {37, 21, 18}}, 1});
  ASSERT_TRUE(coarse) << coarse.error().message;
  EXPECT_EQ(coarse->info.x, 19);
  EXPECT_EQ(coarse->info.y, 11);
  EXPECT_EQ(coarse->info.z, 9);
  EXPECT_TRUE(coarse->info.voxelSize().isApprox(2 * whole_.info.voxelSize()));
  // Frames 4 and 5 are one at this level.
  double fine = 0, sum = 0;
  for (const float value : whole_.frame(4)) fine += 0.5 * value;
  for (const float value : whole_.frame(5)) fine += 0.5 * value;
  for (const float value : coarse->values) sum += 8.0 * value;
  EXPECT_NEAR(sum, fine, 2.5e-2 * std::abs(fine));
}

TEST_F(ExtractSourceTest, TouchesOnlyTheBlocksItNeeds) {
  ASSERT_TRUE(extract({{17}, {{0, 0, 0}, {8, 8, 8}}}));
  Progress progress;
  const auto fresh = std::make_shared<const VoluteReader>(*VoluteReader::open(path_));
  auto source = *ExtractSource::create(fresh, {{17, 18}, {{0, 0, 0}, {8, 8, 8}}}, progress);
  ASSERT_TRUE(readAll(*source, UINT64_MAX));
  EXPECT_EQ(fresh->blocksDecoded(), 1u);
}

TEST_F(ExtractSourceTest, RefusesWhatIsOutsideOrTooLarge) {
  EXPECT_EQ(extract({{0}, {{0, 0, 0}, {38, 21, 18}}}).error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(extract({{0}, {{0, 0, 0}, {37, 21, 18}}, 0, 1000}).error().code, ErrorCode::kTooLarge);
}

}  // namespace
}  // namespace volute
