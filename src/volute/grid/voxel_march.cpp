// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// One ray in each SIMD lane. Lanes step on their own from plane to plane; neighbours in an image
// take the same bricks, so that few idle. Only IEEE operations without fused multiply-add: every
// target gives the same bits.

#include "volute/grid/voxel_march.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <type_traits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volute/grid/voxel_march.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "volute/math/float_lanes-inl.hpp"
#include "volute/math/float_records-inl.hpp"

#ifndef VOLUTE_GRID_VOXEL_MARCH_LANES
#define VOLUTE_GRID_VOXEL_MARCH_LANES

namespace volute {
namespace {

constexpr std::size_t kMaxLanes = 128;  // what a batch holds; a multiple of any vector's lanes
constexpr float kNever = 3e38F;         // stands for infinity, which times 0 would be NaN
constexpr double kFarAway = 1e30;       // [m] planes beyond are never met
constexpr int kCornerSide = BrickSlice::kSide + 1;  // of a trilinear brick

/// Rays as the march wants them: `s` counts from where each enters the volume, in metres.
struct RayLanes {
  alignas(
      64) float first[3][kMaxLanes];  ///< s of the first plane on each axis; kNever when parallel
  alignas(64) float delta[3][kMaxLanes];     ///< from plane to plane; 0 when parallel
  alignas(64) float perDelta[3][kMaxLanes];  ///< 1 / delta; 0 when parallel
  alignas(64) float velocity[3][kMaxLanes];  ///< cells per metre
  alignas(64) float exitAt[3][kMaxLanes];    ///< place in the cell (0..1) where the ray leaves it,
                                             ///< or stays
  alignas(64) std::int32_t cell[3][kMaxLanes];
  alignas(64) std::int32_t step[3][kMaxLanes];
  alignas(64) float length[kMaxLanes];
};

/// Without absorption, or where it is in closed form: the line integrals of the channels. Else
/// emission, transmittance.
struct LaneResults {
  alignas(64) float sum[3][kMaxLanes];
  alignas(64) float transmittance[kMaxLanes];
};

}  // namespace
}  // namespace volute
#endif

HWY_BEFORE_NAMESPACE();

namespace volute {
namespace HWY_NAMESPACE {
namespace {
HWY_INLINE VF Least(VF a, VF b, VF c) {
  return hn::Min(hn::Min(a, b), c);
}

/// (1 - exp(-x)) / x, given e = exp(-x).
HWY_INLINE VF MeanTransmittance(VF x, VF e) {
  VF series = MulThenAdd(x, Constant(1 / 120.0F), Constant(-1 / 24.0F));
  series = MulThenAdd(series, x, Constant(1 / 6.0F));
  series = MulThenAdd(series, x, Constant(-0.5F));
  series = MulThenAdd(series, x, Constant(1));
  return hn::IfThenElse(hn::Lt(hn::Abs(x), Constant(0.1F)), series,
                        hn::Div(hn::Sub(Constant(1), e), x));
}

/// exp(-depth), to 1e-5; a depth above 87 is 87.
HWY_INLINE VF LightAfter(VF depth) {
  const VF x = hn::Min(depth, Constant(87));
  const VF n = hn::Round(hn::Mul(x, Constant(-1.44269504F)));
  const VF r = hn::Add(x, hn::Mul(n, Constant(0.693147181F)));  // -ln2 / 2 .. ln2 / 2
  VF p = MulThenAdd(r, Constant(0.0417F), Constant(-0.16678F));
  p = MulThenAdd(p, r, Constant(0.5F));
  p = MulThenAdd(p, r, Constant(-1));
  p = MulThenAdd(p, r, Constant(1));
  const VI exponent = hn::ShiftLeft<23>(hn::Add(hn::ConvertTo(di, n), hn::Set(di, 127)));
  return hn::Mul(p, hn::BitCast(df, exponent));
}

/// One axis of the march.
struct Axis {
  VF first, delta, perDelta;
  VF count;  ///< planes passed so far
  VF next;   ///< s of the next one, always first + count * delta
  VI cell, step;
  VF velocity, exitAt;

  HWY_INLINE void load(const RayLanes& rays, int axis, std::size_t lane) {
    first = next = hn::Load(df, rays.first[axis] + lane);
    delta = hn::Load(df, rays.delta[axis] + lane);
    perDelta = hn::Load(df, rays.perDelta[axis] + lane);
    velocity = hn::Load(df, rays.velocity[axis] + lane);
    exitAt = hn::Load(df, rays.exitAt[axis] + lane);
    cell = hn::Load(di, rays.cell[axis] + lane);
    step = hn::Load(di, rays.step[axis] + lane);
    count = hn::Zero(df);
  }

  HWY_INLINE void pass(VF planes) {
    count = hn::Add(count, planes);
    next = MulThenAdd(count, delta, first);
  }

  HWY_INLINE VI cellNow() const { return hn::Add(cell, hn::Mul(step, hn::ConvertTo(di, count))); }

  /// The place in the cell at s, 0..1.
  HWY_INLINE VF place(VF s) const { return MulThenAdd(hn::Sub(s, next), velocity, exitAt); }
};

HWY_INLINE VF Gather(const MarchGrid& grid, int offset, VI index) {
  return hn::GatherIndex(df, grid.values + offset, index);
}

/// Of the eight corners of a cell, in voxels, where the pairs along x begin.
constexpr int kPairs[4] = {0, kCornerSide, kCornerSide* kCornerSide, kCornerSide*(kCornerSide + 1)};

/// The eight corners of a cell, as differences so that each place costs seven products.
struct Corners {
  VF base[4], slope[4];

  HWY_INLINE Corners() {}

  HWY_INLINE Corners(const MarchGrid& grid, int channel, const LaneIndex& index) {
    for (int row = 0; row < 4; ++row) {
      VF next;
      LoadPairs(grid.values + channel * grid.channelStride + kPairs[row], index.at, base[row],
                next);
      slope[row] = hn::Sub(next, base[row]);
    }
  }

  HWY_INLINE VF at(VF x, VF y, VF z) const {
    VF edge[4];
    for (int i = 0; i < 4; ++i) edge[i] = MulThenAdd(slope[i], x, base[i]);
    const VF low = MulThenAdd(hn::Sub(edge[1], edge[0]), y, edge[0]);
    const VF high = MulThenAdd(hn::Sub(edge[3], edge[2]), y, edge[2]);
    return MulThenAdd(hn::Sub(high, low), z, low);
  }
};

// What a step through a cell adds up. Constructors are written out because the compiler's own would
// not be compiled for the target. `index` is 0 for lanes that are not active; what they read does
// not count.

template <int kChannels>
struct BoxLine {
  VF sum[3];

  HWY_INLINE BoxLine() { sum[0] = sum[1] = sum[2] = hn::Zero(df); }

  HWY_INLINE void add(const MarchGrid& grid, VI index, VF, VF length, Mask active, const Axis*) {
    for (int c = 0; c < kChannels; ++c) {
      const VF value = hn::IfThenElseZero(active, Gather(grid, c * grid.channelStride, index));
      sum[c] = MulThenAdd(value, length, sum[c]);
    }
  }

  HWY_INLINE VF transmittance() const { return Constant(1); }
};

struct BoxAbsorbing {
  VF sum[3];
  VF passed;

  HWY_INLINE BoxAbsorbing() { sum[0] = sum[1] = sum[2] = hn::Zero(df), passed = Constant(1); }

  HWY_INLINE void add(const MarchGrid& grid, VI index, VF, VF length, Mask active, const Axis*) {
    VF value[3];
    for (int c = 0; c < 3; ++c)
      value[c] = hn::IfThenElseZero(active, Gather(grid, c * grid.channelStride, index));
    const VF scale = Constant(static_cast<float>(grid.extinctionScale / 3));
    const VF depth =
        hn::Mul(hn::Mul(hn::Add(hn::Add(value[0], value[1]), value[2]), scale), length);
    const VF left = Exp(hn::Neg(depth));
    const VF weight = hn::Mul(hn::Mul(passed, length), MeanTransmittance(depth, left));
    for (int c = 0; c < 3; ++c) sum[c] = MulThenAdd(value[c], weight, sum[c]);
    passed = hn::Mul(passed, left);
  }

  HWY_INLINE VF transmittance() const { return passed; }
};

template <int kChannels>
struct TrilinearLine {
  VF sum[3];

  HWY_INLINE TrilinearLine() { sum[0] = sum[1] = sum[2] = hn::Zero(df); }

  /// The value is a cubic of s: two Gauss points are exact.
  HWY_INLINE void add(const MarchGrid& grid, VI index, VF begin, VF length, Mask active,
                      const Axis* axes) {
    const VF near = MulThenAdd(length, Constant(0.21132487F), begin);
    const VF far = MulThenAdd(length, Constant(0.78867513F), begin);
    VF at[2][3];
    for (int axis = 0; axis < 3; ++axis)
      at[0][axis] = axes[axis].place(near), at[1][axis] = axes[axis].place(far);
    const LaneIndex lanes(index);
    for (int c = 0; c < kChannels; ++c) {
      const Corners corners(grid, c, lanes);
      const VF both = hn::Add(corners.at(at[0][0], at[0][1], at[0][2]),
                              corners.at(at[1][0], at[1][1], at[1][2]));
      sum[c] =
          MulThenAdd(hn::IfThenElseZero(active, both), hn::Mul(length, Constant(0.5F)), sum[c]);
    }
  }

  HWY_INLINE VF transmittance() const { return Constant(1); }
};

struct TrilinearAbsorbing {
  VF sum[3];
  VF passed;

  HWY_INLINE TrilinearAbsorbing() { sum[0] = sum[1] = sum[2] = hn::Zero(df), passed = Constant(1); }

  HWY_INLINE void add(const MarchGrid& grid, VI index, VF begin, VF length, Mask active,
                      const Axis* axes) {
    const LaneIndex lanes(index);
    const Corners corners[3] = {Corners(grid, 0, lanes), Corners(grid, 1, lanes),
                                Corners(grid, 2, lanes)};
    const VF part = hn::Mul(length, Constant(1.0F / static_cast<float>(grid.steps)));
    for (int step = 0; step < grid.steps; ++step) {
      rule(grid, corners, MulThenAdd(part, Constant(static_cast<float>(step)), begin), part, active,
           axes);
    }
  }

  /// Emission and extinction are cubics: their values at the four Gauss nodes give the optical
  /// depth up to each node exactly, by the integrals of the Lagrange polynomials.
  HWY_INLINE void rule(const MarchGrid& grid, const Corners* corners, VF begin, VF length,
                       Mask active, const Axis* axes) {
    static constexpr float kNodes[4] = {0.06943184420F, 0.33000947821F, 0.66999052180F,
                                        0.93056815580F};
    static constexpr float kWeights[4] = {0.17392742257F, 0.32607257743F, 0.32607257743F,
                                          0.17392742257F};
    static constexpr float kUpTo[4][4] = {
        {0.08696371128F, -0.02660418009F, 0.01262746269F, -0.00355514968F},
        {0.18811811750F, 0.16303628872F, -0.02788042860F, 0.00673550059F},
        {0.16719192197F, 0.35395300603F, 0.16303628872F, -0.01419069493F},
        {0.17748257225F, 0.31344511474F, 0.35267675752F, 0.08696371128F}};
    const VF scale = Constant(static_cast<float>(grid.extinctionScale / 3));
    VF value[4][3];
    VF extinction[4];
    for (int i = 0; i < 4; ++i) {
      const VF s = MulThenAdd(length, Constant(kNodes[i]), begin);
      const VF x = axes[0].place(s), y = axes[1].place(s), z = axes[2].place(s);
      for (int c = 0; c < 3; ++c) value[i][c] = hn::IfThenElseZero(active, corners[c].at(x, y, z));
      extinction[i] =
          hn::Mul(hn::Mul(hn::Add(hn::Add(value[i][0], value[i][1]), value[i][2]), scale), length);
    }
    VF depth = hn::Zero(df);
    for (int i = 0; i < 4; ++i) {
      VF before = hn::Zero(df);
      for (int j = 0; j < 4; ++j) before = MulThenAdd(extinction[j], Constant(kUpTo[i][j]), before);
      const VF weight =
          hn::Mul(hn::Mul(passed, Exp(hn::Neg(before))), hn::Mul(length, Constant(kWeights[i])));
      for (int c = 0; c < 3; ++c) sum[c] = MulThenAdd(value[i][c], weight, sum[c]);
      depth = MulThenAdd(extinction[i], Constant(kWeights[i]), depth);
    }
    passed = hn::Mul(passed, Exp(hn::Neg(depth)));
  }

  HWY_INLINE VF transmittance() const { return passed; }
};

/// The two Gauss points of a step, and how much of what is emitted at each arrives where the step
/// begins: the optical depth up to each by the integrals of the line through both extinctions.
struct GaussStep {
  VF at[2][3];
  VF extinction[2];
  VF depth;       ///< of the step
  VF arrives[2];  ///< times half the step

  /// @param before  the optical depth up to the step
  HWY_INLINE GaussStep(const Corners& density, VF begin, VF length, VF before, Mask active,
                       const Axis* axes) {
    const VF near = MulThenAdd(length, Constant(0.21132487F), begin);
    const VF far = MulThenAdd(length, Constant(0.78867513F), begin);
    for (int axis = 0; axis < 3; ++axis)
      at[0][axis] = axes[axis].place(near), at[1][axis] = axes[axis].place(far);
    for (int i = 0; i < 2; ++i)
      extinction[i] = hn::IfThenElseZero(active, density.at(at[i][0], at[i][1], at[i][2]));
    const VF low = hn::Mul(extinction[0], length), high = hn::Mul(extinction[1], length);
    const VF first = MulThenAdd(low, Constant(0.25F), hn::Mul(high, Constant(-0.03867513F)));
    const VF second = MulThenAdd(low, Constant(0.53867513F), hn::Mul(high, Constant(0.25F)));
    const VF half = hn::Mul(length, Constant(0.5F));
    arrives[0] = hn::Mul(half, LightAfter(hn::Add(before, first)));
    arrives[1] = hn::Mul(half, LightAfter(hn::Add(before, second)));
    depth = hn::Mul(hn::Add(low, high), Constant(0.5F));
  }
};

/// The light at a cell's corners, summed with weights.
class ScatteredLight {
 public:
  /// @param at  places of two points in the cell, and `scattered` the weight of the light there
  HWY_INLINE ScatteredLight(const VF (&at)[2][3], const VF* scattered) {
    VF other[8];
    shares(at[0], scattered[0], weight_);
    shares(at[1], scattered[1], other);
    for (int i = 0; i < 8; ++i) weight_[i] = hn::Add(weight_[i], other[i]);
    sum_[0] = sum_[1] = sum_[2] = hn::Zero(df);
  }

  /// Two corners side by side, packed.
  HWY_INLINE void addRow(int row, VF low, VF high) {
    add(weight_[2 * row], low);
    add(weight_[2 * row + 1], high);
  }

  HWY_INLINE void addTo(VF* sum, const MarchGrid& grid) const {
    constexpr float kScale[3] = {1, 1 / 4194304.0F, 1};  // green is not shifted
    for (int c = 0; c < 3; ++c)
      sum[c] = MulThenAdd(sum_[c], Constant(grid.lightScale[c] * kScale[c]), sum[c]);
  }

 private:
  HWY_INLINE static void shares(const VF (&at)[3], VF whole, VF* out) {
    const VF top = hn::Mul(at[2], whole), bottom = hn::Sub(whole, top);
    VF row[4];
    row[1] = hn::Mul(at[1], bottom), row[0] = hn::Sub(bottom, row[1]);
    row[3] = hn::Mul(at[1], top), row[2] = hn::Sub(top, row[3]);
    for (int i = 0; i < 4; ++i) {
      out[2 * i + 1] = hn::Mul(at[0], row[i]);
      out[2 * i] = hn::Sub(row[i], out[2 * i + 1]);
    }
  }

  HWY_INLINE void add(VF weight, VF packed) {
    const VI bits = hn::BitCast(di, packed);
    const VF levels[3] = {hn::ConvertTo(df, hn::And(bits, hn::Set(di, 2047))),
                          hn::ConvertTo(df, hn::And(bits, hn::Set(di, 2047 << 11))),
                          hn::ConvertTo(df, hn::And(hn::ShiftRight<22>(bits), hn::Set(di, 1023)))};
    for (int c = 0; c < 3; ++c)
      sum_[c] = MulThenAdd(hn::Mul(levels[c], levels[c]), weight, sum_[c]);
  }

  VF weight_[8], sum_[3];
};

/// The same of light of one colour: plain numbers.
class OneColor {
 public:
  HWY_INLINE OneColor(const VF (&at)[2][3], const VF* scattered)
      : at_(at), scattered_{scattered[0], scattered[1]} {}

  HWY_INLINE void addRow(int row, VF low, VF high) {
    light_.base[row] = low, light_.slope[row] = hn::Sub(high, low);
  }

  HWY_INLINE void addTo(VF* sum, const MarchGrid& grid) const {
    const VF near = hn::Mul(light_.at(at_[0][0], at_[0][1], at_[0][2]), scattered_[0]);
    const VF both = MulThenAdd(light_.at(at_[1][0], at_[1][1], at_[1][2]), scattered_[1], near);
    for (int c = 0; c < 3; ++c) sum[c] = MulThenAdd(both, Constant(grid.lightScale[c]), sum[c]);
  }

 private:
  const VF (&at_)[2][3];
  VF scattered_[2];
  Corners light_;
};

enum class Light { kNone, kPacked, kOneColor };

template <Light kLight>
using LightOf = std::conditional_t<kLight == Light::kOneColor, OneColor, ScatteredLight>;

/// Extinction, emission and light are trilinear each; the product of extinction and light, which is
/// what is scattered, is of degree 6 along a ray.
template <Light kLight>
struct GlowingCells {
  VF sum[3];
  VF depth;

  HWY_INLINE GlowingCells() { sum[0] = sum[1] = sum[2] = depth = hn::Zero(df); }

  HWY_INLINE void add(const MarchGrid& grid, VI index, VF begin, VF length, Mask active,
                      const Axis* axes) {
    const LaneIndex lanes(index);
    const Corners density(grid, 0, lanes);
    const VF part = hn::Mul(length, Constant(1.0F / static_cast<float>(grid.steps)));
    for (int i = 0; i < grid.steps; ++i) {
      const GaussStep step(density, MulThenAdd(part, Constant(static_cast<float>(i)), begin), part,
                           depth, active, axes);
      for (int c = 0; c < 3; ++c) {
        const Corners emission(grid, grid.emissionChannel + c, lanes);
        for (int k = 0; k < 2; ++k) {
          const VF* at = step.at[k];
          const VF value = hn::IfThenElseZero(active, emission.at(at[0], at[1], at[2]));
          sum[c] = MulThenAdd(value, step.arrives[k], sum[c]);
        }
      }
      if constexpr (kLight != Light::kNone) {
        const VF scattered[2] = {hn::Mul(step.extinction[0], step.arrives[0]),
                                 hn::Mul(step.extinction[1], step.arrives[1])};
        LightOf<kLight> light(step.at, scattered);
        for (int row = 0; row < 4; ++row) {
          VF low, high;
          LoadPairs(grid.values + grid.lightChannel * grid.channelStride + kPairs[row], lanes.at,
                    low, high);
          light.addRow(row, low, high);
        }
        light.addTo(sum, grid);
      }
      depth = hn::Add(depth, step.depth);
    }
  }

  HWY_INLINE VF transmittance() const { return LightAfter(depth); }
};

/// The same without emission: extinction and light lie side by side.
template <Light kLight>
struct LitCells {
  VF sum[3];
  VF depth;

  HWY_INLINE LitCells() { sum[0] = sum[1] = sum[2] = depth = hn::Zero(df); }

  HWY_INLINE void add(const MarchGrid& grid, VI index, VF begin, VF length, Mask active,
                      const Axis* axes) {
    const LaneIndex lanes(index);
    Corners density;
    VF low[4], high[4];
    VF four[4][4];
    LoadFourRows<2 * kPairs[1], 2 * kPairs[2], 2 * kPairs[3]>(grid.values, lanes.at, four);
    const auto take = [&](int row) HWY_ATTR {
      const VF* loaded = four[row];
      density.base[row] = loaded[0], density.slope[row] = hn::Sub(loaded[2], loaded[0]);
      low[row] = loaded[1], high[row] = loaded[3];
      return hn::Max(loaded[0], loaded[2]);
    };
    const VF most = hn::Max(hn::Max(take(0), take(1)), hn::Max(take(2), take(3)));
    if (hn::AllFalse(df, hn::And(active, hn::Gt(most, hn::Zero(df)))))
      return;  // nothing to be seen in any lane
    const VF part = hn::Mul(length, Constant(1.0F / static_cast<float>(grid.steps)));
    for (int i = 0; i < grid.steps; ++i) {
      const GaussStep step(density, MulThenAdd(part, Constant(static_cast<float>(i)), begin), part,
                           depth, active, axes);
      const VF scattered[2] = {hn::Mul(step.extinction[0], step.arrives[0]),
                               hn::Mul(step.extinction[1], step.arrives[1])};
      LightOf<kLight> light(step.at, scattered);
      light.addRow(0, low[0], high[0]), light.addRow(1, low[1], high[1]);
      light.addRow(2, low[2], high[2]), light.addRow(3, low[3], high[3]);
      light.addTo(sum, grid);
      depth = hn::Add(depth, step.depth);
    }
  }

  HWY_INLINE VF transmittance() const { return LightAfter(depth); }
};

/// The march of one vector of rays: from brick to brick, and inside stored bricks from cell to
/// cell.
template <class Cells>
class Packet {
 public:
  HWY_INLINE Packet(const MarchGrid& grid, const RayLanes& rays, std::size_t lane) : grid_(grid) {
    for (int axis = 0; axis < 3; ++axis) axes_[axis].load(rays, axis, lane);
    s_ = hn::Zero(df);
    end_ = hn::Load(df, rays.length + lane);
  }

  HWY_INLINE void run(MarchCounts& counts) {
    VF crossed = hn::Zero(df);
    for (;;) {
      end_ = hn::IfThenElse(hn::Lt(cells_.transmittance(), Constant(grid_.lightLost)), s_, end_);
      const Mask alive = hn::Lt(s_, end_);
      if (hn::AllFalse(df, alive))
        break;
      const VI begin = locate();
      const Mask stored = hn::And(alive, ForFloats(hn::Gt(begin, hn::Set(di, -1))));
      const Mask empty = hn::AndNot(stored, alive);
      counts.bricksVisited += hn::CountTrue(df, stored);
      counts.bricksSkipped += hn::CountTrue(df, empty);
      if (!hn::AllFalse(df, empty))
        jump(empty);
      if (hn::AllFalse(df, stored))
        continue;
      const VF before = planesPassed();
      cross(begin, stored);
      crossed = hn::Add(crossed, hn::IfThenElseZero(stored, hn::Sub(planesPassed(), before)));
    }
    counts.voxels += static_cast<std::uint64_t>(hn::GetLane(hn::SumOfLanes(df, crossed)));
  }

  HWY_INLINE void store(LaneResults& results, std::size_t lane) const {
    for (int c = 0; c < 3; ++c) hn::Store(cells_.sum[c], df, results.sum[c] + lane);
    hn::Store(cells_.transmittance(), df, results.transmittance + lane);
  }

 private:
  HWY_INLINE VF planesPassed() const {
    return hn::Add(hn::Add(axes_[0].count, axes_[1].count), axes_[2].count);
  }

  /// Where the values of each lane's brick begin (or less than 0); sets what the lane needs to know
  /// about its brick or, where nothing is stored, about the largest empty node around it.
  HWY_INLINE VI locate() {
    const VI one = hn::Set(di, 1);
    VI cell[3];  // counted from the table's border
    for (int axis = 0; axis < 3; ++axis)
      cell[axis] = hn::Add(axes_[axis].cellNow(), hn::Set(di, BrickSlice::kSide));
    const std::int32_t* table = grid_.table.entries().data();
    const auto& stride = grid_.table.topStride();
    int shift = 3 + BrickTable::kNodeBits * (grid_.table.levels() - 1);
    VI entry = hn::ShiftRightSame(cell[0], shift);
    for (int axis = 1; axis < 3; ++axis) {
      entry = hn::Add(entry, hn::Mul(hn::ShiftRightSame(cell[axis], shift),
                                     hn::Set(di, stride[static_cast<std::size_t>(axis)])));
    }
    VI number = hn::GatherIndex(di, table, entry);
    VI last = hn::Set(di, (1 << shift) - 1);  // cell of the node, on each axis
    while (shift > 3) {
      shift -= BrickTable::kNodeBits;
      const auto inner = hn::Gt(number, hn::Set(di, -1));
      if (hn::AllFalse(di, inner))
        break;
      const auto part = [&](int axis) HWY_ATTR {
        return hn::And(hn::ShiftRightSame(cell[axis], shift), hn::Set(di, 7));
      };
      const VI child =
          hn::Or(hn::Or(hn::ShiftLeft<6>(part(2)), hn::ShiftLeft<3>(part(1))), part(0));
      const VI below =
          hn::GatherIndex(di, table, hn::IfThenElseZero(inner, hn::Add(number, child)));
      number = hn::IfThenElse(inner, below, number);
      last = hn::IfThenElse(inner, hn::Set(di, (1 << shift) - 1), last);
    }
    inside_ = hn::Zero(di);
    for (int axis = 0; axis < 3; ++axis) {
      const Axis& a = axes_[axis];
      const VI in = hn::And(cell[axis], last);
      inside_ = hn::Add(inside_, hn::Mul(in, hn::Set(di, grid_.stride[axis])));
      const VI planes = hn::IfThenElse(hn::Gt(a.step, hn::Zero(di)),
                                       hn::Sub(hn::Add(last, one), in), hn::Add(in, one));
      toLeave_[axis] = hn::ConvertTo(df, planes);
      leaves_[axis] =
          MulThenAdd(hn::Add(a.count, hn::Sub(toLeave_[axis], Constant(1))), a.delta, a.first);
    }
    brickEnd_ = hn::Min(Least(leaves_[0], leaves_[1], leaves_[2]), end_);
    return hn::Mul(number, hn::Set(di, grid_.brickStride));
  }

  /// Takes the lanes of `empty` to the end of their brick. A plane count that rounding makes wrong
  /// by one is a step of length zero later, or one taken a rounding too early.
  HWY_INLINE void jump(Mask empty) {
    for (int axis = 0; axis < 3; ++axis) {
      Axis& a = axes_[axis];
      const VF planes =
          hn::Add(hn::Floor(hn::Mul(hn::Sub(brickEnd_, a.next), a.perDelta)), Constant(1));
      const VF within =
          hn::Min(hn::Max(planes, hn::Zero(df)), hn::Sub(toLeave_[axis], Constant(1)));
      const VF passed = hn::IfThenElse(hn::Le(leaves_[axis], brickEnd_), toLeave_[axis], within);
      a.pass(hn::IfThenElseZero(empty, passed));
    }
    s_ = hn::IfThenElse(empty, hn::Max(s_, brickEnd_), s_);
  }

  /// Takes the lanes of `stored` through their brick, cell by cell; the others stand still.
  HWY_INLINE void cross(VI begin, Mask stored) {
    const VF limit = hn::IfThenElse(stored, brickEnd_, s_);
    VI index = hn::Add(begin, inside_);
    VI stride[3];
    for (int axis = 0; axis < 3; ++axis)
      stride[axis] = hn::Mul(axes_[axis].step, hn::Set(di, grid_.stride[axis]));
    Mask active = stored;  // even if the brick ends where it begins, by rounding: that plane is yet
                           // to be passed
    do {
      const VF to = hn::Max(s_, hn::Min(Least(axes_[0].next, axes_[1].next, axes_[2].next), limit));
      cells_.add(grid_, hn::IfThenElseZero(ForInts(active), index), s_, hn::Sub(to, s_), active,
                 axes_);
      for (int axis = 0; axis < 3; ++axis) {
        const Mask passes = hn::And(active, hn::Le(axes_[axis].next, to));
        axes_[axis].pass(hn::IfThenElseZero(passes, Constant(1)));
        index = hn::Add(index, hn::IfThenElseZero(ForInts(passes), stride[axis]));
      }
      s_ = to;
      active = hn::Lt(s_, limit);
    } while (!hn::AllFalse(df, active));
  }

  const MarchGrid& grid_;
  Cells cells_;
  Axis axes_[3];
  VF s_, end_;
  VF toLeave_[3];  ///< planes to pass to leave the brick by this axis
  VF leaves_[3];   ///< s at which that happens
  VF brickEnd_;    ///< s at which the ray leaves the brick, or ends in it
  VI inside_;      ///< index of the cell's value within its brick
};

template <class Cells>
void MarchAll(const MarchGrid& grid, const RayLanes& rays, std::size_t count, LaneResults& results,
              MarchCounts& counts) {
  for (std::size_t lane = 0; lane < count; lane += hn::Lanes(df)) {
    Packet<Cells> packet(grid, rays, lane);
    packet.run(counts);
    packet.store(results, lane);
  }
}

void March(const MarchGrid& grid, const RayLanes& rays, std::size_t count, LaneResults& results,
           MarchCounts& counts) {
  const bool rgb = grid.channels == 3;
  if (grid.shaded) {
    const bool emits = grid.emissionChannel >= 0;
    if (emits && grid.lightChannel < 0) {
      MarchAll<GlowingCells<Light::kNone>>(grid, rays, count, results, counts);
    } else if (emits) {
      (grid.oneColor ? MarchAll<GlowingCells<Light::kOneColor>>
                     : MarchAll<GlowingCells<Light::kPacked>>)(grid, rays, count, results, counts);
    } else {
      (grid.oneColor ? MarchAll<LitCells<Light::kOneColor>>
                     : MarchAll<LitCells<Light::kPacked>>)(grid, rays, count, results, counts);
    }
  } else if (rgb && grid.extinctionScale != 0) {
    (grid.trilinear ? MarchAll<TrilinearAbsorbing> : MarchAll<BoxAbsorbing>)(grid, rays, count,
                                                                             results, counts);
  } else if (rgb) {
    (grid.trilinear ? MarchAll<TrilinearLine<3>> : MarchAll<BoxLine<3>>)(grid, rays, count, results,
                                                                         counts);
  } else {
    (grid.trilinear ? MarchAll<TrilinearLine<1>> : MarchAll<BoxLine<1>>)(grid, rays, count, results,
                                                                         counts);
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace volute

HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volute {
namespace {

HWY_EXPORT(March);

void setLane(RayLanes& rays, std::size_t lane, const CellGrid& cells, const Segment& segment,
             const CellEntry& entry) {
  for (int axis = 0; axis < 3; ++axis) {
    const double direction = segment.direction[axis];
    const double cell = cells.cell[axis];
    rays.cell[axis][lane] = entry.cell[axis];
    rays.step[axis][lane] = entry.step[axis];
    const double first = entry.crossing[axis] - entry.begin;
    const bool meets = entry.step[axis] != 0 && first < kFarAway;
    if (meets) {
      rays.first[axis][lane] = static_cast<float>(first);
      rays.delta[axis][lane] = static_cast<float>(std::min(cell / std::abs(direction), kFarAway));
      rays.perDelta[axis][lane] = static_cast<float>(std::abs(direction) / cell);
      rays.velocity[axis][lane] = static_cast<float>(direction / cell);
      rays.exitAt[axis][lane] = direction > 0 ? 1 : 0;
    } else {
      const double start = segment.origin[axis] + (direction == 0 ? 0 : entry.begin * direction);
      rays.first[axis][lane] = kNever;
      rays.delta[axis][lane] = 0;
      rays.perDelta[axis][lane] = 0;
      rays.velocity[axis][lane] = 0;
      rays.exitAt[axis][lane] =
          static_cast<float>((start - cells.plane(axis, entry.cell[axis])) / cell);
    }
  }
  rays.length[lane] = static_cast<float>(entry.end - entry.begin);
}

/// A lane without a ray: it has no length, and stands in the first cell.
void setIdle(RayLanes& rays, std::size_t lane) {
  for (int axis = 0; axis < 3; ++axis) {
    rays.cell[axis][lane] = rays.step[axis][lane] = 0;
    rays.first[axis][lane] = kNever;
    rays.delta[axis][lane] = rays.perDelta[axis][lane] = 0;
    rays.velocity[axis][lane] = rays.exitAt[axis][lane] = 0;
  }
  rays.length[lane] = 0;
}

Radiance lightOf(const MarchGrid& grid, const LaneResults& results, std::size_t lane) {
  Radiance light;
  if (grid.shaded) {
    for (int c = 0; c < 3; ++c) light.emitted[c] = results.sum[c][lane];
    light.transmittance = results.transmittance[lane];
    return light;
  }
  for (int c = 0; c < 3; ++c)
    light.emitted[c] = grid.emissionScale * results.sum[grid.channels == 3 ? c : 0][lane];
  light.transmittance = results.transmittance[lane];
  if (grid.channels == 1 && grid.extinctionScale != 0) {
    // Emission is a multiple of extinction all along, so that the light depends on the optical
    // depth alone.
    const double depth = grid.extinctionScale * results.sum[0][lane];
    light.transmittance = std::exp(-depth);
    if (depth != 0)
      light.emitted *= -std::expm1(-depth) / depth;
  }
  return light;
}

void marchBatch(const MarchGrid& grid, const CellGrid& cells, const CellRange& range,
                std::span<const Segment> segments, std::span<Radiance> out, MarchCounts& counts) {
  constexpr std::size_t kWidest = 16;
  RayLanes rays;
  LaneResults results;
  std::size_t lanes = 0;
  std::size_t segmentOf[kMaxLanes];
  for (std::size_t i = 0; i < segments.size(); ++i) {
    CellEntry entry;
    if (enterCells(cells, range, segments[i], entry)) {
      segmentOf[lanes] = i;
      setLane(rays, lanes++, cells, segments[i], entry);
    } else {
      out[i] = Radiance{};
    }
  }
  for (std::size_t lane = lanes; lane % kWidest != 0; ++lane) setIdle(rays, lane);
  HWY_DYNAMIC_DISPATCH(March)(grid, rays, lanes, results, counts);
  for (std::size_t lane = 0; lane < lanes; ++lane)
    out[segmentOf[lane]] = lightOf(grid, results, lane);
}

}  // namespace

void marchRadiance(const MarchGrid& grid, const CellGrid& cells, const CellRange& range,
                   std::span<const Segment> segments, std::span<Radiance> out,
                   MarchCounts& counts) {
  for (std::size_t i = 0; i < segments.size(); i += kMaxLanes) {
    const std::size_t count = std::min(kMaxLanes, segments.size() - i);
    marchBatch(grid, cells, range, segments.subspan(i, count), out.subspan(i, count), counts);
  }
}

}  // namespace volute
#endif  // HWY_ONCE
