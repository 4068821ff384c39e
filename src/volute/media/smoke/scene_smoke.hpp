// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "volute/optics/extinction.hpp"
#include "volute/optics/visibility.hpp"
#include "volute/media/clock.hpp"
#include "volute/media/smoke/fds_look.hpp"
#include "volute/tetmesh/tet_field.hpp"

namespace volute {

/// A medium of kind "smoke" in a scene, or a case on the command line.
struct SmokeDescription {
  std::string where;         ///< begins errors about its members: "scene.json: /media/0"
  std::string file;          ///< the case
  std::string field;         ///< empty: the only scalar
  std::string densityField;  ///< of mass-fraction
  SmokeModel model;
  PictureLaw law;
  bool givesC = false;              ///< `law.c` was said, not assumed
  Rgb albedo = Rgb::Constant(0.3);  ///< share of what is taken from light that is scattered
  Negatives negatives = Negatives::kRefuse;
  Clock clock;
  FdsLook fds;               ///< of FDS cases
  std::optional<Rgb> walls;  ///< what the mesh's boundary reflects; nothing: it is not shown
};

/// A smoke object of a scene. Errors name the file and the path inside it, keys that are unknown
/// included.
[[nodiscard]] Result<SmokeDescription> parseSmoke(const nlohmann::json& json,
                                                  const std::string& file, const std::string& path);

/// What scenes and command lines both say by name; empty texts say nothing.
struct SmokeWords {
  std::string quantity, unit, material, burning, mode, c;
  bool massExtinction = false;  ///< it was said; the model holds it
};

/// An objection, and the member of a scene that it is about; an option has `-` for `_`.
struct SmokeObjection {
  const char* about;
  std::string message;
};

/// Sets what the words say, and checks the whole: what is missing, and what the quantity leaves
/// nothing to say to, which would change no picture.
[[nodiscard]] tl::expected<void, SmokeObjection> takeWords(SmokeDescription& smoke,
                                                           const SmokeWords& words);

/// By its name, and of a .pvd by that of its first file: smoke on a mesh, no volume of voxels.
bool isSmokeCase(const std::string& path);

}  // namespace volute
