// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <optional>

#include "volute/fds/fds_field.hpp"
#include "volute/geometry/triangle_scene.hpp"
#include "volute/lighting/lit_medium.hpp"

namespace volute {

class GlPart;

/// FdsField's twin, or that of one of an FdsFlame's lights.
struct GlFds {
  FdsField field;
  double scale = 1;           ///< of the extinction and of what it scatters
  std::optional<Rgb> glow{};  ///< of fire: radiance per metre of a unit; it hides nothing
  std::shared_ptr<const LitMedium> lit{};  ///< the smoke in lamps' light; null: none shines
  TriangleScene surfaces{};                ///< which shadow it
};

std::shared_ptr<const GlPart> glPart(GlFds fds);

}  // namespace volute
