// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "volute/camera/camera.hpp"
#include "volute/fog/polar_table.hpp"
#include "volute/lighting/lit_medium.hpp"

namespace volute {

class GlPart;

/// FogMedium's twin.
struct GlFog {
  FogMedium fog;
  double factor = 1;  ///< of its extinction, as ScaledMedium has it
  /// Alone in its picture it is drawn by a polar table where this gives options for the camera and
  /// a table serves (PolarTable::make). Empty: it is walked.
  std::function<std::optional<PolarOptions>(const Camera& camera)> polar{};
};

/// litFog()'s twin. Surfaces that shadow it are the scene's `shade`.
struct GlLitFog {
  FogMedium fog;
  LitMedium lit;
  double factor = 1;
};

std::shared_ptr<const GlPart> glPart(GlFog fog);
std::shared_ptr<const GlPart> glPart(GlLitFog fog);

}  // namespace volute
