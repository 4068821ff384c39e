// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bench/benchmark.hpp"
#include "volute/base/result.hpp"
#include "volute/camera/camera.hpp"
#include "volute/tetmesh/tet_locator.hpp"

// What `volute bench smoke` draws, and `bench gl` of it: cases, eyes, the four modes of a moving
// picture.

namespace volute::bench {

/// Smoke at a few times on one mesh.
struct SmokeCase {
  std::string name;
  std::shared_ptr<const TetMesh> mesh;
  std::vector<std::vector<float>> extinction;  ///< [1/m]
};

/// A hall of cells that are `cell` metres wide, which a plume fills.
SmokeCase madeSmokeCase(std::string name, double cell);

/// The last snapshots of a case that have the same mesh as the last; of a single one, shares of it.
/// Its field is taken as g/m3 of soot.
[[nodiscard]] Result<SmokeCase> readSmokeCase(const BenchInput& input);

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

struct SmokeEye {
  std::string name;
  Vec3 eye, target;
  double fov;  ///< vertical [degrees]
};

/// From outside, and from a tet inside, by a building's place in its bounds.
std::vector<SmokeEye> smokeEyes(const TetLocator& locator);

/// On a vertex, an edge and a face of the tet that is nearest to another eye.
std::vector<SmokeEye> eyesOnMesh(const TetMesh& mesh, const SmokeEye& near);

/// Staubli et al. 2005, table 3. A "fixed" eye turns, as there.
struct SmokeMode {
  const char* name;
  bool newSmoke, moving;
};

inline constexpr SmokeMode kSmokeModes[] = {{"steady smoke, fixed eye", false, false},
                                            {"new smoke, fixed eye", true, false},
                                            {"steady smoke, moving eye", false, true},
                                            {"new smoke, moving eye", true, true}};

/// A row of pictures.
struct SmokeSetting {
  const SmokeCase& smoke;
  SmokeEye eye;
  int width = 0, height = 0;
  bool sign = false;

  std::size_t pixels() const { return static_cast<std::size_t>(width) * height; }

  std::string name() const;

  /// The view at step i: turned a little, or moved a little aside.
  SmokeView view(int field, int turn, int move) const;
};

}  // namespace volute::bench
