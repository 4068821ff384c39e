// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// Rays walk side by side, one in each lane, and write down what they pass: a few steps at a time,
// which stay in the innermost cache. Then the weights of one ray after the other meet the values, a
// node's colours in one vector: rays in lanes would need gathers there, and the transpose scatters
// with conflicts.

#include "volute/tomography/ray_kernels.hpp"

#include <algorithm>
#include <cmath>

// The fallback needs vectors of four. The compiler's bug that makes Highway avoid them (GCC 106322)
// concerns 16-bit integers.
#define HWY_BROKEN_EMU128 0
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volute/tomography/ray_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "volute/math/float_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();

namespace volute {
namespace HWY_NAMESPACE {
namespace {
using D4 = hn::FixedTag<float, 4>;
using V4 = hn::Vec<D4>;
constexpr D4 d4;

constexpr std::size_t kLanes = hn::MaxLanes(df);

constexpr float kNever = 1e30F;
constexpr int kSteps = 8;  // between two turns of the values

/// Nodes that a step of a ray is done with. Trilinear: the four corners of the face of its cell
/// that lies behind it, with all weight that they get from this ray. Box: the cell.
template <Basis kBasis>
constexpr int kNodesAStep = kBasis == Basis::kBox ? 1 : 4;

/// What the rays of a group passed in up to kSteps steps.
template <Basis kBasis>
struct Passed {
  static constexpr int kNodes = kNodesAStep<kBasis>;
  alignas(64) std::int32_t steps[kLanes];  ///< of each ray
  alignas(64) std::int32_t node[kSteps][kNodes][kLanes];
  alignas(64) float weight[kSteps][kNodes][kLanes];
};

/// A place in each ray's cell, or a length along its axes.
struct Vec3F {
  VF x, y, z;
};

HWY_INLINE VI Select(Mask mask, VI yes, VI no) {
  return hn::IfThenElse(hn::RebindMask(di, mask), yes, no);
}

/// The rays of a group from cell to cell. Each is mirrored so that it goes upwards on all axes: it
/// enters cells at 0 and leaves them at 1, and strides carry the sign.
template <Basis kBasis>
class Group {
 public:
  HWY_INLINE Group(const WalkLattice& lattice, const WalkRay* rays, std::size_t count) {
    alignas(64) float place[3][kLanes] = {}, speed[3][kLanes] = {}, left[kLanes] = {};
    alignas(64) std::int32_t stride[3][kLanes] = {}, node[kLanes] = {};
    for (std::size_t i = 0; i < count; ++i) {
      left[i] = std::max(rays[i].length, 0.0F);
      node[i] = rays[i].node;
      for (int a = 0; a < 3; ++a) {
        const bool down = rays[i].velocity[a] < 0;
        place[a][i] = down ? 1 - rays[i].position[a] : rays[i].position[a];
        speed[a][i] = std::abs(rays[i].velocity[a]);
        stride[a][i] = down ? -lattice.stride[a] : lattice.stride[a];
        // The corner that the ray comes from; a box has but one node.
        node[i] += down && kBasis == Basis::kTrilinear ? lattice.stride[a] : 0;
      }
    }
    place_ = {hn::Load(df, place[0]), hn::Load(df, place[1]), hn::Load(df, place[2])};
    speed_ = {hn::Load(df, speed[0]), hn::Load(df, speed[1]), hn::Load(df, speed[2])};
    inverse_ = {inverseOf(speed_.x), inverseOf(speed_.y), inverseOf(speed_.z)};
    left_ = hn::Load(df, left);
    before_ = left_;
    node_ = hn::Load(di, node);
    for (int a = 0; a < 3; ++a) stride_[a] = hn::Load(di, stride[a]);
    for (VF& corner : corner_) corner = hn::Zero(df);
  }

  HWY_INLINE bool goesOn() const { return !hn::AllFalse(df, hn::Gt(before_, hn::Zero(df))); }

  /// The next steps of all rays.
  HWY_INLINE void walk(Passed<kBasis>& passed) {
    VI steps = hn::Zero(di);
    for (int k = 0; k < kSteps; ++k) {
      // One step more after the end takes the last cell's other face.
      const Mask valid = hn::Gt(before_, hn::Zero(df));
      steps = hn::Add(steps, hn::IfThenElseZero(hn::RebindMask(di, valid), hn::Set(di, 1)));
      step(passed, k);
    }
    hn::Store(steps, di, passed.steps);
  }

 private:
  HWY_INLINE static VF inverseOf(VF speed) {
    const Mask moves = hn::Gt(speed, hn::Set(df, 1e-20F));
    const VF one = hn::Set(df, 1.0F);
    return hn::IfThenElse(moves, hn::Div(one, hn::IfThenElse(moves, speed, one)),
                          hn::Set(df, kNever));
  }

  HWY_INLINE void step(Passed<kBasis>& passed, int k) {
    const VF one = hn::Set(df, 1.0F);
    const VF toX = hn::Mul(hn::Sub(one, place_.x), inverse_.x);
    const VF toY = hn::Mul(hn::Sub(one, place_.y), inverse_.y);
    const VF toZ = hn::Mul(hn::Sub(one, place_.z), inverse_.z);
    const VF least = hn::Min(hn::Min(toX, toY), hn::Min(toZ, left_));
    const VF piece = hn::Max(least, hn::Zero(df));
    before_ = left_;
    left_ = hn::Sub(left_, piece);
    const Vec3F end{hn::MulAdd(speed_.x, piece, place_.x), hn::MulAdd(speed_.y, piece, place_.y),
                    hn::MulAdd(speed_.z, piece, place_.z)};
    // One face at a time. At its end a ray leaves by x, so that all its weight comes out.
    const Mask x = hn::Or(hn::Le(toX, piece), hn::Le(left_, hn::Zero(df)));
    const Mask y = hn::AndNot(x, hn::Le(toY, piece));
    if constexpr (kBasis == Basis::kBox) {
      hn::Store(node_, di, passed.node[k][0]);
      hn::Store(piece, df, passed.weight[k][0]);
    } else {
      addHats(end, piece);
      leaveFace(x, y, passed, k);
    }
    node_ = hn::Add(node_, Select(x, stride_[0], Select(y, stride_[1], stride_[2])));
    const VF zero = hn::Zero(df);
    place_.x = hn::IfThenElse(x, zero, end.x);
    place_.y = hn::IfThenElse(y, zero, end.y);
    place_.z = hn::IfThenElse(hn::Or(x, y), end.z, zero);
  }

  /// Adds the integrals of the cell's eight hat functions over a piece: a product of three linear
  /// functions is a cubic, so two Gauss points are exact.
  HWY_INLINE void addHats(const Vec3F& end, VF piece) {
    const VF half = hn::Mul(piece, hn::Set(df, 0.5F));
    const Vec3F across{hn::Sub(end.x, place_.x), hn::Sub(end.y, place_.y),
                       hn::Sub(end.z, place_.z)};
    VF a[4], b[4], zA, zB;
    hatsAt(across, hn::Set(df, 0.21132487F), half, a, zA);
    hatsAt(across, hn::Set(df, 0.78867513F), half, b, zB);
    for (int i = 0; i < 4; ++i) {
      const VF far = hn::MulAdd(b[i], zB, hn::Mul(a[i], zA));
      const VF both = hn::Add(a[i], b[i]);
      corner_[4 + i] = hn::Add(corner_[4 + i], far);
      corner_[i] = hn::Add(corner_[i], hn::Sub(both, far));
    }
  }

  /// The hats in x and y, x the faster, and the place on z.
  HWY_INLINE void hatsAt(const Vec3F& across, VF share, VF scale, VF xy[4], VF& z) const {
    const VF x = hn::MulAdd(across.x, share, place_.x);
    const VF y = hn::MulAdd(across.y, share, place_.y);
    z = hn::MulAdd(across.z, share, place_.z);
    const VF far = hn::Mul(scale, x), near = hn::Sub(scale, far);
    xy[3] = hn::Mul(far, y);
    xy[1] = hn::Sub(far, xy[3]);
    xy[2] = hn::Mul(near, y);
    xy[0] = hn::Sub(near, xy[2]);
  }

  /// Writes down the corners behind the ray, and makes those ahead of it the ones behind. Corner
  /// 1 x + 2 y + 4 z has 1 for ahead.
  HWY_INLINE void leaveFace(Mask x, Mask y, Passed<kBasis>& passed, int k) {
    VF* c = corner_;
    const Mask z = hn::Not(hn::Or(x, y));
    const VI first = hn::Add(node_, Select(x, stride_[1], stride_[0]));
    const VI second = Select(z, stride_[1], stride_[2]);
    hn::Store(node_, di, passed.node[k][0]);
    hn::Store(first, di, passed.node[k][1]);
    hn::Store(hn::Add(node_, second), di, passed.node[k][2]);
    hn::Store(hn::Add(first, second), di, passed.node[k][3]);
    hn::Store(c[0], df, passed.weight[k][0]);
    hn::Store(hn::IfThenElse(x, c[2], c[1]), df, passed.weight[k][1]);
    hn::Store(hn::IfThenElse(z, c[2], c[4]), df, passed.weight[k][2]);
    hn::Store(hn::IfThenElse(x, c[6], hn::IfThenElse(y, c[5], c[3])), df, passed.weight[k][3]);
    c[0] = hn::IfThenElse(x, c[1], hn::IfThenElse(y, c[2], c[4]));
    c[1] = hn::IfThenZeroElse(x, hn::IfThenElse(y, c[3], c[5]));
    c[2] = hn::IfThenElse(x, c[3], hn::IfThenElseZero(z, c[6]));
    c[3] = hn::IfThenElseZero(z, c[7]);
    c[4] = hn::IfThenElse(x, c[5], hn::IfThenElseZero(y, c[6]));
    c[5] = hn::IfThenElseZero(y, c[7]);
    c[6] = hn::IfThenElseZero(x, c[7]);
    c[7] = hn::Zero(df);
  }

  Vec3F place_, speed_, inverse_;
  VF left_, before_;  // [m] to the end, now and a step ago
  VI node_, stride_[3];
  VF corner_[8];  // weights that are not written down yet
};

template <class T>
HWY_INLINE T* At(T* values, std::int32_t node) {
  return values + 4 * static_cast<std::ptrdiff_t>(node);
}

// What is done with what a ray passed. Classes, as compilers do not inline lambdas of another
// target.

/// Sums values up, for each ray.
struct Gather {
  const float* values;
  alignas(16) float sum[kLanes][4] = {};

  HWY_INLINE explicit Gather(const float* from) : values(from) {}

  template <Basis kBasis>
  HWY_INLINE void take(std::size_t ray, const Passed<kBasis>& passed) {
    constexpr int kNodes = kNodesAStep<kBasis>;
    // Four sums, so that additions need not wait for each other.
    V4 part[4] = {hn::Load(d4, sum[ray]), hn::Zero(d4), hn::Zero(d4), hn::Zero(d4)};
    for (int k = 0; k < passed.steps[ray]; ++k) {
      for (int i = 0; i < kNodes; ++i)
        part[i] = hn::MulAdd(hn::Set(d4, passed.weight[k][i][ray]),
                             hn::LoadU(d4, At(values, passed.node[k][i][ray])), part[i]);
    }
    hn::Store(hn::Add(hn::Add(part[0], part[1]), hn::Add(part[2], part[3])), d4, sum[ray]);
  }
};

/// Adds a value of each ray where it passed.
struct Scatter {
  float* gradient;
  alignas(16) float value[kLanes][4];

  HWY_INLINE explicit Scatter(float* to) : gradient(to) {}

  template <Basis kBasis>
  HWY_INLINE void take(std::size_t ray, const Passed<kBasis>& passed) const {
    const V4 v = hn::Load(d4, value[ray]);
    for (int k = 0; k < passed.steps[ray]; ++k) {
      for (int i = 0; i < kNodesAStep<kBasis>; ++i) {
        float* at = At(gradient, passed.node[k][i][ray]);
        hn::StoreU(hn::MulAdd(hn::Set(d4, passed.weight[k][i][ray]), v, hn::LoadU(d4, at)), d4, at);
      }
    }
  }
};

/// Appends the weights to the list of each ray's row.
struct Append {
  std::vector<NodeWeight>* out;
  int raysPerRow;

  HWY_INLINE Append(std::vector<NodeWeight>* to, int rays) : out(to), raysPerRow(rays) {}

  template <Basis kBasis>
  HWY_INLINE void take(std::size_t ray, const Passed<kBasis>& passed) const {
    std::vector<NodeWeight>& row = out[ray / raysPerRow];
    const float share = 1.0F / static_cast<float>(raysPerRow);
    for (int k = 0; k < passed.steps[ray]; ++k)
      for (int i = 0; i < kNodesAStep<kBasis>; ++i)
        row.push_back({passed.node[k][i][ray], share * passed.weight[k][i][ray]});
  }
};

/// Walks a group to its end.
template <Basis kBasis, class Visit>
HWY_INLINE void WalkGroup(const WalkLattice& lattice, const WalkRay* rays, std::size_t count,
                          Visit& visit) {
  Passed<kBasis> passed;
  Group<kBasis> group(lattice, rays, count);
  while (group.goesOn()) {
    group.walk(passed);
    for (std::size_t ray = 0; ray < count; ++ray) visit.take(ray, passed);
  }
}

// Groups of whole rows: a row has 1 or 4 rays, and a group 4 or more.

template <Basis kBasis>
void ForwardRows(const WalkLattice& lattice, const float* values, const WalkRay* rays,
                 std::size_t rows, int raysPerRow, float* sums) {
  const V4 share = hn::Set(d4, 1.0F / static_cast<float>(raysPerRow));
  const std::size_t rowsAtOnce = kLanes / raysPerRow;
  for (std::size_t first = 0; first < rows; first += rowsAtOnce) {
    const std::size_t count = std::min(rowsAtOnce, rows - first);
    Gather gather(values);
    WalkGroup<kBasis>(lattice, rays + first * raysPerRow, count * raysPerRow, gather);
    for (std::size_t row = 0; row < count; ++row) {
      V4 sum = hn::Load(d4, gather.sum[row * raysPerRow]);
      for (int i = 1; i < raysPerRow; ++i)
        sum = hn::Add(sum, hn::Load(d4, gather.sum[row * raysPerRow + i]));
      hn::StoreU(hn::Mul(sum, share), d4, sums + 4 * (first + row));
    }
  }
}

template <Basis kBasis>
void AdjointRows(const WalkLattice& lattice, const float* rowValues, const WalkRay* rays,
                 std::size_t rows, int raysPerRow, float* gradient) {
  const V4 share = hn::Set(d4, 1.0F / static_cast<float>(raysPerRow));
  const std::size_t rowsAtOnce = kLanes / raysPerRow;
  for (std::size_t first = 0; first < rows; first += rowsAtOnce) {
    const std::size_t count = std::min(rowsAtOnce, rows - first);
    Scatter scatter(gradient);
    for (std::size_t ray = 0; ray < count * raysPerRow; ++ray)
      hn::Store(hn::Mul(hn::LoadU(d4, rowValues + 4 * (first + ray / raysPerRow)), share), d4,
                scatter.value[ray]);
    WalkGroup<kBasis>(lattice, rays + first * raysPerRow, count * raysPerRow, scatter);
  }
}

template <Basis kBasis>
void WeightRows(const WalkLattice& lattice, const WalkRay* rays, std::size_t rows, int raysPerRow,
                std::vector<NodeWeight>* out) {
  const std::size_t rowsAtOnce = kLanes / raysPerRow;
  for (std::size_t first = 0; first < rows; first += rowsAtOnce) {
    const std::size_t count = std::min(rowsAtOnce, rows - first);
    Append append(out + first, raysPerRow);
    WalkGroup<kBasis>(lattice, rays + first * raysPerRow, count * raysPerRow, append);
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

void Weights(const WalkLattice& lattice, const WalkRay* rays, std::size_t rows, int raysPerRow,
             std::vector<NodeWeight>* out) {
  (lattice.basis == Basis::kBox
       ? WeightRows<Basis::kBox>
       : WeightRows<Basis::kTrilinear>)(lattice, rays, rows, raysPerRow, out);
}

void Table(const NodeWeight* table, const std::uint64_t* begin, std::size_t rows,
           const float* values, float* sums) {
  for (std::size_t row = 0; row < rows; ++row) {
    V4 part[4] = {hn::Zero(d4), hn::Zero(d4), hn::Zero(d4), hn::Zero(d4)};
    std::uint64_t i = begin[row];
    const std::uint64_t end = begin[row + 1];
    for (; i + 4 <= end; i += 4)
      for (int j = 0; j < 4; ++j)
        part[j] = hn::MulAdd(hn::Set(d4, table[i + j].weight),
                             hn::LoadU(d4, At(values, table[i + j].node)), part[j]);
    for (; i < end; ++i)
      part[0] = hn::MulAdd(hn::Set(d4, table[i].weight), hn::LoadU(d4, At(values, table[i].node)),
                           part[0]);
    hn::StoreU(hn::Add(hn::Add(part[0], part[1]), hn::Add(part[2], part[3])), d4, sums + 4 * row);
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

void walkWeights(const WalkLattice& lattice, const WalkRay* rays, std::size_t rows, int raysPerRow,
                 std::vector<NodeWeight>* out) {
  HWY_DYNAMIC_DISPATCH(Weights)(lattice, rays, rows, raysPerRow, out);
}

void tableSums(const NodeWeight* table, const std::uint64_t* begin, std::size_t rows,
               const float* values, float* sums) {
  HWY_DYNAMIC_DISPATCH(Table)(table, begin, rows, values, sums);
}

}  // namespace volute
#endif  // HWY_ONCE
