// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace volute {

/// The biorthogonal wavelets of the codec, by their lifting steps. Haar is the paper's (Ahrenberg
/// et al. 2005, section 6).
enum class Wavelet {
  kHaar,
  kCdf53,  ///< Cohen-Daubechies-Feauveau 5/3 (LeGall)
  kCdf97,  ///< Cohen-Daubechies-Feauveau 9/7
};

/// "haar", "cdf53" or "cdf97"; empty for any other name.
std::optional<Wavelet> waveletByName(std::string_view name);
std::string_view waveletName(Wavelet wavelet);

/// One level of the transform of `n` samples x[0], x[stride], ..., in place and interleaved:
/// afterwards the even samples are the scaling (low) and the odd samples the wavelet (high)
/// coefficients. Symmetric extension at both ends; scaled so that the low of a constant is sqrt(2)
/// times it (orthonormal for Haar). Of an odd number of samples the last is a low without a
/// partner; of one sample nothing is changed but that scale. T is float or double.
template <class T>
void liftForward(T* x, std::ptrdiff_t n, std::ptrdiff_t stride, Wavelet wavelet);

/// Undoes liftForward.
template <class T>
void liftInverse(T* x, std::ptrdiff_t n, std::ptrdiff_t stride, Wavelet wavelet);

}  // namespace volute
