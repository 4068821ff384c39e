// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/refined_spline.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "volute/base/assert.hpp"
#include "volute/base/parallel.hpp"

namespace volute {
namespace {

constexpr int kFineSide = BrickSlice::kSide;

/// Four weights of the coefficients from `first` on that make one voxel along an axis.
struct Taps {
  int first = 0;
  std::array<float, 4> weights{};
};

/// How voxels of a brick are made of coefficients along each axis. Which are those is the same in
/// every brick but for where it begins.
struct SplineTaps {
  std::array<Taps, kFineSide> taps;  ///< `first` counts from the first that the brick needs
  int before = 0;                    ///< of brick 0 the first that it needs is -before
  int stride = 0;                    ///< from one brick to the next
  int length = 0;                    ///< what a brick needs
};

/// The spline at voxels' centres is (1, 4, 1)/6 of its coefficients; interpolation between its
/// values at a distance h adds h^2/12 of its second derivative to means, which is taken off.
SplineTaps smoothedTaps() {
  SplineTaps made{{}, 2, kFineSide, kFineSide + 2};
  for (int i = 0; i < kFineSide; ++i) made.taps[i] = {i, {1 / 12.0F, 10 / 12.0F, 1 / 12.0F, 0}};
  return made;
}

/// Twice as fine, the spline's coefficients are (1, 6, 1)/8 and (1, 1)/2 of the old ones, and the
/// voxels (1, 10, 1)/12 of these. The first voxel lies between centres -2 and -1.
SplineTaps refinedTaps() {
  SplineTaps made{{}, 3, kFineSide / 2, kFineSide};
  for (int i = 0; i < kFineSide; i += 2) {
    made.taps[i] = {i / 2, {1 / 96.0F, 47 / 96.0F, 47 / 96.0F, 1 / 96.0F}};
    made.taps[i + 1] = {i / 2 + 1, {7 / 48.0F, 34 / 48.0F, 7 / 48.0F, 0}};
  }
  return made;
}

constexpr int kMaxNeeded = kFineSide + 4;

using Block = std::array<float, kMaxNeeded * kMaxNeeded * kMaxNeeded>;

/// Coefficients of one channel, `length` along each axis, zeros where there are none.
/// @return  whether one of them is not 0
bool readBlock(const BrickSlice& from, const BrickPlace& begin, int length, int channel,
               Block& out) {
  out.fill(0);
  bool any = false;
  const int size[3] = {from.x(), from.y(), from.z()};
  BrickPlace low, high;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    low[axis] = std::max(begin[axis], 0);
    high[axis] = std::min(begin[axis] + length, size[axis]);
    if (low[axis] >= high[axis])
      return false;
  }
  for (int z = low[2]; z < high[2]; ++z) {
    for (int y = low[1]; y < high[1]; ++y) {
      for (int x = low[0]; x < high[0];) {
        const int end = std::min((x / kFineSide + 1) * kFineSide, high[0]);
        const std::int32_t stored = from.brickAt(x / kFineSide, y / kFineSide, z / kFineSide);
        if (stored != BrickSlice::kEmpty) {
          const float* row = from.brick(stored) + channel * BrickSlice::kVoxels +
                             ((z % kFineSide) * kFineSide + y % kFineSide) * kFineSide +
                             x % kFineSide;
          float* to = &out[static_cast<std::size_t>(
              ((z - begin[2]) * kMaxNeeded + y - begin[1]) * kMaxNeeded + x - begin[0])];
          std::copy_n(row, end - x, to);
          any = any || std::any_of(row, row + (end - x), [](float value) { return value != 0; });
        }
        x = end;
      }
    }
  }
  return any;
}

float weighted(const float* from, int stride, const std::array<float, 4>& weights) {
  return weights[0] * from[0] + weights[1] * from[stride] + weights[2] * from[2 * stride] +
         weights[3] * from[3 * stride];
}

/// One channel of one brick, axis by axis.
void makeBrick(const SplineTaps& how, const Block& from, float* out) {
  constexpr int kRow = kMaxNeeded;
  std::array<float, kRow * kRow * kFineSide> alongX{};
  std::array<float, kRow * kFineSide * kFineSide> alongY{};
  for (int line = 0; line < kRow * kRow; ++line) {
    for (int x = 0; x < kFineSide; ++x) {
      const Taps& taps = how.taps[x];
      const float* row = &from[static_cast<std::size_t>(line * kRow)];
      alongX[static_cast<std::size_t>(line * kFineSide + x)] =
          weighted(row + taps.first, 1, taps.weights);
    }
  }
  for (int z = 0; z < how.length; ++z) {
    for (int y = 0; y < kFineSide; ++y) {
      const Taps& taps = how.taps[y];
      for (int x = 0; x < kFineSide; ++x) {
        alongY[static_cast<std::size_t>((z * kFineSide + y) * kFineSide + x)] =
            weighted(&alongX[static_cast<std::size_t>((z * kRow + taps.first) * kFineSide + x)],
                     kFineSide, taps.weights);
      }
    }
  }
  constexpr int kPlane = kFineSide * kFineSide;
  for (int z = 0; z < kFineSide; ++z) {
    const Taps& taps = how.taps[z];
    for (int i = 0; i < kPlane; ++i)
      *out++ = weighted(&alongY[static_cast<std::size_t>(taps.first * kPlane + i)], kPlane,
                        taps.weights);
  }
}

/// Bricks that a stored one reaches into, in the order of isBefore().
std::vector<BrickPlace> placesOf(const BrickSlice& spline, const SplineTaps& how,
                                 const BrickPlace& count) {
  std::vector<BrickPlace> places;
  for (const BrickSlice::Entry& entry : spline.entries()) {
    BrickPlace low, high;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int first = entry.place[axis] * kFineSide, last = first + kFineSide - 1;
      // Brick b needs coefficients from b stride - before on.
      low[axis] = std::max((first + how.before - how.length + how.stride) / how.stride, 0);
      high[axis] = std::min((last + how.before) / how.stride, count[axis] - 1);
    }
    for (int z = low[2]; z <= high[2]; ++z) {
      for (int y = low[1]; y <= high[1]; ++y) {
        for (int x = low[0]; x <= high[0]; ++x) places.push_back({x, y, z});
      }
    }
  }
  std::ranges::sort(places, isBefore);
  places.erase(std::ranges::unique(places).begin(), places.end());
  return places;
}

/// @param info  of what is made
BrickSlice madeOf(const BrickSlice& spline, const SplineTaps& how, const VolumeInfo& info) {
  const BrickPlace count{(info.x + kFineSide - 1) / kFineSide, (info.y + kFineSide - 1) / kFineSide,
                         (info.z + kFineSide - 1) / kFineSide};
  const std::vector<BrickPlace> places = placesOf(spline, how, count);
  BrickSlice made(info, places);
  parallelRanges(places.size(), 8, [&](std::size_t begin, std::size_t end) {
    Block block;
    for (std::size_t b = begin; b < end; ++b) {
      BrickPlace first;
      for (std::size_t axis = 0; axis < 3; ++axis)
        first[axis] = places[b][axis] * how.stride - how.before;
      float* out = made.brick(static_cast<std::int32_t>(b));
      for (int c = 0; c < info.channels; ++c, out += BrickSlice::kVoxels) {
        if (readBlock(spline, first, how.length, c, block))
          makeBrick(how, block, out);
      }
    }
  });
  made.dropEmpty();
  return made;
}

constexpr int kSteps[] = {1, kMaxNeeded, kMaxNeeded* kMaxNeeded};

/// What flows out of a voxel to higher ones beside it, a sixth of each difference.
float outflow(const float* at) {
  float sum = 0;
  for (const int step : kSteps)
    sum += std::max(at[-step] - *at, 0.0F) + std::max(at[step] - *at, 0.0F);
  return sum / 6;
}

/// What comes into a voxel through the face to the next one, each with its share of the outflow.
float throughFace(const float* at, const float* share, int step) {
  const float difference = (*at - at[step]) / 6;
  return difference * (difference > 0 ? share[step] : *share);
}

/// The values less a sixth of the second differences of `shape`, as far as they last.
/// @param values, shape  two voxels more than a brick on each side
void sharpenBrick(const Block& values, const Block& shape, float* out) {
  Block shares;
  const auto place = [](int x, int y, int z) {
    return static_cast<std::size_t>((z * kMaxNeeded + y) * kMaxNeeded + x);
  };
  for (int z = 1; z < kFineSide + 3; ++z) {
    for (int y = 1; y < kFineSide + 3; ++y) {
      for (int x = 1; x < kFineSide + 3; ++x) {
        const std::size_t i = place(x, y, z);
        const float flows = outflow(&shape[i]);
        shares[i] = flows > values[i] ? std::max(values[i], 0.0F) / flows : 1.0F;
      }
    }
  }
  for (int z = 2; z < kFineSide + 2; ++z) {
    for (int y = 2; y < kFineSide + 2; ++y) {
      for (int x = 2; x < kFineSide + 2; ++x) {
        const std::size_t i = place(x, y, z);
        float sum = values[i];
        for (const int step : kSteps) {
          sum +=
              throughFace(&shape[i], &shares[i], step) + throughFace(&shape[i], &shares[i], -step);
        }
        *out++ = values[i] > 0 ? std::max(sum, 0.0F) : sum;  // but for rounding it is not below
      }
    }
  }
}

BrickSlice sharpened(const BrickSlice& values, const BrickSlice& shape) {
  BrickSlice made = values.unshared();
  parallelRanges(made.entries().size(), 8, [&](std::size_t begin, std::size_t end) {
    Block own, its;
    for (std::size_t b = begin; b < end; ++b) {
      const BrickSlice::Entry& entry = made.entries()[b];
      BrickPlace first;
      for (std::size_t axis = 0; axis < 3; ++axis) first[axis] = entry.place[axis] * kFineSide - 2;
      float* out = made.brick(entry.stored);
      for (int c = 0; c < values.channels(); ++c, out += BrickSlice::kVoxels) {
        if (readBlock(values, first, kFineSide + 4, c, own) &&
            readBlock(shape, first, kFineSide + 4, c, its))
          sharpenBrick(own, its, out);
      }
    }
  });
  return made;
}

VolumeInfo trilinearInfo(const BrickSlice& spline) {
  VOLUTE_ASSERT(spline.basis() == Basis::kCubic);
  VolumeInfo info;
  info.channels = spline.channels();
  info.basis = Basis::kTrilinear;
  return info;
}

/// Bounds that are larger by a number of voxels on each side.
Box3 grown(const BrickSlice& spline, double voxels) {
  const Vec3 voxel = spline.bounds().size().cwiseQuotient(Vec3(spline.x(), spline.y(), spline.z()));
  return {spline.bounds().min - voxels * voxel, spline.bounds().max + voxels * voxel};
}

}  // namespace

BrickSlice splineThrough(const BrickSlice& values) {
  BrickSlice made = sharpened(values, sharpened(values, values));
  made.setBasis(Basis::kCubic);
  return made;
}

BrickSlice refinedSpline(const BrickSlice& spline) {
  VolumeInfo info = trilinearInfo(spline);
  info.x = 2 * spline.x() + 5, info.y = 2 * spline.y() + 5, info.z = 2 * spline.z() + 5;
  info.bounds = grown(spline, 1.25);
  return madeOf(spline, refinedTaps(), info);
}

BrickSlice smoothedSpline(const BrickSlice& spline) {
  VolumeInfo info = trilinearInfo(spline);
  info.x = spline.x() + 2, info.y = spline.y() + 2, info.z = spline.z() + 2;
  info.bounds = grown(spline, 1);
  return madeOf(spline, smoothedTaps(), info);
}

std::uint64_t refinedSplineBytes(const BrickSlice& spline) {
  constexpr std::uint64_t kFiner = 8, kWithBorder = 2;  // 8^3 voxels a brick, and 9^3 in the march
  constexpr std::uint64_t kReach = 2;                   // beyond the stored bricks
  return spline.entries().size() * kFiner * kReach * (1 + kWithBorder) * BrickSlice::kVoxels *
         sizeof(float) * static_cast<std::uint64_t>(spline.channels());
}

}  // namespace volute
