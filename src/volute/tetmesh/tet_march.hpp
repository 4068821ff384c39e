// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "volute/tetmesh/screen.hpp"

// The inner loops of TetMarcher.

namespace volute {

/// Where a ray enters the mesh.
struct MarchEntry {
  std::int32_t pixel = 0;     ///< within the batch
  std::int32_t halfFace = 0;  ///< 4 * tet + the vertex across
  float z = 0;                ///< depth; entries of one pixel go by it
};

/// One pixel's ray.
struct MarchRay {
  float px = 0, py = 0;  ///< pixels from the picture's centre
  float scale = 1;       ///< metres along the ray for each metre of depth
  float zEnd = 0;        ///< depth where it ends
  std::int32_t entryBegin = 0, entryEnd = 0;
};

/// What comes out of a ray.
struct MarchResult {
  float depth = 0;
  float rgb[3] = {};
  bool doubtful = false;  ///< the ray met an edge, or rounding left it no way out of a tet
};

/// The mesh as the march sees it.
struct MarchMesh {
  const ScreenVertex* vertices = nullptr;
  const ScreenRest* rests = nullptr;       ///< of the vertices
  const std::int32_t* tets = nullptr;      ///< four vertices each
  const std::int32_t* opposite = nullptr;  ///< of each half-face, or -1
  bool orthographic = false;
  bool lit = false;
  /// The field at the eye; for rays that begin in the eye's tet (entries with z = 0 that are the
  /// tet's face behind them).
  bool eyeInside = false;
  float eyeTau = 0, eyeRgb[3] = {};
};

/// A triangle to be found in a row of pixels.
struct EntryFace {
  std::int32_t vertices[3];
  std::int32_t halfFace = 0;
  bool positive = true;  ///< the sign of the edges' functions where rays enter
  PixelBox box;
};

/// Adds an entry for each pixel of the box that the ray enters through the face, pixels numbered
/// (y - y0) * width + x - x0; sets `doubtful` for those whose ray meets its border.
void rasterEntries(const ScreenView& view, const ScreenVertex* vertices, const ScreenRest* rests,
                   const EntryFace& face, const PixelBox& tile, std::vector<MarchEntry>& entries,
                   std::span<char> doubtful);

/// Takes all rays through the mesh.
std::uint64_t marchRays(const MarchMesh& mesh, std::span<const MarchRay> rays,
                        std::span<const MarchEntry> entries, std::span<MarchResult> results);

/// segmentWeights in float, as the march uses it: errors below 1e-6. For tests.
void marchWeights(std::span<const float> d0, std::span<const float> d1, std::span<float> w0,
                  std::span<float> w1);

}  // namespace volute
