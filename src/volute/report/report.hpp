// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volute/math/box.hpp"
#include "volute/report/json.hpp"

namespace volute {

/// Results: the same entries as lines of text for people and as one JSON object for programs.
class Report {
 public:
  /// `text` is what people read; an entry with an empty text is for programs alone.
  Report& add(std::string_view key, nlohmann::ordered_json value, std::string text);

  /// Numbers and texts that read the same in both. Infinities and NaN are null in JSON.
  Report& add(std::string_view key, double value);
  Report& add(std::string_view key, std::string_view value);

  const nlohmann::ordered_json& json() const { return json_; }

  /// Lines "key  text", aligned; underscores of keys become spaces.
  std::string text() const;

 private:
  struct Line {
    std::string label;
    std::string text;
  };

  nlohmann::ordered_json json_ = nlohmann::ordered_json::object();
  std::vector<Line> lines_;
};

/// "123 bytes", "1.4 MB" (powers of 1000).
std::string bytesText(std::uint64_t bytes);

/// "1, 2.5, -3", six digits each.
std::string vectorText(const Vec3& v);

/// "1, 2, 3  to  4, 5, 6 m", the corners of a box [m].
std::string boxText(const Box3& box);

/// [1, 2, 3].
nlohmann::ordered_json vectorJson(const Vec3& v);

/// [[1, 2, 3], [4, 5, 6]], the corners of a box [m].
nlohmann::ordered_json boxJson(const Box3& box);

/// Format, contents and figures of a file, for `info`.
struct FileDescription {
  Report report;
  bool damaged = false;  ///< something of it is missing or cannot be used; the report says what
};

/// The range of many values, counted as they are read.
struct ValueRange {
  double minimum = std::numeric_limits<double>::infinity();  ///< of finite values
  double maximum = -std::numeric_limits<double>::infinity();
  std::uint64_t notFinite = 0;
  std::uint64_t zeros = 0;
  std::uint64_t count = 0;  ///< of all values

  void add(std::span<const float> values);

  /// As "minimum", "maximum", "zero_share" and "not_finite".
  void addTo(Report& report) const;
};

}  // namespace volute
