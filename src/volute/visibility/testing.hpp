// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/media/sight.hpp"

namespace volute {

/// A room 30 x 10 x 3 m of uniform smoke K and a wall of 1 m from x = 20 on, all but 4 m wide.
class Room final : public BasicSightSnapshot {
 public:
  explicit Room(double extinction) : extinction_(extinction) {}

  static Box3 bounds() { return {Vec3(0, 0, 0), Vec3(30, 10, 3)}; }

  void look(std::span<const SightLine> lines, std::span<Sight> sights) const override {
    for (std::size_t i = 0; i < lines.size(); ++i) {
      Sight& sight = sights[i] = {};
      sight.depth = extinction_ * lines[i].length();
      sight.low = 0.8 * sight.depth, sight.high = 1.2 * sight.depth;
      const Vec3 step = lines[i].target - lines[i].eye;
      const double share = (20.5 - lines[i].eye[0]) / step[0];
      const double y = lines[i].eye[1] + share * step[1];
      sight.blocked = share > 0 && share < 1 && y > 4;
    }
  }

  void places(std::span<const Vec3> points, std::span<Place> places) const override {
    for (std::size_t i = 0; i < points.size(); ++i) {
      const bool wall = points[i][0] > 20 && points[i][0] < 21 && points[i][1] > 4;
      places[i] =
          !bounds().contains(points[i]) ? Place::kOutside : (wall ? Place::kSolid : Place::kGas);
    }
  }

  void extinction(std::span<const Vec3>, std::span<double> out) const override {
    for (double& value : out) value = extinction_;
  }

 private:
  double extinction_;
};

}  // namespace volute
