// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <string_view>

#include "volute/base/result.hpp"

namespace volute {

/// That `json` is an object with no other members than these.
/// @param path  where it stands in the file, as "/signs/0"; empty: it is the whole file
[[nodiscard]] Status checkMembers(const nlohmann::json& json,
                                  std::span<const std::string_view> members,
                                  const std::string& file, std::string_view path = "");

}  // namespace volute
