// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/smoke/smoke_contour.hpp"

#include "volute/base/assert.hpp"
#include "volute/tetmesh/tet_contour.hpp"

namespace volute {
namespace {

ContourSurface contourOf(const Contour& contour, const SmokeState& smoke) {
  const TetMesh& mesh = smoke.locator->mesh();
  if (contour.kind == Contour::Kind::kSurface)
    return contourSurface(mesh, smoke.extinction, contour.c / contour.visibility);
  return contourSlice(mesh, Vec3::Unit(contour.axis), contour.place, smoke.extinction);
}

/// The boundary of the mesh, where it faces the camera with its inner side.
void addWalls(const Camera& camera, const TetMesh& mesh, std::vector<Triangle>& walls) {
  for (const std::int32_t f : mesh.boundary()) {
    const TetFace& face = mesh.faces()[f];
    Triangle wall;
    for (int k = 0; k < 3; ++k) wall.corners[k] = mesh.vertices()[face.vertices[k]];
    const Vec3& inner = mesh.vertices()[mesh.tets()[face.first / 4][face.first % 4]];
    const Vec3 toEye =
        camera.isOrthographic() ? Vec3(-camera.forward()) : Vec3(camera.eye() - wall.corners[0]);
    if ((wall.normal().dot(toEye) > 0) == (wall.normal().dot(inner - wall.corners[0]) > 0))
      walls.push_back(wall);
  }
}

}  // namespace

void contourPieces(const Contour& contour, const Camera& camera, const SmokeState& smoke,
                   ContourPieces& pieces) {
  const bool slice = contour.kind == Contour::Kind::kSlice;
  const bool concentration = slice && contour.shows == Contour::Shows::kConcentration;
  const ContourSurface found = contourOf(contour, smoke);
  VOLUTE_ASSERT(!concentration || smoke.extinctionOfUnit > 0);
  const double unit = concentration ? smoke.extinctionOfUnit : 1;
  for (const auto& corners : found.triangles) {
    Triangle& triangle = pieces.triangles.emplace_back();
    std::array<float, 3>& values = pieces.values.emplace_back();
    for (int k = 0; k < 3; ++k) {
      triangle.corners[k] = found.vertices[corners[k]];
      values[k] = found.values.empty() ? 0 : static_cast<float>(found.values[corners[k]] / unit);
    }
  }
  addWalls(camera, smoke.locator->mesh(), pieces.walls);
}

}  // namespace volute
