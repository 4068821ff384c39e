// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/cli/bench.hpp"

namespace volute::cli {

[[nodiscard]] Result<std::vector<BenchRow>> benchSlice(Progress& progress);
[[nodiscard]] Result<std::vector<BenchRow>> benchCodec(Progress& progress);

}  // namespace volute::cli
