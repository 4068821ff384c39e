// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>
#include <vector>

#include "volute/math/vec.hpp"
#include "volute/media/sight.hpp"

namespace volute {

/// The rooms of a plan, and the doors between them.
///
/// Where people could walk is divided at its narrow passages: the distance to the nearest wall has
/// a maximum in each room and a saddle in each passage. Two maxima are of two rooms if the passage
/// is narrower than kDoor and than kNarrowing of the smaller room's width there, or, however wide
/// it is, than kWideNarrowing of that.
struct Rooms {
  static constexpr double kDoor = 2.4;            ///< [m]
  static constexpr double kNarrowing = 0.8;       ///< of the smaller room's width
  static constexpr double kWideNarrowing = 0.35;  ///< the same
  static constexpr double kMinSize = 1.0;         ///< smaller ones are part of a neighbour [m2]

  struct Room {
    double area = 0;       ///< [m2]
    bool outside = false;  ///< an opening of the case's border leads out of it
  };

  struct Door {
    int first = 0, second = 0;  ///< rooms
    Vec2 place = Vec2::Zero();
    double width = 0;   ///< [m]; as wide as the points tell
    bool shut = false;  ///< something opaque stands there at some time
  };

  std::vector<Room> rooms;  ///< in the order of a plan that is read from its upper left
  std::vector<Door> doors;

  /// The room of a point, or of the nearest one within `reach` [m]; -1: none.
  int at(const Vec2& point, double reach) const;

  // Squares at half the spacing of the points, shape (y, x).
  Vec2 origin = Vec2::Zero();
  double spacing = 0;  ///< of the squares [m]
  int nx = 0, ny = 0;
  std::vector<int> labels;  ///< -1: a wall, or no room
};

/// Of all places that can be seen from at a height, with doors shut that are so at any time.
Rooms findRooms(const SightSnapshot& first, const Box3& bounds, double height);

}  // namespace volute
