// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "volute/report/json.hpp"

namespace volute::cli {

/// Results of a command: the same entries as lines of text for people and as one JSON object for
/// programs.
class Report {
 public:
  /// `text` is what people read; an entry with an empty text is for programs alone.
  Report& add(std::string_view key, Json value, std::string text);

  /// Numbers and words that read the same in both. Infinities and NaN are null in JSON.
  Report& add(std::string_view key, double value);
  Report& add(std::string_view key, std::string_view value);

  const Json& json() const { return json_; }

  /// Lines "key  text", aligned; underscores of keys become spaces.
  std::string text() const;

 private:
  struct Line {
    std::string label;
    std::string text;
  };

  Json json_ = Json::object();
  std::vector<Line> lines_;
};

/// "123 bytes", "1.4 MB" (powers of 1000).
std::string bytesText(std::uint64_t bytes);

}  // namespace volute::cli
