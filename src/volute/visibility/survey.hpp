// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/base/team.hpp"
#include "volute/visibility/safety_sign.hpp"

namespace volute {

/// A sign with the point that sight lines end at.
struct SightTarget {
  SafetySign sign;
  Vec3 target = Vec3::Zero();  ///< the sign's position, or the nearest gas in front of it
};

/// Finds the end points of sight lines to the signs. A sign on a wall's face is its own target; one
/// inside a wall or outside the field gets the first gas along its normal, up to half a metre away,
/// with a remark; beyond that it is an error that names the sign.
[[nodiscard]] Result<std::vector<SightTarget>> placeSigns(const SightSnapshot& snapshot,
                                                          std::span<const SafetySign> signs,
                                                          const Box3& bounds, Progress& progress);

/// Looks from all eyes to all signs at one time, on all threads.
/// @param out  shape (sign, eye), eye fastest.
void lookAround(const SightSnapshot& snapshot, std::span<const SightTarget> signs,
                std::span<const Vec3> eyes, std::span<Sighting> out);

/// Looks repeatedly from the same eyes, while smoke changes and obstructions mostly stay: computes
/// the weights of lines once and keeps them, as far as memory allows.
class Lookout {
 public:
  /// Keeps at most `maxBytes` of weights; further lines are traced again each time.
  explicit Lookout(std::uint64_t maxBytes) : maxBytes_(maxBytes) {}

  /// As lookAround(), to float precision.
  /// @param again  whether there will be another call; if not, nothing is kept.
  void look(const SightSnapshot& snapshot, std::span<const SightTarget> signs,
            std::span<const Vec3> eyes, std::span<Sighting> out, bool again);

  /// Collective. Computes the weights for look(), each line on one rank, and distributes them.
  [[nodiscard]] Status workOutTogether(const SightSnapshot& snapshot,
                                       std::span<const SightTarget> signs,
                                       std::span<const Vec3> eyes, Team& team);

 private:
  /// Lines that are computed and summed together.
  struct Batch {
    std::vector<SightWeight> weights;
    std::vector<std::uint32_t> ends;  ///< of each line's weights
    std::vector<Sighting> sights;     ///< but for the depths
  };

  bool fits(const SightSnapshot& snapshot, std::span<const Vec3> eyes) const;
  bool workOut(const SightSnapshot& snapshot, std::span<const SightTarget> signs,
               std::span<const Vec3> eyes);
  std::uint64_t workOutSome(const SightSnapshot& snapshot, std::span<const SightTarget> signs,
                            std::span<const Vec3> eyes, int rank, int ranks);
  bool keep(const SightSnapshot& snapshot, std::span<const Vec3> eyes, std::uint64_t bytes);
  void sum(const SightSnapshot& snapshot, std::span<const SightTarget> signs,
           std::span<const Vec3> eyes, std::span<Sighting> out) const;

  std::uint64_t maxBytes_;
  std::uint64_t geometry_ = 0;  // of the lines that are kept; 0: none
  std::uint64_t tooLarge_ = 0;  // the geometry whose lines did not fit
  std::vector<Vec3> eyes_;
  std::vector<Batch> batches_;
};

}  // namespace volute
