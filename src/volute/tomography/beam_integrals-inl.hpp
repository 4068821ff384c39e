// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// What the rays of a beam weigh in a slab, in closed form: integrals along rays of the hat
// functions of a plane's nodes, which are piecewise bilinear there. For each SIMD target: included
// by kernels alone.
#if defined(VOLUTE_TOMOGRAPHY_BEAM_INTEGRALS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef VOLUTE_TOMOGRAPHY_BEAM_INTEGRALS_INL
#undef VOLUTE_TOMOGRAPHY_BEAM_INTEGRALS_INL
#else
#define VOLUTE_TOMOGRAPHY_BEAM_INTEGRALS_INL
#endif

#include <hwy/highway.h>

#include "volute/math/float_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();

namespace volute::HWY_NAMESPACE {
namespace {

/// A ray in its plane axes, with what its integrals take from memory.
struct Ray {
  VF place[2], slope[2], inverse[2];
  VF halfSlope[2], thirdSlope[2];
  VF length, perSlope[2];            ///< the length times 1 and each slope
  VF perHalfSlope[2];                ///< and half of it
  VF halfPerSlopes, thirdPerSlopes;  ///< and both
};

/// Sums of those over the rays of a beam.
struct RaySums {
  VF length, slope[2], thirdSlopes;

  // Compilers give no target to members' initialisers.
  HWY_INLINE RaySums() { length = slope[0] = slope[1] = thirdSlopes = hn::Zero(df); }

  HWY_INLINE void add(const Ray& ray) {
    length = hn::Add(length, ray.length);
    for (int a = 0; a < 2; ++a) slope[a] = hn::Add(slope[a], ray.perSlope[a]);
    thirdSlopes = hn::Add(thirdSlopes, ray.thirdPerSlopes);
  }
};

/// The integral of a function along the rays of a beam, and that of it times u.
struct Moments {
  VF whole, near;

  HWY_INLINE static Moments none() { return {hn::Zero(df), hn::Zero(df)}; }
};

/// Of a ray in a slab, by its end: r(u) = max(end - slope u, 0), where u goes back from the far
/// plane (0) to the near one (1).
struct Ramp {
  VF end, extent;           ///< positive for u < extent <= 1
  VF whole, first, second;  ///< 2, 6 and 12 times the integrals of r, r u and r u^2

  HWY_INLINE Ramp(VF at, const Ray& ray, int axis) {
    end = hn::Max(at, hn::Zero(df));
    extent = hn::Min(hn::Mul(end, ray.inverse[axis]), hn::Set(df, 1.0F));
    const VF least = hn::NegMulAdd(ray.slope[axis], extent, end);
    const VF once = hn::Add(end, least), twice = hn::Add(once, least);
    const VF power1 = hn::Mul(ray.length, extent), power2 = hn::Mul(power1, extent);
    whole = hn::Mul(power1, once);
    first = hn::Mul(power2, twice);
    second = hn::Mul(hn::Mul(power2, extent), hn::Add(twice, least));
  }
};

/// Sums over rays of a ramp's integrals with 1 and with the place on the other axis.
class RampSums {
 public:
  HWY_INLINE RampSums() : one_(Moments::none()), place_(Moments::none()) {}

  HWY_INLINE void add(const Ramp& r, const Ray& ray, int other, VF otherEnd) {
    one_.whole = hn::Add(one_.whole, r.whole);
    one_.near = hn::Add(one_.near, r.first);
    place_.whole =
        hn::NegMulAdd(ray.thirdSlope[other], r.first, hn::MulAdd(otherEnd, r.whole, place_.whole));
    place_.near =
        hn::NegMulAdd(ray.halfSlope[other], r.second, hn::MulAdd(otherEnd, r.first, place_.near));
  }

  HWY_INLINE Moments withOne() const { return scaled(one_); }

  HWY_INLINE Moments withPlace() const { return scaled(place_); }

 private:
  HWY_INLINE static Moments scaled(const Moments& m) {
    return {hn::Mul(m.whole, hn::Set(df, 1 / 2.0F)), hn::Mul(m.near, hn::Set(df, 1 / 6.0F))};
  }

  Moments one_, place_;
};

/// Sums over rays of the integrals of two ramps' product, a - b u + c u^2 for u < e.
class ProductSums {
 public:
  HWY_INLINE ProductSums() : sum_(Moments::none()) {}

  HWY_INLINE void add(const Ramp& x, const Ramp& y, const Ray& ray) {
    const VF weighted = hn::Mul(ray.length, x.end);
    const VF a = hn::Mul(weighted, y.end);
    const VF halfB = hn::MulAdd(weighted, ray.halfSlope[1], hn::Mul(y.end, ray.perHalfSlope[0]));
    const VF e = hn::Min(x.extent, y.extent);
    const VF whole = hn::NegMulAdd(e, hn::NegMulAdd(e, ray.thirdPerSlopes, halfB), a);
    sum_.whole = hn::MulAdd(e, whole, sum_.whole);
    const VF middle = hn::NegMulAdd(e, ray.halfPerSlopes, hn::Mul(halfB, hn::Set(df, 4 / 3.0F)));
    sum_.near = hn::MulAdd(hn::Mul(e, e), hn::NegMulAdd(e, middle, a), sum_.near);
  }

  HWY_INLINE Moments moments() const {
    return {sum_.whole, hn::Mul(sum_.near, hn::Set(df, 1 / 2.0F))};
  }

 private:
  Moments sum_;
};

/// Turns integrals with 1, x, max(x - 1, 0), max(x - 2, 0) into those with the hat functions of
/// nodes 0, 1, ...
template <int kNodes>
HWY_INLINE void ToHats(VF (&f)[kNodes]) {
  for (int i = 1; i < kNodes - 1; ++i) f[i] = hn::Sub(f[i], f[i + 1]);  // how far cells are passed
  for (int i = 0; i < kNodes - 1; ++i) f[i] = hn::Sub(f[i], f[i + 1]);
}

}  // namespace
}  // namespace volute::HWY_NAMESPACE

HWY_AFTER_NAMESPACE();

#endif
