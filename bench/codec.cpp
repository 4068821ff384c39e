// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// `volute bench codec`: .volute files against files of the peers that Debian has, and of those
// whose sources are given, at equal error. Sizes are those of files on disk, errors those of what
// was decoded from them.
#include <algorithm>
#include <array>
#include <limits>

#include "bench/benchmark.hpp"
#include "bench/codec_measurement.hpp"
#include "bench/scratch.hpp"
#include "volute/base/parallel.hpp"

namespace volute::bench {
namespace {

constexpr std::array kTargets{1e-2, 3e-3, 1e-3};  ///< relative RMS
constexpr double kFullTarget = 3e-3;              ///< here encoding is timed, too
constexpr int kSize = 48;  ///< voxels on a side of made-up data: a minute for everything
constexpr std::size_t kVolute = 0, kBaseline = 1;  ///< places in fileCodecs(); zfp 4D

/// A codec that this build has, and its files at the present target.
struct Rival {
  std::size_t place = 0;  ///< in fileCodecs(), or behind them
  std::string called;
  std::unique_ptr<FileCodec> codec;
  CodedFiles files;
  double seconds = 0;  ///< of what was timed last, with one thread

  std::string_view name() const { return called; }
};

/// The rows of one sequence.
class Table {
 public:
  Table(std::string data, BenchRows& rows) : data_(std::move(data)), rows_(rows) {}

  void add(std::string_view figure, double target, std::string_view codec, double value,
           std::string_view unit, std::optional<double> ratio = std::nullopt,
           std::string note = {}) {
    BenchRow row{fmt::format("{}: {} at {}, {}", data_, figure, target, codec), value,
                 std::string(unit), ratio};
    row.labels = {{"data", data_},
                  {"figure", std::string(figure)},
                  {"target", fmt::format("{}", target)},
                  {"codec", std::string(codec)}};
    row.note = std::move(note);
    rows_.add(std::move(row));
  }

  void addMissing(std::string_view codec, const Error& reason) {
    BenchRow row{fmt::format("{}: {}", data_, codec), std::numeric_limits<double>::quiet_NaN(), ""};
    row.labels = {{"data", data_}, {"figure", "missing"}, {"codec", std::string(codec)}};
    row.note = "not measured: " + reason.message;
    rows_.add(std::move(row));
  }

  const std::string& data() const { return data_; }

 private:
  std::string data_;
  BenchRows& rows_;
};

/// @param peers  a folder with sources of some; empty: none
std::vector<Rival> rivals(Table& table, const std::string& peers, const ScratchFolder& scratch) {
  std::vector<Rival> list;
  for (std::size_t place = 0; place < fileCodecs().size(); ++place) {
    auto made = fileCodecs()[place].make();
    if (made)
      list.push_back({place, std::string(fileCodecs()[place].name), std::move(*made), {}, 0});
    else
      table.addMissing(fileCodecs()[place].name, made.error());
  }
  for (std::size_t i = 0; i < sourceCodecs().size() && !peers.empty(); ++i) {
    const SourceCodecEntry& entry = sourceCodecs()[i];
    auto made = makeSourceCodec(entry, peers, scratch.path());
    if (made)
      list.push_back({fileCodecs().size() + i, std::string(entry.name), std::move(*made), {}, 0});
    else
      table.addMissing(entry.name, made.error());
  }
  return list;
}

/// Fills in `files`. A codec that has no error to choose keeps those of the first target.
Status encodeAll(std::span<Rival> list, const Sequence& sequence, double target,
                 const ScratchFolder& scratch, const std::string& data, Progress& progress) {
  for (std::size_t i = 0; i < list.size(); ++i) {
    Rival& rival = list[i];
    progress.report(fmt::format("{} at {}: {}", data, target, rival.name()), static_cast<double>(i),
                    static_cast<double>(list.size()));
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped before {}", rival.name());
    const auto folder = scratch.path() / fmt::format("{}", rival.place);
    VOLUTE_ASSIGN(rival.files,
                  encodeWithin(*rival.codec, sequence, target, folder, /*threads=*/1, progress));
  }
  return {};
}

void addSizes(Table& table, std::span<const Rival> list, double target, double raw) {
  for (const Rival& rival : list) {
    const auto bytes = static_cast<double>(rival.files.bytes);
    table.add("size", target, rival.name(), bytes / raw, "of raw",
              bytes / static_cast<double>(list[kVolute].files.bytes));
  }
  for (const Rival& rival : list) {
    table.add("relative RMS", target, rival.name(), rival.files.relativeRms, "", std::nullopt,
              rival.files.relativeRms > target ? "above the target" : "");
  }
}

/// From the seconds of one thread, and Volute's with all.
void addSpeeds(Table& table, const std::string& figure, std::span<Rival* const> timed,
               double target, double allSeconds, const VolumeInfo& info) {
  const double megabytes = static_cast<double>(info.rawBytes()) / 1e6;
  const auto baseline = std::ranges::find(timed, kBaseline, &Rival::place);
  for (const Rival* rival : timed) {
    table.add(figure, target, rival->name(), megabytes / rival->seconds, "MB/s",
              baseline == timed.end() ? std::nullopt
                                      : std::optional((*baseline)->seconds / rival->seconds));
  }
  if (threadCount() == 1)
    return;
  const Rival& volute = *timed[kVolute];
  table.add(fmt::format("{} with {} threads", figure, threadCount()), target, volute.name(),
            megabytes / allSeconds, "MB/s", volute.seconds / allSeconds);
}

Status timeDecoding(Table& table, std::span<Rival> list, const Sequence& sequence, double target,
                    Progress& progress) {
  progress.report(fmt::format("{} at {}: timing decoding", table.data(), target), 0, 0);
  std::vector<Rival*> timed;
  std::vector<Contestant> race;
  for (Rival& rival : list) {
    timed.push_back(&rival);
    race.push_back({rival.codec.get(), rival.files.folder, /*threads=*/1});
  }
  race.push_back({list[kVolute].codec.get(), list[kVolute].files.folder, /*threads=*/0});
  VOLUTE_TRY(raceDecoding(sequence.info, race, progress));
  for (std::size_t i = 0; i < timed.size(); ++i) timed[i]->seconds = race[i].seconds;
  addSpeeds(table, "decoding", timed, target, race.back().seconds, sequence.info);
  return {};
}

/// One frame, and a cube of 16^3 voxels through all of them: what reading less costs.
Status timeParts(Table& table, std::span<Rival> list, const Sequence& sequence, double target,
                 Progress& progress) {
  const VolumeInfo& info = sequence.info;
  const auto middle = [](int size, int wanted) {
    const int first = std::max(0, (size - wanted) / 2);
    return std::pair(first, std::min(size, first + wanted));
  };
  const auto [frame, frameEnd] = middle(info.frames, 1);
  const auto [z, zEnd] = middle(info.z, 16);
  const auto [y, yEnd] = middle(info.y, 16);
  const auto [x, xEnd] = middle(info.x, 16);
  const std::array<std::pair<std::string_view, Part>, 2> parts{
      {{"one frame", {{frame, 0, 0, 0}, {frameEnd, info.z, info.y, info.x}}},
       {"one region", {{0, z, y, x}, {info.frames, zEnd, yEnd, xEnd}}}}};
  for (const auto& [figure, part] : parts) {
    progress.report(fmt::format("{} at {}: timing {}", table.data(), target, figure), 0, 0);
    std::vector<Contestant> race;
    for (Rival& rival : list)
      race.push_back({rival.codec.get(), rival.files.folder, /*threads=*/1});
    VOLUTE_TRY(raceDecoding(info, race, progress, part));
    double baseline = 0;
    for (std::size_t i = 0; i < list.size(); ++i)
      baseline = list[i].place == kBaseline ? race[i].seconds : baseline;
    for (std::size_t i = 0; i < list.size(); ++i) {
      table.add(figure, target, list[i].name(), 1000 * race[i].seconds, "ms",
                baseline > 0 ? std::optional(baseline / race[i].seconds) : std::nullopt);
    }
  }
  return {};
}

Status addMemory(Table& table, std::span<const Rival> list, const Sequence& sequence, double target,
                 const ScratchFolder& scratch, Progress& progress) {
  for (const Rival& rival : list) {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped before the memory of {}", rival.name());
    VOLUTE_ASSIGN(const Memory memory,
                  memoryOf(*rival.codec, sequence, rival.files, scratch.path() / "memory"));
    table.add("memory of encoding", target, rival.name(), memory.encoding, "MiB", std::nullopt,
              "beside the values");
    table.add("memory of decoding", target, rival.name(), memory.decoding, "MiB", std::nullopt,
              "beside the values");
  }
  return {};
}

/// One thread was timed when the files were made; here Volute takes all.
Status timeEncoding(Table& table, std::span<Rival> list, const Sequence& sequence, double target,
                    Progress& progress) {
  progress.report(fmt::format("{} at {}: timing encoding", table.data(), target), 0, 0);
  std::vector<Rival*> timed;
  for (Rival& rival : list) {
    rival.seconds = rival.files.encodingSeconds;
    timed.push_back(&rival);
  }
  const Rival& volute = list[kVolute];
  const auto folder = volute.files.folder;
  VOLUTE_ASSIGN(const CodedFiles files,
                encodeWithin(*volute.codec, sequence, target, folder, /*threads=*/0, progress));
  addSpeeds(table, "encoding", timed, target, files.encodingSeconds, sequence.info);
  return {};
}

Status benchOne(const NamedSequence& named, const std::string& peers, Progress& progress,
                BenchRows& rows) {
  const Sequence& sequence = named.sequence;
  const auto [low, high] = std::ranges::minmax(sequence.values);
  if (!(high > low)) {
    return fail(ErrorCode::kInvalidData,
                "{}: all values are {}, or some are no numbers; expected a volume that varies",
                named.name, low);
  }
  VOLUTE_ASSIGN(const auto scratch, ScratchFolder::create());
  Table table(named.name, rows);
  std::vector<Rival> list = rivals(table, peers, scratch);
  for (const double target : kTargets) {
    VOLUTE_TRY(encodeAll(list, sequence, target, scratch, named.name, progress));
    addSizes(table, list, target, static_cast<double>(sequence.info.rawBytes()));
    VOLUTE_TRY(timeDecoding(table, list, sequence, target, progress));
    if (target != kFullTarget)
      continue;
    VOLUTE_TRY(timeParts(table, list, sequence, target, progress));
    VOLUTE_TRY(addMemory(table, list, sequence, target, scratch, progress));
    VOLUTE_TRY(timeEncoding(table, list, sequence, target, progress));
  }
  return {};
}

}  // namespace

Status benchCodec(const BenchInput& input, BenchRows& rows, Progress& progress) {
  VOLUTE_ASSIGN(const auto sequences, benchSequences(input, progress, kSize));
  for (const NamedSequence& named : sequences)
    VOLUTE_TRY(benchOne(named, input.peers, progress, rows));
  return {};
}

}  // namespace volute::bench
