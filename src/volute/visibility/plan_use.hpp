// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/visibility/watch.hpp"

namespace volute {

/// What the points of a plan are for. Verdicts are of points where people are.
struct PlanUse {
  enum class Kind : unsigned char {
    kPeople,  ///< there is a floor below
    kVoid,    ///< no floor within kReach below: a shaft, a void, above a roof
    kFire,    ///< in the fire's or a burner's own place
  };

  /// How far below an eye a floor may be [m].
  static constexpr double kReach = 2.5;

  std::vector<Kind> kinds;  ///< of each eye
  std::string firesFrom;    ///< how the fire's place is known; empty: no point is in it

  /// One for each eye.
  std::vector<bool> are(Kind kind) const;

  std::size_t count(Kind kind) const;

  /// "not counted: ..."; empty where all points count.
  std::string words() const;
};

/// Of eyes at the first time. With Survey::everywhere, and where no point has a floor, all of them
/// are for people; the latter is a remark.
PlanUse planUse(const Survey& survey, const SightInstant& first, std::span<const Vec3> eyes,
                Progress& progress);

}  // namespace volute
