// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Vectors of floats as kernels use them. Included once for each SIMD target, after the targets are
// chosen.
#if defined(VOLUTE_MATH_FLOAT_LANES_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef VOLUTE_MATH_FLOAT_LANES_INL
#undef VOLUTE_MATH_FLOAT_LANES_INL
#else
#define VOLUTE_MATH_FLOAT_LANES_INL
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();

namespace volute::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using DF = hn::CappedTag<float, 16>;
using DI = hn::RebindToSigned<DF>;
using VF = hn::Vec<DF>;
using VI = hn::Vec<DI>;
using Mask = hn::Mask<DF>;
constexpr DF df;
constexpr DI di;
constexpr std::size_t kWidest = 16;

HWY_INLINE VF Constant(float x) {
  return hn::Set(df, x);
}

/// Rounded twice, so that every CPU gives the same.
HWY_INLINE VF MulThenAdd(VF a, VF b, VF c) {
  return hn::Add(hn::Mul(a, b), c);
}

HWY_INLINE Mask ForFloats(hn::Mask<DI> mask) {
  return hn::RebindMask(df, mask);
}

HWY_INLINE hn::Mask<DI> ForInts(Mask mask) {
  return hn::RebindMask(di, mask);
}

/// exp(x), to some 1e-7 (the polynomial of Cephes' expf); x is kept within -87..87.
HWY_INLINE VF Exp(VF x) {
  x = hn::Min(hn::Max(x, Constant(-87)), Constant(87));
  const VF n = hn::Round(hn::Mul(x, Constant(1.44269504F)));
  const VF r =
      MulThenAdd(n, Constant(2.12194440e-4F), hn::Sub(x, hn::Mul(n, Constant(0.693359375F))));
  VF p = MulThenAdd(Constant(1.9875691500e-4F), r, Constant(1.3981999507e-3F));
  p = MulThenAdd(p, r, Constant(8.3334519073e-3F));
  p = MulThenAdd(p, r, Constant(4.1665795894e-2F));
  p = MulThenAdd(p, r, Constant(1.6666665459e-1F));
  p = MulThenAdd(p, r, Constant(5.0000001201e-1F));
  p = hn::Add(MulThenAdd(p, hn::Mul(r, r), r), Constant(1));
  const VI exponent = hn::ShiftLeft<23>(hn::Add(hn::ConvertTo(di, n), hn::Set(di, 127)));
  return hn::Mul(p, hn::BitCast(df, exponent));
}

}  // namespace
}  // namespace volute::HWY_NAMESPACE

HWY_AFTER_NAMESPACE();
#endif
