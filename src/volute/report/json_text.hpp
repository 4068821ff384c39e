// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace volute {

/// A number for JSON: null when it is not finite.
nlohmann::ordered_json jsonNumber(double value);

/// One JSON object on one or more lines; text that is no UTF-8 (a file name, say) is replaced,
/// never an exception.
std::string dumpJson(const nlohmann::ordered_json& json);

}  // namespace volute
