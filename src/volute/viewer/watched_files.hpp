// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "volute/scene/scene_file.hpp"

namespace volute {

/// The files that a name of a scene stands for: itself; the files of a .pvd collection; of a
/// pattern those that are there, and the one that would follow them.
std::vector<std::filesystem::path> filesOf(const std::string& name);

/// All files that a scene shows, as it was read from `json` of the file `file`: media, geometry,
/// billboards, tops of fog, signs' pictures. Those that are not there too.
std::vector<std::filesystem::path> filesOf(const SceneDescription& scene,
                                           const nlohmann::ordered_json& json,
                                           const std::string& file);

}  // namespace volute
