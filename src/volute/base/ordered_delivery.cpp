// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/ordered_delivery.hpp"

#include <algorithm>

namespace volute {

Status OrderedDelivery::give(std::int64_t unit, Bytes bytes) {
  maxPending_ = std::max<std::uint64_t>(maxPending_, bytes.size());
  if (!team_.leads())
    return team_.post(unit, std::move(bytes), maxPending_);
  ownBytes_ += bytes.size();
  own_.emplace(unit, std::move(bytes));
  return takeWhatIsThere();
}

// Waits for others only while too much of this rank's own waits for them. Units are begun in order,
// so the next one is done or in work, and its rank has room for it.
Status OrderedDelivery::takeWhatIsThere() {
  while (next_ < units_ &&
         (own_.contains(next_) || ownBytes_ > maxPending_ || team_.arrived(next_)))
    VOLUTE_TRY(takeNext());
  return {};
}

Status OrderedDelivery::takeNext() {
  if (const auto own = own_.find(next_); own != own_.end()) {
    VOLUTE_TRY(take_(next_, own->second));
    ownBytes_ -= own->second.size();
    own_.erase(own);
  } else {
    VOLUTE_ASSIGN(const Bytes bytes, team_.collect(next_));
    VOLUTE_TRY(take_(next_, bytes));
  }
  ++next_;
  return {};
}

Status OrderedDelivery::finish() {
  while (team_.leads() && next_ < units_) VOLUTE_TRY(takeNext());
  return {};
}

}  // namespace volute
