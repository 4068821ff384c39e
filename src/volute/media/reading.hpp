// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>

#include "volute/base/progress.hpp"

namespace volute {

/// How the parts of a scene are read: who receives progress and may stop it, and how much memory it
/// takes.
struct Reading {
  Progress& progress;
  std::uint64_t maxMemory = 0;  ///< [bytes]
};

}  // namespace volute
