// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/shaded_voxels.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <mutex>
#include <optional>

#include "volute/base/assert.hpp"
#include "volute/base/parallel.hpp"
#include "volute/grid/refined_spline.hpp"
#include "volute/grid/voxel_cells.hpp"
#include "volute/grid/voxel_march.hpp"
#include "volute/medium/integrate.hpp"

namespace volute {
namespace {

constexpr int kShadedSide = CornerSet::kSide;
constexpr float kMaxOfMeans = 1.5F;  // of the light itself
constexpr int kShadedCorners = CornerSet::kCorners;

/// The first channel alone, of what is unshared.
std::shared_ptr<const BrickSlice> firstChannel(const std::shared_ptr<const BrickSlice>& whole) {
  const BrickSlice& slice = *whole;
  if (slice.channels() == 1)
    return whole;
  VolumeInfo info;
  info.x = slice.x(), info.y = slice.y(), info.z = slice.z();
  info.bounds = slice.bounds();
  info.basis = slice.basis();
  std::vector<BrickPlace> places;
  for (const BrickSlice::Entry& entry : slice.entries()) places.push_back(entry.place);
  auto out = std::make_shared<BrickSlice>(info, places);
  for (const BrickSlice::Entry& entry : slice.entries())
    std::copy_n(slice.brick(entry.stored), BrickSlice::kVoxels, out->brick(entry.stored));
  out->dropEmpty();
  return out;
}

/// Light is another in each place.
std::shared_ptr<const BrickSlice> unshared(std::shared_ptr<const BrickSlice> slice) {
  if (slice->entries().size() == slice->storedBricks())
    return slice;
  return std::make_shared<const BrickSlice>(slice->unshared());
}

/// How many steps keep the optical depth of each at 1.3 on the longest way through a cell.
int stepsOf(const BrickSlice& slice, const CellGrid& cells) {
  constexpr double kMaxDepth = 1.3, kMaxSteps = 64;
  double largest = 0;
  for (std::size_t b = 0; b < slice.storedBricks(); ++b) {
    const float* brick = slice.brick(static_cast<std::int32_t>(b));
    largest = std::max<double>(largest, *std::max_element(brick, brick + BrickSlice::kVoxels));
  }
  const double steps = std::ceil(largest * cells.cell.norm() / kMaxDepth);
  return static_cast<int>(steps < kMaxSteps ? std::max(steps, 1.0) : kMaxSteps);
}

std::shared_ptr<const MarchGrid> layoutOf(const std::shared_ptr<const BrickSlice>& slice,
                                          const CellGrid& cells,
                                          const BrickTable* without = nullptr) {
  auto march = layMarchGrid(slice, cells, without);
  march->shaded = true;
  march->emissionChannel = slice->channels() == 4 ? 1 : -1;
  march->steps = stepsOf(*slice, cells);
  march->lightLost = 1e-4F;
  return march;
}

/// 1 where a corner, or one beside it along any axes, is not 0; of the corners of one brick.
void markNeeded(const float* values, std::array<std::uint8_t, kShadedCorners>& marks) {
  for (int i = 0; i < kShadedCorners; ++i) marks[static_cast<std::size_t>(i)] = values[i] != 0;
  for (const int stride : {1, kShadedSide, kShadedSide * kShadedSide}) {
    const auto before = marks;
    const int most = kShadedSide - 1;
    for (int line = 0; line < kShadedCorners; line += kShadedSide * stride) {
      for (int i = line; i < line + most * stride; ++i) {
        marks[static_cast<std::size_t>(i)] |= before[static_cast<std::size_t>(i + stride)];
        marks[static_cast<std::size_t>(i + stride)] |= before[static_cast<std::size_t>(i)];
      }
    }
  }
}

/// Whether all of it is the brightest, made darker.
bool isOneColor(std::span<const VoxelLight> light, const Rgb& largest) {
  constexpr double kSame = 1e-6;
  const double brightest = largest.maxCoeff();
  const Rgb color = largest / brightest;
  return std::ranges::all_of(light, [&](const VoxelLight& voxel) {
    const Rgb one = voxel.cast<double>();
    const double share = (one * color).sum() / color.square().sum();
    return ((one - share * color).abs() <= kSame * brightest).all();
  });
}

Polynomial product(const Cubic& a, const Cubic& b) {
  Polynomial out;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < 4; ++j) out.c[i + j] += a.c[i] * b.c[j];
  }
  return out;
}

}  // namespace

struct ShadedVoxels::Counters {
  std::atomic<std::uint64_t> voxels{0};
  std::atomic<std::uint64_t> bricksVisited{0};
  std::atomic<std::uint64_t> bricksSkipped{0};
};

/// What a march without light reads, made when it is first asked for, maybe by one of many that
/// march: fans of rays find their light without it.
class ShadedVoxels::Values {
 public:
  Values(std::shared_ptr<const BrickSlice> slice, std::shared_ptr<const MarchGrid> layout)
      : slice_(std::move(slice)), layout_(std::move(layout)) {}

  Box3 bounds() const { return voxels::cellsOf(*slice_).bounds(); }

  const std::shared_ptr<const MarchGrid>& march() const {
    std::call_once(marched_, [&] { isolated([&] { march_ = filled(*layout_); }); });
    return march_;
  }

  const VoxelMedium& absorption() const {
    std::call_once(absorbs_, [&] {
      if (layout_ && slice_->channels() == 1 && slice_->entries().size() == slice_->storedBricks())
        absorption_.emplace(march(), 0, 1);
      else
        isolated([&] { absorption_.emplace(firstChannel(slice_), 0, 1); });
    });
    return *absorption_;
  }

 private:
  std::shared_ptr<const BrickSlice> slice_;
  std::shared_ptr<const MarchGrid> layout_;  ///< null: cubic
  mutable std::once_flag marched_, absorbs_;
  mutable std::shared_ptr<const MarchGrid> march_;
  mutable std::optional<VoxelMedium> absorption_;
};

constexpr int kTileSide = 4;  // cells
constexpr int kTilesOfBrick = BrickSlice::kSide / kTileSide;

/// Cubes of cells in which the extinction is the same everywhere, and so it is in their bricks.
struct ShadedVoxels::Tiles {
  BrickTable bricks;  ///< of cells, that are tiles
  BrickTable table;   ///< the number of each tile
  std::vector<BrickPlace> places;
  std::vector<float> extinction;
  std::vector<std::array<std::int32_t, 8>> points;  ///< which of the places their corners are
  BrickTable corners;                               ///< the same of each corner, in tiles
  std::size_t firstPoint = 0;                       ///< those before are of other cells, too
};

ShadedVoxels::ShadedVoxels(std::shared_ptr<const BrickSlice> slice)
    : ShadedVoxels(unshared(std::move(slice)), nullptr) {}

ShadedVoxels ShadedVoxels::withTiles(std::shared_ptr<const BrickSlice> slice, std::size_t many) {
  auto tiles = slice->channels() == 1 && slice->basis() == Basis::kTrilinear &&
                       slice->entries().size() >= many
                   ? findTiles(*slice)
                   : nullptr;
  if (!tiles || tiles->places.size() < many * kTilesOfBrick * kTilesOfBrick * kTilesOfBrick)
    return ShadedVoxels(std::move(slice));
  ShadedVoxels made(std::move(slice), &tiles->bricks);
  auto corners = std::make_shared<Corners>(*made.corners_);
  made.addCorners(*tiles, *corners);
  made.corners_ = std::move(corners);
  made.tiles_ = std::move(tiles);
  return made;
}

ShadedVoxels::ShadedVoxels(std::shared_ptr<const BrickSlice> whole, const BrickTable* without)
    : slice_(std::move(whole)),
      cells_(voxels::cellsOf(*slice_)),
      occupied_(voxels::occupiedCells(*slice_, cells_)),
      counters_(std::make_shared<Counters>()) {
  VOLUTE_ASSERT(slice_->basis() != Basis::kBox);
  VOLUTE_ASSERT(slice_->channels() == 1 || slice_->channels() == 4);
  if (slice_->basis() == Basis::kCubic) {
    if (slice_->channels() == 4)
      cubic_ = std::make_shared<const CubicVoxels>(slice_, 1, 1);
    corners_ = findCentres(*slice_);
  } else {
    layout_ = layoutOf(slice_, cells_, without);
    corners_ = findCorners(*layout_);
  }
  values_ = std::make_shared<const Values>(slice_, layout_);
}

Box3 ShadedVoxels::bounds() const {
  return values_->bounds();
}

const VoxelMedium& ShadedVoxels::absorption() const {
  return values_->absorption();
}

std::shared_ptr<const MarchGrid> ShadedVoxels::marched() const {
  return lit_ ? lit_ : values_->march();
}

ShadedVoxels ShadedVoxels::refining(std::shared_ptr<const BrickSlice> spline) {
  spline = unshared(std::move(spline));
  ShadedVoxels made(std::make_shared<const BrickSlice>(smoothedSpline(*spline)));
  made.splines_ = std::move(spline);
  return made;
}

ShadedVoxels ShadedVoxels::drawn() const {
  return splines_ ? drawnFrom(*splines_) : *this;
}

std::uint64_t ShadedVoxels::drawnBytes() const {
  return splines_ ? refinedSplineBytes(*splines_) : 0;
}

ShadedVoxels ShadedVoxels::drawnFrom(const BrickSlice& splines) const {
  ShadedVoxels made = *this;  // with its extinction, which the means of rays are the same for
  made.slice_ = std::make_shared<const BrickSlice>(refinedSpline(splines));
  made.splines_ = nullptr;
  made.cells_ = voxels::cellsOf(*made.slice_);
  made.occupied_ = voxels::occupiedCells(*made.slice_, made.cells_);
  made.layout_ = layoutOf(made.slice_, made.cells_);
  static const auto kNone = std::make_shared<const Corners>();
  made.corners_ = kNone;
  made.light_ = nullptr;
  const auto values = std::make_shared<const Values>(made.slice_, made.layout_);
  if (made.slice_->channels() == 1)
    made.values_ = values;
  else
    made.lit_ = values->march();
  made.counters_ = std::make_shared<Counters>();
  return made;
}

Vec3 ShadedVoxels::centreOf(const std::array<std::int32_t, 3>& place) const {
  const Vec3 size(slice_->x(), slice_->y(), slice_->z());
  const Vec3 shares =
      (Vec3(place[0], place[1], place[2]) + Vec3::Constant(0.5)).cwiseQuotient(size);
  return slice_->bounds().min + slice_->bounds().size().cwiseProduct(shares);
}

VoxelPlaces ShadedVoxels::lightPlaces() const {
  if (corners_->ofBrick.empty())
    return corners_->places;
  return {corners_->ofBrick, layout_->bricks, corners_->places};
}

std::vector<Vec3> ShadedVoxels::lightPoints() const {
  std::vector<Vec3> points;
  const VoxelPlaces places = lightPlaces();
  points.reserve(places.size());
  VoxelPlaces::Reader at(places);
  for (std::size_t i = 0; i < places.size(); ++i) points.push_back(centreOf(at[i]));
  return points;
}

std::int32_t ShadedVoxels::lightPointAt(const std::array<std::int32_t, 3>& voxel) const {
  if (layout_)
    return pointAt(voxel);
  const auto [x, y, z] = voxel;
  const bool stored =
      x >= 0 && y >= 0 && z >= 0 && x < slice_->x() && y < slice_->y() && z < slice_->z() &&
      slice_->brickAt(x / BrickSlice::kSide, y / BrickSlice::kSide, z / BrickSlice::kSide) >= 0;
  return stored ? corners_->ofVoxel[slice_->placeOf(x, y, z)] : -1;
}

std::shared_ptr<ShadedVoxels::Tiles> ShadedVoxels::findTiles(const BrickSlice& slice) {
  auto tiles = std::make_shared<Tiles>();
  const BrickPlace count{slice.bricksX() + 1, slice.bricksY() + 1, slice.bricksZ() + 1};
  tiles->bricks = BrickTable(count, slice.entries().size());
  constexpr int kMany = kTilesOfBrick * kTilesOfBrick * kTilesOfBrick;
  tiles->table =
      BrickTable({kTilesOfBrick * count[0], kTilesOfBrick * count[1], kTilesOfBrick * count[2]},
                 kMany * slice.entries().size());
  for (const BrickSlice::Entry& entry : slice.entries()) {
    if (entry.stored < slice.firstUniform())
      continue;
    // Cells begin one voxel before a brick; light changes most just below the surface.
    bool alone = true;
    for (int i = 1; i < 8 && alone; ++i) {
      for (const int way : {-1, 1}) {
        alone = alone &&
                slice.brickAt(entry.place[0] + way * (i & 1), entry.place[1] + way * (i >> 1 & 1),
                              entry.place[2] + way * (i >> 2)) == entry.stored;
      }
    }
    if (!alone)
      continue;
    tiles->bricks.set(entry.place, 0);
    for (int i = 0; i < kMany; ++i) {
      const BrickPlace place{kTilesOfBrick * entry.place[0] + i % kTilesOfBrick,
                             kTilesOfBrick * entry.place[1] + i / kTilesOfBrick % kTilesOfBrick,
                             kTilesOfBrick * entry.place[2] + i / kTilesOfBrick / kTilesOfBrick};
      tiles->table.set(place, static_cast<std::int32_t>(tiles->places.size()));
      tiles->places.push_back(place);
      tiles->extinction.push_back(*slice.brick(entry.stored));
    }
  }
  return tiles;
}

void ShadedVoxels::addCorners(Tiles& tiles, Corners& corners) const {
  const BrickPlace& count = tiles.table.count();
  tiles.corners = BrickTable({count[0] + 1, count[1] + 1, count[2] + 1}, tiles.places.size());
  tiles.firstPoint = lightPlaces().size();
  for (const BrickPlace& tile : tiles.places) {
    auto& points = tiles.points.emplace_back();
    for (int i = 0; i < 8; ++i) {
      const BrickPlace corner{tile[0] + (i & 1), tile[1] + (i >> 1 & 1), tile[2] + (i >> 2)};
      std::int32_t point = tiles.corners.at(corner);
      if (point < 0) {
        const std::array<std::int32_t, 3> voxel{
            kTileSide * corner[0] - 1, kTileSide * corner[1] - 1, kTileSide * corner[2] - 1};
        point = pointAt(voxel);
        if (point < 0) {
          point = static_cast<std::int32_t>(tiles.firstPoint + corners.places.size());
          corners.places.push_back(voxel);
        }
        tiles.corners.set(corner, point);
      }
      points[static_cast<std::size_t>(i)] = point;
    }
  }
}

namespace {

/// Calls visit(brick before, its corner) for each brick before, on any axes, that shares a corner,
/// until it returns true.
template <class Visit>
bool forBricksBefore(const MarchGrid& grid, const BrickPlace& brick, int corner, Visit&& visit) {
  const int place[3] = {corner % kShadedSide, corner / kShadedSide % kShadedSide,
                        corner / kShadedSide / kShadedSide};
  for (int way = 1; way < 8; ++way) {
    BrickPlace other = brick;
    int there = corner;
    bool shared = true;
    for (std::size_t axis = 0, stride = 1; axis < 3; ++axis, stride *= kShadedSide) {
      if (!(way >> axis & 1))
        continue;
      shared = shared && place[axis] == 0;
      --other[axis];
      there += BrickSlice::kSide * static_cast<int>(stride);
    }
    const std::int32_t before = shared ? grid.table.at(other) : BrickTable::kEmpty;
    if (before >= 0 && visit(static_cast<std::size_t>(before), there))
      return true;
  }
  return false;
}

bool isAtFace(int corner) {
  return corner % kShadedSide == 0 || corner / kShadedSide % kShadedSide == 0 ||
         corner < kShadedSide * kShadedSide;
}

}  // namespace

std::int32_t ShadedVoxels::Corners::pointAt(const MarchGrid& grid, std::size_t brick,
                                            int corner) const {
  const BrickCorners& marks = ofBrick[brick];
  if (!marks.needed.has(corner))
    return -1;
  if (marks.own.has(corner))
    return static_cast<std::int32_t>(marks.first) + marks.own.before(corner);
  std::int32_t point = -1;
  forBricksBefore(grid, grid.bricks[brick].place, corner, [&](std::size_t before, int there) {
    point = pointAt(grid, before, there);
    return point >= 0;
  });
  return point;
}

std::array<std::int32_t, CornerSet::kCorners> ShadedVoxels::Corners::pointsOf(
    const MarchGrid& grid, std::size_t brick) const {
  std::array<std::int32_t, CornerSet::kCorners> points;
  points.fill(-1);
  const BrickCorners& marks = ofBrick[brick];
  auto next = static_cast<std::int32_t>(marks.first);
  marks.own.each([&](int corner) { points[static_cast<std::size_t>(corner)] = next++; });
  marks.needed.each([&](int corner) {
    if (std::int32_t& point = points[static_cast<std::size_t>(corner)]; point < 0)
      point = pointAt(grid, brick, corner);
  });
  return points;
}

std::shared_ptr<ShadedVoxels::Corners> ShadedVoxels::findCorners(const MarchGrid& grid) {
  auto corners = std::make_shared<Corners>();
  std::vector<BrickCorners>& marks = corners->ofBrick;
  marks.resize(grid.bricks.size());
  parallelRanges(marks.size(), 16, [&](std::size_t begin, std::size_t end) {
    std::vector<float> values(static_cast<std::size_t>(grid.brickStride));
    std::array<std::uint8_t, kShadedCorners> needed;
    for (std::size_t b = begin; b < end; ++b) {
      copyCorners(*grid.slice, grid.bricks[b].place, values.data());
      markNeeded(values.data(), needed);
      for (int i = 0; i < kShadedCorners; ++i) {
        if (needed[static_cast<std::size_t>(i)])
          marks[b].needed.add(i);
      }
    }
  });
  parallelRanges(marks.size(), 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      marks[b].needed.each([&](int i) {
        const auto has = [&](std::size_t before, int there) {
          return marks[before].needed.has(there);
        };
        if (!isAtFace(i) || !forBricksBefore(grid, grid.bricks[b].place, i, has))
          marks[b].own.add(i);
      });
    }
  });
  std::size_t points = 0;
  for (BrickCorners& brick : marks) {
    brick.first = static_cast<std::uint32_t>(points);
    points += static_cast<std::size_t>(brick.own.before(kShadedCorners));
  }
  VOLUTE_ASSERT(points <= std::numeric_limits<std::int32_t>::max());
  return corners;
}

std::shared_ptr<const ShadedVoxels::Corners> ShadedVoxels::findCentres(const BrickSlice& slice) {
  auto centres = std::make_shared<Corners>();
  centres->ofVoxel.assign(slice.storedBricks() * BrickSlice::kVoxels, -1);
  for (const BrickSlice::Entry& entry : slice.entries()) {
    const float* values = slice.brick(entry.stored);
    for (int i = 0; i < BrickSlice::kVoxels; ++i) {
      if (!(values[i] > 0))
        continue;
      const int x = entry.place[0] * BrickSlice::kSide + i % BrickSlice::kSide,
                y = entry.place[1] * BrickSlice::kSide + i / BrickSlice::kSide % BrickSlice::kSide,
                z = entry.place[2] * BrickSlice::kSide + i / BrickSlice::kSide / BrickSlice::kSide;
      centres->ofVoxel[slice.placeOf(x, y, z)] = static_cast<std::int32_t>(centres->places.size());
      centres->places.push_back({x, y, z});
    }
  }
  return centres;
}

std::int32_t ShadedVoxels::pointAt(const std::array<std::int32_t, 3>& voxel) const {
  const std::array<std::int32_t, 3> place{voxel[0] + 1, voxel[1] + 1, voxel[2] + 1};  // in cells
  // Most are inside of a brick.
  if (place[0] >= 0 && place[1] >= 0 && place[2] >= 0 && place[0] <= cells_.count[0] &&
      place[1] <= cells_.count[1] && place[2] <= cells_.count[2]) {
    const int x = place[0] / BrickSlice::kSide, y = place[1] / BrickSlice::kSide,
              z = place[2] / BrickSlice::kSide;
    const std::int32_t brick = layout_->table.at(x, y, z);
    if (brick >= 0) {
      const int corner =
          ((place[2] % BrickSlice::kSide) * kShadedSide + place[1] % BrickSlice::kSide) *
              kShadedSide +
          place[0] % BrickSlice::kSide;
      const std::int32_t point =
          corners_->pointAt(*layout_, static_cast<std::size_t>(brick), corner);
      if (point >= 0)
        return point;
    }
  }
  // A corner that bricks share is at 0 in one of them, and at 8 in those before.
  for (int way = 0; way < 8; ++way) {
    BrickPlace brickOf{};
    int corner = 0;
    bool possible = true;
    for (std::size_t axis = 0, stride = 1; axis < 3; ++axis, stride *= kShadedSide) {
      const std::int32_t at = place[axis];
      int brick = at / BrickSlice::kSide, in = at % BrickSlice::kSide;
      if (way >> axis & 1) {
        possible = possible && in == 0;
        --brick, in = BrickSlice::kSide;
      }
      possible = possible && at >= 0 && at <= cells_.count[axis];
      brickOf[axis] = brick;
      corner += in * static_cast<int>(stride);
    }
    const std::int32_t number = possible ? layout_->table.at(brickOf) : BrickTable::kEmpty;
    if (number < 0)
      continue;
    const std::int32_t point =
        corners_->pointAt(*layout_, static_cast<std::size_t>(number), corner);
    if (point >= 0)
      return point;
  }
  return -1;
}

std::vector<VoxelLight> ShadedVoxels::forMeans(std::span<const VoxelLight> light,
                                               const Vec3& edges) const {
  if (!layout_ || splines_)
    return {light.begin(), light.end()};
  std::vector<VoxelLight> out(light.size());
  eachMean(light, edges, [&](std::size_t i, const VoxelLight& mean) { out[i] = mean; });
  return out;
}

ShadedVoxels ShadedVoxels::withMeansOf(std::vector<VoxelLight> light, const Vec3& edges) const {
  if (!layout_ || splines_)
    return withLight(std::move(light));
  VoxelLight most = VoxelLight::Zero();
  for (const VoxelLight& one : light) most = most.max(one);
  if (!(most.maxCoeff() > 0))
    return withLight(std::move(light));
  auto packed = std::make_shared<PackedLight>(kMaxOfMeans * most,
                                              isOneColor(light, most.cast<double>()), light.size());
  eachMean(light, edges, [&](std::size_t i, const VoxelLight& mean) { packed->set(i, mean); });
  light = std::vector<VoxelLight>();  // {} would keep its memory
  return withPacked(std::move(packed));
}

/// Linear in between, half of the optical depth by which a neighbour is darker than its own smoke
/// explains is the light halfway to it. At an edge of the smoke neighbours are those across it.
VoxelLight ShadedVoxels::atRim(const std::array<std::int32_t, 3>& place, std::size_t point,
                               std::span<const VoxelLight> light, const Vec3& edges) const {
  // From here on light is too little to tell by which smoke it was taken.
  constexpr float kDark = 20;
  const VoxelLight& own = light[point];
  VoxelLight sum = VoxelLight::Zero();
  float weight = 0;
  const auto add = [&](int axes) {  // along so many of them
    for (int n = 0; n < 27; ++n) {
      const std::array<std::int32_t, 3> way{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
      if (std::abs(way[0]) + std::abs(way[1]) + std::abs(way[2]) != axes)
        continue;
      const std::array beside{place[0] + way[0], place[1] + way[1], place[2] + way[2]};
      const float extinction = slice_->value(beside[0], beside[1], beside[2]);
      const std::int32_t other = extinction > 0 ? pointAt(beside) : -1;
      if (other < 0)
        continue;
      const double length = edges.cwiseProduct(Vec3(way[0], way[1], way[2])).norm();
      const auto ramp = static_cast<float>(0.5 * extinction * length);
      const VoxelLight& its = light[static_cast<std::size_t>(other)];
      weight += extinction;
      for (int c = 0; c < 3; ++c) {
        if (!(own[c] > 0))
          continue;
        const float depth = own[c] > std::exp(kDark) * its[c] ? kDark : std::log(own[c] / its[c]);
        const float shadow = std::exp(-0.5F * std::max(depth - ramp, 0.0F));
        sum[c] += extinction * (2 - shadow) * shadow * own[c];
      }
    }
  };
  for (int axes = 1; axes <= 3 && !(weight > 0); ++axes) add(axes);
  return weight > 0 ? VoxelLight(sum / weight) : own;
}

template <class Put>
void ShadedVoxels::eachMean(std::span<const VoxelLight> light, const Vec3& edges, Put&& put) const {
  if (tiles_)
    eachMeanOfTiles(light, put);
  // By the brick that has a point first; its neighbours are mostly there.
  parallelRanges(corners_->ofBrick.size(), 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      const auto points = corners_->pointsOf(*layout_, b);
      corners_->ofBrick[b].own.each([&](int corner) {
        const auto i = static_cast<std::size_t>(points[static_cast<std::size_t>(corner)]);
        const auto place = VoxelPlaces::cornerOf(layout_->bricks[b].place, corner);
        if (!tiles_ && slice_->value(place[0], place[1], place[2]) == 0)
          return put(i, atRim(place, i, light, edges));
        VoxelLight differences = VoxelLight::Zero();
        for (std::size_t axis = 0, stride = 1; axis < 3; ++axis, stride *= kShadedSide) {
          const auto step = static_cast<int>(stride);
          const int at = corner / step % kShadedSide;
          const auto neighbour = [&](int way) {
            if (at + way >= 0 && at + way < kShadedSide)
              return points[static_cast<std::size_t>(corner + way * step)];
            auto beside = place;
            beside[axis] += way;
            return pointAt(beside);
          };
          const std::int32_t before = neighbour(-1), after = neighbour(1);
          if (before >= 0 && after >= 0)
            differences += light[static_cast<std::size_t>(before)] +
                           light[static_cast<std::size_t>(after)] - 2 * light[i];
        }
        put(i, (light[i] - differences / 12).max(0.5F * light[i]).min(kMaxOfMeans * light[i]));
      });
    }
  });
}

template <class Put>
void ShadedVoxels::eachMeanOfTiles(std::span<const VoxelLight> light, Put&& put) const {
  for (std::size_t i = tiles_->firstPoint; i < light.size(); ++i) {
    const auto& place = corners_->places[i - tiles_->firstPoint];
    VoxelLight differences = VoxelLight::Zero();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto neighbour = [&](int way) {
        auto voxel = place;
        voxel[axis] += way * kTileSide;
        BrickPlace corner;
        for (std::size_t a = 0; a < 3; ++a) corner[a] = (voxel[a] + 1) / kTileSide;
        const std::int32_t point = tiles_->corners.at(corner);
        return point >= 0 ? point : pointAt(voxel);
      };
      const std::int32_t before = neighbour(-1), after = neighbour(1);
      if (before >= 0 && after >= 0)
        differences += light[static_cast<std::size_t>(before)] +
                       light[static_cast<std::size_t>(after)] - 2 * light[i];
    }
    put(i, (light[i] - differences / 12).max(0.5F * light[i]).min(kMaxOfMeans * light[i]));
  }
}

/// Between voxels the spline of products K_i L_i is K L plus a sixth of its second derivative, and
/// the spline of K is K plus a sixth of its own: what is asked for, the product of the latter with
/// L, has coefficients K_i L_i - sum over neighbours n of K_n (L_n - L_i) / 6.
BrickSlice ShadedVoxels::litSplines(const BrickSlice& splines,
                                    std::span<const VoxelLight> light) const {
  constexpr int kSide = BrickSlice::kSide, kVoxels = BrickSlice::kVoxels;
  VolumeInfo info;
  info.x = splines.x(), info.y = splines.y(), info.z = splines.z();
  info.channels = 4;
  info.bounds = splines.bounds();
  info.basis = Basis::kCubic;
  std::vector<BrickPlace> bricks;
  for (const BrickSlice::Entry& entry : splines.entries()) bricks.push_back(entry.place);
  BrickSlice lit(info, bricks);
  // Smoothed voxels begin one earlier.
  const auto pointOf = [&](const std::array<std::int32_t, 3>& at) {
    return layout_ ? pointAt({at[0] + 1, at[1] + 1, at[2] + 1})
                   : corners_->ofVoxel[splines.placeOf(at[0], at[1], at[2])];
  };
  parallelRanges(bricks.size(), 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      const float* from = splines.brick(splines.entries()[b].stored);
      float* out = lit.brick(static_cast<std::int32_t>(b));
      std::copy_n(from, splines.channels() * kVoxels, out);
      for (int i = 0; i < kVoxels; ++i) {
        if (!(from[i] > 0))
          continue;
        const std::array<std::int32_t, 3> place{bricks[b][0] * kSide + i % kSide,
                                                bricks[b][1] * kSide + i / kSide % kSide,
                                                bricks[b][2] * kSide + i / kSide / kSide};
        const std::int32_t point = pointOf(place);
        if (point < 0)
          continue;
        const VoxelLight& own = light[static_cast<std::size_t>(point)];
        Rgb differences = Rgb::Zero();
        for (std::size_t way = 0; way < 6; ++way) {
          auto at = place;
          at[way / 2] += way % 2 == 0 ? -1 : 1;
          const double beside = splines.value(at[0], at[1], at[2], 0);
          const std::int32_t other = beside == 0 ? -1 : pointOf(at);
          if (other >= 0)
            differences += beside * (light[static_cast<std::size_t>(other)] - own).cast<double>();
        }
        const Rgb plain = static_cast<double>(from[i]) * own.cast<double>();
        const Rgb scattered = (plain - differences / 6).max(0.5 * plain).min(1.5 * plain);
        for (int c = 0; c < 3; ++c) out[(1 + c) * kVoxels + i] += static_cast<float>(scattered[c]);
      }
    }
  });
  return lit;
}

ShadedVoxels ShadedVoxels::withSplines(std::span<const VoxelLight> light) const {
  if (splines_)
    return drawnFrom(litSplines(*splines_, light));
  ShadedVoxels lit = *this;
  lit.cubic_ = std::make_shared<const CubicVoxels>(
      std::make_shared<const BrickSlice>(litSplines(*slice_, light)), 1, 1);
  return lit;
}

ShadedVoxels ShadedVoxels::withLight(std::vector<VoxelLight> given) const {
  VOLUTE_ASSERT(given.size() == lightPlaces().size());
  if (!layout_ || splines_)
    return withSplines(given);
  VoxelLight most = VoxelLight::Zero();
  for (const VoxelLight& one : given) most = most.max(one);
  if (!(most.maxCoeff() > 0)) {
    ShadedVoxels lit = *this;
    lit.light_ = nullptr, lit.lit_ = nullptr;
    return lit;
  }
  auto packed =
      std::make_shared<PackedLight>(most, isOneColor(given, most.cast<double>()), given.size());
  for (std::size_t i = 0; i < given.size(); ++i) packed->set(i, given[i]);
  given = std::vector<VoxelLight>();
  return withPacked(std::move(packed));
}

ShadedVoxels ShadedVoxels::withPacked(std::shared_ptr<const PackedLight> light) const {
  ShadedVoxels lit = *this;
  lit.light_ = light, lit.lit_ = nullptr;
  VoxelLight greatest = VoxelLight::Zero();
  for (std::size_t i = 0; i < light->size(); ++i)
    greatest = greatest.max(light->at(static_cast<std::int32_t>(i)));
  const Rgb largest = greatest.cast<double>();
  const int channels = slice_->channels();
  auto march = std::make_shared<MarchGrid>(*layout_);
  march->lightChannel = channels;
  march->oneColor = light->oneColor();
  for (int c = 0; c < 3; ++c) {
    const double levels = march->oneColor ? 1 : kPackedLevels[c];
    march->lightScale[c] = static_cast<float>(largest[c] / (levels * levels));
  }
  const Rgb perLargest = 1 / largest.max(1e-300);
  const auto valueOf = [&](const VoxelLight& one) {
    const Rgb shares = one.cast<double>() * perLargest;
    return march->oneColor ? static_cast<float>(shares.maxCoeff()) : packLight(shares);
  };
  const std::size_t bricks = layout_->bricks.size();
  const auto to = static_cast<std::size_t>(channels + 1) * kShadedCorners;
  march->fits = march->fits && bricks * to < std::numeric_limits<std::int32_t>::max();
  if (!march->fits)
    return lit;  // by pieces
  march->brickStride = static_cast<std::int32_t>(to);
  std::vector<float> corners(bricks * to);
  const bool beside = channels == 1;  // light is beside extinction, so that one load takes both
  if (beside) {
    march->channelStride = 1;
    for (std::int32_t& stride : march->stride) stride *= 2;
  }
  parallelRanges(bricks, 16, [&](std::size_t begin, std::size_t end) {
    std::array<float, kShadedCorners> extinction;
    for (std::size_t b = begin; b < end; ++b) {
      float* out = &corners[b * to];
      copyCorners(*slice_, layout_->bricks[b].place, beside ? extinction.data() : out);
      for (int i = 0; beside && i < kShadedCorners; ++i)
        out[2 * i] = extinction[static_cast<std::size_t>(i)];
      out += channels * march->channelStride;
      for (const std::int32_t point : corners_->pointsOf(*layout_, b)) {
        if (point >= 0)
          *out = valueOf(light->at(point));
        out += march->stride[0];
      }
    }
  });
  march->corners = std::make_shared<const std::vector<float>>(std::move(corners));
  march->values = march->corners->data();
  lit.lit_ = std::move(march);
  return lit;
}

Rgb ShadedVoxels::lightAt(std::int32_t brick, const std::array<int, 3>& cell, int corner) const {
  if (!light_ || brick < 0)
    return Rgb::Zero();
  int place = 0;
  for (int axis = 0, stride = 1; axis < 3; ++axis, stride *= kShadedSide)
    place +=
        (cell[static_cast<std::size_t>(axis)] % BrickSlice::kSide + (corner >> axis & 1)) * stride;
  const std::int32_t point = corners_->pointAt(*layout_, static_cast<std::size_t>(brick), place);
  return point < 0 ? Rgb(Rgb::Zero()) : Rgb(light_->at(point).cast<double>());
}

Rgb ShadedVoxels::emission(const Vec3& point) const {
  Rgb sent = Rgb::Zero();
  if (!layout_)
    return cubic_ ? cubic_->emission(point) : sent;
  if (!bounds().contains(point))
    return sent;
  const auto cell = cells_.cellAt(point);
  if (const std::int32_t tile =
          tiles_ && light_
              ? tiles_->table.at(cell[0] / kTileSide, cell[1] / kTileSide, cell[2] / kTileSide)
              : BrickTable::kEmpty;
      tile >= 0) {
    const auto n = static_cast<std::size_t>(tile);
    const auto part =
        voxels::cornerShares(voxels::placeInCell(tileGrid(), tiles_->places[n], point));
    for (std::size_t i = 0; i < 8; ++i) {
      const VoxelLight one = light_->at(tiles_->points[n][i]);
      sent += part[i] * tiles_->extinction[n] * one.cast<double>();
    }
    return sent;
  }
  const auto shares = voxels::cornerShares(voxels::placeInCell(cells_, cell, point));
  const std::int32_t brick = layout_->table.at(
      cell[0] / BrickSlice::kSide, cell[1] / BrickSlice::kSide, cell[2] / BrickSlice::kSide);
  Rgb light = Rgb::Zero();
  double extinction = 0;
  for (int i = 0; i < 8; ++i) {
    const auto& [dx, dy, dz] = voxels::kCorners[static_cast<std::size_t>(i)];
    const double share = shares[static_cast<std::size_t>(i)];
    const int x = cell[0] + dx, y = cell[1] + dy, z = cell[2] + dz;
    extinction += share * slice_->value(x, y, z, 0);
    light += share * lightAt(brick, cell, i);
    for (int c = 0; c < 3 && slice_->channels() == 4; ++c)
      sent[c] += share * slice_->value(x, y, z, 1 + c);
  }
  return sent + extinction * light;
}

void ShadedVoxels::pieces(std::span<const Segment> segments,
                          std::span<std::vector<Piece>> pieces) const {
  if (!layout_)
    return cubic_ ? cubic_->pieces(segments, pieces) : absorption().pieces(segments, pieces);
  const int channels = slice_->channels();
  const auto march = marched();
  for (std::size_t s = 0; s < segments.size(); ++s) {
    pieces[s].clear();
    forMarchedCells(*march, cells_, segments[s],
                    [&](const std::array<int, 3>& cell, std::int32_t brick, const float* first,
                        double begin, double end) {
                      const voxels::InCell ray(cells_, cell, segments[s], begin, end);
                      std::array<std::array<double, 8>, 7> values{};
                      bool empty = true;
                      for (int i = 0; i < 8; ++i) {
                        for (int c = 0; c < channels; ++c) {
                          const double value = cornerOf(*march, first, i, c);
                          values[static_cast<std::size_t>(c)][static_cast<std::size_t>(i)] = value;
                          empty = empty && value == 0;
                        }
                      }
                      if (empty)
                        return;
                      for (int i = 0; i < 8 && light_; ++i) {
                        const Rgb light = lightAt(brick, cell, i);
                        for (std::size_t c = 0; c < 3; ++c)
                          values[4 + c][static_cast<std::size_t>(i)] = light[c];
                      }
                      Piece piece{begin, end, {}, {}, 0};
                      const Cubic extinction = voxels::cornerCubic(ray, values[0]);
                      piece.extinction = extinction;
                      for (std::size_t c = 0; c < 3; ++c) {
                        piece.emission[c] = voxels::cornerCubic(ray, values[1 + c]);
                        if (light_)
                          piece.emission[c] +=
                              product(extinction, voxels::cornerCubic(ray, values[4 + c]));
                      }
                      pieces[s].push_back(piece);
                    });
    if (tiles_) {
      addTilePieces(segments[s], pieces[s]);
      std::ranges::sort(pieces[s], {}, &Piece::begin);
    }
  }
}

CellGrid ShadedVoxels::tileGrid() const {
  return {cells_.origin, kTileSide * cells_.cell, {}};
}

void ShadedVoxels::addTilePieces(const Segment& segment, std::vector<Piece>& pieces) const {
  const CellGrid grid = tileGrid();
  tiles_->table.walk(grid, segment,
                     [&](const BrickPlace& place, std::int32_t number, double begin, double end) {
                       if (!(end > begin))
                         return true;
                       const auto n = static_cast<std::size_t>(number);
                       const voxels::InCell ray(grid, place, segment, begin, end);
                       Piece piece{begin, end, {}, {}, 0};
                       piece.extinction.c[0] = tiles_->extinction[n];
                       for (int c = 0; c < 3 && light_; ++c) {
                         std::array<double, 8> values{};
                         for (std::size_t i = 0; i < 8; ++i)
                           values[i] = piece.extinction.c[0] * light_->at(tiles_->points[n][i])[c];
                         piece.emission[c] = voxels::cornerCubic(ray, values);
                       }
                       pieces.push_back(piece);
                       return true;
                     });
}

/// Emission and absorption in a tile, by two Gauss points for each step.
Radiance ShadedVoxels::radianceOfTile(const OnTile& on, const Segment& segment) const {
  constexpr double kMaxDepth = 1.3;
  const auto n = static_cast<std::size_t>(on.number);
  const double extinction = tiles_->extinction[n], length = on.end - on.begin;
  const voxels::InCell ray(tileGrid(), tiles_->places[n], segment, on.begin, on.end);
  std::array<VoxelLight, 8> light;
  for (std::size_t i = 0; i < 8; ++i) light[i] = light_->at(tiles_->points[n][i]);
  const GaussRule rule = gaussRule(2);
  const double steps = std::ceil(std::max(extinction * length / kMaxDepth, 1.0));
  const double step = length / steps;
  Radiance sum;
  for (double k = 0; k < steps && sum.transmittance > layout_->lightLost; ++k) {
    for (std::size_t g = 0; g < 2; ++g) {
      const double into = 0.5 * step * (1 + rule.nodes[g]);
      const auto shares = voxels::cornerShares(ray.at + (k * step + into) * ray.velocity);
      VoxelLight at = VoxelLight::Zero();
      for (std::size_t i = 0; i < 8; ++i) at += static_cast<float>(shares[i]) * light[i];
      sum.emitted += 0.5 * step * rule.weights[g] * extinction * sum.transmittance *
                     std::exp(-extinction * into) * at.cast<double>();
    }
    sum.transmittance *= std::exp(-extinction * step);
  }
  return sum;
}

void ShadedVoxels::radianceWithTiles(std::span<const Segment> segments, std::span<Radiance> out,
                                     MarchCounts& counts) const {
  // What is before each run of tiles, and behind the last.
  std::vector<OnTile> tiles;
  std::vector<Segment> between;
  std::vector<std::size_t> firstTile;
  constexpr double kTogether = 1e-9;
  for (const Segment& segment : segments) {
    firstTile.push_back(tiles.size());
    Segment rest = segment;
    tiles_->table.walk(
        tileGrid(), segment, [&](const BrickPlace&, std::int32_t number, double begin, double end) {
          if (!(end > begin))
            return true;
          const bool first = tiles.size() == firstTile.back();
          const bool begins = first || begin - tiles.back().end > kTogether * std::abs(begin);
          if (begins) {
            Segment before = rest;
            before.end = std::max(before.begin, begin);
            between.push_back(before);
          }
          tiles.push_back({number, begin, end, begins});
          rest.begin = end;
          return true;
        });
    rest.end = std::max(rest.begin, rest.end);
    between.push_back(rest);
  }
  firstTile.push_back(tiles.size());
  std::vector<Radiance> marched(between.size());
  marchRadiance(*lit_, cells_, occupied_, between, marched, counts);
  auto next = marched.begin();
  for (std::size_t s = 0; s < segments.size(); ++s) {
    Radiance sum;
    const auto add = [&](const Radiance& one) {
      sum.emitted += sum.transmittance * one.emitted;
      sum.transmittance *= one.transmittance;
    };
    for (std::size_t i = firstTile[s]; i < firstTile[s + 1]; ++i) {
      if (tiles[i].begins)
        add(*next++);
      if (sum.transmittance > layout_->lightLost)
        add(radianceOfTile(tiles[i], segments[s]));
    }
    add(*next++);
    out[s] = sum;
  }
}

bool ShadedVoxels::marchesLight() const {
  return lit_ && lit_->lightChannel >= 0;
}

void ShadedVoxels::radiance(std::span<const Segment> segments, std::span<Radiance> out) const {
  if (!layout_)
    return cubic_ ? cubic_->radiance(segments, out) : absorption().radiance(segments, out);
  if (!layout_->fits || (light_ && !marchesLight()))
    return radianceByPieces(*this, segments, out);
  if (!marchesLight() && layout_->emissionChannel < 0)
    return absorption().radiance(segments, out);
  MarchCounts counts;
  if (tiles_)
    radianceWithTiles(segments, out, counts);
  else
    marchRadiance(*marched(), cells_, occupied_, segments, out, counts);
  counters_->voxels += counts.voxels;
  counters_->bricksVisited += counts.bricksVisited;
  counters_->bricksSkipped += counts.bricksSkipped;
}

MarchCounts ShadedVoxels::counts() const {
  if (!layout_)
    return cubic_ ? cubic_->counts() : absorption().counts();
  return {counters_->voxels, counters_->bricksVisited, counters_->bricksSkipped};
}

}  // namespace volute
