// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "volute/base/result.hpp"
#include "volute/math/vec.hpp"

namespace volute::cli {

/// A whole JSON file of at most 16 MiB; errors name the file and the line.
[[nodiscard]] Result<nlohmann::json> readJson(const std::string& file);

/// Finite numbers at a place of a file; the errors of these are "FILE: PATH: expected ...".
[[nodiscard]] Result<double> jsonToNumber(const nlohmann::json& json, const std::string& file,
                                          const std::string& path);
[[nodiscard]] Result<Vec3> jsonToVector(const nlohmann::json& json, const std::string& file,
                                        const std::string& path);

}  // namespace volute::cli
