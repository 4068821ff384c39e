// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "volute/cli/arguments.hpp"
#include "volute/cli/context.hpp"
#include "volute/cli/field_options.hpp"
#include "volute/film/render_request.hpp"
#include "volute/gl/gl_smoke_method.hpp"
#include "volute/scene/scene.hpp"

namespace volute::cli {

/// What an entry of a scene's media can say as well: how a file alone is read and looks.
std::vector<Option> mediumOptions(FieldUse use = FieldUse::kAll);

/// What the options given say of a file alone, as members of its entry. kInvalidArgument for
/// options that would change nothing of it; of a scene nothing else is looked at.
[[nodiscard]] Result<nlohmann::ordered_json> mediumMembers(const std::string& path,
                                                           const Arguments& arguments);

/// Where light that lamps throw into media is kept.
std::vector<Option> lightCacheOptions();
[[nodiscard]] Result<std::shared_ptr<const LightCache>> lightCache(const Arguments& arguments,
                                                                   Context& context);

/// A scene, or any other file as a scene of its own, with the options above. Errors name the file
/// or the option; one that would change nothing is refused.
/// @param measured  as OpenOptions has it; else a file alone looks as its grids suggest
[[nodiscard]] Result<Scene> openScene(const std::string& path, const Arguments& arguments,
                                      Context& context, bool measured = true);

/// How openScene() opens it; kInvalidArgument for an option of other kinds.
[[nodiscard]] Result<SceneOptions> sceneOptions(const std::string& path, const Arguments& arguments,
                                                const Context& context);

/// An error about a member of the only medium of a scene that a file stands for, as one about the
/// option.
Error aboutOptions(Error error, const std::string& path);

/// --smoke-method; kInvalidArgument where one is named and OpenGL does not draw.
[[nodiscard]] Result<GlSmokeMethod> smokeMethodOf(const Arguments& arguments, bool gl);

/// `camera` or `parts` of a request from --camera, or --eye, --target, --up and --fov or --ortho.
[[nodiscard]] Status takeCamera(const Arguments& arguments, RenderRequest& request);

}  // namespace volute::cli
