// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/assert.hpp"
#include "volute/base/result.hpp"
#include "volute/cli/values.hpp"

namespace volute::cli {

/// The words of a command line after parsing: values checked, defaults filled in.
class Arguments {
 public:
  void set(std::string_view name, Value value, bool given) {
    values_.insert_or_assign(std::string(name), Stored{std::move(value), given});
  }

  void addPositional(std::string text) { positionals_.push_back(std::move(text)); }

  void setPositional(std::size_t index, std::string text) { positionals_[index] = std::move(text); }

  /// True when the user wrote the option; a default does not count.
  bool given(std::string_view name) const {
    const auto found = values_.find(name);
    return found != values_.end() && found->second.given;
  }

  bool flag(std::string_view name) const { return given(name); }

  /// The value, or the option's default, or nothing. T must be what the option's kind says
  /// (values.hpp).
  template <class T>
  std::optional<T> find(std::string_view name) const {
    const auto found = values_.find(name);
    if (found == values_.end())
      return std::nullopt;
    VOLUTE_ASSERT(std::holds_alternative<T>(found->second.value));
    return std::get<T>(found->second.value);
  }

  /// The value of an option that was given, whatever its type.
  const Value* value(std::string_view name) const {
    const auto found = values_.find(name);
    return found == values_.end() ? nullptr : &found->second.value;
  }

  /// The values of an option that may be repeated.
  std::vector<std::string> all(std::string_view name) const {
    return find<std::vector<std::string>>(name).value_or(std::vector<std::string>());
  }

  /// For options that are required or have a default.
  template <class T>
  T get(std::string_view name) const {
    const auto value = find<T>(name);
    VOLUTE_ASSERT(value.has_value());
    return *value;
  }

  /// The value of an option; nothing where it was not given.
  template <class T>
  std::optional<T> findGiven(std::string_view name) const {
    return given(name) ? find<T>(name) : std::nullopt;
  }

  /// The options of the command; must outlive this.
  std::span<const Option> options() const { return options_; }

  void setOptions(std::span<const Option> options) { options_ = options; }

  const std::vector<std::string>& positionals() const { return positionals_; }

  const std::string& positional(std::size_t index) const { return positionals_[index]; }

 private:
  struct Stored {
    Value value;
    bool given;
  };

  std::map<std::string, Stored, std::less<>> values_;
  std::vector<std::string> positionals_;
  std::span<const Option> options_;
};

}  // namespace volute::cli
