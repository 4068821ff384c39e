// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstring>
#include <span>
#include <vector>

#include "volute/base/team.hpp"

namespace volute {

/// The values in each of some messages.
template <class Value>
std::vector<std::vector<Value>> valuesIn(std::span<const std::vector<std::byte>> messages) {
  std::vector<std::vector<Value>> values;
  for (const auto& bytes : messages) {
    auto& one = values.emplace_back(bytes.size() / sizeof(Value));
    if (!bytes.empty())
      std::memcpy(static_cast<void*>(one.data()), bytes.data(), bytes.size());
  }
  return values;
}

/// Collective. The values of all ranks, bit for bit, in the order of ranks.
template <class Value>
[[nodiscard]] Result<std::vector<std::vector<Value>>> gatherEach(Team& team,
                                                                 std::span<const Value> own) {
  VOLUTE_ASSIGN(const auto all, team.gatherAll(std::as_bytes(own)));
  return valuesIn<Value>(all);
}

/// Collective. The values that each rank has for this one, bit for bit, in the order of ranks.
/// @param toEach  what this rank has for each
template <class Value>
[[nodiscard]] Result<std::vector<std::vector<Value>>> exchangeValues(
    Team& team, std::span<const std::vector<Value>> toEach) {
  std::vector<std::vector<std::byte>> sent;
  for (const auto& values : toEach) {
    const auto bytes = std::as_bytes(std::span(values));
    sent.emplace_back(bytes.begin(), bytes.end());
  }
  VOLUTE_ASSIGN(const auto received, team.exchangeAll(sent));
  return valuesIn<Value>(received);
}

/// The values of all ranks, one after the other. Collective.
template <class Value>
[[nodiscard]] Result<std::vector<Value>> gatherValues(Team& team, std::span<const Value> own) {
  VOLUTE_ASSIGN(const auto each, gatherEach(team, own));
  std::vector<Value> all;
  for (const auto& one : each) all.insert(all.end(), one.begin(), one.end());
  return all;
}

}  // namespace volute
