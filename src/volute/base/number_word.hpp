// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <charconv>
#include <string_view>
#include <system_error>

namespace volute {

/// Whether all of `word` is one number, which may have a plus before it; then `value` is it.
/// Infinity and NaN are numbers, too.
template <class T>
bool readNumber(std::string_view word, T& value) {
  if (word.starts_with('+') && !word.starts_with("+-"))
    word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  return error == std::errc() && end == word.data() + word.size();
}

}  // namespace volute
