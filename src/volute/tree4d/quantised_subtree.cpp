// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tree4d/quantised_subtree.hpp"

#include <bit>

#include "volute/wavelet/quantiser.hpp"

namespace volute {
namespace {

/// All nodes of a level, kept or not, before the breadth-first listing.
struct DenseLevel {
  std::vector<std::uint16_t> masks;     // coefficients; bit 0 unused
  std::vector<std::uint16_t> children;  // that are kept
  std::vector<std::array<std::uint32_t, kChildren>> cells;
  std::vector<std::int32_t> quantised;  // 16 a node and channel
};

/// Whether a node without children is worth its bytes. `gains` is what its coefficients save, in
/// squared steps of error; a coefficient takes a byte, a node two and a quarter. Asking for 0.3 a
/// byte made the trees of fire and smoke 1 to 2 % smaller at equal error. Coefficients that are
/// whole steps already, as those of a file, always pass (1 >= 0.3 * 3.25): loading loses nothing.
bool worthANode(double gains, int coefficients) {
  constexpr double kGainPerByte = 0.3;
  constexpr double kNodeBytes = 2.25;
  return gains >= kGainPerByte * (coefficients + kNodeBytes);
}

DenseLevel quantiseLevel(const detail::Extents4& n, const SubtreeShape& shape, int level,
                         float step, std::span<const std::uint8_t> kept,
                         std::vector<float>& means) {
  const std::size_t nodes = detail::cellCount(detail::halved(n));
  const int channels = shape.channels;
  DenseLevel dense;
  dense.masks.assign(nodes, 0);
  dense.children.assign(nodes, 0);
  dense.cells.resize(nodes);
  dense.quantised.resize(nodes * channels * kChildren);
  std::vector<float> gains(nodes);
  const float scale = orthonormalScale(shape.baseLevel + level) / step;
  means = detail::oneLevelUp(
      n, channels, means,
      [&](std::size_t node, int c, const auto& v, const auto& children, unsigned valid) {
        std::int32_t* q = &dense.quantised[(node * channels + c) * kChildren];
        for (int j = 1; j < kChildren; ++j) {
          q[j] = quantise(v[j], scale);
          if (q[j] == 0)
            continue;
          dense.masks[node] |= static_cast<std::uint16_t>(1u << j);
          const auto steps = static_cast<float>(q[j]);
          gains[node] += steps * (2 * v[j] * scale - steps);
        }
        if (c > 0)
          return;
        for (unsigned o = 0; o < kChildren; ++o) {
          dense.cells[node][o] = static_cast<std::uint32_t>(children[o]);
          const bool keep = (valid >> o & 1) && !kept.empty() && kept[children[o]];
          if (keep)
            dense.children[node] |= static_cast<std::uint16_t>(1u << o);
        }
      });
  for (std::size_t node = 0; node < nodes; ++node) {
    const int coefficients = std::popcount(dense.masks[node]) * channels;
    if (dense.children[node] == 0 && !worthANode(gains[node], coefficients))
      dense.masks[node] = 0;
  }
  return dense;
}

/// Appends node `node` to its level; returns the cells of its kept children through `next`.
void listNode(const DenseLevel& dense, std::size_t node, int channels, SubtreeLevel& level,
              std::vector<std::uint32_t>& next) {
  const std::uint16_t children = dense.children[node];
  level.masks.push_back(static_cast<std::uint16_t>(dense.masks[node] | (children != 0 ? 1 : 0)));
  if (children != 0)
    level.children.push_back(children);
  for (int c = 0; c < channels; ++c) {
    for (int j = 1; j < kChildren; ++j) {
      const std::int32_t q = dense.quantised[(node * channels + c) * kChildren + j];
      if (dense.masks[node] >> j & 1)
        level.coefficients.push_back(q);
    }
  }
  for (int o = 0; o < kChildren; ++o) {
    if (children >> o & 1)
      next.push_back(dense.cells[node][o]);
  }
}

}  // namespace

QuantisedSubtree buildSubtree(const SubtreeShape& shape, std::span<const float> means,
                              std::span<const std::uint8_t> hasNode, double step) {
  std::vector<float> current(means.begin(), means.end());
  std::vector<std::uint8_t> kept(hasNode.begin(), hasNode.end());
  std::vector<DenseLevel> dense;
  detail::Extents4 n = shape.extents;
  for (int level = 0; level < shape.levels; ++level) {
    dense.push_back(quantiseLevel(n, shape, level, static_cast<float>(step), kept, current));
    n = detail::halved(n);
    kept.assign(detail::cellCount(n), 0);
    for (std::size_t i = 0; i < kept.size(); ++i)
      kept[i] = dense[level].masks[i] != 0 || dense[level].children[i] != 0;
  }

  QuantisedSubtree tree;
  tree.mean = current;
  tree.empty = !kept[0];
  tree.levels.resize(shape.levels);
  std::vector<std::uint32_t> nodes{0};
  for (int level = shape.levels; level-- > 0;) {
    std::vector<std::uint32_t> next;
    for (std::uint32_t node : nodes)
      listNode(dense[level], node, shape.channels, tree.levels[level], next);
    nodes = std::move(next);
  }
  tree.leaves = std::move(nodes);
  return tree;
}

}  // namespace volute
