// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/volume/light_fan.hpp"

#include <hwy/aligned_allocator.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <new>
#include <numeric>
#include <tuple>

#include "volute/base/parallel.hpp"
#include "volute/media/volume/light_fan_rows.hpp"

namespace volute {
namespace {

constexpr int kPad = FanPlanes::kPad;  ///< zeros around a plane: as far as cubics reach, too
constexpr double kGauss[2] = {0.21132486540518713, 0.78867513459481287};

/// Values on a plane of voxel centres, zeros around them.
struct Plane {
  Plane(int rowCount, int columnCount)
      : rows(rowCount),
        columns(columnCount),
        width(columnCount + 2 * kPad),
        values(static_cast<std::size_t>(rowCount + 2 * kPad) * static_cast<std::size_t>(width), 0) {
  }

  float* row(int b) { return &values[static_cast<std::size_t>((b + kPad) * width + kPad)]; }

  const float* row(int b) const {
    return &values[static_cast<std::size_t>((b + kPad) * width + kPad)];
  }

  int rows, columns, width;
  bool empty = true;
  std::vector<float> values;
};

/// The two axes of planes across `axis`: columns along x where that is possible.
struct Across {
  std::size_t row, column;

  explicit Across(std::size_t axis) : row(axis == 2 ? 1 : 2), column(axis == 0 ? 1 : 0) {}
};

void fill(const BrickSlice& slice, std::size_t axis, int k, Plane& plane) {
  if (!plane.empty)
    std::ranges::fill(plane.values, 0);
  plane.empty = true;
  constexpr int kSide = BrickSlice::kSide;
  const int size[3] = {slice.x(), slice.y(), slice.z()};
  if (k < 0 || k >= size[axis])
    return;
  constexpr int kStride[3] = {1, kSide, kSide * kSide};
  const Across across(axis);
  for (int b = 0; b < size[across.row]; b += kSide) {
    for (int c = 0; c < size[across.column]; c += kSide) {
      int brick[3]{};
      brick[axis] = k / kSide, brick[across.row] = b / kSide, brick[across.column] = c / kSide;
      const std::int32_t stored = slice.brickAt(brick[0], brick[1], brick[2]);
      if (stored == BrickSlice::kEmpty)
        continue;
      plane.empty = false;
      const float* from = slice.brick(stored) + (k % kSide) * kStride[axis];
      for (int i = 0; i < std::min(kSide, size[across.row] - b); ++i) {
        float* out = plane.row(b + i) + c;
        for (int j = 0; j < std::min(kSide, size[across.column] - c); ++j)
          out[j] = from[i * kStride[across.row] + j * kStride[across.column]];
      }
    }
  }
}

/// Where a way from one plane to the next meets faces between cells, from 0 to 1: parts of it are
/// between neighbours of these.
std::array<double, 4> cutsOf(double b, double db, double c, double dc) {
  const auto crossing = [](double from, double step) {
    const double first = std::floor(from), last = std::floor(from + step);
    return first == last ? 1.0 : std::clamp((std::max(first, last) - from) / step, 0.0, 1.0);
  };
  const double one = crossing(b, db), other = crossing(c, dc);
  return {0, std::min(one, other), std::max(one, other), 1};
}

/// Of the cubic through values at -1, 0, 1 and 2, at 0 <= t < 1.
std::array<float, 4> cubicShares(double t) {
  return {static_cast<float>(-t * (t - 1) * (t - 2) / 6),
          static_cast<float>((t + 1) * (t - 1) * (t - 2) / 2),
          static_cast<float>(-(t + 1) * t * (t - 2) / 2),
          static_cast<float>((t + 1) * t * (t - 1) / 6)};
}

/// Rounded down, of what is not below 0.
std::size_t floorOf(double x) {
  return static_cast<std::size_t>(x);
}

/// Two planes side by side.
void join(const Plane& before, const Plane& here, FanPlanes& both) {
  for (std::size_t i = 0; i < before.values.size(); ++i)
    both.values[2 * i] = before.values[i], both.values[2 * i + 1] = here.values[i];
}

/// The integral from (b, c) in one plane to (b + db, c + dc) in the next, both in voxels, times
/// `length`: shares of the values around (0, 0).
FanTaps tapsOf(double b, double db, double c, double dc, double length) {
  constexpr int kReach = 5;  // from -2 to 2 and one more
  double sums[2][kReach][kReach]{};
  const auto cuts = cutsOf(b, db, c, dc);
  for (std::size_t part = 0; part < 3; ++part) {
    const double from = cuts[part], to = cuts[part + 1];
    const double middle = 0.5 * (from + to);
    const auto cellB = static_cast<int>(std::floor(b + middle * db)),
               cellC = static_cast<int>(std::floor(c + middle * dc));
    for (const double node : kGauss) {
      const double t = from + node * (to - from);
      const double u = b + t * db - cellB, v = c + t * dc - cellC;
      const double weight = 0.5 * (to - from) * length;
      for (int i = 0; i < 8; ++i) {
        const double share = (i & 1 ? t : 1 - t) * (i & 2 ? u : 1 - u) * (i & 4 ? v : 1 - v);
        sums[i & 1][cellB + (i >> 1 & 1) + 2][cellC + (i >> 2) + 2] += weight * share;
      }
    }
  }
  FanTaps taps;
  for (int next = 0; next < 2; ++next) {
    for (int i = 0; i < kReach; ++i) {
      for (int j = 0; j < kReach; ++j) {
        if (sums[next][i][j] != 0)
          taps.add({next, i - 2, j - 2, static_cast<float>(sums[next][i][j])});
      }
    }
  }
  return taps;
}

}  // namespace

LightFan::LightFan(const BrickSlice& slice, const VoxelPlaces& places)
    : slice_(slice),
      voxel_(slice.bounds().size().cwiseQuotient(Vec3(slice.x(), slice.y(), slice.z()))),
      size_{slice.x(), slice.y(), slice.z()},
      places_(places) {
  for (std::size_t axis = 0; axis < 3; ++axis) reach_[axis] = {-1, size_[axis]};
  VoxelPlaces::Reader at(places_);
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const Place place = at[i];
    for (std::size_t axis = 0; axis < 3; ++axis) reach_[axis].add(place[axis]);
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    bricks_[axis] = {size_[axis], 0};
    for (const BrickSlice::Entry& entry : slice.entries()) {
      const int from = entry.place[axis] * BrickSlice::kSide;
      bricks_[axis].add(from),
          bricks_[axis].add(std::min(from + BrickSlice::kSide, size_[axis]) - 1);
    }
  }
}

LightFan::Planes LightFan::planesOf(std::size_t axis) const {
  return planesOf(axis, places_.size(), [](std::size_t i) { return static_cast<std::int32_t>(i); });
}

template <class Which>
LightFan::Planes LightFan::planesOf(std::size_t axis, std::size_t count, Which&& which) const {
  Planes planes;
  planes.first = reach_[axis].least;
  planes.begin.resize(static_cast<std::size_t>(reach_[axis].most - planes.first) + 2);
  planes.points.resize(count);
  VoxelPlaces::Reader at(places_);
  const auto planeOf = [&](std::int32_t point) {
    return static_cast<std::size_t>(at[static_cast<std::size_t>(point)][axis] - planes.first);
  };
  for (std::size_t i = 0; i < count; ++i) ++planes.begin[planeOf(which(i)) + 1];
  std::partial_sum(planes.begin.begin(), planes.begin.end(), planes.begin.begin());
  std::vector<std::uint32_t> next = planes.begin;
  for (std::size_t i = 0; i < count; ++i) planes.points[next[planeOf(which(i))]++] = which(i);
  return planes;
}

LightFan::Rows LightFan::rowsOf(std::size_t axis) const {
  const Across across(axis);
  const auto entries = slice_.entries();
  Rows rows;
  rows.entries.resize(entries.size());
  std::iota(rows.entries.begin(), rows.entries.end(), 0U);
  const auto keyOf = [&](std::uint32_t entry) {
    const BrickPlace& place = entries[entry].place;
    const int row = place[across.row];
    return std::tuple(place[axis], row & 1, row, place[across.column]);
  };
  std::ranges::sort(rows.entries, {}, keyOf);
  rows.layers.resize(static_cast<std::size_t>(size_[axis] / BrickSlice::kSide) + 1);
  for (std::size_t begin = 0, end = 0; begin < rows.entries.size(); begin = end) {
    const auto [layer, odd, row, column] = keyOf(rows.entries[begin]);
    while (end < rows.entries.size() && std::get<2>(keyOf(rows.entries[end])) == row &&
           std::get<0>(keyOf(rows.entries[end])) == layer)
      ++end;
    rows.layers[static_cast<std::size_t>(layer)][static_cast<std::size_t>(odd)].push_back(
        std::span(rows.entries).subspan(begin, end - begin));
  }
  return rows;
}

/// Rays to a sun through the volume, a voxel apart on planes across its main axis. Each ray keeps
/// its number from plane to plane, so that what nothing shades is never touched.
struct LightFan::SunRays {
  std::size_t axis;
  Across across;
  int away;     ///< from a plane to the next that is farther from the sun: -1 or 1
  double b, c;  ///< voxels on the way from a plane towards the sun
  double length;
  int first, last;  ///< planes, from the one nearest to the sun on
  int before;       ///< so many planes, below 0, may have points before the first
  int firstB, firstC;
  std::size_t rows, columns;

  SunRays(const LightFan& fan, const Vec3& towards, std::size_t main)
      : axis(main),
        across(main),
        away(towards[main] > 0 ? -1 : 1),
        first(away < 0 ? fan.bricks_[main].most : fan.bricks_[main].least),
        last(away < 0 ? fan.reach_[main].least : fan.reach_[main].most),
        before(std::min(away < 0 ? first - fan.reach_[main].most : fan.reach_[main].least - first,
                        0)) {
    const Vec3 step = towards / std::abs(towards[main]);
    length = step.cwiseProduct(fan.voxel_).norm();
    b = step[across.row];
    c = step[across.column];
    constexpr int kAround = 16;  // what whole bricks, taps and cubics reach
    const auto reached = [&](std::size_t side, double slope, int& begin) {
      const auto [low, high] = std::minmax({0.0, slope * steps(), slope * before});
      begin = fan.reach_[side].least + static_cast<int>(std::floor(low)) - kAround;
      return static_cast<std::size_t>(fan.reach_[side].most + static_cast<int>(std::ceil(high)) +
                                      kAround - begin);
    };
    rows = reached(across.row, b, firstB);
    columns = reached(across.column, c, firstC) + FanBrick::kLanes;
  }

  /// After the first plane.
  int steps() const { return std::max(away * (last - first), 0); }

  /// Where ray 0 meets the plane after so many steps: at a value, and a share of the way to the
  /// next.
  static std::pair<int, double> place(double slope, int passed) {
    const double at = -slope * passed;
    const double whole = std::floor(at + 1e-9);
    return {static_cast<int>(whole), std::max(at - whole, 0.0)};
  }

  std::size_t rayAt(int rayB, int rayC) const {
    return static_cast<std::size_t>(rayB - firstB) * columns +
           static_cast<std::size_t>(rayC - firstC);
  }
};

bool LightFan::transmittances(const Lamp& lamp, std::span<float> out,
                              std::span<float> beyond) const {
  constexpr std::size_t kSparse = 16, kRays = std::size_t{1} << 24;
  if (slice_.basis() != Basis::kTrilinear)
    return false;
  if (lamp.kind == Lamp::Kind::kSun) {
    const Vec3 towards = (-lamp.direction).cwiseQuotient(voxel_);
    int main = 0;
    towards.cwiseAbs().maxCoeff(&main);
    const SunRays rays(*this, towards, static_cast<std::size_t>(main));
    if (rays.rows > std::max(kRays, 8 * places_.size()) / rays.columns)
      return false;
    fromSun(rays, out, beyond);
    return true;
  }
  const std::size_t voxels = static_cast<std::size_t>(size_[0]) *
                             static_cast<std::size_t>(size_[1]) *
                             static_cast<std::size_t>(size_[2]);
  if (kSparse * places_.size() < voxels)
    return false;
  fromPoint((lamp.position - slice_.bounds().min).cwiseQuotient(voxel_) - Vec3::Constant(0.5), out);
  return true;
}

/// All rays meet a plane at the same place between its values, so that what a brick adds on a step
/// from plane to plane is one weighted sum of its values.
void LightFan::fromSun(const SunRays& rays, std::span<float> out, std::span<float> beyond) const {
  struct Free {
    void operator()(float* memory) const { std::free(memory); }
  };

  // Of untouched pages nothing is there.
  const std::unique_ptr<float, Free> memory(
      static_cast<float*>(std::calloc(rays.rows * rays.columns, sizeof(float))));
  if (!memory)
    throw std::bad_alloc();
  float* const depths = memory.get();
  const Planes planes = planesOf(rays.axis);
  const Rows rows = rowsOf(rays.axis);
  constexpr int kSide = BrickSlice::kSide;
  // Takes what the rays have passed so far, at each point of a plane.
  const auto forPoints = [&](int passed, auto&& take) {
    const auto points = planes.at(rays.first + passed * rays.away);
    const auto [ib, fb] = SunRays::place(rays.b, passed);
    const auto [ic, fc] = SunRays::place(rays.c, passed);
    const int toB = ib + (fb > 0 ? 1 : 0), toC = ic + (fc > 0 ? 1 : 0);
    const auto alongB = cubicShares(fb > 0 ? 1 - fb : 0), alongC = cubicShares(fc > 0 ? 1 - fc : 0);
    parallelRanges(points.size(), 2048, [&](std::size_t begin, std::size_t end) {
      VoxelPlaces::Reader at(places_);
      for (std::size_t i = begin; i < end; ++i) {
        const auto point = static_cast<std::size_t>(points[i]);
        const Place place = at[point];
        const float* from = depths + rays.rayAt(place[rays.across.row] - toB - 1,
                                                place[rays.across.column] - toC - 1);
        float sum = 0;
        for (std::size_t r = 0; r < 4; ++r, from += rays.columns) {
          sum += alongB[r] * (alongC[0] * from[0] + alongC[1] * from[1] + alongC[2] * from[2] +
                              alongC[3] * from[3]);
        }
        take(point, sum);
      }
    });
  };
  const auto passes = [](float depth) { return std::exp(-std::max(depth, 0.0F)); };
  const auto takeShade = [&](std::size_t point, float depth) {
    out[point] = passes(depth);
    if (!beyond.empty())
      beyond[point] = depth;
  };
  // Planes that the light meets before the first brick.
  for (int passed = rays.before; passed < 0; ++passed) {
    for (const std::int32_t point : planes.at(rays.first + passed * rays.away))
      takeShade(static_cast<std::size_t>(point), 0);
  }
  for (int passed = 0; passed <= rays.steps(); ++passed) {
    const int here = rays.first + passed * rays.away, near = here - rays.away;
    const auto [ib, fb] = SunRays::place(rays.b, passed);
    const auto [ic, fc] = SunRays::place(rays.c, passed);
    const FanTaps taps = tapsOf(fb, rays.b, fc, rays.c, rays.length);
    const auto addBrick = [&](const BrickSlice::Entry& entry, FanBrick& brick) {
      const float* values = slice_.brick(entry.stored);
      const int from = entry.place[rays.axis] * kSide;
      brick.take(0, values, rays.axis, here - from);
      brick.take(1, values, rays.axis, near - from);
      const int row = entry.place[rays.across.row] * kSide - ib,
                column = entry.place[rays.across.column] * kSide - ic;
      addFanBrick(brick, taps, depths + rays.rayAt(row, column), rays.columns);
    };
    // Rows of bricks beside each other add to the same rays: every second one at a time.
    const int layers[2] = {here >> 3, near >> 3};
    for (int l = 0; l < (layers[0] == layers[1] ? 1 : 2); ++l) {
      for (const auto& some : rows.at(layers[l])) {
        parallelRanges(some.size(), 4, [&](std::size_t begin, std::size_t end) {
          FanBrick brick;
          for (std::size_t i = begin; i < end; ++i) {
            for (const std::uint32_t entry : some[i]) addBrick(slice_.entries()[entry], brick);
          }
        });
      }
    }
    forPoints(passed, takeShade);
  }
  // What a ray has passed at its end, less what it has passed at a point, is beyond that.
  for (int passed = rays.before; !beyond.empty() && passed <= rays.steps(); ++passed) {
    forPoints(passed, [&](std::size_t point, float whole) {
      beyond[point] = passes(whole - beyond[point]);
    });
  }
}

void LightFan::fromPoint(const Vec3& lamp, std::span<float> out) const {
  std::vector<std::int32_t> pyramids[6];
  VoxelPlaces::Reader at(places_);
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const Place place = at[i];
    const Vec3 way = Vec3(place[0], place[1], place[2]) - lamp;
    int axis = 0;
    if (!(way.cwiseAbs().maxCoeff(&axis) > 1e-9)) {
      out[i] = 1;
      continue;
    }
    pyramids[2 * axis + (way[axis] > 0 ? 1 : 0)].push_back(static_cast<std::int32_t>(i));
  }
  for (std::size_t p = 0; p < 6; ++p) {
    if (!pyramids[p].empty())
      inPyramid(lamp, p / 2, p % 2 == 0 ? -1 : 1, pyramids[p], out);
  }
}

void LightFan::inPyramid(const Vec3& lamp, std::size_t axis, int sign,
                         std::span<const std::int32_t> which, std::span<float> out) const {
  const Across across(axis);
  const auto along = [&](std::size_t a) { return lamp[a]; };
  const double la = along(axis), lb = along(across.row), lc = along(across.column);
  // Planes from the lamp outwards, and the slopes of all ways to the points.
  int last = sign > 0 ? -1 : size_[axis];
  double least[2] = {1, 1}, most[2] = {-1, -1};
  VoxelPlaces::Reader at(places_);
  for (const std::int32_t i : which) {
    const Place place = at[static_cast<std::size_t>(i)];
    last = sign > 0 ? std::max(last, place[axis]) : std::min(last, place[axis]);
    const double far = std::abs(place[axis] - la);
    const double slope[2] = {(place[across.row] - lb) / far, (place[across.column] - lc) / far};
    for (int s = 0; s < 2; ++s)
      least[s] = std::min(least[s], slope[s]), most[s] = std::max(most[s], slope[s]);
  }
  const double perSlope = std::max(std::abs(last - la), 1.0);  // rays: a voxel apart at the last
  int begin[2], count[2];
  for (int s = 0; s < 2; ++s) {
    begin[s] = static_cast<int>(std::floor(least[s] * perSlope)) - 1;
    count[s] = static_cast<int>(std::floor(most[s] * perSlope)) + 3 - begin[s];
  }
  const Planes planes = planesOf(axis, which.size(), [&](std::size_t i) { return which[i]; });
  const int rows = size_[across.row], columns = size_[across.column];
  Plane before(rows, columns), here(rows, columns);
  FanPlanes both(rows, columns);
  const std::size_t rays =
      (static_cast<std::size_t>(count[1]) + kFanRays - 1) / kFanRays * kFanRays;
  const std::size_t all = static_cast<std::size_t>(count[0]) * rays;
  const auto floats = hwy::AllocateAligned<float>(2 * all);
  float *depths = floats.get(), *perStep = depths + all;  // [m] of each ray, from plane to plane
  std::fill_n(depths, 2 * all, 0.0F);
  for (int i = 0; i < count[0]; ++i) {
    for (int j = 0; j < count[1]; ++j) {
      const Vec3 way(voxel_[axis], (begin[0] + i) / perSlope * voxel_[across.row],
                     (begin[1] + j) / perSlope * voxel_[across.column]);
      perStep[static_cast<std::size_t>(i) * rays + static_cast<std::size_t>(j)] =
          static_cast<float>(way.norm());
    }
  }
  int k = sign > 0 ? static_cast<int>(std::floor(la)) + 1 : static_cast<int>(std::ceil(la)) - 1;
  double from = la;
  if (sign > 0 ? k < -1 : k > size_[axis]) {  // outside: nothing is there up to the first plane
    k = sign > 0 ? -1 : size_[axis];
    from = k;
  }
  fill(slice_, axis, k - sign, before);
  for (; sign > 0 ? k <= last : k >= last; k += sign) {
    fill(slice_, axis, k, here);
    const double near = std::abs(from - la), far = std::abs(k - la);
    const auto z0 = static_cast<float>(1 - (far - near));  // place between the two planes
    if (far > near && !(before.empty && here.empty)) {
      join(before, here, both);
      const double v = begin[1] / perSlope;
      FanRow row{};
      row.c = static_cast<float>(lc + v * near), row.cStep = static_cast<float>(near / perSlope);
      row.dc = static_cast<float>(v * (far - near));
      row.dcStep = static_cast<float>((far - near) / perSlope);
      row.z = z0;
      parallelRanges(static_cast<std::size_t>(count[0]), 4,
                     [&](std::size_t first, std::size_t end) {
                       for (std::size_t i = first; i < end; ++i) {
                         FanRow one = row;
                         const double u = (begin[0] + static_cast<int>(i)) / perSlope;
                         one.b = static_cast<float>(lb + u * near),
                         one.db = static_cast<float>(u * (far - near));
                         if (std::max(one.b, one.b + one.db) < -1 ||
                             std::min(one.b, one.b + one.db) > static_cast<float>(rows))
                           continue;
                         addFanRow(both, one, rays, static_cast<float>(far - near),
                                   perStep + i * rays, depths + i * rays);
                       }
                     });
    }
    const auto points = planes.at(k);
    const double perFar = perSlope / far;
    parallelRanges(points.size(), 1024, [&](std::size_t first, std::size_t end) {
      VoxelPlaces::Reader at(places_);
      for (std::size_t p = first; p < end; ++p) {
        const Place place = at[static_cast<std::size_t>(points[p])];
        const double i = (place[across.row] - lb) * perFar - begin[0];
        const double j = (place[across.column] - lc) * perFar - begin[1];
        const std::size_t row = floorOf(i), column = floorOf(j);
        const auto atB = cubicShares(i - static_cast<double>(row)),
                   atC = cubicShares(j - static_cast<double>(column));
        const float* corner = depths + (row - 1) * rays + column - 1;
        float sum = 0;
        for (std::size_t r = 0; r < 4; ++r, corner += rays) {
          sum += atB[r] * (atC[0] * corner[0] + atC[1] * corner[1] + atC[2] * corner[2] +
                           atC[3] * corner[3]);
        }
        out[static_cast<std::size_t>(points[p])] = std::exp(-std::max(sum, 0.0F));
      }
    });
    std::swap(before, here);
    from = k;
  }
}

}  // namespace volute
