// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>
#include <span>
#include <string_view>

namespace volute {

/// How many letters must be inserted, removed, replaced or swapped with their neighbour to make `b`
/// of `a` (optimal string alignment distance).
std::size_t editDistance(std::string_view a, std::string_view b);

/// The candidate that a person who typed `text` most likely meant; empty when none is near.
std::string_view nearest(std::string_view text, std::span<const std::string_view> candidates);

}  // namespace volute
