// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/cli/bench.hpp"
#include "volute/grid/sequence.hpp"

namespace volute::cli {

[[nodiscard]] Status benchCodec(const BenchInput& input, BenchRows& rows, Progress& progress);
[[nodiscard]] Status benchFds(const BenchInput& input, BenchRows& rows, Progress& progress);
[[nodiscard]] Status benchFog(const BenchInput& input, BenchRows& rows, Progress& progress);
/// In builds with OpenGL.
[[nodiscard]] Status benchGl(const BenchInput& input, BenchRows& rows, Progress& progress);
[[nodiscard]] Status benchRender(const BenchInput& input, BenchRows& rows, Progress& progress);
[[nodiscard]] Status benchTomography(const BenchInput& input, BenchRows& rows, Progress& progress);
[[nodiscard]] Status benchSmoke(const BenchInput& input, BenchRows& rows, Progress& progress);
[[nodiscard]] Status benchTree(const BenchInput& input, BenchRows& rows, Progress& progress);

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

}  // namespace volute::cli
