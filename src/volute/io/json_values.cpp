// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/json_values.hpp"

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

namespace volute {

std::string besides(const std::string& file, const std::string& name) {
  return (std::filesystem::path(file).parent_path() / name).string();
}

Result<double> jsonToNumber(const nlohmann::json& json, const std::string& file,
                            const std::string& path) {
  if (json.is_number() && std::isfinite(json.get<double>()))
    return json.get<double>();
  return fail(ErrorCode::kInvalidData, "{}: {}: expected a number", file, path);
}

Result<Vec3> jsonToVector(const nlohmann::json& json, const std::string& file,
                          const std::string& path) {
  if (!json.is_array() || json.size() != 3) {
    return fail(ErrorCode::kInvalidData, "{}: {}: expected three numbers", file, path);
  }
  Vec3 vector;
  for (int axis = 0; axis < 3; ++axis) {
    VOLUTE_ASSIGN(vector[axis], jsonToNumber(json[axis], file, fmt::format("{}[{}]", path, axis)));
  }
  return vector;
}

}  // namespace volute
