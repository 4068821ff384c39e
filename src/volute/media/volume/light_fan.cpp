// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/volume/light_fan.hpp"

#include <hwy/aligned_allocator.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "volute/base/parallel.hpp"
#include "volute/media/volume/light_fan_rows.hpp"

namespace volute {
namespace {

constexpr int kPad = FanPlanes::kPad;  ///< zeros around a plane: as far as cubics reach, too
constexpr double kGauss[2] = {0.21132486540518713, 0.78867513459481287};
constexpr std::size_t kRowGrain = 16;

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

/// A share of one value of a plane beside a ray.
struct Tap {
  bool next;  ///< of the plane that is nearer to the light
  int b, c;
  float share;
};

/// The integral from (b, c) in one plane to (b + db, c + dc) in the next, both in voxels, times
/// `length`: shares of the values around (0, 0).
std::vector<Tap> tapsOf(double b, double db, double c, double dc, double length) {
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
  std::vector<Tap> taps;
  for (int next = 0; next < 2; ++next) {
    for (int i = 0; i < kReach; ++i) {
      for (int j = 0; j < kReach; ++j) {
        if (sums[next][i][j] != 0)
          taps.push_back({next == 1, i - 2, j - 2, static_cast<float>(sums[next][i][j])});
      }
    }
  }
  return taps;
}

}  // namespace

LightFan::LightFan(const BrickSlice& slice, std::span<const Vec3> points)
    : slice_(slice),
      voxel_(slice.bounds().size().cwiseQuotient(Vec3(slice.x(), slice.y(), slice.z()))),
      size_{slice.x(), slice.y(), slice.z()},
      places_(points.size()) {
  parallelRanges(points.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Vec3 place = (points[i] - slice_.bounds().min).cwiseQuotient(voxel_);
      for (int axis = 0; axis < 3; ++axis)
        places_[i][static_cast<std::size_t>(axis)] =
            static_cast<std::int32_t>(place[axis] + 1) - 1;  // rounded down; at least -1/2
    }
  });
}

LightFan::Planes LightFan::planesOf(std::size_t axis, std::span<const std::int32_t> which) const {
  Planes planes;
  planes.first = -1;
  planes.points.resize(static_cast<std::size_t>(size_[axis] + 2));
  for (const std::int32_t i : which) {
    const std::int32_t plane = places_[static_cast<std::size_t>(i)][axis] - planes.first;
    planes.points[static_cast<std::size_t>(plane)].push_back(i);
  }
  return planes;
}

void LightFan::transmittances(const Lamp& lamp, std::span<float> out) const {
  if (lamp.kind == Lamp::Kind::kSun)
    fromSun((-lamp.direction).cwiseQuotient(voxel_), out);
  else
    fromPoint((lamp.position - slice_.bounds().min).cwiseQuotient(voxel_) - Vec3::Constant(0.5),
              out);
}

/// All rays meet a plane at the same place between its values, so that a step from plane to plane
/// is one weighted sum of them.
void LightFan::fromSun(const Vec3& towards, std::span<float> out) const {
  Eigen::Index main = 0;
  towards.cwiseAbs().maxCoeff(&main);
  const auto axis = static_cast<std::size_t>(main);
  const Across across(axis);
  const Vec3 step = towards / std::abs(towards[main]);
  const double length = step.cwiseProduct(voxel_).norm();
  const double tb = step[static_cast<Eigen::Index>(across.row)],
               tc = step[static_cast<Eigen::Index>(across.column)];
  const int rows = size_[across.row], columns = size_[across.column], count = size_[axis];
  std::vector<std::int32_t> all(places_.size());
  std::iota(all.begin(), all.end(), 0);
  const Planes planes = planesOf(axis, all);
  Plane near(rows, columns), here(rows, columns), nearDepth(rows, columns), depth(rows, columns);
  Plane half(rows, columns), atCentres(rows, columns);
  double fb = 0, fc = 0;  // where between values the rays meet the plane
  const int away = step[main] > 0 ? -1 : 1;
  int k = away < 0 ? count : -1;
  fill(slice_, axis, k, near);
  for (const std::int32_t i : planes.points[static_cast<std::size_t>(k - planes.first)])
    out[static_cast<std::size_t>(i)] = 1;
  for (int passed = 0; passed <= count; ++passed) {
    k += away;
    fill(slice_, axis, k, here);
    const auto wrapped = [](double x) {
      const double rest = x - std::floor(x);
      return rest > 1 - 1e-9 ? 0.0 : rest;
    };
    const double before[2] = {fb, fc};
    fb = wrapped(fb - tb), fc = wrapped(fc - tc);
    const int sb = static_cast<int>(std::lround(fb + tb - before[0]));
    const int sc = static_cast<int>(std::lround(fc + tc - before[1]));
    const auto taps = tapsOf(fb, tb, fc, tc, length);
    const bool clear = near.empty && here.empty;
    const auto forRows = [&](int from, int to, auto&& body) {
      parallelRanges(static_cast<std::size_t>(to - from), kRowGrain,
                     [&](std::size_t begin, std::size_t end) {
                       for (std::size_t b = begin; b < end; ++b) body(from + static_cast<int>(b));
                     });
    };
    forRows(-3, rows + 3, [&](int b) {
      float* sum = depth.row(b);
      const float* old = nearDepth.row(b + sb) + sc;
      for (int c = -3; c < columns + 3; ++c) sum[c] = old[c];
      for (const Tap& tap : taps) {
        if (clear)
          break;
        const float* from = (tap.next ? near : here).row(b + tap.b) + tap.c;
        for (int c = -3; c < columns + 3; ++c) sum[c] += tap.share * from[c];
      }
    });
    // At the centres: along rows, then along columns.
    const int ib = fb > 0 ? -1 : 0, ic = fc > 0 ? -1 : 0;
    const auto alongB = cubicShares(fb > 0 ? 1 - fb : 0), alongC = cubicShares(fc > 0 ? 1 - fc : 0);
    forRows(-3, rows + 3, [&](int b) {
      const float* from = depth.row(b) + ic;
      float* to = half.row(b);
      for (int c = -1; c <= columns; ++c) {
        to[c] = alongC[0] * from[c - 1] + alongC[1] * from[c] + alongC[2] * from[c + 1] +
                alongC[3] * from[c + 2];
      }
    });
    forRows(-1, rows + 1, [&](int b) {
      const float* from[4];
      for (int i = 0; i < 4; ++i) from[i] = half.row(b + ib + i - 1);
      float* to = atCentres.row(b);
      for (int c = -1; c <= columns; ++c) {
        to[c] = alongB[0] * from[0][c] + alongB[1] * from[1][c] + alongB[2] * from[2][c] +
                alongB[3] * from[3][c];
      }
    });
    const auto& points = planes.points[static_cast<std::size_t>(k - planes.first)];
    parallelRanges(points.size(), 2048, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const Place& place = places_[static_cast<std::size_t>(points[i])];
        const float found = atCentres.row(place[across.row])[place[across.column]];
        out[static_cast<std::size_t>(points[i])] = std::exp(-std::max(found, 0.0F));
      }
    });
    std::swap(near, here), std::swap(nearDepth, depth);
  }
}

void LightFan::fromPoint(const Vec3& lamp, std::span<float> out) const {
  std::vector<std::int32_t> pyramids[6];
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const Vec3 way = Vec3(places_[i][0], places_[i][1], places_[i][2]) - lamp;
    Eigen::Index axis = 0;
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
  const auto along = [&](std::size_t a) { return lamp[static_cast<Eigen::Index>(a)]; };
  const double la = along(axis), lb = along(across.row), lc = along(across.column);
  // Planes from the lamp outwards, and the slopes of all ways to the points.
  int last = sign > 0 ? -1 : size_[axis];
  double least[2] = {1, 1}, most[2] = {-1, -1};
  for (const std::int32_t i : which) {
    const Place& place = places_[static_cast<std::size_t>(i)];
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
  const Planes planes = planesOf(axis, which);
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
      const Vec3 way(voxel_[static_cast<Eigen::Index>(axis)],
                     (begin[0] + i) / perSlope * voxel_[static_cast<Eigen::Index>(across.row)],
                     (begin[1] + j) / perSlope * voxel_[static_cast<Eigen::Index>(across.column)]);
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
    const auto& points = planes.points[static_cast<std::size_t>(k - planes.first)];
    const double perFar = perSlope / far;
    parallelRanges(points.size(), 1024, [&](std::size_t first, std::size_t end) {
      for (std::size_t p = first; p < end; ++p) {
        const Place& place = places_[static_cast<std::size_t>(points[p])];
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
