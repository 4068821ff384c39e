// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/wavelet/transform4d.hpp"

#include <algorithm>

namespace volute {
namespace {

/// Samples of an axis of `extent` that stand 2^level apart, from 0 on.
std::ptrdiff_t samplesAt(std::ptrdiff_t extent, int level) {
  return ((extent - 1) >> level) + 1;
}

/// Lifts all lines along `axis` of the grid whose samples stand 2^strideLevel[a] apart on axis a.
template <class T, class Lift>
void liftAxis(View<T, 4> view, int axis, const std::array<int, 4>& strideLevel, Lift lift) {
  std::array<std::ptrdiff_t, 4> counts{};
  for (int a = 0; a < 4; ++a) counts[a] = a == axis ? 1 : samplesAt(view.extent(a), strideLevel[a]);
  const std::ptrdiff_t n = samplesAt(view.extent(axis), strideLevel[axis]);
  const std::ptrdiff_t stride = view.stride(axis) << strideLevel[axis];
  std::array<std::ptrdiff_t, 4> i{};
  for (i[0] = 0; i[0] < counts[0]; ++i[0])
    for (i[1] = 0; i[1] < counts[1]; ++i[1])
      for (i[2] = 0; i[2] < counts[2]; ++i[2])
        for (i[3] = 0; i[3] < counts[3]; ++i[3]) {
          T* line = view.data();
          for (int a = 0; a < 4; ++a) line += (i[a] << strideLevel[a]) * view.stride(a);
          lift(line, n, stride);
        }
}

/// Before level `level`, samples of axis a stand 2^min(level, levels[a]) apart.
std::array<int, 4> strideLevelsAt(int level, const std::array<int, 4>& levels) {
  std::array<int, 4> result{};
  for (int a = 0; a < 4; ++a) result[a] = std::min(level, levels[a]);
  return result;
}

}  // namespace

template <class T>
void transformForward(View<T, 4> samples, Wavelet wavelet, const std::array<int, 4>& levels) {
  const int deepest = *std::ranges::max_element(levels);
  for (int level = 0; level < deepest; ++level) {
    for (int axis = 4; axis-- > 0;) {
      if (level >= levels[axis])
        continue;
      // Axes are lifted one after the other on the same grid: the stride grows when all are done.
      liftAxis(samples, axis, strideLevelsAt(level, levels),
               [&](T* line, std::ptrdiff_t n, std::ptrdiff_t stride) {
                 liftForward(line, n, stride, wavelet);
               });
    }
  }
}

template <class T>
void transformInverse(View<T, 4> coefficients, Wavelet wavelet, const std::array<int, 4>& levels) {
  const int deepest = *std::ranges::max_element(levels);
  for (int level = deepest; level-- > 0;) {
    for (int axis = 0; axis < 4; ++axis) {
      if (level >= levels[axis])
        continue;
      liftAxis(coefficients, axis, strideLevelsAt(level, levels),
               [&](T* line, std::ptrdiff_t n, std::ptrdiff_t stride) {
                 liftInverse(line, n, stride, wavelet);
               });
    }
  }
}

template void transformForward<float>(View<float, 4>, Wavelet, const std::array<int, 4>&);
template void transformForward<double>(View<double, 4>, Wavelet, const std::array<int, 4>&);
template void transformInverse<float>(View<float, 4>, Wavelet, const std::array<int, 4>&);
template void transformInverse<double>(View<double, 4>, Wavelet, const std::array<int, 4>&);

}  // namespace volute
