// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/packed_error.hpp"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace volute {
namespace {

constexpr char kBetween = '\x1f';

}  // namespace

std::string packed(const Error& error) {
  std::string text =
      error.message + kBetween + error.path + kBetween + error.member + kBetween + error.statement;
  for (const Hint& hint : error.hints) {
    text += kBetween + std::to_string(static_cast<int>(hint.change));
    for (const std::string& part : {hint.setting, hint.value, hint.purpose})
      text += kBetween + part;
  }
  return text;
}

Error unpacked(ErrorCode code, std::string_view text) {
  const auto next = [&text] {
    const std::string part(text.substr(0, text.find(kBetween)));
    text.remove_prefix(std::min(part.size() + 1, text.size()));
    return part;
  };
  Error error{code, next()};
  error.path = next();
  error.member = next();
  error.statement = next();
  while (!text.empty()) {
    const int change = std::atoi(next().c_str());
    Hint hint{static_cast<Hint::Change>(std::clamp(change, 0, 4)), next()};
    hint.value = next();
    hint.purpose = next();
    error.hints.push_back(std::move(hint));
  }
  return error;
}

}  // namespace volute
