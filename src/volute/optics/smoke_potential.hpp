// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <string_view>

#include "volute/base/result.hpp"

namespace volute {

enum class Burning { kFlaming, kSmouldering };

/// "flaming" or "smouldering".
[[nodiscard]] Result<Burning> burning(std::string_view name);

/// Optical density in dB/m of 1 g of burnt material spread in 1 m3.
struct SmokePotential {
  std::string_view material;
  double flaming;      ///< [dB m2/g]
  double smouldering;  ///< [dB m2/g], without flames

  double value(Burning how) const { return how == Burning::kFlaming ? flaming : smouldering; }
};

/// Staubli et al. 2005, table 1, who reprint it from the fire engineering literature.
std::span<const SmokePotential> smokePotentials();

/// By name, whatever its case. An error lists the names.
[[nodiscard]] Result<SmokePotential> smokePotentialOf(std::string_view material);

}  // namespace volute
