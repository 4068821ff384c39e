// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "volute/base/result.hpp"
#include "volute/io/json_file.hpp"
#include "volute/math/vec.hpp"

namespace volute {

/// Finite numbers at a place of a file; the errors of these are "FILE: PATH: expected ...".
[[nodiscard]] Result<double> jsonToNumber(const nlohmann::json& json, const std::string& file,
                                          const std::string& path);
[[nodiscard]] Result<Vec3> jsonToVector(const nlohmann::json& json, const std::string& file,
                                        const std::string& path);

/// A name found from the folder of the file that says it.
std::string besides(const std::string& file, const std::string& name);

}  // namespace volute
