// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volute/report/json.hpp"
#include "volute/visibility/verdict.hpp"

// Sensitivity of a verdict to uncertain inputs.

namespace volute {

/// A variant of the survey, for comparison.
struct Variation {
  std::string_view name;
  double smoke = 1;  ///< what the extinction is multiplied with
  double law = 1;    ///< what the C of signs is multiplied with

  /// What the C of signs is multiplied with to the same effect.
  double onSigns() const { return law / smoke; }
};

/// Jin's experiments give C of 2 to 4 for reflecting signs and 5 to 10 for emitting ones; FDS's
/// User's Guide 8700 +- 1100 m2/kg for the mass extinction. That the yield of soot is known to 25 %
/// is assumed; its smoke is taken in proportion. Losses that were missed because they were over
/// before the next stored time came within 2 % of the limit at stored times (measured).
std::span<const Variation> variations();

/// An uncertain input with its two limits.
struct Uncertainty {
  std::string name, first, second;  ///< "C of the signs", "33 % lower", "33 % higher"
  FirstLoss atFirst, atSecond;
};

/// {base, rows: [{name, first: {is, time, known}, second, span}]}, the largest span first. Times
/// are interpolated; null: not known, or not reached.
Json sensitivityJson(const FirstLoss& base, std::span<const Uncertainty> all);

/// The same as a table of the page, and as a tornado chart in `file` (.png, and .svg beside it).
[[nodiscard]] Result<std::string> sensitivityPart(const Json& sensitivity, double begin, double end,
                                                  const std::filesystem::path& file);

}  // namespace volute
