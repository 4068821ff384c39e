// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/json_file.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "volute/base/input_file.hpp"

namespace volute::cli {

Result<nlohmann::json> readJson(const std::string& file) {
  constexpr std::uint64_t kMostBytes = 16 << 20;
  VOLUTE_ASSIGN(const auto input, InputFile::open(file));
  if (input.size() > kMostBytes) {
    return fail(ErrorCode::kTooLarge,
                "{}: {} bytes are too many for a JSON file of ours; expected at most {}", file,
                input.size(), kMostBytes);
  }
  std::string text(input.size(), '\0');
  VOLUTE_TRY(input.read(0, std::as_writable_bytes(std::span(text))));
  try {
    return nlohmann::json::parse(text);
  } catch (const nlohmann::json::parse_error& error) {
    const std::size_t end = std::min(error.byte, text.size());
    const auto line =
        1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(end), '\n');
    return fail(ErrorCode::kInvalidData, "{}: line {} is no valid JSON (byte {})", file, line,
                error.byte);
  } catch (const nlohmann::json::exception& error) {  // a number beyond double
    return fail(ErrorCode::kInvalidData, "{}: {}", file, error.what());
  }
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

}  // namespace volute::cli
