// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace volute::cli {

/// Results of a command: the same entries as lines of text for people and as one JSON object for
/// programs.
class Report {
 public:
  /// `text` is what people read; an entry with an empty text is for programs alone.
  Report& add(std::string_view key, nlohmann::ordered_json value, std::string text);

  /// Numbers and words that read the same in both. Infinities and NaN are null in JSON.
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

/// A number for JSON: null when it is not finite.
nlohmann::ordered_json jsonNumber(double value);

/// One JSON object on one or more lines; text that is no UTF-8 (a file name, say) is replaced,
/// never an exception.
std::string dumpJson(const nlohmann::ordered_json& json);

/// "123 bytes", "1.4 MB" (powers of 1000).
std::string bytesText(std::uint64_t bytes);

}  // namespace volute::cli
