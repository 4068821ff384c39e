// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstring>
#include <span>
#include <vector>

#include "volute/base/team.hpp"

namespace volute {

/// Collective. The values of all ranks, bit for bit, in the order of ranks.
template <class Value>
[[nodiscard]] Result<std::vector<std::vector<Value>>> gatherEach(Team& team,
                                                                std::span<const Value> own) {
  VOLUTE_ASSIGN(const auto all, team.gatherAll(std::as_bytes(own)));
  std::vector<std::vector<Value>> values;
  for (const auto& bytes : all) {
    auto& one = values.emplace_back(bytes.size() / sizeof(Value));
    if (!bytes.empty())
      std::memcpy(static_cast<void*>(one.data()), bytes.data(), bytes.size());
  }
  return values;
}

/// The same, one after the other.
template <class Value>
[[nodiscard]] Result<std::vector<Value>> gatherValues(Team& team, std::span<const Value> own) {
  VOLUTE_ASSIGN(const auto each, gatherEach(team, own));
  std::vector<Value> all;
  for (const auto& one : each) all.insert(all.end(), one.begin(), one.end());
  return all;
}

}  // namespace volute
