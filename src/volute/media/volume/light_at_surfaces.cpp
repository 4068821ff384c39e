// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/volume/light_at_surfaces.hpp"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <limits>
#include <utility>

#include "volute/base/parallel.hpp"
#include "volute/media/light_blockers.hpp"

namespace volute {
namespace {

constexpr std::size_t kRaysTogether = 512;

std::pair<BrickPlace, std::size_t> brickOf(const std::array<std::int32_t, 3>& place) {
  constexpr int kSide = BrickSlice::kSide;
  const int x = place[0] + 1, y = place[1] + 1, z = place[2] + 1;
  return {{x / kSide, y / kSide, z / kSide},
          static_cast<std::size_t>((z % kSide * kSide + y % kSide) * kSide + x % kSide)};
}

}  // namespace

/// Cells between voxels' centres in which there is a surface; the first begins one voxel before the
/// volume.
struct LightAtSurfaces::Marks {
  BrickTable bricks;
  std::vector<std::bitset<BrickSlice::kVoxels>> cells{};

  void add(const Place& cell) {
    const auto [brick, in] = brickOf(cell);
    std::int32_t number = bricks.at(brick);
    if (number < 0) {
      number = static_cast<std::int32_t>(cells.size());
      bricks.set(brick, number);
      cells.emplace_back();
    }
    cells[static_cast<std::size_t>(number)].set(in);
  }
};

LightAtSurfaces::LightAtSurfaces(const ShadedVoxels& volume, const AffineMap& place,
                                 TriangleScene surfaces)
    : surfaces_(std::move(surfaces)) {
  const BrickSlice& slice = volume.slice();
  size_ = {slice.x(), slice.y(), slice.z()};
  // Splines reach over two voxels; those for pictures are laid through twice as many values.
  reach_ = slice.basis() == Basis::kCubic || volume.refines() ? 2 : 1;
  const BrickPlace count{slice.bricksX() + 1, slice.bricksY() + 1, slice.bricksZ() + 1};
  Marks marks{BrickTable(count, slice.entries().size())};
  const Vec3 first = volume.centreOf({0, 0, 0});
  const Vec3 voxel = volume.centreOf({1, 1, 1}) - first;
  for (const Triangle& triangle : surfaces_.triangles()) {
    std::array<Vec3, 3> corners;
    for (std::size_t i = 0; i < 3; ++i)
      corners[i] = (place.toOwn(triangle.corners[i]) - first).cwiseQuotient(voxel);
    mark(marks, corners);
  }
  bricks_ = BrickTable(count, slice.entries().size());
  const auto add = [&](const Place& at) {
    const auto [brick, in] = brickOf(at);
    std::int32_t number = bricks_.at(brick);
    if (number >= 0 && numbers_[static_cast<std::size_t>(number)][in] >= 0)
      return;
    const std::int32_t point = volume.lightPointAt(at);
    if (point < 0)
      return;
    if (number < 0) {
      number = static_cast<std::int32_t>(numbers_.size());
      bricks_.set(brick, number);
      numbers_.emplace_back().fill(-1);
    }
    numbers_[static_cast<std::size_t>(number)][in] = static_cast<std::int32_t>(points_.size());
    points_.push_back({point, at});
    positions_.push_back(place.toWorld(volume.centreOf(at)));
  };
  for (int z = -1; z < size_[2]; ++z) {
    for (int y = -1; y < size_[1]; ++y) {
      for (int x = -1; x < size_[0]; ++x) {
        const auto [brick, in] = brickOf({x, y, z});
        const std::int32_t number = marks.bricks.at(brick);
        if (number < 0) {
          x += BrickSlice::kSide - 1 - (x + 1) % BrickSlice::kSide;
          continue;
        }
        if (!marks.cells[static_cast<std::size_t>(number)][in])
          continue;
        for (int i = 1 - reach_; i <= reach_; ++i) {
          for (int j = 1 - reach_; j <= reach_; ++j) {
            for (int k = 1 - reach_; k <= reach_; ++k) {
              const Place at{x + k, y + j, z + i};
              bool inside = true;
              for (std::size_t axis = 0; axis < 3; ++axis)
                inside = inside && at[axis] >= -1 && at[axis] <= size_[axis];
              if (inside)
                add(at);
            }
          }
        }
      }
    }
  }
}

/// In parts that are hardly larger than a cell.
void LightAtSurfaces::mark(Marks& cells, const std::array<Vec3, 3>& corners) const {
  constexpr double kLargest = 1.5, kNear = 1e-3;  // voxels
  const Vec3 low = corners[0].cwiseMin(corners[1]).cwiseMin(corners[2]) - Vec3::Constant(kNear);
  const Vec3 high = corners[0].cwiseMax(corners[1]).cwiseMax(corners[2]) + Vec3::Constant(kNear);
  for (int axis = 0; axis < 3; ++axis) {
    if (!(high[axis] >= -1 && low[axis] < size_[static_cast<std::size_t>(axis)]))
      return;
  }
  if ((high - low).maxCoeff() > kLargest) {
    std::size_t longest = 0;
    double most = -1;
    for (std::size_t i = 0; i < 3; ++i) {
      const double length = (corners[(i + 1) % 3] - corners[i]).squaredNorm();
      if (length > most)
        most = length, longest = i;
    }
    const Vec3 &a = corners[longest], &b = corners[(longest + 1) % 3],
               &c = corners[(longest + 2) % 3];
    const Vec3 middle = 0.5 * (a + b);
    mark(cells, {a, middle, c});
    mark(cells, {middle, b, c});
    return;
  }
  std::array<int, 3> begin, end;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    begin[axis] = std::max(-1, static_cast<int>(std::floor(low[static_cast<int>(axis)])));
    end[axis] =
        std::min(size_[axis] - 1, static_cast<int>(std::floor(high[static_cast<int>(axis)])));
  }
  for (int z = begin[2]; z <= end[2]; ++z) {
    for (int y = begin[1]; y <= end[1]; ++y) {
      for (int x = begin[0]; x <= end[0]; ++x) cells.add({x, y, z});
    }
  }
}

/// In points_; -1: none.
std::int32_t LightAtSurfaces::numberAt(const Place& place) const {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (place[axis] < -1 || place[axis] > size_[axis])
      return -1;
  }
  const auto [brick, in] = brickOf(place);
  const std::int32_t number = bricks_.at(brick);
  return number < 0 ? -1 : numbers_[static_cast<std::size_t>(number)][in];
}

std::vector<LightAtSurfaces::Hidden> LightAtSurfaces::hiddenFrom(const VolumeView& view) const {
  // A point on a surface may be lit from either side: it counts as behind it.
  std::vector<std::uint8_t> blocked(points_.size());
  parallelRanges(points_.size(), kRaysTogether, [&](std::size_t begin, std::size_t end) {
    std::vector<Segment> ways;
    for (std::size_t i = begin; i < end; ++i) {
      const double lift = surfaceLift(positions_[i]);
      if (view.parallel) {
        ways.push_back(
            {positions_[i], -view.at.normalized(), -lift, std::numeric_limits<double>::infinity()});
        continue;
      }
      const Vec3 away = positions_[i] - view.at;
      const double distance = away.norm();
      ways.push_back({view.at, distance > 0 ? Vec3(away / distance) : Vec3::UnitZ(), 0,
                      distance > 0 ? distance + lift : 0});
    }
    surfaces_.occluded(ways, std::span(blocked).subspan(begin, end - begin));
  });
  std::vector<Hidden> hidden(points_.size());
  parallelRanges(points_.size(), 64, [&](std::size_t begin, std::size_t end) {
    std::vector<std::size_t> beside;
    std::vector<Segment> ways;
    std::vector<std::uint8_t> apart;
    for (std::size_t i = begin; i < end; ++i) {
      if (!blocked[i])
        continue;
      Hidden& one = hidden[i];
      const double lift = surfaceLift(positions_[i]);
      one.point = points_[i];
      const Place& at = one.point.place;
      float sum = 0;
      for (int reach = 1; reach <= reach_ && one.seen.empty(); ++reach) {
        beside.clear(), ways.clear();
        for (int z = -reach; z <= reach; ++z) {
          for (int y = -reach; y <= reach; ++y) {
            for (int x = -reach; x <= reach; ++x) {
              if (std::max({std::abs(x), std::abs(y), std::abs(z)}) != reach)
                continue;
              const std::int32_t other = numberAt({at[0] + x, at[1] + y, at[2] + z});
              if (other < 0 || blocked[static_cast<std::size_t>(other)])
                continue;
              beside.push_back(static_cast<std::size_t>(other));
              const Vec3 from = positions_[beside.back()], to = positions_[i] - from;
              ways.push_back({from, to.normalized(), 0, to.norm() + lift});
            }
          }
        }
        apart.assign(ways.size(), 0);
        if (!ways.empty())
          surfaces_.occluded(ways, apart);
        for (std::size_t k = 0; k < ways.size(); ++k) {
          if (!apart[k])
            continue;
          const Point& other = points_[beside[k]];
          float square = 0;
          for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto far = static_cast<float>(other.place[axis] - at[axis]);
            square += far * far;
          }
          one.seen.push_back({other.number, 1 / square});
          sum += 1 / square;
        }
      }
      for (Seen& seen : one.seen) seen.weight /= sum;
    }
  });
  std::erase_if(hidden, [](const Hidden& one) { return one.seen.empty(); });
  return hidden;
}

}  // namespace volute
