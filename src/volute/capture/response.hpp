// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "volute/base/result.hpp"

namespace volute {

/// How a camera's stored values, 0 to 1, follow from the light: the curve that makes them linear.
class Response {
 public:
  enum class Kind { kLinear, kSrgb, kGamma, kTable };

  /// Linear.
  Response() = default;

  static Response srgb();

  /// stored = linear^(1 / gamma), as "gamma 2.2" is understood. gamma > 0.
  static Response gamma(double gamma);

  /// Linear values at evenly spaced stored ones from 0 to 1, interpolated; at least two, finite and
  /// ascending, else kInvalidArgument in a sentence that wants a subject.
  [[nodiscard]] static Result<Response> table(std::vector<double> linear);

  /// "linear", "srgb" or "gamma:2.2".
  [[nodiscard]] static Result<Response> byName(std::string_view text);

  /// The light of a stored value, 1 = white. Below 0 and above 1 the curves go on as lines through
  /// (0, 0) and (1, 1); a table's end values are held.
  double linear(double stored) const;

  /// As byName takes it; "table of N values" for a table.
  std::string name() const;

  Kind kind() const { return kind_; }

  /// The linear values of a table; empty for other kinds.
  const std::vector<double>& table() const { return table_; }

  bool operator==(const Response&) const = default;

 private:
  Kind kind_ = Kind::kLinear;
  double gamma_ = 1;
  std::vector<double> table_;
};

}  // namespace volute
