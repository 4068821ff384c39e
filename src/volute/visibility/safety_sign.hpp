// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "volute/media/sight.hpp"
#include "volute/optics/visibility.hpp"

namespace volute {

/// How the distance from which a sign is seen depends on the angle between the line of sight and
/// the sign's normal: it is multiplied by a factor from 0 to 1.
struct AngleLaw {
  enum class Kind {
    kFront,   ///< 1 from in front of the sign's plane, else 0
    kAny,     ///< 1 from everywhere
    kCosine,  ///< the angle's cosine, 0 from behind (as in FDSVismap, Boerger et al. 2024)
    kLimit,   ///< 1 up to `limit`, else 0
  };

  Kind kind = Kind::kFront;
  double limit = 90;  ///< [degrees], of kLimit

  double factor(double cosine) const;
};

/// "front", "any" or "cosine".
[[nodiscard]] Result<AngleLaw> angleLaw(std::string_view name);
std::string nameOf(const AngleLaw& law);  ///< "limit 60" for one with a limit

/// A sign that people look for.
struct SafetySign {
  std::string name;
  Vec3 position = Vec3::Zero();      ///< its middle [m]
  Vec3 normal = Vec3::UnitX();       ///< unit; where it faces
  std::array<double, 2> size{0, 0};  ///< width and height [m]
  VisibilityLaw law;                 ///< how far it is seen in smoke
  AngleLaw angle;
  std::vector<std::string> routes{};  ///< for whose walkers it is; empty: for everybody
};

/// Whether a sign is seen.
enum class Seen : unsigned char {
  kNo,
  kYes,
  kCannotTell,  ///< the smoke is not known well enough: rounded files, or no data on the line
};

std::string_view nameOf(Seen seen);  ///< "no", "yes", "cannot tell"

/// The visibility of a sign from an eye at one time. A survey holds one of each eye and sign.
struct Sighting {
  double depth = 0, low = 0, high = 0;  ///< see Sight; NaN, the known part, infinity if not covered
  double distance = 0;                  ///< [m]
  double limit = 0;                     ///< largest depth at which the sign is seen, C factor; 0:
                                        ///< it cannot be read from there
  float angle = 0;  ///< [degrees] between the sign's normal and the direction to the eye
  bool covered : 1 = true;
  bool blocked : 1 = false;
  bool visible : 1 = false;    ///< in sight, depth <= limit
  bool certainly : 1 = false;  ///< so at any depth up to `high`
  bool possibly : 1 = false;   ///< so at some depth from `low` up

  /// [1/m].
  double meanExtinction() const { return distance > 0 ? depth / distance : 0; }

  /// From how far the sign would be seen through smoke of that mean extinction at that angle [m]:
  /// C factor / K; infinite in clear air, 0 from where it cannot be read, NaN if not covered.
  double visibility() const;

  /// By the bounds of the depth.
  Seen seen() const { return certainly ? Seen::kYes : (possibly ? Seen::kCannotTell : Seen::kNo); }
};

/// Puts together where the eye is and what lies on the line.
Sighting judge(const SafetySign& sign, const Vec3& eye, const Sight& sight);

/// The same with another depth on the same line, between two stored times, say.
Sighting judged(Sighting sighting, double depth, double low, double high);

}  // namespace volute
