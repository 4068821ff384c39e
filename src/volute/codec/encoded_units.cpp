// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/encoded_units.hpp"

#include <algorithm>
#include <limits>

#include "volute/base/checksum.hpp"
#include "volute/codec/byte_io.hpp"

namespace volute {

void CodingError::add(const CodingError& other) {
  squared += other.squared;
  maximum = std::max(maximum, other.maximum);
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
  for (const auto& mode : modes) record.u8(byteOfMode(mode));
  for (const LayerError& layer : layers) {
    record.u64(layer.layer);
    record.f64(layer.error.squared);
    record.f64(layer.error.maximum);
  }
  for (const auto& [size, crc] : segments) {
    record.u32(size);
    record.u32(crc);
  }
  for (const std::int64_t number :
       {training.oneSum, training.oneCount, training.moreSum, training.moreCount})
    record.zigzag(number);
  const auto& seen = training.counts.seen;
  for (std::size_t at = 0, before = 0; at < seen.size(); ++at) {
    if (seen[at][0] == 0 && seen[at][1] == 0)
      continue;
    record.varint(at - before);
    record.varint(seen[at][0]);
    record.varint(seen[at][1]);
    before = at;
  }
  return record.take();
}

std::optional<EncodedUnitRecord> EncodedUnitRecord::fromBytes(std::span<const std::byte> bytes,
                                                              std::size_t blocks,
                                                              std::size_t layers) {
  EncodedUnitRecord record;
  record.modes.resize(blocks);
  record.layers.resize(layers);
  ByteReader in(bytes);
  for (auto& mode : record.modes) {
    if (!modeOfByte(in.u8(), mode))
      return std::nullopt;
  }
  for (LayerError& layer : record.layers) {
    layer.layer = in.u64();
    layer.error.squared = in.f64();
    layer.error.maximum = in.f64();
  }
  for (std::size_t i = 0; i < blocks * kWaveletTiers.size(); ++i) {
    const std::uint32_t size = in.u32();
    record.segments.emplace_back(size, in.u32());
  }
  Training& training = record.training;
  for (std::int64_t* number :
       {&training.oneSum, &training.oneCount, &training.moreSum, &training.moreCount})
    *number = in.zigzag();
  for (std::size_t at = 0; in.remaining() > 0;) {
    at += in.varint();
    if (at >= training.counts.seen.size())
      return std::nullopt;
    training.counts.seen[at] = {static_cast<std::uint32_t>(in.varint()),
                                static_cast<std::uint32_t>(in.varint())};
  }
  if (!in.ok())
    return std::nullopt;
  return record;
}

std::array<std::uint64_t, kWaveletTiers.size()> EncodedUnitRecord::tierSizes() const {
  std::array<std::uint64_t, kWaveletTiers.size()> sizes{};
  for (std::size_t i = 0; i < segments.size(); ++i) sizes[i % sizes.size()] += segments[i].first;
  return sizes;
}

Status EncodedUnits::open(const std::filesystem::path& target) {
  auto folder = target == "-" ? std::filesystem::temp_directory_path() : target.parent_path();
  if (folder.empty())
    folder = ".";
  // Of rank 0 alone the target's folder is needed.
  if (!team_.leads() && !Spool::create(folder))
    folder = std::filesystem::temp_directory_path();
  for (std::size_t tier = 0; tier < kWaveletTiers.size(); ++tier) {
    auto spool = Spool::create(folder);
    if (!spool)
      return fail(spool.error().code, "{}: cannot be written: {}", target.string(),
                  spool.error().message);
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

Status EncodedUnits::append(const EncodedBlock& block, Unit& unit) {
  for (std::size_t tier = 0; tier < spools_.size(); ++tier) {
    const auto& bytes = block.tiers[tier];
    unit.segments.emplace_back(static_cast<std::uint32_t>(bytes.size()), crc32(bytes));
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

void EncodedUnits::put(const Unit& unit, FileHead& head) const {
  const std::size_t first = plan_.firstBlock(plan_.unit(unit.number));
  const std::size_t tiers = kWaveletTiers.size();
  for (std::size_t i = 0; i < unit.segments.size(); ++i) {
    const auto [size, crc] = unit.segments[i];
    head.segments[i % tiers * blocks_ + first + i / tiers] = {0, size, crc};
  }
}

Status EncodedUnits::shareSegments(FileHead& head) {
  if (!team_.leads()) {
    ByteWriter out;
    for (const Unit& unit : units_) {
      out.u64(static_cast<std::uint64_t>(unit.number));
      out.u64(unit.segments.size());
      for (const auto& [size, crc] : unit.segments) {
        out.u32(size);
        out.u32(crc);
      }
    }
    return team_.post(team_.rank(), out.take(), std::numeric_limits<std::uint64_t>::max());
  }
  head.segments.assign(blocks_ * kWaveletTiers.size(), SegmentEntry{});
  ranks_.assign(static_cast<std::size_t>(plan_.count()), 0);
  for (const Unit& unit : units_) put(unit, head);
  for (int rank = 1; rank < team_.size(); ++rank) {
    VOLUTE_ASSIGN(const auto bytes, team_.collect(rank));
    for (ByteReader in(bytes); in.remaining() > 0;) {
      Unit unit{static_cast<std::int64_t>(in.u64())};
      ranks_[static_cast<std::size_t>(unit.number)] = rank;
      for (std::uint64_t left = in.u64(); left > 0; --left) {
        const std::uint32_t size = in.u32();
        unit.segments.emplace_back(size, in.u32());
      }
      put(unit, head);
    }
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
