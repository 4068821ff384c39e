// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/volume/volume_motion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include "volute/base/parallel.hpp"

namespace volute {
namespace {

constexpr int kIterations = 4;  ///< of a path's end: velocities change slowly from voxel to voxel
constexpr int kMotionSide = BrickSlice::kSide;
using VoxelPlace = VoxelPaths::Step;

/// Values of a frame between the centres of voxels; 0 outside.
class Between {
 public:
  explicit Between(const BrickSlice& slice)
      : slice_(slice), size_{slice.x(), slice.y(), slice.z()} {}

  /// @param at  [voxels], 0 at the centre of the first
  void read(const VoxelPlace& at, float* out) const {
    int first[3];
    float share[3];
    bool oneBrick = true;
    const int channels = slice_.channels();
    std::fill_n(out, channels, 0.0F);
    for (int axis = 0; axis < 3; ++axis) {
      if (!(at[axis] > -1 && at[axis] < static_cast<float>(size_[axis])))
        return;
      const float low = std::floor(at[axis]);
      first[axis] = static_cast<int>(low), share[axis] = at[axis] - low;
      oneBrick = oneBrick && (first[axis] & (kMotionSide - 1)) < kMotionSide - 1;
    }
    // Most are inside of a brick.
    const float* brick = nullptr;
    if (oneBrick) {
      const std::int32_t stored =
          slice_.brickAt(first[0] / kMotionSide, first[1] / kMotionSide, first[2] / kMotionSide);
      if (stored == BrickSlice::kEmpty)
        return;
      brick = slice_.brick(stored) + placeIn(first[0], first[1], first[2]);
    }
    for (int corner = 0; corner < 8; ++corner) {
      float weight = 1;
      int place[3];
      for (int axis = 2; axis >= 0; --axis) {
        const int side = corner >> axis & 1;
        place[axis] = first[axis] + side;
        weight *= side ? share[axis] : 1 - share[axis];
      }
      if (weight == 0)
        continue;
      const int step = (corner & 1) + (corner >> 1 & 1) * kMotionSide +
                       (corner >> 2) * kMotionSide * kMotionSide;
      for (int c = 0; c < channels; ++c) {
        out[c] += weight * (brick ? brick[c * BrickSlice::kVoxels + step]
                                  : slice_.value(place[0], place[1], place[2], c));
      }
    }
  }

  static int placeIn(int x, int y, int z) {
    return ((z % kMotionSide) * kMotionSide + y % kMotionSide) * kMotionSide + x % kMotionSide;
  }

 private:
  const BrickSlice& slice_;
  int size_[3];
};

/// Velocities between voxels.
class Flow {
 public:
  explicit Flow(const Velocities& velocities) {
    for (std::size_t i = 0; i < velocities.size(); ++i) {
      if (velocities[i])
        parts_.emplace_back(Between(*velocities[i]), i);
    }
  }

  VoxelPlace read(const VoxelPlace& at) const {
    VoxelPlace v{};
    for (const auto& [part, axis] : parts_) part.read(at, &v[axis]);
    return v;
  }

 private:
  std::vector<std::pair<Between, std::size_t>> parts_;
};

/// Calls body(brick, voxel in it, its place) for each voxel of the volume in some bricks.
template <class Body>
void forVoxels(const VolumeInfo& info, std::span<const BrickPlace> places, Body&& body) {
  parallelRanges(places.size(), 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      const int x0 = places[b][0] * kMotionSide, y0 = places[b][1] * kMotionSide,
                z0 = places[b][2] * kMotionSide;
      for (int z = z0; z < std::min(z0 + kMotionSide, info.z); ++z) {
        for (int y = y0; y < std::min(y0 + kMotionSide, info.y); ++y) {
          for (int x = x0; x < std::min(x0 + kMotionSide, info.x); ++x) {
            body(b, static_cast<std::size_t>(Between::placeIn(x, y, z)),
                 VoxelPlace{static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
          }
        }
      }
    }
  });
}

VoxelPlace sum(const VoxelPlace& a, const VoxelPlace& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

/// Maps the places of voxels.
class PlaceMap {
 public:
  explicit PlaceMap(const VoxelMap& map) : map_(map), identity_(map.isIdentity()) {}

  VoxelPlace operator()(const VoxelPlace& at) const {
    if (identity_)
      return at;
    const Vec3 place = map_.linear * Vec3(at[0], at[1], at[2]) + map_.offset;
    return {static_cast<float>(place[0]), static_cast<float>(place[1]),
            static_cast<float>(place[2])};
  }

 private:
  VoxelMap map_;
  bool identity_;
};

/// Adds the bricks of a volume into which those of `slices` reach, which lie in a frame.
/// @param toFrame  from the volume's voxels to that frame's
void addPlaces(const VolumeInfo& info, std::span<const std::shared_ptr<const BrickSlice>> slices,
               const VoxelMap& toFrame, std::vector<BrickPlace>& all) {
  const std::vector<BrickPlace> own = placesOf(slices);
  if (toFrame.isIdentity()) {
    all.insert(all.end(), own.begin(), own.end());
    return;
  }
  const VoxelMap back = toFrame.inverse();
  const BrickSlice shape(info);
  const int count[3] = {shape.bricksX(), shape.bricksY(), shape.bricksZ()};
  for (const BrickPlace& place : own) {
    Vec3 low = Vec3::Constant(1e9), high = -low;
    for (int corner = 0; corner < 8; ++corner) {
      Vec3 at;
      for (int axis = 0; axis < 3; ++axis)
        at[axis] = place[static_cast<std::size_t>(axis)] * kMotionSide +
                   (corner >> axis & 1 ? kMotionSide : -1);
      const Vec3 there = back.linear * at + back.offset;
      low = low.cwiseMin(there), high = high.cwiseMax(there);
    }
    int first[3], last[3];
    for (int axis = 0; axis < 3; ++axis) {
      const auto brick = [&](double at) {
        return static_cast<int>(std::floor(std::clamp(at, -1e8, 1e8) / kMotionSide));
      };
      first[axis] = std::max(brick(std::floor(low[axis])), 0);
      last[axis] = std::min(brick(std::ceil(high[axis])), count[axis] - 1);
    }
    for (int z = first[2]; z <= last[2]; ++z)
      for (int y = first[1]; y <= last[1]; ++y)
        for (int x = first[0]; x <= last[0]; ++x) all.push_back({x, y, z});
  }
}

void settle(std::vector<BrickPlace>& places) {
  std::ranges::sort(places, isBefore);
  places.erase(std::unique(places.begin(), places.end()), places.end());
}

float squareOf(const VoxelPlace& v) {
  return v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
}

VoxelPlace product(const MatN<float, 3, 3>& times, const VoxelPlace& v) {
  const VecN<float, 3> way = times * VecN<float, 3>(v[0], v[1], v[2]);
  return {way[0], way[1], way[2]};
}

/// A voxel at a time between two frames of which neither has a velocity there, and that of what
/// comes by: grids of velocities often end where the smoke does.
struct Passing {
  BrickPlace brick;
  std::size_t voxel = 0;
  VoxelPlace velocity{};
};

/// One frame's velocities, and the way to the time between [voxels of the frame].
struct Leaving {
  const Velocities& velocities;
  const VoxelMap& toFrame;  ///< from the volume's voxels
  MatN<float, 3, 3> step;
};

/// Around where what moves further than a voxel is at that time.
/// @param isStill  whether neither frame has a velocity at a place of the volume
template <class IsStill>
std::vector<Passing> passingBy(const VolumeInfo& info, const Leaving& frame,
                               const IsStill& isStill) {
  const auto places = placesOf(frame.velocities);
  const Flow flow(frame.velocities);
  const PlaceMap back(frame.toFrame.inverse());
  const int size[3] = {info.x, info.y, info.z};
  std::vector<std::vector<Passing>> found(places.size());
  const auto add = [&](std::vector<Passing>& into, const VoxelPlace& at,
                       const VoxelPlace& velocity) {
    for (int corner = 0; corner < 8; ++corner) {
      int place[3];
      bool inside = true;
      for (int axis = 0; axis < 3; ++axis) {
        const float low = std::floor(at[axis]);
        inside = inside && low >= -1 && low < static_cast<float>(size[axis]);
        place[axis] = inside ? static_cast<int>(low) + (corner >> axis & 1) : 0;
        inside = inside && place[axis] >= 0 && place[axis] < size[axis];
      }
      if (inside && isStill(VoxelPlace{static_cast<float>(place[0]), static_cast<float>(place[1]),
                                       static_cast<float>(place[2])}))
        into.push_back({{place[0] / kMotionSide, place[1] / kMotionSide, place[2] / kMotionSide},
                        static_cast<std::size_t>(Between::placeIn(place[0], place[1], place[2])),
                        velocity});
    }
  };
  parallelRanges(places.size(), 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t b = begin; b < end; ++b) {
      for (int voxel = 0; voxel < BrickSlice::kVoxels; ++voxel) {
        VoxelPlace at;
        for (int axis = 0; axis < 3; ++axis)
          at[axis] = static_cast<float>(places[b][static_cast<std::size_t>(axis)] * kMotionSide +
                                        (voxel >> 3 * axis) % kMotionSide);
        const VoxelPlace velocity = flow.read(at), way = product(frame.step, velocity);
        if (squareOf(way) <= 1)
          continue;
        const VoxelPlace there = back(sum(at, way));
        if (isStill(there))
          add(found[b], there, velocity);
      }
    }
  });
  std::vector<Passing> all;
  for (const auto& some : found) all.insert(all.end(), some.begin(), some.end());
  return all;
}

}  // namespace

std::vector<BrickPlace> placesOf(std::span<const std::shared_ptr<const BrickSlice>> slices) {
  std::vector<BrickPlace> places;
  std::size_t some = 0;
  for (const auto& slice : slices) {
    if (!slice || slice->entries().empty())
      continue;
    ++some;
    for (const BrickSlice::Entry& entry : slice->entries()) places.push_back(entry.place);
  }
  if (some > 1)
    settle(places);
  return places;
}

VoxelPaths pathsBetween(const VolumeInfo& info, const Velocities& before, const Velocities& after,
                        const Mat3& early, const Mat3& late, const BetweenFrames& between) {
  VoxelPaths paths;
  const Flow earlier(before), later(after);
  const PlaceMap toBefore(between.before), toAfter(between.after);
  const MatN<float, 3, 3> back = (-between.share * early).cast<float>(),
                          ahead = ((1 - between.share) * late).cast<float>();
  const auto isStill = [&](const VoxelPlace& place) {
    return squareOf(earlier.read(toBefore(place))) == 0 &&
           squareOf(later.read(toAfter(place))) == 0;
  };
  const std::array passing{passingBy(info, {before, between.before, -back}, isStill),
                           passingBy(info, {after, between.after, -ahead}, isStill)};
  addPlaces(info, before, between.before, paths.places);
  addPlaces(info, after, between.after, paths.places);
  for (const auto& some : passing)
    std::ranges::transform(some, std::back_inserter(paths.places), &Passing::brick);
  settle(paths.places);
  const BrickSlice shape(info);
  paths.table =
      BrickTable({shape.bricksX(), shape.bricksY(), shape.bricksZ()}, paths.places.size());
  for (std::size_t i = 0; i < paths.places.size(); ++i)
    paths.table.set(paths.places[i], static_cast<std::int32_t>(i));
  paths.from.resize(paths.places.size() * BrickSlice::kVoxels);
  paths.to.resize(paths.from.size());
  for (const auto& some : passing) {
    for (const Passing& one : some) {  // until the voxel's own way takes its place
      const auto brick = static_cast<std::size_t>(paths.table.at(one.brick));
      VoxelPlace& fastest = paths.from[brick * BrickSlice::kVoxels + one.voxel];
      if (squareOf(one.velocity) > squareOf(fastest))
        fastest = one.velocity;
    }
  }
  forVoxels(info, paths.places, [&](std::size_t brick, std::size_t voxel, const VoxelPlace& place) {
    const VoxelPlace atBefore = toBefore(place), atAfter = toAfter(place);
    const VoxelPlace a = earlier.read(atBefore), b = later.read(atAfter);
    VoxelPlace& from = paths.from[brick * BrickSlice::kVoxels + voxel];
    // What moves may not have come yet, or be in neither.
    const VoxelPlace passes = from;
    const VoxelPlace& own = squareOf(a) >= squareOf(b) ? a : b;
    const VoxelPlace& first = squareOf(own) > 0 ? own : passes;
    const auto follow = [&](const Flow& velocity, const VoxelPlace& at,
                            const MatN<float, 3, 3>& times) {
      VoxelPlace way = product(times, first);
      for (int i = 0; i < kIterations; ++i) way = product(times, velocity.read(sum(at, way)));
      return way;
    };
    from = follow(earlier, atBefore, back);
    paths.to[brick * BrickSlice::kVoxels + voxel] = follow(later, atAfter, ahead);
  });
  return paths;
}

namespace {

/// Sums of squares: of what differs, and of the values.
struct Misfit {
  double wrong = 0, all = 0;
};

/// Of the voxels of one frame, each moved into the other.
/// @param step  from a velocity to the way to the other frame, in this one's voxels
/// @param toOther  from this frame's voxels to the other's
Misfit misfitOf(const BrickSlice& one, const BrickSlice& other, const Velocities& velocities,
                const Mat3& step, const VoxelMap& toOther) {
  constexpr std::size_t kMaxBricks = 128;
  const auto entries = one.entries();
  const std::size_t count = std::min(entries.size(), kMaxBricks);
  const Flow flow(velocities);
  const Between there(other);
  const PlaceMap map(toOther);
  const MatN<float, 3, 3> way = step.cast<float>();
  std::vector<Misfit> sums(count);
  parallelRanges(count, 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const BrickSlice::Entry& entry = entries[i * entries.size() / count];
      const float* values = one.brick(entry.stored);
      for (int voxel = 0; voxel < BrickSlice::kVoxels; ++voxel) {
        VoxelPlace at;
        for (int axis = 0; axis < 3; ++axis)
          at[axis] = static_cast<float>(entry.place[axis] * kMotionSide +
                                        (voxel >> 3 * axis) % kMotionSide);
        const VoxelPlace v = flow.read(at);
        const VecN<float, 3> moved = way * VecN<float, 3>(v[0], v[1], v[2]);
        float found[3];
        there.read(map(sum(at, {moved[0], moved[1], moved[2]})), found);
        for (int c = 0; c < one.channels(); ++c) {
          const double value = values[c * BrickSlice::kVoxels + voxel];
          sums[i].wrong += (value - found[c]) * (value - found[c]);
          sums[i].all += value * value;
        }
      }
    }
  });
  Misfit total;
  for (const Misfit& some : sums) total.wrong += some.wrong, total.all += some.all;
  return total;
}

}  // namespace

double misfit(const BrickSlice& before, const BrickSlice& after, const Velocities& vBefore,
              const Velocities& vAfter, const Mat3& early, const Mat3& late,
              const BetweenFrames& between) {
  const VoxelMap back = between.before.inverse();
  const VoxelMap onward{between.after.linear * back.linear,
                        between.after.linear * back.offset + between.after.offset};
  const Misfit forwards = misfitOf(before, after, vBefore, early, onward);
  const Misfit backwards = misfitOf(after, before, vAfter, -late, onward.inverse());
  const double all = forwards.all + backwards.all;
  return all > 0 ? std::sqrt((forwards.wrong + backwards.wrong) / all) : 0;
}

BrickSlice blendFrames(const VolumeInfo& info, const BrickSlice& before, const BrickSlice& after,
                       const BetweenFrames& between, const VoxelPaths* paths) {
  const auto late = static_cast<float>(between.share), early = 1 - late;
  const auto alias = [](const BrickSlice& slice) {
    return std::shared_ptr<const BrickSlice>(std::shared_ptr<void>(), &slice);
  };
  std::vector<BrickPlace> places;
  addPlaces(info, std::array{alias(before)}, between.before, places);
  addPlaces(info, std::array{alias(after)}, between.after, places);
  if (paths)
    places.insert(places.end(), paths->places.begin(), paths->places.end());
  settle(places);
  BrickSlice out(info, places);
  const int channels = info.channels;
  const Between a(before), b(after);
  const PlaceMap toBefore(between.before), toAfter(between.after);
  forVoxels(info, places, [&](std::size_t brick, std::size_t voxel, const VoxelPlace& place) {
    const std::int32_t path = paths ? paths->table.at(places[brick]) : BrickTable::kEmpty;
    float from[3], to[3];
    const VoxelPlace atBefore = toBefore(place), atAfter = toAfter(place);
    if (path >= 0) {
      const std::size_t at = static_cast<std::size_t>(path) * BrickSlice::kVoxels + voxel;
      a.read(sum(atBefore, paths->from[at]), from);
      b.read(sum(atAfter, paths->to[at]), to);
    } else {
      a.read(atBefore, from);
      b.read(atAfter, to);
    }
    float* values = out.brick(static_cast<std::int32_t>(brick)) + voxel;
    for (int c = 0; c < channels; ++c)
      values[c * BrickSlice::kVoxels] = early * from[c] + late * to[c];
  });
  out.dropEmpty();
  return out;
}

}  // namespace volute
