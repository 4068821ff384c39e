// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <string_view>
#include <variant>

#include "volute/visibility/eyes.hpp"

namespace volute {

/// How long people need (required safe egress time).
class Rset {
 public:
  /// The same for everybody [s].
  explicit Rset(double seconds) : what_(seconds) {}

  /// Until somebody comes by for the last time.
  explicit Rset(Trajectories people) : what_(std::move(people)) {}

  /// A map: lines x,y,rset [m, m, s], or people who walk as Trajectories::parse() takes them.
  [[nodiscard]] static Result<Rset> parse(std::string_view text, std::string_view file);

  /// A number of seconds >= 0, or the name of a file for parse(), of at most `most` bytes.
  /// kInvalidArgument, "rset: ...", for other numbers.
  [[nodiscard]] static Result<Rset> read(const std::string& secondsOrFile, std::uint64_t most);

  /// At points [s]; NaN where nobody comes. `radius` [m] around people; a map's value is that of
  /// its nearest point.
  std::vector<double> at(std::span<const Vec3> points, double radius) const;

  /// Whether it is of people who walk, and so has times alone where somebody is.
  bool isOfPeople() const { return std::holds_alternative<Trajectories>(what_); }

  std::string description() const;

 private:
  explicit Rset(std::vector<Vec3> map) : what_(std::move(map)) {}

  std::variant<double, Trajectories, std::vector<Vec3>> what_;  // of a map: z is the time
};

}  // namespace volute
