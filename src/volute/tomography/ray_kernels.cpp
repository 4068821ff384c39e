// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// One ray at a time: its place in a vector of x, y, z, a voxel's colours in another. Rays in lanes
// would need gathers for 24 values a cell, and the transpose would need scatters with conflicts.

#include "volute/tomography/ray_kernels.hpp"

#include <cmath>

// The fallback needs vectors of four. The compiler's bug that makes Highway avoid them (GCC 106322)
// concerns 16-bit integers.
#define HWY_BROKEN_EMU128 0
#define HWY_DISABLED_TARGETS \
  (HWY_SSSE3 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volute/tomography/ray_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();

namespace volute {
namespace HWY_NAMESPACE {
namespace {
namespace hn = hwy::HWY_NAMESPACE;

using D4 = hn::FixedTag<float, 4>;
using V4 = hn::Vec<D4>;
constexpr D4 d4;

constexpr float kNever = 1e30F;

/// The walk of one ray from cell to cell.
class Walk {
 public:
  HWY_INLINE Walk(const WalkLattice& lattice, const WalkRay& ray)
      : length_(ray.length), node_(ray.node) {
    alignas(16) float position[4], velocity[4], inverse[4], exit[4], enter[4];
    std::int32_t step[3];
    for (int a = 0; a < 3; ++a) {
      position[a] = ray.position[a];
      velocity[a] = ray.velocity[a];
      const bool moves = std::abs(velocity[a]) > 1e-20F;
      inverse[a] = moves ? 1 / velocity[a] : kNever;
      exit[a] = velocity[a] < 0 ? 0.0F : 1.0F;
      enter[a] = 1 - exit[a];
      step[a] = velocity[a] < 0 ? -lattice.stride[a] : lattice.stride[a];
    }
    position[3] = velocity[3] = enter[3] = 0;
    exit[3] = 1, inverse[3] = kNever;
    for (int i = 0; i < 16; ++i)
      jump_[i] = (i & 1 ? step[0] : 0) + (i & 2 ? step[1] : 0) + (i & 4 ? step[2] : 0);
    begin_ = hn::Load(d4, position);
    velocity_ = hn::Load(d4, velocity);
    inverse_ = hn::Load(d4, inverse);
    exit_ = hn::Load(d4, exit);
    enter_ = hn::Load(d4, enter);
  }

  HWY_INLINE bool goesOn() const { return s_ < length_; }

  /// To where the ray leaves its present cell: begin(), end(), piece() and node() then describe the
  /// piece inside of it, until pass().
  HWY_INLINE void cross() {
    toPlane_ = hn::Mul(hn::Sub(exit_, begin_), inverse_);
    V4 least = hn::Min(toPlane_, hn::Shuffle2301(toPlane_));
    least = hn::Min(least, hn::Shuffle1032(least));
    least = hn::Min(least, hn::Set(d4, length_ - s_));
    piece_ = hn::Max(least, hn::Zero(d4));
    end_ = hn::MulAdd(velocity_, piece_, begin_);
  }

  HWY_INLINE void pass() {
    const auto passes = hn::Le(toPlane_, piece_);
    alignas(8) std::uint8_t bits[8];
    hn::StoreMaskBits(d4, passes, bits);
    begin_ = hn::IfThenElse(passes, enter_, end_);
    node_ += jump_[bits[0] & 15];
    s_ += hn::GetLane(piece_);
  }

  HWY_INLINE V4 begin() const { return begin_; }

  HWY_INLINE V4 end() const { return end_; }

  HWY_INLINE V4 piece() const { return piece_; }  ///< its length [m] in all lanes

  HWY_INLINE std::int32_t node() const { return node_; }

 private:
  V4 begin_, velocity_, inverse_, exit_, enter_;
  V4 end_, toPlane_, piece_;
  float s_ = 0;
  float length_;
  std::int32_t node_;
  std::int32_t jump_[16];
};

/// The integrals of the eight hat functions over a piece: a product of three linear functions is a
/// cubic, so two Gauss points are exact.
struct HatWeights {
  V4 low, high;  ///< at the lower and upper z; x is the faster of the four

  HWY_INLINE explicit HatWeights(const Walk& walk) {
    const V4 across = hn::Sub(walk.end(), walk.begin());
    const V4 half = hn::Mul(walk.piece(), hn::Set(d4, 0.5F));
    V4 xy, below, above;
    at(hn::MulAdd(across, hn::Set(d4, 0.21132487F), walk.begin()), half, xy, below, above);
    low = hn::Mul(xy, below);
    high = hn::Mul(xy, above);
    at(hn::MulAdd(across, hn::Set(d4, 0.78867513F), walk.begin()), half, xy, below, above);
    low = hn::MulAdd(xy, below, low);
    high = hn::MulAdd(xy, above, high);
  }

 private:
  HWY_INLINE static void at(V4 place, V4 scale, V4& xy, V4& below, V4& above) {
    const V4 rest = hn::Sub(hn::Set(d4, 1.0F), place);
    const V4 xThenY = hn::InterleaveLower(d4, rest, place);  // 1-x, x, 1-y, y
    const V4 z = hn::InterleaveUpper(d4, rest, place);       // 1-z, z, .., ..
    const V4 x = hn::ConcatLowerLower(d4, xThenY, xThenY);
    const V4 y = hn::InterleaveUpper(d4, xThenY, xThenY);
    xy = hn::Mul(hn::Mul(x, y), scale);
    below = hn::Broadcast<0>(z);
    above = hn::Broadcast<1>(z);
  }
};

/// visit(node, weight in all lanes, number) for the eight corners of a cell.
template <class Visit>
HWY_INLINE void ForCorners(const WalkLattice& lattice, std::int32_t node, const HatWeights& w,
                           Visit& visit) {
  const std::int32_t y = node + lattice.stride[1], z = node + lattice.stride[2];
  const std::int32_t yz = y + lattice.stride[2];
  visit(node, hn::Broadcast<0>(w.low), 0);
  visit(node + 1, hn::Broadcast<1>(w.low), 1);
  visit(y, hn::Broadcast<2>(w.low), 2);
  visit(y + 1, hn::Broadcast<3>(w.low), 3);
  visit(z, hn::Broadcast<0>(w.high), 4);
  visit(z + 1, hn::Broadcast<1>(w.high), 5);
  visit(yz, hn::Broadcast<2>(w.high), 6);
  visit(yz + 1, hn::Broadcast<3>(w.high), 7);
}

/// visit(node, weight in all lanes, a number 0..7 to tell corners apart) for all that a ray
/// reaches.
template <Basis kBasis, class Visit>
HWY_INLINE void ForWeights(const WalkLattice& lattice, const WalkRay& ray, Visit& visit) {
  for (Walk walk(lattice, ray); walk.goesOn(); walk.pass()) {
    walk.cross();
    const std::int32_t node = walk.node();
    if (kBasis == Basis::kBox)
      visit(node, walk.piece(), 0);
    else
      ForCorners(lattice, node, HatWeights(walk), visit);
  }
}

template <class T>
HWY_INLINE T* At(T* values, std::int32_t node) {
  return values + 4 * static_cast<std::ptrdiff_t>(node);
}

// What is done with each weight. Classes, as compilers do not inline lambdas of another target.

struct Gather {
  const float* values;
  // Four sums, so that additions need not wait for each other.
  V4 sum[4] = {hn::Zero(d4), hn::Zero(d4), hn::Zero(d4), hn::Zero(d4)};

  HWY_INLINE explicit Gather(const float* from) : values(from) {}

  HWY_INLINE void operator()(std::int32_t node, V4 weight, int corner) {
    V4& part = sum[corner & 3];
    part = hn::MulAdd(weight, hn::LoadU(d4, At(values, node)), part);
  }

  HWY_INLINE V4 total() const { return hn::Add(hn::Add(sum[0], sum[1]), hn::Add(sum[2], sum[3])); }
};

struct Scatter {
  V4 value;
  float* gradient;

  HWY_INLINE Scatter(V4 what, float* to) : value(what), gradient(to) {}

  HWY_INLINE void operator()(std::int32_t node, V4 weight, int) {
    float* at = At(gradient, node);
    hn::StoreU(hn::MulAdd(weight, value, hn::LoadU(d4, at)), d4, at);
  }
};

struct Append {
  std::vector<NodeWeight>& out;
  float share;

  HWY_INLINE Append(std::vector<NodeWeight>& to, float factor) : out(to), share(factor) {}

  HWY_INLINE void operator()(std::int32_t node, V4 weight, int) {
    out.push_back({node, share * hn::GetLane(weight)});
  }
};

template <Basis kBasis>
void ForwardRows(const WalkLattice& lattice, const float* values, const WalkRay* rays,
                 std::size_t rows, int raysPerRow, float* sums) {
  const V4 share = hn::Set(d4, 1.0F / static_cast<float>(raysPerRow));
  for (std::size_t row = 0; row < rows; ++row) {
    Gather gather(values);
    for (int i = 0; i < raysPerRow; ++i) ForWeights<kBasis>(lattice, *rays++, gather);
    hn::StoreU(hn::Mul(gather.total(), share), d4, sums + 4 * row);
  }
}

template <Basis kBasis>
void AdjointRows(const WalkLattice& lattice, const float* rowValues, const WalkRay* rays,
                 std::size_t rows, int raysPerRow, float* gradient) {
  const V4 share = hn::Set(d4, 1.0F / static_cast<float>(raysPerRow));
  for (std::size_t row = 0; row < rows; ++row) {
    Scatter scatter(hn::Mul(hn::LoadU(d4, rowValues + 4 * row), share), gradient);
    for (int i = 0; i < raysPerRow; ++i) ForWeights<kBasis>(lattice, *rays++, scatter);
  }
}

void Forward(const WalkLattice& lattice, const float* values, const WalkRay* rays, std::size_t rows,
             int raysPerRow, float* sums) {
  (lattice.basis == Basis::kBox
       ? ForwardRows<Basis::kBox>
       : ForwardRows<Basis::kTrilinear>)(lattice, values, rays, rows, raysPerRow, sums);
}

void Adjoint(const WalkLattice& lattice, const float* rowValues, const WalkRay* rays,
             std::size_t rows, int raysPerRow, float* gradient) {
  (lattice.basis == Basis::kBox
       ? AdjointRows<Basis::kBox>
       : AdjointRows<Basis::kTrilinear>)(lattice, rowValues, rays, rows, raysPerRow, gradient);
}

void Weights(const WalkLattice& lattice, const WalkRay* rays, int raysPerRow,
             std::vector<NodeWeight>& out) {
  Append append(out, 1.0F / static_cast<float>(raysPerRow));
  for (int i = 0; i < raysPerRow; ++i) {
    if (lattice.basis == Basis::kBox)
      ForWeights<Basis::kBox>(lattice, rays[i], append);
    else
      ForWeights<Basis::kTrilinear>(lattice, rays[i], append);
  }
}

void Table(const NodeWeight* table, const std::uint64_t* begin, std::size_t rows,
           const float* values, float* sums) {
  for (std::size_t row = 0; row < rows; ++row) {
    Gather gather(values);
    std::uint64_t i = begin[row];
    const std::uint64_t end = begin[row + 1];
    for (; i + 4 <= end; i += 4) {
      gather(table[i].node, hn::Set(d4, table[i].weight), 0);
      gather(table[i + 1].node, hn::Set(d4, table[i + 1].weight), 1);
      gather(table[i + 2].node, hn::Set(d4, table[i + 2].weight), 2);
      gather(table[i + 3].node, hn::Set(d4, table[i + 3].weight), 3);
    }
    for (; i < end; ++i) gather(table[i].node, hn::Set(d4, table[i].weight), 0);
    hn::StoreU(gather.total(), d4, sums + 4 * row);
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
HWY_EXPORT(Weights);
HWY_EXPORT(Table);

void walkForward(const WalkLattice& lattice, const float* values, const WalkRay* rays,
                 std::size_t rows, int raysPerRow, float* sums) {
  HWY_DYNAMIC_DISPATCH(Forward)(lattice, values, rays, rows, raysPerRow, sums);
}

void walkAdjoint(const WalkLattice& lattice, const float* rowValues, const WalkRay* rays,
                 std::size_t rows, int raysPerRow, float* gradient) {
  HWY_DYNAMIC_DISPATCH(Adjoint)(lattice, rowValues, rays, rows, raysPerRow, gradient);
}

void walkWeights(const WalkLattice& lattice, const WalkRay* rays, int raysPerRow,
                 std::vector<NodeWeight>& out) {
  HWY_DYNAMIC_DISPATCH(Weights)(lattice, rays, raysPerRow, out);
}

void tableSums(const NodeWeight* table, const std::uint64_t* begin, std::size_t rows,
               const float* values, float* sums) {
  HWY_DYNAMIC_DISPATCH(Table)(table, begin, rows, values, sums);
}

}  // namespace volute
#endif  // HWY_ONCE
