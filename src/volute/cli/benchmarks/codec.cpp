// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <unistd.h>

#include <filesystem>

#include "volute/base/output_file.hpp"
#include "volute/cli/bench_timing.hpp"
#include "volute/cli/benchmarks/benchmarks.hpp"
#include "volute/codec/compress.hpp"
#include "volute/codec/volute_reader.hpp"
#include "volute/grid/sequence.hpp"

namespace volute::cli {
namespace {

Status benchOne(const std::string& name, const Sequence& sequence, Progress& progress,
                std::vector<BenchRow>& rows) {
  const auto target =
      std::filesystem::temp_directory_path() / fmt::format("volute-bench-{}.volute", ::getpid());
  VOLUTE_ASSIGN(const auto pending, PendingFile::create(target));  // removes itself at the end

  SequenceSource source(sequence);
  CompressOptions options;
  options.target = {ErrorTarget::Kind::kRms, 3e-3};
  VOLUTE_ASSIGN(const auto report, compress(source, pending.path(), options, progress));
  VOLUTE_ASSIGN(const auto reader, VoluteReader::open(pending.path()));
  std::vector<float> frame(sequence.info.frameValues());
  Status status;
  const double reading = medianSeconds([&] {
    const auto frames =
        frameSource(std::make_shared<VoluteReader>(*VoluteReader::open(pending.path())));
    for (int i = 0; i < sequence.info.frames && status; ++i) status = frames->readFrame(i, frame);
  });
  VOLUTE_TRY(status);

  const double raw = static_cast<double>(report.rawBytes);
  rows.push_back({fmt::format("{}: file", name), static_cast<double>(report.fileBytes), "bytes",
                  static_cast<double>(report.fileBytes) / raw});
  rows.push_back({fmt::format("{}: relative RMS", name), report.relativeRms, "", std::nullopt});
  rows.push_back(
      {fmt::format("{}: compressing", name), raw / 1e6 / report.seconds, "MB/s", std::nullopt});
  rows.push_back({fmt::format("{}: reading", name), raw / 1e6 / reading, "MB/s", std::nullopt});
  return {};
}

}  // namespace

Result<std::vector<BenchRow>> benchCodec(const BenchInput& input, Progress& progress) {
  std::vector<BenchRow> rows;
  VOLUTE_ASSIGN(const auto sequences, benchSequences(input, progress));
  for (const auto& [name, sequence] : sequences)
    VOLUTE_TRY(benchOne(name, sequence, progress, rows));
  return rows;
}

}  // namespace volute::cli
