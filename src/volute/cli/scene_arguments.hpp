// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "volute/cli/arguments.hpp"
#include "volute/cli/context.hpp"
#include "volute/cli/field_options.hpp"
#include "volute/media/camera_file.hpp"
#include "volute/scene/scene.hpp"
#include "volute/scene/scene_sight.hpp"

namespace volute::cli {

/// What an entry of a scene's media can say as well: how a file alone is read and looks.
std::vector<Option> mediumOptions(FieldUse use = FieldUse::kAll);

/// What the options given say of a file alone, as members of its entry. kInvalidArgument for
/// options that would change nothing of it; of a scene nothing else is looked at.
[[nodiscard]] Result<nlohmann::ordered_json> mediumMembers(const std::string& path,
                                                           const Arguments& arguments);

/// Where light that lamps throw into media is kept.
std::vector<Option> lightCacheOptions();
[[nodiscard]] Result<std::optional<LightCache>> lightCache(const Arguments& arguments,
                                                           Context& context);

/// A scene, or any other file as a scene of its own, with the options above. Errors name the file
/// or the option; one that would change nothing is refused.
/// @param measured  as OpenOptions has it; else a file alone looks as its grids suggest
[[nodiscard]] Result<Scene> openScene(const std::string& path, const Arguments& arguments,
                                      Context& context, bool measured = true);

/// The same as sight lines ask for it.
[[nodiscard]] Result<std::unique_ptr<SightField>> openSight(const std::string& path,
                                                            const Arguments& arguments,
                                                            Context& context);

/// The entry of a scene that a file alone stands for, with what the options given say; its names
/// are found from the file's folder. kInvalidArgument for an option of other kinds.
[[nodiscard]] Result<nlohmann::ordered_json> entryOf(const std::string& path,
                                                     const Arguments& arguments);

/// An error about a member of the only medium of a scene that a file stands for, as one about the
/// option.
Error aboutOptions(Error error, const std::string& path);

/// From --camera or --eye, --target, --up and --fov or --ortho; nothing when none of them is given.
[[nodiscard]] Result<std::optional<CameraDescription>> cameraOf(const Arguments& arguments);

}  // namespace volute::cli
