// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace volute {

/// A file that a scene at `scene` calls `name`, as a scene at `target` says it: from its own folder
/// where it is below that, else absolute.
std::string nameFrom(const std::string& scene, const std::string& target, const std::string& name);

/// Calls `change` for each name of a file in the JSON of a scene at `from`.
void eachName(nlohmann::ordered_json& scene, const std::string& from,
              const std::function<void(std::string& name)>& change);

/// All names in the JSON of a scene at `from`, as one at `to` says them.
void moveAllNames(nlohmann::ordered_json& scene, const std::string& from, const std::string& to);

}  // namespace volute
