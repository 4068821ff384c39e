// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace volute {

/// A change of the caller's settings that would help. Each interface words it in its own terms: the
/// command as an option, Python as an argument, the viewer as a control.
struct Hint {
  enum class Change {
    kSet,       ///< give it the value; without one: a value, which only the caller knows
    kChoose,    ///< give it one of the values that the sentence lists
    kRaise,     ///< a greater value
    kLower,     ///< a smaller value
    kLeaveOut,  ///< do not give it
  };

  Change change = Change::kSet;
  std::string setting;    ///< as an argument in Python: "max_memory"
  std::string value{};    ///< as text: "cpu"; empty: the caller's choice
  std::string purpose{};  ///< what then happens: "shows what is intact"; empty: that it works

  bool operator==(const Hint&) const = default;

  static Hint set(std::string setting, std::string value = {}) {
    return {Change::kSet, std::move(setting), std::move(value)};
  }

  static Hint choose(std::string setting) { return {Change::kChoose, std::move(setting)}; }

  static Hint raise(std::string setting) { return {Change::kRaise, std::move(setting)}; }

  static Hint lower(std::string setting) { return {Change::kLower, std::move(setting)}; }

  static Hint leaveOut(std::string setting) { return {Change::kLeaveOut, std::move(setting)}; }

  Hint so(std::string thatThen) && {
    purpose = std::move(thatThen);
    return std::move(*this);
  }
};

/// Alternatives, the best first.
using Hints = std::vector<Hint>;

}  // namespace volute
