// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/resample.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <unordered_map>
#include <unordered_set>

#include "volute/base/parallel.hpp"
#include "volute/grid/rounding_source.hpp"

namespace volute {
namespace {

constexpr double kWhole = 1e-6;  // voxels; this near a voxel's centre it is that
constexpr int kMaxParts = 16;

struct IndexHash {
  std::size_t operator()(const VoxelIndex& at) const {
    std::uint64_t hash = 0;
    for (const std::int64_t i : at)
      hash = (hash ^ static_cast<std::uint64_t>(i)) * 0x9E3779B97F4A7C15u;
    return static_cast<std::size_t>(hash ^ hash >> 32);
  }
};

std::int64_t floorOf(std::int64_t i, std::int64_t side) {
  return (i >= 0 ? i : i - side + 1) / side;
}

/// Finds the value of any voxel.
class VoxelFinder {
 public:
  /// Where the last one was found, which most others are too.
  struct Last {
    IndexBox box{};
    std::ptrdiff_t leaf = -1;      ///< -1: all of `box` has one value
    const float* value = nullptr;  ///< that one
    bool active = false;
  };

  explicit VoxelFinder(const Bricks& bricks) : bricks_(bricks) {
    for (std::size_t i = 0; i < bricks.leaves().size(); ++i)
      place(bricks.leaves()[i].origin, Bricks::kSide, static_cast<std::ptrdiff_t>(i));
    for (std::size_t i = 0; i < bricks.tiles().size(); ++i)
      place(bricks.tiles()[i].origin, bricks.tiles()[i].side, -1 - static_cast<std::ptrdiff_t>(i));
  }

  /// Adds weight times a voxel's value; whether it is active.
  bool add(const VoxelIndex& at, double weight, double* out, Last& last) const {
    if (!last.box.contains(at))
      find(at, last);
    const int channels = bricks_.channels();
    if (last.leaf < 0) {
      for (int c = 0; c < channels; ++c) out[c] += weight * last.value[c];
      return last.active;
    }
    const auto index = static_cast<std::size_t>(last.leaf);
    const auto z = static_cast<std::size_t>(at[2] - last.box.begin[2]);
    const auto bit = static_cast<std::size_t>((at[1] - last.box.begin[1]) * Bricks::kSide + at[0] -
                                              last.box.begin[0]);
    const float* values = bricks_.values(index).data() + 64 * z + bit;
    for (int c = 0; c < channels; ++c)
      out[c] += weight * values[static_cast<std::ptrdiff_t>(c) * Bricks::kVoxels];
    const Bricks::Leaf& leaf = bricks_.leaves()[index];
    return (leaf.valued[z] >> bit & 1) != 0 ? leaf.active[z] >> bit & 1 : isInActiveTile(at);
  }

 private:
  /// Cubes of one size, as far from multiples of it.
  struct Level {
    std::int64_t side;
    VoxelIndex phase;
    std::unordered_map<VoxelIndex, std::ptrdiff_t, IndexHash> cubes{};
  };

  VoxelIndex cubeOf(const Level& level, const VoxelIndex& at) const {
    VoxelIndex cube;
    for (std::size_t a = 0; a < 3; ++a) cube[a] = floorOf(at[a] - level.phase[a], level.side);
    return cube;
  }

  void place(const VoxelIndex& origin, std::int64_t side, std::ptrdiff_t what) {
    VoxelIndex phase;
    for (std::size_t a = 0; a < 3; ++a) phase[a] = origin[a] - floorOf(origin[a], side) * side;
    auto level = std::ranges::find_if(
        levels_, [&](const Level& one) { return one.side == side && one.phase == phase; });
    if (level == levels_.end())
      level = levels_.insert(levels_.end(), {side, phase});
    level->cubes[cubeOf(*level, origin)] = what;
  }

  /// Leaves may reach into tiles, see Bricks.
  bool isInActiveTile(const VoxelIndex& at) const {
    return !bricks_.tiles().empty() && std::ranges::any_of(levels_, [&](const Level& level) {
      const auto found = level.cubes.find(cubeOf(level, at));
      return found != level.cubes.end() && found->second < 0 &&
             bricks_.tiles()[static_cast<std::size_t>(-1 - found->second)].active;
    });
  }

  void find(const VoxelIndex& at, Last& last) const {
    for (const Level& level : levels_) {
      const auto found = level.cubes.find(cubeOf(level, at));
      if (found == level.cubes.end())
        continue;
      last.leaf = found->second;
      if (last.leaf >= 0) {
        const VoxelIndex& o = bricks_.leaves()[static_cast<std::size_t>(last.leaf)].origin;
        last.box = {o, {o[0] + Bricks::kSide, o[1] + Bricks::kSide, o[2] + Bricks::kSide}};
      } else {
        const Bricks::Tile& tile = bricks_.tiles()[static_cast<std::size_t>(-1 - last.leaf)];
        last = {tile.box(), -1, tile.value.data(), tile.active};
      }
      return;
    }
    last = {{at, {at[0] + 1, at[1] + 1, at[2] + 1}}, -1, bricks_.background().data(), false};
  }

  const Bricks& bricks_;
  std::vector<Level> levels_;
};

/// How far the basis of a voxel reaches from its centre [voxels].
double reachOf(Basis basis) {
  return basis == Basis::kBox ? 0.5 : basis == Basis::kTrilinear ? 1 : 2;
}

/// What the basis functions along an axis are at a place: of voxels from `first` on.
struct AxisBasis {
  std::int64_t first = 0;
  int count = 1;
  std::array<double, 4> weights{1, 0, 0, 0};

  AxisBasis(Basis basis, double at) {
    const double nearest = std::round(at);
    if (basis == Basis::kBox) {
      first = static_cast<std::int64_t>(std::floor(at + 0.5));
      return;
    }
    if (basis == Basis::kTrilinear) {
      first = static_cast<std::int64_t>(std::abs(at - nearest) < kWhole ? nearest : std::floor(at));
      const double t = at - static_cast<double>(first);
      if (t > kWhole)
        count = 2, weights = {1 - t, t, 0, 0};
      return;
    }
    const double low = std::floor(at), t = at - low, u = 1 - t;
    first = static_cast<std::int64_t>(low) - 1, count = 4;
    weights = {u * u * u / 6, (4 - 6 * t * t + 3 * t * t * t) / 6,
               (4 - 6 * u * u + 3 * u * u * u) / 6, t * t * t / 6};
  }
};

/// Adds weight times the basis at a place [old voxels]; whether an active voxel counts.
bool addSample(const VoxelFinder& finder, Basis basis, const Vec3& at, double weight, double* out,
               VoxelFinder::Last& last) {
  const AxisBasis x(basis, at.x()), y(basis, at.y()), z(basis, at.z());
  bool active = false;
  for (int k = 0; k < z.count; ++k) {
    for (int j = 0; j < y.count; ++j) {
      const double both =
          weight * z.weights[static_cast<std::size_t>(k)] * y.weights[static_cast<std::size_t>(j)];
      for (int i = 0; i < x.count; ++i) {
        const double w = both * x.weights[static_cast<std::size_t>(i)];
        if (w > 0)
          active |=
              finder.add({x.first + i, y.first + j, z.first + k}, static_cast<float>(w), out, last);
      }
    }
  }
  return active;
}

/// The new bricks into which something reaches, within a box.
class ReachedBricks {
 public:
  ReachedBricks(const LatticeMap& map, const IndexBox& box, double reach, std::uint64_t maxMemory)
      : map_(map), box_(box), reach_(reach), most_(maxMemory / kEntryBytes) {}

  /// Whether there is memory for them.
  bool add(const IndexBox& old) {
    constexpr double kFarthest = 1e12;
    Vec3 low = Vec3::Constant(kFarthest), high = -low;
    for (int corner = 0; corner < 8; ++corner) {
      Vec3 at;
      for (int a = 0; a < 3; ++a) {
        const auto axis = static_cast<std::size_t>(a);
        at[a] = corner >> a & 1 ? static_cast<double>(old.end[axis] - 1) + reach_
                                : static_cast<double>(old.begin[axis]) - reach_;
      }
      const Vec3 place = map_.toNew(at);
      low = low.cwiseMin(place), high = high.cwiseMax(place);
    }
    IndexBox bricks;
    double count = 1;
    for (std::size_t a = 0; a < 3; ++a) {
      // Half a voxel for the parts of new ones.
      const auto begin =
          static_cast<std::int64_t>(std::floor(std::clamp(low[a] - 0.5, -kFarthest, kFarthest)));
      const auto end =
          static_cast<std::int64_t>(std::ceil(std::clamp(high[a] + 0.5, -kFarthest, kFarthest)));
      const auto first = std::max(begin, box_.begin[a]), last = std::min(end, box_.end[a] - 1);
      if (first > last)
        return true;
      bricks.begin[a] = floorOf(first, Bricks::kSide);
      bricks.end[a] = floorOf(last, Bricks::kSide) + 1;
      count *= static_cast<double>(bricks.size(static_cast<int>(a)));
    }
    if (count > static_cast<double>(most_))
      return false;
    for (auto z = bricks.begin[2]; z < bricks.end[2]; ++z)
      for (auto y = bricks.begin[1]; y < bricks.end[1]; ++y)
        for (auto x = bricks.begin[0]; x < bricks.end[0]; ++x) places_.insert({x, y, z});
    return places_.size() <= most_;
  }

  std::vector<VoxelIndex> places() const { return {places_.begin(), places_.end()}; }

 private:
  static constexpr std::uint64_t kEntryBytes = 64;

  const LatticeMap& map_;
  IndexBox box_;
  double reach_;
  std::uint64_t most_;
  std::unordered_set<VoxelIndex, IndexHash> places_;
};

/// How many parts a new voxel has along each axis, at a place.
std::array<int, 3> partsAt(const LatticeMap& map, const Vec3& at) {
  std::array<int, 3> parts{};
  for (int a = 0; a < 3; ++a) {
    const Vec3 half = 0.5 * Vec3::Unit(a);
    const double length = (map.toOld(at + half) - map.toOld(at - half)).norm();
    parts[static_cast<std::size_t>(a)] =
        std::isfinite(length)
            ? std::clamp(static_cast<int>(std::ceil(std::min(length, 1e3) - 1e-3)), 1, kMaxParts)
            : 1;
  }
  return parts;
}

/// One new brick, without values where nothing is in it.
struct NewBrick {
  Bricks::Leaf leaf{};
  std::vector<float> values{};
};

NewBrick sampleBrick(const VoxelFinder& finder, const LatticeMap& map, const IndexBox& box,
                     Basis basis, Components components, const Bricks& old,
                     const VoxelIndex& place) {
  NewBrick made;
  const auto channels = static_cast<std::size_t>(old.channels());
  for (std::size_t a = 0; a < 3; ++a) made.leaf.origin[a] = place[a] * Bricks::kSide;
  const BrickMask inside = maskInside(made.leaf.origin, box);
  VoxelFinder::Last last;
  bool any = false;
  std::vector<float> values(channels * Bricks::kVoxels);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = old.background()[i / static_cast<std::size_t>(Bricks::kVoxels)];
  for (std::size_t v = 0; v < static_cast<std::size_t>(Bricks::kVoxels); ++v) {
    const std::size_t z = v / 64, bit = v % 64;
    if ((inside[z] >> bit & 1) == 0)
      continue;
    const Vec3 centre(static_cast<double>(made.leaf.origin[0]) + static_cast<double>(bit % 8),
                      static_cast<double>(made.leaf.origin[1]) + static_cast<double>(bit / 8),
                      static_cast<double>(made.leaf.origin[2]) + static_cast<double>(z));
    const auto parts = partsAt(map, centre);
    const double weight = 1.0 / (parts[0] * parts[1] * parts[2]);
    double sum[3] = {};
    bool active = false;
    for (int k = 0; k < parts[2]; ++k) {
      for (int j = 0; j < parts[1]; ++j) {
        for (int i = 0; i < parts[0]; ++i) {
          const Vec3 part = centre +
                            Vec3((i + 0.5) / parts[0], (j + 0.5) / parts[1], (k + 0.5) / parts[2]) -
                            Vec3::Constant(0.5);
          const Vec3 at = map.toOld(part);
          // Beyond what can be counted nothing is.
          if (!(at.cwiseAbs().maxCoeff() < 1e12)) {
            for (std::size_t c = 0; c < channels; ++c) sum[c] += weight * old.background()[c];
            continue;
          }
          if (components == Components::kAtCentres) {
            active |= addSample(finder, basis, at, weight, sum, last);
            continue;
          }
          for (std::size_t c = 0; c < channels; ++c) {
            const Vec3 half = 0.5 * Vec3::Unit(static_cast<int>(c));
            const Vec3 face = components == Components::kAtFaces ? map.toOld(part - half) : at;
            double all[3] = {};
            active |= addSample(finder, basis, face + half, weight, all, last);
            sum[c] += all[c];
          }
        }
      }
    }
    bool valued = active;
    for (std::size_t c = 0; c < channels; ++c)
      valued = valued || static_cast<float>(sum[c]) != old.background()[c];
    if (!valued)
      continue;
    any = true;
    made.leaf.valued[z] |= std::uint64_t{1} << bit;
    made.leaf.active[z] |= std::uint64_t{active} << bit;
    for (std::size_t c = 0; c < channels; ++c)
      values[c * Bricks::kVoxels + v] = static_cast<float>(sum[c]);
  }
  if (any)
    made.values = std::move(values);
  return made;
}

VoxelsCut cutOf(const Bricks& bricks, const LatticeMap& map, const IndexBox& box) {
  const auto isInside = [&](const VoxelIndex& at) {
    const Vec3 place = map.toNew(
        Vec3(static_cast<double>(at[0]), static_cast<double>(at[1]), static_cast<double>(at[2])));
    for (std::size_t a = 0; a < 3; ++a) {
      const double index = place[a] + 0.5;
      if (!(index > static_cast<double>(box.begin[a]) - kWhole &&
            index < static_cast<double>(box.end[a]) + kWhole))
        return false;
    }
    return true;
  };
  // A cube is convex, and so is the box: what has its corners inside is inside.
  const auto cubeIsInside = [&](const VoxelIndex& origin, std::int64_t side) {
    for (int corner = 0; corner < 8; ++corner) {
      VoxelIndex at = origin;
      for (std::size_t a = 0; a < 3; ++a) at[a] += (corner >> a & 1) * (side - 1);
      if (!isInside(at))
        return false;
    }
    return true;
  };
  constexpr auto kSide = static_cast<std::size_t>(Bricks::kSide);
  VoxelsCut cut;
  for (std::size_t i = 0; i < bricks.leaves().size(); ++i) {
    const Bricks::Leaf& leaf = bricks.leaves()[i];
    const bool inside = cubeIsInside(leaf.origin, Bricks::kSide);
    const auto values = bricks.values(i);
    for (std::size_t v = 0; v < kSide * kSide * kSide; ++v) {
      bool differs = false;
      for (std::size_t c = 0; c < static_cast<std::size_t>(bricks.channels()); ++c)
        differs |= values[c * kSide * kSide * kSide + v] != bricks.background()[c];
      if (!differs)
        continue;
      ++cut.all;
      const VoxelIndex at{leaf.origin[0] + static_cast<std::int64_t>(v % kSide),
                          leaf.origin[1] + static_cast<std::int64_t>(v / kSide % kSide),
                          leaf.origin[2] + static_cast<std::int64_t>(v / (kSide * kSide))};
      cut.outside += inside || isInside(at) ? 0 : 1;
    }
  }
  for (const Bricks::Tile& tile : bricks.tiles()) {
    if (std::equal(tile.value.begin(), tile.value.begin() + bricks.channels(),
                   bricks.background().begin()))
      continue;
    // By blocks of voxels, at most 16 along each axis.
    const std::int64_t step = std::max<std::int64_t>(1, tile.side / 16);
    const auto voxels = static_cast<std::uint64_t>(step * step * step);
    cut.all += static_cast<std::uint64_t>(tile.side * tile.side * tile.side);
    if (cubeIsInside(tile.origin, tile.side))
      continue;
    for (std::int64_t z = step / 2; z < tile.side; z += step)
      for (std::int64_t y = step / 2; y < tile.side; y += step)
        for (std::int64_t x = step / 2; x < tile.side; x += step) {
          const VoxelIndex at{tile.origin[0] + x, tile.origin[1] + y, tile.origin[2] + z};
          cut.outside += isInside(at) ? 0 : voxels;
        }
  }
  return cut;
}

class ResampledSource final : public RoundingSource {
 public:
  ResampledSource(std::unique_ptr<FrameSource> source, std::vector<GridMatrix> places,
                  const Lattice& lattice, Basis basis, std::uint64_t maxMemory,
                  std::vector<Mat3> turns, std::function<void(int, const VoxelsCut&)> onCut,
                  Components components)
      : source_(std::move(source)),
        places_(std::move(places)),
        lattice_(lattice),
        basis_(basis),
        maxMemory_(maxMemory),
        turns_(std::move(turns)),
        onCut_(std::move(onCut)),
        components_(components),
        info_(source_->info()) {
    info_.x = static_cast<int>(lattice.box.size(0));
    info_.y = static_cast<int>(lattice.box.size(1));
    info_.z = static_cast<int>(lattice.box.size(2));
    const GridSpace space = spaceOf(lattice.indexToWorld);
    for (std::size_t a = 0; a < 3; ++a) {
      const auto face = [&](std::int64_t index) {
        return space.origin[a] + (static_cast<double>(index) - 0.5) * space.voxelSize[a];
      };
      info_.bounds.min[a] = face(lattice.box.begin[a]);
      info_.bounds.max[a] = face(lattice.box.end[a]);
    }
  }

  const VolumeInfo& info() const override { return info_; }

  Status readFrame(int index, std::span<float> values) override {
    return readLayers(index, 0, info_.z, values);
  }

  Status readLayers(int index, int first, int end, std::span<float> values) override {
    Bricks bricks;
    VOLUTE_TRY(readBricks(index, first, end, bricks));
    bricks.toDense({{0, 0, first}, {info_.x, info_.y, end}}, values);
    return {};
  }

  Status readBricks(int index, int first, int end, Bricks& bricks) override {
    VOLUTE_TRY(source_->readBricks(index, 0, source_->info().z, bricks));
    const auto frame = static_cast<std::size_t>(index);
    const AffineLattices map(indexToWorld(source_->info(), places_, frame), lattice_.indexToWorld);
    if (onCut_ && first == 0)
      onCut_(index, cutOf(bricks, map, lattice_.box));
    IndexBox box = lattice_.box;
    box.begin[2] = lattice_.box.begin[2] + first, box.end[2] = lattice_.box.begin[2] + end;
    const auto moved = wholeVoxels(map);
    if (moved && components_ != Components::kFacesToCentres) {
      bricks.shift(*moved);
      bricks.crop(box);
    } else {
      bricks.sort();
      auto made = resampled(bricks, map, box, basis_, maxMemory_, components_);
      if (!made) {
        return fail(made.error().code, made.error().hints, "'{}', frame {}: {}", info_.name,
                    info_.frameText(frame), made.error().message);
      }
      bricks = *std::move(made);
    }
    if (!turns_.empty() && bricks.channels() == 3)
      turnVectors(bricks, turns_[frame]);
    bricks.shift({-lattice_.box.begin[0], -lattice_.box.begin[1], -lattice_.box.begin[2]});
    bricks.sort();
    return {};
  }

  std::vector<std::string> otherGrids() const override { return source_->otherGrids(); }

  bool hasTopology() const override { return source_->hasTopology(); }

  /// About, where voxels are others.
  std::uint64_t brickBytes() const override {
    const Mat3 linear = linearOf(indexToWorld(source_->info(), places_, 0)).inverse() *
                        linearOf(lattice_.indexToWorld);
    const double times = 2 / std::abs(linear.determinant());
    const std::uint64_t dense = FrameSource::brickBytes(), old = source_->brickBytes();
    if (linear.isApprox(Mat3::Identity(), 1e-6))
      return std::min(dense, old);
    return static_cast<std::uint64_t>(
        std::min(static_cast<double>(dense), times * static_cast<double>(old)));
  }

  double rounding() const override { return roundingOf(*source_); }

  double offset() const override { return offsetOf(*source_); }

 private:
  /// From an old index to the new one, where that is a whole number of voxels.
  std::optional<VoxelIndex> wholeVoxels(const AffineLattices& map) const {
    const VolumeInfo& old = source_->info();
    const double longest = std::max({old.x, old.y, old.z, info_.x, info_.y, info_.z});
    const Vec3 moved = map.toNew(Vec3::Zero());
    if (!((map.linear() - Mat3::Identity()).cwiseAbs().maxCoeff() * longest < 1e-3) ||
        !(moved.cwiseAbs().maxCoeff() < 1e9))
      return std::nullopt;
    VoxelIndex by;
    for (std::size_t a = 0; a < 3; ++a) {
      const double along = moved[a];
      by[a] = std::llround(along);
      if (std::abs(along - std::round(along)) > 1e-3)
        return std::nullopt;
    }
    return by;
  }

  static void turnVectors(Bricks& bricks, const Mat3& turn) {
    Bricks turned(3, bricks.background());
    turned.reserve(bricks.leaves().size(), bricks.tiles().size());
    for (Bricks::Tile tile : bricks.tiles()) {
      const Vec3 v = turn * Vec3(tile.value[0], tile.value[1], tile.value[2]);
      tile.value = {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2])};
      turned.addTile(tile);
    }
    for (std::size_t i = 0; i < bricks.leaves().size(); ++i) {
      const std::span<const float> from = bricks.values(i);
      const std::span<float> to = turned.addLeaf(bricks.leaves()[i]);
      constexpr auto kPlane = static_cast<std::size_t>(Bricks::kVoxels);
      for (std::size_t v = 0; v < kPlane; ++v) {
        const Vec3 one = turn * Vec3(from[v], from[kPlane + v], from[2 * kPlane + v]);
        for (std::size_t c = 0; c < 3; ++c) to[c * kPlane + v] = static_cast<float>(one[c]);
      }
    }
    bricks = std::move(turned);
  }

  std::unique_ptr<FrameSource> source_;
  std::vector<GridMatrix> places_;
  Lattice lattice_;
  Basis basis_;
  std::uint64_t maxMemory_;
  std::vector<Mat3> turns_;
  std::function<void(int, const VoxelsCut&)> onCut_;
  Components components_;
  VolumeInfo info_;
};

}  // namespace

Result<Bricks> resampled(const Bricks& bricks, const LatticeMap& map, const IndexBox& box,
                         Basis basis, std::uint64_t maxMemory, Components components) {
  const auto tooLarge = [&] {
    return fail(ErrorCode::kTooLarge,
                {Hint::raise("voxel_size"), Hint::set("bounds"), Hint::raise("max_memory")},
                "on the new lattice it takes more than the {} MiB of memory allowed",
                maxMemory >> 20);
  };
  // A face of an old voxel may be that of a new one beside it.
  const double aside = components == Components::kAtCentres ? 0 : 1;
  ReachedBricks reached(map, box, reachOf(basis) + aside, maxMemory);
  for (const Bricks::Leaf& leaf : bricks.leaves()) {
    const VoxelIndex& o = leaf.origin;
    if (!reached.add({o, {o[0] + Bricks::kSide, o[1] + Bricks::kSide, o[2] + Bricks::kSide}}))
      return tooLarge();
  }
  for (const Bricks::Tile& tile : bricks.tiles()) {
    if (!reached.add(tile.box()))
      return tooLarge();
  }
  const auto places = reached.places();
  const VoxelFinder finder(bricks);
  Bricks all(bricks.channels(), bricks.background());
  constexpr std::size_t kAtOnce = 4096;
  std::vector<NewBrick> made;
  for (std::size_t first = 0; first < places.size(); first += kAtOnce) {
    made.assign(std::min(kAtOnce, places.size() - first), {});
    parallelRanges(made.size(), 8, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        made[i] = sampleBrick(finder, map, box, basis, components, bricks, places[first + i]);
    });
    for (const NewBrick& brick : made) {
      if (!brick.values.empty())
        std::ranges::copy(brick.values, all.addLeaf(brick.leaf).begin());
    }
    if (all.bytes() > maxMemory)
      return tooLarge();
  }
  all.sort();
  return all;
}

std::unique_ptr<FrameSource> resampleTo(std::unique_ptr<FrameSource> source,
                                        std::vector<GridMatrix> places, const Lattice& lattice,
                                        Basis basis, std::uint64_t maxMemory,
                                        std::vector<Mat3> turns,
                                        std::function<void(int, const VoxelsCut&)> onCut,
                                        Components components) {
  return std::make_unique<ResampledSource>(std::move(source), std::move(places), lattice, basis,
                                           maxMemory, std::move(turns), std::move(onCut),
                                           components);
}

GridMatrix indexToWorld(const VolumeInfo& info, const std::vector<GridMatrix>& places,
                        std::size_t frame) {
  const Vec3 voxel = info.voxelSize(), origin = info.bounds.min + 0.5 * voxel;
  if (places.empty())
    return gridMatrix(voxel.asDiagonal(), origin);
  const Mat3 linear = linearOf(places[frame]);
  return gridMatrix(linear * voxel.asDiagonal(), linear * origin + offsetOf(places[frame]));
}

}  // namespace volute
