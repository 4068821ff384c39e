// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/wavelet/shape_adaptive.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volute/wavelet/shape_adaptive.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include "volute/wavelet/lifting_steps.hpp"

HWY_BEFORE_NAMESPACE();

namespace volute::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// A few lines side by side, one in each lane, without gaps. What lies beyond their ends is zero
/// and not in the support. Never MulAdd: it rounds differently from CPU to CPU.
///
/// kCount: their samples, where that is known, so that all of them stay in registers; else 0.
template <class D, bool kShaped, std::size_t kCount>
struct Strip {
  using F = hn::Vec<D>;
  D d;
  const LiftingRows& rows;

  HWY_INLINE std::size_t count() const { return kCount != 0 ? kCount : rows.count; }

  /// Calls visit for every second sample from `first` on.
  template <class Visit>
  HWY_INLINE void everySecond(std::size_t first, const Visit& visit) const {
    if constexpr (kCount != 0) {
#pragma GCC unroll 16
      for (std::size_t i = 0; i < kCount; i += 2) visit(first + i);
    } else {
      for (std::size_t i = first; i < rows.count; i += 2) visit(i);
    }
  }

  HWY_INLINE float* at(std::size_t i) const { return rows.samples + i * rows.stride; }

  HWY_INLINE F get(std::size_t i) const { return i < count() ? hn::LoadU(d, at(i)) : hn::Zero(d); }

  HWY_INLINE F in(std::size_t i) const {
    if (i >= count())
      return hn::Zero(d);
    if constexpr (kShaped)
      return hn::LoadU(d, rows.support + i * rows.stride);
    else
      return hn::Set(d, 1.0f);
  }

  /// x[i] += factor (x[i-1] + x[i+1]), a neighbour that is missing mirrored by the other one.
  HWY_INLINE void step(std::size_t i, F factor) const {
    F before = get(i - 1);
    F after = get(i + 1);
    if (kShaped || i == 0 || i + 1 == count()) {
      const F two = hn::Set(d, 2.0f);
      before = hn::Mul(hn::Sub(two, in(i + 1)), before);
      after = hn::Mul(hn::Sub(two, in(i - 1)), after);
    }
    F change = hn::Mul(factor, hn::Add(before, after));
    if constexpr (kShaped)
      change = hn::Mul(in(i), change);
    hn::StoreU(hn::Add(get(i), change), d, at(i));
  }

  HWY_INLINE void steps(std::size_t first, double factor) const {
    const F f = hn::Set(d, static_cast<float>(factor));
    everySecond(first, [&](std::size_t i) HWY_ATTR { step(i, f); });
  }

  /// Multiplies sample i by `paired`, or by `alone` where no neighbour is in the support.
  HWY_INLINE void scale(std::size_t i, double paired, double alone) const {
    F factor = hn::Set(d, static_cast<float>(paired));
    if (kShaped || count() == 1) {
      const auto none = hn::Eq(hn::Add(in(i - 1), in(i + 1)), hn::Zero(d));
      factor = hn::IfThenElse(none, hn::Set(d, static_cast<float>(alone)), factor);
    }
    hn::StoreU(hn::Mul(get(i), factor), d, at(i));
  }

  HWY_INLINE void scaleAll(double low, double high, double loneLow) const {
    everySecond(0, [&](std::size_t i) HWY_ATTR { scale(i, low, loneLow); });
    everySecond(1, [&](std::size_t i) HWY_ATTR { scale(i, high, 1.0); });
  }

  /// (a, b) becomes ((a + b) / sqrt 2, (a - b) / sqrt 2); a lone a is multiplied by `alone`, a lone
  /// b stays.
  HWY_INLINE void haar(double alone) const {
    const F half = hn::Set(d, static_cast<float>(1 / kRootTwo));
    for (std::size_t i = 0; i < count(); i += 2) {
      const F a = get(i);
      const F b = get(i + 1);
      const auto both = hn::Ne(hn::Mul(in(i), in(i + 1)), hn::Zero(d));
      const F lone = hn::Mul(a, hn::Set(d, static_cast<float>(alone)));
      hn::StoreU(hn::IfThenElse(both, hn::Mul(hn::Add(a, b), half), lone), d, at(i));
      if (i + 1 < count())
        hn::StoreU(hn::IfThenElse(both, hn::Mul(hn::Sub(a, b), half), b), d, at(i + 1));
    }
  }

  HWY_INLINE void lift(Wavelet wavelet, bool inverse) const {
    const LiftingSteps steps_ = liftingSteps(wavelet);
    if (wavelet == Wavelet::kHaar) {
      haar(inverse ? 1 / kRootTwo : kRootTwo);
    } else if (!inverse) {
      for (int i = 0; i < steps_.count; ++i) steps(i % 2 == 0 ? 1 : 0, steps_.factor[i]);
      scaleAll(steps_.scale, 1 / steps_.scale, kRootTwo);
    } else {
      scaleAll(1 / steps_.scale, steps_.scale, 1 / kRootTwo);
      for (int i = steps_.count; i-- > 0;) steps(i % 2 == 0 ? 1 : 0, -steps_.factor[i]);
    }
  }
};

/// Lifts lines from `lane` on as long as they fill a vector. They are copied beside each other
/// first: rows far apart, by powers of two, would push each other out of the cache.
template <bool kShaped, std::size_t kCount, class D>
void liftStrips(D d, const LiftingRows& rows, Wavelet wavelet, bool inverse, std::size_t& lane) {
  const std::size_t lanes = hn::Lanes(d);
  HWY_ALIGN float samples[kLongestSide * hn::MaxLanes(d)];
  HWY_ALIGN float support[kLongestSide * hn::MaxLanes(d)];
  const LiftingRows near{samples, support, rows.count, lanes, lanes};
  const Strip<D, kShaped, kCount> strip{d, near};
  const std::size_t count = strip.count();
  for (; lane + lanes <= rows.lines; lane += lanes) {
    auto any = hn::Zero(d);  // zeros stay zeros
    for (std::size_t i = 0; i < count; ++i) {
      const auto row = hn::LoadU(d, rows.samples + i * rows.stride + lane);
      hn::Store(row, d, samples + i * lanes);
      any = hn::Max(any, hn::Abs(row));
    }
    if (hn::AllFalse(d, hn::Ne(any, hn::Zero(d))))
      continue;
    if constexpr (kShaped) {
      for (std::size_t i = 0; i < count; ++i)
        hn::Store(hn::LoadU(d, rows.support + i * rows.stride + lane), d, support + i * lanes);
    }
    strip.lift(wavelet, inverse);
    for (std::size_t i = 0; i < count; ++i)
      hn::StoreU(hn::Load(d, samples + i * lanes), d, rows.samples + i * rows.stride + lane);
  }
}

template <bool kShaped>
void liftLanes(const LiftingRows& rows, Wavelet wavelet, bool inverse) {
  std::size_t lane = 0;
  if (!kShaped && rows.count == kLongestSide)
    liftStrips<kShaped, kLongestSide>(hn::ScalableTag<float>(), rows, wavelet, inverse, lane);
  else
    liftStrips<kShaped, 0>(hn::ScalableTag<float>(), rows, wavelet, inverse, lane);
  // What is left of a block at its coarse levels has short rows.
  liftStrips<kShaped, 0>(hn::CappedTag<float, 8>(), rows, wavelet, inverse, lane);
  liftStrips<kShaped, 0>(hn::CappedTag<float, 4>(), rows, wavelet, inverse, lane);
  liftStrips<kShaped, 0>(hn::CappedTag<float, 1>(), rows, wavelet, inverse, lane);
}

void LiftRows(const LiftingRows& rows, Wavelet wavelet, bool inverse) {
  if (rows.support != nullptr)
    liftLanes<true>(rows, wavelet, inverse);
  else
    liftLanes<false>(rows, wavelet, inverse);
}

/// to(j, i) = from(i, j), i < rows, j < columns, both without gaps.
void turn(const float* from, std::size_t rows, std::size_t columns, float* to) {
#if HWY_TARGET != HWY_SCALAR
  if (rows % 4 == 0 && columns % 4 == 0) {
    const hn::FixedTag<float, 4> d;
    for (std::size_t i = 0; i < rows; i += 4) {
      for (std::size_t j = 0; j < columns; j += 4) {
        const float* at = from + i * columns + j;
        const auto r0 = hn::LoadU(d, at), r1 = hn::LoadU(d, at + columns);
        const auto r2 = hn::LoadU(d, at + 2 * columns), r3 = hn::LoadU(d, at + 3 * columns);
        const auto low01 = hn::InterleaveLower(d, r0, r1), high01 = hn::InterleaveUpper(d, r0, r1);
        const auto low23 = hn::InterleaveLower(d, r2, r3), high23 = hn::InterleaveUpper(d, r2, r3);
        float* out = to + j * rows + i;
        hn::StoreU(hn::ConcatLowerLower(d, low23, low01), d, out);
        hn::StoreU(hn::ConcatUpperUpper(d, low23, low01), d, out + rows);
        hn::StoreU(hn::ConcatLowerLower(d, high23, high01), d, out + 2 * rows);
        hn::StoreU(hn::ConcatUpperUpper(d, high23, high01), d, out + 3 * rows);
      }
    }
    return;
  }
#endif
  for (std::size_t j = 0; j < columns; ++j) {
    for (std::size_t i = 0; i < rows; ++i) to[j * rows + i] = from[i * columns + j];
  }
}

/// Lines of `count` samples, one after the other: x becomes the slowest axis for a while, some
/// lines at a time.
void LiftLines(float* samples, const float* support, std::size_t lines, std::size_t count,
               Wavelet wavelet, bool inverse) {
  constexpr std::size_t kLines = 16;
  HWY_ALIGN float turned[kLongestSide * kLines];
  HWY_ALIGN float turnedSupport[kLongestSide * kLines];
  for (std::size_t first = 0; first < lines; first += kLines) {
    const std::size_t n = HWY_MIN(kLines, lines - first);
    float* some = samples + first * count;
    turn(some, n, count, turned);
    if (support != nullptr)
      turn(support + first * count, n, count, turnedSupport);
    LiftRows({turned, support != nullptr ? turnedSupport : nullptr, count, n, n}, wavelet, inverse);
    turn(turned, count, n, some);
  }
}

}  // namespace volute::HWY_NAMESPACE

HWY_AFTER_NAMESPACE();

#if HWY_ONCE

#include <algorithm>
#include <cmath>
#include <vector>

#include "volute/base/assert.hpp"

namespace volute {
namespace {

HWY_EXPORT(LiftRows);
HWY_EXPORT(LiftLines);

using Extents = std::array<int, 4>;

std::size_t sizeOf(const Extents& e) {
  return static_cast<std::size_t>(e[0]) * e[1] * e[2] * e[3];
}

/// A block, or what is left of it at a level, without gaps.
class Level {
 public:
  Level(std::span<float> samples, std::span<const float> support, const Extents& extents)
      : samples_(samples), support_(support), extents_(extents) {}

  void lift(int axis, Wavelet wavelet, bool inverse) const {
    const auto count = static_cast<std::size_t>(extents_[axis]);
    if (axis == 3)
      return HWY_DYNAMIC_DISPATCH(LiftLines)(samples_.data(),
                                             support_.empty() ? nullptr : support_.data(),
                                             samples_.size() / count, count, wavelet, inverse);
    std::size_t lines = 1;
    for (int a = axis + 1; a < 4; ++a) lines *= static_cast<std::size_t>(extents_[a]);
    const std::size_t slab = count * lines;
    for (std::size_t begin = 0; begin < samples_.size(); begin += slab)
      run({samples_.data() + begin, support_.empty() ? nullptr : support_.data() + begin, count,
           lines, lines},
          wavelet, inverse);
  }

 private:
  static void run(const LiftingRows& rows, Wavelet wavelet, bool inverse) {
    HWY_DYNAMIC_DISPATCH(LiftRows)(rows, wavelet, inverse);
  }

  std::span<float> samples_;
  std::span<const float> support_;
  Extents extents_;
};

// What is left of a block after halving the axes of `halved`.
Extents halfOf(const Extents& e, const std::array<bool, 4>& halved) {
  Extents half = e;
  for (int a = 0; a < 4; ++a)
    if (halved[a])
      half[a] = (e[a] + 1) / 2;
  return half;
}

// visit(i, j): element i of the half is element j of the whole.
template <class Visit>
void visitLow(const Extents& e, const std::array<bool, 4>& halved, const Visit& visit) {
  const Extents half = halfOf(e, halved);
  std::size_t i = 0;
  for (int t = 0; t < half[0]; ++t)
    for (int z = 0; z < half[1]; ++z)
      for (int y = 0; y < half[2]; ++y) {
        const std::size_t line =
            ((static_cast<std::size_t>(t << halved[0]) * e[1] + (z << halved[1])) * e[2] +
             (y << halved[2])) *
            e[3];
        for (int x = 0; x < half[3]; ++x)
          visit(i++, line + (static_cast<std::size_t>(x) << halved[3]));
      }
}

/// Room for what is left of a block at each level.
struct Scratch {
  std::array<std::vector<float>, 5> samples, support;
};

/// What is wanted of the first axis.
struct Wanted {
  int first = 0, end = kLongestSide;

  /// The low samples that it depends on: each lifting step reaches one sample further.
  Wanted low(Wavelet wavelet) const {
    const int reach = liftingSteps(wavelet).count + 1;
    return {std::max(0, first - reach) / 2, (end + reach) / 2 + 1};
  }
};

/// @param wanted  by the inverse
void transform(std::span<float> samples, std::span<const float> support, const Extents& extents,
               Wavelet wavelet, const AxisLevels& levels, bool inverse, Wanted wanted,
               Scratch& scratch, std::size_t depth) {
  if (deepest(levels) == 0)
    return;
  const Level level(samples, support, extents);
  std::array<bool, 4> halved{};
  AxisLevels left = levels;
  for (int axis = 0; axis < 4; ++axis) {
    halved[axis] = levels[axis] > 0;
    left[axis] -= halved[axis] ? 1 : 0;
  }
  if (!inverse) {
    for (int axis = 4; axis-- > 0;)
      if (halved[axis])
        level.lift(axis, wavelet, false);
  }
  if (deepest(left) > 0) {
    const Extents half = halfOf(extents, halved);
    std::vector<float>& low = scratch.samples[depth];
    std::vector<float>& lowSupport = scratch.support[depth];
    low.resize(sizeOf(half));
    lowSupport.resize(support.empty() ? 0 : low.size());
    visitLow(extents, halved, [&](std::size_t i, std::size_t j) { low[i] = samples[j]; });
    if (!support.empty())
      visitLow(extents, halved, [&](std::size_t i, std::size_t j) { lowSupport[i] = support[j]; });
    transform(low, lowSupport, half, wavelet, left, inverse,
              halved[0] ? wanted.low(wavelet) : wanted, scratch, depth + 1);
    visitLow(extents, halved, [&](std::size_t i, std::size_t j) { samples[j] = low[i]; });
  }
  if (inverse) {
    if (halved[0])
      level.lift(0, wavelet, true);
    // From here on no sample depends on those at other places of the first axis.
    const int end = std::min(wanted.end, extents[0]);
    const int count = end - wanted.first;
    const std::size_t slab = samples.size() / static_cast<std::size_t>(extents[0]);
    const std::size_t begin = static_cast<std::size_t>(wanted.first) * slab;
    const std::size_t size = static_cast<std::size_t>(count) * slab;
    const Level part(samples.subspan(begin, size),
                     support.empty() ? support : support.subspan(begin, size),
                     {count, extents[1], extents[2], extents[3]});
    for (int axis = 1; axis < 4; ++axis)
      if (halved[axis])
        part.lift(axis, wavelet, true);
  }
}

void transformBlock(std::span<float> samples, std::span<const std::uint8_t> support,
                    const Extents& extents, Wavelet wavelet, const AxisLevels& levels, bool inverse,
                    Wanted wanted) {
  VOLUTE_ASSERT(wanted.first >= 0 && wanted.first < std::min(wanted.end, extents[0]) &&
                samples.size() == sizeOf(extents) &&
                (support.empty() || support.size() == samples.size()) &&
                *std::ranges::max_element(extents) <= kLongestSide);
  // Memory of this size costs as much to get as to use.
  thread_local Scratch scratch;
  scratch.support[0].assign(support.begin(), support.end());
  transform(samples, scratch.support[0], extents, wavelet, levels, inverse, wanted, scratch, 1);
}

int halvings(int side) {
  int levels = 0;
  for (; side > 1; side = (side + 1) / 2) ++levels;
  return levels;
}

}  // namespace

AxisLevels blockLevels(const std::array<int, 4>& extents, int timeLevels) {
  const int space = halvings(std::max({extents[1], extents[2], extents[3]}));
  return {std::min(timeLevels, halvings(extents[0])), space, space, space};
}

int deepest(const AxisLevels& levels) {
  return *std::ranges::max_element(levels);
}

void shapeForward(std::span<float> samples, std::span<const std::uint8_t> support,
                  const std::array<int, 4>& extents, Wavelet wavelet, const AxisLevels& levels) {
  transformBlock(samples, support, extents, wavelet, levels, false, {});
}

void shapeInverse(std::span<float> coefficients, std::span<const std::uint8_t> support,
                  const std::array<int, 4>& extents, Wavelet wavelet, const AxisLevels& levels,
                  int first, int end) {
  transformBlock(coefficients, support, extents, wavelet, levels, true, {first, end});
}

}  // namespace volute

#endif
