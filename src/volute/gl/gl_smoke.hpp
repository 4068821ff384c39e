// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <vector>

#include "volute/tetmesh/tet_locator.hpp"

namespace volute {

class GlPart;

/// How a smoke is drawn that is alone in its picture. One among other media is marched with them,
/// and so is any under a camera with a lens.
enum class GlSmokeMethod {
  kAuto,     ///< black smoke and optical depths by the splat, light by the march
  kMarch,    ///< from face to face, in a compute shader
  kSplat,    ///< DepthSplat: transmittance alone; light is marched
  kProject,  ///< TetProjector, for drivers whose compute shaders are slow
};

/// TetMarcher's twin: one instant of smoke on a mesh.
struct GlSmoke {
  std::shared_ptr<const TetLocator> locator;
  std::vector<float> extinction{};  ///< [1/m], one for each vertex, finite and >= 0
  std::vector<float> source{};  ///< radiance of infinitely thick smoke, RGB a vertex; empty: black
  GlSmokeMethod method = GlSmokeMethod::kAuto;
};

std::shared_ptr<const GlPart> glPart(GlSmoke smoke);

}  // namespace volute
