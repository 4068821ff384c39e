// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace volute {

/// Calls use(i) for begin <= i < end where mask[i] is not 0; for all where the mask is empty. Fast
/// over long runs of 0.
template <class Use>
void forEachSet(std::span<const std::uint8_t> mask, std::size_t begin, std::size_t end,
                const Use& use) {
  std::uint64_t eight = 0;
  for (std::size_t i = begin; i < end; ++i) {
    if (!mask.empty() && mask[i] == 0) {
      for (; i + sizeof(eight) < end; i += sizeof(eight)) {
        std::memcpy(&eight, &mask[i], sizeof(eight));
        if (eight != 0)
          break;
      }
      if (mask[i] == 0)
        continue;
    }
    use(i);
  }
}

}  // namespace volute
