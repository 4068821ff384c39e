// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tree4d/tree_read.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "volute/tree4d/tree_read.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include <algorithm>
#include <cstring>

#include "volute/codec/block_grid.hpp"

HWY_BEFORE_NAMESPACE();

namespace volute::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr std::uint64_t kCoefficientBits = 0xFFFEFFFEFFFEFFFEull;
constexpr std::uint64_t kInnerBits = 0x0001000100010001ull;

// Bit j of kOdd[o]: wavelet j is negative in child o.
constexpr std::array<std::uint16_t, 16> kOdd = [] {
  std::array<std::uint16_t, 16> odd{};
  for (unsigned o = 0; o < 16; ++o) {
    for (unsigned j = 0; j < 16; ++j) {
      unsigned parity = o & j;
      parity = (parity ^ parity >> 2) & 3;
      if ((parity ^ parity >> 1) & 1)
        odd[o] = static_cast<std::uint16_t>(odd[o] | 1u << j);
    }
  }
  return odd;
}();

HWY_INLINE std::uint32_t popCount(std::uint64_t bits) {
  return static_cast<std::uint32_t>(hwy::PopCount(bits));
}

/// kBefore[n]: the bits of the first n masks of a group, as words of four masks.
struct alignas(64) BeforeTable {
  std::uint64_t words[TreeData::kGroup][TreeData::kGroup / 4];
};

constexpr BeforeTable kBefore = [] {
  BeforeTable table{};
  for (int n = 0; n < TreeData::kGroup; ++n) {
    for (int i = 0; i < n; ++i) table.words[n][i / 4] |= std::uint64_t{0xFFFF} << 16 * (i % 4);
  }
  return table;
}();

/// How many of `bits` are set in the masks of the nodes that stand before `node` in its group. All
/// words are counted, since a loop of unknown length costs more in mispredicted branches.
HWY_INLINE std::uint32_t rankInGroup(const std::uint16_t* masks, std::uint32_t node,
                                     std::uint64_t bits) {
  const std::uint16_t* group = masks + (node & ~(TreeData::kGroup - 1u));
  const std::uint64_t* before = kBefore.words[node & (TreeData::kGroup - 1u)];
  std::uint32_t count = 0;
  for (int i = 0; i < TreeData::kGroup / 4; ++i) {
    std::uint64_t word = 0;
    std::memcpy(&word, group + 4 * i, sizeof word);
    count += popCount(word & bits & before[i]);
  }
  return count;
}

HWY_NOINLINE std::int32_t escaped(const TreeData::Level& level, std::uint32_t index) {
  const auto found = std::lower_bound(level.escapeIndex.begin(), level.escapeIndex.end(), index);
  return level.escapeValue[static_cast<std::size_t>(found - level.escapeIndex.begin())];
}

/// Calls visit(lowest bit of the mask, quantised value) for each kept coefficient; `values` has
/// those of one channel.
template <class T, class Visit>
HWY_INLINE void forEachCoefficient(const TreeData::Level& level, const T* values,
                                   std::uint32_t index, unsigned mask, Visit&& visit) {
  for (unsigned m = mask & 0xFFFEu; m != 0; m &= m - 1, ++index) {
    std::int32_t q = values[index];
    if (HWY_UNLIKELY(q == hwy::LowestValue<T>()))
      q = escaped(level, index);
    visit(m & (0u - m), q);
  }
}

template <class Visit>
HWY_INLINE void forEachCoefficient(const TreeData::Level& level, std::uint32_t index, unsigned mask,
                                   Visit&& visit) {
  if (level.wide) {
    forEachCoefficient(level, level.wide16.data(), index, mask, visit);
  } else {
    forEachCoefficient(level, level.narrow8.data(), index, mask, visit);
  }
}

/// Where a channel's coefficients begin: a node keeps them channel after channel.
HWY_INLINE std::uint32_t channelBegin(const TreeData& data, std::uint32_t coefficient,
                                      unsigned mask, int channel) {
  return coefficient * data.channels +
         static_cast<std::uint32_t>(channel) * popCount(mask & 0xFFFEu);
}

HWY_INLINE float detail(const TreeData& data, const TreeData::Level& level,
                        std::uint32_t coefficient, unsigned mask, unsigned o, int channel) {
  std::int32_t sum = 0;
  forEachCoefficient(level, channelBegin(data, coefficient, mask, channel), mask,
                     [&](unsigned bit, std::int32_t q) { sum += kOdd[o] & bit ? -q : q; });
  return static_cast<float>(sum) * level.scale;
}

HWY_INLINE unsigned childAt(const std::array<int, 4>& voxel, int level) {
  return static_cast<unsigned>((voxel[0] >> level & 1) << 3 | (voxel[1] >> level & 1) << 2 |
                               (voxel[2] >> level & 1) << 1 | (voxel[3] >> level & 1));
}

HWY_INLINE std::uint32_t coefficientsBefore(const TreeData& data, std::uint32_t node) {
  return data.groups[node / TreeData::kGroup].coefficients +
         rankInGroup(data.masks.data(), node, kCoefficientBits);
}

HWY_INLINE std::uint32_t innerBefore(const TreeData& data, std::uint32_t node) {
  return data.groups[node / TreeData::kGroup].inner +
         rankInGroup(data.masks.data(), node, kInnerBits);
}

HWY_INLINE std::uint32_t childOf(const TreeData& data, std::uint32_t node, unsigned mask,
                                 unsigned o) {
  if (!(mask & 1))
    return TreeData::kNoNode;
  const std::uint32_t inner = innerBefore(data, node);
  const unsigned children = data.childMasks[inner];
  if (!(children >> o & 1))
    return TreeData::kNoNode;
  return data.childBases[inner] + popCount(children & ((1u << o) - 1));
}

HWY_INLINE float clamped(const TreeData& data, float value) {
  return std::min(std::max(value, data.minimum), data.maximum);
}

float ReadValue(const TreeData& data, const std::array<int, 4>& v, int channel) {
  if (!data.isOccupied(v[0], v[1], v[2], v[3]))
    return 0;
  const TreeData::Entry& entry = data.entryAt(v[0], v[1], v[2], v[3]);
  float value = entry.value[channel];
  std::uint32_t node = entry.node;
  for (int l = data.entryLevels - 1; node != TreeData::kNoNode; --l) {
    const unsigned mask = data.masks[node];
    const unsigned o = childAt(v, l);
    value += detail(data, data.levels[l], coefficientsBefore(data, node), mask, o, channel);
    node = childOf(data, node, mask, o);
  }
  return clamped(data, value);
}

void ReadValues(const TreeData& data, std::span<const std::array<int, 4>> voxels,
                std::span<float> values) {
  std::size_t i = 0;
  for (const auto& voxel : voxels) {
    for (int c = 0; c < data.channels; ++c) values[i++] = ReadValue(data, voxel, c);
  }
}

struct Item {
  std::uint32_t node, coefficient, inner;
  std::uint32_t z, y, x;  // of its first child in the finer grid
};

/// From g^3 cells to (2g)^3, each value eight times.
HWY_INLINE void upsample(const float* HWY_RESTRICT from, int g, float* HWY_RESTRICT to) {
  const int h = 2 * g;
#if HWY_TARGET != HWY_SCALAR
  const hn::CappedTag<float, 8> d;
  const auto lanes = static_cast<int>(hn::Lanes(d));
  alignas(32) static constexpr std::int32_t kTwice[] = {0, 0, 1, 1, 2, 2, 3, 3,
                                                        4, 4, 5, 5, 6, 6, 7, 7};
  const auto firstHalf = hn::SetTableIndices(d, kTwice);
  const auto secondHalf = hn::SetTableIndices(d, kTwice + lanes);
#endif
  for (int z = 0; z < g; ++z) {
    for (int y = 0; y < g; ++y) {
      float* row = to + (2 * z * h + 2 * y) * h;
      const float* source = from + (z * g + y) * g;
      int x = 0;
#if HWY_TARGET != HWY_SCALAR
      for (; x + lanes <= g; x += lanes) {
        const auto v = hn::LoadU(d, source + x);
        const auto first = hn::TableLookupLanes(v, firstHalf);
        const auto second = hn::TableLookupLanes(v, secondHalf);
        for (float* r : {row, row + h, row + h * h, row + h * h + h}) {
          hn::StoreU(first, d, r + 2 * x);
          hn::StoreU(second, d, r + 2 * x + lanes);
        }
      }
#endif
      for (x *= 2; x < h; ++x)
        row[x] = row[h + x] = row[h * h + x] = row[h * h + h + x] = source[x / 2];
    }
  }
}

/// Adds what the 15 wavelets of a node are in its eight children of one time half, for coefficients
/// of any size.
HWY_INLINE void addDetailsSlowly(const TreeData::Level& level, std::uint32_t begin, unsigned mask,
                                 bool later, int h, float* HWY_RESTRICT at) {
  std::int32_t sums[8] = {};
  forEachCoefficient(level, begin, mask, [&](unsigned bit, std::int32_t q) {
    for (unsigned o = 0; o < 8; ++o) sums[o] += kOdd[o + 8 * later] & bit ? -q : q;
  });
  for (int o = 0; o < 8; ++o) {
    at[((o >> 2) * h + (o >> 1 & 1)) * h + (o & 1)] += static_cast<float>(sums[o]) * level.scale;
  }
}

#if HWY_TARGET == HWY_SCALAR
HWY_INLINE void addDetails(const TreeData::Level& level, std::uint32_t begin, unsigned mask,
                           bool later, int h, float* HWY_RESTRICT at) {
  addDetailsSlowly(level, begin, mask, later, h, at);
}
#else

/// kSpread[m]: for each bit of m that is set, how many are set below it; 0x80 for the others.
/// Spreads packed bytes to the places that their mask names.
struct alignas(64) SpreadTable {
  std::uint8_t bytes[256][8];
};

constexpr SpreadTable kSpread = [] {
  SpreadTable table{};
  for (unsigned m = 0; m < 256; ++m) {
    std::uint8_t rank = 0;
    for (unsigned bit = 0; bit < 8; ++bit) table.bytes[m][bit] = m >> bit & 1 ? rank++ : 0x80;
  }
  return table;
}();

/// The same for int8: spread to their places, then a Hadamard transform of the eight children in
/// eight 16-bit lanes. kMayEscape: the level has coefficients that do not fit.
template <bool kMayEscape>
HWY_INLINE void addNarrowDetails(const TreeData::Level& level, std::uint32_t begin, unsigned mask,
                                 bool later, int h, float* HWY_RESTRICT at) {
  const hn::FixedTag<std::uint8_t, 16> d8;
  const hn::FixedTag<std::uint8_t, 8> dHalf8;
  const hn::FixedTag<std::int8_t, 16> di8;
  const hn::FixedTag<std::int16_t, 8> d16;
  const hn::FixedTag<std::uint32_t, 4> d32;
  [[maybe_unused]] const hn::FixedTag<std::int32_t, 4> di32;
  const hn::FixedTag<float, 4> df;
  const hn::FixedTag<float, 2> dPair;

  const unsigned earlier = mask & 0xFEu;
  const auto spreadEarlier = hn::Load(dHalf8, kSpread.bytes[earlier]);
  const auto spreadLater = hn::Add(hn::Load(dHalf8, kSpread.bytes[mask >> 8]),
                                   hn::Set(dHalf8, static_cast<std::uint8_t>(popCount(earlier))));
  const auto packed =
      hn::LoadU(d8, reinterpret_cast<const std::uint8_t*>(level.narrow8.data() + begin));
  const auto w = hn::BitCast(
      di8, hn::TableLookupBytesOr0(packed, hn::Combine(d8, spreadLater, spreadEarlier)));
  if (kMayEscape &&
      HWY_UNLIKELY(!hn::AllFalse(di8, hn::Eq(w, hn::Set(di8, hwy::LowestValue<std::int8_t>()))))) {
    return addDetailsSlowly(level, begin, mask, later, h, at);
  }
  const auto a = hn::PromoteTo(d16, hn::LowerHalf(w));
  const auto b = hn::PromoteTo(d16, hn::UpperHalf(hn::Half<decltype(di8)>(), w));
  const auto t = later ? hn::Sub(a, b) : hn::Add(a, b);

  // Each step adds a lane to, or subtracts it from, the lane whose number differs in one bit.
  alignas(16) static constexpr std::int16_t kMinusX[8] = {0, -1, 0, -1, 0, -1, 0, -1};
  alignas(16) static constexpr std::int16_t kMinusY[8] = {0, 0, -1, -1, 0, 0, -1, -1};
  alignas(16) static constexpr std::int16_t kMinusZ[8] = {0, 0, 0, 0, -1, -1, -1, -1};
  const auto minusX = hn::Load(d16, kMinusX);
  const auto minusY = hn::Load(d16, kMinusY);
  const auto minusZ = hn::Load(d16, kMinusZ);
  const auto words = hn::BitCast(d32, t);
  const auto otherX = hn::BitCast(d16, hn::Or(hn::ShiftLeft<16>(words), hn::ShiftRight<16>(words)));
  const auto x = hn::Add(otherX, hn::Sub(hn::Xor(t, minusX), minusX));
  const auto otherY = hn::BitCast(d16, hn::Shuffle2301(hn::BitCast(d32, x)));
  const auto y = hn::Add(otherY, hn::Sub(hn::Xor(x, minusY), minusY));
  const auto otherZ = hn::BitCast(d16, hn::Shuffle1032(hn::BitCast(d32, y)));
  const auto z = hn::Add(otherZ, hn::Sub(hn::Xor(y, minusZ), minusZ));

#if HWY_MAX_BYTES >= 32
  const hn::FixedTag<float, 8> df8;
  const hn::FixedTag<std::int32_t, 8> di8x32;
  const auto all = hn::Mul(hn::ConvertTo(df8, hn::PromoteTo(di8x32, z)), hn::Set(df8, level.scale));
  const auto low = hn::LowerHalf(df, all);
  const auto high = hn::UpperHalf(df, all);
#else
  const auto scale = hn::Set(df, level.scale);
  const auto low = hn::Mul(hn::ConvertTo(df, hn::PromoteTo(di32, hn::LowerHalf(z))), scale);
  const auto high = hn::Mul(
      hn::ConvertTo(df, hn::PromoteTo(di32, hn::UpperHalf(hn::Half<decltype(d16)>(), z))), scale);
#endif
  auto addPair = [&](float* pair, auto add) {
    hn::StoreU(hn::Add(hn::LoadU(dPair, pair), add), dPair, pair);
  };
  addPair(at, hn::LowerHalf(low));
  addPair(at + h, hn::UpperHalf(dPair, low));
  addPair(at + h * h, hn::LowerHalf(high));
  addPair(at + h * h + h, hn::UpperHalf(dPair, high));
}

HWY_INLINE void addDetails(const TreeData::Level& level, std::uint32_t begin, unsigned mask,
                           bool later, int h, float* HWY_RESTRICT at) {
  if (level.wide) {
    addDetailsSlowly(level, begin, mask, later, h, at);
  } else {
    addNarrowDetails<true>(level, begin, mask, later, h, at);
  }
}
#endif

/// Appends the children of `item` in one time half; their ranks follow from the first one's.
HWY_INLINE int listChildren(const TreeData& data, const TreeData::Level& below, const Item& item,
                            bool later, Item* out) {
  const unsigned children = data.childMasks[item.inner];
  const unsigned half = later ? children >> 8 : children & 0xFFu;
  if (half == 0)
    return 0;
  std::uint32_t node = data.childBases[item.inner] + (later ? popCount(children & 0xFFu) : 0);
  std::uint32_t coefficient = coefficientsBefore(data, node);
  std::uint32_t inner = innerBefore(data, node);
  int count = 0;
  for (unsigned m = half; m != 0; m &= m - 1, ++node) {
    const auto o = static_cast<unsigned>(hwy::Num0BitsBelowLS1Bit_Nonzero32(m));
    const unsigned mask = data.masks[node];
    out[count++] = {node,
                    coefficient,
                    inner,
                    2 * (item.z + (o >> 2)),
                    2 * (item.y + (o >> 1 & 1)),
                    2 * (item.x + (o & 1))};
    if (!below.wide)
      hwy::Prefetch(below.narrow8.data() + coefficient * data.channels);
    coefficient += popCount(mask & 0xFFFEu);
    inner += mask & 1u;
  }
  return count;
}

/// The children of one parent in one time half.
struct Siblings {
  std::uint32_t node, coefficient;  // of the first
  unsigned present;                 // bit o: child o is there
  float* at;                        // the parent's first voxel
};

/// Lists who has children in the time half, and asks for their coefficients before they are needed.
HWY_INLINE int listSiblings(const TreeData& data, const Item* parents, int count, bool later, int h,
                            float* values, Siblings* out) {
  const TreeData::Level& level = data.levels[0];
  int listed = 0;
  for (int i = 0; i < count; ++i) {
    const Item& parent = parents[i];
    if (!(data.masks[parent.node] & 1))
      continue;
    const unsigned children = data.childMasks[parent.inner];
    const unsigned present = later ? children >> 8 : children & 0xFFu;
    if (present == 0)
      continue;
    const std::uint32_t node =
        data.childBases[parent.inner] + (later ? popCount(children & 0xFFu) : 0);
    const std::uint32_t coefficient = coefficientsBefore(data, node);
    if (!level.wide)
      hwy::Prefetch(level.narrow8.data() + coefficient * data.channels);
    out[listed++] = {node, coefficient, present,
                     values + ((2 * parent.z) * h + 2 * parent.y) * h + 2 * parent.x};
  }
  return listed;
}

/// Adds the finest level to `values`, straight from its parents: its nodes are most of the tree.
/// `add` is addDetails or a part of it; the sides of the grid are a constant where they can be.
template <class Add>
HWY_INLINE int addFinest(const TreeData& data, const Item* parents, int count, int t, int h,
                         float* HWY_RESTRICT values, const Add& add) {
  constexpr int kMaxParents = 64;
  Siblings siblings[kMaxParents];
  const int listed = listSiblings(data, parents, count, (t >> 1 & 1) != 0, h, values, siblings);
  const bool later = t & 1;
  const std::size_t cells = static_cast<std::size_t>(h) * h * h;
  int visited = 0;
  for (int i = 0; i < listed; ++i) {
    std::uint32_t node = siblings[i].node;
    std::uint32_t coefficient = siblings[i].coefficient;
    for (unsigned m = siblings[i].present; m != 0; m &= m - 1, ++node, ++visited) {
      const auto o = static_cast<unsigned>(hwy::Num0BitsBelowLS1Bit_Nonzero32(m));
      const unsigned mask = data.masks[node];
      float* child = siblings[i].at + ((o >> 2) * h + (o >> 1 & 1)) * 2 * h + 2 * (o & 1);
      for (int c = 0; c < data.channels; ++c)
        add(channelBegin(data, coefficient, mask, c), mask, later, child + c * cells);
      coefficient += popCount(mask & 0xFFFEu);
    }
  }
  return visited;
}

HWY_INLINE int addFinest(const TreeData& data, const Item* parents, int count, int t, int h,
                         float* HWY_RESTRICT values) {
  const TreeData::Level& level = data.levels[0];
#if HWY_TARGET != HWY_SCALAR
  constexpr int kUsualSide = BlockGrid::kSide;
  if (h == kUsualSide && !level.wide && level.escapeIndex.empty()) {
    return addFinest(data, parents, count, t, kUsualSide, values,
                     [&](std::uint32_t begin, unsigned mask, bool later, float* at) {
                       addNarrowDetails<false>(level, begin, mask, later, kUsualSide, at);
                     });
  }
#endif
  return addFinest(data, parents, count, t, h, values,
                   [&](std::uint32_t begin, unsigned mask, bool later, float* at) {
                     addDetails(level, begin, mask, later, h, at);
                   });
}

int ReadBlockSlice(const TreeData& data, const TreeData::Entry& entry, int t, float* values) {
  constexpr int kMaxSide = 16;
  constexpr int kMaxNodes = 64;  // of the levels above the finest
  alignas(64) float buffers[2][3 * kMaxSide * kMaxSide * kMaxSide / 8];
  Item items[2][kMaxNodes];
  int count = 0;
  if (entry.node != TreeData::kNoNode) {
    items[0][0] = {
        entry.node, coefficientsBefore(data, entry.node), innerBefore(data, entry.node), 0, 0, 0};
    count = 1;
  }
  int turn = 0;
  int visited = 0;
  float* current = data.entryLevels % 2 == 0 ? buffers[0] : buffers[1];
  for (int c = 0; c < data.channels; ++c) current[c] = entry.value[c];
  int g = 1;
  for (int l = data.entryLevels - 1; l >= 0; --l) {
    const int h = 2 * g;
    const int cells = h * h * h;
    float* finer = l == 0 ? values : current == buffers[0] ? buffers[1] : buffers[0];
    const bool later = t >> l & 1;
    for (int c = 0; c < data.channels; ++c) upsample(current + c * g * g * g, g, finer + c * cells);
    if (l == 0 && data.entryLevels > 1) {
      visited += addFinest(data, items[turn], count, t, h, finer);
      break;
    }
    int next = 0;
    for (int i = 0; i < count; ++i) {
      const Item& item = items[turn][i];
      const unsigned mask = data.masks[item.node];
      float* at = finer + (item.z * h + item.y) * h + item.x;
      for (int c = 0; c < data.channels; ++c)
        addDetails(data.levels[l], channelBegin(data, item.coefficient, mask, c), mask, later, h,
                   at + c * cells);
      if (l > 1 && (mask & 1))
        next += listChildren(data, data.levels[l - 1], item, later, &items[turn ^ 1][next]);
    }
    visited += count;
    current = finer;
    g = h;
    if (l == 1)
      continue;  // the finest level is listed by addFinest from these nodes
    turn ^= 1;
    count = next;
  }
  return visited;
}

void CopyValues(const TreeData& data, const BoxCopy& copy) {
  const BoxCopy c = copy;  // a copy that no store can alias
  const hn::CappedTag<float, 8> d;
  const auto lanes = static_cast<int>(hn::Lanes(d));
  const auto minimum = hn::Set(d, data.minimum);
  const auto maximum = hn::Set(d, data.maximum);
  for (int z = 0; z < c.depth; ++z) {
    const float* from = c.from + z * c.fromPlane;
    float* to = c.to + z * c.toPlane;
    for (int y = 0; y < c.height; ++y, from += c.fromRow, to += c.toRow) {
      int x = 0;
      for (; c.toStep == 1 && x + lanes <= c.width; x += lanes)
        hn::StoreU(hn::Min(hn::Max(hn::LoadU(d, from + x), minimum), maximum), d, to + x);
      for (; x < c.width; ++x) to[x * c.toStep] = clamped(data, from[x]);
    }
  }
}

}  // namespace volute::HWY_NAMESPACE

HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace volute {

HWY_EXPORT(ReadValue);
HWY_EXPORT(ReadValues);
HWY_EXPORT(ReadBlockSlice);
HWY_EXPORT(CopyValues);

float readValue(const TreeData& data, const std::array<int, 4>& voxel, int channel) {
  return HWY_DYNAMIC_DISPATCH(ReadValue)(data, voxel, channel);
}

void readValues(const TreeData& data, std::span<const std::array<int, 4>> voxels,
                std::span<float> values) {
  HWY_DYNAMIC_DISPATCH(ReadValues)(data, voxels, values);
}

int readBlockSlice(const TreeData& data, const TreeData::Entry& entry, int t, float* values) {
  return HWY_DYNAMIC_DISPATCH(ReadBlockSlice)(data, entry, t, values);
}

void copyValues(const TreeData& data, const BoxCopy& copy) {
  HWY_DYNAMIC_DISPATCH(CopyValues)(data, copy);
}

}  // namespace volute
#endif
