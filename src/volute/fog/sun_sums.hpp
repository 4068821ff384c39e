// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "volute/fog/fog_medium.hpp"

namespace volute {

/// Integrals over the ways from many places on the floor of a fog to the sun, all of one direction.
/// On large maps ways are walked to the next of the lines that cut the map across, 32 cells apart;
/// what is beyond is interpolated linearly between the ways through at least 16 places of each cell
/// on that line. Those ways meet the next line in places that are known too, so that they are
/// walked once, and each result is interpolated once: n^2 cells' work for n^2 places, not n^3.
class SunSums {
 public:
  /// What is integrated along t > 0 [m].
  enum class Weight {
    kOne,    ///< rho(p + s t)
    kWay,    ///< rho t
    kDecay,  ///< rho exp(-decay s_z t)
  };

  /// @param fog  without levels of detail and top; its profile does not count
  /// @param sun  unit length, s_z > 0
  /// @param samples  along the side of a cell that are asked for
  /// @param decay  [1/m], of kDecay
  /// @param plain  of kWay: the sums of kOne, which must outlive these
  SunSums(const FogMedium& fog, const Vec3& sun, int samples, Weight weight, double decay = 0,
          const SunSums* plain = nullptr);

  /// Of places of the map [cells] from its corner.
  /// @param places  shape (n, 2), within the map
  void at(std::span<const Vec2> places, std::span<double> sums) const;

  /// Maps of at most so many cells are walked from end to end.
  static constexpr int kWhole = 128;

 private:
  /// The sums from a line across the map; between nodes linear.
  struct Line {
    std::int64_t first = 0;  ///< the lowest node, in nodes
    std::vector<double> sums;

    double at(double node) const;
  };

  void fill(int line);
  /// Integrals over the ways of so many metres at most from each place.
  void walk(std::span<const Vec2> places, std::span<const double> lengths,
            std::span<double> sums) const;
  /// What the way beyond a line adds, after so many metres before it.
  double beyond(int line, double node, double before) const;

  /// Nodes count along lines that the ways follow: node n is at n / perCell_ + slope_ * way.
  double nodeAt(double across, double way) const { return (across - slope_ * way) * perCell_; }

  FogMedium fog_;
  Vec3 sun_;
  Weight weight_;
  double factor_ = 1;
  double decay_ = 0;
  const SunSums* plain_ = nullptr;
  int along_ = 0;  ///< the axis that lines cut across
  int cellsAlong_ = 0, cellsAcross_ = 0;
  double speed_ = 0;  ///< [cells/m] along
  double slope_ = 0;  ///< cells across for each cell along
  int perCell_ = 1;
  std::vector<Line> lines_;  ///< the one at (i + 1) * 32 cells of the way
};

}  // namespace volute
