// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <optional>

#include "volute/media/field.hpp"

namespace volute {

/// How a person looks at a scene in the viewer: the "view" of a scene file, which pictures do not
/// depend on.
struct SceneLook {
  double stops = 0;  ///< light is multiplied by the exposure times 2^stops
  /// [1 / radiance]; nothing: one that suits the first picture.
  std::optional<double> exposure{};
  int colors = 0;                ///< grey, viridis, inferno: of what has one channel
  int tone = 0;                  ///< automatic, none, filmic, shoulder, ACES, OpenColorIO's
  int quality = 0;               ///< automatic, full, half, quarter
  int renderer = 0;              ///< automatic, OpenGL, CPU
  bool surfaces = true;          ///< opaque things are shown
  bool walks = false;            ///< else orbits
  double speed = 1;              ///< of the timeline
  std::optional<double> time{};  ///< [s]
  std::optional<std::array<double, 2>> loop{};  ///< [s], ascending; nothing: all frames

  bool operator==(const SceneLook&) const = default;
};

const FieldTable& lookFields();

/// The look as "view" of a scene file.
nlohmann::ordered_json toJson(const SceneLook& look);

}  // namespace volute
