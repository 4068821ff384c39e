// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/background.hpp"

#include <algorithm>
#include <vector>

#include "volute/base/assert.hpp"

namespace volute {
namespace {

float medianOf(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1)
    return *middle;
  return 0.5f * (*middle + *std::max_element(values.begin(), middle));
}

}  // namespace

Result<Image> medianImage(std::size_t count, std::uint64_t maxMemory,
                          const std::function<Result<Image>(std::size_t)>& picture) {
  VOLUTE_ASSERT(count > 0);
  VOLUTE_ASSIGN(Image median, picture(0));
  const std::uint64_t bytes = sizeof(float) * median.pixels.size();
  const auto room = std::max<std::uint64_t>(1, maxMemory / 2 / std::max<std::uint64_t>(1, bytes));
  const std::size_t taken = static_cast<std::size_t>(std::min<std::uint64_t>(count, room));
  std::vector<Image> pictures{median};
  for (std::size_t i = 1; i < taken; ++i) {
    VOLUTE_ASSIGN(auto next, picture(i * count / taken));
    VOLUTE_ASSERT(next.pixels.size() == median.pixels.size());
    pictures.push_back(std::move(next));
  }
  std::vector<float> values(pictures.size());
  for (std::size_t p = 0; p < median.pixels.size(); ++p) {
    std::ranges::transform(pictures, values.begin(),
                           [&](const Image& image) { return image.pixels[p]; });
    median.pixels[p] = medianOf(values);
  }
  return median;
}

}  // namespace volute
