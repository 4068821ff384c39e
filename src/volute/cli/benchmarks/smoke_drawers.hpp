// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/tetmesh/tet_locator.hpp"
#include "volute/tetmesh/tet_reference.hpp"

// What `volute bench smoke` compares.

namespace volute::cli {

/// Smoke at a few instants on one mesh.
struct SmokeCase {
  std::string name;
  std::shared_ptr<const TetMesh> mesh;
  std::vector<std::vector<float>> extinction;  ///< [1/m]
};

struct SmokeView {
  Vec3 eye, target;
  double fov = 60;
  int width = 0, height = 0;
  int field = 0;           ///< of the case's
  std::vector<Vec3> sign;  ///< a black rectangle's corners in order, or none

  Camera camera() const {
    return Camera::pinhole({eye, target, Vec3::UnitZ()}, fov, width, height);
  }
};

/// Where the sign is, for each pixel; empty without one.
std::vector<float> opaqueDepth(const SmokeView& view);

/// Of one frame [s], with what new smoke takes.
struct DrawTimes {
  double wall = 0, processor = 0;
};

class SmokeDrawer {
 public:
  virtual ~SmokeDrawer() = default;
  virtual std::string_view name() const = 0;

  /// The opacity of each pixel.
  [[nodiscard]] virtual Result<DrawTimes> draw(const SmokeView& view, std::span<float> opacity) = 0;
};

/// VTK's projected tetrahedra first, then Volute's, then slower ones of VTK. Hold the case alive.
std::vector<std::unique_ptr<SmokeDrawer>> smokeDrawers(
    const SmokeCase& smoke, const std::shared_ptr<const TetLocator>& locator, bool quick);

}  // namespace volute::cli
