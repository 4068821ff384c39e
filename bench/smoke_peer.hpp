// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/tetmesh/tet_mesh.hpp"

// Others that draw smoke on tetrahedra, for `volute bench smoke`. They live in a plug-in: a program
// that measures nothing does not carry them.

namespace volute::bench {

enum class PeerMapper : std::int32_t { kProjectedTetrahedra, kRayCaster, kZSweep };

/// What is drawn. Lives as long as the peer.
struct PeerScene {
  std::shared_ptr<const TetMesh> mesh;
  const std::vector<std::vector<float>>* extinction = nullptr;  ///< fields [1/m] of vertices
};

/// One picture: a pinhole upright along z, and perhaps a black rectangle in the smoke. Trivially
/// copyable: it crosses to the process that draws.
struct PeerView {
  double eye[3], target[3];
  double fov = 60;  ///< vertical [degrees]
  std::int32_t width = 0, height = 0;
  std::int32_t field = 0;
  std::int32_t hasSign = 0;
  double sign[4][3] = {};  ///< corners in order
};

/// Of one picture [s], read back included.
struct PeerTimes {
  double wall = 0, cpu = 0;
};

class SmokePeer {
 public:
  virtual ~SmokePeer() = default;

  /// White smoke before black: the opacity of each pixel, row by row from the top.
  [[nodiscard]] virtual Result<PeerTimes> draw(const PeerView& view, std::span<float> opacity) = 0;
};

struct SmokePeerPlugin {
  Result<std::unique_ptr<SmokePeer>> (*make)(PeerMapper mapper, const PeerScene& scene);
};

}  // namespace volute::bench
