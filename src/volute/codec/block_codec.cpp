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

}  // namespace volute
