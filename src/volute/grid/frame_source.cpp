// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/frame_source.hpp"

#include "volute/base/assert.hpp"
#include "volute/grid/bricks.hpp"
#include "volute/grid/rounding_source.hpp"

namespace volute {

Status FrameSource::readBricks(int index, int first, int end, Bricks& bricks) {
  constexpr std::size_t kAtOnce = std::size_t{1} << 21;  // values
  const auto zero = static_cast<float>(0 - offsetOf(*this));
  const std::array<float, 3> background{zero, zero, zero};
  const Bricks empty(info().channels, background);
  bricks = empty;
  const std::size_t layer = info().frameValues() / static_cast<std::size_t>(info().z);
  if (!readsLayers() || layer * static_cast<std::size_t>(end - first) <= kAtOnce) {
    std::vector<float> values(layer * static_cast<std::size_t>(end - first));
    VOLUTE_TRY(readLayers(index, first, end, values));
    bricks = Bricks::fromLayers(info(), first, end, values, background);
    return {};
  }
  // By parts, so that values do not lie here and in bricks all at the same time.
  const int part = std::max(1, static_cast<int>(kAtOnce / layer) / Bricks::kSide) * Bricks::kSide;
  const auto leavesAlong = [](int size) { return (size + Bricks::kSide - 1) / Bricks::kSide; };
  const std::size_t most = static_cast<std::size_t>(leavesAlong(info().x)) *
                           static_cast<std::size_t>(leavesAlong(info().y)) *
                           static_cast<std::size_t>(leavesAlong(end) - first / Bricks::kSide);
  Bricks all = empty;
  all.reserve(most, 0);
  std::vector<float> values;
  for (int begin = first; begin < end;) {
    const int next = std::min(end, begin - begin % Bricks::kSide + part);
    values.resize(layer * static_cast<std::size_t>(next - begin));
    VOLUTE_TRY(readLayers(index, begin, next, values));
    all.append(Bricks::fromLayers(info(), begin, next, values, background));
    begin = next;
  }
  if (2 * all.leaves().size() > most) {
    bricks = std::move(all);
  } else {
    bricks.reserve(all.leaves().size(), 0);
    bricks.append(all);
  }
  return {};
}

Status FrameSink::writeBricks(const Bricks&) {
  VOLUTE_ASSERT(!"a sink that takes bricks must write them");
  return {};
}

}  // namespace volute
