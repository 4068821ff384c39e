// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/report/json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

namespace volute {

Json jsonNumber(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}

Json jsonFrame(int number, FrameScale scale) {
  return scale.decimals == 0 ? Json(number) : Json(scale.frame(number));
}

std::string dumpJson(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace volute
