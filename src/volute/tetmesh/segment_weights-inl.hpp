// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Segment weights in float, for each SIMD target: included by kernels alone.
#if defined(VOLUTE_TETMESH_SEGMENT_WEIGHTS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef VOLUTE_TETMESH_SEGMENT_WEIGHTS_INL
#undef VOLUTE_TETMESH_SEGMENT_WEIGHTS_INL
#else
#define VOLUTE_TETMESH_SEGMENT_WEIGHTS_INL
#endif

#include <hwy/highway.h>

#include "volute/math/float_lanes-inl.hpp"
#include "volute/math/quadrature.hpp"

HWY_BEFORE_NAMESPACE();

namespace volute::HWY_NAMESPACE {
namespace {

/// e^-x for x >= 0.
HWY_INLINE VF ExpNeg(VF x) {
  x = hn::Max(hn::Neg(x), Constant(-87));
  const VF n = hn::Round(hn::Mul(x, Constant(1.44269504F)));
  const VF r =
      hn::NegMulAdd(n, Constant(-2.12194440e-4F), hn::NegMulAdd(n, Constant(0.693359375F), x));
  VF p = hn::MulAdd(Constant(1.9875691500e-4F), r, Constant(1.3981999507e-3F));
  p = hn::MulAdd(p, r, Constant(8.3334519073e-3F));
  p = hn::MulAdd(p, r, Constant(4.1665795894e-2F));
  p = hn::MulAdd(p, r, Constant(1.6666665459e-1F));
  p = hn::MulAdd(p, r, Constant(5.0000001201e-1F));
  p = hn::Add(hn::MulAdd(p, hn::Mul(r, r), r), Constant(1));
  const VI exponent = hn::ShiftLeft<23>(hn::Add(hn::ConvertTo(di, n), hn::Set(di, 127)));
  return hn::Mul(p, hn::BitCast(df, exponent));
}

/// 1 - e^-x for 0 <= x <= 1/2, without cancellation.
HWY_INLINE VF SmallLoss(VF x) {
  VF p = hn::MulAdd(x, Constant(1 / 5040.0F), Constant(-1 / 720.0F));
  p = hn::MulAdd(p, x, Constant(1 / 120.0F));
  p = hn::MulAdd(p, x, Constant(-1 / 24.0F));
  p = hn::MulAdd(p, x, Constant(1 / 6.0F));
  p = hn::MulAdd(p, x, Constant(-0.5F));
  p = hn::MulAdd(p, x, Constant(1));
  return hn::Mul(p, x);
}

/// Gauss on (0, 1).
template <int kPoints>
struct UnitRule {
  float nodes[kPoints], weights[kPoints];

  UnitRule() {
    const GaussRule rule = gaussRule(kPoints);
    for (std::size_t i = 0; i < kPoints; ++i) {
      nodes[i] = static_cast<float>(0.5 + 0.5 * rule.nodes[i]);
      weights[i] = static_cast<float>(0.5 * rule.weights[i]);
    }
  }
};

template <int kPoints, class F>
HWY_INLINE VF Quadrature(VF from, VF length, F&& f) {
  static const UnitRule<kPoints> rule;
  VF sum = hn::Zero(df);
  for (std::size_t i = 0; i < kPoints; ++i) {
    const VF s = hn::MulAdd(length, Constant(rule.nodes[i]), from);
    sum = hn::MulAdd(f(s), Constant(rule.weights[i]), sum);
  }
  return hn::Mul(sum, length);
}

/// The integral of x - x^2 / 2 + x^3 / 6 for x = d0 s + c s^2 over (0, 1): that of 1 - e^-x but for
/// 3e-7 while x <= 0.05.
HWY_INLINE VF ThinWeight(VF d0, VF c) {
  VF cubic = hn::MulAdd(c, Constant(1 / 42.0F), hn::Mul(d0, Constant(1 / 12.0F)));
  cubic = hn::MulAdd(cubic, c, hn::Mul(hn::Mul(d0, d0), Constant(0.1F)));
  VF square = hn::MulAdd(c, Constant(-0.1F), hn::Mul(d0, Constant(-0.25F)));
  square = hn::MulAdd(cubic, c, hn::Mul(square, c));
  const VF first = hn::MulAdd(d0, Constant(1 / 24.0F), Constant(-1 / 6.0F));
  const VF alone = hn::MulAdd(hn::Mul(first, d0), d0, hn::Mul(d0, Constant(0.5F)));
  return hn::Add(hn::MulAdd(c, Constant(1 / 3.0F), alone), square);
}

/// w0 = integral of 1 - T, w0 + w1 = 1 - T(1), which is returned; see segment_weights.cpp. The rule
/// is the cheapest that suits the deepest lane: cells of real meshes are thin.
HWY_INLINE VF Weights(VF d0, VF d1, VF& w0, VF& w1) {
  const VF slope = hn::Mul(Constant(0.5F), hn::Sub(d1, d0));
  const VF whole = hn::Mul(Constant(0.5F), hn::Add(d0, d1));
  const auto depth = [&](VF s) { return hn::Mul(s, hn::MulAdd(slope, s, d0)); };
  if (hn::AllTrue(df, hn::Le(whole, Constant(0.05F)))) {
    w0 = ThinWeight(d0, slope);
    const VF lost = SmallLoss(whole);
    w1 = hn::Sub(lost, w0);
    return lost;
  }
  if (hn::AllTrue(df, hn::Le(whole, Constant(0.5F)))) {
    const auto loss = [&](VF s) { return SmallLoss(depth(s)); };
    const VF lost = SmallLoss(whole);
    if (hn::AllTrue(df, hn::Le(whole, Constant(0.2F))))
      w0 = Quadrature<3>(hn::Zero(df), Constant(1), loss);
    else
      w0 = Quadrature<4>(hn::Zero(df), Constant(1), loss);
    w1 = hn::Sub(lost, w0);
    return lost;
  }
  const auto loss = [&](VF s) {
    const VF x = depth(s);
    return hn::IfThenElse(hn::Lt(x, Constant(0.25F)), SmallLoss(x),
                          hn::Sub(Constant(1), ExpNeg(x)));
  };
  const VF lost = hn::Sub(Constant(1), ExpNeg(whole));
  if (hn::AllTrue(df, hn::Le(whole, Constant(1.5F)))) {
    w0 = Quadrature<5>(hn::Zero(df), Constant(1), loss);
  } else if (hn::AllTrue(df, hn::Le(whole, Constant(6)))) {
    w0 = Quadrature<8>(hn::Zero(df), Constant(1), loss);
  } else {
    constexpr float kDark = 17;  // e^-17 = 4e-8
    const VF root = hn::MulAdd(d0, d0, hn::Mul(Constant(4 * kDark), slope));
    const VF to = hn::Div(Constant(2 * kDark), hn::Add(d0, hn::Sqrt(hn::Max(root, hn::Zero(df)))));
    const VF dark =
        hn::IfThenElse(hn::Ge(root, hn::Zero(df)), hn::Min(to, Constant(1)), Constant(1));
    const VF half = hn::Mul(dark, Constant(0.5F));
    w0 = hn::Add(hn::Sub(Constant(1), dark),
                 hn::Add(Quadrature<8>(hn::Zero(df), half, loss), Quadrature<8>(half, half, loss)));
  }
  w1 = hn::Max(hn::Sub(lost, w0), hn::Zero(df));
  return lost;
}

/// The same by the mean depth d = (d0 + d1) / 2 and c = (d1 - d0) / 2, |c| <= d: returns what is
/// lost, w0 + w1, and `lean` = (w1 - w0) / 2. Then E0 w0 + E1 w1 = (E0 + E1) / 2 lost + (E1 - E0)
/// lean. Thin pieces: e^-x up to its cubic term, 3e-7 at most.
HWY_INLINE VF LostAndLean(VF d, VF c, VF& lean) {
  if (hn::AllTrue(df, hn::Le(d, Constant(0.05F)))) {
    const VF square = hn::MulAdd(d, Constant(-1 / 120.0F), Constant(1 / 60.0F));
    const VF first =
        hn::MulAdd(hn::MulAdd(d, Constant(1 / 40.0F), Constant(-1 / 12.0F)), d, Constant(1 / 6.0F));
    const VF alone = hn::Mul(hn::MulAdd(d, Constant(1 / 24.0F), Constant(-1 / 12.0F)), d);
    lean = hn::MulAdd(c, Constant(1 / 840.0F), square);
    lean = hn::MulAdd(hn::MulAdd(lean, c, first), c, hn::Mul(alone, d));
    VF lost = hn::MulAdd(d, Constant(-1 / 24.0F), Constant(1 / 6.0F));
    lost = hn::MulAdd(lost, d, Constant(-0.5F));
    return hn::Mul(hn::MulAdd(lost, d, Constant(1)), d);
  }
  VF w0, w1;
  const VF lost =
      Weights(hn::Max(hn::Sub(d, c), hn::Zero(df)), hn::Max(hn::Add(d, c), hn::Zero(df)), w0, w1);
  lean = hn::Mul(Constant(0.5F), hn::Sub(w1, w0));
  return lost;
}

}  // namespace
}  // namespace volute::HWY_NAMESPACE

HWY_AFTER_NAMESPACE();
#endif
