// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/grid/bricks.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "volute/base/assert.hpp"
#include "volute/base/checksum.hpp"
#include "volute/base/parallel.hpp"

namespace volute {
namespace {

constexpr int kSide = Bricks::kSide;

/// In the order of voxels: z slowest.
bool before(const VoxelIndex& a, const VoxelIndex& b) {
  return std::tie(a[2], a[1], a[0]) < std::tie(b[2], b[1], b[0]);
}

/// What a message begins with; tiles, leaves and values follow.
struct MessageHead {
  std::uint64_t leaves = 0, tiles = 0, leftOut = 0;
  std::array<float, 3> background{};
  std::int32_t channels = 1;
};

template <class Value>
std::byte* put(std::byte* to, const Value* values, std::size_t count) {
  if (count > 0)
    std::memcpy(to, values, count * sizeof(Value));
  return to + count * sizeof(Value);
}

/// The voxels of a leaf that lie in a box, counted from the leaf's first one.
struct LeafPart {
  std::array<int, 3> begin{}, end{};

  LeafPart(const VoxelIndex& origin, const IndexBox& box) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      begin[axis] =
          static_cast<int>(std::clamp<std::int64_t>(box.begin[axis] - origin[axis], 0, kSide));
      end[axis] =
          static_cast<int>(std::clamp<std::int64_t>(box.end[axis] - origin[axis], 0, kSide));
    }
  }

  /// The bits of one z.
  std::uint64_t mask(int z) const {
    if (z < begin[2] || z >= end[2] || begin[0] >= end[0])
      return 0;
    const std::uint64_t row = (0xFFull >> (kSide - (end[0] - begin[0]))) << begin[0];
    std::uint64_t mask = 0;
    for (int y = begin[1]; y < end[1]; ++y) mask |= row << (kSide * y);
    return mask;
  }
};

}  // namespace

BrickMask maskInside(const VoxelIndex& origin, const IndexBox& box) {
  const LeafPart part(origin, box);
  BrickMask mask{};
  for (int z = part.begin[2]; z < part.end[2]; ++z)
    mask[static_cast<std::size_t>(z)] = part.mask(z);
  return mask;
}

std::uint64_t voxelsIn(const IndexBox& box) {
  if (box.empty())
    return 0;
  constexpr std::uint64_t kMax = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t voxels = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const auto side = static_cast<std::uint64_t>(box.size(axis));
    voxels = side > kMax / voxels ? kMax : voxels * side;
  }
  return voxels;
}

std::span<float> Bricks::addLeaf(const Leaf& leaf) {
  leaves_.push_back(leaf);
  for (int c = 0; c < channels_; ++c)
    values_.resize(values_.size() + kVoxels, background_[static_cast<std::size_t>(c)]);
  return values(leaves_.size() - 1);
}

void Bricks::append(const Bricks& other) {
  VOLUTE_ASSERT(channels_ == other.channels_);
  leaves_.insert(leaves_.end(), other.leaves_.begin(), other.leaves_.end());
  values_.insert(values_.end(), other.values_.begin(), other.values_.end());
  tiles_.insert(tiles_.end(), other.tiles_.begin(), other.tiles_.end());
}

void Bricks::reserve(std::size_t leaves, std::size_t tiles) {
  leaves_.reserve(leaves);
  values_.reserve(leaves * leafValues());
  tiles_.reserve(tiles);
}

Bricks Bricks::fromDense(const VolumeInfo& info, std::span<const float> values,
                         const std::array<float, 3>& background) {
  return fromLayers(info, 0, info.z, values, background);
}

Bricks Bricks::fromLayers(const VolumeInfo& info, int firstLayer, int endLayer,
                          std::span<const float> values, const std::array<float, 3>& background) {
  Bricks all(info.channels, background);
  const auto channels = static_cast<std::size_t>(info.channels);
  const auto width = static_cast<std::size_t>(info.x), height = static_cast<std::size_t>(info.y);
  const int firstBrick = firstLayer / kSide, endBrick = (endLayer + kSide - 1) / kSide;
  const int across = (info.x + kSide - 1) / kSide, down = (info.y + kSide - 1) / kSide;
  // A layer of bricks is a task.
  std::vector<Bricks> layers(static_cast<std::size_t>(endBrick - firstBrick),
                             Bricks(info.channels, background));
  parallelFor(layers.size(), [&](std::size_t i) {
    Bricks& layer = layers[i];
    const int z0 = (firstBrick + static_cast<int>(i)) * kSide;
    std::vector<float> brick(all.leafValues());
    for (int by = 0; by < down; ++by) {
      for (int bx = 0; bx < across; ++bx) {
        const int columns = std::min(kSide, info.x - bx * kSide);
        // Calls visit(z, y, row) for each row of the brick, with places in the brick.
        const auto forRows = [&](const auto& visit) {
          for (int z = std::max(z0, firstLayer); z < std::min(z0 + kSide, endLayer); ++z) {
            for (int y = by * kSide; y < std::min((by + 1) * kSide, info.y); ++y)
              visit(static_cast<std::size_t>(z - z0), y % kSide,
                    &values[((static_cast<std::size_t>(z - firstLayer) * height +
                              static_cast<std::size_t>(y)) *
                                 width +
                             static_cast<std::size_t>(bx * kSide)) *
                            channels]);
          }
        };
        Leaf leaf{{bx * kSide, by * kSide, z0}};
        std::uint64_t any = 0;
        forRows([&](std::size_t z, int y, const float* row) {
          for (int x = 0; x < columns; ++x, row += channels) {
            for (std::size_t c = 0; c < channels; ++c) {
              if (row[c] != background[c])
                leaf.active[z] |= 1ull << (kSide * y + x);
            }
          }
          any |= leaf.active[z];
        });
        if (any == 0)
          continue;
        leaf.valued = leaf.active;
        const std::span<float> to = layer.addLeaf(leaf);
        forRows([&](std::size_t z, int y, const float* row) {
          const std::size_t place = (z * kSide + static_cast<std::size_t>(y)) * kSide;
          for (int x = 0; x < columns; ++x) {
            for (std::size_t c = 0; c < channels; ++c)
              to[c * kVoxels + place + static_cast<std::size_t>(x)] =
                  row[static_cast<std::size_t>(x) * channels + c];
          }
        });
      }
    }
  });
  std::size_t count = 0;
  for (const Bricks& layer : layers) count += layer.leaves_.size();
  all.reserve(count, 0);
  for (const Bricks& layer : layers) all.append(layer);
  return all;
}

void Bricks::toDense(const IndexBox& box, std::span<float> values) const {
  const auto channels = static_cast<std::size_t>(channels_);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = background_[i % channels];
  const auto rowAt = [&](std::int64_t x, std::int64_t y, std::int64_t z) {
    return values.data() + static_cast<std::size_t>(
                               ((z - box.begin[2]) * box.size(1) + y - box.begin[1]) * box.size(0) +
                               x - box.begin[0]) *
                               channels;
  };
  for (const Tile& tile : tiles_) {
    const IndexBox part = tile.box().intersection(box);
    if (part.empty())
      continue;
    for (std::int64_t z = part.begin[2]; z < part.end[2]; ++z) {
      for (std::int64_t y = part.begin[1]; y < part.end[1]; ++y) {
        float* to = rowAt(part.begin[0], y, z);
        for (std::int64_t x = part.begin[0]; x < part.end[0]; ++x)
          to = std::copy_n(tile.value.begin(), channels, to);
      }
    }
  }
  parallelRanges(leaves_.size(), 64, [&](std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) {
      const VoxelIndex& origin = leaves_[i].origin;
      const LeafPart part(origin, box);
      const std::span<const float> from = this->values(i);
      for (int z = part.begin[2]; z < part.end[2]; ++z) {
        for (int y = part.begin[1]; y < part.end[1] && part.begin[0] < part.end[0]; ++y) {
          float* to = rowAt(origin[0] + part.begin[0], origin[1] + y, origin[2] + z);
          for (int x = part.begin[0]; x < part.end[0]; ++x) {
            for (std::size_t c = 0; c < channels; ++c)
              *to++ = from[c * kVoxels + static_cast<std::size_t>((z * kSide + y) * kSide + x)];
          }
        }
      }
    }
  });
}

void Bricks::sort() {
  std::ranges::sort(tiles_, before, &Tile::origin);
  if (std::ranges::is_sorted(leaves_, before, &Leaf::origin))
    return;
  std::vector<std::size_t> order(leaves_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::sort(order, before, [&](std::size_t i) { return leaves_[i].origin; });
  std::vector<Leaf> leaves;
  std::vector<float> values;
  leaves.reserve(leaves_.size());
  values.reserve(values_.size());
  for (const std::size_t i : order) {
    leaves.push_back(leaves_[i]);
    const auto own = std::as_const(*this).values(i);
    values.insert(values.end(), own.begin(), own.end());
  }
  leaves_ = std::move(leaves);
  values_ = std::move(values);
}

std::size_t Bricks::find(const VoxelIndex& origin) const {
  const auto at = std::ranges::lower_bound(leaves_, origin, before, &Leaf::origin);
  return static_cast<std::size_t>(
      (at != leaves_.end() && at->origin == origin ? at : leaves_.end()) - leaves_.begin());
}

void Bricks::fillUnderTiles() {
  if (leaves_.empty())
    return;
  const auto phaseOf = [](std::int64_t place) { return (place % kSide + kSide) % kSide; };
  const VoxelIndex& lattice = leaves_.front().origin;
  const auto fill = [&](const Tile& tile, std::size_t leaf) {
    const VoxelIndex& o = leaves_[leaf].origin;
    const IndexBox part = tile.box().intersection({o, {o[0] + kSide, o[1] + kSide, o[2] + kSide}});
    const std::span<float> to = values(leaf);
    for (auto z = part.begin[2]; z < part.end[2]; ++z) {
      for (auto y = part.begin[1]; y < part.end[1]; ++y) {
        for (auto x = part.begin[0]; x < part.end[0]; ++x) {
          const auto bit = static_cast<std::size_t>((y - o[1]) * kSide + x - o[0]);
          const auto layer = static_cast<std::size_t>(z - o[2]);
          if ((leaves_[leaf].valued[layer] >> bit & 1) != 0)
            continue;
          for (std::size_t c = 0; c < static_cast<std::size_t>(channels_); ++c)
            to[c * kVoxels + layer * kSide * kSide + bit] = tile.value[c];
        }
      }
    }
  };
  for (const Tile& tile : tiles_) {
    VoxelIndex first = tile.origin;
    std::uint64_t places = 1;
    bool aligned = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      first[axis] -= phaseOf(tile.origin[axis] - lattice[axis]);
      aligned = aligned && first[axis] == tile.origin[axis];
      places *= static_cast<std::uint64_t>(tile.side / kSide + 1);
    }
    if (aligned)
      continue;  // a leaf is in it or beside it, and no source has both
    if (places > leaves_.size()) {
      for (std::size_t leaf = 0; leaf < leaves_.size(); ++leaf) fill(tile, leaf);
      continue;
    }
    const IndexBox box = tile.box();
    VoxelIndex at;
    for (at[2] = first[2]; at[2] < box.end[2]; at[2] += kSide) {
      for (at[1] = first[1]; at[1] < box.end[1]; at[1] += kSide) {
        for (at[0] = first[0]; at[0] < box.end[0]; at[0] += kSide) {
          if (const std::size_t leaf = find(at); leaf < leaves_.size())
            fill(tile, leaf);
        }
      }
    }
  }
}

std::uint64_t Bricks::activeVoxels() const {
  std::uint64_t count = 0;
  for (const Leaf& leaf : leaves_) {
    for (const std::uint64_t word : leaf.active)
      count += static_cast<std::uint64_t>(std::popcount(word));
  }
  for (const Tile& tile : tiles_) {
    const auto side = static_cast<std::uint64_t>(tile.side);
    count += tile.active ? side * side * side : 0;
  }
  return count;
}

std::size_t Bricks::messageBytes() const {
  return sizeof(MessageHead) + tiles_.size() * sizeof(Tile) + leaves_.size() * sizeof(Leaf) +
         values_.size() * sizeof(float);
}

void Bricks::toMessage(std::span<std::byte> message) const {
  VOLUTE_ASSERT(message.size() >= messageBytes());
  const MessageHead head{leaves_.size(), tiles_.size(), leftOut_, background_, channels_};
  std::byte* to = put(message.data(), &head, 1);
  to = put(to, tiles_.data(), tiles_.size());
  to = put(to, leaves_.data(), leaves_.size());
  put(to, values_.data(), values_.size());
}

std::uint32_t Bricks::checksum() const {
  std::uint32_t sum = crc32(std::as_bytes(std::span(leaves_)));
  sum = 31 * sum + crc32(std::as_bytes(std::span(values_)));
  for (const Tile& tile : tiles_) {
    sum = 31 * sum + crc32(std::as_bytes(std::span(tile.origin)));
    sum = 31 * sum + crc32(std::as_bytes(std::span(tile.value))) +
          static_cast<std::uint32_t>(tile.side) * 2 + (tile.active ? 1 : 0);
  }
  return sum;
}

Result<Bricks> Bricks::fromMessage(std::span<const std::byte> message) {
  constexpr std::int64_t kFarthest = std::int64_t{1} << 40;
  const auto malformed = [](std::string_view what) {
    return fail(ErrorCode::kInvalidData, "describes a frame that cannot be: {}", what);
  };
  MessageHead head;
  if (message.size() < sizeof head)
    return malformed("it is cut short");
  std::memcpy(&head, message.data(), sizeof head);
  message = message.subspan(sizeof head);
  if ((head.channels != 1 && head.channels != 3) ||
      !std::ranges::all_of(head.background, [](float value) { return std::isfinite(value); }))
    return malformed("its channels or its background");
  Bricks all(head.channels, head.background);
  all.leftOut_ = head.leftOut;
  const std::size_t leafBytes = sizeof(Leaf) + all.leafValues() * sizeof(float);
  if (head.tiles > message.size() / sizeof(Tile) || head.leaves > message.size() / leafBytes ||
      head.tiles * sizeof(Tile) + head.leaves * leafBytes > message.size())
    return malformed("it is cut short");
  const auto take = [&](auto& to, std::size_t count) {
    to.resize(count);
    const std::size_t size = count * sizeof(to[0]);
    if (size > 0)
      std::memcpy(to.data(), message.data(), size);
    message = message.subspan(size);
  };
  take(all.tiles_, static_cast<std::size_t>(head.tiles));
  take(all.leaves_, static_cast<std::size_t>(head.leaves));
  take(all.values_, static_cast<std::size_t>(head.leaves) * all.leafValues());
  const auto near = [](const VoxelIndex& origin) {
    return std::ranges::all_of(origin,
                               [](std::int64_t i) { return i > -kFarthest && i < kFarthest; });
  };
  for (Tile& tile : all.tiles_) {
    std::uint8_t active = 0;  // any byte may stand where a bool is
    std::memcpy(&active, &tile.active, 1);
    tile.active = active != 0;
    if (!near(tile.origin) || tile.side < kSide || tile.side > kFarthest ||
        !std::has_single_bit(static_cast<std::uint64_t>(tile.side)))
      return malformed("a tile");
  }
  for (std::size_t i = 0; i < all.leaves_.size(); ++i) {
    Leaf& leaf = all.leaves_[i];
    if (!near(leaf.origin))
      return malformed("a leaf");
    const auto values = all.values(i);
    for (std::size_t z = 0; z < leaf.valued.size(); ++z) {
      leaf.valued[z] |= leaf.active[z];
      for (std::uint64_t left = ~leaf.valued[z]; left != 0; left &= left - 1) {
        for (std::size_t c = 0; c < static_cast<std::size_t>(head.channels); ++c)
          values[c * kVoxels + 64 * z + static_cast<std::size_t>(std::countr_zero(left))] =
              head.background[c];
      }
    }
  }
  all.sort();
  const auto twice = [](const auto& list) {
    return std::ranges::adjacent_find(list, {}, [](const auto& one) { return one.origin; }) !=
           list.end();
  };
  if (twice(all.leaves_))
    return malformed("two leaves in one place");
  all.fillUnderTiles();
  return all;
}

void Bricks::shift(const VoxelIndex& by) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (Leaf& leaf : leaves_) leaf.origin[axis] += by[axis];
    for (Tile& tile : tiles_) tile.origin[axis] += by[axis];
  }
}

void Bricks::crop(const IndexBox& box) {
  std::erase_if(tiles_, [&](const Tile& tile) { return tile.box().intersection(box).empty(); });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < leaves_.size(); ++i) {
    Leaf leaf = leaves_[i];
    const LeafPart part(leaf.origin, box);
    std::uint64_t any = 0;
    for (int z = 0; z < kSide; ++z) {
      const std::uint64_t mask = part.mask(z);
      std::uint64_t lost = leaf.valued[static_cast<std::size_t>(z)] & ~mask;
      leaf.active[static_cast<std::size_t>(z)] &= mask;
      leaf.valued[static_cast<std::size_t>(z)] &= mask;
      any |= leaf.valued[static_cast<std::size_t>(z)];
      for (; lost != 0; lost &= lost - 1) {
        for (int c = 0; c < channels_; ++c)
          values(i)[static_cast<std::size_t>(c * kVoxels + z * kSide * kSide +
                                             std::countr_zero(lost))] =
              background_[static_cast<std::size_t>(c)];
      }
    }
    if (any == 0)
      continue;
    leaves_[kept] = leaf;
    if (kept != i)
      std::ranges::copy(values(i), values(kept).begin());
    ++kept;
  }
  leaves_.resize(kept);
  values_.resize(kept * leafValues());
}

}  // namespace volute
