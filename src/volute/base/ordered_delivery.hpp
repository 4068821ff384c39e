// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <map>

#include "volute/base/team.hpp"

namespace volute {

/// Hands what units of a stage give, on whichever rank, to rank 0 in the order of units: frames of
/// a film, lines of a table. A few wait at a time, whatever their number: ranks that are ahead wait
/// for the others.
///
///     OrderedDelivery film(team, frames, 64 << 20, [&](std::int64_t frame, auto bytes) { .. });
///     team.forUnits("rendering", frames, progress,
///                   [&](std::int64_t frame) { return film.give(frame, draw(frame)); },
///                   [&] { return film.finish(); });
class OrderedDelivery {
 public:
  using Bytes = std::vector<std::byte>;

  /// @param maxPending  bytes that may wait on each rank, one unit's at least.
  /// @param take  called on rank 0, for each unit in order.
  OrderedDelivery(Team& team, std::int64_t units, std::uint64_t maxPending,
                  std::function<Status(std::int64_t, const Bytes&)> take)
      : team_(team), units_(units), maxPending_(maxPending), take_(std::move(take)) {}

  /// What a unit gave, in any order on rank 0, in ascending order on others.
  [[nodiscard]] Status give(std::int64_t unit, Bytes bytes);

  /// When this rank has no more units: takes what is left. For `last` of Team::forUnits.
  [[nodiscard]] Status finish();

 private:
  [[nodiscard]] Status takeWhatIsThere();
  [[nodiscard]] Status takeNext();

  Team& team_;
  std::int64_t units_;
  std::uint64_t maxPending_;
  std::function<Status(std::int64_t, const Bytes&)> take_;
  std::map<std::int64_t, Bytes> own_;  // of rank 0, before their turn
  std::uint64_t ownBytes_ = 0;
  std::int64_t next_ = 0;
};

}  // namespace volute
