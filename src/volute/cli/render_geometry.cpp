// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/render_job.hpp"
#include "volute/render/scaled_medium.hpp"
#include "volute/render/surfaces.hpp"
#include "volute/tetmesh/tet_medium.hpp"

// The part of a RenderJob that geometry and billboards have.

namespace volute::cli {

Result<SurfaceView> RenderJob::viewOfGeometry(std::span<const AnyMedium> others,
                                              std::span<const SmokeState> states,
                                              Progress& progress) {
  const Stopwatch watch(totals.surfaces);
  if (gl) {
    VOLUTE_ASSIGN(auto seen, gl->surfaces(camera, glSubject, geometry, lights, progress));
    totals.surfacePixels += seen.surfacePixels;
    return SurfaceView{std::move(seen.depth), std::move(seen.color)};
  }
  // Lamps' light is always attenuated physically, whatever the picture's law.
  std::vector<AnyMedium> media;
  for (const AnyMedium& other : others) {
    media.push_back(law.factor() == 1 ? other : AnyMedium(ScaledMedium(other, 1 / law.factor())));
  }
  for (const SmokeState& smoke : states)
    media.emplace_back(TetMedium(smoke.locator, smoke.extinction));
  const SurfaceScene scene{geometry, lights.lamps, lights.ambient, media};
  VOLUTE_ASSIGN(auto picture, renderSurfaces(camera, scene, Rgb::Zero(), progress));
  totals.surfacePixels += picture.surfacePixels;
  totals.shadowRays += picture.shadowRays;
  return SurfaceView{std::move(picture.depth), std::move(picture.color)};
}

Status RenderJob::placeBuildings(double time) {
  std::vector<std::uint64_t> wanted;
  for (const FdsLayer& fds : fdsCases) wanted.push_back(fds.surfacesAt(time));
  if (wanted == buildings)
    return {};
  if (!fixedGeometry)
    fixedGeometry = geometry;
  const auto triangles = fixedGeometry->triangles();
  const auto materials = fixedGeometry->materials();
  TriangleMesh all{{triangles.begin(), triangles.end()}, {materials.begin(), materials.end()}};
  for (const FdsLayer& fds : fdsCases) VOLUTE_TRY(fds.addSurfaces(time, all));
  VOLUTE_ASSIGN(geometry, TriangleScene::build(std::move(all.triangles), std::move(all.materials)));
  buildings = std::move(wanted);
  return {};
}

Status RenderJob::addBillboards(double time, std::vector<AnyMedium>& media, Progress& progress) {
  for (BillboardLayer& board : billboards) {
    VOLUTE_ASSIGN(const auto volume,
                  board.volume.mediumAt(board.volume.positionAt(time), law.factor()));
    VOLUTE_ASSIGN(auto drawn, Billboard::draw(AnyMedium(volume), camera, board.options, progress));
    media.emplace_back(std::move(drawn));
  }
  return {};
}

}  // namespace volute::cli
