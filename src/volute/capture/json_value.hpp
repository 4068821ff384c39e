// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <initializer_list>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/math/vec.hpp"

namespace volute {

/// A place in a JSON file that knows its path, so that errors read "FILE: cameras[3].K[1]: expected
/// three numbers". Refers to the JSON, which must outlive it.
class JsonValue {
 public:
  JsonValue(const nlohmann::json& json, std::string file) : json_(&json), file_(std::move(file)) {}

  /// "FILE: PATH".
  std::string where() const;

  /// An error here: "FILE: PATH: `message`".
  tl::unexpected<Error> fault(std::string_view message) const;

  /// A member of an object; an error when it is missing.
  [[nodiscard]] Result<JsonValue> at(std::string_view key) const;
  /// A member, or nothing. Null counts as missing.
  std::optional<JsonValue> find(std::string_view key) const;

  bool has(std::string_view key) const { return find(key).has_value(); }

  [[nodiscard]] Result<std::vector<JsonValue>> items() const;  ///< of an array
  [[nodiscard]] Result<double> number() const;                 ///< finite
  [[nodiscard]] Result<int> integer() const;                   ///< whole, within int
  [[nodiscard]] Result<std::string> text() const;
  [[nodiscard]] Result<std::vector<double>> numbers() const;
  [[nodiscard]] Result<std::vector<double>> numbers(std::size_t count) const;
  [[nodiscard]] Result<Vec3> vector() const;
  [[nodiscard]] Result<Mat3> matrix() const;  ///< three rows of three numbers
  /// Three or four rows of four numbers; the fourth is 0, 0, 0, 1 where it is missing.
  [[nodiscard]] Result<Mat4> affine() const;

  /// The members whose names are not in `known`, as "PATH.name".
  std::vector<std::string> unknownKeys(std::initializer_list<std::string_view> known) const;

  const nlohmann::json& json() const { return *json_; }

 private:
  /// Rows of numbers, exactly so many, one after the other.
  [[nodiscard]] Result<std::vector<double>> rows(std::size_t count, std::size_t columns) const;
  JsonValue child(const nlohmann::json& json, const std::string& step) const;

  const nlohmann::json* json_;
  std::string file_;
  std::string path_;
};

/// Puts what `read` makes of a member into `to`; an error when it is missing.
template <class T, class Read>
[[nodiscard]] Status readMember(const JsonValue& value, std::string_view key, T& to,
                                const Read& read) {
  VOLUTE_ASSIGN(const auto member, value.at(key));
  VOLUTE_ASSIGN(to, std::invoke(read, member));
  return {};
}

/// The same of a member that may be missing: then `to` stays as it is.
template <class T, class Read>
[[nodiscard]] Status readIfThere(const JsonValue& value, std::string_view key, T& to,
                                 const Read& read) {
  return value.has(key) ? readMember(value, key, to, read) : Status();
}

}  // namespace volute
