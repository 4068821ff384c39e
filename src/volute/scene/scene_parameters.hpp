// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/scene/parameter.hpp"
#include "volute/scene/scene_facts.hpp"
#include "volute/scene/scene_file.hpp"

namespace volute {

/// What a person may change about a scene, in the order of its file: media, lights, signs, the
/// background. `scene` is what `json` holds; `json` decides where values stand.
/// @param facts  what the media's files say; a medium without is taken for one of one frame
std::vector<Parameter> sceneParameters(const nlohmann::ordered_json& json,
                                       const SceneDescription& scene, const SceneFacts& facts);

/// Puts a value into a scene's JSON, as one of sceneParameters() describes it, and whatever must go
/// with it: smokes share their mode and C, a sign that emits light drops a C of its own, a quantity
/// takes along what it needs. kInvalidArgument for a path that none of them has.
[[nodiscard]] Status setParameter(nlohmann::ordered_json& json, const SceneDescription& scene,
                                  const SceneFacts& facts, const std::string& path,
                                  const std::vector<double>& value);

}  // namespace volute
