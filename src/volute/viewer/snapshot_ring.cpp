// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/snapshot_ring.hpp"

#include <algorithm>
#include <utility>

namespace volute {

SnapshotRing::Held SnapshotRing::find(double time) const {
  const auto found = held_.find(time);
  return found == held_.end() ? nullptr : found->second;
}

std::vector<SnapshotRing::Held> SnapshotRing::add(double time, Held snapshot,
                                                  std::span<const double> ahead) {
  std::vector<Held> gone;
  const auto drop = [&](std::map<double, Held>::iterator at) {
    bytes_ -= bytesOf(at->second);
    gone.push_back(std::move(at->second));
    held_.erase(at);
  };
  if (const auto same = held_.find(time); same != held_.end())
    drop(same);
  bytes_ += bytesOf(snapshot);
  held_.emplace(time, std::move(snapshot));
  for (auto at = held_.begin(); tooMuch() && at != held_.end();) {
    const auto here = at++;
    if (here->first != time && std::ranges::find(ahead, here->first) == ahead.end())
      drop(here);
  }
  for (std::size_t i = ahead.size(); tooMuch() && i-- > 0;) {
    if (const auto last = held_.find(ahead[i]); last != held_.end() && ahead[i] != time)
      drop(last);
  }
  return gone;
}

std::optional<double> SnapshotRing::missing(std::span<const double> ahead) const {
  std::uint64_t wanted = 0;
  for (const double time : ahead) {
    const auto found = held_.find(time);
    if (found == held_.end()) {
      const std::uint64_t each = held_.empty() ? 0 : bytes_ / held_.size();
      return wanted + each <= limit_ ? std::optional(time) : std::nullopt;
    }
    wanted += bytesOf(found->second);
  }
  return std::nullopt;
}

std::vector<double> SnapshotRing::times() const {
  std::vector<double> times;
  for (const auto& [time, snapshot] : held_) times.push_back(time);
  return times;
}

std::vector<SnapshotRing::Held> SnapshotRing::clear() {
  std::vector<Held> gone;
  for (auto& [time, snapshot] : held_) gone.push_back(std::move(snapshot));
  held_.clear();
  bytes_ = 0;
  return gone;
}

}  // namespace volute
