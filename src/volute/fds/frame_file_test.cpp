// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/frame_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <memory>

#include "volute/base/program.hpp"
#include "volute/fds/fds_writer.hpp"

namespace volute {
namespace {

using fdswriter::Records;
using ::testing::HasSubstr;

const fdswriter::Planes kPlanes{{{0, 0.1, 0.25, 0.5}, {1, 2, 3}, {0, 0.5}}};
constexpr std::array<int, 3> kCells{3, 2, 1};

FdsMesh mesh() {
  FdsMesh mesh;
  mesh.planes = kPlanes;
  return mesh;
}

double closedForm(double x, double y, double z, double t) {
  return 1 + x + 10 * y + 100 * z + 1000 * t;
}

std::vector<float> valuesAt(double t) {
  return fdswriter::atNodes(kPlanes, {0, 3, 0, 2, 0, 1},
                            [&](double x, double y, double z) { return closedForm(x, y, z, t); });
}

std::vector<std::uint8_t> bytesAt(int t) {
  std::vector<std::uint8_t> bytes(24, static_cast<std::uint8_t>(3 * t));
  for (int i = 0; i < 7; ++i)
    bytes[static_cast<std::size_t>(5 + i)] = static_cast<std::uint8_t>(240 + 2 * i);
  return bytes;
}

fdswriter::Slice wholeSlice() {
  return {{0, 3, 0, 2, 0, 1}};
}

FdsSliceEntry entryOf(const fdswriter::Slice& slice, const std::filesystem::path& path,
                      bool stated = true) {
  FdsSliceEntry entry;
  entry.file = path;
  entry.labels = {slice.quantity, slice.shortName, slice.unit};
  if (stated)
    entry.nodes = FdsNodeBox{{slice.at.i1, slice.at.j1, slice.at.k1},
                             {slice.at.i2, slice.at.j2, slice.at.k2}};
  return entry;
}

/// One of the four kinds of file, with three frames (PLOT3D: one), and how it is opened.
struct Kind {
  std::string name;
  Records file;
  std::function<Result<std::unique_ptr<FdsFrameFile>>(const std::filesystem::path&)> open;
  std::size_t frames = 3;
};

template <class File>
Result<std::unique_ptr<FdsFrameFile>> asFile(Result<File> opened) {
  if (!opened)
    return tl::unexpected<Error>(opened.error());
  return std::unique_ptr<FdsFrameFile>(std::make_unique<File>(std::move(*opened)));
}

std::vector<Kind> kinds(std::size_t split = 0) {
  std::vector<std::pair<float, std::vector<float>>> floats;
  std::vector<std::pair<float, std::vector<std::uint8_t>>> bytes;
  std::vector<std::pair<float, std::vector<double>>> words;
  for (int t = 0; t < 3; ++t) {
    floats.emplace_back(static_cast<float>(t), valuesAt(t));
    bytes.emplace_back(static_cast<float>(t), bytesAt(t));
    const auto values = valuesAt(t);
    words.emplace_back(static_cast<float>(t), std::vector<double>(values.begin(), values.end()));
  }
  std::vector<float> five;
  for (int v = 0; v < 5; ++v) {
    const auto values = valuesAt(v);
    five.insert(five.end(), values.begin(), values.end());
  }
  const auto slice = [](bool stated) {
    return [stated](const std::filesystem::path& path) {
      return asFile(FdsSliceFile::open(entryOf(wholeSlice(), path, stated), mesh()));
    };
  };
  return {
      {"slice", fdswriter::sliceFile(wholeSlice(), floats, split), slice(true)},
      {"slice without indices", fdswriter::sliceFile(wholeSlice(), floats, split), slice(false)},
      {"s3d", fdswriter::smokeFile(kCells, bytes, split),
       [](const std::filesystem::path& path) { return asFile(FdsSmokeFile::open(path, mesh())); }},
      {"s16", fdswriter::smoke16File(kCells, words, split),
       [](const std::filesystem::path& path) {
         return asFile(FdsSmoke16File::open(path, mesh()));
       }},
      {"q", fdswriter::plotFile(kCells, five),
       [](const std::filesystem::path& path) {
         return asFile(FdsPlotFiles::open(std::vector<FdsPlotEntry>{{0, 7.5, path, {}}},
                                          std::vector<std::size_t>{1}, mesh()));
       },
       1},
  };
}

std::vector<std::vector<float>> readAll(const FdsFrameFile& file) {
  std::vector<std::vector<float>> out;
  for (std::size_t i = 0; i < file.frames().times.size(); ++i) {
    out.emplace_back(file.values());
    const auto status = file.readFrame(i, out.back());
    EXPECT_TRUE(status) << status.error().message;
  }
  return out;
}

TEST(FrameFile, readsEveryKindWholeAndSplit) {
  const ScratchFolder folder;
  for (const std::size_t split : {0, 5}) {
    for (const Kind& kind : kinds(split)) {
      SCOPED_TRACE(kind.name);
      kind.file.save(folder / "file");
      const auto file = kind.open(folder / "file");
      ASSERT_TRUE(file) << file.error().message;
      EXPECT_TRUE((*file)->frames().remarks.empty());
      ASSERT_EQ((*file)->frames().times.size(), kind.frames);
      const auto frames = readAll(**file);
      for (std::size_t t = 0; t < kind.frames; ++t) {
        if (kind.name == "s3d") {
          const auto bytes = bytesAt(static_cast<int>(t));
          EXPECT_EQ(frames[t], std::vector<float>(bytes.begin(), bytes.end()));
          continue;
        }
        const auto expected = valuesAt(kind.name == "q" ? 1.0 : static_cast<double>(t));
        const double step = kind.name == "s16" ? 130.0 / 65535 : 0;
        for (std::size_t i = 0; i < expected.size(); ++i)
          EXPECT_NEAR(frames[t][i] + 0.5 * step, expected[i], 0.52 * step) << "words are cut off";
      }
    }
  }
}

TEST(FrameFile, aFrameOfOneValueHasExactWords) {
  const ScratchFolder folder;
  const auto values = valuesAt(0);
  const std::vector<double> one(values.size(), 0.25), more(values.begin(), values.end());
  fdswriter::smoke16File(kCells, {{0, one}, {1, more}}).save(folder / "file");
  const auto file = FdsSmoke16File::open(folder / "file", mesh());
  ASSERT_TRUE(file) << file.error().message;
  EXPECT_EQ(file->step(0).value(), 0) << "FDS writes a range of 1 there, which is no step";
  EXPECT_GT(file->step(1).value(), 0);
  EXPECT_THAT(readAll(*file)[0], ::testing::Each(0.25F));
}

TEST(FrameFile, everyTruncationLeavesTheWholeFramesAndSaysSo) {
  const ScratchFolder folder;
  for (const std::size_t split : {0, 7}) {
    for (const Kind& kind : kinds(split)) {
      SCOPED_TRACE(kind.name);
      kind.file.save(folder / "whole");
      const auto all = readAll(**kind.open(folder / "whole"));
      std::size_t last = 0;
      for (std::size_t size = 0; size < kind.file.bytes.size(); ++size) {
        fdswriter::saveBytes(
            folder / "cut",
            {kind.file.bytes.begin(), kind.file.bytes.begin() + static_cast<std::ptrdiff_t>(size)});
        const auto file = kind.open(folder / "cut");
        if (!file) {
          EXPECT_EQ(file.error().code, ErrorCode::kTruncated) << file.error().message;
          EXPECT_EQ(last, 0U);
          continue;
        }
        const auto frames = readAll(**file);
        ASSERT_LE(frames.size(), all.size());
        EXPECT_GE(frames.size(), last);
        last = frames.size();
        EXPECT_EQ(frames, decltype(all)(all.begin(),
                                        all.begin() + static_cast<std::ptrdiff_t>(frames.size())));
        const bool atFrameEnd = (*file)->frames().remarks.empty();
        if (!atFrameEnd) {
          EXPECT_THAT((*file)->frames().remarks[0].sentence, HasSubstr("ends at byte"));
        }
        EXPECT_TRUE(!atFrameEnd || kind.name != "q");
      }
      EXPECT_EQ(last, kind.frames - 1);
    }
  }
}

TEST(FrameFile, everyFlippedBitOfHeadersAndMarkersIsRefused) {
  const ScratchFolder folder;
  std::size_t flips = 0;
  for (const std::size_t split : {0, 7}) {
    for (const Kind& kind : kinds(split)) {
      for (const auto& [begin, end] : kind.file.guarded) {
        for (std::size_t bit = 8 * begin; bit < 8 * end; ++bit) {
          auto bytes = kind.file.bytes;
          bytes[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
          fdswriter::saveBytes(folder / "flipped", bytes);
          const auto file = kind.open(folder / "flipped");
          constexpr std::size_t kVersion = 8;  // of 3D smoke, whose 0 and 1 are the same
          const bool version = kind.name == "s3d" && bit / 8 == kVersion;
          if (version && bit == 8 * kVersion) {
            EXPECT_TRUE(file);
            continue;
          }
          ASSERT_FALSE(file) << kind.name << " byte " << bit / 8 << " bit " << bit % 8;
          EXPECT_TRUE(file.error().code == ErrorCode::kInvalidData ||
                      (version && file.error().code == ErrorCode::kUnsupported))
              << file.error().message;
          EXPECT_THAT(file.error().message, HasSubstr("flipped: byte "));
          ++flips;
        }
      }
    }
  }
  EXPECT_GT(flips, 10000U);
}

TEST(FrameFile, aRestartReplacesLaterFrames) {
  const ScratchFolder folder;
  fdswriter::sliceFile(
      wholeSlice(),
      {{0, valuesAt(0)}, {1, valuesAt(1)}, {2, valuesAt(2)}, {1, valuesAt(5)}, {3, valuesAt(6)}})
      .save(folder / "restarted");
  const auto file = FdsSliceFile::open(entryOf(wholeSlice(), folder / "restarted"), mesh());
  ASSERT_TRUE(file);
  EXPECT_THAT(file->frames().times, ::testing::ElementsAre(0, 1, 3));
  ASSERT_EQ(file->frames().remarks.size(), 1U);
  EXPECT_THAT(file->frames().remarks[0].sentence, HasSubstr("go back from 2 s to 1 s"));
  EXPECT_EQ(readAll(*file)[1], valuesAt(5));
}

TEST(FrameFile, aWrongMeshIsRefused) {
  const ScratchFolder folder;
  FdsMesh other = mesh();
  other.planes[0].push_back(1);
  fdswriter::smokeFile(kCells, {{0, bytesAt(0)}}).save(folder / "a.s3d");
  const auto file = FdsSmokeFile::open(folder / "a.s3d", other);
  ASSERT_FALSE(file);
  EXPECT_THAT(file.error().message, HasSubstr("word 4 of the header is 3, expected 4"));
}

TEST(RunLengths, whatIsNotACodeIsRefused) {
  std::vector<std::uint8_t> out(8);
  const auto decode = [&](std::vector<std::uint8_t> code) { return bool(decodeRuns(code, out)); };
  EXPECT_TRUE(decode({255, 7, 8}));
  EXPECT_TRUE(decode({255, 7, 4, 1, 2, 3, 4}));
  EXPECT_FALSE(decode({255, 7, 9}));
  EXPECT_FALSE(decode({255, 7, 7}));
  EXPECT_FALSE(decode({255, 7}));
  EXPECT_FALSE(decode({255, 255, 8}));
  EXPECT_FALSE(decode({255, 7, 0, 255, 7, 8}));
  EXPECT_FALSE(decode({255, 7, 8, 1}));
  EXPECT_FALSE(decode({}));
}

RC_GTEST_PROP(RunLengths, comeBackAsTheyWere, ()) {
  const auto runs = *rc::gen::container<std::vector<std::pair<std::uint8_t, std::uint8_t>>>(
      rc::gen::pair(rc::gen::inRange<std::uint8_t>(0, 255), rc::gen::inRange<std::uint8_t>(1, 40)));
  std::vector<std::uint8_t> bytes;
  for (const auto& [value, count] : runs) bytes.insert(bytes.end(), count, value);
  std::vector<std::uint8_t> out(bytes.size());
  RC_ASSERT(decodeRuns(fdswriter::runLengths(bytes), out).has_value());
  RC_ASSERT(out == bytes);
}

}  // namespace
}  // namespace volute
