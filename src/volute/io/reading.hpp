// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>

#include "volute/base/progress.hpp"

namespace volute {

class MemoryVolumes;

/// How the parts of a scene are read: who receives progress and may stop it, and how much memory it
/// takes.
struct Reading {
  Progress& progress;
  std::uint64_t maxMemory = 0;             ///< [bytes]
  const MemoryVolumes* volumes = nullptr;  ///< found by name before files are; may be null

  /// The same with another receiver of progress.
  Reading with(Progress& other) const { return {other, maxMemory, volumes}; }
};

}  // namespace volute
