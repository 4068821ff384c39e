// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/encoded_units.hpp"

#include <algorithm>
#include <limits>

#include "volute/base/checksum.hpp"
#include "volute/codec/byte_io.hpp"

namespace volute {

void CodingError::add(const CodingError& other) {
  for (std::size_t i = 0; i < squaredOf.size(); ++i) squaredOf[i] += other.squaredOf[i];
  voxels += other.voxels;
  if (other.maximum > maximum || (other.maximum == maximum && other.place < place)) {
    maximum = other.maximum;
    place = other.place;
  }
}

std::uint8_t byteOfMode(const std::optional<BlockMode>& mode) {
  const auto all = allBlockModes();
  return static_cast<std::uint8_t>(mode ? std::ranges::find(all, *mode) - all.begin() + 1 : 0);
}

bool modeOfByte(unsigned byte, std::optional<BlockMode>& mode) {
  const auto all = allBlockModes();
  if (byte > all.size())
    return false;
  mode = byte == 0 ? std::nullopt : std::optional(all[byte - 1]);
  return true;
}

// Contexts that saw nothing are left out.
std::vector<std::byte> EncodedUnitRecord::toBytes() const {
  ByteWriter record;
  record.varint(blocks.size());
  for (const std::uint64_t block : blocks) record.varint(block);
  for (const auto& mode : modes) record.u8(byteOfMode(mode));
  record.varint(layers.size());
  for (const LayerError& layer : layers) {
    record.u64(layer.layer);
    for (const double squared : layer.error.squaredOf) record.f64(squared);
    record.f64(layer.error.maximum);
    record.u64(layer.error.place);
    record.f64(layer.error.voxels);
  }
  for (const auto& [size, crc] : segments) {
    record.u32(size);
    record.u32(crc);
  }
  record.varint(means.size());
  for (const std::int64_t mean : means) record.zigzag(mean);
  for (const std::int64_t* number : training.sums()) record.zigzag(*number);
  const auto putCounts = [&](const auto& all) {
    std::uint64_t put = 0;
    for (const auto& counts : all) put += std::ranges::any_of(counts, std::identity()) ? 1 : 0;
    record.varint(put);
    for (std::size_t at = 0, before = 0; at < all.size(); ++at) {
      if (std::ranges::none_of(all[at], std::identity()))
        continue;
      record.varint(at - before);
      for (const std::uint32_t count : all[at]) record.varint(count);
      before = at;
    }
  };
  putCounts(training.counts.seen);
  putCounts(training.symbols);
  return record.take();
}

std::optional<EncodedUnitRecord> EncodedUnitRecord::fromBytes(std::span<const std::byte> bytes) {
  EncodedUnitRecord record;
  ByteReader in(bytes);
  const std::uint64_t blocks = in.varint();
  if (!in.ok() || blocks > in.remaining())
    return std::nullopt;
  for (std::uint64_t i = 0; i < blocks; ++i) record.blocks.push_back(in.varint());
  record.modes.resize(static_cast<std::size_t>(blocks));
  for (auto& mode : record.modes) {
    if (!modeOfByte(in.u8(), mode))
      return std::nullopt;
  }
  const std::uint64_t layers = in.varint();
  if (!in.ok() || layers > in.remaining())
    return std::nullopt;
  record.layers.resize(static_cast<std::size_t>(layers));
  for (LayerError& layer : record.layers) {
    layer.layer = in.u64();
    for (double& squared : layer.error.squaredOf) squared = in.f64();
    layer.error.maximum = in.f64();
    layer.error.place = in.u64();
    layer.error.voxels = in.f64();
  }
  for (std::size_t i = 0; i < blocks * kWaveletTiers.size(); ++i) {
    const std::uint32_t size = in.u32();
    record.segments.emplace_back(size, in.u32());
  }
  const std::uint64_t means = in.varint();
  if (!in.ok() || means > in.remaining())
    return std::nullopt;
  for (std::uint64_t i = 0; i < means; ++i) record.means.push_back(in.zigzag());
  Training& training = record.training;
  for (std::int64_t* number : training.sums()) *number = in.zigzag();
  const auto getCounts = [&](auto& all) {
    std::uint64_t count = in.varint();
    for (std::size_t at = 0; in.ok() && count > 0; --count) {
      at += in.varint();
      if (at >= all.size())
        return false;
      for (std::uint32_t& seen : all[at]) seen = static_cast<std::uint32_t>(in.varint());
    }
    return in.ok();
  };
  training.symbols.resize(symbol::kCount);
  if (!getCounts(training.counts.seen) || !getCounts(training.symbols) || in.remaining() > 0)
    return std::nullopt;
  return record;
}

std::array<std::uint64_t, kWaveletTiers.size()> EncodedUnitRecord::tierSizes() const {
  std::array<std::uint64_t, kWaveletTiers.size()> sizes{};
  for (std::size_t i = 0; i < segments.size(); ++i) sizes[i % sizes.size()] += segments[i].first;
  return sizes;
}

Status EncodedUnits::open(const std::filesystem::path& target, const std::string& name) {
  auto folder = target == "-" ? std::filesystem::temp_directory_path() : target.parent_path();
  if (folder.empty())
    folder = ".";
  // Of rank 0 alone the target's folder is needed.
  if (!team_.leads() && !Spool::create(folder))
    folder = std::filesystem::temp_directory_path();
  for (std::size_t tier = 0; tier < kWaveletTiers.size(); ++tier) {
    auto spool = Spool::create(folder);
    if (!spool) {
      auto failed =
          failIn(name, "", spool.error().code, "cannot be written: {}", spool.error().message);
      failed.value().hints = spool.error().hints;
      return failed;
    }
    spools_.push_back(std::move(*spool));
  }
  return {};
}

Status EncodedUnits::clear() {
  units_.clear();
  for (Spool& spool : spools_) VOLUTE_TRY(spool.clear());
  return {};
}

EncodedUnits::Unit EncodedUnits::begin(std::int64_t number) const {
  Unit unit{number};
  for (std::size_t tier = 0; tier < spools_.size(); ++tier)
    unit.begins[tier] = spools_[tier].size();
  return unit;
}

Status EncodedUnits::append(std::uint64_t number, const EncodedBlock& block, Unit& unit) {
  unit.blocks.push_back(number);
  unit.means.insert(unit.means.end(), block.means.begin(), block.means.end());
  for (std::size_t tier = 0; tier < spools_.size(); ++tier) {
    std::vector<std::byte> bytes = block.tiers[tier];
    const std::uint32_t crc = crc32(bytes);
    if (checked_ && !bytes.empty())
      appendChecksum(bytes);
    unit.segments.emplace_back(static_cast<std::uint32_t>(bytes.size()), crc);
    unit.sizes[tier] += bytes.size();
    VOLUTE_TRY(spools_[tier].write(bytes));
  }
  return {};
}

Result<std::vector<std::byte>> EncodedUnits::bytesOf(const Unit& unit) {
  std::vector<std::byte> bytes;
  for (std::size_t tier = 0; tier < spools_.size(); ++tier) {
    const std::size_t before = bytes.size();
    bytes.resize(before + unit.sizes[tier]);
    VOLUTE_TRY(spools_[tier].read(unit.begins[tier], std::span(bytes).subspan(before)));
  }
  return bytes;
}

Status EncodedUnits::appendBytes(const Unit& unit, std::span<const std::byte> bytes) {
  for (std::size_t tier = 0; tier < spools_.size(); ++tier) {
    VOLUTE_TRY(spools_[tier].write(bytes.first(unit.sizes[tier])));
    bytes = bytes.subspan(unit.sizes[tier]);
  }
  return {};
}

Status EncodedUnits::shareSegments(FileHead& head) {
  if (!team_.leads()) {
    ByteWriter out;
    for (const Unit& unit : units_) {
      out.u64(static_cast<std::uint64_t>(unit.number));
      out.u64(unit.blocks.size());
      for (const std::uint64_t block : unit.blocks) out.u64(block);
      for (const auto& [size, crc] : unit.segments) {
        out.u32(size);
        out.u32(crc);
      }
      out.varint(unit.means.size());
      for (const std::int64_t mean : unit.means) out.zigzag(mean);
    }
    return team_.post(team_.rank(), out.take(), std::numeric_limits<std::uint64_t>::max());
  }
  constexpr std::size_t kTiers = kWaveletTiers.size();
  ranks_.assign(static_cast<std::size_t>(plan_.count()), 0);
  std::vector<Unit> all = units_;
  for (int rank = 1; rank < team_.size(); ++rank) {
    VOLUTE_ASSIGN(const auto bytes, team_.collect(rank));
    for (ByteReader in(bytes); in.remaining() > 0;) {
      Unit unit{static_cast<std::int64_t>(in.u64())};
      ranks_[static_cast<std::size_t>(unit.number)] = rank;
      unit.blocks.resize(static_cast<std::size_t>(in.u64()));
      for (std::uint64_t& block : unit.blocks) block = in.u64();
      for (std::size_t left = kTiers * unit.blocks.size(); left > 0; --left) {
        const std::uint32_t size = in.u32();
        unit.segments.emplace_back(size, in.u32());
      }
      unit.means.resize(static_cast<std::size_t>(in.varint()));
      for (std::int64_t& mean : unit.means) mean = in.zigzag();
      all.push_back(std::move(unit));
    }
  }
  std::ranges::sort(all, {}, &Unit::number);
  head.blocks.clear();
  head.means.clear();
  for (const Unit& unit : all) {
    head.blocks.insert(head.blocks.end(), unit.blocks.begin(), unit.blocks.end());
    head.means.insert(head.means.end(), unit.means.begin(), unit.means.end());
  }
  // Codec 2 has all blocks, without bytes where there is nothing.
  const std::vector<std::uint64_t> occupied = head.blocks;
  if (head.header.codec == static_cast<int>(kWaveletCodec)) {
    head.blocks.resize(BlockGrid(head.info).count());
    std::iota(head.blocks.begin(), head.blocks.end(), std::uint64_t{0});
  }
  head.segments.assign(kTiers * head.blocks.size(), SegmentEntry{});
  std::size_t first = 0;
  for (const Unit& unit : all) {
    for (std::size_t i = 0; i < unit.segments.size(); ++i) {
      const auto [size, crc] = unit.segments[i];
      const std::size_t place = head.placeOf(occupied[first + i / kTiers]);
      head.segments[i % kTiers * head.blocks.size() + place] = {0, size, crc};
    }
    first += unit.blocks.size();
  }
  return {};
}

Status EncodedUnits::writeSegments(OutputFile& file, const std::function<Status()>& goesOn) {
  constexpr std::uint64_t kPiece = std::uint64_t{1} << 20;
  std::vector<std::byte> piece;
  const std::int64_t count = plan_.count();
  for (std::size_t tier = 0; tier < spools_.size(); ++tier) {
    auto own = units_.begin();
    for (std::int64_t number = 0; number < count; ++number) {
      VOLUTE_TRY(goesOn());
      if (ranks_[static_cast<std::size_t>(number)] != 0) {
        const auto item = static_cast<std::int64_t>(tier) * count + number;
        VOLUTE_ASSIGN(const auto bytes, team_.collect(item));
        VOLUTE_TRY(file.write(bytes));
        continue;
      }
      for (std::uint64_t at = 0; at < own->sizes[tier]; at += piece.size()) {
        piece.resize(std::min(kPiece, own->sizes[tier] - at));
        VOLUTE_TRY(spools_[tier].read(own->begins[tier] + at, piece));
        VOLUTE_TRY(file.write(piece));
      }
      ++own;
    }
  }
  return {};
}

Status EncodedUnits::sendSegments() {
  constexpr std::uint64_t kMaxPending = std::uint64_t{64} << 20;
  for (std::size_t tier = 0; tier < spools_.size(); ++tier) {
    for (const Unit& unit : units_) {
      std::vector<std::byte> bytes(unit.sizes[tier]);
      VOLUTE_TRY(spools_[tier].read(unit.begins[tier], bytes));
      const auto item = static_cast<std::int64_t>(tier) * plan_.count() + unit.number;
      VOLUTE_TRY(team_.post(item, std::move(bytes), kMaxPending));
    }
  }
  return {};
}

}  // namespace volute
