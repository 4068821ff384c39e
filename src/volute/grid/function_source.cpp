// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/function_source.hpp"

#include <algorithm>
#include <cmath>

#include "volute/base/assert.hpp"

namespace volute {

Status FunctionSource::readLayers(int index, int first, int end, std::span<float> values) {
  const auto width = static_cast<std::size_t>(info_.x), rows = static_cast<std::size_t>(info_.y);
  const auto channels = static_cast<std::size_t>(info_.channels);
  const std::size_t count = static_cast<std::size_t>(end - first) * rows * width;
  VOLUTE_ASSERT(values.size() == count * channels);
  const Vec3 voxel = info_.voxelSize();
  std::vector<double> x(std::min(kBatch, count)), y(x.size()), z(x.size());
  for (std::size_t begin = 0; begin < count; begin += kBatch) {
    const std::size_t points = std::min(kBatch, count - begin);
    for (std::size_t i = 0; i < points; ++i) {
      const std::size_t row = (begin + i) / width;
      const Vec3 centre(static_cast<double>((begin + i) % width) + 0.5,
                        static_cast<double>(row % rows) + 0.5,
                        static_cast<double>(row / rows) + first + 0.5);
      const Vec3 place = info_.bounds.min + centre.cwiseProduct(voxel);
      x[i] = place.x(), y[i] = place.y(), z[i] = place.z();
    }
    const PlacesAtTime places{std::span(x).first(points), std::span(y).first(points),
                              std::span(z).first(points),
                              info_.times[static_cast<std::size_t>(index)]};
    const auto to = values.subspan(begin * channels, points * channels);
    VOLUTE_TRY(value_(places, to));
    const auto wrong = std::ranges::find_if(to, [](float value) { return !std::isfinite(value); });
    if (wrong != to.end()) {
      const auto i = static_cast<std::size_t>(wrong - to.begin()) / channels;
      return fail(ErrorCode::kInvalidData,
                  "the function of '{}' is {} at ({:g}, {:g}, {:g}) m, {:g} s; expected finite "
                  "values of float32",
                  info_.name, *wrong, x[i], y[i], z[i], places.time);
    }
  }
  return {};
}

}  // namespace volute
