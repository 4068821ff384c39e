// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <string>

#include "volute/media/clock.hpp"
#include "volute/media/field.hpp"
#include "volute/optics/extinction.hpp"
#include "volute/optics/visibility.hpp"
#include "volute/tetmesh/tet_field.hpp"

namespace volute {

/// A medium of kind "smoke" in a scene that is on a mesh, or a case on the command line.
struct SmokeDescription {
  FieldOrigin origin;        ///< of its entry, for errors about its members
  std::string file;          ///< the case
  std::string field;         ///< empty: the only scalar
  std::string densityField;  ///< of mass-fraction
  std::string airFields;     ///< of the air's temperature and gases, as parseMeshAir() takes them
  SmokeModel model;
  PictureLaw law;
  bool givesC = false;              ///< `law.c` was said, not assumed
  Rgb albedo = Rgb::Constant(0.3);  ///< share of what is taken from light that is scattered
  Negatives negatives = Negatives::kRefuse;
  Clock clock;
  std::optional<Rgb> walls;  ///< what the mesh's boundary reflects; nothing: it is not shown
};

/// Smoke on a mesh.
const FieldTable& smokeFields();

/// A smoke object of a scene, or the options that say the same, about a mesh. What
/// would change nothing, since the quantity leaves nothing to say to it, is an error.
[[nodiscard]] Result<SmokeDescription> parseSmoke(const nlohmann::json& json,
                                                  const FieldOrigin& origin);

/// By its name, and of a .pvd by that of its first file: smoke on a mesh, no volume of voxels.
bool isSmokeCase(const std::string& path);

}  // namespace volute
