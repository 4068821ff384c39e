// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <span>
#include <vector>

namespace volute {

/// The second moments of values of up to three channels, for their Karhunen-Loeve transform.
struct ColorMoments {
  std::array<double, 9> sum{};  ///< of value_i value_j, row by row

  void add(std::span<const float> values, int channels);
  void add(const ColorMoments& other);
};

/// An orthonormal change of channels: component i of a value is the sum of row i times it.
struct ColorTransform {
  std::array<float, 9> rows{1, 0, 0, 0, 1, 0, 0, 0, 1};

  /// The transform that packs most energy into the first component, least into the last.
  static ColorTransform of(const ColorMoments& moments);

  /// Interleaved values, divided by `unit`, into one plane for each component. One channel stays
  /// one. `unit` is a power of two, so nothing is rounded by it.
  std::vector<float> split(std::span<const float> values, int channels, float unit) const;

  /// Undoes split(). Products are added in the order of the components, in float32.
  void merge(std::span<const float> planes, int channels, float unit,
             std::span<float> values) const;
};

}  // namespace volute
