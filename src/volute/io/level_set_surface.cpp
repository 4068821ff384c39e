// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/level_set_surface.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "volute/grid/brick_table.hpp"
#include "volute/grid/voxel_cells.hpp"

namespace volute {
namespace {

constexpr int kSide = Bricks::kSide;
constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();

Vec3 vecOf(const VoxelIndex& voxel) {
  return {static_cast<double>(voxel[0]), static_cast<double>(voxel[1]),
          static_cast<double>(voxel[2])};
}

VoxelIndex plus(const VoxelIndex& voxel, int x, int y, int z) {
  return {voxel[0] + x, voxel[1] + y, voxel[2] + z};
}

/// Values at the corners of a cell; bits 0, 1, 2 of a corner are its x, y, z.
using Cell = std::array<double, 8>;

double distanceIn(const Cell& cell, const Vec3& at) {
  const auto shares = voxels::cornerShares(at);
  double sum = 0;
  for (std::size_t i = 0; i < 8; ++i) sum += shares[i] * cell[i];
  return sum;
}

/// Of the distance, at a place in the cell's own coordinates.
Vec3 slopeIn(const Cell& cell, const Vec3& at) {
  Vec3 slope;
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 low = at, high = at;
    low[axis] = 0, high[axis] = 1;
    slope[axis] = distanceIn(cell, high) - distanceIn(cell, low);
  }
  return slope;
}

/// A place on the surface in a cell: from the middle of where it crosses the edges, downhill.
Vec3 placeOnSurface(const Cell& cell) {
  constexpr int kSteps = 4;
  Vec3 sum = Vec3::Zero();
  int count = 0;
  for (int corner = 0; corner < 8; ++corner)
    for (int axis = 0; axis < 3; ++axis) {
      const double from = cell[static_cast<std::size_t>(corner)],
                   to = cell[static_cast<std::size_t>(corner | 1 << axis)];
      if ((corner >> axis & 1) != 0 || (from < 0) == (to < 0))
        continue;
      Vec3 at(corner & 1, corner >> 1 & 1, corner >> 2);
      at[axis] = from / (from - to);
      sum += at, ++count;
    }
  Vec3 at = sum / count;
  for (int i = 0; i < kSteps; ++i) {
    const Vec3 slope = slopeIn(cell, at);
    if (!(slope.squaredNorm() > 0))
      break;
    at -= distanceIn(cell, at) / slope.squaredNorm() * slope;
    at = at.cwiseMax(0.0).cwiseMin(1.0);
  }
  return at;
}

/// Where the slope of a cubic is 0, ascending; infinite where it is not.
std::array<double, 2> extremesOf(const Cubic& cubic) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const double a = 3 * cubic.c[3], b = cubic.c[2], c = cubic.c[1];  // a s^2 + 2 b s + c
  const double under = b * b - a * c;
  if (!(under >= 0))
    return {kNever, kNever};
  const double q = -(b + std::copysign(std::sqrt(under), b));
  const double one = a != 0 ? q / a : kNever, other = q != 0 ? c / q : kNever;
  return {std::min(one, other), std::max(one, other)};
}

/// Where a distance within 0 <= s <= end is first on the other side.
std::optional<double> crossingOf(const Cubic& distance, double end, bool inside) {
  const auto crossed = [&](double s) { return (distance(s) < 0) != inside; };
  if (crossed(0))
    return 0;
  double from = 0;
  const std::array<double, 2> extremes = extremesOf(distance);
  for (const double to : {extremes[0], extremes[1], end}) {
    if (!(to > from && to <= end))
      continue;
    if (!crossed(to)) {
      from = to;
      continue;
    }
    double low = from, high = to;
    for (int halving = 0; halving < 52; ++halving) {
      const double middle = 0.5 * (low + high);
      (crossed(middle) ? high : low) = middle;
    }
    return high;
  }
  return std::nullopt;
}

}  // namespace

/// Distances and where among them there is a surface; shared by those that lie elsewhere.
struct LevelSetSurface::Field {
  explicit Field(Bricks distances);

  BrickPlace placeOf(const VoxelIndex& voxel) const {
    BrickPlace place{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      place[axis] = static_cast<int>((voxel[axis] - lowest[axis]) >> 3);
    return place;
  }

  /// A voxel of the leaves, or next to them; NaN where there is none.
  double value(const VoxelIndex& voxel) const {
    const std::int32_t leaf = table.at(placeOf(voxel));
    if (leaf < 0)
      return kNoValue;
    std::size_t in[3];
    for (std::size_t axis = 0; axis < 3; ++axis)
      in[axis] = static_cast<std::size_t>(voxel[axis] - lowest[axis]) % kSide;
    return bricks.values(static_cast<std::size_t>(leaf))[(in[2] * kSide + in[1]) * kSide + in[0]];
  }

  Cell cell(const VoxelIndex& lowest) const {
    Cell cell{};
    for (int corner = 0; corner < 8; ++corner)
      cell[static_cast<std::size_t>(corner)] =
          value(plus(lowest, corner & 1, corner >> 1 & 1, corner >> 2));
    return cell;
  }

  /// Whether a cell without a surface is inside; nothing where it reaches out of the leaves.
  std::optional<bool> sideOf(const VoxelIndex& lowest) const {
    const Cell values = cell(lowest);
    if (!std::ranges::all_of(values, [](double value) { return std::isfinite(value); }))
      return std::nullopt;
    return values[0] < 0;
  }

  bool crosses(std::size_t leaf, const std::array<int, 3>& in) const {
    return (cells[leaf][static_cast<std::size_t>(in[2])] >> (8 * in[1] + in[0]) & 1) != 0;
  }

  static constexpr std::size_t kNoCell = std::numeric_limits<std::size_t>::max();

  /// The number of a cell with a surface, in the order of forCells(); kNoCell: it has none.
  std::size_t numberOf(const VoxelIndex& cell) const {
    const std::int32_t leaf = table.at(placeOf(cell));
    if (leaf < 0)
      return kNoCell;
    const auto at = static_cast<std::size_t>(leaf);
    const VoxelIndex& origin = bricks.leaves()[at].origin;
    const auto z = static_cast<std::size_t>(cell[2] - origin[2]);
    const std::int64_t bit = 8 * (cell[1] - origin[1]) + cell[0] - origin[0];
    if ((cells[at][z] >> bit & 1) == 0)
      return kNoCell;
    std::size_t number = begins[at];
    for (std::size_t i = 0; i < z; ++i)
      number += static_cast<std::size_t>(std::popcount(cells[at][i]));
    return number +
           static_cast<std::size_t>(std::popcount(cells[at][z] & ((std::uint64_t{1} << bit) - 1)));
  }

  /// Calls visit(leaf, place in it) for each cell in which there is a surface.
  template <class Visit>
  void forCells(const Visit& visit) const {
    for (std::size_t leaf = 0; leaf < cells.size(); ++leaf)
      for (std::size_t z = 0; z < kSide; ++z)
        for (std::uint64_t left = cells[leaf][z]; left != 0; left &= left - 1) {
          const int bit = std::countr_zero(left);
          visit(leaf, std::array<int, 3>{bit % kSide, bit / kSide, static_cast<int>(z)});
        }
  }

  Bricks bricks;
  VoxelIndex lowest{};              ///< the first voxel of the lowest leaf on each axis
  BrickTable table;                 ///< numbers of the leaves, by their place
  CellGrid grid;                    ///< the leaves, among voxels
  std::vector<BrickMask> cells;     ///< of each leaf: the cells, by their lowest corners
  std::vector<std::size_t> begins;  ///< of each leaf: how many cells there are before it
  std::size_t count = 0;            ///< of cells
  std::uint64_t triangles = 0;      ///< that addTriangles() makes at most
  Box3 box;                         ///< around those cells
};

namespace {

/// The values of a leaf and of those before it on all axes' upper sides; NaN where there is none.
class LeafCorners {
 public:
  LeafCorners(const Bricks& bricks, const BrickTable& table, BrickPlace place) {
    std::array<std::int32_t, 8> leaves{};
    for (int i = 0; i < 8; ++i)
      leaves[static_cast<std::size_t>(i)] =
          table.at(place[0] + (i & 1), place[1] + (i >> 1 & 1), place[2] + (i >> 2));
    for (int z = 0; z < kCorners; ++z)
      for (int y = 0; y < kCorners; ++y)
        for (int x = 0; x < kCorners; ++x) {
          const int which = (x / kSide) + 2 * (y / kSide) + 4 * (z / kSide);
          const std::int32_t from = leaves[static_cast<std::size_t>(which)];
          values_[index(x, y, z)] =
              from < 0 ? kNoValue
                       : bricks.values(static_cast<std::size_t>(from))[static_cast<std::size_t>(
                             (z % kSide * kSide + y % kSide) * kSide + x % kSide)];
        }
  }

  /// Which corners are inside; 0, too, where one has no value.
  unsigned inside(int x, int y, int z) const {
    unsigned inside = 0;
    for (unsigned corner = 0; corner < 8; ++corner) {
      const double value =
          values_[index(x + static_cast<int>(corner & 1), y + static_cast<int>(corner >> 1 & 1),
                        z + static_cast<int>(corner >> 2))];
      if (!std::isfinite(value))
        return 0;
      inside |= static_cast<unsigned>(value < 0) << corner;
    }
    return inside;
  }

 private:
  static constexpr int kCorners = kSide + 1;  // of the cells of a leaf, along an axis

  static std::size_t index(int x, int y, int z) {
    return static_cast<std::size_t>((z * kCorners + y) * kCorners + x);
  }

  std::array<double, std::size_t{kCorners} * kCorners * kCorners> values_{};
};

}  // namespace

LevelSetSurface::Field::Field(Bricks distances) : bricks(std::move(distances)) {
  const auto leaves = bricks.leaves();
  cells.resize(leaves.size());
  if (leaves.empty())
    return;
  VoxelIndex last = lowest = leaves.front().origin;
  for (const Bricks::Leaf& leaf : leaves) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lowest[axis] = std::min(lowest[axis], leaf.origin[axis]);
      last[axis] = std::max(last[axis], leaf.origin[axis]);
    }
  }
  const BrickPlace top = placeOf(last);
  const BrickPlace count{top[0] + 1, top[1] + 1, top[2] + 1};
  table = BrickTable(count, leaves.size());
  grid = {vecOf(lowest), Vec3::Constant(kSide), count};
  for (std::size_t i = 0; i < leaves.size(); ++i)
    table.set(placeOf(leaves[i].origin), static_cast<std::int32_t>(i));
  for (std::size_t leaf = 0; leaf < leaves.size(); ++leaf) {
    const VoxelIndex& origin = leaves[leaf].origin;
    const LeafCorners corners(bricks, table, placeOf(origin));
    begins.push_back(this->count);
    for (int z = 0; z < kSide; ++z)
      for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
          const unsigned inside = corners.inside(x, y, z);
          if (inside == 0 || inside == 0xff)
            continue;
          ++this->count;
          for (unsigned axis = 0; axis < 3; ++axis)
            triangles += ((inside >> (1u << axis) ^ inside) & 1) != 0 ? 2 : 0;
          cells[leaf][static_cast<std::size_t>(z)] |= std::uint64_t{1} << (8 * y + x);
          const Vec3 at = vecOf(plus(origin, x, y, z));
          box.extend(at), box.extend(at + Vec3::Ones());
        }
  }
}

Result<std::shared_ptr<const LevelSetSurface>> LevelSetSurface::make(
    Bricks distances, const VolumeInfo& info, const std::optional<GridMatrix>& place,
    std::uint64_t maxMemory) {
  const Vec3 voxel = info.voxelSize(), first = info.bounds.min + 0.5 * voxel;
  const Mat3 linear =
      place ? Mat3(linearOf(*place) * voxel.asDiagonal()) : Mat3(voxel.asDiagonal());
  const Vec3 offset = place ? Vec3(linearOf(*place) * first + offsetOf(*place)) : first;
  auto field = std::make_shared<const Field>(std::move(distances));
  if (field->triangles > maxMemory / sizeof(Triangle)) {
    return fail(ErrorCode::kTooLarge, Hint::raise("max_memory"),
                "the surface of '{}' has more triangles than the {} MiB of memory allowed hold",
                info.name, maxMemory >> 20);
  }
  return std::shared_ptr<const LevelSetSurface>(
      new LevelSetSurface(std::move(field), linear, offset));
}

LevelSetSurface::LevelSetSurface(std::shared_ptr<const Field> field, const Mat3& linear,
                                 const Vec3& offset)
    : field_(std::move(field)), linear_(linear), offset_(offset), inverse_(linear.inverse()) {
  constexpr double kRoughness = 0.1;  // of a voxel: cells meet in edges
  roughness_ = kRoughness * linear.columnNorms().minCoeff();
  const Box3& box = field_->box;
  for (int corner = 0; corner < 8 && !box.empty(); ++corner)
    bounds_.extend(linear * box.corner(corner) + offset);
}

std::shared_ptr<const CurvedSurface> LevelSetSurface::moved(const Mat4& transform) const {
  const Mat3 linear = linearPart(transform);
  return std::shared_ptr<const CurvedSurface>(
      new LevelSetSurface(field_, linear * linear_, linear * offset_ + offsetPart(transform)));
}

/// The same parameters mean the same places.
Segment LevelSetSurface::amongVoxels(const Segment& segment) const {
  return {inverse_ * (segment.origin - offset_), inverse_ * segment.direction, segment.begin,
          segment.end};
}

std::optional<double> LevelSetSurface::nearest(const Segment& segment) const {
  const Field& field = *field_;
  if (field.count == 0)
    return std::nullopt;
  const Segment ray = amongVoxels(segment);
  std::optional<double> found;

  // A crossing may be rounded into the next cell: what side the ray was on goes along.
  struct {
    VoxelIndex cell{};
    double end = -std::numeric_limits<double>::infinity();
    std::optional<bool> inside{};  ///< at the end; nothing: that of the cell's corners
  } last;

  const auto look = [&](std::size_t leaf, const CellGrid& cells, const std::array<int, 3>& in,
                        double begin, double end) {
    const VoxelIndex at = plus(field.bricks.leaves()[leaf].origin, in[0], in[1], in[2]);
    const bool crosses = field.crosses(leaf, in);
    std::optional<bool> before;
    if (begin == last.end)
      before = last.inside || !crosses ? last.inside : field.sideOf(last.cell);
    last = {at, end, std::nullopt};
    if (!crosses) {
      if (before && field.sideOf(at).value_or(*before) != *before)
        found = begin;
      return;
    }
    const Cubic distance =
        voxels::cornerCubic(voxels::InCell(cells, in, ray, begin, end), field.cell(at));
    const bool inside = before.value_or(distance(0) < 0);
    if (const auto way = crossingOf(distance, end - begin, inside))
      found = begin + *way;
    last.inside = distance(end - begin) < 0;
  };

  field.table.walk(
      field.grid, ray, [&](const BrickPlace&, std::int32_t number, double begin, double end) {
        const auto leaf = static_cast<std::size_t>(number);
        const CellGrid cells{
            vecOf(field.bricks.leaves()[leaf].origin), Vec3::Ones(), {kSide, kSide, kSide}};
        traverseCells(cells, {{0, 0, 0}, {kSide, kSide, kSide}, true},
                      Segment{ray.origin, ray.direction, begin, end},
                      [&](const std::array<int, 3>& in, double from, double to) {
                        if (!found)
                          look(leaf, cells, in, from, to);
                      });
        return !found;
      });
  if (found && !(*found > segment.begin && *found < segment.end))
    return std::nullopt;
  return found;
}

/// Central differences at the voxels, of one side where there is no value on the other.
Vec3 LevelSetSurface::outward(const Segment& segment, double distance) const {
  const Segment ray = amongVoxels(segment);
  const Vec3 at = ray.at(distance);
  VoxelIndex lowest{};
  Vec3 share;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = std::floor(at[axis]);
    lowest[static_cast<std::size_t>(axis)] = static_cast<std::int64_t>(low);
    share[axis] = at[axis] - low;
  }
  std::array<double, 64> near{};
  for (int i = 0; i < 64; ++i)
    near[static_cast<std::size_t>(i)] =
        field_->value(plus(lowest, i % 4 - 1, i / 4 % 4 - 1, i / 16 - 1));
  Vec3 smooth = Vec3::Zero(), own = Vec3::Zero();
  for (int corner = 0; corner < 8; ++corner) {
    const int side[3] = {corner & 1, corner >> 1 & 1, corner >> 2};
    const int voxel = (side[0] + 1) + 4 * (side[1] + 1) + 16 * (side[2] + 1);
    const double value = near[static_cast<std::size_t>(voxel)];
    if (!std::isfinite(value))
      continue;
    double weights[3];
    for (int axis = 0; axis < 3; ++axis) weights[axis] = side[axis] ? share[axis] : 1 - share[axis];
    for (int axis = 0; axis < 3; ++axis) {
      const int step = 1 << 2 * axis;
      const double below = near[static_cast<std::size_t>(voxel - step)],
                   above = near[static_cast<std::size_t>(voxel + step)];
      const double slope = std::isfinite(above) && std::isfinite(below) ? 0.5 * (above - below)
                           : std::isfinite(above)                       ? above - value
                           : std::isfinite(below)                       ? value - below
                                                                        : 0;
      smooth[axis] += weights[0] * weights[1] * weights[2] * slope;
      own[axis] +=
          weights[(axis + 1) % 3] * weights[(axis + 2) % 3] * (side[axis] ? value : -value);
    }
  }
  const Mat3 toWorld = inverse_.transpose();
  const Vec3 exact = toWorld * own;
  Vec3 normal = toWorld * smooth;
  if (!(normal.norm() > 0))
    normal = exact;
  normal.normalize();
  // What is seen from outside at a grazing angle is not seen from inside.
  constexpr double kGrazing = 1e-6;
  const double sign = exact.dot(segment.direction) > 0 ? 1 : -1;
  const double length = segment.direction.norm();
  if (const double along = normal.dot(segment.direction) / length; !(sign * along >= kGrazing))
    normal = (normal + (sign * kGrazing - along) / length * segment.direction).normalized();
  return normal;
}

/// Dual to the cells (surface nets): one place in each, four of them around each edge that the
/// surface crosses.
void LevelSetSurface::addTriangles(std::uint32_t material, std::vector<Triangle>& to) const {
  const Field& field = *field_;
  std::vector<Vec3> places;
  places.reserve(field.count);
  field.forCells([&](std::size_t leaf, const std::array<int, 3>& in) {
    const VoxelIndex at = plus(field.bricks.leaves()[leaf].origin, in[0], in[1], in[2]);
    places.emplace_back(linear_ * (vecOf(at) + placeOnSurface(field.cell(at))) + offset_);
  });
  const bool mirrored = linear_.determinant() < 0;
  to.reserve(to.size() + field.triangles);
  field.forCells([&](std::size_t leaf, const std::array<int, 3>& in) {
    const VoxelIndex at = plus(field.bricks.leaves()[leaf].origin, in[0], in[1], in[2]);
    const bool inside = field.value(at) < 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      VoxelIndex end = at;
      ++end[axis];
      if ((field.value(end) < 0) == inside)
        continue;
      // Around the edge, anticlockwise as seen from its end.
      std::array<Vec3, 4> around;
      bool whole = true;
      for (std::size_t i = 0; i < 4; ++i) {
        VoxelIndex cell = at;
        cell[(axis + 1) % 3] -= i == 1 || i == 2 ? 1 : 0;
        cell[(axis + 2) % 3] -= i >= 2 ? 1 : 0;
        const std::size_t number = field.numberOf(cell);
        whole = whole && number != Field::kNoCell;
        if (whole)
          around[i] = places[number];
      }
      if (!whole)
        continue;
      if (inside == mirrored)
        std::swap(around[1], around[3]);
      // Along the shorter diagonal.
      if ((around[0] - around[2]).squaredNorm() > (around[1] - around[3]).squaredNorm())
        std::ranges::rotate(around, around.begin() + 1);
      to.push_back({{around[0], around[1], around[2]}, material});
      to.push_back({{around[0], around[2], around[3]}, material});
    }
  });
}

}  // namespace volute
