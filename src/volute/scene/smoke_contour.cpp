// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/smoke_contour.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>

#include "volute/base/assert.hpp"
#include "volute/base/parallel.hpp"
#include "volute/geometry/triangle_scene.hpp"
#include "volute/image/srgb.hpp"
#include "volute/tetmesh/tet_contour.hpp"

namespace volute {
namespace {

constexpr double kWall = 0.12, kSurface = 0.55;  // reflected of a light at the eye

/// Triangles of all smokes, and three values for each.
struct Pieces {
  std::vector<Triangle> triangles;
  std::vector<std::array<float, 3>> values;
};

ContourSurface contourOf(const SmokeContour& contour, const SmokeState& smoke) {
  const TetMesh& mesh = smoke.locator->mesh();
  if (contour.kind == SmokeContour::Kind::kSurface)
    return contourSurface(mesh, smoke.extinction, contour.c / contour.visibility);
  return contourSlice(mesh, Vec3::Unit(contour.axis), contour.place, smoke.extinction);
}

Pieces piecesOf(const SmokeContour& contour, std::span<const SmokeState> smokes) {
  Pieces pieces;
  const bool slice = contour.kind == SmokeContour::Kind::kSlice;
  const bool concentration = slice && contour.shows == SmokeContour::Shows::kConcentration;
  for (const SmokeState& smoke : smokes) {
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
  }
  return pieces;
}

/// The boundaries of the meshes, those that face the camera with their inner sides.
std::vector<Triangle> wallsOf(const Camera& camera, std::span<const SmokeState> smokes) {
  std::vector<Triangle> walls;
  for (const SmokeState& smoke : smokes) {
    const TetMesh& mesh = smoke.locator->mesh();
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
  return walls;
}

double valueAt(const Triangle& triangle, const std::array<float, 3>& values, const Vec3& point) {
  const Vec3 u = triangle.corners[1] - triangle.corners[0],
             v = triangle.corners[2] - triangle.corners[0], w = point - triangle.corners[0];
  const Vec3 normal = u.cross(v);
  const double area = normal.squaredNorm();
  const double second = std::clamp(w.cross(v).dot(normal) / area, 0.0, 1.0),
               third = std::clamp(u.cross(w).dot(normal) / area, 0.0, 1.0 - second);
  return (1 - second - third) * values[0] + second * values[1] + third * values[2];
}

/// Seen by a light at the eye.
double shadeOf(const Triangle& triangle, const Vec3& direction) {
  return std::abs(triangle.normal().normalized().dot(direction));
}

/// Of the extinction, or of the concentration where that is shown.
Rgb colorOf(const SmokeContour& contour, double value) {
  double shown = value / contour.most;
  if (contour.shows == SmokeContour::Shows::kVisibility)
    shown = value > 0 ? contour.c / value / contour.most : 1;
  return displayColor(colorMapOf(contour), shown).unaryExpr(&srgbDecode);
}

}  // namespace

ColorMap colorMapOf(const SmokeContour& slice) {
  return slice.shows == SmokeContour::Shows::kConcentration ? ColorMap::kPlasma
                                                            : ColorMap::kViridis;
}

Result<SmokeContour> parseSlice(std::string_view text) {
  SmokeContour slice;
  const std::string_view axes = "xyz";
  const char* end = text.data() + text.size();
  const bool named =
      text.size() > 2 && text[1] == '=' && axes.find(text[0]) != std::string_view::npos;
  if (named) {
    const auto [rest, error] = std::from_chars(text.data() + 2, end, slice.place);
    if (error == std::errc() && rest == end && std::isfinite(slice.place)) {
      slice.axis = static_cast<int>(axes.find(text[0]));
      return slice;
    }
  }
  return fail(ErrorCode::kInvalidArgument,
              "--slice: '{}' is no plane; expected x, y or z and a place in metres, as z=1.8",
              text);
}

double mostOn(const SmokeContour& slice, std::span<const SmokeState> smokes) {
  double most = 0;
  for (const auto& values : piecesOf(slice, smokes).values)
    most = std::max<double>(most, *std::ranges::max_element(values));
  return most;
}

Result<Image> lookAtContour(const Camera& camera, std::span<const SmokeState> smokes,
                            const SmokeContour& contour) {
  Pieces pieces = piecesOf(contour, smokes);
  const auto values = std::move(pieces.values);
  VOLUTE_ASSIGN(const auto scene, TriangleScene::build(std::move(pieces.triangles)));
  VOLUTE_ASSIGN(const auto walls, TriangleScene::build(wallsOf(camera, smokes)));
  Image image(camera.width(), camera.height(), 3);
  const auto width = static_cast<std::size_t>(camera.width());
  parallelFor(static_cast<std::size_t>(camera.height()), [&](std::size_t y) {
    std::vector<Segment> rays;
    for (std::size_t x = 0; x < width; ++x)
      rays.push_back(camera.ray(static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5));
    std::vector<Hit> onContour(width), onWall(width);
    scene.nearest(rays, onContour);
    walls.nearest(rays, onWall);
    for (std::size_t x = 0; x < width; ++x) {
      const Hit& hit = onContour[x];
      Rgb color = Rgb::Zero();
      if (hit.found() && hit.distance <= onWall[x].distance) {
        const Triangle& triangle = scene.triangles()[hit.triangle];
        color = contour.kind == SmokeContour::Kind::kSurface
                    ? Rgb::Constant(kSurface * shadeOf(triangle, rays[x].direction))
                    : colorOf(contour,
                              valueAt(triangle, values[hit.triangle], rays[x].at(hit.distance)));
      } else if (onWall[x].found()) {
        color = Rgb::Constant(kWall *
                              shadeOf(walls.triangles()[onWall[x].triangle], rays[x].direction));
      }
      for (int c = 0; c < 3; ++c)
        image.at(static_cast<int>(x), static_cast<int>(y), c) = static_cast<float>(color[c]);
    }
  });
  return image;
}

}  // namespace volute
