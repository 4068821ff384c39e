// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "volute/cli/arguments.hpp"
#include "volute/cli/option.hpp"
#include "volute/cli/volume_layer.hpp"
#include "volute/optics/extinction.hpp"
#include "volute/optics/visibility.hpp"
#include "volute/tetmesh/tet_field.hpp"

namespace volute::cli {

/// A medium of kind "smoke" in a scene, or a case on the command line.
struct SmokeDescription {
  std::string where;         ///< begins errors about its members: "scene.json: /media/0"
  std::string file;          ///< the case
  std::string field;         ///< empty: the only scalar
  std::string densityField;  ///< of mass-fraction
  SmokeModel model;
  PictureLaw law;
  Rgb albedo = Rgb::Constant(0.3);  ///< share of what is taken from light that is scattered
  Negatives negatives = Negatives::kRefuse;
  Clock clock;
  std::optional<Rgb> walls;  ///< what the mesh's boundary reflects; nothing: it is not shown
};

/// A smoke object of a scene. Errors name the file and the path inside it, keys that are unknown
/// included.
[[nodiscard]] Result<SmokeDescription> parseSmoke(const nlohmann::json& json,
                                                  const std::string& file, const std::string& path);

/// The options that say the same on a command line.
std::vector<Option> smokeOptions();

/// A case on a command line, with smokeOptions().
[[nodiscard]] Result<SmokeDescription> smokeOf(const std::string& file, const Arguments& arguments);

/// By its name, and of a .pvd by that of its first file: smoke on a mesh, no volume of voxels.
bool isSmokeCase(const std::string& path);

}  // namespace volute::cli
