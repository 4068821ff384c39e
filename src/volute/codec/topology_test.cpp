// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <random>

#include "volute/codec/codec_testing.hpp"
#include "volute/codec/extract_source.hpp"
#include "volute/codec/join.hpp"
#include "volute/grid/compare.hpp"

namespace volute {
namespace {

using Kind = ErrorTarget::Kind;
using namespace testing;

VolumeInfo volume(int z, int y, int x, int channels = 1) {
  VolumeInfo info;
  info.x = x, info.y = y, info.z = z, info.channels = channels;
  return info;
}

/// A ball of smoke that moves; its leaves lie off the corner of the volume.
Bricks puff(float at, const std::array<float, 3>& background = {}, int channels = 1) {
  Bricks frame(channels, background);
  for (int z = -3; z < 45; z += 8)
    for (int y = -3; y < 45; y += 8)
      for (int x = -3; x < 45; x += 8) {
        Bricks::Leaf leaf{{x, y, z}};
        std::vector<float> values(static_cast<std::size_t>(Bricks::kVoxels * channels));
        bool any = false;
        for (int i = 0; i < Bricks::kVoxels; ++i) {
          const float dx = static_cast<float>(x + i % 8) - at,
                      dy = static_cast<float>(y + i / 8 % 8) - 20,
                      dz = static_cast<float>(z + i / 64) - 18;
          const float body = 1 - (dx * dx + dy * dy + dz * dz) / 80;
          if (body <= 0 || x + i % 8 < 0 || y + i / 8 % 8 < 0 || z + i / 64 < 0)
            continue;
          any = true;
          leaf.active[static_cast<std::size_t>(i / 64)] |= std::uint64_t{1} << i % 64;
          for (int c = 0; c < channels; ++c)
            values[static_cast<std::size_t>(c * Bricks::kVoxels + i)] =
                body * static_cast<float>(c + 1) + 0.1f * std::sin(dx * dy + dz);
        }
        if (!any)
          continue;
        leaf.valued = leaf.active;
        const auto to = frame.addLeaf(leaf);
        for (int i = 0; i < Bricks::kVoxels * channels; ++i)
          if ((leaf.active[static_cast<std::size_t>(i % Bricks::kVoxels / 64)] >> i % 64 & 1) != 0)
            to[static_cast<std::size_t>(i)] = values[static_cast<std::size_t>(i)];
      }
  return frame;
}

std::vector<Bricks> puffs(int frames) {
  std::vector<Bricks> all;
  for (int i = 0; i < frames; ++i) all.push_back(puff(12 + 0.7f * static_cast<float>(i)));
  return all;
}

/// What is anywhere in a frame, voxel by voxel of the volume.
struct Voxels {
  Voxels(const Bricks& frame, const VolumeInfo& info) : values(info.frameValues()) {
    const IndexBox box{{0, 0, 0}, {info.x, info.y, info.z}};
    frame.toDense(box, values);
    Bricks states(1);
    for (const Bricks::Leaf& leaf : frame.leaves()) {
      Bricks::Leaf both = leaf;
      both.active = both.valued = leaf.valued;
      const auto to = states.addLeaf(both);
      for (int i = 0; i < Bricks::kVoxels; ++i) {
        const auto bit = [&](const BrickMask& mask) {
          return static_cast<float>(mask[static_cast<std::size_t>(i / 64)] >> i % 64 & 1);
        };
        to[static_cast<std::size_t>(i)] = 2 * bit(leaf.active) + bit(leaf.valued);
      }
    }
    topology.resize(info.voxels());
    states.toDense(box, topology);
  }

  std::vector<float> values, topology;
};

struct Kept {
  CompressReport report;
  std::vector<Bricks> frames;
};

/// Through a file and back, with the same topology.
Kept throughFile(BrickFrames source, const CompressOptions& options) {
  const ScratchFile file;
  Progress progress;
  Kept kept;
  const auto report = compress(source, file.path(), options, progress);
  EXPECT_TRUE(report) << report.error().message;
  if (!report)
    return kept;
  kept.report = *report;
  auto reader = VoluteReader::open(file.path());
  EXPECT_TRUE(reader) << reader.error().message;
  if (!reader)
    return kept;
  EXPECT_TRUE(reader->hasTopology());
  EXPECT_TRUE(reader->verify().complete());
  const auto back = frameSource(std::make_shared<const VoluteReader>(std::move(*reader)));
  for (int i = 0; i < source.info().frames; ++i) {
    Bricks before, after;
    EXPECT_TRUE(source.readBricks(i, 0, source.info().z, before));
    EXPECT_TRUE(back->readBricks(i, 0, source.info().z, after));
    EXPECT_EQ(after.background(), before.background());
    EXPECT_TRUE(std::ranges::equal(after.tiles(), before.tiles()));
    const Voxels a(before, source.info()), b(after, source.info());
    EXPECT_EQ(a.topology, b.topology) << i;
    std::vector<float> dense(source.info().frameValues());
    EXPECT_TRUE(back->readFrame(i, dense));
    EXPECT_EQ(dense, b.values) << i;
    for (std::size_t k = 0; k < a.values.size(); ++k) {
      if (a.topology[k / static_cast<std::size_t>(source.info().channels)] == 0) {
        EXPECT_EQ(a.values[k], b.values[k]) << "not in use, at " << k << " of frame " << i;
        if (a.values[k] != b.values[k])
          return kept;
      }
    }
    kept.frames.push_back(std::move(after));
  }
  return kept;
}

TEST(Topology, ComesBackInEveryMode) {
  for (const BlockMode& mode : allBlockModes()) {
    CompressOptions options;
    options.mode = mode;
    options.target = {Kind::kRms, 1e-2};
    const auto kept = throughFile({volume(37, 40, 44), puffs(3)}, options);
    EXPECT_LE(kept.report.support.rms, 1e-2) << shortName(mode);
  }
}

TEST(Topology, ComesBackForEveryTarget) {
  for (const ErrorTarget target :
       {ErrorTarget{Kind::kRms, 3e-3}, ErrorTarget{Kind::kRms, 0.5},
        ErrorTarget{Kind::kRmsOverAll, 0.1}, ErrorTarget{Kind::kPsnr, 60},
        ErrorTarget{Kind::kRatio, 50}, ErrorTarget{Kind::kMaxError, 0.02},
        ErrorTarget{Kind::kLook, 3e-3}}) {
    CompressOptions options;
    options.target = target;
    const auto kept = throughFile({volume(37, 40, 44), puffs(18)}, options);
    if (target.kind == Kind::kMaxError) {
      EXPECT_LE(kept.report.maxError, 0.02);
    }
  }
}

TEST(Topology, ErrorsAreThoseOfWhatIsInUse) {
  const auto frames = puffs(5);
  const auto kept = throughFile({volume(37, 40, 44), frames}, {});
  double squares = 0, count = 0, greatest = 0, low = INFINITY, high = -INFINITY;
  int worst = 0;
  std::array<int, 3> place{};
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const Voxels a(frames[i], volume(37, 40, 44)), b(kept.frames[i], volume(37, 40, 44));
    for (std::size_t k = 0; k < a.values.size(); ++k) {
      if (a.topology[k] == 0)
        continue;
      const double error = std::abs(static_cast<double>(a.values[k]) - b.values[k]);
      squares += error * error, ++count;
      low = std::min<double>(low, a.values[k]), high = std::max<double>(high, a.values[k]);
      if (error > greatest) {
        greatest = error, worst = static_cast<int>(i);
        const int at = static_cast<int>(k);
        place = {at % 44, at / 44 % 40, at / 44 / 40};
      }
    }
  }
  const SupportError& support = kept.report.support;
  EXPECT_NEAR(support.rms, std::sqrt(squares / count) / (high - low), 1e-9);
  EXPECT_LE(support.rms, 3e-3);
  EXPECT_NEAR(support.share, count / (5.0 * 37 * 40 * 44), 1e-12);
  EXPECT_EQ(support.low, low);
  EXPECT_EQ(support.high, high);
  EXPECT_FALSE(support.robust);
  EXPECT_EQ(kept.report.maxError, greatest);
  EXPECT_EQ(support.worstFrame, worst);
  EXPECT_EQ(support.worstVoxel, place);
}

TEST(Topology, TheBoxDoesNotMatter) {
  CompressOptions options;
  const auto small = throughFile({volume(37, 40, 44), puffs(4)}, options);
  const auto large = throughFile({volume(300, 310, 320), puffs(4)}, options);
  EXPECT_NEAR(large.report.support.rms, small.report.support.rms, 3e-4);
  EXPECT_LT(large.report.fileBytes, small.report.fileBytes * 11 / 10);
  EXPECT_EQ(large.report.blocks, small.report.blocks);
}

TEST(Topology, OneValueApartDoesNotRuleTheError) {
  for (const float apart : {1e6f, -1e4f}) {
    auto frames = puffs(6);
    const std::size_t hot = 64 * 4 + 8 * 4 + 4;
    std::size_t leaf = 0;
    while ((frames[2].leaves()[leaf].active[4] >> (8 * 4 + 4) & 1) == 0) ++leaf;
    frames[2].values(leaf)[hot] = apart;
    const VoxelIndex at = frames[2].leaves()[leaf].origin;
    const auto kept = throughFile({volume(37, 40, 44), frames}, {});
    const SupportError& support = kept.report.support;
    EXPECT_TRUE(support.robust);
    EXPECT_LT(support.high - support.low, 2);
    EXPECT_LE(support.rms, 3e-3);
    EXPECT_LT(kept.report.maxError, 0.1);
    std::vector<float> one(1);
    kept.frames[2].toDense({{at[0] + 4, at[1] + 4, at[2] + 4}, {at[0] + 5, at[1] + 5, at[2] + 5}},
                           one);
    EXPECT_EQ(one[0], apart);
  }
}

TEST(Topology, SomeValuesApartDoNotRuleTheErrorEither) {
  const auto plain = throughFile({volume(37, 40, 44), puffs(1)}, {});
  const auto count =
      static_cast<std::size_t>(std::lround(plain.report.support.share * 37 * 40 * 44));
  ASSERT_GT(count, 1500U);
  for (const std::size_t some : {std::size_t{2}, std::size_t{7}, count / 150}) {
    auto frames = puffs(1);
    std::size_t seen = 0, changed = 0;
    for (std::size_t leaf = 0; leaf < frames[0].leaves().size(); ++leaf) {
      for (std::size_t i = 0; i < Bricks::kVoxels; ++i) {
        const bool used = (frames[0].leaves()[leaf].active[i / 64] >> i % 64 & 1) != 0;
        if (!used || seen++ % (count / some) != 0 || changed == some)
          continue;
        frames[0].values(leaf)[i] = changed++ % 3 == 0 ? -1e4F : 1e6F + static_cast<float>(i);
      }
    }
    ASSERT_EQ(changed, some);
    const auto kept = throughFile({volume(37, 40, 44), frames}, {});
    EXPECT_TRUE(kept.report.support.robust) << some;
    EXPECT_LT(kept.report.support.high - kept.report.support.low, 2) << some;
    EXPECT_LT(kept.report.maxError, 0.1) << some;
  }
}

TEST(Topology, AVoxelAloneSurvives) {
  auto frames = puffs(2);
  Bricks::Leaf alone{{29, 37, 29}};
  alone.active[7] = alone.valued[7] = std::uint64_t{1} << 8;
  frames[1].addLeaf(alone)[64 * 7 + 8] = 0.5f;
  const auto kept = throughFile({volume(37, 40, 44), frames}, {});
  std::vector<float> one(1);
  kept.frames[1].toDense({{29, 38, 36}, {30, 39, 37}}, one);
  EXPECT_NEAR(one[0], 0.5, 0.02);
}

TEST(Topology, LevelSetsKeepTheirSides) {
  // Distances in a band; inside of it -3, outside 3, both not active; and the background 0.
  for (const float background : {3.0f, 0.0f}) {
    std::vector<Bricks> frames;
    for (int t = 0; t < 2; ++t) {
      Bricks frame(1, {background, 0, 0});
      for (int z = 0; z < 40; z += 8)
        for (int y = 0; y < 40; y += 8)
          for (int x = 0; x < 40; x += 8) {
            Bricks::Leaf leaf{{x, y, z}};
            if (leaf.origin == VoxelIndex{16, 16, 16})
              continue;  // a tile
            std::vector<float> values(Bricks::kVoxels, background);
            for (int i = 0; i < Bricks::kVoxels; ++i) {
              const float d = std::hypot(static_cast<float>(x + i % 8 - 20),
                                         static_cast<float>(y + i / 8 % 8 - 20),
                                         static_cast<float>(z + i / 64 - 20)) -
                              12 + static_cast<float>(t);
              const bool active = std::abs(d) < 3 || background == 0;
              const std::uint64_t bit = std::uint64_t{1} << i % 64;
              if (active)
                leaf.active[static_cast<std::size_t>(i / 64)] |= bit;
              if (active || d < 0) {
                leaf.valued[static_cast<std::size_t>(i / 64)] |= bit;
                values[static_cast<std::size_t>(i)] = active ? d : -3;
              }
            }
            if (leaf.valued != BrickMask{})
              std::ranges::copy(values, frame.addLeaf(leaf).begin());
          }
      frame.addTile({{16, 16, 16}, 8, false, {-3, 0, 0}});
      frames.push_back(std::move(frame));
    }
    const auto kept = throughFile({volume(40, 40, 40), frames}, {});
    for (std::size_t t = 0; t < 2; ++t) {
      const Voxels a(frames[t], volume(40, 40, 40)), b(kept.frames[t], volume(40, 40, 40));
      for (std::size_t i = 0; i < a.values.size(); ++i) {
        if (a.topology[i] != 3)
          ASSERT_EQ(a.values[i], b.values[i]);
        else
          ASSERT_NEAR(a.values[i], b.values[i], background > 0 ? 0.2 : 1);
      }
    }
  }
}

TEST(Topology, ValuesOfInactiveVoxelsDiffer) {
  auto frames = puffs(2);
  for (std::size_t i = 0; i < frames[0].leaves().size(); i += 2) frames[0].leaf(i).active = {};
  const auto kept = throughFile({volume(37, 40, 44), frames}, {});
  EXPECT_LE(kept.report.support.rms, 3e-3);
}

TEST(Topology, ColoursOnAColouredBackground) {
  std::vector<Bricks> frames;
  for (int i = 0; i < 3; ++i)
    frames.push_back(puff(14 + static_cast<float>(i), {0.5f, 0.25f, -1}, 3));
  const auto kept = throughFile({volume(37, 40, 44, 3), frames}, {});
  EXPECT_LE(kept.report.support.rms, 3e-3);
}

TEST(Topology, TilesCostNothing) {
  std::vector<Bricks> frames(2);
  for (Bricks& frame : frames) {
    for (std::int64_t x = 0; x < 512; x += 128)
      frame.addTile({{x, 128, 0}, 128, true, {0.8f, 0, 0}});
  }
  const auto kept = throughFile({volume(128, 256, 512), frames}, {});
  EXPECT_EQ(kept.report.blocks, 0u);
  EXPECT_EQ(kept.report.maxError, 0);
  EXPECT_LT(kept.report.fileBytes, 600u);
  EXPECT_NEAR(kept.report.support.share, 0.5, 1e-12);
}

// Two puffs a hundred thousand voxels apart, and tiles of many frames.
TEST(Topology, ABoxBeyondAllMemoryHoldsTwoPuffs) {
  constexpr int kSide = 100000;
  auto frames = puffs(3);
  for (Bricks& frame : frames) {
    Bricks far = puff(12, {0, 0, 0});
    far.shift({kSide - 48, kSide - 48, kSide - 48});
    frame.append(far);
    frame.addTile({{4096, 4096, 4096}, 1024, true, {2, 0, 0}});
  }
  BrickFrames source(volume(kSide, kSide, kSide), frames);
  const ScratchFile file;
  Progress progress;
  CompressOptions options;
  options.target = {Kind::kRms, 3e-3};
  const auto report = compress(source, file.path(), options, progress);
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_LE(report->support.rms, 3e-3);
  const auto reader = VoluteReader::open(file.path());
  ASSERT_TRUE(reader) << reader.error().message;
  std::vector<Bricks> back(3);
  const auto read = reader->readBricks(0, 3, back);
  ASSERT_TRUE(read) << read.error().message;
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(back[i].tiles().size(), 1u);
    EXPECT_EQ(back[i].activeVoxels(), frames[i].activeVoxels());
  }
}

TEST(Topology, LayersAreCompressedAsTheWhole) {
  const ScratchFile whole, layered;
  Progress progress;
  BrickFrames source({volume(60, 40, 44), puffs(17)});
  CompressOptions options;
  options.target = {Kind::kRms, 1e-2};
  ASSERT_TRUE(compress(source, whole.path(), options, progress));
  options.work = layered.folder() / "work";
  ASSERT_TRUE(compress(source, layered.path(), options, progress));
  EXPECT_EQ(testing::readBytes(whole.path()), testing::readBytes(layered.path()));
}

TEST(Topology, RegionsAndJoinedFilesHaveIt) {
  const ScratchFile a("a.volute"), b("b.volute"), both("both.volute");
  Progress progress;
  const auto frames = puffs(24);
  VolumeInfo info = volume(37, 40, 44);
  BrickFrames first(info, {frames.begin(), frames.begin() + 16});
  ASSERT_TRUE(compress(first, a.path(), {}, progress));
  VolumeInfo rest = info;
  BrickFrames second(rest, {frames.begin() + 16, frames.end()});
  const_cast<VolumeInfo&>(second.info()).frameNumbers.clear();
  for (int i = 16; i < 24; ++i) const_cast<VolumeInfo&>(second.info()).frameNumbers.push_back(i);
  ASSERT_TRUE(compress(second, b.path(), {}, progress));
  const auto joined = join({a.path(), b.path()}, both.path(), {}, progress);
  ASSERT_TRUE(joined) << joined.error().message;
  EXPECT_TRUE(joined->copied);
  auto reader = VoluteReader::open(both.path());
  ASSERT_TRUE(reader) << reader.error().message;
  const auto shared = std::make_shared<const VoluteReader>(std::move(*reader));
  Extraction extraction;
  extraction.positions = {3, 20};
  extraction.region = {{3, 4, 5}, {30, 31, 32}};
  extraction.bricks = true;
  const auto source = ExtractSource::create(shared, extraction, progress);
  ASSERT_TRUE(source) << source.error().message;
  for (int i = 0; i < 2; ++i) {
    Bricks region,
        wanted =
            frames[static_cast<std::size_t>(extraction.positions[static_cast<std::size_t>(i)])];
    ASSERT_TRUE((*source)->readBricks(i, 0, 27, region));
    wanted.crop({{3, 4, 5}, {30, 31, 32}});
    wanted.shift({-3, -4, -5});
    EXPECT_EQ(Voxels(region, volume(27, 27, 27)).topology,
              Voxels(wanted, volume(27, 27, 27)).topology);
  }
}

TEST(Topology, OneBackgroundOfAllFrames) {
  auto frames = puffs(2);
  frames[1] = puff(12, {0.5f, 0, 0});
  BrickFrames source(volume(37, 40, 44), frames);
  const ScratchFile file;
  Progress progress;
  const auto report = compress(source, file.path(), {}, progress);
  ASSERT_FALSE(report);
  EXPECT_NE(report.error().message.find("background"), std::string::npos) << report.error().message;
}

TEST(Topology, LeavesOfBlocksKeepTheTilesThatTheyReachInto) {
  std::vector<Bricks> frames(2, Bricks(1, {0.5f, 0, 0}));
  for (Bricks& frame : frames) {
    Bricks::Leaf leaf{{5, 13, 21}};
    leaf.active.fill(~std::uint64_t{0});
    leaf.valued = leaf.active;
    std::ranges::fill(frame.addLeaf(leaf), 1.0f);
    frame.addTile({{13, 13, 21}, 8, true, {2, 0, 0}});
    frame.addTile({{5, 21, 21}, 8, false, {-0.5f, 0, 0}});
    frame.addTile({{21, -3, 5}, 16, true, {3, 0, 0}});
    frame.sort();
  }
  BrickFrames source(volume(40, 40, 44), frames);
  const auto kept = throughFile({volume(40, 40, 44), frames}, {});
  ASSERT_EQ(kept.frames.size(), 2u);
  EXPECT_EQ(kept.frames[0].activeVoxels(), frames[0].activeVoxels());
  std::vector<float> before(source.info().frameValues()), after(before.size());
  const IndexBox all{{0, 0, 0}, {44, 40, 40}};
  frames[1].toDense(all, before), kept.frames[1].toDense(all, after);
  for (std::size_t i = 0; i < before.size(); ++i) ASSERT_NEAR(after[i], before[i], 0.01) << i;
  BrickFrames back(volume(40, 40, 44), kept.frames);
  Progress progress;
  const auto difference = compare(source, back, progress);
  ASSERT_TRUE(difference);
  EXPECT_LT(difference->maxError, 0.01);
  EXPECT_EQ(difference->outsideError, 0);
  const auto other = compare(back, source, progress);
  ASSERT_TRUE(other);
  EXPECT_EQ(other->supportValues, difference->supportValues);
}

TEST(Topology, FaintFramesAreNamed) {
  auto frames = puffs(3);
  for (std::size_t i = 0; i < frames[1].leaves().size(); ++i)
    for (float& value : frames[1].values(i)) value *= 0.01f;
  const auto kept = throughFile({volume(37, 40, 44), frames}, {});
  ASSERT_EQ(kept.report.faintFrames.size(), 1u);
  EXPECT_EQ(kept.report.faintFrames[0].position, 1);
  EXPECT_GT(kept.report.faintFrames[0].relativeRms, kept.report.support.rms);
}

TEST(Topology, NoDamageGoesUnnoticed) {
  const ScratchFile file;
  Progress progress;
  auto frames = puffs(2);
  frames[0].addTile({{37, 37, 37}, 8, true, {2, 0, 0}});
  BrickFrames source(volume(40, 40, 44), frames);
  ASSERT_TRUE(compress(source, file.path(), {}, progress));
  const auto bytes = testing::readBytes(file.path());
  const auto readsWhole = [&] {
    const auto reader = VoluteReader::open(file.path());
    return reader && reader->verify().complete();
  };
  ASSERT_TRUE(readsWhole());
  for (std::size_t size = 0; size < bytes.size(); size += 1 + size / 64) {
    testing::writeBytes(file.path(), bytes.substr(0, size));
    EXPECT_FALSE(readsWhole()) << "cut at " << size;
  }
  std::mt19937 random(3);
  for (int i = 0; i < 400; ++i) {
    testing::writeBytes(file.path(), testing::withFlippedBit(bytes, random() % (8 * bytes.size())));
    EXPECT_FALSE(readsWhole());
  }
}

}  // namespace
}  // namespace volute
