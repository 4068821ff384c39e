// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/haar_transform.hpp"

namespace volute {
namespace {

struct Average {
  // Halved first, so that no finite pair overflows.
  void operator()(float& a, float& b) const {
    const float low = 0.5f * a + 0.5f * b;
    b = 0.5f * a - 0.5f * b;
    a = low;
  }
};

struct Spread {
  void operator()(float& low, float& high) const {
    const float a = low + high;
    high = low - high;
    low = a;
  }
};

template <class Butterfly>
void alongLine(float* line, int extent, int stride, const Butterfly& butterfly) {
  for (int x = 0; x + stride < extent; x += 2 * stride) butterfly(line[x], line[x + stride]);
}

template <class Butterfly>
void acrossLines(float* first, float* second, int extent, int stride, const Butterfly& butterfly) {
  if (stride == 1) {  // most of the work; a constant stride lets the compiler vectorise it
    for (int x = 0; x < extent; ++x) butterfly(first[x], second[x]);
  } else {
    for (int x = 0; x < extent; x += stride) butterfly(first[x], second[x]);
  }
}

template <class Butterfly>
void alongAxis(float* data, const BlockGrid::Index4& extents, int axis, int stride,
               const Butterfly& butterfly) {
  int step[3] = {stride, stride, stride};
  std::ptrdiff_t partner = static_cast<std::ptrdiff_t>(stride);
  for (int a = 3; a > axis; --a) partner *= extents[a];
  if (axis < 3)
    step[axis] = 2 * stride;
  for (int t = 0; t < extents[0]; t += step[0]) {
    if (axis == 0 && t + stride >= extents[0])
      break;
    for (int z = 0; z < extents[1]; z += step[1]) {
      if (axis == 1 && z + stride >= extents[1])
        break;
      for (int y = 0; y < extents[2]; y += step[2]) {
        if (axis == 2 && y + stride >= extents[2])
          break;
        float* line = data + ((static_cast<std::ptrdiff_t>(t) * extents[1] + z) * extents[2] + y) *
                                 extents[3];
        if (axis == 3) {
          alongLine(line, extents[3], stride, butterfly);
        } else {
          acrossLines(line, line + partner, extents[3], stride, butterfly);
        }
      }
    }
  }
}

}  // namespace

void haarForward(std::span<float> samples, const BlockGrid::Index4& extents) {
  const int longest = *std::ranges::max_element(extents);
  for (int stride = 1; stride < longest; stride *= 2) {
    for (int axis = 0; axis < 4; ++axis)
      alongAxis(samples.data(), extents, axis, stride, Average{});
  }
}

void haarInverse(std::span<float> coefficients, const BlockGrid::Index4& extents) {
  const int longest = *std::ranges::max_element(extents);
  int stride = 1;
  while (2 * stride < longest) stride *= 2;
  for (; stride >= 1; stride /= 2) {
    for (int axis = 3; axis >= 0; --axis)
      alongAxis(coefficients.data(), extents, axis, stride, Spread{});
  }
}

}  // namespace volute
