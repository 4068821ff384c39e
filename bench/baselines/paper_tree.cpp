// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "bench/baselines/paper_tree.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "volute/base/assert.hpp"
#include "volute/base/parallel.hpp"
#include "volute/tree4d/haar_node.hpp"
#include "volute/tree4d/quantised_subtree.hpp"

namespace volute {
namespace {

constexpr std::size_t kFixedBytes = 4 * sizeof(std::uint16_t) + 2 * sizeof(std::uint16_t);

template <class T>
T readAt(const std::vector<std::byte>& bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

template <class T>
void append(std::vector<std::byte>& bytes, T value) {
  const auto* begin = reinterpret_cast<const std::byte*>(&value);
  bytes.insert(bytes.end(), begin, begin + sizeof value);
}

unsigned bitCount(unsigned mask) {
  return static_cast<unsigned>(std::popcount(mask));
}

/// 1 or -1: the sign of wavelet j in child o.
int signOf(unsigned j, unsigned o) {
  return bitCount(j & o) % 2 == 0 ? 1 : -1;
}

}  // namespace

/// What a threshold keeps of one level.
struct PaperTransform::Kept {
  std::vector<std::uint16_t> masks;  // coefficients; bit 0 unused
  std::vector<std::uint16_t> children;
};

PaperTransform::PaperTransform(const Sequence& sequence) : info_(sequence.info) {
  std::vector<float> means = sequence.values;
  const auto [low, high] = std::ranges::minmax(means);
  range_ = static_cast<double>(high) - low;
  detail::Extents4 n{info_.frames, info_.z, info_.y, info_.x};
  const int channels = info_.channels;
  for (int l = 0; l == 0 || detail::cellCount(n) > 1; ++l) {
    Level level;
    level.nodes = detail::halved(n);
    const std::size_t nodes = detail::cellCount(level.nodes);
    level.coefficients.resize(nodes * channels * kChildren);
    level.validChildren.resize(nodes);
    level.cells.resize(nodes);
    const float scale = orthonormalScale(l);
    means = detail::oneLevelUp(
        n, channels, means,
        [&](std::size_t node, int c, const auto& v, const auto& children, unsigned valid) {
          float* to = &level.coefficients[(node * channels + c) * kChildren];
          for (int j = 1; j < kChildren; ++j) to[j] = v[j] * scale;
          level.validChildren[node] = static_cast<std::uint16_t>(valid);
          std::ranges::copy(children, level.cells[node].begin());
        });
    level.magnitudes.resize(nodes * kChildren);
    level.energies.resize(nodes * kChildren);
    for (std::size_t i = 0; i < nodes * kChildren; ++i) {
      for (int c = 0; c < channels; ++c) {
        const float v =
            level.coefficients[(i / kChildren * channels + c) * kChildren + i % kChildren];
        level.magnitudes[i] = std::max(level.magnitudes[i], std::fabs(v));
        level.energies[i] += v * v;
      }
    }
    levels_.push_back(std::move(level));
    n = detail::halved(n);
  }
  mean_ = means;
}

std::vector<PaperTransform::Kept> PaperTransform::keep(double threshold) const {
  constexpr std::size_t kGrain = 4096;
  const auto least = std::max(static_cast<float>(threshold), std::numeric_limits<float>::min());
  std::vector<Kept> kept(levels_.size());
  for (std::size_t l = 0; l < levels_.size(); ++l) {
    const Level& level = levels_[l];
    kept[l].masks.resize(level.cells.size());
    kept[l].children.resize(level.cells.size());
    parallelRanges(level.cells.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t node = begin; node < end; ++node) {
        unsigned mask = 0, children = 0;
        for (int j = 1; j < kChildren; ++j)
          mask |= static_cast<unsigned>(level.magnitudes[node * kChildren + j] >= least) << j;
        for (unsigned o = 0; l > 0 && o < kChildren; ++o) {
          const std::uint32_t cell = level.cells[node][o];
          const bool there = level.validChildren[node] >> o & 1;
          if (there && (kept[l - 1].masks[cell] != 0 || kept[l - 1].children[cell] != 0))
            children |= 1u << o;
        }
        kept[l].masks[node] = static_cast<std::uint16_t>(mask);
        kept[l].children[node] = static_cast<std::uint16_t>(children);
      }
    });
  }
  return kept;
}

std::size_t PaperTransform::bytesAt(double threshold) const {
  const auto kept = keep(threshold);
  std::size_t bytes = sizeof(float) * info_.channels;
  for (std::size_t l = 0; l < kept.size(); ++l) {
    for (std::size_t i = 0; i < kept[l].masks.size(); ++i) {
      const bool isRoot = l + 1 == kept.size();
      if (!isRoot && kept[l].masks[i] == 0 && kept[l].children[i] == 0)
        continue;
      bytes += kFixedBytes + bitCount(kept[l].masks[i]) * sizeof(float) * info_.channels +
               bitCount(kept[l].children[i]) * sizeof(std::uint32_t);
    }
  }
  return bytes;
}

double PaperTransform::relativeRmsAt(double threshold) const {
  const auto least = static_cast<float>(threshold);
  double dropped = 0;
  for (const Level& level : levels_) {
    for (std::size_t i = 0; i < level.magnitudes.size(); ++i) {
      if (level.magnitudes[i] < least)
        dropped += level.energies[i];
    }
  }
  return range_ > 0 ? std::sqrt(dropped / static_cast<double>(info_.values())) / range_ : 0;
}

namespace {

/// The largest x in [0, high] with holds(x), to half a percent, for a condition that holds below
/// some x and not above.
template <class Holds>
double bisect(double high, Holds&& holds) {
  double low = high * 1e-14;
  if (!holds(low))
    return 0;
  for (int i = 0; i < 40 && high > low * 1.005; ++i) {
    const double middle = std::sqrt(low * high);
    (holds(middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace

double PaperTransform::thresholdForRms(double relativeRms) const {
  const double high = range_ * orthonormalScale(static_cast<int>(levels_.size()));
  return bisect(high, [&](double threshold) { return relativeRmsAt(threshold) <= relativeRms; });
}

double PaperTransform::thresholdForBytes(std::size_t bytes) const {
  const double high = range_ * orthonormalScale(static_cast<int>(levels_.size()));
  return bisect(high, [&](double threshold) { return bytesAt(threshold) >= bytes; });
}

PaperTree PaperTransform::build(double threshold) const {
  const auto kept = keep(threshold);
  const int channels = info_.channels;
  PaperTree tree;
  tree.info_ = info_;
  tree.levels_ = static_cast<int>(levels_.size());
  auto& bytes = tree.bytes_;
  for (float mean : mean_) append(bytes, mean);

  std::vector<std::uint32_t> nodes{0};
  std::vector<std::size_t> offsetFields;  // where the parents wait for the offsets of `nodes`
  for (std::size_t l = levels_.size(); l-- > 0;) {
    const Level& level = levels_[l];
    std::vector<std::uint32_t> nextNodes;
    std::vector<std::size_t> nextFields;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const std::uint32_t node = nodes[i];
      if (!offsetFields.empty()) {
        const auto offset = static_cast<std::uint32_t>(bytes.size());
        std::memcpy(bytes.data() + offsetFields[i], &offset, sizeof offset);
      }
      std::uint32_t rest = node;
      std::array<std::uint16_t, 4> position{};
      for (int a = 4; a-- > 0;) {
        position[a] = static_cast<std::uint16_t>(rest % level.nodes[a]);
        rest /= level.nodes[a];
      }
      for (std::uint16_t p : position) append(bytes, p);
      append(bytes, kept[l].masks[node]);
      append(bytes, kept[l].children[node]);
      for (int j = 1; j < kChildren; ++j) {
        if (!(kept[l].masks[node] >> j & 1))
          continue;
        for (int c = 0; c < channels; ++c)
          append(bytes, level.coefficients[(node * channels + c) * kChildren + j]);
      }
      for (int o = 0; o < kChildren; ++o) {
        if (!(kept[l].children[node] >> o & 1))
          continue;
        nextNodes.push_back(level.cells[node][o]);
        nextFields.push_back(bytes.size());
        append(bytes, std::uint32_t{0});
      }
    }
    tree.nodes_ += nodes.size();
    nodes = std::move(nextNodes);
    offsetFields = std::move(nextFields);
  }
  return tree;
}

void PaperTree::values(int t, int z, int y, int x, std::span<float> out) const {
  const int channels = info_.channels;
  for (int c = 0; c < channels; ++c) out[c] = readAt<float>(bytes_, c * sizeof(float));
  std::size_t node = channels * sizeof(float);
  for (int l = levels_ - 1;; --l) {
    VOLUTE_ASSERT(readAt<std::uint16_t>(bytes_, node) == t >> (l + 1));
    const unsigned mask = readAt<std::uint16_t>(bytes_, node + 8);
    const unsigned children = readAt<std::uint16_t>(bytes_, node + 10);
    const auto o = static_cast<unsigned>((t >> l & 1) << 3 | (z >> l & 1) << 2 | (y >> l & 1) << 1 |
                                         (x >> l & 1));
    const float scale = 1 / orthonormalScale(l);
    std::size_t at = node + kFixedBytes;
    for (unsigned m = mask; m != 0; m &= m - 1) {
      const float basis =
          static_cast<float>(signOf(static_cast<unsigned>(std::countr_zero(m)), o)) * scale;
      for (int c = 0; c < channels; ++c, at += sizeof(float))
        out[c] += readAt<float>(bytes_, at) * basis;
    }
    if (!(children >> o & 1))
      return;
    node = readAt<std::uint32_t>(bytes_,
                                 at + sizeof(std::uint32_t) * bitCount(children & ((1u << o) - 1)));
  }
}

float PaperTree::value(int t, int z, int y, int x, int channel) const {
  std::array<float, 3> out{};
  values(t, z, y, x, out);
  return out[channel];
}

Eigen::Matrix<double, 5, 5> paperViewMatrix(const Eigen::Matrix3d& rotation, double t) {
  Eigen::Matrix<double, 5, 5> m = Eigen::Matrix<double, 5, 5>::Zero();
  m.topLeftCorner<3, 3>() = rotation;
  m(3, 4) = t;
  m(4, 4) = 1;
  return m;
}

std::vector<float> renderByTraversal(const PaperTree& tree, const Eigen::Matrix<double, 5, 5>& view,
                                     int n, const VoxelBox* box) {
  const VolumeInfo& info = tree.info();
  const int channels = info.channels;
  const double longest = std::max({info.x, info.y, info.z});
  const Eigen::Vector3d centre(0.5 * info.x, 0.5 * info.y, 0.5 * info.z);
  std::vector<float> image(static_cast<std::size_t>(n) * n * channels);
  parallelFor(n, [&](std::size_t row) {
    std::array<float, 3> value{};
    for (int column = 0; column < n; ++column) {
      float* pixel = &image[(row * n + column) * channels];
      for (int depth = 0; depth < n; ++depth) {
        // The view volume: x right, y away from the eye, z up, as long as the volume's longest
        // side.
        Eigen::Matrix<double, 5, 1> p;
        p << (column + 0.5) / n - 0.5, (depth + 0.5) / n - 0.5,
            0.5 - (static_cast<double>(row) + 0.5) / n, 0, 1;
        p.head<3>() *= longest;
        const Eigen::Matrix<double, 5, 1> u = view * p;
        const int x = static_cast<int>(std::floor(u[0] + centre[0]));
        const int y = static_cast<int>(std::floor(u[1] + centre[1]));
        const int z = static_cast<int>(std::floor(u[2] + centre[2]));
        if (box != nullptr) {
          if (z < box->begin[0] || z >= box->end[0] || y < box->begin[1] || y >= box->end[1] ||
              x < box->begin[2] || x >= box->end[2]) {
            continue;
          }
        } else if (x < 0 || y < 0 || z < 0 || x >= info.x || y >= info.y || z >= info.z) {
          continue;
        }
        tree.values(static_cast<int>(u[3]), z, y, x, value);
        for (int c = 0; c < channels; ++c) pixel[c] += value[c];
      }
      for (int c = 0; c < channels; ++c) pixel[c] /= static_cast<float>(n);
    }
  });
  return image;
}

}  // namespace volute
