// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/block_codec.hpp"

#include <algorithm>

#include "volute/base/assert.hpp"

namespace volute {

int BlockShape::levels() const {
  int levels = 1;
  for (int side = *std::ranges::max_element(extents); side > 1; side = (side + 1) / 2) ++levels;
  return levels;
}

bool knowsCodec(std::uint32_t id) {
  return id == 1 || id == 2;
}

Result<std::shared_ptr<const BlockDecoder>> openDecoder(std::uint32_t id,
                                                        std::span<const std::byte> parameters,
                                                        const StreamInfo& stream) {
  VOLUTE_ASSERT(knowsCodec(id));
  return id == 1 ? openHaarDecoder(parameters, stream) : openWaveletDecoder(parameters, stream);
}

}  // namespace volute
