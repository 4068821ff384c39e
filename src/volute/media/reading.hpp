// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>

#include "volute/base/progress.hpp"

namespace volute {

/// What reads the parts of a scene: who hears of it and may stop it, and how much it may hold.
struct Reading {
  Progress& progress;
  std::uint64_t maxMemory = 0;  ///< [bytes]
};

}  // namespace volute
