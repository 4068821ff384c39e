// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/suggest.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace volute {

namespace {

/// No name of ours is as long; what is longer is like none of them.
constexpr std::size_t kLongest = 256;

}  // namespace

std::size_t editDistance(std::string_view a, std::string_view b) {
  if (std::max(a.size(), b.size()) > kLongest)
    return std::max(a.size(), b.size());
  // Rows of the table: the one that is filled, and the two before it.
  std::vector<std::size_t> row(b.size() + 1), above(row.size()), above2(row.size());
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        row[j] = i + j;
        continue;
      }
      const std::size_t replaced = above[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      row[j] = std::min({replaced, above[j] + 1, row[j - 1] + 1});
      const bool swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
      if (swapped)
        row[j] = std::min(row[j], above2[j - 2] + 1);
    }
    std::swap(above, above2);
    std::swap(row, above);
  }
  return above[b.size()];
}

std::string_view nearest(std::string_view text, std::span<const std::string_view> candidates) {
  std::string_view best;
  // A third of the letters may be wrong; beyond that a suggestion would be a guess.
  std::size_t least = std::max<std::size_t>(2, text.size() / 3) + 1;
  for (const auto candidate : candidates) {
    const std::size_t longer = std::max(text.size(), candidate.size());
    const bool begun = text.size() >= 3 && candidate.starts_with(text);
    if (!begun && longer - std::min(text.size(), candidate.size()) >= least)
      continue;
    const std::size_t distance = begun ? 1 : editDistance(text, candidate);
    if (distance < least && distance < longer) {
      least = distance;
      best = candidate;
    }
  }
  return best;
}

}  // namespace volute
