// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/block_codec.hpp"

#include <algorithm>

namespace volute {

int BlockShape::levels() const {
  int levels = 1;
  for (int side = *std::ranges::max_element(extents); side > 1; side = (side + 1) / 2) ++levels;
  return levels;
}

void fillFrames(std::span<float> values, const BlockShape& shape, FrameSpan wanted,
                std::span<const float> ofChannels) {
  const auto channels = static_cast<std::size_t>(shape.channels);
  const std::size_t frame = shape.values() / static_cast<std::size_t>(shape.extents[0]);
  const auto begin = static_cast<std::size_t>(wanted.first) * frame;
  const auto end = static_cast<std::size_t>(std::min(wanted.end, shape.extents[0])) * frame;
  for (std::size_t i = begin; i < end; i += channels)
    std::copy_n(ofChannels.begin(), channels, values.begin() + static_cast<std::ptrdiff_t>(i));
}

}  // namespace volute
