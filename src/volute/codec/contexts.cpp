// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/contexts.hpp"

#include <algorithm>
#include <cmath>

#include "volute/codec/index_bits.hpp"

namespace volute {
namespace {

// A table holds an index 1..63 for each trained context, finer near 0 and near 1, where a step of
// probability costs most.
constexpr std::uint8_t kTrainedSeen = 40;
constexpr std::uint8_t kGuessedSeen = 2;
// Fewer bits than this cannot pay for an entry.
constexpr std::uint32_t kWorthAnEntry = 6;

/// How the entries themselves are coded: whether there is one (after one, after none), and which.
struct TableBits {
  AdaptiveBit present[2];
  IndexBits index;
};

}  // namespace

std::uint16_t probabilityOfIndex(int index) {
  const int near = index <= 32 ? 32 * index * index : 65536 - 32 * (64 - index) * (64 - index);
  return static_cast<std::uint16_t>(std::clamp(near, AdaptiveBit::kMin, 65536 - AdaptiveBit::kMin));
}

int indexOfCounts(const std::array<std::uint32_t, 2>& seen) {
  const double one = (seen[1] + 0.4) / (static_cast<double>(seen[0]) + seen[1] + 0.8);
  const double near = std::sqrt(std::min(one, 1 - one) * 65536 / 32);
  const int index = static_cast<int>(std::lround(one <= 0.5 ? near : 64 - near));
  return std::clamp(index, 1, kGreatestIndex);
}

void ContextCounts::add(const ContextCounts& other) {
  for (std::size_t i = 0; i < seen.size(); ++i) {
    seen[i][0] += other.seen[i][0];
    seen[i][1] += other.seen[i][1];
  }
}

Contexts untrainedContexts() {
  Contexts contexts(context::kCount);
  for (unsigned i = context::kCell; i < context::kSize; ++i) {
    const unsigned neighbours = i < context::kZero ? (i - context::kCell) / 24 % kSumClasses
                                                   : (i - context::kZero) / 36 % kSumClasses;
    contexts[i] = {static_cast<std::uint16_t>(2000 + 4500 * neighbours), kGuessedSeen};
  }
  return contexts;
}

std::vector<std::byte> contextTable(const ContextCounts& counts) {
  ArithmeticEncoder out;
  TableBits bits;
  bool before = false;
  int last = 32;
  for (const auto& seen : counts.seen) {
    const bool present = seen[0] + seen[1] >= kWorthAnEntry;
    out.bit(bits.present[before ? 1 : 0], present);
    before = present;
    if (!present)
      continue;
    const int index = indexOfCounts(seen);
    bits.index.write(out, index - last);
    last = index;
  }
  auto bytes = out.finish();
  if (bytes.empty())
    bytes.push_back(std::byte{0});
  return bytes;
}

Contexts contextsOf(std::span<const std::byte> table) {
  if (table.empty())
    return untrainedContexts();
  Contexts contexts(context::kCount);
  ArithmeticDecoder in(table);
  TableBits bits;
  bool before = false;
  int last = 32;
  for (AdaptiveBit& state : contexts) {
    before = in.bit(bits.present[before ? 1 : 0]);
    if (before)
      last = bits.index.read(in, last);
    state = {probabilityOfIndex(last), before ? kTrainedSeen : kGuessedSeen};
  }
  return contexts;
}

}  // namespace volute
