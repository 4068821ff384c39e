// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/json_value.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

namespace volute {

JsonValue JsonValue::child(const nlohmann::json& json, const std::string& step) const {
  JsonValue value(json, file_);
  value.path_ = path_.empty() && step.starts_with('.') ? step.substr(1) : path_ + step;
  return value;
}

std::string JsonValue::where() const {
  return path_.empty() ? file_ : fmt::format("{}: {}", file_, path_);
}

tl::unexpected<Error> JsonValue::fault(std::string_view message) const {
  return fail(ErrorCode::kInvalidData, "{}: {}", where(), message);
}

std::optional<JsonValue> JsonValue::find(std::string_view key) const {
  if (!json_->is_object())
    return std::nullopt;
  const auto found = json_->find(std::string(key));
  if (found == json_->end() || found->is_null())
    return std::nullopt;
  return child(*found, fmt::format(".{}", key));
}

Result<JsonValue> JsonValue::at(std::string_view key) const {
  if (!json_->is_object())
    return fault("expected an object");
  if (auto value = find(key))
    return *value;
  return fault(fmt::format("'{}' is missing", key));
}

Result<std::vector<JsonValue>> JsonValue::items() const {
  if (!json_->is_array())
    return fault("expected a list");
  std::vector<JsonValue> values;
  for (std::size_t i = 0; i < json_->size(); ++i)
    values.push_back(child((*json_)[i], fmt::format("[{}]", i)));
  return values;
}

Result<double> JsonValue::number() const {
  if (json_->is_number() && std::isfinite(json_->get<double>()))
    return json_->get<double>();
  return fault("expected a number");
}

Result<int> JsonValue::integer() const {
  constexpr double kMax = std::numeric_limits<int>::max();
  if (json_->is_number()) {
    const double value = json_->get<double>();
    if (value == std::floor(value) && std::abs(value) <= kMax)
      return static_cast<int>(value);
  }
  return fault("expected a whole number of at most 2147483647");
}

Result<std::string> JsonValue::text() const {
  if (json_->is_string())
    return json_->get<std::string>();
  return fault("expected a text");
}

Result<std::vector<double>> JsonValue::numbers() const {
  VOLUTE_ASSIGN(const auto values, items());
  std::vector<double> numbers;
  for (const JsonValue& value : values) {
    VOLUTE_ASSIGN(const double number, value.number());
    numbers.push_back(number);
  }
  return numbers;
}

Result<std::vector<double>> JsonValue::numbers(std::size_t count) const {
  if (!json_->is_array() || json_->size() != count)
    return fault(fmt::format("expected {} numbers", count));
  return numbers();
}

Result<Vec3> JsonValue::vector() const {
  VOLUTE_ASSIGN(const auto values, numbers(3));
  return Vec3(values[0], values[1], values[2]);
}

Result<std::vector<double>> JsonValue::rows(std::size_t count, std::size_t columns) const {
  if (!json_->is_array() || json_->size() != count)
    return fault(fmt::format("expected {} rows of {} numbers", count, columns));
  VOLUTE_ASSIGN(const auto lines, items());
  std::vector<double> all;
  for (const JsonValue& line : lines) {
    VOLUTE_ASSIGN(const auto values, line.numbers(columns));
    all.insert(all.end(), values.begin(), values.end());
  }
  return all;
}

Result<Mat3> JsonValue::matrix() const {
  VOLUTE_ASSIGN(const auto numbers, rows(3, 3));
  return Mat3(numbers.data()).transpose();
}

Result<Mat4> JsonValue::affine() const {
  VOLUTE_ASSIGN(auto numbers, rows(json_->is_array() && json_->size() == 3 ? 3 : 4, 4));
  if (numbers.size() == 12)
    numbers.insert(numbers.end(), {0, 0, 0, 1});
  return Mat4(numbers.data()).transpose();
}

std::vector<std::string> JsonValue::unknownKeys(
    std::initializer_list<std::string_view> known) const {
  std::vector<std::string> unknown;
  if (!json_->is_object())
    return unknown;
  for (const auto& [key, value] : json_->items()) {
    if (std::ranges::find(known, key) == known.end())
      unknown.push_back(path_.empty() ? key : path_ + "." + key);
  }
  return unknown;
}

}  // namespace volute
