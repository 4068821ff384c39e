// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/array_source.hpp"

#include <algorithm>
#include <vector>

#include "volute/base/assert.hpp"
#include "volute/base/parallel.hpp"

namespace volute {

std::array<std::ptrdiff_t, 5> denseStrides(const VolumeInfo& info, const NumberType& type) {
  const auto size = static_cast<std::ptrdiff_t>(type.size());
  const std::ptrdiff_t c = size, x = c * info.channels, y = x * info.x, z = y * info.y;
  return {z * info.z, z, y, x, c};
}

Status ArraySource::readLayers(int index, int first, int end, std::span<float> values) {
  const auto channels = static_cast<std::size_t>(info_.channels);
  const auto width = static_cast<std::size_t>(info_.x) * channels;
  const auto rows = static_cast<std::size_t>(info_.y);
  const auto layers = static_cast<std::size_t>(end - first);
  VOLUTE_ASSERT(values.size() == layers * rows * width);
  const auto [t, z, y, x, c] = array_.strides;
  const auto channelCount = static_cast<std::ptrdiff_t>(channels);
  // A row is read at once where its numbers are evenly apart.
  const bool even = channels == 1 || x == c * channelCount;

  struct Layer {
    double rounding = 0;
    std::optional<double> beyond{};
  };

  std::vector<Layer> done(layers);
  parallelFor(layers, [&](std::size_t layer) {
    const std::byte* const from =
        array_.data + t * index + z * (first + static_cast<std::ptrdiff_t>(layer));
    const auto convert = [&](const std::byte* at, std::ptrdiff_t stride, std::span<float> to) {
      const auto beyond = toFloats(array_.type, at, stride, to, done[layer].rounding, offset_);
      if (beyond)
        done[layer].beyond = beyond;
    };
    for (std::size_t row = 0; row < rows; ++row) {
      const auto to = values.subspan((layer * rows + row) * width, width);
      const std::byte* at = from + y * static_cast<std::ptrdiff_t>(row);
      if (even) {
        convert(at, channels == 1 ? x : c, to);
        continue;
      }
      for (std::size_t i = 0; i < width; i += channels, at += x)
        convert(at, c, to.subspan(i, channels));
    }
  });
  for (const Layer& layer : done) {
    rounding_ = std::max(rounding_, layer.rounding);
    if (layer.beyond) {
      return fail(
          ErrorCode::kInvalidData,
          "frame {}: the value {:g} is beyond float32, in which values are kept; expected at "
          "most 3.4e38: scale them",
          index, *layer.beyond);
    }
  }
  return {};
}

}  // namespace volute
