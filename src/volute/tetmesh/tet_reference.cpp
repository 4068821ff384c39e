// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/tet_reference.hpp"

#include "volute/base/parallel.hpp"
#include "volute/medium/integrate.hpp"

namespace volute {
namespace {

/// Rows as batches, on all threads.
template <class Row>
void forEachRow(const Camera& camera, OpaqueDepth opaque, const Row& row) {
  parallelFor(static_cast<std::size_t>(camera.height()), [&](std::size_t y) {
    std::vector<Segment> rays;
    for (int x = 0; x < camera.width(); ++x)
      rays.push_back(pixelRay(camera, x, static_cast<int>(y), opaque));
    row(y * camera.width(), rays);
  });
}

}  // namespace

void referenceDepth(const TetMedium& medium, const Camera& camera, OpaqueDepth opaque,
                    std::span<double> depth) {
  forEachRow(camera, opaque, [&](std::size_t first, std::span<const Segment> rays) {
    medium.opticalDepth(rays, depth.subspan(first, rays.size()));
  });
}

void referenceColor(const TetMedium& medium, const Camera& camera, OpaqueDepth opaque,
                    std::span<double> rgbt) {
  forEachRow(camera, opaque, [&](std::size_t first, std::span<const Segment> rays) {
    std::vector<Radiance> light(rays.size());
    radianceByPieces(medium, rays, light);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      double* out = &rgbt[4 * (first + i)];
      for (int c = 0; c < 3; ++c) out[c] = light[i].emitted[c];
      out[3] = light[i].transmittance;
    }
  });
}

}  // namespace volute
