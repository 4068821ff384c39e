// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/bench.hpp"

#include "volute/cli/benchmarks/benchmarks.hpp"

namespace volute::cli {

std::span<const Benchmark> benchmarks() {
  static const std::vector<Benchmark> table = {
      {"codec", "compressing and reading at relative RMS 3e-3", benchCodec},
      {"render", "pictures of 512 x 512 straight from the tree, against the reference",
       benchRender},
      {"smoke",
       "smoke on tetrahedra, steady and new, eye fixed and moving; ratios to the reference",
       benchSmoke},
#ifdef VOLUTE_BENCH
      {"tree",
       "the compact tree in memory, against dense, the paper's layout, zfp and NanoVDB at "
       "relative RMS 3e-3, one thread",
       benchTree},
#endif
  };
  return table;
}

}  // namespace volute::cli
