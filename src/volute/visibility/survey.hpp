// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/visibility/safety_sign.hpp"

namespace volute {

/// A sign with the point that sight lines end at.
struct SightTarget {
  SafetySign sign;
  Vec3 target = Vec3::Zero();  ///< the sign's position, or the nearest gas in front of it
};

/// Finds where sight lines to the signs end. A sign on a wall's face is its own target; one inside
/// of a wall or outside of the field gets the first gas along its normal, with a remark, as far as
/// half a metre; beyond that it is an error that names the sign.
[[nodiscard]] Result<std::vector<SightTarget>> placeSigns(const SightInstant& instant,
                                                          std::span<const SafetySign> signs,
                                                          const Box3& bounds, Progress& progress);

/// Looks from all eyes to all signs at one instant, on all threads.
/// @param out  shape (sign, eye), eye fastest.
void lookAround(const SightInstant& instant, std::span<const SightTarget> signs,
                std::span<const Vec3> eyes, std::span<Sighting> out);

/// The first stored times at which something is no longer so, for many places [s]; infinite where
/// it always is.
struct LossTimes {
  std::vector<double> time;      ///< at the field's depths
  std::vector<double> earliest;  ///< at the largest depths that its rounding allows
  std::vector<double> latest;    ///< at the smallest

  explicit LossTimes(std::size_t places);

  /// A stored time, in ascending order; `holds(i)` etc. say what is so at place i.
  template <class Holds, class Certainly, class Possibly>
  void update(double now, Holds&& holds, Certainly&& certainly, Possibly&& possibly) {
    for (std::size_t i = 0; i < time.size(); ++i) {
      if (!holds(i) && now < time[i])
        time[i] = now;
      if (!certainly(i) && now < earliest[i])
        earliest[i] = now;
      if (!possibly(i) && now < latest[i])
        latest[i] = now;
    }
  }
};

/// When no sign of a set is seen any more: the ASET map (available safe egress time) by visibility.
/// @param members  the set, positions in the signs.
/// @param sightings  as lookAround gives them at `now`.
void updateLoss(LossTimes& loss, double now, std::span<const std::size_t> members,
                std::span<const Sighting> sightings);

}  // namespace volute
