// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "bench/codec_measurement.hpp"

#include <time.h>

#include <limits>

#include "bench/benchmark.hpp"
#include "bench/own_process.hpp"
#include "bench/timing.hpp"
#include "bench/tolerance_search.hpp"
#include "volute/base/parallel.hpp"
#include "volute/grid/compare.hpp"

namespace volute::bench {
namespace {

namespace fs = std::filesystem;

/// One thread is charged the time that it has the CPU, so that a busy machine does not blur
/// the ratios; several are charged what passes on the wall.
class Stopwatch {
 public:
  explicit Stopwatch(int threads)
      : clock_(threads == 1 ? CLOCK_PROCESS_CPUTIME_ID : CLOCK_MONOTONIC), begin_(now()) {}

  double seconds() const { return now() - begin_; }

 private:
  double now() const {
    timespec time{};
    ::clock_gettime(clock_, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  }

  clockid_t clock_;
  double begin_;
};

std::uint64_t bytesIn(const fs::path& folder) {
  std::uint64_t sum = 0;
  for (const auto& entry : fs::directory_iterator(folder)) sum += entry.file_size();
  return sum;
}

/// Encodes into an emptied folder, decodes what lies there, and measures both.
Result<CodedFiles> encodeAndMeasure(const FileCodec& codec, const Sequence& sequence,
                                    double setting, const fs::path& folder, int threads) {
  const ThreadLimit limit(threads);
  std::error_code error;
  fs::remove_all(folder, error);
  if (!fs::create_directories(folder, error))
    return fail(ErrorCode::kIo, "{}: cannot create: {}", folder.string(), error.message());
  const Stopwatch watch(threads);
  VOLUTE_ASSIGN(const float scale, codec.encode(sequence, setting, folder));
  const double seconds = watch.seconds();
  std::vector<float> decoded(sequence.values.size(), std::numeric_limits<float>::quiet_NaN());
  VOLUTE_TRY(codec.decode(sequence.info, folder, decoded));
  if (scale != 1) {
    for (float& value : decoded) value *= scale;
  }
  Difference difference;
  difference.add(sequence.values, decoded);
  return CodedFiles{folder, setting, seconds, bytesIn(folder), difference.relativeRms()};
}

}  // namespace

Result<CodedFiles> encodeWithin(const FileCodec& codec, const Sequence& sequence, double target,
                                const fs::path& folder, int threads, const Progress& progress) {
  if (codec.setting() != FileCodec::Setting::kTolerance)
    return encodeAndMeasure(codec, sequence, target, folder, threads);
  CodedFiles last;
  auto measure = [&](double tolerance) -> Result<double> {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped while a tolerance was searched");
    VOLUTE_ASSIGN(last, encodeAndMeasure(codec, sequence, tolerance, folder, threads));
    return last.relativeRms;
  };
  VOLUTE_ASSIGN(const double tolerance,
                searchTolerance(target, 4 * target * valueRange(sequence), measure));
  if (last.setting != tolerance)
    VOLUTE_TRY(measure(tolerance));
  return last;
}

Status raceDecoding(const VolumeInfo& info, std::span<Contestant> contestants,
                    const Progress& progress, const std::optional<Part>& part) {
  constexpr int kRounds = 5;
  constexpr std::chrono::milliseconds kTurn{50};  // at least: small volumes are decoded repeatedly
  std::size_t count = info.values();
  if (part) {
    count = static_cast<std::size_t>(info.channels);
    for (std::size_t axis = 0; axis < 4; ++axis)
      count *= static_cast<std::size_t>(part->end[axis] - part->begin[axis]);
  }
  std::vector<float> values(count);
  for (Contestant& one : contestants) one.seconds = std::numeric_limits<double>::infinity();
  for (int round = 0; round < kRounds; ++round) {
    for (Contestant& one : contestants) {
      const ThreadLimit limit(one.threads);
      const auto turn = Clock::now();
      do {
        if (progress.cancelled())
          return fail(ErrorCode::kCancelled, "stopped while decoding was timed");
        const Stopwatch watch(one.threads);
        VOLUTE_TRY(part ? one.codec->decodePart(info, one.folder, part->begin, part->end, values)
                        : one.codec->decode(info, one.folder, values));
        one.seconds = std::min(one.seconds, watch.seconds());
      } while (Clock::now() - turn < kTurn);
    }
  }
  return {};
}

Result<Memory> memoryOf(const FileCodec& codec, const Sequence& sequence, const CodedFiles& files,
                        const fs::path& scratch) {
  std::error_code error;
  fs::create_directories(scratch, error);
  if (error)
    return fail(ErrorCode::kIo, "{}: cannot create: {}", scratch.string(), error.message());
  const double setting = files.setting;
  VOLUTE_ASSIGN(const Outcome encoding, measured([&]() -> Result<double> {
                  const ThreadLimit limit(1);
                  VOLUTE_TRY(codec.encode(sequence, setting, scratch));
                  return 0.0;
                }));
  std::vector<float> values(sequence.values.size(), 1.0f);
  VOLUTE_ASSIGN(const Outcome decoding, measured([&]() -> Result<double> {
                  const ThreadLimit limit(1);
                  VOLUTE_TRY(codec.decode(sequence.info, files.folder, values));
                  return 0.0;
                }));
  fs::remove_all(scratch, error);
  return Memory{encoding.growth, decoding.growth};
}

}  // namespace volute::bench
