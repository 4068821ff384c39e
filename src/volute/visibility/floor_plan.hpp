// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <vector>

#include "volute/media/sight.hpp"

namespace volute {

/// A floor plan: points in the middle of squares, all at one height.
struct FloorPlan {
  Vec3 origin = Vec3::Zero();  ///< the first point [m]; z is the eyes' height
  double step = 0.25;          ///< [m]
  int nx = 0, ny = 0;
  std::vector<Place> places;  ///< shape (y, x), x fastest

  std::size_t size() const { return static_cast<std::size_t>(nx) * ny; }

  Vec3 at(std::size_t i) const {
    const auto x = static_cast<double>(i % static_cast<std::size_t>(nx));
    const auto y = static_cast<double>(i / static_cast<std::size_t>(nx));
    return origin + Vec3(step * x, step * y, 0);
  }

  bool walkable(std::size_t i) const { return places[i] == Place::kGas; }
};

}  // namespace volute
