// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "volute/cli/arguments.hpp"
#include "volute/cli/context.hpp"
#include "volute/cli/option.hpp"
#include "volute/scene/scene.hpp"
#include "volute/scene/scene_sight.hpp"

namespace volute::cli {

/// What a scene's entry of the medium can say as well: how a file alone is read and looks.
std::vector<Option> volumeOptions();
std::vector<Option> smokeOptions();

/// Where light that lamps throw into media is kept.
std::vector<Option> lightCacheOptions();
[[nodiscard]] Result<std::optional<LightCache>> lightCache(const Arguments& arguments,
                                                           Context& context);

/// A scene, or any other file as a scene of its own, with the options above. Errors name the file
/// or the option; one that would change nothing is refused.
[[nodiscard]] Result<Scene> openScene(const std::string& path, const Arguments& arguments,
                                      Context& context);

/// The same as sight lines ask for it.
[[nodiscard]] Result<std::unique_ptr<SightField>> openSight(const std::string& path,
                                                            const Arguments& arguments,
                                                            Context& context);

/// Of the options above those that change what sight lines meet.
std::vector<Option> sightOptions();

/// The entry of a scene that a file alone stands for, with what the options given say; its names
/// are found from the file's folder. kInvalidArgument for an option of other kinds.
[[nodiscard]] Result<nlohmann::ordered_json> entryOf(const std::string& path,
                                                     const Arguments& arguments);

/// The members that the options given stand for, for an entry of a kind; kInvalidArgument for an
/// option of other kinds.
[[nodiscard]] Result<nlohmann::ordered_json> membersOf(const Arguments& arguments,
                                                       const MediumKind& kind,
                                                       const std::string& path);

/// An error about a member of the only medium of a scene that a file stands for, as one about the
/// option.
Error aboutOptions(Error error, const std::string& path);

}  // namespace volute::cli
