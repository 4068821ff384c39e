// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/wavelet/lifting.hpp"

#include "volute/wavelet/lifting_steps.hpp"

namespace volute {
namespace {

/// x[i] += c * (its two neighbours) for i = first, first + 2, ...; a neighbour that is missing is
/// mirrored by the other.
template <class T>
void step(T* x, std::ptrdiff_t n, std::ptrdiff_t stride, std::ptrdiff_t first, T c) {
  for (std::ptrdiff_t i = first; i < n; i += 2) {
    const T left = x[(i > 0 ? i - 1 : i + 1) * stride];
    const T right = x[(i + 1 < n ? i + 1 : i - 1) * stride];
    x[i * stride] += c * (left + right);
  }
}

template <class T>
void scaleAll(T* x, std::ptrdiff_t n, std::ptrdiff_t stride, T low, T high) {
  for (std::ptrdiff_t i = 0; i < n; ++i) x[i * stride] *= i % 2 == 0 ? low : high;
}

template <class T>
void haar(T* x, std::ptrdiff_t n, std::ptrdiff_t stride, T lone) {
  constexpr T kHalf = static_cast<T>(1 / kRootTwo);
  for (std::ptrdiff_t i = 0; i + 1 < n; i += 2) {
    const T a = x[i * stride];
    const T b = x[(i + 1) * stride];
    x[i * stride] = (a + b) * kHalf;
    x[(i + 1) * stride] = (a - b) * kHalf;
  }
  if (n % 2 == 1)
    x[(n - 1) * stride] *= lone;
}

}  // namespace

std::optional<Wavelet> waveletByName(std::string_view name) {
  for (Wavelet wavelet : {Wavelet::kHaar, Wavelet::kCdf53, Wavelet::kCdf97}) {
    if (name == waveletName(wavelet))
      return wavelet;
  }
  return {};
}

std::string_view waveletName(Wavelet wavelet) {
  switch (wavelet) {
    case Wavelet::kHaar:
      return "haar";
    case Wavelet::kCdf53:
      return "cdf53";
    default:
      return "cdf97";
  }
}

template <class T>
void liftForward(T* x, std::ptrdiff_t n, std::ptrdiff_t stride, Wavelet wavelet) {
  if (n == 1) {
    x[0] *= static_cast<T>(kRootTwo);
  } else if (wavelet == Wavelet::kHaar) {
    haar(x, n, stride, static_cast<T>(kRootTwo));
  } else {
    const LiftingSteps scheme = liftingSteps(wavelet);
    for (int s = 0; s < scheme.count; ++s)
      step(x, n, stride, s % 2 == 0 ? 1 : 0, static_cast<T>(scheme.factor[s]));
    scaleAll(x, n, stride, static_cast<T>(scheme.scale), static_cast<T>(1 / scheme.scale));
  }
}

template <class T>
void liftInverse(T* x, std::ptrdiff_t n, std::ptrdiff_t stride, Wavelet wavelet) {
  if (n == 1) {
    x[0] *= static_cast<T>(1 / kRootTwo);
  } else if (wavelet == Wavelet::kHaar) {
    haar(x, n, stride, static_cast<T>(1 / kRootTwo));
  } else {
    const LiftingSteps scheme = liftingSteps(wavelet);
    scaleAll(x, n, stride, static_cast<T>(1 / scheme.scale), static_cast<T>(scheme.scale));
    for (int s = scheme.count; s-- > 0;)
      step(x, n, stride, s % 2 == 0 ? 1 : 0, static_cast<T>(-scheme.factor[s]));
  }
}

template void liftForward<float>(float*, std::ptrdiff_t, std::ptrdiff_t, Wavelet);
template void liftForward<double>(double*, std::ptrdiff_t, std::ptrdiff_t, Wavelet);
template void liftInverse<float>(float*, std::ptrdiff_t, std::ptrdiff_t, Wavelet);
template void liftInverse<double>(double*, std::ptrdiff_t, std::ptrdiff_t, Wavelet);

}  // namespace volute
