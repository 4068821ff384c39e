// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <vector>

#include "volute/gl/gl_smoke_method.hpp"
#include "volute/tetmesh/tet_locator.hpp"

namespace volute {

class GlPart;

/// TetMarcher's twin: one snapshot of smoke on a mesh.
struct GlSmoke {
  std::shared_ptr<const TetLocator> locator;
  std::vector<float> extinction{};  ///< [1/m], one for each vertex, finite and >= 0
  std::vector<float> source{};  ///< radiance of infinitely thick smoke, RGB a vertex; empty: black
  GlSmokeMethod method = GlSmokeMethod::kAuto;
};

std::shared_ptr<const GlPart> glPart(GlSmoke smoke);

}  // namespace volute
