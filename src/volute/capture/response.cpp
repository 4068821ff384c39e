// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/response.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "volute/base/assert.hpp"
#include "volute/base/number_word.hpp"
#include "volute/image/srgb.hpp"

namespace volute {

Response Response::srgb() {
  Response response;
  response.kind_ = Kind::kSrgb;
  return response;
}

Response Response::gamma(double gamma) {
  VOLUTE_ASSERT(gamma > 0);
  Response response;
  response.kind_ = Kind::kGamma;
  response.gamma_ = gamma;
  return response;
}

Result<Response> Response::table(std::vector<double> linear) {
  const bool finite = std::ranges::all_of(linear, [](double v) { return std::isfinite(v); });
  if (linear.size() < 2 || !finite || !std::ranges::is_sorted(linear)) {
    return fail(ErrorCode::kInvalidArgument,
                "expected at least two finite, ascending linear values for the stored ones from 0 "
                "to 1");
  }
  Response response;
  response.kind_ = Kind::kTable;
  response.table_ = std::move(linear);
  return response;
}

Result<Response> Response::byName(std::string_view text) {
  if (text == "linear")
    return Response();
  if (text == "srgb")
    return srgb();
  constexpr std::string_view kGammaPrefix = "gamma:";
  if (text.starts_with(kGammaPrefix)) {
    double value = 0;
    if (readNumber(text.substr(kGammaPrefix.size()), value) && value >= 0.1 && value <= 10)
      return gamma(value);
  }
  return fail(ErrorCode::kInvalidArgument,
              "'{}' is no known response; expected linear, srgb, or gamma:G with G from 0.1 to 10",
              text);
}

double Response::linear(double stored) const {
  const double inside = std::clamp(stored, 0.0, 1.0);
  const double beyond = stored - inside;
  switch (kind_) {
    case Kind::kLinear:
      return stored;
    case Kind::kSrgb:
      return srgbDecode(inside) + beyond;
    case Kind::kGamma:
      return std::pow(inside, gamma_) + beyond;
    case Kind::kTable: {
      const double place = inside * static_cast<double>(table_.size() - 1);
      const auto below = std::min(static_cast<std::size_t>(place), table_.size() - 2);
      const double share = place - static_cast<double>(below);
      return (1 - share) * table_[below] + share * table_[below + 1];
    }
  }
  return stored;
}

std::string Response::name() const {
  switch (kind_) {
    case Kind::kLinear:
      return "linear";
    case Kind::kSrgb:
      return "srgb";
    case Kind::kGamma:
      return fmt::format("gamma:{}", gamma_);
    case Kind::kTable:
      return fmt::format("table of {} values", table_.size());
  }
  return "";
}

}  // namespace volute
