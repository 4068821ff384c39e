// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <gtest/gtest.h>

#include <cmath>

#include "volute/codec/bundle.hpp"
#include "volute/codec/codec_testing.hpp"
#include "volute/codec/compress.hpp"
#include "volute/codec/join.hpp"
#include "volute/grid/array_source.hpp"
#include "volute/grid/look_figures.hpp"

namespace volute {
namespace {

using namespace testing;

/// The values of a sequence, where they are.
ArraySource sourceOf(const Sequence& sequence) {
  return {sequence.info, NumberArray{reinterpret_cast<const std::byte*>(sequence.values.data()),
                                     NumberType{}, denseStrides(sequence.info, NumberType{})}};
}

Status write(const Sequence& sequence, const std::filesystem::path& path) {
  ArraySource source = sourceOf(sequence);
  CompressOptions options;
  options.target = {ErrorTarget::Kind::kRms, 1e-2};
  Progress quiet;
  VOLUTE_TRY(compress(source, path, options, quiet));
  return {};
}

std::optional<LookFigures> lookIn(const std::filesystem::path& path) {
  const auto reader = VoluteReader::open(path);
  return reader ? reader->grid().look : std::nullopt;
}

TEST(Look, AFileHasTheFiguresOfItsSource) {
  const Sequence sequence = plumes(5, 20, 18, 22);
  ArraySource source = sourceOf(sequence);
  const auto figures = lookFigures(source);
  ASSERT_TRUE(figures.has_value());
  EXPECT_TRUE(figures->any());
  // Of frames 1, 2 and 4, by what they are defined as.
  double most = 0, column = 0;
  const VolumeInfo& info = sequence.info;
  const double step = info.bounds.size().z() / info.z;
  for (const int t : {1, 2, 4}) {
    std::vector<double> sums;
    for (int y = 0; y < info.y; ++y)
      for (int x = 0; x < info.x; ++x) {
        double sum = 0;
        for (int z = 0; z < info.z; ++z) {
          const double value = sequence.view()(t, z, y, x, 0);
          most = std::max(most, value);
          sum += step * std::max(value, 0.0);
        }
        if (sum > 0)
          sums.push_back(sum);
      }
    std::ranges::sort(sums);
    column = std::max(column,
                      sums[static_cast<std::size_t>(0.9 * static_cast<double>(sums.size() - 1))]);
  }
  EXPECT_EQ(figures->most, most);
  EXPECT_NEAR(figures->column, column, 1e-9 * column);
  const ScratchFile file;
  ASSERT_TRUE(write(sequence, file.path()).has_value());
  EXPECT_EQ(lookIn(file.path()), *figures);
}

TEST(Look, AFileSaysHowMuchIsInItsFrames) {
  Sequence sequence = plumes(4, 20, 18, 22);
  const std::size_t frame = sequence.info.frameValues();
  std::fill_n(sequence.values.begin(), frame, 0.0F);
  for (std::size_t i = 3 * frame; i < sequence.values.size(); ++i) sequence.values[i] *= 2;
  const ScratchFile file, later, joined;
  ASSERT_TRUE(write(sequence, file.path()).has_value());
  const auto reader = VoluteReader::open(file.path());
  ASSERT_TRUE(reader.has_value());
  const FrameAmounts amounts = reader->header().amounts;
  ASSERT_EQ(amounts.shares.size(), 4u);
  EXPECT_EQ(amounts.shares[0], 0);
  EXPECT_GT(amounts.shares[2], 0);
  EXPECT_EQ(amounts.shares[3], 255);
  for (float& value : sequence.values) value *= 10;
  for (int& number : sequence.info.frameNumbers) number += 4;
  for (double& time : sequence.info.times) time += 1;
  ASSERT_TRUE(write(sequence, later.path()).has_value());
  Progress quiet;
  ASSERT_TRUE(join({file.path(), later.path()}, joined.path(), {}, quiet).has_value());
  const auto whole = VoluteReader::open(joined.path());
  ASSERT_TRUE(whole.has_value());
  const auto& shares = whole->header().amounts.shares;
  ASSERT_EQ(shares.size(), 8u);
  EXPECT_EQ(shares[7], 255);
  EXPECT_NEAR(shares[3], 25.5, 1);
  EXPECT_EQ(shares[4], 0);
}

TEST(Look, ColoursHaveNone) {
  const ScratchFile file;
  ASSERT_TRUE(write(plumes(2, 8, 8, 8, 3), file.path()).has_value());
  EXPECT_FALSE(lookIn(file.path()).has_value());
}

TEST(Look, JoinedAndBundledFilesHaveIt) {
  Sequence one = plumes(16, 9, 10, 11), other = plumes(16, 9, 10, 11);
  for (float& value : other.values) value *= 3;
  for (int& number : other.info.frameNumbers) number += 16;
  for (double& time : other.info.times) time += 16 / 25.0;
  const ScratchFile first, second, joined, bundled;
  ASSERT_TRUE(write(one, first.path()).has_value());
  ASSERT_TRUE(write(other, second.path()).has_value());
  Progress quiet;
  const auto report = join({first.path(), second.path()}, joined.path(), {}, quiet);
  ASSERT_TRUE(report.has_value()) << report.error().message;
  EXPECT_TRUE(report->copied);
  EXPECT_EQ(lookIn(joined.path()), lookIn(second.path()));
  EXPECT_NE(lookIn(first.path()), lookIn(second.path()));
  const auto bytes = bundle(
      {{.name = "a", .file = joined.path()}, {.name = "b"}, {.name = "c", .file = joined.path()}},
      {}, bundled.path(), quiet);
  ASSERT_TRUE(bytes.has_value()) << bytes.error().message;
  const auto reader = VoluteReader::open(bundled.path(), {.grid = "c"});
  ASSERT_TRUE(reader.has_value());
  EXPECT_EQ(reader->grids()[0].look, lookIn(second.path()));
  EXPECT_FALSE(reader->grids()[1].look.has_value());
  EXPECT_EQ(reader->grid().look, lookIn(second.path()));
}

}  // namespace
}  // namespace volute
