// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "volute/base/remark.hpp"
#include "volute/visibility/floor_plan.hpp"

// Eye positions: plans, routes, tables and trajectories.

namespace volute {

/// The points of a plan over `bounds` at a height, and whether they are obstructed at that time.
/// The grid starts at the bounds' lower corner; at most 4 million points.
[[nodiscard]] Result<FloorPlan> floorPlan(const SightSnapshot& snapshot, const Box3& bounds,
                                          double height, double step);

/// An escape route: straight from point to point.
struct Route {
  std::string name;
  std::vector<Vec3> points;  ///< of the eyes [m], at least two
  bool level = false;        ///< no point states its z

  double length() const;
  Vec3 at(double along) const;  ///< [m] from the start; clamped to the route
};

/// Points along a route at most `step` apart [m], from its start to its end, as distances from the
/// start. Corners are among them.
std::vector<double> stationsOf(const Route& route, double step);

/// A line of a table of points.
struct NamedPoint {
  std::string name;  ///< from the column "route" or "name"; empty without one
  Vec3 position = Vec3::Zero();
  bool hasZ = false;  ///< the table states it
};

/// Points in a table: x,y,z or x,y [m], with or without a line of column names (x, y, z, and name
/// or route), which may have units, as in "x [cm]"; lines that begin with # are comments. Without z
/// the eyes are at `height`. Errors name `file` and the line; a column with another name is one.
[[nodiscard]] Result<std::vector<NamedPoint>> parsePoints(std::string_view text,
                                                          std::string_view file,
                                                          std::optional<double> height);

/// Routes of consecutive points: one route for each name, in order of first appearance.
[[nodiscard]] Result<std::vector<Route>> routesOf(const std::vector<NamedPoint>& points,
                                                  std::string_view file);

/// Positions of walking people over time.
class Trajectories {
 public:
  /// People as evacuation programs write them:
  /// - a table with names: id, time [s], x, y, z [m] of the eyes, or `floor` instead of z, and
  ///   eye_height, if known; units in the names or in a line below;
  /// - Pathfinder's table of occupants (with a column active or location), whose z is the floor;
  /// - JuPedSim's text, "# framerate: F" and lines "id frame x y z ...", whose z is the floor, or
  ///   PeTrack's (centimetres, or named in a remark), whose z is the head;
  /// - JuPedSim's SQLite database, without z.
  /// With `height` all eyes are at that z [m]; else they are `eyeHeight` [m] above floors, which
  /// remarks() says.
  [[nodiscard]] static Result<Trajectories> parse(std::string_view text, std::string_view file,
                                                  std::optional<double> height,
                                                  double eyeHeight = kEyeHeight);

  static constexpr double kEyeHeight = 1.8;  ///< [m]

  /// Whether anybody's eyes are `eyeHeight` above a floor.
  bool areAboveFloors() const { return aboveFloors_; }

  /// Remarks on how columns and units were read.
  std::span<const Remark> remarks() const { return remarks_; }

  struct Person {
    int id = 0;
    Vec3 eye = Vec3::Zero();
  };

  /// The people present at a time [s], by id; positions are interpolated linearly between two
  /// frames of a person.
  std::vector<Person> at(double time) const;

  /// The last time [s] at which a person is within `radius` [m] of a point, seen from above, and on
  /// its storey: a person whose z is known is on that of points up to 2.5 m above it and .6 m below
  /// it, so that it may be the floor's or the eyes'. NaN if nobody comes near it.
  std::vector<double> lastTimes(std::span<const Vec3> points, double radius) const;

  /// How many people are never at a height [m] that `isOn`.
  std::size_t outside(const std::function<bool(double z)>& isOn) const;

  std::span<const int> ids() const { return ids_; }  ///< ascending

  /// When each is there, by id: the first and the last time [s].
  std::vector<std::pair<int, StoredSpan>> spans() const;

  int people() const { return static_cast<int>(ids_.size()); }

  double begin() const { return begin_; }  ///< [s]

  double end() const { return end_; }

 private:
  struct Step {
    double time;
    Vec3 eye;
  };

  void add(int id, std::vector<Step> steps);

  std::vector<Remark> remarks_;
  bool aboveFloors_ = false;
  std::vector<int> ids_;
  std::vector<std::vector<Step>> steps_;  // of each person, ascending in time
  double begin_ = 0, end_ = 0;
};

}  // namespace volute
