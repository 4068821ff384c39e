// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/frame_source.hpp"

#include "volute/base/assert.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/grid/rounding_source.hpp"

namespace volute {

Status FrameSource::readBricks(int index, int first, int end, Bricks& bricks) {
  const std::size_t layer = info().frameValues() / static_cast<std::size_t>(info().z);
  std::vector<float> values(layer * static_cast<std::size_t>(end - first));
  VOLUTE_TRY(readLayers(index, first, end, values));
  const auto zero = static_cast<float>(0 - offsetOf(*this));
  bricks = Bricks::fromLayers(info(), first, end, values, {zero, zero, zero});
  return {};
}

Status FrameSink::writeBricks(const Bricks&) {
  VOLUTE_ASSERT(!"a sink that takes bricks must write them");
  return {};
}

}  // namespace volute
