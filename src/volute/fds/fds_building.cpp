// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/fds_building.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace volute {
namespace {

constexpr double kFinest = 0.02;     ///< [m] of the raster
constexpr double kIndoors = 0.6;     ///< [m] of gas that end the way through a wall
constexpr double kRoomHeight = 1.5;  ///< [m]
constexpr double kLowRoom = 0.45;    ///< of the meshes' height, where they are low
constexpr double kShellShare = 0.3;
constexpr double kTallWall = 1.8;  ///< [m]
constexpr double kEndOn = 1.2;     ///< deeper than that, of its width, is no wall on that side
constexpr double kThinWall = 0.3;  ///< [m]
constexpr double kEyeLevel = 1.2;  ///< [m]
constexpr std::size_t kInteriorPoints = 400;
constexpr double kBeforeWall = 0.004;  ///< [m] that a vent stands before what it lies on
constexpr double kOfCell = 0.02;       ///< the same in very fine meshes, of a cell

constexpr int kGasCell = -1, kVoidCell = -2, kClosedCell = -3;

/// A flat box with a way round: a quad that is seen from both sides.
FdsQuad quadOf(const Box3& box, int axis, int side, const FdsColour& colour) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  FdsQuad quad{{}, colour};
  for (int corner = 0; corner < 4; ++corner) {
    const int turned = side == 1 ? corner : 3 - corner;
    Vec3& at = quad.corners[static_cast<std::size_t>(corner)];
    at[axis] = side == 1 ? box.max[axis] : box.min[axis];
    at[u] = turned == 1 || turned == 2 ? box.max[u] : box.min[u];
    at[v] = turned >= 2 ? box.max[v] : box.min[v];
  }
  return quad;
}

/// What is left of a box; false: nothing. Bits of `made` say which of its faces cuts made.
bool clip(Box3& box, std::span<const FdsCut> cuts, FdsSides& made) {
  for (const FdsCut& cut : cuts) {
    double& end = cut.above ? box.max[cut.axis] : box.min[cut.axis];
    const double other = cut.above ? box.min[cut.axis] : box.max[cut.axis];
    const bool beyond = cut.above ? end > cut.place : end < cut.place;
    if (!beyond)
      continue;
    if (cut.above ? other >= cut.place : other <= cut.place)
      return false;
    end = cut.place;
    made |= 1U << (2 * cut.axis + (cut.above ? 1 : 0));
  }
  return true;
}

}  // namespace

/// What each part of space holds, with a layer around the meshes.
struct FdsBuilding::Raster {
  Vec3 origin;  // of the first cell
  Vec3 cell;    // [m]
  std::array<int, 3> n{};
  std::vector<std::int32_t> what;  // a box, or kGasCell, kVoidCell, kClosedCell
  std::vector<char> covered;       // something is above

  Raster(const Box3& meshes, int columns) {
    const Vec3 size = meshes.size();
    const double wide = std::max(size.head<2>().maxCoeff() / columns, kFinest);
    cell = Vec3(wide, wide, std::max(size.z() / (0.48 * columns), std::min(wide, 0.1)));
    origin = meshes.min - cell;
    for (int axis = 0; axis < 3; ++axis)
      n[axis] = 2 + std::max(1, static_cast<int>(std::ceil(size[axis] / cell[axis] - 1e-9)));
    what.assign(static_cast<std::size_t>(n[0]) * n[1] * n[2], kVoidCell);
    covered.assign(what.size(), 0);
  }

  std::size_t at(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * n[1] + y) * n[0] + x;
  }

  std::size_t at(const std::array<int, 3>& p) const { return at(p[0], p[1], p[2]); }

  int place(int axis, double where) const {
    return std::clamp(static_cast<int>(std::floor((where - origin[axis]) / cell[axis])), 0,
                      n[axis] - 1);
  }

  /// Cells whose middle is in between; one at least.
  std::array<int, 2> range(int axis, double from, double to) const {
    const double a = (from - origin[axis]) / cell[axis], b = (to - origin[axis]) / cell[axis];
    int begin = static_cast<int>(std::ceil(a - 0.5 - 1e-6));
    int end = static_cast<int>(std::floor(b - 0.5 - 1e-6)) + 1;
    if (begin >= end) {
      begin = static_cast<int>(std::floor(0.5 * (a + b) - 1e-6));
      end = begin + 1;
    }
    begin = std::clamp(begin, 0, n[axis] - 1);
    return {begin, std::clamp(end, begin + 1, n[axis])};
  }

  void fill(const Box3& box, int value) {
    std::array<std::array<int, 2>, 3> r;
    for (int axis = 0; axis < 3; ++axis) r[axis] = range(axis, box.min[axis], box.max[axis]);
    for (int z = r[2][0]; z < r[2][1]; ++z)
      for (int y = r[1][0]; y < r[1][1]; ++y)
        for (int x = r[0][0]; x < r[0][1]; ++x) what[at(x, y, z)] = value;
  }

  bool solid(std::size_t cell) const { return what[cell] >= 0 || what[cell] == kClosedCell; }

  void cover() {
    for (int y = 0; y < n[1]; ++y)
      for (int x = 0; x < n[0]; ++x) {
        bool above = false;
        for (int z = n[2] - 1; z >= 0; --z) {
          covered[at(x, y, z)] = above;
          above |= solid(at(x, y, z));
        }
      }
  }
};

FdsBuilding::FdsBuilding(const SmvIndex& index, double time, int columns) {
  const FdsObstructions obstructions(index, time);
  boxes_.assign(obstructions.boxes().begin(), obstructions.boxes().end());
  shell_.assign(boxes_.size(), 0);
  addVents(index, time);
  findBounds(index);
  Box3 meshes;
  for (const FdsMesh& mesh : index.meshes) meshes.extend(mesh.bounds());
  Raster raster(meshes, columns);
  for (const FdsMesh& mesh : index.meshes) raster.fill(mesh.bounds(), kGasCell);
  for (const Face& face : faces_) {
    if (face.side < 0)
      continue;
    Box3 outside = face.box;  // the cell beyond
    const double step = (face.side % 2 == 0 ? -0.5 : 0.5) * raster.cell[face.axis];
    outside.min[face.axis] = outside.max[face.axis] = face.box.min[face.axis] + step;
    raster.fill(outside, kClosedCell);
  }
  for (std::size_t i = 0; i < boxes_.size(); ++i)
    raster.fill(boxes_[i].bounds, static_cast<int>(i));
  raster.cover();
  findShell(raster);
  findInterior(raster);
}

void FdsBuilding::addVents(const SmvIndex& index, double time) {
  for (const FdsMesh& mesh : index.meshes) {
    for (const FdsVent& vent : mesh.vents) {
      Face face;
      face.box = boxOf(mesh, vent.nodes);
      int flat = 0;
      for (int axis = 0; axis < 3; ++axis) {
        flat += vent.nodes.begin[axis] == vent.nodes.end[axis];
        if (vent.nodes.begin[axis] == vent.nodes.end[axis])
          face.axis = axis;
      }
      if (flat != 1 || !vent.drawn || !isShown(vent.events, time))
        continue;
      face.exterior = vent.exterior;
      const int place = vent.nodes.begin[face.axis];
      if (place == 0)
        face.side = 2 * face.axis;
      else if (place == mesh.cells(face.axis))
        face.side = 2 * face.axis + 1;
      face.colour = vent.colour ? *vent.colour : surfaceColour(index, vent.surface);
      faces_.push_back(face);
    }
  }
}

void FdsBuilding::findBounds(const SmvIndex& index) {
  for (const FdsBox& box : boxes_) bounds_.extend(box.bounds);
  bool walls = false;
  for (const Face& face : faces_) {
    walls |= face.side >= 0 && face.axis != 2;
    if (face.side >= 0 && face.axis != 2)
      bounds_.extend(face.box);
  }
  if (bounds_.empty() || (!walls && bounds_.size().minCoeff() <= 0)) {
    for (const FdsMesh& mesh : index.meshes) bounds_.extend(mesh.bounds());
  }
}

/// Which boxes are part of the outer wall on each side, and of the roof.
void FdsBuilding::findShell(const Raster& raster) {
  const double roomHeight = std::min(kRoomHeight, kLowRoom * raster.cell.z() * (raster.n[2] - 2));
  std::vector<std::array<int, 6>> hits(boxes_.size(), std::array<int, 6>{});
  std::vector<int> pending;
  for (const int side : {0, 1, 2, 3, 5}) {
    const int axis = side / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
    const int needed = std::max(
        1,
        static_cast<int>(std::ceil((axis == 2 ? roomHeight : kIndoors) / raster.cell[axis] - 0.5)));
    for (int j = 0; j < raster.n[v]; ++j) {
      for (int i = 0; i < raster.n[u]; ++i) {
        pending.clear();
        int gas = 0;
        for (int k = 0; k < raster.n[axis]; ++k) {
          std::array<int, 3> place;
          place[axis] = side % 2 == 0 ? k : raster.n[axis] - 1 - k;
          place[u] = i;
          place[v] = j;
          const std::size_t at = raster.at(place);
          const int what = raster.what[at];
          if (raster.solid(at)) {
            gas = 0;
            if (what >= 0 && (pending.empty() || pending.back() != what))
              pending.push_back(what);
          } else if (axis != 2 && !raster.covered[at]) {
            gas = 0;  // it stands alone
            pending.clear();
          } else if ((axis != 2 || raster.covered[at]) && ++gas >= needed) {
            break;
          }
        }
        if (gas < needed)
          continue;
        for (const int box : pending) ++hits[static_cast<std::size_t>(box)][side];
      }
    }
    for (std::size_t b = 0; b < boxes_.size(); ++b) {
      const Box3& box = boxes_[b].bounds;
      const auto ru = raster.range(u, box.min[u], box.max[u]);
      const auto rv = raster.range(v, box.min[v], box.max[v]);
      const double face = static_cast<double>(ru[1] - ru[0]) * (rv[1] - rv[0]);
      if (hits[b][side] < kShellShare * face || hits[b][side] == 0)
        continue;
      const Vec3 size = box.size();
      if (axis == 2 && size.z() >= roomHeight && size.z() > 1.5 * size.head<2>().minCoeff())
        continue;  // a wall that reaches up to the roof
      if (axis != 2 && size[axis] > kEndOn * size[1 - axis])
        continue;  // seen from its end, beside a window or a door
      if (axis != 2 && box.size().z() < std::min(kTallWall, roomHeight * 1.2) &&
          box.size()[axis] > kThinWall) {
        const int z = std::min(raster.range(2, box.min.z(), box.max.z())[1], raster.n[2] - 1);
        const auto rx = raster.range(0, box.min.x(), box.max.x());
        const auto ry = raster.range(1, box.min.y(), box.max.y());
        int under = 0, all = 0;
        for (int y = ry[0]; y < ry[1]; ++y)
          for (int x = rx[0]; x < rx[1]; ++x, ++all) under += raster.solid(raster.at(x, y, z));
        if (2 * under < all)
          continue;  // furniture
      }
      shell_[b] |= 1U << side;
    }
  }
}

void FdsBuilding::findInterior(const Raster& raster) {
  const double roomHeight = std::min(kRoomHeight, kLowRoom * raster.cell.z() * (raster.n[2] - 2));
  const int needed = std::max(1, static_cast<int>(std::ceil(roomHeight / raster.cell.z() - 0.5)));
  const double columns = static_cast<double>(raster.n[0] - 2) * (raster.n[1] - 2);
  const int step = std::max(1, static_cast<int>(std::sqrt(columns / kInteriorPoints)));
  std::map<int, int> stacked;
  int looked = 0;
  for (const bool roofed : {true, false}) {
    for (int y = 1; y < raster.n[1] - 1; y += step) {
      for (int x = 1; x < raster.n[0] - 1; x += step) {
        int rooms = 0, begin = -1;
        for (int z = 0; z < raster.n[2]; ++z) {
          const std::size_t at = raster.at(x, y, z);
          const bool gas = raster.what[at] == kGasCell && (!roofed || raster.covered[at]);
          if (gas && begin < 0)
            begin = z;
          if (gas || begin < 0)
            continue;
          if (z - begin >= needed) {
            ++rooms;
            const double floor = raster.origin.z() + raster.cell.z() * begin;
            const double height = raster.cell.z() * (z - begin);
            interior_.emplace_back(raster.origin.x() + raster.cell.x() * (x + 0.5),
                                   raster.origin.y() + raster.cell.y() * (y + 0.5),
                                   floor + std::min(kEyeLevel, 0.5 * height));
          }
          begin = -1;
        }
        for (int n = 1; n <= rooms; ++n) ++stacked[n];
        looked += rooms > 0;
      }
    }
    if (!interior_.empty())
      break;
  }
  for (const auto& [rooms, count] : stacked) {
    if (10 * count >= looked)
      storeys_ = std::max(storeys_, rooms);
  }
}

FdsSides FdsBuilding::sidesTowards(const Vec3& eye) const {
  FdsSides sides = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (eye[axis] < bounds_.min[axis])
      sides |= 1U << (2 * axis);
    if (eye[axis] > bounds_.max[axis])
      sides |= 2U << (2 * axis);
  }
  return sides;
}

std::vector<FdsBox> FdsBuilding::kept(FdsSides open) const {
  std::vector<FdsBox> boxes;
  for (std::size_t i = 0; i < boxes_.size(); ++i) {
    if (!left(i, open))
      boxes.push_back(boxes_[i]);
  }
  return boxes;
}

std::vector<Vec3> FdsBuilding::vents() const {
  std::vector<Vec3> middles;
  for (const Face& face : faces_) {
    if (!face.exterior)
      middles.push_back(face.box.centre());
  }
  return middles;
}

/// Whether a point lies on an obstruction that is left out.
bool FdsBuilding::touchesLeft(const Vec3& point, FdsSides open) const {
  constexpr double kTouching = 1e-4;  // [m]
  for (std::size_t i = 0; i < boxes_.size(); ++i) {
    const Box3& box = boxes_[i].bounds;
    if (left(i, open) && (point.array() >= box.min.array() - kTouching).all() &&
        (point.array() <= box.max.array() + kTouching).all())
      return true;
  }
  return false;
}

std::vector<FdsQuad> FdsBuilding::quads(FdsSides open, std::span<const FdsCut> cuts) const {
  std::vector<FdsQuad> quads;
  for (std::size_t i = 0; i < boxes_.size(); ++i) {
    FdsBox one = boxes_[i];
    FdsSides made = 0;
    if (!one.drawn || left(i, open) || !clip(one.bounds, cuts, made))
      continue;
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 size = one.bounds.size();
      if (size[(axis + 1) % 3] <= 0 || size[(axis + 2) % 3] <= 0)
        continue;  // the edge of a thin one
      for (int side = 0; side < 2; ++side) {
        if (size[axis] <= 0 && side == 1)
          break;  // both sides look alike
        const int face = 2 * axis + side;
        FdsQuad quad = quadOf(one.bounds, axis, side, one.colours[static_cast<std::size_t>(face)]);
        Vec3 middle = one.bounds.centre();
        middle[axis] = side == 1 ? one.bounds.max[axis] : one.bounds.min[axis];
        quad.cut =
            (made >> face & 1) != 0 || ((open >> face & 1) != 0 && touchesLeft(middle, open));
        quads.push_back(quad);
      }
    }
  }
  for (const Face& one : faces_) {
    Box3 box = one.box;
    FdsSides made = 0;
    if ((one.side >= 0 && (open >> one.side & 1) != 0) || !clip(box, cuts, made))
      continue;
    if (one.exterior || one.side >= 0) {
      const double lift = one.exterior ? 0 : (one.side % 2 == 0 ? kBeforeWall : -kBeforeWall);
      box.min[one.axis] += lift;
      box.max[one.axis] += lift;
      quads.push_back(quadOf(box, one.axis, one.side % 2 == 0 ? 1 : 0, one.colour));
      continue;
    }
    if (touchesLeft(box.centre(), open))
      continue;
    const double lift = std::min(kBeforeWall, kOfCell * box.size().maxCoeff());
    for (int side = 0; side < 2; ++side) {
      Box3 before = box;
      before.min[one.axis] += side == 1 ? lift : -lift;
      before.max[one.axis] = before.min[one.axis];
      quads.push_back(quadOf(before, one.axis, side, one.colour));
    }
  }
  return quads;
}

}  // namespace volute
