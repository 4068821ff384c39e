// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// Every CPU gives the same: no product is added in one rounding.

#include "volute/tomography/variation_kernels.hpp"

#include <algorithm>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volute/tomography/variation_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "volute/math/float_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();

namespace volute {
namespace HWY_NAMESPACE {
namespace {

constexpr std::size_t kLanes = hn::MaxLanes(df);
static_assert(VariationPlanes::kBlock % kLanes == 0);

using Slopes = std::array<VF, 9>;

HWY_INLINE VF Square(VF x) {
  return hn::Mul(x, x);
}

/// A symmetric matrix in each lane.
struct Symmetric {
  VF xx, yy, zz, xy, xz, yz;
};

HWY_INLINE VF SumOfProducts(VF a, VF b, VF c, VF d, VF e, VF f) {
  return hn::Add(hn::Add(hn::Mul(a, b), hn::Mul(c, d)), hn::Mul(e, f));
}

/// slopes' slopes, of which the eigenvalues are the squares of the singular values.
HWY_INLINE Symmetric Squares(const Slopes& s) {
  const auto entry = [&](std::size_t a, std::size_t b) HWY_ATTR {
    return SumOfProducts(s[a], s[b], s[3 + a], s[3 + b], s[6 + a], s[6 + b]);
  };
  return {entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2)};
}

HWY_INLINE VF Determinant(const Symmetric& g) {
  const auto minor = [](VF a, VF b, VF c, VF d)
                         HWY_ATTR { return hn::Sub(hn::Mul(a, b), hn::Mul(c, d)); };
  return hn::Add(hn::Sub(hn::Mul(g.xx, minor(g.yy, g.zz, g.yz, g.yz)),
                         hn::Mul(g.xy, minor(g.xy, g.zz, g.yz, g.xz))),
                 hn::Mul(g.xz, minor(g.xy, g.yz, g.yy, g.xz)));
}

/// Descending; of matrices that have no negative ones (Smith 1961, "Eigenvalues of a symmetric 3 x
/// 3 matrix").
HWY_INLINE std::array<VF, 3> Eigenvalues(const Symmetric& g) {
  const VF zero = hn::Zero(df), one = Constant(1);
  const VF mean = hn::Mul(hn::Add(hn::Add(g.xx, g.yy), g.zz), Constant(1.0F / 3));
  Symmetric rest = g;
  rest.xx = hn::Sub(g.xx, mean);
  rest.yy = hn::Sub(g.yy, mean);
  rest.zz = hn::Sub(g.zz, mean);
  const VF apart = hn::Add(SumOfProducts(rest.xx, rest.xx, rest.yy, rest.yy, rest.zz, rest.zz),
                           hn::Mul(Constant(2), SumOfProducts(g.xy, g.xy, g.xz, g.xz, g.yz, g.yz)));
  const VF size = hn::Max(hn::Sqrt(hn::Mul(apart, Constant(1.0F / 6))), Constant(1e-12F));
  const VF cosine = hn::Min(
      one, hn::Max(hn::Neg(one),
                   hn::Div(Determinant(rest), hn::Mul(Constant(2), hn::Mul(size, Square(size))))));
  // cos(acos(cosine) / 3) of the half angle's cosine, to 1.2e-6.
  const VF u = hn::Sqrt(hn::Mul(Constant(0.5F), hn::Add(one, cosine)));
  VF c = Constant(0.0041927417F);
  for (const float next : {-0.01930424F, 0.047797095F, -0.10994401F, 0.57725813F, 0.50000121F})
    c = MulThenAdd(u, c, Constant(next));
  const VF s = hn::Mul(Constant(1.7320508F), hn::Sqrt(hn::Max(zero, hn::Sub(one, Square(c)))));
  return {MulThenAdd(hn::Add(size, size), c, mean),
          hn::Max(zero, hn::Sub(mean, hn::Mul(size, hn::Sub(c, s)))),
          hn::Max(zero, hn::Sub(mean, hn::Mul(size, hn::Add(c, s))))};
}

/// min(1, 1 / sqrt(x)) of the matrices: the polynomial that takes its values at the three
/// eigenvalues, in Newton's form.
HWY_INLINE Symmetric Shrinking(const Symmetric& g, const std::array<VF, 3>& value) {
  const VF one = Constant(1);
  VF above[3], root[3];
  for (int k = 0; k < 3; ++k) {
    above[k] = hn::Max(value[k], one);
    root[k] = hn::Sqrt(above[k]);
  }
  // Without cancellation.
  const auto dividedDifference = [&](int a, int b) HWY_ATTR {
    const VF apart = hn::Max(hn::Sub(value[a], value[b]), hn::Mul(Constant(1e-9F), value[0]));
    return hn::Div(hn::Sub(above[b], above[a]),
                   hn::Mul(hn::Mul(apart, hn::Mul(root[a], root[b])), hn::Add(root[a], root[b])));
  };
  const VF none = hn::Div(one, root[0]), first = dividedDifference(0, 1);
  const VF width = hn::Sub(value[0], value[2]);
  const VF second = hn::IfThenElseZero(
      hn::Gt(width, hn::Mul(Constant(1e-4F), value[0])),
      hn::Div(hn::Sub(first, dividedDifference(1, 2)), hn::Max(width, Constant(1e-20F))));
  const VF ax = hn::Sub(g.xx, value[0]), ay = hn::Sub(g.yy, value[0]), az = hn::Sub(g.zz, value[0]);
  const VF bx = hn::Sub(g.xx, value[1]), by = hn::Sub(g.yy, value[1]), bz = hn::Sub(g.zz, value[1]);
  const VF xy = Square(g.xy), xz = Square(g.xz), yz = Square(g.yz);
  const auto diagonal = [&](VF a, VF b, VF p, VF q) HWY_ATTR {
    return MulThenAdd(second, hn::Add(MulThenAdd(a, b, p), q), MulThenAdd(first, a, none));
  };
  const auto beside = [&](VF entry, VF a, VF b, VF p, VF q) HWY_ATTR {
    return MulThenAdd(second, SumOfProducts(a, entry, entry, b, p, q), hn::Mul(first, entry));
  };
  return {diagonal(ax, bx, xy, xz),         diagonal(ay, by, xy, yz),
          diagonal(az, bz, xz, yz),         beside(g.xy, ax, by, g.xz, g.yz),
          beside(g.xz, ax, bz, g.xy, g.yz), beside(g.yz, ay, bz, g.xy, g.xz)};
}

HWY_INLINE Mask SameChannels(const Slopes& s) {
  Mask same = hn::And(hn::Eq(s[0], s[1]), hn::Eq(s[1], s[2]));
  for (std::size_t i = 3; i < 9; i += 3)
    same = hn::And(same, hn::And(hn::Eq(s[i], s[i + 1]), hn::Eq(s[i + 1], s[i + 2])));
  return same;
}

HWY_INLINE void Clip(Slopes& s) {
  const VF one = Constant(1), zero = hn::Zero(df);
  const Symmetric g = Squares(s);
  const VF trace = hn::Add(hn::Add(g.xx, g.yy), g.zz);
  const Mask large = hn::Gt(trace, one);
  if (hn::AllFalse(df, large))
    return;
  const auto value = Eigenvalues(g);
  Symmetric f = Shrinking(g, value);
  // Where all channels are the same there is one singular value, and rounding must not bring
  // colour into what has none.
  const Mask grey = SameChannels(s);
  const VF root = hn::Div(one, hn::Sqrt(trace));
  for (VF* entry : {&f.xx, &f.yy, &f.zz}) *entry = hn::IfThenElse(grey, root, *entry);
  for (VF* entry : {&f.xy, &f.xz, &f.yz}) *entry = hn::IfThenElse(grey, zero, *entry);
  const Mask changed = hn::Or(hn::And(grey, large), hn::AndNot(grey, hn::Gt(value[0], one)));
  for (std::size_t i = 0; i < 9; i += 3) {
    const VF a = s[i], b = s[i + 1], c = s[i + 2];
    s[i] = hn::IfThenElse(changed, SumOfProducts(a, f.xx, b, f.xy, c, f.xz), a);
    s[i + 1] = hn::IfThenElse(changed, SumOfProducts(a, f.xy, b, f.yy, c, f.yz), b);
    s[i + 2] = hn::IfThenElse(changed, SumOfProducts(a, f.xz, b, f.yz, c, f.zz), c);
  }
}

template <class Body>
HWY_INLINE void ForVectors(const VariationPlanes& planes, std::size_t begin, std::size_t end,
                           const Body& body) {
  for (std::size_t block = begin; block < end; ++block) {
    const std::ptrdiff_t first = planes.blocks[block];
    for (std::size_t i = 0; i < VariationPlanes::kBlock; i += hn::Lanes(df))
      body(first + static_cast<std::ptrdiff_t>(i));
  }
}

HWY_INLINE VF At(const std::vector<float>& plane, std::ptrdiff_t node) {
  return hn::LoadU(df, plane.data() + node);
}

void UpdatePrimal(VariationPlanes& planes, const SlopePlanes& slopes, bool nonNegative,
                  std::size_t begin, std::size_t end) {
  const VF least = nonNegative ? hn::Zero(df) : Constant(-3e38F);
  ForVectors(planes, begin, end, [&](std::ptrdiff_t n) HWY_ATTR {
    const VF weight = At(planes.weight, n);
    for (std::size_t c = 0; c < 3; ++c) {
      VF sum = hn::Zero(df);
      for (std::size_t a = 0; a < 3; ++a) {
        const auto& plane = slopes[3 * a + c];
        sum = hn::Add(sum, hn::Sub(At(plane, n - planes.stride[a]), At(plane, n)));
      }
      const VF value = hn::Sub(At(planes.target[c], n), hn::Mul(weight, sum));
      hn::StoreU(hn::Max(value, least), df, planes.primal[c].data() + n);
    }
  });
}

void UpdateDual(VariationPlanes& planes, float beta, std::size_t begin, std::size_t end) {
  const VF further = Constant(beta);
  ForVectors(planes, begin, end, [&](std::ptrdiff_t n) HWY_ATTR {
    const VF rate = At(planes.rate, n);
    Slopes next;
    for (std::size_t c = 0; c < 3; ++c) {
      const VF here = At(planes.primal[c], n);
      for (std::size_t a = 0; a < 3; ++a) {
        const VF slope = hn::Sub(At(planes.primal[c], n + planes.stride[a]), here);
        next[3 * a + c] = MulThenAdd(rate, slope, At(planes.ahead[3 * a + c], n));
      }
    }
    Clip(next);
    for (std::size_t i = 0; i < 9; ++i) {
      const VF step = hn::Sub(next[i], At(planes.dual[i], n));
      hn::StoreU(MulThenAdd(further, step, next[i]), df, planes.ahead[i].data() + n);
      hn::StoreU(next[i], df, planes.dual[i].data() + n);
    }
  });
}

void ClipAll(SlopePlanes& slopes) {
  const std::size_t size = slopes[0].size();
  float lanes[9][kLanes];
  for (std::size_t begin = 0; begin < size; begin += hn::Lanes(df)) {
    const std::size_t count = std::min(hn::Lanes(df), size - begin);
    Slopes s;
    for (std::size_t i = 0; i < 9; ++i) {
      std::fill_n(lanes[i], kLanes, 0.0F);
      std::copy_n(slopes[i].data() + begin, count, lanes[i]);
      s[i] = hn::LoadU(df, lanes[i]);
    }
    Clip(s);
    for (std::size_t i = 0; i < 9; ++i) {
      hn::StoreU(s[i], df, lanes[i]);
      std::copy_n(lanes[i], count, slopes[i].data() + begin);
    }
  }
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace volute

HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volute {

HWY_EXPORT(UpdatePrimal);
HWY_EXPORT(UpdateDual);
HWY_EXPORT(ClipAll);

VariationPlanes::VariationPlanes(std::size_t latticeSize)
    : weight(latticeSize + kBlock), rate(latticeSize + kBlock) {
  for (auto* planes : {&target, &primal})
    for (auto& plane : *planes) plane.resize(latticeSize + kBlock);
  for (auto* planes : {&dual, &ahead})
    for (auto& plane : *planes) plane.resize(latticeSize + kBlock);
}

void VariationPlanes::updatePrimal(const SlopePlanes& slopes, bool nonNegative, std::size_t begin,
                                   std::size_t end) {
  HWY_DYNAMIC_DISPATCH(UpdatePrimal)(*this, slopes, nonNegative, begin, end);
}

void VariationPlanes::updateDual(float beta, std::size_t begin, std::size_t end) {
  HWY_DYNAMIC_DISPATCH(UpdateDual)(*this, beta, begin, end);
}

void clipSingularValues(SlopePlanes& slopes) {
  HWY_DYNAMIC_DISPATCH(ClipAll)(slopes);
}

}  // namespace volute
#endif
