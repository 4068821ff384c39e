// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/math/vec.hpp"

namespace volute {

/// A part of plans that somebody names, for verdicts of its own.
struct NamedArea {
  enum class Kind : unsigned char {
    kArea,   ///< what is inside of a polygon
    kRoute,  ///< what is near a line, or in areas and exits
    kExit,   ///< what is near a line
  };

  Kind kind = Kind::kArea;
  std::string name;
  std::string storey;                                     ///< empty: it is on each
  double low = -std::numeric_limits<double>::infinity();  ///< z of the storey's floor [m]
  double high = std::numeric_limits<double>::infinity();  ///< and of what is above [m]
  std::vector<Vec2> outline;         ///< of a polygon, or the points of a line [m]
  double reach = 0;                  ///< around a line [m]
  std::vector<std::string> members;  ///< of a route: names of areas and exits
  bool people = true;                ///< verdicts of the whole plan count it
  std::optional<double> rset;        ///< [s]

  /// Whether a plan at this height of the eyes [m] is of its storey.
  bool isAt(double height) const { return low <= height && height < high; }

  /// Whether a point is in the polygon, or near the line.
  bool contains(const Vec2& point) const;
};

/// Reads areas.json: {"storeys": [{"name", "z": [floor, ceiling]}], "areas": [{"name", "storey",
/// "polygon": [[x, y], ...], "people", "rset"}], "exits": [{"name", "storey", "line", "radius"}],
/// "routes": [{"name", "storey", "line", "width"} or {"name", "areas": [names]}]}; lengths in
/// metres. Refused, with the place in the file: polygons that cross themselves, areas of a storey
/// that overlap, names that are there twice or not at all.
[[nodiscard]] Result<std::vector<NamedArea>> readAreas(const std::string& file);

/// A closed line of a drawing.
struct PlanOutline {
  std::string name;   ///< empty: not known
  std::string where;  ///< in its file, for people
  std::vector<Vec2> points;
};

/// Areas of each storey from what is drawn on a layer. Those without a name have that of the text
/// within them, else the layer's with a number. Refused as in areas.json, and where there are none.
/// @param texts  where each begins
[[nodiscard]] Result<std::vector<NamedArea>> areasOfOutlines(
    std::vector<PlanOutline> outlines, std::span<const std::pair<Vec2, std::string>> texts,
    const std::string& layer, const std::string& file);

/// Refuses areas whose names are there twice, and those of a storey that overlap.
/// @param from  where each is from, for people
[[nodiscard]] Status checkTogether(std::span<const NamedArea> areas,
                                   std::span<const std::string> from);

/// Refuses areas of storeys of which no plan is made.
[[nodiscard]] Status checkStoreys(std::span<const NamedArea> areas, std::span<const double> heights,
                                  const std::string& file);

/// A place that two polygons share, by more than a centimetre; nothing where they do not.
std::optional<Vec2> overlap(std::span<const Vec2> one, std::span<const Vec2> other);

}  // namespace volute
