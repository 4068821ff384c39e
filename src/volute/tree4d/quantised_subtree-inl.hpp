// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <utility>

#include "volute/tree4d/haar_node.hpp"
#include "volute/tree4d/quantised_subtree.hpp"

namespace volute::detail {

using Extents4 = std::array<int, 4>;

inline Extents4 halved(const Extents4& n) {
  return {(n[0] + 1) / 2, (n[1] + 1) / 2, (n[2] + 1) / 2, (n[3] + 1) / 2};
}

inline std::size_t cellCount(const Extents4& n) {
  return static_cast<std::size_t>(n[0]) * n[1] * n[2] * n[3];
}

/// Calls visit(parent, children) for each cell of the halved grid: children[o] is the cell that
/// stands for child o and valid the set of children that are really there.
template <class Visit>
void forEachNode(const Extents4& n, Visit&& visit) {
  const Extents4 half = halved(n);
  std::size_t parent = 0;
  std::array<int, 4> p{};
  for (p[0] = 0; p[0] < half[0]; ++p[0])
    for (p[1] = 0; p[1] < half[1]; ++p[1])
      for (p[2] = 0; p[2] < half[2]; ++p[2])
        for (p[3] = 0; p[3] < half[3]; ++p[3], ++parent) {
          std::size_t low[4], step[4];
          unsigned missing = 0;
          std::size_t stride = 1;
          for (int a = 4; a-- > 0;) {
            low[a] = 2 * p[a] * stride;
            const bool there = 2 * p[a] + 1 < n[a];
            step[a] = there ? stride : 0;
            if (!there)
              missing |= 8u >> a;
            stride *= static_cast<std::size_t>(n[a]);
          }
          std::array<std::size_t, kChildren> children;
          unsigned valid = 0;
          for (unsigned o = 0; o < kChildren; ++o) {
            children[o] = low[0] + low[1] + low[2] + low[3] + (o >> 3 & 1) * step[0] +
                          (o >> 2 & 1) * step[1] + (o >> 1 & 1) * step[2] + (o & 1) * step[3];
            if ((o & missing) == 0)
              valid |= 1u << o;
          }
          visit(parent, children, valid);
        }
}

/// One level up: the means of the parents, and visit(parent, channel, coefficients in mean form,
/// valid children).
template <class Visit>
std::vector<float> oneLevelUp(const Extents4& n, int channels, std::span<const float> means,
                              Visit&& visit) {
  std::vector<float> parents(cellCount(halved(n)) * channels);
  forEachNode(n, [&](std::size_t parent, const std::array<std::size_t, kChildren>& children,
                     unsigned valid) {
    for (int c = 0; c < channels; ++c) {
      std::array<float, kChildren> v;
      for (int o = 0; o < kChildren; ++o) v[o] = means[children[o] * channels + c];
      butterfly16(v);
      for (float& value : v) value *= 1.0f / kChildren;
      parents[parent * channels + c] = v[0];
      visit(parent, c, v, children, valid);
    }
  });
  return parents;
}

}  // namespace volute::detail

namespace volute {

template <class Visit>
void visitCoefficients(const SubtreeShape& shape, std::span<const float> means, Visit&& visit) {
  std::vector<float> current(means.begin(), means.end());
  detail::Extents4 n = shape.extents;
  for (int level = 0; level < shape.levels; ++level) {
    const float scale = orthonormalScale(shape.baseLevel + level);
    current = detail::oneLevelUp(n, shape.channels, current,
                                 [&](auto, auto, const auto& v, const auto&, auto) {
                                   for (int j = 1; j < kChildren; ++j) visit(v[j] * scale);
                                 });
    n = detail::halved(n);
  }
}

}  // namespace volute
