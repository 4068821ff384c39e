// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/visibility/watch.hpp"

namespace volute {

/// The use of the points of a plan. Verdicts are given for points where people are.
struct PlanUse {
  enum class Kind : unsigned char {
    kPeople,  ///< there is a floor below, and head room
    kVoid,    ///< no floor within kReach below: a shaft, a void, above a roof
    kFire,    ///< in the fire's or a burner's own place
    kLow,     ///< less than kHeadRoom between the floor and what is above
    kTop,     ///< on top of something: a small surface that no step leads to
    kNamed,   ///< in an area that somebody names as not for people
    kHigher,  ///< the floor is higher than the plan's, and the air at the eyes there is not known
  };

  /// How far below an eye a floor may be [m].
  static constexpr double kReach = 2.5;
  static constexpr double kHeadRoom = 1.8;  ///< [m]
  /// How high a step is, and how much a ramp or stairs may rise with distance.
  static constexpr double kStep = 0.3, kSlope = 0.8;  ///< [m], [m/m]
  static constexpr double kTopOfThings = 6;  ///< smaller surfaces without a step are furniture [m2]

  std::vector<Kind> kinds;   ///< of each eye
  std::string firesFrom{};   ///< how the fire's place is known; empty: no point is in it
  std::string areas{};       ///< names of areas that are not for people
  bool fireUnknown = false;  ///< neither the case nor the user says where it burns
  bool fireFound = false;    ///< nor do they, and its place is where the smoke rises

  /// The people's places among some are the fire's. Nothing if that is most of them.
  void findFire(const std::vector<bool>& eyes, std::string from);

  /// One for each eye.
  std::vector<bool> are(Kind kind) const;

  std::size_t count(Kind kind) const;

  /// All points are for people, as none would be otherwise, which is a remark.
  static PlanUse everybody(std::size_t eyes, Progress& progress);

  /// "not counted: ...", and whether the fire's own place is; empty where all points count.
  std::string words() const;
};

/// The floors within PlanUse::kReach below eyes at a height [m], at the first time; NaN where there
/// is none. Eyes above floors that are higher than the plan's by more than a step, as on ramps,
/// stairs and stages, are lifted as far above them, as far as there is gas; how many is a remark.
/// @param bounds  of the field
std::vector<double> standOnFloors(const SightSnapshot& first, const Box3& bounds, double height,
                                  std::span<Vec3> eyes, Progress& progress);

/// Of eyes at the first time, `places` of the plan, above floors as standOnFloors() gives them.
/// With Survey::everywhere, and where no point has a floor, all of them are for people; the latter
/// is a remark.
PlanUse planUse(const Survey& survey, const SightSnapshot& first, const FloorPlan& plan,
                std::span<const std::size_t> places, std::span<const Vec3> eyes,
                std::span<const double> floors, Progress& progress);

}  // namespace volute
