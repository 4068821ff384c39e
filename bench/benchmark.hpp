// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/base/result.hpp"
#include "volute/grid/sequence.hpp"

namespace volute::bench {

/// One measured figure.
struct BenchRow {
  std::string name;
  double value = 0;
  std::string unit;
  std::optional<double> ratio =
      std::nullopt;  ///< to the baseline that the benchmark names, in the same run
  std::vector<std::pair<std::string, std::string>> labels =
      {};                 ///< what the row is about, for programs: {"codec", "zfp 4D"}
  std::string note = {};  ///< a remark; why there is no value (NaN), say
};

/// The figures of a benchmark, in order. Each is shown as soon as it is measured, for a run that is
/// stopped loses none.
class BenchRows {
 public:
  using Show = std::function<void(const BenchRow&)>;

  explicit BenchRows(Show show) : show_(std::move(show)) {}

  void add(BenchRow row) {
    show_(row);
    rows_.push_back(std::move(row));
  }

  const std::vector<BenchRow>& all() const { return rows_; }

 private:
  Show show_;
  std::vector<BenchRow> rows_;
};

/// What a benchmark measures with.
struct BenchInput {
  std::string volume;  ///< a volume sequence, or a capture for tomography; empty: made-up ones
  std::uint64_t maxMemory = std::uint64_t{4} << 30;
  std::string truth{};  ///< the volumes that a capture shows
  std::string grid{};   ///< of the truth's files; empty: the only one
  bool quick = false;   ///< fewer measurements, where there are many
  bool whole = false;   ///< smoke: errors of every pixel instead of times
  std::string peers{};  ///< codec: a folder with sources of peers; empty: none
  std::string only{};   ///< light: what is in the names of its rows; empty: all
};

/// A set of measurements that belong together. Figures of one run are compared with each other,
/// never with those of another machine.
struct Benchmark {
  std::string_view name;
  std::string_view description;
  Status (*run)(const BenchInput& input, BenchRows& rows, Progress& progress);
};

/// All benchmarks. A new one is one entry in benchmarks.cpp.
std::span<const Benchmark> benchmarks();

[[nodiscard]] Status benchCodec(const BenchInput& input, BenchRows& rows, Progress& progress);
[[nodiscard]] Status benchFog(const BenchInput& input, BenchRows& rows, Progress& progress);
/// In builds with OpenGL.
[[nodiscard]] Status benchGl(const BenchInput& input, BenchRows& rows, Progress& progress);
[[nodiscard]] Status benchLight(const BenchInput& input, BenchRows& rows, Progress& progress);
[[nodiscard]] Status benchTomography(const BenchInput& input, BenchRows& rows, Progress& progress);
[[nodiscard]] Status benchSmoke(const BenchInput& input, BenchRows& rows, Progress& progress);
[[nodiscard]] Status benchSparse(const BenchInput& input, BenchRows& rows, Progress& progress);

[[nodiscard]] Status benchVisibility(const BenchInput& input, BenchRows& rows, Progress& progress);

/// Whether the input is a mesh with smoke, not voxels.
bool isMeshInput(const BenchInput& input);

/// What to measure with: the named input, or a fire and a smoke of size^3 voxels and 32 frames,
/// scalar.
struct NamedSequence {
  std::string name;
  Sequence sequence;
};

[[nodiscard]] Result<std::vector<NamedSequence>> benchSequences(const BenchInput& input,
                                                                Progress& progress, int size = 64);

/// The largest of its values minus the least.
double valueRange(const Sequence& sequence);

}  // namespace volute::bench
