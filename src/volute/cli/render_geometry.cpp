// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// The part of a RenderJob that geometry and billboards have.
#include "volute/cli/render_job.hpp"

namespace volute::cli {

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

Result<MediumForCamera> RenderJob::mediumOf(BillboardLayer& board, double time) const {
  VOLUTE_ASSIGN(const auto volume,
                board.volume.mediumAt(board.volume.positionAt(time), law.factor()));
  return [medium = AnyMedium(volume),
          options = board.options](const Camera& eye) -> Result<AnyMedium> {
    Progress quiet;
    VOLUTE_ASSIGN(auto drawn, Billboard::draw(medium, eye, options, quiet));
    return AnyMedium(std::move(drawn));
  };
}

}  // namespace volute::cli
