// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "volute/base/frame_name.hpp"

namespace volute {

/// A number for JSON: null when it is not finite.
nlohmann::ordered_json jsonNumber(double value);

/// A frame's number: whole ones without a decimal point.
nlohmann::ordered_json jsonFrame(int number, FrameScale scale);

/// One JSON object on one or more lines; text that is no UTF-8 (a file name, say) is replaced,
/// never an exception.
std::string dumpJson(const nlohmann::ordered_json& json);

}  // namespace volute
