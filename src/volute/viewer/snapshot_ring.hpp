// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "volute/viewer/view_scene.hpp"

namespace volute {

/// A cache of loaded snapshots with a memory limit: those ahead of the time that is played, and
/// those shown before. Not thread-safe.
class SnapshotRing {
 public:
  using Held = std::shared_ptr<const ViewScene>;

  void setLimit(std::uint64_t bytes) { limit_ = bytes; }

  /// The snapshot of a time [s]; null: it is not there.
  Held find(double time) const;

  /// Keeps a snapshot. `ahead`: which times are wanted next, in order; those of other times go
  /// first where there is too little room, then the last of `ahead`.
  /// @returns what went, to be freed where that keeps nobody waiting
  std::vector<Held> add(double time, Held snapshot, std::span<const double> ahead);

  /// The first of `ahead` that is not there and that there is room for; nothing: none.
  std::optional<double> missing(std::span<const double> ahead) const;

  /// The times of the snapshots, ascending [s].
  std::vector<double> times() const;

  /// @returns all that was there
  std::vector<Held> clear();

  std::uint64_t bytes() const { return bytes_; }

  std::size_t size() const { return held_.size(); }

 private:
  static constexpr std::uint64_t kEach = 64 << 10;  ///< [bytes] of each, besides what it says
  static constexpr std::size_t kMax = 4096;

  static std::uint64_t bytesOf(const Held& snapshot) { return kEach + snapshot->bytes; }

  bool tooMuch() const { return held_.size() > 1 && (bytes_ > limit_ || held_.size() > kMax); }

  std::uint64_t limit_ = std::uint64_t{256} << 20;
  std::uint64_t bytes_ = 0;
  std::map<double, Held> held_;
};

}  // namespace volute
