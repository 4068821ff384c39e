// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "volute/base/damage_testing.hpp"
#include "volute/base/program.hpp"
#include "volute/codec/compress.hpp"
#include "volute/codec/volute_reader.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/grid/sequence.hpp"

namespace volute::testing {

/// A file name in a folder of its own that is removed with the object.
class ScratchFile {
 public:
  explicit ScratchFile(const std::string& name = "x.volute") : path_(folder_ / name) {}

  const std::filesystem::path& path() const { return path_; }

  const std::filesystem::path& folder() const { return folder_.path(); }

 private:
  ScratchFolder folder_;
  std::filesystem::path path_;
};

/// Drifting plumes with empty space and some grain; exact in every float unit that rounds as IEEE
/// 754 says.
inline Sequence plumes(int frames, int z, int y, int x, int channels = 1, float offset = 0) {
  Sequence sequence = makeSequence(frames, z, y, x, channels);
  auto view = sequence.view();
  std::uint32_t seed = 12345;
  for (int t = 0; t < frames; ++t)
    for (int k = 0; k < z; ++k)
      for (int j = 0; j < y; ++j)
        for (int i = 0; i < x; ++i)
          for (int c = 0; c < channels; ++c) {
            const float drift = 0.1f * static_cast<float>(t);
            const float dx = (static_cast<float>(i) - 0.5f * static_cast<float>(x) - drift) /
                             static_cast<float>(x);
            const float dy =
                (static_cast<float>(j) - 0.4f * static_cast<float>(y)) / static_cast<float>(y);
            const float dz =
                (static_cast<float>(k) - 0.3f * static_cast<float>(z + c)) / static_cast<float>(z);
            const float body = 0.2f - dx * dx - dy * dy - dz * dz;
            seed = seed * 1664525u + 1013904223u;
            const float grain = static_cast<float>(seed >> 24) * 0x1p-13f;
            view(t, k, j, i, c) = body > 0 ? offset + body * 4 + grain : offset;
          }
  return sequence;
}

/// Frames with a topology of their own.
class BrickFrames final : public FrameSource {
 public:
  BrickFrames(VolumeInfo info, std::vector<Bricks> frames)
      : info_(std::move(info)), frames_(std::move(frames)) {
    for (Bricks& frame : frames_) frame.sort();
    info_.frames = static_cast<int>(frames_.size());
    info_.frameNumbers.clear();
    info_.times.clear();
    info_.bounds = {};
    info_.fillDefaults();
  }

  const VolumeInfo& info() const override { return info_; }

  Status readFrame(int index, std::span<float> values) override {
    frames_[static_cast<std::size_t>(index)].toDense({{0, 0, 0}, {info_.x, info_.y, info_.z}},
                                                     values);
    return {};
  }

  Status readBricks(int index, int first, int end, Bricks& bricks) override {
    bricks = frames_[static_cast<std::size_t>(index)];
    if (first > 0 || end < info_.z)
      bricks.crop({{0, 0, first}, {info_.x, info_.y, end}});
    return {};
  }

  bool hasTopology() const override { return true; }

  std::uint64_t brickBytes() const override {
    std::uint64_t most = 0;
    for (const Bricks& frame : frames_) most = std::max(most, frame.bytes());
    return most;
  }

 private:
  VolumeInfo info_;
  std::vector<Bricks> frames_;
};

inline Result<CompressReport> compressTo(const std::filesystem::path& path,
                                         const Sequence& sequence, ErrorTarget target,
                                         CompressOptions options = {}) {
  SequenceSource source(sequence);
  options.target = target;
  Progress progress;
  return compress(source, path, options, progress);
}

inline Result<Sequence> readBack(const std::filesystem::path& path,
                                 const VoluteReader::Options& options = {}) {
  VOLUTE_ASSIGN(VoluteReader reader, VoluteReader::open(path, options));
  const auto source = frameSource(std::make_shared<VoluteReader>(std::move(reader)));
  return readAll(*source, std::uint64_t{1} << 32);
}

struct SequenceError {
  double relativeRms = 0, maxError = 0;
};

inline SequenceError differenceOf(const Sequence& a, const Sequence& b) {
  double sum = 0, greatest = 0, low = INFINITY, high = -INFINITY;
  for (std::size_t i = 0; i < a.values.size(); ++i) {
    const double error = std::abs(static_cast<double>(b.values[i]) - a.values[i]);
    sum += error * error;
    greatest = std::max(greatest, error);
    low = std::min<double>(low, a.values[i]);
    high = std::max<double>(high, a.values[i]);
  }
  const double rms = std::sqrt(sum / static_cast<double>(a.values.size()));
  return {high > low ? rms / (high - low) : rms, greatest};
}

}  // namespace volute::testing
