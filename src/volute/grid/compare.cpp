// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/compare.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <tuple>
#include <vector>

#include "volute/base/assert.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/grid/rounding_source.hpp"
#include "volute/grid/value_histogram.hpp"

namespace volute {
namespace {

constexpr std::int64_t kSmallCube = 2 * Bricks::kSide;  // compared voxel by voxel
constexpr std::size_t kFewTiles = 64;

double errorBetween(float a, float b, double apart) {
  if ((a == b && apart == 0) || (std::isnan(a) && std::isnan(b)))
    return 0;
  const double error = std::abs(static_cast<double>(b) - a - apart);
  return std::isnan(error) ? std::numeric_limits<double>::infinity() : error;
}

std::string sizeText(const VolumeInfo& info) {
  return fmt::format("{} frame{} of {} x {} x {} voxels with {} channel{}", info.frames,
                     info.frames == 1 ? "" : "s", info.x, info.y, info.z, info.channels,
                     info.channels == 1 ? "" : "s");
}

/// A frame, and what of it reaches into a cube.
struct FramePart {
  const Bricks* frame;
  std::vector<std::uint32_t> leaves{}, tiles{};

  static FramePart all(const Bricks& frame) {
    FramePart part{&frame};
    part.leaves.resize(frame.leaves().size()), part.tiles.resize(frame.tiles().size());
    std::iota(part.leaves.begin(), part.leaves.end(), 0U);
    std::iota(part.tiles.begin(), part.tiles.end(), 0U);
    return part;
  }

  FramePart within(const IndexBox& box) const {
    FramePart part{frame};
    for (const std::uint32_t leaf : leaves) {
      if (!leafBox(leaf).intersection(box).empty())
        part.leaves.push_back(leaf);
    }
    for (const std::uint32_t tile : tiles) {
      if (!frame->tiles()[tile].box().intersection(box).empty())
        part.tiles.push_back(tile);
    }
    return part;
  }

  /// Whether all of a box is one tile, the last one, or background.
  bool isUniform(const IndexBox& box) const {
    return leaves.empty() && std::ranges::all_of(tiles, [&](std::uint32_t tile) {
             return frame->tiles()[tile].box().contains(box);
           });
  }

  const std::array<float, 3>& uniform() const {
    return tiles.empty() ? frame->background() : frame->tiles()[tiles.back()].value;
  }

  bool uniformIsSupport() const {
    return !tiles.empty() &&
           (frame->tiles()[tiles.back()].active || uniform() != frame->background());
  }

  /// Values of a small box, shape (c, z, y, x), and which voxels are of the support.
  void fill(const IndexBox& box, std::vector<float>& values,
            std::vector<std::uint8_t>& support) const {
    const auto voxels = static_cast<std::size_t>(voxelsIn(box));
    const auto channels = static_cast<std::size_t>(frame->channels());
    support.assign(voxels, 0);
    values.clear();
    for (std::size_t c = 0; c < channels; ++c)
      values.resize(values.size() + voxels, frame->background()[c]);
    const auto visit = [&](const IndexBox& part, auto&& voxel) {
      for (auto z = part.begin[2]; z < part.end[2]; ++z)
        for (auto y = part.begin[1]; y < part.end[1]; ++y)
          for (auto x = part.begin[0]; x < part.end[0]; ++x)
            voxel(static_cast<std::size_t>(((z - box.begin[2]) * box.size(1) + y - box.begin[1]) *
                                               box.size(0) +
                                           x - box.begin[0]),
                  x, y, z);
    };
    for (const std::uint32_t t : tiles) {
      const Bricks::Tile& tile = frame->tiles()[t];
      const bool counts = tile.active || tile.value != frame->background();
      visit(tile.box().intersection(box), [&](std::size_t to, auto, auto, auto) {
        for (std::size_t c = 0; c < channels; ++c) values[c * voxels + to] = tile.value[c];
        support[to] = counts;
      });
    }
    for (const std::uint32_t l : leaves) {
      const Bricks::Leaf& leaf = frame->leaves()[l];
      const std::span<const float> from = frame->values(l);
      visit(leafBox(l).intersection(box), [&](std::size_t to, auto x, auto y, auto z) {
        const auto bit =
            static_cast<std::size_t>((y - leaf.origin[1]) * Bricks::kSide + x - leaf.origin[0]);
        const auto layer = static_cast<std::size_t>(z - leaf.origin[2]);
        for (std::size_t c = 0; c < channels; ++c)
          values[c * voxels + to] = from[c * Bricks::kVoxels + 64 * layer + bit];
        support[to] |= leaf.valued[layer] >> bit & 1;  // else what a tile there says
      });
    }
  }

 private:
  IndexBox leafBox(std::uint32_t leaf) const {
    const VoxelIndex& o = frame->leaves()[leaf].origin;
    return {o, {o[0] + Bricks::kSide, o[1] + Bricks::kSide, o[2] + Bricks::kSide}};
  }
};

/// A plane across an axis.
struct Cut {
  std::size_t axis = 0;
  std::int64_t at = 0;
};

/// The face of a tile that cuts a box most evenly; there is one where isUniform() is not.
Cut faceThrough(const IndexBox& box, const FramePart& a, const FramePart& b) {
  Cut best;
  double evenness = -1;
  for (const FramePart* part : {&a, &b}) {
    for (const std::uint32_t tile : part->tiles) {
      const IndexBox faces = part->frame->tiles()[tile].box();
      for (std::size_t axis = 0; axis < 3; ++axis) {
        for (const std::int64_t at : {faces.begin[axis], faces.end[axis]}) {
          const auto before = static_cast<double>(at - box.begin[axis]),
                     after = static_cast<double>(box.end[axis] - at);
          const double share = std::min(before, after) / (before + after);
          if (before > 0 && after > 0 && share > evenness)
            best = {axis, at}, evenness = share;
        }
      }
    }
  }
  VOLUTE_ASSERT(evenness > 0);
  return best;
}

/// Two frames, by cubes that are cut in eight until they are alike all over, or small, or hold
/// nothing but a few tiles, which cut them then.
class FrameComparison {
 public:
  FrameComparison(const IndexBox& whole, int channels, double apart, ValueHistogram& histogram)
      : whole_(whole),
        channels_(static_cast<std::size_t>(channels)),
        apart_(apart),
        histogram_(histogram) {}

  Difference run(const Bricks& a, const Bricks& b) {
    std::int64_t side = kSmallCube;
    for (int axis = 0; axis < 3; ++axis) {
      while (side < whole_.end[static_cast<std::size_t>(axis)]) side *= 2;
    }
    for (std::size_t c = 0; c < channels_; ++c) {
      const bool same = static_cast<double>(a.background()[c]) + apart_ == b.background()[c];
      sum_.backgroundsDiffer = sum_.backgroundsDiffer || !same;
    }
    visit({{0, 0, 0}, {side, side, side}}, FramePart::all(a), FramePart::all(b));
    return sum_;
  }

 private:
  void visit(const IndexBox& cube, const FramePart& a, const FramePart& b) {
    const IndexBox box = cube.intersection(whole_);
    if (box.empty())
      return;
    if (a.isUniform(box) && b.isUniform(box)) {
      const bool support = a.uniformIsSupport();
      for (std::size_t c = 0; c < channels_; ++c)
        add(a.uniform()[c], b.uniform()[c], support, voxelsIn(box), box.begin);
      return;
    }
    if (a.leaves.empty() && b.leaves.empty() && a.tiles.size() + b.tiles.size() <= kFewTiles) {
      const Cut cut = faceThrough(box, a, b);
      IndexBox near = box, far = box;
      near.end[cut.axis] = far.begin[cut.axis] = cut.at;
      for (const IndexBox& part : {near, far}) visit(part, a.within(part), b.within(part));
      return;
    }
    const std::int64_t half = cube.size(0) / 2;
    if (cube.size(0) <= kSmallCube) {
      compareVoxels(box, a, b);
      return;
    }
    for (int i = 0; i < 8; ++i) {
      IndexBox part;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        part.begin[axis] = cube.begin[axis] + (i >> axis & 1) * half;
        part.end[axis] = part.begin[axis] + half;
      }
      visit(part, a.within(part), b.within(part));
    }
  }

  void compareVoxels(const IndexBox& box, const FramePart& a, const FramePart& b) {
    a.fill(box, valuesA_, support_);
    b.fill(box, valuesB_, supportB_);
    const std::size_t voxels = support_.size();
    for (std::size_t c = 0; c < channels_; ++c) {
      for (std::size_t i = 0; i < voxels; ++i) {
        const auto at = static_cast<std::int64_t>(i);
        add(valuesA_[c * voxels + i], valuesB_[c * voxels + i], support_[i] != 0, 1,
            {box.begin[0] + at % box.size(0), box.begin[1] + at / box.size(0) % box.size(1),
             box.begin[2] + at / box.size(0) / box.size(1)});
      }
    }
  }

  void add(float a, float b, bool support, std::uint64_t count, const VoxelIndex& place) {
    if (support)
      histogram_.add(a, count);
    if (sum_.add(a, b, support, count, apart_))
      sum_.worst = place, sum_.worstA = a, sum_.worstB = b;
  }

  IndexBox whole_;
  std::size_t channels_;
  double apart_;
  ValueHistogram& histogram_;
  Difference sum_;
  std::vector<float> valuesA_, valuesB_;
  std::vector<std::uint8_t> support_, supportB_;
};

/// One frame's to that of those before it.
void addFrame(const Difference& frame, int position, Difference& all) {
  if (frame.maxError > all.maxError) {
    all.worstFrame = position;
    all.worst = frame.worst, all.worstA = frame.worstA, all.worstB = frame.worstB;
  }
  const auto extend = [](double low, double high, bool first, double& least, double& most) {
    least = first ? low : std::min(least, low);
    most = first ? high : std::max(most, high);
  };
  extend(frame.minA, frame.maxA, all.values == 0, all.minA, all.maxA);
  if (frame.supportValues > 0)
    extend(frame.supportLow, frame.supportHigh, all.supportValues == 0, all.supportLow,
           all.supportHigh);
  all.sumOfSquares += frame.sumOfSquares, all.values += frame.values;
  all.supportSquares += frame.supportSquares, all.supportValues += frame.supportValues;
  all.maxError = std::max(all.maxError, frame.maxError);
  all.outsideError = std::max(all.outsideError, frame.outsideError);
  all.backgroundsDiffer = all.backgroundsDiffer || frame.backgroundsDiffer;
}

}  // namespace

bool Difference::add(float a, float b, bool support, std::uint64_t count, double apart) {
  const double error = errorBetween(a, b, apart);
  const double squares = error * error * static_cast<double>(count);
  sumOfSquares += squares;
  if (values == 0)
    minA = maxA = a;
  minA = std::min<double>(minA, a), maxA = std::max<double>(maxA, a);
  if (support) {
    if (supportValues == 0)
      supportLow = supportHigh = a;
    supportLow = std::min<double>(supportLow, a), supportHigh = std::max<double>(supportHigh, a);
    supportSquares += squares;
    supportValues += count;
  } else {
    outsideError = std::max(outsideError, error);
  }
  values += count;
  const bool largest = error > maxError;
  maxError = std::max(maxError, error);
  return largest;
}

void Difference::shift(double offsetA, double offsetB) {
  for (double* const of : {&minA, &maxA, &supportLow, &supportHigh, &worstA}) *of += offsetA;
  worstB += offsetB;
}

void Difference::add(std::span<const float> a, std::span<const float> b) {
  for (std::size_t i = 0; i < a.size(); ++i) add(a[i], b[i], a[i] != 0);
}

double Difference::rms() const {
  return values == 0 ? 0 : std::sqrt(sumOfSquares / static_cast<double>(values));
}

double Difference::relativeRms() const {
  if (rms() == 0)
    return 0;
  return maxA > minA ? rms() / (maxA - minA) : std::numeric_limits<double>::infinity();
}

double Difference::psnr() const {
  return relativeRms() == 0 ? std::numeric_limits<double>::infinity()
                            : -20 * std::log10(relativeRms());
}

double Difference::supportRms() const {
  if (!(supportSquares > 0))
    return 0;
  const double range = supportHigh > supportLow ? supportHigh - supportLow : maxA - minA;
  return range > 0 ? std::sqrt(supportSquares / static_cast<double>(supportValues)) / range
                   : std::numeric_limits<double>::infinity();
}

double Difference::supportShare() const {
  return values == 0 ? 0 : static_cast<double>(supportValues) / static_cast<double>(values);
}

Result<Difference> compare(FrameSource& a, FrameSource& b, Progress& progress,
                           std::vector<Difference>* byFrame) {
  const VolumeInfo& infoA = a.info();
  const VolumeInfo& infoB = b.info();
  const bool sameSize = infoA.frames == infoB.frames && infoA.x == infoB.x && infoA.y == infoB.y &&
                        infoA.z == infoB.z && infoA.channels == infoB.channels;
  if (!sameSize) {
    return fail(ErrorCode::kInvalidData,
                "the sizes differ: the first has {}, the second {}; volumes of the same size can "
                "be compared",
                sizeText(infoA), sizeText(infoB));
  }
  const double offsetA = offsetOf(a), offsetB = offsetOf(b);
  Difference difference;
  ValueHistogram histogram;
  Bricks bricksA, bricksB;
  for (int frame = 0; frame < infoA.frames; ++frame) {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped: comparing frame {}", frame);
    VOLUTE_TRY(a.readBricks(frame, bricksA));
    VOLUTE_TRY(b.readBricks(frame, bricksB));
    const Difference one = FrameComparison({{0, 0, 0}, {infoA.x, infoA.y, infoA.z}}, infoA.channels,
                                           offsetA - offsetB, histogram)
                               .run(bricksA, bricksB);
    addFrame(one, frame, difference);
    if (byFrame)
      byFrame->push_back(one);
    progress.report("comparing", frame + 1, infoA.frames);
  }
  if (const auto range = histogram.robustRange(difference.supportLow, difference.supportHigh)) {
    std::tie(difference.supportLow, difference.supportHigh) = *range;
    difference.robust = true;
  }
  difference.shift(offsetA, offsetB);
  for (std::size_t i = 0; byFrame && i < byFrame->size(); ++i)
    (*byFrame)[i].shift(offsetA, offsetB);
  return difference;
}

}  // namespace volute
