// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>

namespace volute {

/// The largest amount of memory that this process has held [bytes].
std::uint64_t peakMemoryBytes();

/// CPU time of this process and its finished children [s], user and system.
double cpuSeconds();

}  // namespace volute
