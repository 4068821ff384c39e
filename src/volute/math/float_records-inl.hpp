// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Values that lie side by side, read for each lane from its own place: twice as fast as gathers of
// one value each, and more. Included once for each SIMD target.
#if defined(VOLUTE_MATH_FLOAT_RECORDS_INL) == defined(HWY_TARGET_TOGGLE)
#ifdef VOLUTE_MATH_FLOAT_RECORDS_INL
#undef VOLUTE_MATH_FLOAT_RECORDS_INL
#else
#define VOLUTE_MATH_FLOAT_RECORDS_INL
#endif

#include <cstdint>

#include "volute/math/float_lanes-inl.hpp"

HWY_BEFORE_NAMESPACE();

namespace volute::HWY_NAMESPACE {
namespace {

#if HWY_TARGET == HWY_SCALAR
HWY_INLINE void LoadFours(const float* values, const std::int32_t* index, VF* out) {
  for (int i = 0; i < 4; ++i) out[i] = Constant(values[*index + i]);
}

template <int kSecond, int kThird, int kFourth>
HWY_INLINE void LoadFourRows(const float* values, const std::int32_t* index, VF (&out)[4][4]) {
  constexpr int kOffsets[4] = {0, kSecond, kThird, kFourth};
  for (int i = 0; i < 4; ++i) LoadFours(values + kOffsets[i], index, out[i]);
}

HWY_INLINE void LoadPairs(const float* values, const std::int32_t* index, VF& first, VF& second) {
  first = Constant(values[*index]), second = Constant(values[*index + 1]);
}
#else
/// A block of four values from each fourth index on.
template <class D>
HWY_INLINE hn::Vec<D> LoadBlocks(D d, const float* values, const std::int32_t* index) {
  if constexpr (hn::MaxLanes(D()) == 4) {
    return hn::LoadU(d, values + *index);
  } else {
    const hn::Half<D> half;
    return hn::Combine(d, LoadBlocks(half, values, index + hn::MaxLanes(d) / 2),
                       LoadBlocks(half, values, index));
  }
}

/// Two values from each index on.
template <class D>
HWY_INLINE hn::Vec<D> LoadHalves(D d, const float* values, const std::int32_t* index) {
  if constexpr (hn::MaxLanes(D()) == 2) {
    return hn::LoadU(d, values + *index);
  } else {
    const hn::Half<D> half;
    return hn::Combine(d, LoadHalves(half, values, index + hn::MaxLanes(d) / 4),
                       LoadHalves(half, values, index));
  }
}

/// Four values in a row for each lane: `rows` as LoadBlocks() has them from the first index on, the
/// second, ...; `out` has the first value of all lanes, the second, ...
HWY_INLINE void Transpose(const VF* rows, VF* out) {
  const hn::RepartitionToWide<DF> wide;
  const auto low = hn::BitCast(wide, hn::InterleaveLower(df, rows[0], rows[1]));
  const auto high = hn::BitCast(wide, hn::InterleaveUpper(df, rows[0], rows[1]));
  const auto nextLow = hn::BitCast(wide, hn::InterleaveLower(df, rows[2], rows[3]));
  const auto nextHigh = hn::BitCast(wide, hn::InterleaveUpper(df, rows[2], rows[3]));
  out[0] = hn::BitCast(df, hn::InterleaveLower(wide, low, nextLow));
  out[1] = hn::BitCast(df, hn::InterleaveUpper(wide, low, nextLow));
  out[2] = hn::BitCast(df, hn::InterleaveLower(wide, high, nextHigh));
  out[3] = hn::BitCast(df, hn::InterleaveUpper(wide, high, nextHigh));
}

HWY_INLINE void LoadFours(const float* values, const std::int32_t* index, VF* out) {
  const VF rows[4] = {LoadBlocks(df, values, index), LoadBlocks(df, values, index + 1),
                      LoadBlocks(df, values, index + 2), LoadBlocks(df, values, index + 3)};
  Transpose(rows, out);
}

/// The same at `values` and at three other offsets. Each index is read once.
template <int kSecond, int kThird, int kFourth>
HWY_INLINE void LoadFourRows(const float* values, const std::int32_t* index, VF (&out)[4][4]) {
  VF rows[4][4];
  const auto load = [&](int i) HWY_ATTR {
    rows[0][i] = LoadBlocks(df, values, index + i);
    rows[1][i] = LoadBlocks(df, values + kSecond, index + i);
    rows[2][i] = LoadBlocks(df, values + kThird, index + i);
    rows[3][i] = LoadBlocks(df, values + kFourth, index + i);
  };
  load(0), load(1), load(2), load(3);
  Transpose(rows[0], out[0]), Transpose(rows[1], out[1]);
  Transpose(rows[2], out[2]), Transpose(rows[3], out[3]);
}

/// Two values in a row for each lane.
HWY_INLINE void LoadPairs(const float* values, const std::int32_t* index, VF& first, VF& second) {
  const VF low = LoadHalves(df, values, index);
  const VF high = LoadHalves(df, values, index + hn::MaxLanes(df) / 2);
  first = hn::ConcatEven(df, high, low);
  second = hn::ConcatOdd(df, high, low);
}
#endif

/// Where the values of each lane are, for loads one by one.
struct LaneIndex {
  alignas(64) std::int32_t at[kWidest];

  HWY_INLINE explicit LaneIndex(VI index) { hn::Store(index, di, at); }
};

}  // namespace
}  // namespace volute::HWY_NAMESPACE

HWY_AFTER_NAMESPACE();
#endif
