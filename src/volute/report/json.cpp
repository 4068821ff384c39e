// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/report/json.hpp"

#include <cmath>

namespace volute {

Json jsonNumber(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}

std::string dumpJson(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace volute
