// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "volute/fog/fog_medium.hpp"

// How rays get into the lanes of the SIMD walk: a batch of rays is laid out once, and entered into
// each zone of the profile and each level of detail that it meets.

namespace volute {

constexpr std::size_t kFogLanes = 128;  // what a batch holds; a multiple of any vector's lanes

enum class ZoneKind { kConstant, kLinear, kExponential };

ZoneKind kindOf(const FogProfile::Zone& zone);

/// A batch of rays in double; positions count from the corner of the fog's domain [m].
struct FogRays {
  alignas(64) double origin[3][kFogLanes];
  alignas(64) double direction[3][kFogLanes];
  alignas(64) double begin[kFogLanes];
  alignas(64) double end[kFogLanes];
  alignas(64) double distance[kFogLanes];  ///< |OP| where detail is dropped by mu; finite
  std::size_t count = 0;  ///< up to the next multiple of 16 there are rays of no length

  bool behind = false;  ///< some begin behind the eye

  /// At most kFogLanes segments.
  void set(const FogMedium& fog, std::span<const Segment> segments);
};

/// Where the levels of a fog end along its rays: FogDetail::ends() for |OP| = 1.
struct LevelEnds {
  FogDetail::Ends ends;
  int count = 1;  ///< levels that are looked at

  explicit LevelEnds(const FogMedium& fog);
};

/// The parts of a batch in one zone and one level, as the walk wants them: s counts from where each
/// ray enters, in metres. A ray that misses what is not empty has no length.
struct FogLanes {
  struct Axis {
    alignas(64) float first[kFogLanes];     ///< s of the first plane; huge when parallel
    alignas(64) float delta[kFogLanes];     ///< from plane to plane; 0 when parallel
    alignas(64) float velocity[kFogLanes];  ///< cells per metre
    alignas(64) float exitAt[kFogLanes];    ///< place in the cell (0..1) where the ray leaves it
    alignas(64) std::int32_t cell[kFogLanes];
    alignas(64) std::int32_t step[kFogLanes];
  };

  Axis x, y;
  alignas(64) float begin[kFogLanes];  ///< parameter of the segment where the ray enters
  alignas(64) float length[kFogLanes];
  alignas(64) float zoneBegin[kFogLanes];  ///< g at s = 0; exponential: its exponent, negated
  alignas(64) float zoneSlope[kFogLanes];  ///< [1/m], the change of zoneBegin with s
  FogLevels::Level level;

  /// False when no ray is in this zone and level.
  bool set(const FogMedium& fog, const FogRays& rays, const FogProfile::Zone& zone, int level,
           const LevelEnds& ends);
};

}  // namespace volute
