// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <numeric>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "volute/base/output_file.hpp"
#include "volute/base/team.hpp"
#include "volute/codec/block_encoder.hpp"
#include "volute/codec/container.hpp"
#include "volute/codec/spool.hpp"
#include "volute/codec/unit_plan.hpp"

namespace volute {

/// How far decoded blocks are from what was encoded. What is empty is exact, so the squares of the
/// support are those of all voxels.
struct CodingError {
  std::array<double, BlockGrid::kSide> squaredOf{};  ///< sums, of each frame of a row
  double maximum = 0;
  std::uint64_t place = 0;  ///< of the maximum: the voxel's number in C order (t, z, y, x)
  double voxels = 0;        ///< of the support

  void add(const CodingError& other);

  double squared() const { return std::accumulate(squaredOf.begin(), squaredOf.end(), 0.0); }
};

/// That of one layer of blocks. Sums of layers in their order are the same for any number of ranks.
struct LayerError {
  std::uint64_t layer = 0;
  CodingError error;
};

struct EncodedBlock {
  std::vector<std::vector<std::byte>> tiers;
  std::vector<std::int64_t> means;  ///< of each channel, for the index
  CodingError error;
};

/// Bytes, and their checksum.
using SegmentSize = std::pair<std::uint32_t, std::uint32_t>;

/// All that is known of a unit besides its bytes, for an earlier run to leave to a later one.
struct EncodedUnitRecord {
  std::vector<std::uint64_t> blocks;            ///< that hold something, ascending
  std::vector<std::optional<BlockMode>> modes;  ///< of each
  std::vector<LayerError> layers;
  std::vector<SegmentSize> segments;  ///< block by block, tier by tier
  std::vector<std::int64_t> means;    ///< block by block, of each channel
  Training training;

  std::vector<std::byte> toBytes() const;

  /// Nothing when the bytes are of no such record.
  static std::optional<EncodedUnitRecord> fromBytes(std::span<const std::byte> bytes);

  /// Bytes of each tier, summed over all blocks.
  std::array<std::uint64_t, kWaveletTiers.size()> tierSizes() const;
};

/// A mode as a byte; 0 is none.
std::uint8_t byteOfMode(const std::optional<BlockMode>& mode);

/// False when there is no such mode.
bool modeOfByte(unsigned byte, std::optional<BlockMode>& mode);

/// The encoded blocks of one pass over a volume: of this rank the bytes, in files without names;
/// together with the other ranks, the segments of the file.
class EncodedUnits {
 public:
  /// What a rank has of a unit, and where each tier's bytes begin in its spools.
  struct Unit {
    std::int64_t number = 0;
    std::vector<std::uint64_t> blocks{};  ///< that hold something, ascending
    std::vector<SegmentSize> segments{};  ///< block by block, tier by tier
    std::vector<std::int64_t> means{};    ///< block by block, of each channel
    std::array<std::uint64_t, kWaveletTiers.size()> begins{}, sizes{};
    bool hasBytes = true;
  };

  EncodedUnits(const UnitPlan& plan, Team& team) : plan_(plan), team_(team) {}

  /// Before the first block: of codec 3, whose segments have their checksums behind them.
  void setChecked(bool checked) { checked_ = checked; }

  /// Makes the files beside the target.
  /// @param name  of the target, in errors
  [[nodiscard]] Status open(const std::filesystem::path& target, const std::string& name);

  /// Throws all away.
  [[nodiscard]] Status clear();

  /// A unit whose bytes follow.
  Unit begin(std::int64_t number) const;

  /// The next block of a unit that was begun, and its number.
  [[nodiscard]] Status append(std::uint64_t number, const EncodedBlock& block, Unit& unit);

  void finish(Unit unit) { units_.push_back(std::move(unit)); }

  /// Puts a unit in the place of one that was finished.
  void replace(std::size_t i, Unit unit) { units_[i] = std::move(unit); }

  /// Of this rank, in the order in which they were finished.
  const std::vector<Unit>& units() const { return units_; }

  /// All bytes of a unit, tier by tier.
  [[nodiscard]] Result<std::vector<std::byte>> bytesOf(const Unit& unit);

  /// Appends bytes as bytesOf() gives them; `unit` states their sizes.
  [[nodiscard]] Status appendBytes(const Unit& unit, std::span<const std::byte> bytes);

  /// Rank 0 gets sizes and checksums of all, and puts them into `head`. Collective.
  [[nodiscard]] Status shareSegments(FileHead& head);

  /// On rank 0: the segments of all ranks, tier by tier and in each unit by unit. Meanwhile the
  /// other ranks are in sendSegments().
  /// @param goesOn  asked now and then; an error ends it
  [[nodiscard]] Status writeSegments(OutputFile& file, const std::function<Status()>& goesOn);
  [[nodiscard]] Status sendSegments();

 private:
  const UnitPlan& plan_;
  Team& team_;
  bool checked_ = false;
  std::vector<Spool> spools_;  // one a tier
  std::vector<Unit> units_;
  std::vector<int> ranks_;  // of rank 0: who has which unit
};

}  // namespace volute
