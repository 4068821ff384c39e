// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/bench.hpp"

#include "volute/cli/benchmarks/benchmarks.hpp"

namespace volute::cli {

std::span<const Benchmark> benchmarks() {
  static const std::vector<Benchmark> table = {
      {"slice", "making bricks of a dense frame, against copying the frame", benchSlice},
      {"codec", "compressing and reading made-up fire and smoke at relative RMS 3e-3", benchCodec},
  };
  return table;
}

}  // namespace volute::cli
