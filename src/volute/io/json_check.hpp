// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "volute/base/result.hpp"

namespace volute {

/// Lists and objects within each other, of any JSON that is read: what goes through them does so by
/// recursion, and none of ours is deeper than 10.
inline constexpr int kDeepestJson = 64;

struct JsonLimits {
  std::size_t members = SIZE_MAX;                 ///< of one object
  std::uint64_t memory = std::uint64_t{2} << 30;  ///< [bytes] of the parsed values, about
};

/// Of text before it is parsed: an error with file and line where lists and objects are deeper
/// within each other than kDeepestJson, where a member is in its object twice, of which parsers
/// keep the last one, or where more is there than the limits say. Of text that is no JSON it may
/// find nothing.
[[nodiscard]] Status checkJson(std::string_view text, const std::string& file,
                               const JsonLimits& limits = {});

}  // namespace volute
