// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/json_members.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "volute/base/printable.hpp"
#include "volute/base/suggest.hpp"

namespace volute {

Status checkMembers(const nlohmann::json& json, std::span<const std::string_view> members,
                    const std::string& file, std::string_view path) {
  if (!json.is_object()) {
    return fail(ErrorCode::kInvalidData, "{}: {}: expected an object", file,
                path.empty() ? "/" : path);
  }
  for (const auto& [key, value] : json.items()) {
    if (std::ranges::find(members, key) != members.end())
      continue;
    const auto near = nearest(key, members);
    return fail(ErrorCode::kInvalidData, "{}: {}/{}: this name is unknown; {}", file, path,
                printable(key),
                near.empty() ? fmt::format("expected {}", fmt::join(members, ", "))
                             : fmt::format("did you mean '{}'?", near));
  }
  return {};
}

}  // namespace volute
