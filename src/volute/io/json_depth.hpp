// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

#include "volute/base/result.hpp"

namespace volute {

/// Lists and objects within each other, of any JSON that is read: what goes through them does so by
/// recursion, and none of ours is deeper than 10.
inline constexpr int kDeepestJson = 64;

/// Before `text` is parsed. Brackets in strings do not count.
[[nodiscard]] inline Status checkJsonDepth(std::string_view text, const std::string& file) {
  int depth = 0;
  bool quoted = false;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    if (quoted) {
      at += c == '\\' ? 1 : 0;
      quoted = c != '"';
    } else if (c == '"') {
      quoted = true;
    } else if (c == '[' || c == '{') {
      if (++depth <= kDeepestJson)
        continue;
      const auto line =
          1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(at), '\n');
      return fail(ErrorCode::kInvalidData,
                  "{}: line {}: lists and objects more than {} deep within each other (byte {}); "
                  "expected at most {}",
                  file, line, kDeepestJson, at, kDeepestJson);
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return {};
}

}  // namespace volute
