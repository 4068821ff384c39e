// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// The walk of one vector of rays. Included once for each SIMD target, after hwy/highway.h.

#include "volute/fog/fog_lanes.hpp"

#if defined(VOLUTE_FOG_KERNEL) == defined(HWY_TARGET_TOGGLE)
#ifdef VOLUTE_FOG_KERNEL
#undef VOLUTE_FOG_KERNEL
#else
#define VOLUTE_FOG_KERNEL
#endif

#include "volute/math/float_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();

namespace volute {
namespace HWY_NAMESPACE {
namespace {
/// The density along a cell's piece of the ray, t from -1 to 1: the coefficients of t^0 .. t^2d.
template <int kDegree>
struct Along {
  VF m[2 * kDegree + 1];
};

HWY_INLINE void alongCell(const float* values, VI index, std::int32_t, VF, VF, VF, VF,
                          Along<0>& out) {
  out.m[0] = hn::GatherIndex(df, values, index);
}

/// f00 + B u + C v + D u v at u = um + hu t, v = vm + hv t.
HWY_INLINE void alongCell(const float* values, VI index, std::int32_t stride, VF um, VF vm, VF hu,
                          VF hv, Along<1>& out) {
  const VF f00 = hn::GatherIndex(df, values, index);
  const VF f10 = hn::GatherIndex(df, values + 1, index);
  const VF f01 = hn::GatherIndex(df, values + stride, index);
  const VF f11 = hn::GatherIndex(df, values + stride + 1, index);
  const VF b = hn::Sub(f10, f00);
  const VF c = hn::Sub(f01, f00);
  const VF d = hn::Sub(hn::Sub(f11, f10), c);
  const VF slopeU = MulThenAdd(d, vm, b);
  out.m[0] = MulThenAdd(slopeU, um, MulThenAdd(c, vm, f00));
  out.m[1] = MulThenAdd(slopeU, hu, hn::Mul(MulThenAdd(d, um, c), hv));
  out.m[2] = hn::Mul(d, hn::Mul(hu, hv));
}

/// The splines that touch a cell at u = um + hu t: w[i][k] is the coefficient of t^k of the i-th.
template <int kDegree>
struct LineWeights {
  VF w[kDegree + 1][kDegree + 1];

  HWY_INLINE LineWeights(VF um, VF hu) {
    const VF half = Constant(0.5F), one = Constant(1), sixth = Constant(1 / 6.0F);
    const VF u1 = hn::Sub(one, um), h2 = hn::Mul(hu, hu);
    const VF uu = hn::Mul(um, um), vv = hn::Mul(u1, u1);
    if constexpr (kDegree == 2) {
      set(0, hn::Mul(half, vv), hn::Neg(hn::Mul(u1, hu)), hn::Mul(half, h2));
      set(1, MulThenAdd(um, u1, half), hn::Mul(hn::Sub(u1, um), hu), hn::Neg(h2));
      set(2, hn::Mul(half, uu), hn::Mul(um, hu), hn::Mul(half, h2));
    } else {
      const VF h3 = hn::Mul(sixth, hn::Mul(h2, hu)), halfH2 = hn::Mul(half, h2);
      set(0, hn::Mul(sixth, hn::Mul(vv, u1)), hn::Neg(hn::Mul(hn::Mul(half, vv), hu)),
          hn::Mul(halfH2, u1));
      set(3, hn::Mul(sixth, hn::Mul(uu, um)), hn::Mul(hn::Mul(half, uu), hu), hn::Mul(halfH2, um));
      // N1 = 2/3 - u^2 + u^3/2, and N2 the same of 1 - u.
      inner(1, um, uu, hu, halfH2);
      inner(2, u1, vv, hn::Neg(hu), halfH2);
      w[0][3] = hn::Neg(h3);
      w[3][3] = h3;
      w[1][3] = hn::Mul(Constant(3), h3);
      w[2][3] = hn::Neg(w[1][3]);
    }
  }

 private:
  HWY_INLINE void set(int i, VF w0, VF w1, VF w2) { w[i][0] = w0, w[i][1] = w1, w[i][2] = w2; }

  HWY_INLINE void inner(int i, VF u, VF uu, VF h, VF halfH2) {
    w[i][0] = MulThenAdd(hn::Mul(uu, Constant(0.5F)), hn::Sub(u, Constant(2)), Constant(2 / 3.0F));
    w[i][1] = hn::Mul(h, hn::Sub(hn::Mul(uu, Constant(1.5F)), hn::Add(u, u)));
    w[i][2] = hn::Mul(halfH2, hn::Sub(hn::Mul(Constant(3), u), Constant(2)));
  }
};

template <int kDegree>
HWY_INLINE void alongCell(const float* values, VI index, std::int32_t stride, VF um, VF vm, VF hu,
                          VF hv, Along<kDegree>& out) {
  constexpr int n = kDegree + 1;
  const LineWeights<kDegree> x(um, hu), y(vm, hv);
  VF rows[n][n];  // rows[j][k]: row j of coefficients times the splines in x, of t^k
  for (int j = 0; j < n; ++j) {
    VF c[n];
    for (int i = 0; i < n; ++i) c[i] = hn::GatherIndex(df, values + j * stride + i, index);
    for (int k = 0; k < n; ++k) {
      rows[j][k] = hn::Mul(c[0], x.w[0][k]);
      for (int i = 1; i < n; ++i) rows[j][k] = MulThenAdd(c[i], x.w[i][k], rows[j][k]);
    }
  }
  for (int k = 0; k < 2 * kDegree + 1; ++k) {
    out.m[k] = hn::Zero(df);
    for (int a = k > kDegree ? k - kDegree : 0; a <= k && a <= kDegree; ++a) {
      for (int j = 0; j < n; ++j) out.m[k] = MulThenAdd(rows[j][a], y.w[j][k - a], out.m[k]);
    }
  }
}

/// Half the integral of t^j exp(-b t) over -1 <= t <= 1 for |b| <= 1, to 3e-8: the series of
/// (-b)^k / (k! (j + k + 1)) over k of j's parity.
HWY_INLINE VF Moment(int j, VF b) {
  static constexpr float kFactorials[10] = {1, 1, 2, 6, 24, 120, 720, 5040, 40320, 362880};
  const VF bb = hn::Mul(b, b);
  const int odd = j & 1;
  VF sum = hn::Zero(df);
  for (int k = 8 + odd; k >= odd; k -= 2)
    sum = MulThenAdd(sum, bb, Constant(1 / (kFactorials[k] * static_cast<float>(j + k + 1))));
  return odd ? hn::Neg(hn::Mul(sum, b)) : sum;
}

/// The mean over t of the even powers, or of the odd ones times t.
template <int kDegree>
HWY_INLINE VF MeanOf(const Along<kDegree>& along, int odd) {
  VF sum = hn::Zero(df);
  for (int k = odd; k < 2 * kDegree + 1; k += 2)
    sum = MulThenAdd(along.m[k], Constant(1.0F / static_cast<float>(k + 1 + odd)), sum);
  return sum;
}

/// One axis of a walk.
struct WalkAxis {
  VF first, delta, velocity, exitAt;
  VF count;  ///< planes passed so far
  VF next;   ///< s of the next one, always first + count * delta
  VI cell, step;

  HWY_INLINE void load(const FogLanes::Axis& axis, std::size_t lane) {
    first = next = hn::Load(df, axis.first + lane);
    delta = hn::Load(df, axis.delta + lane);
    velocity = hn::Load(df, axis.velocity + lane);
    exitAt = hn::Load(df, axis.exitAt + lane);
    cell = hn::Load(di, axis.cell + lane);
    step = hn::Load(di, axis.step + lane);
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

template <int kDegree, ZoneKind kKind>
class Walk {
 public:
  /// Ends where the optical depth has reached `opaque`.
  HWY_INLINE Walk(const FogLevels& levels, const FogLanes& lanes, std::size_t lane, float opaque)
      : level_(lanes.level), values_(levels.values().data()), skips_(levels.skips().data()) {
    x_.load(lanes.x, lane);
    y_.load(lanes.y, lane);
    s_ = sum_ = hn::Zero(df);
    end_ = hn::Load(df, lanes.length + lane);
    zoneBegin_ = hn::Load(df, lanes.zoneBegin + lane);
    zoneSlope_ = hn::Load(df, lanes.zoneSlope + lane);
    opaque_ = Constant(opaque);
    if constexpr (kKind == ZoneKind::kConstant)  // g is multiplied in at the end
      opaque_ = hn::Div(opaque_, hn::Max(zoneBegin_, Constant(1e-30F)));
    if constexpr (kKind == ZoneKind::kExponential)  // so that |b| <= 1 in Moment()
      longest_ = hn::Div(Constant(2), hn::Max(hn::Abs(zoneSlope_), Constant(1e-30F)));
  }

  /// From cell to cell to the end.
  HWY_INLINE void run() { cross(hn::Lt(s_, end_), end_); }

  /// From block to block: over empty squares at once, through others from cell to cell.
  HWY_INLINE void runOverEmpty() {
    for (;;) {
      const Mask alive = hn::Lt(s_, end_);
      if (hn::AllFalse(df, alive))
        return;
      const Mask empty = locate(alive);
      if (!hn::AllFalse(df, empty))
        jump(empty);
      const Mask stored = hn::AndNot(empty, alive);
      if (!hn::AllFalse(df, stored))
        cross(stored, hn::IfThenElse(stored, blockEnd_, s_));
    }
  }

  /// From cell to cell up to s = limit or the end.
  HWY_INLINE void runTo(VF limit) {
    const VF stop = hn::Max(s_, hn::Min(limit, end_));
    cross(hn::Lt(s_, stop), stop);
  }

  HWY_INLINE VF sum() const { return sum_; }

  /// The density where the walk stands; 0 outside of what is not empty.
  HWY_INLINE VF density(VF s) {
    const VI index = hn::Add(hn::Mul(y_.cellNow(), hn::Set(di, level_.stride)),
                             hn::Add(x_.cellNow(), hn::Set(di, level_.base)));
    Along<kDegree> along;
    const VF zero = hn::Zero(df);
    alongCell(values_, index, level_.stride, x_.place(s_), y_.place(s_), zero, zero, along);
    return hn::IfThenElseZero(hn::And(hn::Ge(s, zero), hn::Lt(s, end_)), along.m[0]);
  }

  HWY_INLINE void store(float* sum) const {
    hn::Store(kKind == ZoneKind::kConstant ? hn::Mul(sum_, zoneBegin_) : sum_, df, sum);
  }

 private:
  /// Takes the lanes of `active` to `limit`; the others have none to go.
  HWY_INLINE void cross(Mask active, VF limit) {
    VI index = hn::Add(hn::Mul(y_.cellNow(), hn::Set(di, level_.stride)),
                       hn::Add(x_.cellNow(), hn::Set(di, level_.base)));
    const VI strideY = hn::Mul(y_.step, hn::Set(di, level_.stride));
    while (!hn::AllFalse(df, active)) {
      VF to = hn::Min(hn::Min(x_.next, y_.next), limit);
      if constexpr (kKind == ZoneKind::kExponential)
        to = hn::Min(to, hn::Add(s_, longest_));
      to = hn::Max(s_, to);
      add(index, to);
      const Mask passX = hn::And(active, hn::Le(x_.next, to));
      const Mask passY = hn::And(active, hn::Le(y_.next, to));
      x_.pass(hn::IfThenElseZero(passX, Constant(1)));
      y_.pass(hn::IfThenElseZero(passY, Constant(1)));
      index = hn::Add(index, hn::Add(hn::IfThenElseZero(ForInts(passX), x_.step),
                                     hn::IfThenElseZero(ForInts(passY), strideY)));
      s_ = to;
      const Mask opaque = hn::Gt(sum_, opaque_);
      end_ = hn::IfThenElse(opaque, s_, end_);
      limit = hn::IfThenElse(opaque, s_, limit);
      active = hn::Lt(s_, limit);
    }
  }

  /// The integral from s_ to `to`, both in the cell at `index`.
  HWY_INLINE void add(VI index, VF to) {
    const VF length = hn::Sub(to, s_);
    const VF half = hn::Mul(length, Constant(0.5F));
    const VF middle = hn::Mul(hn::Add(s_, to), Constant(0.5F));
    Along<kDegree> along;
    alongCell(values_, index, level_.stride, x_.place(middle), y_.place(middle),
              hn::Mul(half, x_.velocity), hn::Mul(half, y_.velocity), along);
    if constexpr (kKind == ZoneKind::kConstant) {
      sum_ = MulThenAdd(MeanOf(along, 0), length, sum_);
    } else if constexpr (kKind == ZoneKind::kLinear) {
      const VF g = MulThenAdd(zoneSlope_, middle, zoneBegin_);
      VF mean = hn::Mul(MeanOf(along, 0), g);
      mean = MulThenAdd(MeanOf(along, 1), hn::Mul(zoneSlope_, half), mean);
      sum_ = MulThenAdd(mean, length, sum_);
    } else {
      const VF g = Exp(hn::Neg(MulThenAdd(zoneSlope_, middle, zoneBegin_)));
      const VF b = hn::Mul(zoneSlope_, half);
      VF mean = hn::Zero(df);
      for (int k = 0; k < 2 * kDegree + 1; ++k) mean = MulThenAdd(along.m[k], Moment(k, b), mean);
      sum_ = MulThenAdd(hn::Mul(mean, g), length, sum_);
    }
  }

  /// Which lanes stand in an empty square; sets what leaving the square or block means.
  HWY_INLINE Mask locate(Mask alive) {
    const VI cx = x_.cellNow(), cy = y_.cellNow();
    const VI lastX = hn::Set(di, level_.cellsX - 1), lastY = hn::Set(di, level_.cellsY - 1);
    const VI inX = hn::Min(hn::Max(cx, hn::Zero(di)), lastX);
    const VI inY = hn::Min(hn::Max(cy, hn::Zero(di)), lastY);
    const VI entry = hn::Add(hn::Mul(hn::ShiftRight<3>(inY), hn::Set(di, level_.skipStride)),
                             hn::Add(hn::ShiftRight<3>(inX), hn::Set(di, level_.skipBase)));
    const VI side = hn::GatherIndex(di, skips_, entry);
    const auto isEmpty = hn::Gt(side, hn::Zero(di));
    const VI mask = hn::Sub(hn::Max(side, hn::Set(di, FogLevels::kBlock)), hn::Set(di, 1));
    leave(x_, hn::And(inX, mask), mask, 0);
    leave(y_, hn::And(inY, mask), mask, 1);
    blockEnd_ = hn::Min(hn::Min(leaves_[0], leaves_[1]), end_);
    return hn::And(alive, hn::RebindMask(df, isEmpty));
  }

  /// `inside` is the cell's place in a square whose side is mask + 1.
  HWY_INLINE void leave(const WalkAxis& axis, VI inside, VI mask, int which) {
    const VI ahead = hn::IfThenElse(hn::Gt(axis.step, hn::Zero(di)), hn::Sub(mask, inside), inside);
    toLeave_[which] = hn::ConvertTo(df, hn::Add(ahead, hn::Set(di, 1)));
    leaves_[which] =
        MulThenAdd(hn::Add(axis.count, hn::ConvertTo(df, ahead)), axis.delta, axis.first);
  }

  /// Takes the lanes of `empty` to the end of their square. A plane count that rounding makes wrong
  /// by one is a step of length zero later, or one taken a rounding too early.
  HWY_INLINE void jump(Mask empty) {
    WalkAxis* axes[2] = {&x_, &y_};
    for (int i = 0; i < 2; ++i) {
      WalkAxis& axis = *axes[i];
      const VF planes = hn::Add(
          hn::Floor(hn::Mul(hn::Sub(blockEnd_, axis.next), hn::Abs(axis.velocity))), Constant(1));
      const VF within = hn::Min(hn::Max(planes, hn::Zero(df)), hn::Sub(toLeave_[i], Constant(1)));
      const VF passed = hn::IfThenElse(hn::Le(leaves_[i], blockEnd_), toLeave_[i], within);
      axis.pass(hn::IfThenElseZero(empty, passed));
    }
    s_ = hn::IfThenElse(empty, hn::Max(s_, blockEnd_), s_);
  }

  const FogLevels::Level& level_;
  const float* values_;
  const std::int32_t* skips_;
  WalkAxis x_, y_;
  VF s_, end_, sum_, zoneBegin_, zoneSlope_, longest_;
  VF opaque_;      ///< optical depth beyond which no light is left to tell
  VF toLeave_[2];  ///< planes to pass to leave the square by this axis
  VF leaves_[2];   ///< s at which that happens
  VF blockEnd_;    ///< s at which the ray leaves the square, or ends in it
};

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace volute

HWY_AFTER_NAMESPACE();

#endif  // per target
