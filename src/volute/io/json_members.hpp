// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>

#include "volute/base/suggest.hpp"
#include "volute/io/json_values.hpp"
#include "volute/math/vec.hpp"

namespace volute {

inline constexpr double kUnlimited = std::numeric_limits<double>::infinity();

/// A name found from the folder of the file that says it.
std::string besides(const std::string& file, const std::string& name);

/// One object of a JSON file: its members by name, and errors that say where they stand.
class Members {
 public:
  /// `json` and `file` must outlive it.
  Members(const nlohmann::json& json, const std::string& file, std::string path)
      : json_(json), file_(file), path_(std::move(path)) {}

  /// An object without other names than these.
  Status check(std::span<const std::string_view> names) const {
    if (!json_.is_object())
      return fail(ErrorCode::kInvalidData, "{}: {}: expected an object", file_, path_);
    for (const auto& [key, value] : json_.items()) {
      if (std::ranges::find(names, key) != names.end())
        continue;
      const auto near = nearest(key, names);
      return fail(ErrorCode::kInvalidData, "{}: {}/{}: this name is unknown{}", file_, path_, key,
                  near.empty() ? "" : fmt::format("; did you mean '{}'?", near));
    }
    return {};
  }

  bool has(const char* key) const { return json_.contains(key); }

  const nlohmann::json& at(const char* key) const { return json_[key]; }

  std::string where(const char* key) const { return path_ + "/" + key; }

  /// Leaves `value` as it is where the member is missing.
  Status number(const char* key, double& value, double least = -kUnlimited,
                double most = kUnlimited) const {
    if (!has(key))
      return {};
    VOLUTE_ASSIGN(value, jsonToNumber(json_[key], file_, where(key)));
    if (value >= least && value <= most)
      return {};
    return wrong(key, std::isinf(most) ? fmt::format("at least {}", least)
                                       : fmt::format("{} to {}", least, most));
  }

  Status integer(const char* key, int& value, int least, int most) const {
    if (!has(key))
      return {};
    if (!json_[key].is_number_integer())
      return wrong(key, fmt::format("a whole number from {} to {}", least, most));
    double number = 0;
    VOLUTE_TRY(this->number(key, number, least, most));
    value = static_cast<int>(number);
    return {};
  }

  Status text(const char* key, std::string& value, const char* expected) const {
    if (!has(key) || !json_[key].is_string())
      return fail(ErrorCode::kInvalidData, "{}: {}: expected {}", file_, where(key), expected);
    value = json_[key].get<std::string>();
    return {};
  }

  Status vector(const char* key, Vec3& value) const {
    if (!has(key))
      return {};
    VOLUTE_ASSIGN(value, jsonToVector(json_[key], file_, where(key)));
    return {};
  }

  /// Three numbers within limits.
  Status color(const char* key, Rgb& value, double most) const {
    Vec3 given = value.matrix();
    VOLUTE_TRY(vector(key, given));
    value = given.array();
    if ((value >= 0).all() && (value <= most).all())
      return {};
    return wrong(key, std::isinf(most) ? "numbers of at least 0" : "numbers from 0 to 1");
  }

  /// The library's objection, at a member.
  Status objection(const char* key, const Error& error) const {
    return fail(ErrorCode::kInvalidData, "{}: {}: {}", file_, where(key), error.message);
  }

 private:
  Status wrong(const char* key, std::string_view expected) const {
    return fail(ErrorCode::kInvalidData, "{}: {}: {} is out of range; expected {}", file_,
                where(key), json_[key].dump(), expected);
  }

  const nlohmann::json& json_;
  const std::string& file_;
  std::string path_;
};

}  // namespace volute
