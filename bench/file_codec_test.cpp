// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "bench/file_codec.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bench/codec_measurement.hpp"
#include "bench/scratch.hpp"

namespace volute::bench {
namespace {

/// A wandering blob that fades into exact zeros, sizes that are no multiples of anything.
Sequence blob(int channels) {
  Sequence sequence = makeSequence(5, 9, 13, 18, channels);
  const auto view = sequence.view();
  for (int t = 0; t < 5; ++t)
    for (int z = 0; z < 9; ++z)
      for (int y = 0; y < 13; ++y)
        for (int x = 0; x < 18; ++x)
          for (int c = 0; c < channels; ++c) {
            const double square =
                std::pow(z - 4.0, 2) + std::pow(y - 5.0 - t, 2) + std::pow(x - 9.0 + c, 2);
            view(t, z, y, x, c) = static_cast<float>(std::pow(std::max(0.0, 1.3 - square / 40), 3) *
                                                     (1 + 0.1 * std::sin(x * y)));
          }
  return sequence;
}

class EveryFileCodec : public ::testing::TestWithParam<FileCodecEntry> {};

TEST_P(EveryFileCodec, KeepsTheErrorThatIsAskedFor) {
  const auto codec = GetParam().make();
  if (!codec)
    GTEST_SKIP() << codec.error().message;
  const auto scratch = ScratchFolder::create();
  ASSERT_TRUE(scratch);
  Progress quiet;
  for (const int channels : {1, 3}) {
    for (const double target : {1e-2, 1e-3}) {
      const auto files =
          encodeWithin(**codec, blob(channels), target, scratch->path() / "files", 1, quiet);
      ASSERT_TRUE(files) << files.error().message;
      EXPECT_LE(files->relativeRms, target) << channels;
      EXPECT_GT(files->bytes, 0u);
      if ((*codec)->setting() == FileCodec::Setting::kTolerance) {
        EXPECT_GT(files->relativeRms, 0.8 * target) << channels;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, EveryFileCodec, ::testing::ValuesIn(fileCodecs()),
                         [](const auto& info) {
                           std::string name(info.param.name);
                           std::erase_if(name, [](char c) { return !std::isalnum(c); });
                           return name;
                         });

TEST(ScratchFolder, LeavesNothingBehind) {
  std::filesystem::path path;
  {
    const auto scratch = ScratchFolder::create();
    ASSERT_TRUE(scratch);
    path = scratch->path();
    std::filesystem::create_directory(path / "deeper");
    EXPECT_TRUE(std::filesystem::exists(path));
  }
  EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace volute::bench
