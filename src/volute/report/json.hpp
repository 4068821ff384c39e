// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json.hpp>

#include "volute/report/json_text.hpp"

namespace volute {

using Json = nlohmann::ordered_json;

}  // namespace volute
