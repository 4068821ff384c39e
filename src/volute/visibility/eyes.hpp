// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volute/visibility/floor_plan.hpp"

// Where people look from.

namespace volute {

/// The points of a plan over `bounds` at a height, and what stands there at that instant. The
/// squares start at the bounds' lower corner; at most 4 million of them.
[[nodiscard]] Result<FloorPlan> floorPlan(const SightInstant& instant, const Box3& bounds,
                                          double height, double step);

/// A way of escape: straight from point to point.
struct Route {
  std::string name;
  std::vector<Vec3> points;  ///< of the eyes [m], at least two

  double length() const;
  Vec3 at(double along) const;  ///< [m] from the start; clamped to the route
};

/// Points along a route at most `step` apart [m], from its start to its end, as distances from the
/// start. Corners are among them.
std::vector<double> stationsOf(const Route& route, double step);

/// A line of a table of points.
struct NamedPoint {
  std::string name;  ///< of the column "route" or "name"; empty without
  Vec3 position = Vec3::Zero();
};

/// Points in comma-separated text: x,y,z or x,y [m], with or without a line of column names (x, y,
/// z, and name or route); lines that begin with # are remarks. Without z the eyes are at `height`.
/// Errors name `file` and the line.
[[nodiscard]] Result<std::vector<NamedPoint>> parsePoints(std::string_view text,
                                                          std::string_view file,
                                                          std::optional<double> height);

/// Routes of points that follow each other: a route for each name, in the order of the first.
[[nodiscard]] Result<std::vector<Route>> routesOf(const std::vector<NamedPoint>& points,
                                                  std::string_view file);

/// Where walking people are over time.
class Trajectories {
 public:
  /// JuPedSim's text format, or a table as parseTable() has it: "# framerate: F", lines "id frame x y z ..." in metres, or in
  /// centimetres when the line of column names says so ("x/cm"). With `height` the eyes are at that
  /// z, else at the file's.
  [[nodiscard]] static Result<Trajectories> parse(std::string_view text, std::string_view file,
                                                  std::optional<double> height);

  /// Comma-separated text with a line of names: id, time [s] (or t), x, y [m], and z without
  /// `height`. parse() takes such files as well.
  [[nodiscard]] static Result<Trajectories> parseTable(std::string_view text, std::string_view file,
                                                       std::optional<double> height);

  struct Person {
    int id = 0;
    Vec3 eye = Vec3::Zero();
  };

  /// Those who are there at a time [s], by id; between two frames of a person on the straight line
  /// between them.
  std::vector<Person> at(double time) const;

  /// When somebody is within `radius` [m] of a point for the last time, seen from above [s]; NaN
  /// where nobody comes.
  std::vector<double> lastTimes(std::span<const Vec3> points, double radius) const;

  std::span<const int> ids() const { return ids_; }  ///< ascending

  int people() const { return static_cast<int>(ids_.size()); }

  double begin() const { return begin_; }  ///< [s]

  double end() const { return end_; }

 private:
  struct Step {
    double time;
    Vec3 eye;
  };

  void add(int id, std::vector<Step> steps);

  std::vector<int> ids_;
  std::vector<std::vector<Step>> steps_;  // of each person, ascending in time
  double begin_ = 0, end_ = 0;
};

}  // namespace volute
