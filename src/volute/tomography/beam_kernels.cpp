// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// Beams walk side by side, one in each lane, slab by slab, and write down the weights of the nodes
// that they meet, summed up over the rays of a beam: so nodes that several rays share are read and
// written once, and those of a plane once for the slabs on both its sides. Then the weights of one
// beam after the other meet the values, from plane to plane: beams side by side write to
// overlapping stretches of memory, and a vector that was just stored a node further left has to
// reach the cache before it can be loaded.

#include "volute/tomography/beam_kernels.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

// The fallback needs vectors of four. The compiler's bug that makes Highway avoid them (GCC 106322)
// concerns 16-bit integers.
#define HWY_BROKEN_EMU128 0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volute/tomography/beam_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "volute/math/float_lanes-inl.hpp"
#include "volute/tomography/beam_integrals-inl.hpp"

HWY_BEFORE_NAMESPACE();

namespace volute {
namespace HWY_NAMESPACE {
namespace {
using D4 = hn::FixedTag<float, 4>;
using V4 = hn::Vec<D4>;
constexpr D4 d4;

constexpr int kLanes = static_cast<int>(hn::MaxLanes(df));

constexpr int kSide = kBeamNodes;
constexpr int kRays = kBeamRays;
constexpr float kNever = 1e30F;
constexpr int kNodesAVector = kLanes / 4;                // colours in a vector
constexpr int kVectors = kSide * kSide / kNodesAVector;  // of colours in a window
constexpr int kRowVectors = kSide / kNodesAVector;       // of those in a row
constexpr int kWeightVectors = kSide * kSide / kLanes;   // of weights in a window
constexpr int kUsualVectors = kVectors - kRowVectors;    // of colours in all rows but the last

/// The weights of kSide x kSide nodes of a plane, row by row. A row goes along the first axis.
struct alignas(64) Window {
  float weight[kSide * kSide];
};

/// What the beams of a group meet, one after the other: windows of the planes that they pass.
class Trace {
 public:
  /// Forgets all, and makes room for beams that cross so many slabs.
  HWY_INLINE void start(int slabs) {
    most_ = 2 * slabs + 1;  // a plane may take two
    if (windows_.size() < static_cast<std::size_t>(kLanes * most_)) {
      windows_.resize(static_cast<std::size_t>(kLanes * most_));
      nodes_.resize(static_cast<std::size_t>(most_));
      tall_.resize(static_cast<std::size_t>(most_));
    }
    size_ = tallSize_ = 0;
    next_ = windows_.data();
  }

  /// Writes a window of each beam, a row after the other.
  class Put {
   public:
    HWY_INLINE explicit Put(Trace& trace) : trace_(trace) {}

    HWY_INLINE void row(int row, const VF (&weight)[kSide]) {
      transposeBlocks(weight, block_[row]);
    }

    HWY_INLINE void end() {
      for (int i = 0; i < 4; ++i)
        trace_.putWindows(block_[0][i], block_[1][i], block_[2][i], block_[3][i], i);
      ++trace_.size_;
      ++trace_.next_;
    }

   private:
    Trace& trace_;
    VF block_[kSide][4];  // block_[row][i]: the rows of beams i, i + 4, ...
  };

  /// @param fourRows  Whether the last row has weights.
  HWY_INLINE Put add(VI node, bool fourRows) {
    hn::Store(node, di, nodes_[size_].of);
    tall_[tallSize_] = size_;
    tallSize_ += fourRows ? 1 : 0;
    return Put(*this);
  }

  HWY_INLINE int size() const { return size_; }

  HWY_INLINE void setEnd(int beam, int windows) { end_[beam] = windows; }

  /// The windows of a beam.
  HWY_INLINE int windowsOf(int beam) const { return end_[beam]; }

  HWY_INLINE const float* weights(int beam, int i) const {
    return windows_[static_cast<std::size_t>(beam * most_ + i)].weight;
  }

  HWY_INLINE std::ptrdiff_t node(int beam, int i) const { return nodes_[i].of[beam]; }

  /// The windows whose last row has weights, ascending.
  HWY_INLINE std::span<const int> tall() const { return {tall_.data(), tallSize_}; }

 private:
  struct alignas(64) Nodes {
    std::int32_t of[kLanes];
  };

  /// In each block of four lanes, out[i] has the four weights of lane i.
  HWY_INLINE static void transposeBlocks(const VF (&w)[kSide], VF (&out)[4]) {
    const VF a = hn::InterleaveLower(df, w[0], w[2]), b = hn::InterleaveLower(df, w[1], w[3]);
    const VF c = hn::InterleaveUpper(df, w[0], w[2]), d = hn::InterleaveUpper(df, w[1], w[3]);
    out[0] = hn::InterleaveLower(df, a, b);
    out[1] = hn::InterleaveUpper(df, a, b);
    out[2] = hn::InterleaveLower(df, c, d);
    out[3] = hn::InterleaveUpper(df, c, d);
  }

  HWY_INLINE float* target(int beam) { return next_[beam * most_].weight; }

  /// The rows of beams i, i + 4, ..., a block each.
  HWY_INLINE void putWindows(VF row0, VF row1, VF row2, VF row3, int i) {
    if constexpr (kLanes == 16) {
      const VF a = hn::ConcatLowerLower(df, row2, row0), b = hn::ConcatLowerLower(df, row3, row1);
      const VF c = hn::ConcatUpperUpper(df, row2, row0), d = hn::ConcatUpperUpper(df, row3, row1);
      hn::Store(hn::OddEvenBlocks(hn::SwapAdjacentBlocks(b), a), df, target(i));
      hn::Store(hn::OddEvenBlocks(b, hn::SwapAdjacentBlocks(a)), df, target(i + 4));
      hn::Store(hn::OddEvenBlocks(hn::SwapAdjacentBlocks(d), c), df, target(i + 8));
      hn::Store(hn::OddEvenBlocks(d, hn::SwapAdjacentBlocks(c)), df, target(i + 12));
    } else if constexpr (kLanes == 8) {
      hn::Store(hn::ConcatLowerLower(df, row1, row0), df, target(i));
      hn::Store(hn::ConcatLowerLower(df, row3, row2), df, target(i) + 8);
      hn::Store(hn::ConcatUpperUpper(df, row1, row0), df, target(i + 4));
      hn::Store(hn::ConcatUpperUpper(df, row3, row2), df, target(i + 4) + 8);
    } else {
      hn::Store(row0, df, target(i));
      hn::Store(row1, df, target(i) + 4);
      hn::Store(row2, df, target(i) + 8);
      hn::Store(row3, df, target(i) + 12);
    }
  }

  std::vector<Window> windows_;  // most_ of each beam
  std::vector<Nodes> nodes_;
  std::vector<int> tall_;
  std::size_t tallSize_ = 0;
  Window* next_ = nullptr;  // of the first beam
  std::ptrdiff_t most_ = 0;
  int size_ = 0;
  int end_[kLanes] = {};
};

/// Beams side by side, from slab to slab.
class Group {
 public:
  /// @param count  Of the beams from `first` on; lanes beyond walk along and are not looked at.
  HWY_INLINE Group(const BeamFields& beams, std::size_t first, int count) : count_(count) {
    for (int i = 0; i < kLanes; ++i) slabs_[i] = i < count ? beams.slabs[first + i] : 0;
    node_ = hn::LoadU(di, &beams.node[first]);
    for (int a = 0; a < 3; ++a) stride_[a] = hn::LoadU(di, &beams.stride[a][first]);
    for (int r = 0; r < kRays; ++r) loadRay(beams.ray[r], first, ray_[r]);
  }

  /// Writes down all that the beams meet.
  void walk(Trace& trace) {
    const auto [least, most] = std::minmax_element(slabs_, slabs_ + count_);
    trace.start(*most);
    const VF one = hn::Set(df, 1.0F), two = hn::Set(df, 2.0F);
    for (int k = 0; k < *most; ++k) {
      Mask moves[2] = {moveAnchor(0), moveAnchor(1)};
      const VF lowest = farthest(1);
      const Mask wide = hn::Gt(farthest(0), two), tall = hn::Gt(lowest, two);
      const Mask outgrown = hn::Or(hn::And(moves[0], wide), hn::And(moves[1], tall));
      if (k > 0 && !hn::AllFalse(df, outgrown))
        closeWindow(trace);
      if (k == 0 || !hn::AllFalse(df, outgrown)) {
        openWindow();
        moves[0] = moves[1] = hn::Lt(two, two);
      }
      if (k >= *least)
        dropEnded(k);
      if (!hn::AllFalse(df, tall) || !hn::AllFalse(df, hn::And(moves[1], hn::Gt(lowest, one))))
        fourRows_ = true;
      if (!hn::AllFalse(df, tall))
        step<4, 4>(moves, trace);
      else if (!hn::AllFalse(df, wide))
        step<4, 3>(moves, trace);
      else
        step<3, 3>(moves, trace);
      if (k + 1 >= *least) {
        for (int i = 0; i < count_; ++i) {
          if (slabs_[i] == k + 1)
            trace.setEnd(i, trace.size() + 1);
        }
      }
    }
    closeWindow(trace);
  }

 private:
  HWY_INLINE void loadRay(const BeamFields::Ray& from, std::size_t first, Ray& ray) {
    const VF one = hn::Set(df, 1.0F);
    for (int a = 0; a < 2; ++a) {
      ray.place[a] = hn::LoadU(df, &from.place[a][first]);
      ray.slope[a] = hn::LoadU(df, &from.slope[a][first]);
      const auto moves = hn::Gt(ray.slope[a], hn::Set(df, 1e-20F));
      ray.inverse[a] = hn::IfThenElse(moves, hn::Div(one, hn::IfThenElse(moves, ray.slope[a], one)),
                                      hn::Set(df, kNever));
    }
    ray.length = hn::LoadU(df, &from.length[first]);
    weighRay(ray);
    sum_.add(ray);
  }

  /// What depends on the ray's length.
  HWY_INLINE static void weighRay(Ray& ray) {
    const VF half = hn::Set(df, 1 / 2.0F), third = hn::Set(df, 1 / 3.0F);
    for (int a = 0; a < 2; ++a) {
      ray.halfSlope[a] = hn::Mul(ray.slope[a], half);
      ray.thirdSlope[a] = hn::Mul(ray.slope[a], third);
      ray.perSlope[a] = hn::Mul(ray.length, ray.slope[a]);
      ray.perHalfSlope[a] = hn::Mul(ray.length, ray.halfSlope[a]);
    }
    ray.halfPerSlopes = hn::Mul(ray.perSlope[0], ray.halfSlope[1]);
    ray.thirdPerSlopes = hn::Mul(ray.perSlope[0], ray.thirdSlope[1]);
  }

  /// Where all rays have left the first line of nodes behind, the window moves on by one.
  HWY_INLINE Mask moveAnchor(int a) {
    VF least = ray_[0].place[a];
    for (const Ray& ray : ray_) least = hn::Min(least, ray.place[a]);
    const VF one = hn::Set(df, 1.0F);
    const Mask moves = hn::Ge(least, one);
    const VF by = hn::IfThenElseZero(moves, one);
    for (Ray& ray : ray_) ray.place[a] = hn::Sub(ray.place[a], by);
    node_ = hn::Add(node_, hn::IfThenElseZero(hn::RebindMask(di, moves), stride_[a]));
    return moves;
  }

  /// The highest place at the end of the slab.
  HWY_INLINE VF farthest(int a) const {
    VF most = hn::Add(ray_[0].place[a], ray_[0].slope[a]);
    for (const Ray& ray : ray_) most = hn::Max(most, hn::Add(ray.place[a], ray.slope[a]));
    return most;
  }

  /// No weights yet, from the anchor on.
  HWY_INLINE void openWindow() {
    window_ = node_;
    fourRows_ = false;
    for (auto& row : open_)
      for (VF& weight : row) weight = hn::Zero(df);
  }

  HWY_INLINE void closeWindow(Trace& trace) const {
    Trace::Put put = trace.add(window_, fourRows_);
    for (int row = 0; row < kSide; ++row) put.row(row, open_[row]);
    put.end();
  }

  /// Beams that have passed their slabs before slab `k` have no weights any more.
  HWY_INLINE void dropEnded(int k) {
    alignas(64) float goesOn[kLanes];
    for (int i = 0; i < kLanes; ++i) goesOn[i] = slabs_[i] > k ? 1.0F : 0.0F;
    const VF share = hn::Load(df, goesOn);
    sum_ = RaySums();
    for (Ray& ray : ray_) {
      ray.length = hn::Mul(ray.length, share);
      weighRay(ray);
      sum_.add(ray);
    }
  }

  /// A slab: ends the window of its near plane, which stands a line of nodes before the anchor
  /// where `moves`, and opens that of the far plane.
  template <int kColumns, int kRows>
  HWY_INLINE void step(const Mask (&moves)[2], Trace& trace) {
    Moments m[kRows][kColumns];
    integrate<kColumns, kRows>(m);
    VF near[kRows][kColumns];
    hats<kColumns, kRows>(m, false, near);
    addNear<kColumns, kRows>(near, moves);
    closeWindow(trace);
    hats<kColumns, kRows>(m, true, open_);
    fourRows_ = kRows == kSide;
    for (int row = 0; row < kSide; ++row)
      for (int i = 0; i < kSide; ++i) {
        if (row >= kRows || i >= kColumns)
          open_[row][i] = hn::Zero(df);
      }
    node_ = window_ = hn::Add(node_, stride_[2]);
    for (Ray& ray : ray_)
      for (int a = 0; a < 2; ++a) ray.place[a] = hn::Add(ray.place[a], ray.slope[a]);
  }

  /// Integrals over the slab, from the anchor on. Along a ray, the hat functions in a plane's axis
  /// are sums of 1, of the place x and of ramps max(x - i, 0), those across the slab are u and
  /// 1 - u. All products of these have closed integrals, which are summed up over the rays.
  template <int kColumns, int kRows>
  HWY_INLINE void integrate(Moments (&m)[kRows][kColumns]) const {
    VF x = hn::Zero(df), y = x, xy = x, slopes = x;
    RampSums rampX[kColumns - 2], rampY[kRows - 2];
    ProductSums ramps[kRows - 2][kColumns - 2];
    for (const Ray& ray : ray_) {
      const VF endX = hn::Add(ray.place[0], ray.slope[0]);
      const VF endY = hn::Add(ray.place[1], ray.slope[1]);
      const VF lengthX = hn::Mul(ray.length, endX);
      x = hn::Add(x, lengthX);
      y = hn::MulAdd(ray.length, endY, y);
      xy = hn::MulAdd(lengthX, endY, xy);
      slopes = hn::MulAdd(endX, ray.perSlope[1], hn::MulAdd(endY, ray.perSlope[0], slopes));
      for (int j = 0; j < kRows - 2; ++j) {
        const Ramp down(hn::Sub(endY, hn::Set(df, static_cast<float>(j + 1))), ray, 1);
        rampY[j].add(down, ray, 0, endX);
        for (int i = 0; i < kColumns - 2; ++i) {
          const Ramp across(hn::Sub(endX, hn::Set(df, static_cast<float>(i + 1))), ray, 0);
          if (j == 0)
            rampX[i].add(across, ray, 1, endY);
          ramps[j][i].add(across, down, ray);
        }
      }
    }
    const VF half = hn::Set(df, 1 / 2.0F), third = hn::Set(df, 1 / 3.0F);
    m[0][0] = {sum_.length, hn::Mul(sum_.length, half)};
    m[0][1] = {hn::NegMulAdd(sum_.slope[0], half, x),
               hn::NegMulAdd(sum_.slope[0], third, hn::Mul(x, half))};
    m[1][0] = {hn::NegMulAdd(sum_.slope[1], half, y),
               hn::NegMulAdd(sum_.slope[1], third, hn::Mul(y, half))};
    m[1][1] = {
        hn::NegMulAdd(slopes, half, hn::Add(sum_.thirdSlopes, xy)),
        hn::NegMulAdd(slopes, third,
                      hn::MulAdd(sum_.thirdSlopes, hn::Set(df, 3 / 4.0F), hn::Mul(xy, half)))};
    for (int i = 2; i < kColumns; ++i) {
      m[0][i] = rampX[i - 2].withOne();
      m[1][i] = rampX[i - 2].withPlace();
      for (int j = 2; j < kRows; ++j) m[j][i] = ramps[j - 2][i - 2].moments();
    }
    for (int j = 2; j < kRows; ++j) {
      m[j][0] = rampY[j - 2].withOne();
      m[j][1] = rampY[j - 2].withPlace();
    }
  }

  /// The weights of the near or the far plane's nodes.
  template <int kColumns, int kRows, std::size_t kWidth, std::size_t kHeight>
  HWY_INLINE static void hats(const Moments (&m)[kRows][kColumns], bool isFar,
                              VF (&out)[kHeight][kWidth]) {
    VF byColumn[kColumns][kRows];
    for (int j = 0; j < kRows; ++j) {
      VF row[kColumns];
      for (int i = 0; i < kColumns; ++i)
        row[i] = isFar ? hn::Sub(m[j][i].whole, m[j][i].near) : m[j][i].near;
      ToHats(row);
      for (int i = 0; i < kColumns; ++i) byColumn[i][j] = row[i];
    }
    for (int i = 0; i < kColumns; ++i) {
      ToHats(byColumn[i]);
      for (int j = 0; j < kRows; ++j) out[j][i] = byColumn[i][j];
    }
  }

  /// Adds weights that stand a line of nodes further than the open window where `moves`.
  template <int kColumns, int kRows>
  HWY_INLINE void addNear(const VF (&near)[kRows][kColumns], const Mask (&moves)[2]) {
    const bool down = !hn::AllFalse(df, moves[1]);
    for (int row = 0; row < kRows; ++row) {
      VF across[kSide];
      across[0] = hn::IfThenZeroElse(moves[0], near[row][0]);
      for (int i = 1; i < kColumns; ++i)
        across[i] = hn::IfThenElse(moves[0], near[row][i - 1], near[row][i]);
      if (kColumns < kSide)
        across[kSide - 1] = hn::IfThenElseZero(moves[0], near[row][kColumns - 1]);
      if (!down) {
        for (int i = 0; i < kSide; ++i) open_[row][i] = hn::Add(open_[row][i], across[i]);
        continue;
      }
      for (int i = 0; i < kSide; ++i) {
        open_[row][i] = hn::Add(open_[row][i], hn::IfThenZeroElse(moves[1], across[i]));
        // Of four rows, none moves.
        if (row + 1 < kSide)
          open_[row + 1][i] = hn::Add(open_[row + 1][i], hn::IfThenElseZero(moves[1], across[i]));
      }
    }
  }

  int count_;
  std::int32_t slabs_[kLanes];
  VI node_, stride_[3];
  bool fourRows_ = false;  // whether the open window has weights in its last row
  VI window_;              // where the open window stands
  VF open_[kSide][kSide];  // the weights of the near plane so far
  Ray ray_[kRays];

  RaySums sum_;
};

/// The weights of a window as factors of the colours of its nodes, as these follow each other in
/// memory: a row from the anchor on, or backwards for beams that descend along it.
class Spread {
 public:
  HWY_INLINE explicit Spread(bool backwards) {
    for (int v = 0; v < kVectors; ++v) {
      alignas(64) std::int32_t lane[kLanes];
      for (int i = 0; i < kLanes; ++i) {
        const int place = v * kNodesAVector + i / 4, column = place % kSide;
        lane[i] = (place - column + (backwards ? kSide - 1 - column : column)) % kLanes;
      }
      index_[v] = hn::Load(di, lane);
    }
  }

  HWY_INLINE VF operator()(const VF* weights, int v) const {
    return hn::TableLookupLanes(weights[v * kNodesAVector / kLanes],
                                hn::IndicesFromVec(df, index_[v]));
  }

 private:
  VI index_[kVectors];
};

/// The windows of one beam: visit(weights, where the colours of its vectors are from the first).
class BeamWindows {
 public:
  /// @param across, down  The beam's strides in the plane.
  HWY_INLINE BeamWindows(const Trace& trace, int beam, std::int32_t across, std::int32_t down)
      : trace_(trace),
        beam_(beam),
        down_(4 * static_cast<std::ptrdiff_t>(down)),
        first_(across < 0 ? -4 * (kSide - 1) : 0) {}

  HWY_INLINE int size() const { return trace_.windowsOf(beam_); }

  HWY_INLINE void load(int i, VF* weights) const {
    const float* from = trace_.weights(beam_, i);
    for (int k = 0; k < kWeightVectors; ++k) weights[k] = hn::Load(df, from + k * kLanes);
  }

  /// Those whose last row has weights; beams of a group share them, so some may lie behind the end.
  HWY_INLINE std::span<const int> tall() const { return trace_.tall(); }

  /// Of vector 0 of a window, in floats.
  HWY_INLINE std::ptrdiff_t place(int i) const { return first_ + 4 * trace_.node(beam_, i); }

  HWY_INLINE std::ptrdiff_t offset(int v) const {
    return v / kRowVectors * down_ + v % kRowVectors * kLanes;
  }

 private:
  const Trace& trace_;
  int beam_;
  std::ptrdiff_t down_, first_;
};

// The last row, which few windows have, goes on its own: a branch in each window would be guessed
// wrong too often.

/// The sum of the values that a beam meets.
HWY_INLINE V4 GatherBeam(const BeamWindows& windows, const Spread spread, const float* values) {
  VF sum[kVectors];
  for (VF& part : sum) part = hn::Zero(df);
  const int size = windows.size();
  VF weights[kWeightVectors];
  for (int i = 0; i < size; ++i) {
    windows.load(i, weights);
    const float* from = values + windows.place(i);
    for (int v = 0; v < kUsualVectors; ++v)
      sum[v] = hn::MulAdd(spread(weights, v), hn::LoadU(df, from + windows.offset(v)), sum[v]);
  }
  for (const int i : windows.tall()) {
    if (i >= size)
      break;
    windows.load(i, weights);
    const float* from = values + windows.place(i);
    for (int v = kUsualVectors; v < kVectors; ++v)
      sum[v] = hn::MulAdd(spread(weights, v), hn::LoadU(df, from + windows.offset(v)), sum[v]);
  }
  VF all = sum[0];
  for (int v = 1; v < kVectors; ++v) all = hn::Add(all, sum[v]);
  alignas(64) float lanes[kLanes];
  hn::Store(all, df, lanes);
  V4 total = hn::Load(d4, lanes);
  for (int i = 4; i < kLanes; i += 4) total = hn::Add(total, hn::Load(d4, lanes + i));
  return total;
}

/// Adds `value` to the nodes that a beam meets.
HWY_INLINE void ScatterBeam(const BeamWindows& windows, const Spread spread, const float* value,
                            float* gradient) {
  const VF colour = hn::LoadDup128(df, value);
  const int size = windows.size();
  VF weights[kWeightVectors];
  for (int i = 0; i < size; ++i) {
    windows.load(i, weights);
    float* to = gradient + windows.place(i);
    for (int v = 0; v < kUsualVectors; ++v) {
      float* at = to + windows.offset(v);
      hn::StoreU(hn::MulAdd(spread(weights, v), colour, hn::LoadU(df, at)), df, at);
    }
  }
  for (const int i : windows.tall()) {
    if (i >= size)
      break;
    windows.load(i, weights);
    float* to = gradient + windows.place(i);
    for (int v = kUsualVectors; v < kVectors; ++v) {
      float* at = to + windows.offset(v);
      hn::StoreU(hn::MulAdd(spread(weights, v), colour, hn::LoadU(df, at)), df, at);
    }
  }
}

/// Appends a beam's weights that are not 0 to `out`.
void AppendBeam(const Trace& trace, int i, std::int32_t across, std::int32_t down,
                std::vector<NodeWeight>& out) {
  constexpr float kShare = 1.0F / kRays;
  for (int k = 0; k < trace.windowsOf(i); ++k) {
    const float* weight = trace.weights(i, k);
    for (int row = 0; row < kSide; ++row)
      for (int column = 0; column < kSide; ++column, ++weight) {
        if (*weight != 0)
          out.push_back({static_cast<std::int32_t>(trace.node(i, k)) + row * down + column * across,
                         kShare * *weight});
      }
  }
}

/// Beams of a product, in groups that walk side by side.
class Walker {
 public:
  explicit Walker(const BeamRange& range)
      : beams_(range.beams),
        next_(range.first),
        end_(range.first + range.count),
        spread_{Spread(false), Spread(true)} {}

  /// Walks the next group; the number of its beams, 0 at the end.
  HWY_INLINE int walk() {
    first_ = next_;
    const int count = static_cast<int>(std::min<std::size_t>(kLanes, end_ - first_));
    if (count > 0)
      Group(beams_, first_, count).walk(trace_);
    next_ += count;
    return count;
  }

  // Of beam i of the group.

  HWY_INLINE void gather(int i, const float* values, float* sum) const {
    hn::StoreU(hn::Mul(GatherBeam(windowsOf(i), spreadOf(i), values), hn::Set(d4, 1.0F / kRays)),
               d4, sum);
  }

  HWY_INLINE void scatter(int i, const float* value, float* gradient) const {
    alignas(16) float share[4];
    hn::Store(hn::Mul(hn::LoadU(d4, value), hn::Set(d4, 1.0F / kRays)), d4, share);
    ScatterBeam(windowsOf(i), spreadOf(i), share, gradient);
  }

  HWY_INLINE void append(int i, std::vector<NodeWeight>& out) const {
    AppendBeam(trace_, i, across(i), down(i), out);
  }

 private:
  HWY_INLINE std::int32_t across(int i) const { return beams_.stride[0][first_ + i]; }

  HWY_INLINE std::int32_t down(int i) const { return beams_.stride[1][first_ + i]; }

  HWY_INLINE BeamWindows windowsOf(int i) const { return {trace_, i, across(i), down(i)}; }

  HWY_INLINE const Spread& spreadOf(int i) const { return spread_[across(i) < 0 ? 1 : 0]; }

  const BeamFields& beams_;
  std::size_t next_, end_;
  std::size_t first_ = 0;  // of the group
  Spread spread_[2];
  Trace trace_;
};

void Forward(const BeamRange& beams, const float* values, float* sums) {
  Walker walker(beams);
  while (const int n = walker.walk()) {
    for (int i = 0; i < n; ++i, sums += 4) walker.gather(i, values, sums);
  }
}

void Adjoint(const BeamRange& beams, const float* beamValues, float* gradient) {
  Walker walker(beams);
  while (const int n = walker.walk()) {
    for (int i = 0; i < n; ++i, beamValues += 4) walker.scatter(i, beamValues, gradient);
  }
}

void Weights(const BeamRange& beams, std::vector<NodeWeight>* out) {
  Walker walker(beams);
  while (const int n = walker.walk()) {
    for (int i = 0; i < n; ++i, ++out) walker.append(i, *out);
  }
}

void ThereAndBack(const BeamRange& beams, const float* values, BeamTurn turn, const void* context,
                  float* sums, float* gradient) {
  Walker walker(beams);
  std::size_t first = 0;
  while (const int n = walker.walk()) {
    for (int i = 0; i < n; ++i) walker.gather(i, values, sums + 4 * (first + i));
    float back[4 * kLanes];
    turn(context, first, n, sums + 4 * first, back);
    for (int i = 0; i < n; ++i) walker.scatter(i, back + 4 * i, gradient);
    first += n;
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace volute

HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volute {

HWY_EXPORT(Forward);
HWY_EXPORT(Adjoint);
HWY_EXPORT(ThereAndBack);
HWY_EXPORT(Weights);

BeamFields::BeamFields(std::span<const Beam> beams, std::span<const BeamRay> rays)
    : slabs(beams.size() + kPadding), node(slabs.size()) {
  for (auto& field : stride) field.resize(slabs.size());
  for (Ray& of : ray) {
    for (auto* field : {&of.place[0], &of.place[1], &of.slope[0], &of.slope[1], &of.length})
      field->resize(slabs.size());
  }
  for (std::size_t i = 0; i < beams.size(); ++i) {
    slabs[i] = beams[i].slabs;
    node[i] = beams[i].node;
    for (int a = 0; a < 3; ++a) stride[a][i] = beams[i].stride[a];
    for (int r = 0; r < kBeamRays; ++r) {
      const BeamRay& from = rays[i * kBeamRays + r];
      for (int a = 0; a < 2; ++a) {
        ray[r].place[a][i] = from.place[a];
        ray[r].slope[a][i] = from.slope[a];
      }
      ray[r].length[i] = from.length;
    }
  }
}

void beamForward(const BeamRange& beams, const float* values, float* sums) {
  HWY_DYNAMIC_DISPATCH(Forward)(beams, values, sums);
}

void beamAdjoint(const BeamRange& beams, const float* beamValues, float* gradient) {
  HWY_DYNAMIC_DISPATCH(Adjoint)(beams, beamValues, gradient);
}

void beamThereAndBack(const BeamRange& beams, const float* values, BeamTurn turn,
                      const void* context, float* sums, float* gradient) {
  HWY_DYNAMIC_DISPATCH(ThereAndBack)(beams, values, turn, context, sums, gradient);
}

void beamWeights(const BeamRange& beams, std::vector<NodeWeight>* out) {
  HWY_DYNAMIC_DISPATCH(Weights)(beams, out);
}

}  // namespace volute
#endif  // HWY_ONCE
