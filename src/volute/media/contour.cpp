// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/contour.hpp"

#include <algorithm>
#include <cmath>

#include "volute/base/number_word.hpp"
#include "volute/base/parallel.hpp"
#include "volute/image/srgb.hpp"

namespace volute {
namespace {

constexpr double kWall = 0.12, kSurface = 0.55;  // reflected of a light at the eye

ContourPieces piecesOf(const Contour& contour, const Camera& camera,
                       std::span<const std::shared_ptr<const MediumSnapshot>> media) {
  ContourPieces pieces;
  for (const auto& medium : media) medium->addContour(contour, camera, pieces);
  return pieces;
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
Rgb colorOf(const Contour& contour, double value) {
  double shown = value / contour.most;
  if (contour.shows == Contour::Shows::kVisibility)
    shown = value > 0 ? contour.c / value / contour.most : 1;
  return displayColor(colorMapOf(contour), shown).unaryExpr(&srgbDecode);
}

}  // namespace

ColorMap colorMapOf(const Contour& slice) {
  return slice.shows == Contour::Shows::kConcentration ? ColorMap::kPlasma : ColorMap::kViridis;
}

Result<Contour> parseSlice(std::string_view text) {
  Contour slice;
  const std::string_view axes = "xyz";
  const bool named =
      text.size() > 2 && text[1] == '=' && axes.find(text[0]) != std::string_view::npos;
  if (named) {
    if (readNumber(text.substr(2), slice.place) && std::isfinite(slice.place)) {
      slice.axis = static_cast<int>(axes.find(text[0]));
      return slice;
    }
  }
  return failFor("slice", ErrorCode::kInvalidArgument,
                 "'{}' is not a plane; expected x, y or z and a place in metres, as z=1.8", text);
}

double largestOn(const Contour& slice,
                 std::span<const std::shared_ptr<const MediumSnapshot>> media) {
  const Camera any = Camera::framing({Vec3::Zero(), Vec3::Ones()}, 1, 1);  // walls do not count
  double largest = 0;
  for (const auto& values : piecesOf(slice, any, media).values)
    largest = std::max<double>(largest, *std::ranges::max_element(values));
  return largest;
}

Result<Image> lookAtContour(const Camera& camera,
                            std::span<const std::shared_ptr<const MediumSnapshot>> media,
                            const Contour& contour) {
  ContourPieces pieces = piecesOf(contour, camera, media);
  const auto values = std::move(pieces.values);
  VOLUTE_ASSIGN(const auto scene, TriangleScene::build(std::move(pieces.triangles)));
  VOLUTE_ASSIGN(const auto walls, TriangleScene::build(std::move(pieces.walls)));
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
        color = contour.kind == Contour::Kind::kSurface
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
