// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/cli/bench.hpp"
#include "volute/grid/sequence.hpp"

namespace volute::cli {

[[nodiscard]] Result<std::vector<BenchRow>> benchCodec(const BenchInput& input, Progress& progress);
[[nodiscard]] Result<std::vector<BenchRow>> benchFds(const BenchInput& input, Progress& progress);
[[nodiscard]] Result<std::vector<BenchRow>> benchFog(const BenchInput& input, Progress& progress);
[[nodiscard]] Result<std::vector<BenchRow>> benchRender(const BenchInput& input,
                                                        Progress& progress);
[[nodiscard]] Result<std::vector<BenchRow>> benchTomography(const BenchInput& input,
                                                            Progress& progress);
[[nodiscard]] Result<std::vector<BenchRow>> benchSmoke(const BenchInput& input, Progress& progress);
[[nodiscard]] Result<std::vector<BenchRow>> benchTree(const BenchInput& input, Progress& progress);

[[nodiscard]] Result<std::vector<BenchRow>> benchVisibility(const BenchInput& input,
                                                            Progress& progress);

/// What to measure with: the named input, or a fire and a smoke of size^3 voxels and 32 frames,
/// scalar.
struct NamedSequence {
  std::string name;
  Sequence sequence;
};

[[nodiscard]] Result<std::vector<NamedSequence>> benchSequences(const BenchInput& input,
                                                                Progress& progress, int size = 64);

}  // namespace volute::cli
