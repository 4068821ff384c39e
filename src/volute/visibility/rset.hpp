// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "volute/visibility/eyes.hpp"

namespace volute {

/// How long people need (required safe egress time).
class Rset {
 public:
  /// One required time for everybody [s].
  explicit Rset(double seconds) : what_(seconds) {}

  /// The required time of a point is the last time at which people pass it.
  explicit Rset(Trajectories people) : what_(std::move(people)) {}

  /// A map: lines x,y,rset [m, m, s] or with a line of names (z too, and other units), a table
  /// area,rset, or people who walk as Trajectories::parse() takes them. Two values at one place or
  /// of one area are refused.
  [[nodiscard]] static Result<Rset> parse(std::string_view text, std::string_view file);

  /// A number of seconds >= 0, or the name of a file for parse(), of at most `most` bytes.
  /// kInvalidArgument, "rset: ...", for other numbers.
  [[nodiscard]] static Result<Rset> read(const std::string& secondsOrFile, std::uint64_t most);

  /// At points [s]; NaN where nobody comes. `radius` [m] around people; a map's value is that of
  /// its nearest point, of the same storey where the map has z; NaN without one.
  std::vector<double> at(std::span<const Vec3> points, double radius) const;

  /// Whether it is of people who walk, and so has times alone where somebody is.
  bool isOfPeople() const { return std::holds_alternative<Trajectories>(what_); }

  /// The required times of rooms and areas by name [s].
  std::span<const std::pair<std::string, double>> areas() const;

  /// Sentences about how a file was read, and about people, or places of a map, that are on no
  /// storey with eyes at one of these heights [m].
  std::vector<Remark> remarks(std::span<const double> heights) const;

  std::string description() const;

  /// How many places of a map lie beside these bounds, and the first of them; empty: none.
  std::string placesBeside(const Box3& bounds) const;

 private:
  using Areas = std::vector<std::pair<std::string, double>>;

  struct Place {
    double x = 0, y = 0;      // [m]
    std::optional<double> z;  // [m], if the map has it
    double seconds = 0;
  };

  explicit Rset(std::vector<Place> map) : what_(std::move(map)) {}

  explicit Rset(Areas areas) : what_(std::move(areas)) {}

  static Result<Rset> parseAreas(std::string_view text, std::string_view file);

  static Status checkPlaces(std::vector<Place> map, std::string_view file);

  std::variant<double, Trajectories, std::vector<Place>, Areas> what_;
};

}  // namespace volute
