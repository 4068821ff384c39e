// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "volute/codec/coefficient_coder.hpp"
#include "volute/codec/wavelet_codec.hpp"

// What of a block stands before and after its coefficients, and the way through them; for writing,
// reading and pricing alike (see coefficient_coder.hpp). docs/format.md, section 8.

namespace volute {

/// @param full  all voxels are coded, so that none can be left out of a support
template <class Bits>
void codeMode(Bits& bits, BlockMode& mode, bool full = false) {
  mode.shaped = !full && bits.bit(context::kShaped, mode.shaped);
  if (!bits.bit(context::kWavelet, mode.wavelet != Wavelet::kCdf97)) {
    mode.wavelet = Wavelet::kCdf97;
  } else {
    mode.wavelet = bits.bit(context::kWavelet + 1, mode.wavelet == Wavelet::kHaar)
                       ? Wavelet::kHaar
                       : Wavelet::kCdf53;
  }
  const bool many = bits.bit(context::kTime, mode.timeLevels >= 2);
  const bool odd =
      bits.bit(context::kTime + (many ? 2u : 1u), mode.timeLevels == 1 || mode.timeLevels == 4);
  mode.timeLevels = many ? (odd ? 4 : 2) : (odd ? 1 : 0);
}

/// The support, line by line, from the lines before: a line's bits as a word, bit x for voxel x.
/// A line whose neighbouring lines are all empty, or all full, has a bit of its own that says
/// whether it goes on like that.
template <class Bits>
class SupportCoder {
 public:
  SupportCoder(Bits& bits, const BlockGrid::Index4& extents, std::span<std::uint8_t> support)
      : bits_(bits), e_(extents), support_(support) {}

  void run() {
    const std::size_t count = static_cast<std::size_t>(e_[0]) * e_[1] * e_[2];
    lines_.assign(count, 0);
    std::size_t at = 0;
    for (int t = 0; t < e_[0]; ++t)
      for (int z = 0; z < e_[1]; ++z)
        for (int y = 0; y < e_[2]; ++y, ++at) {
          std::span<std::uint8_t> voxels = support_.subspan(at * e_[3], e_[3]);
          std::uint32_t wanted = 0;
          for (int x = 0; x < e_[3]; ++x) wanted |= static_cast<std::uint32_t>(voxels[x]) << x;
          lines_[at] = line(t, z, y, wanted);
          for (int x = 0; x < e_[3]; ++x) voxels[x] = lines_[at] >> x & 1;
        }
  }

 private:
  std::uint32_t at(int t, int z, int y) const {
    if (t < 0 || z < 0 || y < 0 || z >= e_[1] || y >= e_[2])
      return 0;
    return lines_[(static_cast<std::size_t>(t) * e_[1] + z) * e_[2] + y];
  }

  std::uint32_t line(int t, int z, int y, std::uint32_t wanted) {
    const std::uint32_t full = (1u << e_[3]) - 1;
    const std::uint32_t y1 = at(t, z, y - 1);
    const std::uint32_t z1 = at(t, z - 1, y);
    const std::uint32_t t1 = at(t - 1, z, y);
    const std::uint32_t z1after = at(t, z - 1, y + 1);
    const std::uint32_t z1before = at(t, z - 1, y - 1);
    const std::uint32_t t1y = at(t - 1, z, y + 1);
    const std::uint32_t t1z = at(t - 1, z + 1, y);
    if ((y1 | z1 | t1 | z1after | z1before | t1y | t1z) == 0) {
      if (bits_.bit(context::kLine, wanted == 0))
        return 0;
    } else if ((y1 & z1 & t1) == full) {
      if (bits_.bit(context::kLine + 1, wanted == full))
        return full;
    }
    std::uint32_t line = 0;
    for (int x = 0; x < e_[3]; ++x) {
      const auto before = [x](std::uint32_t word) { return word << 1 >> x & 1; };
      const auto here = [x](std::uint32_t word) { return word >> x & 1; };
      const auto after = [x](std::uint32_t word) { return word >> x >> 1 & 1; };
      const std::uint32_t c = before(line) | here(y1) << 1 | here(z1) << 2 | here(t1) << 3 |
                              after(y1) << 4 | after(z1) << 5 | here(z1after) << 6 |
                              after(t1) << 7 | here(t1y) << 8 | here(t1z) << 9 | before(y1) << 10 |
                              here(z1before) << 11;
      if (bits_.bit(context::kSupport + c, (wanted >> x & 1) != 0))
        line |= 1u << x;
    }
    return line;
  }

  Bits& bits_;
  BlockGrid::Index4 e_;
  std::span<std::uint8_t> support_;
  std::vector<std::uint32_t> lines_;
};

/// Codes which voxels of a block belong to its support (1) and which do not (0).
template <class Bits>
void codeSupport(Bits& bits, const BlockGrid::Index4& extents, std::span<std::uint8_t> support) {
  SupportCoder<Bits>(bits, extents, support).run();
}

/// Codes what the voxels of a block are: which are active, and which of the others hold something.
template <class Bits>
void codeStates(Bits& bits, const BlockGrid::Index4& extents, std::span<VoxelState> states,
                std::vector<std::uint8_t>& room) {
  const bool full =
      std::ranges::all_of(states, [](VoxelState state) { return state == VoxelState::kActive; });
  if (bits.bit(context::kFull, full)) {
    std::ranges::fill(states, VoxelState::kActive);
    return;
  }
  room.resize(states.size());
  bool any = false;
  for (std::size_t i = 0; i < states.size(); ++i) {
    room[i] = states[i] == VoxelState::kActive ? 1 : 0;
    any = any || states[i] == VoxelState::kValued;
  }
  codeSupport(bits, extents, std::span(room));
  any = bits.bit(context::kOther, any);
  const std::array<std::size_t, 4> step{
      static_cast<std::size_t>(extents[1]) * extents[2] * extents[3],
      static_cast<std::size_t>(extents[2]) * extents[3], static_cast<std::size_t>(extents[3]), 1};
  std::size_t at = 0;
  BlockGrid::Index4 i{};
  for (i[0] = 0; i[0] < extents[0]; ++i[0])
    for (i[1] = 0; i[1] < extents[1]; ++i[1])
      for (i[2] = 0; i[2] < extents[2]; ++i[2])
        for (i[3] = 0; i[3] < extents[3]; ++i[3], ++at) {
          if (room[at] != 0 || !any) {
            states[at] = room[at] != 0 ? VoxelState::kActive : VoxelState::kEmpty;
            continue;
          }
          unsigned neighbours = 0;
          for (std::size_t axis = 0; axis < 4; ++axis)
            neighbours =
                3 * neighbours + (i[axis] > 0 ? static_cast<unsigned>(states[at - step[axis]]) : 0);
          states[at] =
              bits.bit(context::kOtherVoxel + neighbours, states[at] == VoxelState::kValued)
                  ? VoxelState::kValued
                  : VoxelState::kEmpty;
        }
}

/// Codes them in the order of voxels, by lines of x.
template <class Bits>
void codeOutliers(Bits& bits, const BlockShape& shape, std::vector<Outlier>& outliers) {
  if (!bits.bit(context::kOutliers, !outliers.empty()))
    return;
  const auto line = static_cast<std::uint32_t>(shape.extents[3]);
  const auto voxels = static_cast<std::uint32_t>(shape.voxels());
  std::vector<Outlier> all;
  auto next = outliers.begin();
  for (std::uint32_t begin = 0; begin < voxels; begin += line) {
    const bool any = next != outliers.end() && next->voxel < begin + line;
    if (!bits.bit(context::kOutliers + 1, any))
      continue;
    bool before = false;
    for (std::uint32_t voxel = begin; voxel < begin + line; ++voxel) {
      const bool is = next != outliers.end() && next->voxel == voxel;
      before = bits.bit(context::kOutliers + (before ? 3u : 2u), is);
      if (!before)
        continue;
      Outlier& one = all.emplace_back(Outlier{voxel});
      for (int c = 0; c < shape.channels; ++c) {
        const auto wanted =
            is ? std::bit_cast<std::uint32_t>(next->value[static_cast<std::size_t>(c)]) : 0u;
        std::uint32_t word = 0;
        for (int i = 32; i-- > 0;) word = word << 1 | (bits.even((wanted >> i & 1) != 0) ? 1u : 0u);
        one.value[static_cast<std::size_t>(c)] = std::bit_cast<float>(word);
      }
      if (is)
        ++next;
    }
  }
  outliers = std::move(all);
}

/// Whole numbers of corrections for the values of a block, most of them 0; by lines of x.
template <class Bits>
void codeCorrections(Bits& bits, const BlockShape& shape, std::span<std::int32_t> corrections) {
  const std::size_t line = static_cast<std::size_t>(shape.extents[3]) * shape.channels;
  for (std::size_t begin = 0; begin < corrections.size(); begin += line) {
    const auto values = corrections.subspan(begin, line);
    bool any = false;
    for (std::int32_t value : values) any = any || value != 0;
    if (!bits.bit(context::kCorrected, any))
      continue;
    bool before = false;
    for (std::int32_t& value : values) {
      before = bits.bit(context::kCorrected + (before ? 2u : 1u), value != 0);
      if (!before)
        continue;
      // Never 0: from 1 up and from -1 down.
      const std::int32_t coded =
          codeNumber(bits, context::kCorrection, value > 0 ? value : value - 1);
      value = coded > 0 ? coded : coded + 1;
    }
  }
}

/// The magnitudes of a component at the level that is coded and the one above.
struct ComponentMemory {
  CellMemory current, above;
};

/// The way through the coefficients of a block, stride by stride and within one component by
/// component, from coarse to fine.
class BlockWalk {
 public:
  /// @param memories  room, one for each component; used up to the end of the walk.
  BlockWalk(const BlockShape& shape, const BlockMode& mode, std::span<const std::uint8_t> support,
            std::span<ComponentMemory> memories)
      : shape_(shape),
        mode_(mode),
        support_(support),
        levels_(blockLevels(shape.extents, mode.timeLevels)),
        memories_(memories) {}

  /// Calls code(component, position, norm) for each scaling coefficient.
  template <class Code>
  void scaling(const Code& code) const {
    const ScalingLattice lattice(shape_.extents, levels_, mode_.wavelet);
    for (int c = 0; c < shape_.channels; ++c) {
      BlockGrid::Index4 i{};
      for (i[0] = 0; i[0] < lattice.count[0]; ++i[0])
        for (i[1] = 0; i[1] < lattice.count[1]; ++i[1])
          for (i[2] = 0; i[2] < lattice.count[2]; ++i[2])
            for (i[3] = 0; i[3] < lattice.count[3]; ++i[3]) {
              std::ptrdiff_t position = 0;
              for (int axis = 0; axis < 4; ++axis) position += i[axis] * lattice.step[axis];
              if (support_.empty() || support_[position] != 0)
                code(c, position, lattice.norm);
            }
    }
  }

  /// Calls code(component, level, position, existing, context, neighbours, q) as codeLevel() does.
  template <class Code>
  void cells(const TierStrides& strides, const Code& code) {
    for (int stride = strides.first; stride > strides.end; --stride) {
      if (stride >= deepest(levels_))
        continue;
      CellLevel level(shape_.extents, levels_, stride, mode_.wavelet);
      for (int c = 0; c < shape_.channels; ++c) {
        ComponentMemory& memory = memories_[static_cast<std::size_t>(c)];
        std::swap(memory.current, memory.above);
        codeLevel(level, support_, above_ ? &*above_ : nullptr, above_ ? &memory.above : nullptr,
                  memory.current,
                  [&](auto&&... rest) { return code(c, std::as_const(level), rest...); });
      }
      above_ = level;
    }
  }

 private:
  BlockShape shape_;
  BlockMode mode_;
  std::span<const std::uint8_t> support_;
  AxisLevels levels_;
  std::span<ComponentMemory> memories_;
  std::optional<CellLevel> above_;
};

}  // namespace volute
