// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "volute/fds/obstructions.hpp"

namespace volute {

/// A plane that cuts a building open.
struct FdsCut {
  int axis = 2;       ///< across it: 0 x, 1 y, 2 z
  double place = 0;   ///< along the axis [m]
  bool above = true;  ///< what is above is left out, else what is below

  bool operator==(const FdsCut&) const = default;
};

/// Sides of a box, a bit each: 1 -x, 2 +x, 4 -y, 8 +y, 16 -z, 32 +z.
using FdsSides = unsigned;

/// A building at one time as somebody draws it: obstructions, vents, and the meshes' own walls
/// where the case closes them. It can be opened like a doll's house: the outer wall on a side, and
/// the roof, are left out. Cheap to copy.
///
/// What is outer is found on a raster of 200 columns along the longer side of the meshes. Gas under
/// an obstruction, or under a closed top of the meshes, is indoors. On the way into the meshes from
/// a side all that is solid before the first 0.6 m indoors belongs to that side's wall; from above
/// all that is solid before the first 1.5 m of gas (less in low models) is the roof. An obstruction
/// is left out as a whole, where at least 0.3 of its face on that side is such; of walls those that
/// stand up to a ceiling, are 1.8 m high or at most 0.3 m thick, so that furniture at a wall stays.
class FdsBuilding {
 public:
  static constexpr int kUsualColumns = 200;

  /// @param columns  of the raster; its layers are at most 0.48 times as many
  FdsBuilding(const SmvIndex& index, double time, int columns = kUsualColumns);

  /// Around obstructions and closed walls of the meshes; around all meshes where there are none.
  const Box3& bounds() const { return bounds_; }

  /// The sides of bounds() that a point is beyond.
  FdsSides sidesTowards(const Vec3& eye) const;

  /// The obstructions that stay where sides are open.
  std::vector<FdsBox> kept(FdsSides open) const;

  /// Faces to draw. Vents that lie on an obstruction stand a little before it.
  /// @param open  whose walls are left out
  /// @param cuts  leave out more; faces that they make are FdsQuad::cut
  std::vector<FdsQuad> quads(FdsSides open = 0, std::span<const FdsCut> cuts = {}) const;

  /// Places at about a person's height in what is indoors, some hundreds; of a building without a
  /// roof all gas above a floor.
  std::span<const Vec3> interior() const { return interior_; }

  /// Middles of what burns or blows: vents that the case draws, the meshes' own walls apart.
  std::vector<Vec3> vents() const;

  /// How many rooms are above each other, in a tenth of the plan at least; at least 1.
  int storeys() const { return storeys_; }

 private:
  struct Face {
    Box3 box;  // flat
    FdsColour colour{};
    int axis = 0;
    int side = -1;          // 0..5 of the mesh that it closes; else -1
    bool exterior = false;  // a wall of the mesh itself
  };
  struct Raster;

  void addVents(const SmvIndex& index, double time);
  void findBounds(const SmvIndex& index);
  void findShell(const Raster& raster);
  void findInterior(const Raster& raster);

  bool left(std::size_t box, FdsSides open) const { return (shell_[box] & open) != 0; }

  bool touchesLeft(const Vec3& point, FdsSides open) const;

  std::vector<FdsBox> boxes_;
  std::vector<FdsSides> shell_;  // of each box: sides whose wall it is part of
  std::vector<Face> faces_;
  Box3 bounds_;
  std::vector<Vec3> interior_;
  int storeys_ = 1;
};

}  // namespace volute
