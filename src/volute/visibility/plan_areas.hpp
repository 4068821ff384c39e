// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/visibility/plan_picture.hpp"
#include "volute/visibility/plan_use.hpp"
#include "volute/visibility/plan_values.hpp"
#include "volute/visibility/verdict.hpp"
#include "volute/visibility/watch.hpp"

// Verdicts of parts of a plan: rooms, and the areas, routes and exits that somebody names.

namespace volute {

/// The parts of one plan.
struct PlanAreas {
  struct Area {
    std::string name;
    std::string kind;  ///< "room", "area", "route", "exit"
    std::string storey;
    double size = 0;             ///< [m2]; of routes and exits, of their points
    std::optional<double> rset;  ///< [s]
    bool people = true;          ///< verdicts of the whole plan count it
    bool outside = false;        ///< a room from which an opening of the case's border leads
    std::vector<std::size_t> eyes{};
  };

  /// Between two rooms or areas, by position in `areas`.
  struct Door {
    std::size_t first = 0, second = 0;
    Vec2 place = Vec2::Zero();
    double width = 0;   ///< [m]
    bool shut = false;  ///< something opaque stands there at some time
  };

  std::vector<Area> areas;
  std::vector<Door> doors;
  std::vector<int> of;  ///< of each eye: its room or area; -1: in none

  /// The size of the room or area of each eye [m2]; NaN: it is in none.
  std::vector<double> sizes() const;
};

/// Finds the rooms of a plan; the survey's areas win over them. Refuses areas of the plan's storey
/// that hold none of its points.
[[nodiscard]] Result<PlanAreas> planAreas(const Survey& survey, const SightSnapshot& first,
                                          std::span<const Vec3> eyes, Progress& progress);

/// Safety margins at the places of a plan: available minus required safe egress time [s].
struct PlanMargins {
  std::vector<double> rset;    ///< NaN: nobody is there
  std::vector<double> margin;  ///< infinite: no criterion is reached; NaN: not known, or nobody
  std::vector<double> least;  ///< what is sure: `margin`, or what is left until the end of the data

  /// Counts of some places, and the worst of them.
  struct Worst {
    std::size_t needed = 0, tooLate = 0, unknown = 0;  ///< places
    std::optional<std::size_t> place{};                ///< with the smallest margin that is known
    std::optional<std::size_t> open{};  ///< with the smallest of those that are not known
  };

  Worst worst(std::span<const std::size_t> places) const;

  /// The largest RSET of some places [s]; NaN: nobody is at any.
  double longest(std::span<const std::size_t> places) const;
};

/// @param aset  of all criteria; `end` is the last time that is looked at
PlanMargins planMargins(std::vector<double> rset, const LossTimes& aset, RoundTime round,
                        double end);

/// What is told of each part of a plan.
struct AreaFindings {
  std::span<const Vec3> eyes;
  const LossTimes* all = nullptr;     ///< of all criteria
  const LossTimes* latest = nullptr;  ///< the same by the least that the data allow; may be null
  std::vector<std::string> by{};      ///< the first of them at each eye; may be empty

  struct Single {
    std::string name;
    const LossTimes* times = nullptr;
    std::vector<bool> holds{};          ///< at which eyes it is a criterion; empty: at all
    const LossTimes* latest = nullptr;  ///< by the least that the data allow; null: as times
  };

  std::vector<Single> single{};          ///< each criterion by itself
  std::vector<bool> people{};            ///< which eyes count
  const PlanMargins* margins = nullptr;  ///< may be null
};

/// Adds `areas` and `doors` to a report and sentences to its verdict, writes areas.csv and
/// areas.png; their part of the page.
[[nodiscard]] Result<std::string> reportAreas(const Survey& survey, const PlanAreas& areas,
                                              const AreaFindings& found, PlanPicture picture,
                                              const PlanValues& values, Json& report,
                                              Json& verdict);

}  // namespace volute
