// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// Beams walk side by side, one in each lane, slab by slab. In a slab, the weights of the nodes of
// both planes are summed up over all rays of the beam; so nodes that several rays share are read
// and written once. Then the weights of one beam after the other meet the values, four nodes in a
// row.

#include "volute/tomography/beam_kernels.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

// The fallback needs vectors of four. The compiler's bug that makes Highway avoid them (GCC 106322)
// concerns 16-bit integers.
#define HWY_BROKEN_EMU128 0
#define HWY_DISABLED_TARGETS \
  (HWY_SSSE3 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volute/tomography/beam_kernels.cpp"
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

constexpr int kLanes = static_cast<int>(hn::MaxLanes(df));

constexpr int kSide = kBeamNodes;
constexpr int kRays = kBeamRays;
constexpr int kPieces = 3;  // of a ray in a slab: it crosses one line of nodes on each axis at most
constexpr int kPoints =
    2;  // of Gauss' rule on a piece: a product of three linear functions is a cubic
constexpr float kNever = 1e30F;
constexpr int kNodesAVector = kLanes / 4;  // colours in a vector

/// The weights of a slab. A row is kSide nodes along the first axis of the plane; those of one beam
/// stand together.
struct SlabWeights {
  int rows;                               ///< that any beam reaches, from the anchor on
  alignas(64) std::int32_t node[kLanes];  ///< the anchor in the near plane
  alignas(64) float weight[2][kSide][4 * kLanes];

  /// Of a beam in the near (0) or far (1) plane.
  HWY_INLINE const float* row(int plane, int row, int beam) const {
    return &weight[plane][row][4 * ((beam % 4) * (kLanes / 4) + beam / 4)];
  }
};

/// Hat functions of the first kNodes nodes at a place 0..kNodes-1, and beyond those of the outer
/// ones.
template <int kNodes>
HWY_INLINE void HatsAt(VF place, VF* hat) {
  const VF zero = hn::Zero(df), one = hn::Set(df, 1.0F);
  VF x = hn::Min(hn::Max(place, zero), hn::Set(df, static_cast<float>(kNodes - 1)));
  // How far each cell is passed: 1 for those before the place, 0 for those after it.
  VF before = one;
  for (int i = 0; i < kNodes - 1; ++i) {
    const VF passed = i == kNodes - 2 ? hn::Max(x, zero) : hn::Min(hn::Max(x, zero), one);
    hat[i] = hn::Sub(before, passed);
    before = passed;
    x = hn::Sub(x, one);
  }
  hat[kNodes - 1] = before;
}

/// Beams side by side, from slab to slab.
class Group {
 public:
  HWY_INLINE Group(const Beam* beams, const BeamRay* rays, int count) {
    alignas(64) std::int32_t node[kLanes] = {}, next[kLanes] = {};
    alignas(64) std::int32_t stride[2][kLanes] = {}, anchor[2][kLanes] = {}, last[2][kLanes] = {};
    for (int i = 0; i < count; ++i) {
      node[i] = beams[i].node;
      next[i] = beams[i].stride[2];
      for (int a = 0; a < 2; ++a) {
        stride[a][i] = beams[i].stride[a];
        anchor[a][i] = beams[i].anchor[a];
        last[a][i] = beams[i].lastAnchor[a];
      }
    }
    node_ = hn::Load(di, node);
    next_ = hn::Load(di, next);
    for (int a = 0; a < 2; ++a) {
      stride_[a] = hn::Load(di, stride[a]);
      anchor_[a] = hn::Load(di, anchor[a]);
      last_[a] = hn::Load(di, last[a]);
    }
    for (int r = 0; r < kRays; ++r) loadRay(rays + r, count, ray_[r]);
  }

  /// The weights of the next slab.
  HWY_INLINE void walk(SlabWeights& out) {
    const VF across = moveAnchor(0), down = moveAnchor(1);
    hn::Store(node_, di, out.node);
    const VF two = hn::Set(df, 2.0F);
    const bool narrow = hn::AllTrue(df, hn::Le(across, two));
    const bool low = hn::AllTrue(df, hn::Le(down, two));
    if (narrow && low)
      addWeights<3, 3>(out);
    else if (low)
      addWeights<4, 3>(out);
    else
      addWeights<4, 4>(out);
    for (Ray& ray : ray_)
      for (int a = 0; a < 2; ++a) ray.place[a] = hn::Add(ray.place[a], ray.slope[a]);
    node_ = hn::Add(node_, next_);
  }

 private:
  struct Ray {
    VF place[2], slope[2], inverse[2], length;
  };

  /// At one point of one ray: the weight of a node is across * down of the near or the far plane.
  struct Factor {
    VF across[kSide], down[2][kSide];
  };

  HWY_INLINE static void loadRay(const BeamRay* rays, int count, Ray& ray) {
    alignas(64) float place[2][kLanes] = {}, slope[2][kLanes] = {}, length[kLanes] = {};
    for (int i = 0; i < count; ++i) {
      const BeamRay& from = rays[i * kRays];
      for (int a = 0; a < 2; ++a) {
        place[a][i] = from.place[a];
        slope[a][i] = from.slope[a];
      }
      length[i] = from.length;
    }
    ray.length = hn::Load(df, length);
    const VF one = hn::Set(df, 1.0F);
    for (int a = 0; a < 2; ++a) {
      ray.place[a] = hn::Load(df, place[a]);
      ray.slope[a] = hn::Load(df, slope[a]);
      const VF steep = hn::Abs(ray.slope[a]);
      const auto moves = hn::Gt(steep, hn::Set(df, 1e-20F));
      ray.inverse[a] = hn::IfThenElse(moves, hn::Div(one, hn::IfThenElse(moves, steep, one)),
                                      hn::Set(df, kNever));
    }
  }

  /// To the lowest place that any ray has in the slab, as far as the lattice goes. Returns the
  /// highest, from there.
  HWY_INLINE VF moveAnchor(int a) {
    VF least = ray_[0].place[a], most = least;
    for (const Ray& ray : ray_) {
      const VF end = hn::Add(ray.place[a], ray.slope[a]);
      least = hn::Min(least, hn::Min(ray.place[a], end));
      most = hn::Max(most, hn::Max(ray.place[a], end));
    }
    const VI wanted = hn::Add(anchor_[a], hn::ConvertTo(di, hn::Floor(least)));
    const VI to = hn::Min(hn::Max(wanted, hn::Zero(di)), last_[a]);
    const VI by = hn::Sub(to, anchor_[a]);
    anchor_[a] = to;
    node_ = hn::Add(node_, hn::Mul(by, stride_[a]));
    const VF shift = hn::ConvertTo(df, by);
    for (Ray& ray : ray_) ray.place[a] = hn::Sub(ray.place[a], shift);
    return hn::Sub(most, shift);
  }

  /// Where, 0..1, a ray crosses the next line of nodes; 1 when it does not.
  HWY_INLINE static VF crossing(const Ray& ray, int a) {
    const VF low = hn::Floor(ray.place[a]), one = hn::Set(df, 1.0F);
    const VF above = hn::Sub(ray.place[a], low);
    const VF way = hn::IfThenElse(hn::Lt(ray.slope[a], hn::Zero(df)), above, hn::Sub(one, above));
    return hn::Min(hn::Mul(way, ray.inverse[a]), one);
  }

  /// The weights of all nodes that any beam reaches in a slab.
  template <int kColumns, int kRows>
  HWY_INLINE void addWeights(SlabWeights& out) const {
    out.rows = kRows;
    Factor factors[kRays * kPieces * kPoints];
    Factor* end = factors;
    for (const Ray& ray : ray_) end = addRay<kColumns, kRows>(ray, end);
    for (int row = 0; row < kRows; ++row) sumRow<kColumns>(factors, end, row, out);
  }

  /// The points on the pieces of a ray that are not empty in all lanes.
  template <int kColumns, int kRows>
  HWY_INLINE static Factor* addRay(const Ray& ray, Factor* out) {
    const VF x = crossing(ray, 0), y = crossing(ray, 1), one = hn::Set(df, 1.0F);
    const VF cut[kPieces + 1] = {hn::Zero(df), hn::Min(x, y), hn::Max(x, y), one};
    for (int piece = 0; piece < kPieces; ++piece) {
      if (piece > 0 && hn::AllTrue(df, hn::Ge(cut[piece], one)))
        break;
      const VF extent = hn::Sub(cut[piece + 1], cut[piece]);
      const VF weight = hn::Mul(hn::Mul(extent, hn::Set(df, 0.5F)), ray.length);
      for (float share : {0.21132487F, 0.78867513F})
        addPoint<kColumns, kRows>(ray, hn::MulAdd(extent, hn::Set(df, share), cut[piece]), weight,
                                  *out++);
    }
    return out;
  }

  template <int kColumns, int kRows>
  HWY_INLINE static void addPoint(const Ray& ray, VF at, VF weight, Factor& out) {
    HatsAt<kColumns>(hn::MulAdd(ray.slope[0], at, ray.place[0]), out.across);
    VF down[kSide];
    HatsAt<kRows>(hn::MulAdd(ray.slope[1], at, ray.place[1]), down);
    const VF far = hn::Mul(weight, at), near = hn::Sub(weight, far);
    for (int i = 0; i < kRows; ++i) {
      out.down[0][i] = hn::Mul(near, down[i]);
      out.down[1][i] = hn::Mul(far, down[i]);
    }
  }

  template <int kColumns>
  HWY_INLINE static void sumRow(const Factor* f, const Factor* end, int row, SlabWeights& out) {
    VF near[kSide], far[kSide];
    for (int i = 0; i < kSide; ++i) near[i] = far[i] = hn::Zero(df);
    for (; f != end; ++f) {
      for (int i = 0; i < kColumns; ++i) {
        near[i] = hn::MulAdd(f->across[i], f->down[0][row], near[i]);
        far[i] = hn::MulAdd(f->across[i], f->down[1][row], far[i]);
      }
    }
    storeByBeam(near, out.weight[0][row]);
    storeByBeam(far, out.weight[1][row]);
  }

  /// Transposes in each block of four beams.
  HWY_INLINE static void storeByBeam(const VF w[kSide], float* out) {
    const VF a = hn::InterleaveLower(df, w[0], w[2]), b = hn::InterleaveLower(df, w[1], w[3]);
    const VF c = hn::InterleaveUpper(df, w[0], w[2]), d = hn::InterleaveUpper(df, w[1], w[3]);
    hn::Store(hn::InterleaveLower(df, a, b), df, out);
    hn::Store(hn::InterleaveUpper(df, a, b), df, out + kLanes);
    hn::Store(hn::InterleaveLower(df, c, d), df, out + 2 * kLanes);
    hn::Store(hn::InterleaveUpper(df, c, d), df, out + 3 * kLanes);
  }

  VI node_, next_, stride_[2], anchor_[2], last_[2];
  Ray ray_[kRays];
};

/// Four weights as factors of the colours of four nodes in a row.
class Spread {
 public:
  HWY_INLINE Spread() {
    alignas(64) std::int32_t lane[kLanes];
    for (int part = 0; part < kSide / kNodesAVector; ++part) {
      for (int i = 0; i < kLanes; ++i) lane[i] = part * kNodesAVector + i / 4;
      index_[part] = hn::Load(di, lane);
    }
  }

  HWY_INLINE VF operator()(const float* weights, int part) const {
    return hn::TableLookupLanes(hn::LoadDup128(df, weights), hn::IndicesFromVec(df, index_[part]));
  }

 private:
  VI index_[kSide / kNodesAVector];
};

/// From row to row and from plane to plane of a beam, in floats.
struct Rows {
  std::ptrdiff_t down, next;

  HWY_INLINE explicit Rows(const Beam& beam)
      : down(4 * static_cast<std::ptrdiff_t>(beam.stride[1])),
        next(4 * static_cast<std::ptrdiff_t>(beam.stride[2])) {}
};

// What is done with the weights of a slab. Classes, as compilers do not inline lambdas of another
// target.

/// Sums up the values that each beam meets.
class Gather {
 public:
  HWY_INLINE explicit Gather(const float* values) : values_(values) {}

  HWY_INLINE void take(const Rows& rows, int beam, const SlabWeights& slab) {
    const float* from = values_ + 4 * static_cast<std::ptrdiff_t>(slab.node[beam]);
    VF total[2] = {hn::Load(df, sum_[beam]), hn::Zero(df)};
    for (int row = 0; row < slab.rows; ++row, from += rows.down)
      for (int plane = 0; plane < 2; ++plane)
        for (int part = 0; part < kSide / kNodesAVector; ++part)
          total[plane] =
              hn::MulAdd(spread_(slab.row(plane, row, beam), part),
                         hn::LoadU(df, from + plane * rows.next + part * kLanes), total[plane]);
    hn::Store(hn::Add(total[0], total[1]), df, sum_[beam]);
  }

  HWY_INLINE V4 sum(int beam) const {
    V4 total = hn::Load(d4, sum_[beam]);
    for (int i = 4; i < kLanes; i += 4) total = hn::Add(total, hn::Load(d4, sum_[beam] + i));
    return total;
  }

 private:
  const float* values_;
  Spread spread_;
  alignas(64) float sum_[kLanes][kLanes] = {};
};

/// Adds a value of each beam to the nodes that it meets.
class Scatter {
 public:
  HWY_INLINE explicit Scatter(float* gradient) : gradient_(gradient) {}

  HWY_INLINE void set(int beam, V4 value) { hn::Store(value, d4, value_[beam]); }

  HWY_INLINE void take(const Rows& rows, int beam, const SlabWeights& slab) const {
    float* to = gradient_ + 4 * static_cast<std::ptrdiff_t>(slab.node[beam]);
    const VF value = hn::LoadDup128(df, value_[beam]);
    for (int row = 0; row < slab.rows; ++row, to += rows.down)
      for (int plane = 0; plane < 2; ++plane)
        for (int part = 0; part < kSide / kNodesAVector; ++part) {
          float* at = to + plane * rows.next + part * kLanes;
          hn::StoreU(
              hn::MulAdd(spread_(slab.row(plane, row, beam), part), value, hn::LoadU(df, at)), df,
              at);
        }
  }

 private:
  float* gradient_;
  Spread spread_;
  alignas(64) float value_[kLanes][4];
};

/// Appends the weights to the list of each beam.
class Append {
 public:
  HWY_INLINE Append(std::vector<NodeWeight>* out, float share) : out_(out), share_(share) {}

  HWY_INLINE void take(const Rows& rows, int beam, const SlabWeights& slab) const {
    const auto down = static_cast<std::int32_t>(rows.down / 4),
               next = static_cast<std::int32_t>(rows.next / 4);
    for (int plane = 0; plane < 2; ++plane)
      for (int row = 0; row < slab.rows; ++row) {
        const float* weight = slab.row(plane, row, beam);
        const std::int32_t first = slab.node[beam] + plane * next + row * down;
        for (int i = 0; i < kSide; ++i) {
          if (weight[i] != 0)
            out_[beam].push_back({first + i, share_ * weight[i]});
        }
      }
  }

 private:
  std::vector<NodeWeight>* out_;
  float share_;
};

int MostSlabs(const Beam* beams, int count) {
  int most = 0;
  for (int i = 0; i < count; ++i) most = std::max(most, static_cast<int>(beams[i].slabs));
  return most;
}

/// Shows slab `k` of each beam of a group to `visit`. Not one after the other: beams side by side
/// write to overlapping stretches of memory, and a vector that was just stored a node further left
/// has to reach the cache before it can be loaded.
template <class Visit>
HWY_INLINE void VisitSlab(const Beam* beams, int count, int k, const SlabWeights& slab,
                          Visit& visit) {
  constexpr int kApart = 5;  // prime to the number of lanes
  for (int step = 0; step < kLanes; ++step) {
    const int i = step * kApart % kLanes;
    if (i < count && k < beams[i].slabs)
      visit.take(Rows(beams[i]), i, slab);
  }
}

template <class Visit>
HWY_INLINE void WalkGroup(const Beam* beams, const BeamRay* rays, int count, Visit& visit) {
  SlabWeights slab;
  Group group(beams, rays, count);
  const int most = MostSlabs(beams, count);
  for (int k = 0; k < most; ++k) {
    group.walk(slab);
    VisitSlab(beams, count, k, slab, visit);
  }
}

/// body(first, count) for groups of beams.
template <class Body>
HWY_INLINE void ForGroups(std::size_t beams, Body& body) {
  for (std::size_t first = 0; first < beams; first += kLanes)
    body.group(first, static_cast<int>(std::min<std::size_t>(kLanes, beams - first)));
}

struct Beams {
  const Beam* beams;
  const BeamRay* rays;
};

struct ForwardBody {
  Beams from;
  const float* values;
  float* sums;

  HWY_INLINE void group(std::size_t first, int count) {
    Gather gather(values);
    WalkGroup(from.beams + first, from.rays + first * kRays, count, gather);
    for (int i = 0; i < count; ++i)
      hn::StoreU(hn::Mul(gather.sum(i), hn::Set(d4, 1.0F / kRays)), d4, sums + 4 * (first + i));
  }
};

struct AdjointBody {
  Beams from;
  const float* beamValues;
  float* gradient;

  HWY_INLINE void group(std::size_t first, int count) {
    Scatter scatter(gradient);
    for (int i = 0; i < count; ++i)
      scatter.set(i,
                  hn::Mul(hn::LoadU(d4, beamValues + 4 * (first + i)), hn::Set(d4, 1.0F / kRays)));
    WalkGroup(from.beams + first, from.rays + first * kRays, count, scatter);
  }
};

struct WeightsBody {
  Beams from;
  std::vector<NodeWeight>* out;

  HWY_INLINE void group(std::size_t first, int count) {
    Append append(out + first, 1.0F / kRays);
    WalkGroup(from.beams + first, from.rays + first * kRays, count, append);
  }
};

struct ThereAndBackBody {
  Beams from;
  const float* values;
  BeamTurn turn;
  const void* context;
  float* sums;
  float* gradient;
  std::vector<SlabWeights>& slabs;

  HWY_INLINE void group(std::size_t first, int count) {
    const Beam* beams = from.beams + first;
    Gather gather(values);
    Group walk(beams, from.rays + first * kRays, count);
    const int most = MostSlabs(beams, count);
    if (slabs.size() < static_cast<std::size_t>(most))
      slabs.resize(most);
    for (int k = 0; k < most; ++k) {
      walk.walk(slabs[k]);
      VisitSlab(beams, count, k, slabs[k], gather);
    }
    alignas(64) float back[kLanes][4];
    for (int i = 0; i < count; ++i)
      hn::StoreU(hn::Mul(gather.sum(i), hn::Set(d4, 1.0F / kRays)), d4, sums + 4 * (first + i));
    turn(context, first, count, sums + 4 * first, back[0]);
    Scatter scatter(gradient);
    for (int i = 0; i < count; ++i)
      scatter.set(i, hn::Mul(hn::Load(d4, back[i]), hn::Set(d4, 1.0F / kRays)));
    for (int k = 0; k < most; ++k) VisitSlab(beams, count, k, slabs[k], scatter);
  }
};

void Forward(const Beam* beams, const BeamRay* rays, std::size_t count, const float* values,
             float* sums) {
  ForwardBody body{{beams, rays}, values, sums};
  ForGroups(count, body);
}

void Adjoint(const Beam* beams, const BeamRay* rays, std::size_t count, const float* beamValues,
             float* gradient) {
  AdjointBody body{{beams, rays}, beamValues, gradient};
  ForGroups(count, body);
}

void Weights(const Beam* beams, const BeamRay* rays, std::size_t count,
             std::vector<NodeWeight>* out) {
  WeightsBody body{{beams, rays}, out};
  ForGroups(count, body);
}

void ThereAndBack(const Beam* beams, const BeamRay* rays, std::size_t count, const float* values,
                  BeamTurn turn, const void* context, float* sums, float* gradient) {
  std::vector<SlabWeights> slabs;
  ThereAndBackBody body{{beams, rays}, values, turn, context, sums, gradient, slabs};
  ForGroups(count, body);
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

void beamForward(const Beam* beams, const BeamRay* rays, std::size_t count, const float* values,
                 float* sums) {
  HWY_DYNAMIC_DISPATCH(Forward)(beams, rays, count, values, sums);
}

void beamAdjoint(const Beam* beams, const BeamRay* rays, std::size_t count, const float* beamValues,
                 float* gradient) {
  HWY_DYNAMIC_DISPATCH(Adjoint)(beams, rays, count, beamValues, gradient);
}

void beamThereAndBack(const Beam* beams, const BeamRay* rays, std::size_t count,
                      const float* values, BeamTurn turn, const void* context, float* sums,
                      float* gradient) {
  HWY_DYNAMIC_DISPATCH(ThereAndBack)
  (beams, rays, count, values, turn, context, sums, gradient);
}

void beamWeights(const Beam* beams, const BeamRay* rays, std::size_t count,
                 std::vector<NodeWeight>* out) {
  HWY_DYNAMIC_DISPATCH(Weights)(beams, rays, count, out);
}

}  // namespace volute
#endif  // HWY_ONCE
