// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fds/fds_triangle_sheets.hpp"

#include <algorithm>
#include <cmath>

#include "volute/base/parallel.hpp"
#include "volute/fds/fds_iso.hpp"
#include "volute/medium/integrate.hpp"

namespace volute {
namespace {

constexpr std::size_t kMaxSheets = 64;  // of which 0.6^64 = 6e-15 of the light passes
constexpr double kBehind = 1e-5;        // [m] and of the distance: where to look for the next one

Vec3 pointOf(const FdsIsoFrame& frame, std::int32_t vertex) {
  const auto& [x, y, z] = frame.vertices[static_cast<std::size_t>(vertex)];
  return {x, y, z};
}

}  // namespace

Result<FdsTriangleSheets> FdsTriangleSheets::build(std::span<const FdsIsoFrame> frames,
                                                   std::span<const Rgb> colours) {
  FdsTriangleSheets sheets;
  std::vector<Triangle> triangles;
  std::vector<std::array<float, 3>> ups;
  for (const FdsIsoFrame& frame : frames) {
    std::vector<Vec3> normals(frame.vertices.size(), Vec3::Zero());
    for (std::size_t i = 0; i < frame.triangles.size(); ++i) {
      Triangle& triangle = triangles.emplace_back();
      triangle.material = static_cast<std::uint32_t>(frame.levels[i]);
      for (int c = 0; c < 3; ++c) triangle.corners[c] = pointOf(frame, frame.triangles[i][c]);
      const Vec3 normal = triangle.normal();  // as long as the triangle is large
      for (const std::int32_t corner : frame.triangles[i]) {
        Vec3& sum = normals[static_cast<std::size_t>(corner)];
        sum += sum.dot(normal) < 0 ? Vec3(-normal) : normal;
      }
    }
    for (std::size_t i = 0; i < frame.triangles.size(); ++i) {
      std::array<float, 3>& up = ups.emplace_back();
      for (int c = 0; c < 3; ++c) {
        const Vec3& normal = normals[static_cast<std::size_t>(frame.triangles[i][c])];
        const double length = normal.norm();
        up[c] = length > 0 ? static_cast<float>(std::abs(normal.z()) / length) : 1.0F;
      }
    }
  }
  std::vector<Material> materials;
  for (const Rgb& colour : colours) materials.push_back({Rgb::Zero(), colour});
  VOLUTE_ASSIGN(sheets.scene_, TriangleScene::build(std::move(triangles), std::move(materials)));
  sheets.up_ = std::make_shared<const std::vector<std::array<float, 3>>>(std::move(ups));
  return sheets;
}

Box3 FdsTriangleSheets::bounds() const {
  constexpr double kAround = 1e-3;  // [m]
  Box3 box = scene_.bounds();
  box.min -= Vec3::Constant(kAround);
  box.max += Vec3::Constant(kAround);
  return box;
}

std::vector<Hit> FdsTriangleSheets::crossings(const Segment& segment) const {
  std::vector<Hit> hits;
  Segment rest = segment;
  while (hits.size() < kMaxSheets && !rest.empty()) {
    Hit hit;
    scene_.nearest({&rest, 1}, {&hit, 1});
    if (!hit.found())
      break;
    rest.begin = hit.distance + kBehind * (1 + std::abs(hit.distance));
    if (hits.empty() || hits.back().triangle != hit.triangle)
      hits.push_back(hit);
  }
  return hits;
}

Rgb FdsTriangleSheets::shaded(const Segment& segment, const Hit& hit) const {
  const Triangle& triangle = scene_.triangles()[hit.triangle];
  const Vec3 point = segment.at(hit.distance);
  const Vec3 normal = triangle.normal();
  const double area = normal.squaredNorm();
  const std::array<float, 3>& corners = (*up_)[hit.triangle];
  double up = corners[0];
  if (area > 0) {
    up = 0;
    for (int c = 0; c < 3; ++c) {
      const Vec3& next = triangle.corners[(c + 1) % 3];
      const Vec3& last = triangle.corners[(c + 2) % 3];
      up += corners[c] * std::clamp((last - next).cross(point - next).dot(normal) / area, 0.0, 1.0);
    }
  }
  return sheetShade(std::min(up, 1.0)) * scene_.materialOf(hit).emission;
}

void FdsTriangleSheets::opticalDepth(std::span<const Segment> segments,
                                     std::span<double> depths) const {
  parallelRanges(segments.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      depths[i] = -std::log1p(-kOpacity) * static_cast<double>(crossings(segments[i]).size());
  });
}

void FdsTriangleSheets::pieces(std::span<const Segment> segments,
                               std::span<std::vector<Piece>> pieces) const {
  std::vector<double> roots;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const std::vector<Hit> hits = crossings(segments[i]);
    roots.clear();
    for (const Hit& hit : hits) roots.push_back(hit.distance);
    sheetPieces(
        segments[i], roots, kOpacity,
        [&](std::size_t root) { return shaded(segments[i], hits[root]); }, pieces[i]);
  }
}

void FdsTriangleSheets::radiance(std::span<const Segment> segments, std::span<Radiance> out) const {
  radianceByPieces(*this, segments, out);
}

}  // namespace volute
