// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/smoke/smoke_walls.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "volute/base/mask.hpp"
#include "volute/base/parallel.hpp"
#include "volute/lighting/inner_points.hpp"

namespace volute {
namespace {

constexpr std::size_t kFewFaces = 8;
constexpr std::size_t kFewPixels = 1 << 16;

/// Pixels by the face that they see.
struct PixelsOfFaces {
  std::vector<std::uint32_t> begin, pixels;

  /// @param only  not 0 for pixels that count; empty: all
  PixelsOfFaces(std::span<const std::uint32_t> faceOf, std::size_t faces,
                std::span<const std::uint8_t> only)
      : begin(faces + 1, 0) {
    forEachSet(only, 0, faceOf.size(), [&](std::size_t i) {
      if (faceOf[i] != WallView::kNone)
        ++begin[faceOf[i] + 1];
    });
    for (std::size_t f = 0; f < faces; ++f) begin[f + 1] += begin[f];
    pixels.resize(begin.back());
    std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
    forEachSet(only, 0, faceOf.size(), [&](std::size_t i) {
      if (faceOf[i] != WallView::kNone)
        pixels[next[faceOf[i]]++] = static_cast<std::uint32_t>(i);
    });
  }

  std::span<const std::uint32_t> of(std::size_t face) const {
    return std::span(pixels).subspan(begin[face], begin[face + 1] - begin[face]);
  }
};

/// cornerShares() of many points of one triangle.
class CornerShares {
 public:
  CornerShares(const std::array<std::int32_t, 3>& corners, std::span<const Vec3> points)
      : origin_(points[corners[0]]) {
    const Vec3 u = points[corners[1]] - origin_, v = points[corners[2]] - origin_;
    const Vec3 normal = u.cross(v);
    second_ = v.cross(normal) / normal.squaredNorm();
    third_ = normal.cross(u) / normal.squaredNorm();
  }

  Vec3 operator()(const Vec3& point) const {
    const Vec3 from = point - origin_;
    const double second = from.dot(second_), third = from.dot(third_);
    return Vec3(1 - second - third, second, third).cwiseMax(0);
  }

 private:
  Vec3 origin_, second_, third_;  // gradients of the second and the third share
};

/// The lamps before the walls of a mesh.
class LampsOnWalls {
 public:
  LampsOnWalls(const SmokeState& smoke, const SceneLights& lights, const Blocks& blocks,
               const MeshWalls& walls, std::uint64_t view, WallLight& known)
      : smoke_(smoke),
        lights_(lights),
        blocks_(blocks),
        walls_(walls),
        request_{*smoke.locator, smoke.extinction, walls, lights.lamps},
        known_(known),
        lift_(blocks ? InnerSide::kLift * wallRounding(smoke.locator->mesh()) : 0) {
    request_.view = view;
    if (const WallInterval& between = smoke.interval; between.light) {
      request_.extinction = *between.from, request_.later = *between.to;
      request_.time = smoke.intervalTime;
    }
  }

  /// Adds what points of a wall reflect of lamps' light if they reflect all.
  void addTo(std::span<Rgb> light, std::span<const Vec3> points, std::size_t face) const {
    const WallFace& wall = walls_.faces()[face];
    const CornerShares sharesAt(wall.vertices, smoke_.locator->mesh().vertices());
    std::vector<Vec3> corners(points.size()), near;
    std::vector<double> reflected, shares;
    std::vector<std::size_t> lit;
    for (std::size_t i = 0; i < points.size(); ++i) corners[i] = sharesAt(points[i]);
    for (std::size_t l = 0; l < lights_.lamps.size(); ++l) {
      const Lamp& lamp = lights_.lamps[l];
      const double ahead = aheadOf(wall, lamp);
      if (!(ahead > 0) || !(lamp.intensity > 0).any())
        continue;
      near.clear(), reflected.clear(), lit.clear();
      for (std::size_t i = 0; i < points.size(); ++i) {
        const double here = reflectedShare(lamp, ahead, points[i]);
        if (here > 0)
          near.push_back(corners[i]), lit.push_back(i), reflected.push_back(here);
      }
      if (lit.empty())
        continue;
      shares.resize(lit.size());
      known_.shares(request_, l, face, near, shares);
      leaveOutBlocked(lamp, lift_ * wall.inwards, points, lit, shares);
      for (std::size_t i = 0; i < lit.size(); ++i)
        light[lit[i]] += shares[i] * reflected[i] * lamp.intensity;
    }
  }

 private:
  /// How far a lamp is before the plane of a wall [m]; the sun: the cosine at which it shines
  /// there.
  double aheadOf(const WallFace& wall, const Lamp& lamp) const {
    if (lamp.kind == Lamp::Kind::kSun)
      return -wall.inwards.dot(lamp.direction);
    const Vec3& corner = smoke_.locator->mesh().vertices()[wall.vertices[0]];
    return wall.inwards.dot(lamp.position - corner);
  }

  /// Of a lamp's intensity, what a point of a white wall reflects if nothing is in the way: [1/m^2]
  /// of a spot. Lamp::irradiance() by the cosine of the wall, over pi.
  static double reflectedShare(const Lamp& lamp, double ahead, const Vec3& point) {
    constexpr double kInversePi = 1 / std::numbers::pi;
    if (lamp.kind == Lamp::Kind::kSun)
      return ahead * kInversePi;
    const double square = (lamp.position - point).squaredNorm();
    const double reach = std::max(square, lamp.radius * lamp.radius);
    const double all = ahead * kInversePi / (std::sqrt(square) * reach);
    return lamp.coneCosine > -1 ? lamp.coneShare(point) * all : all;
  }

  /// @param inwards  from a wall that others may show a little before it
  void leaveOutBlocked(const Lamp& lamp, const Vec3& inwards, std::span<const Vec3> points,
                       std::span<const std::size_t> lit, std::span<double> shares) const {
    if (!blocks_)
      return;
    std::vector<Segment> ways;
    ways.reserve(lit.size());
    for (const std::size_t i : lit) ways.push_back(lamp.towards(points[i] + inwards));
    std::vector<std::uint8_t> blocked(lit.size(), 0);
    blocks_(ways, blocked);
    for (std::size_t i = 0; i < lit.size(); ++i) {
      if (blocked[i])
        shares[i] = 0;
    }
  }

  const SmokeState& smoke_;
  const SceneLights& lights_;
  const Blocks& blocks_;
  const MeshWalls& walls_;
  WallLight::Request request_;
  WallLight& known_;
  double lift_;  ///< [m]
};

constexpr double kGap = 1e-6;  ///< [m] between tets that counts as outside

/// Where a ray leaves a mesh for the first time: the tet, and how far that is [m].
struct MeshExit {
  std::int32_t tet = -1;
  double distance = std::numeric_limits<double>::infinity();
};

MeshExit exitOf(const TetLocator& locator, const Segment& ray) {
  std::vector<TetCrossing> crossings;
  locator.crossings(ray, crossings);
  const auto wall = locator.wallOn(ray);
  for (std::size_t i = 0; i < crossings.size(); ++i) {
    const bool last = i + 1 == crossings.size();
    if (last || crossings[i + 1].begin > crossings[i].end + kGap ||
        (wall && crossings[i].end > *wall - kGap))
      return {crossings[i].tet, crossings[i].end};
  }
  return {};
}

/// Inwards, of the face through which a ray leaves a tet.
Vec3 normalBehind(const TetMesh& mesh, std::int32_t tet, const Segment& ray) {
  const auto points = mesh.vertices();
  const Tet& corners = mesh.tets()[static_cast<std::size_t>(tet)];
  double nearest = std::numeric_limits<double>::infinity();
  Vec3 normal = -ray.direction;
  for (int k = 0; k < 4; ++k) {
    const Vec3& a = points[corners[(k + 1) & 3]];
    const Vec3& b = points[corners[(k + 2) & 3]];
    const Vec3& c = points[corners[(k + 3) & 3]];
    Vec3 across = (b - a).cross(c - a);
    if (across.dot(points[corners[k]] - a) < 0)
      across = -across;
    const double towards = across.dot(ray.direction);
    if (!(towards < 0))
      continue;
    const double distance = across.dot(a - ray.origin) / towards;
    if (distance < nearest)
      nearest = distance, normal = across.normalized();
  }
  return normal;
}

}  // namespace

std::optional<WallHit> wallLeft(const TetLocator& locator, const Segment& ray) {
  const MeshExit exit = exitOf(locator, ray);
  if (exit.tet < 0)
    return std::nullopt;
  return WallHit{exit.distance, normalBehind(locator.mesh(), exit.tet, ray)};
}

Vec3 cornerShares(const std::array<std::int32_t, 3>& corners, std::span<const Vec3> points,
                  const Vec3& point) {
  return CornerShares(corners, points)(point);
}

Result<SurfaceView> lookAtWalls(const Camera& camera, const SmokeState& smoke,
                                const SceneLights& lights, const Rgb& color, const Blocks& blocks,
                                std::span<const std::uint8_t> only, WallLight* known) {
  std::shared_ptr<const MeshWalls> walls = smoke.walls;
  if (!walls) {
    VOLUTE_ASSIGN(walls, MeshWalls::make(smoke.locator->mesh()));
  }
  const auto width = static_cast<std::size_t>(camera.width());
  SurfaceView view{std::vector<float>(width * static_cast<std::size_t>(camera.height()),
                                      std::numeric_limits<float>::infinity()),
                   Image(camera.width(), camera.height(), 3)};
  const auto rayOf = [&](std::size_t pixel) {
    return camera.ray(static_cast<double>(pixel % width) + 0.5,
                      static_cast<double>(pixel / width) + 0.5);
  };
  const auto show = [&](std::size_t pixel, const Rgb& light) {
    for (std::size_t c = 0; c < 3; ++c) {
      view.color.pixels[3 * pixel + c] = static_cast<float>(color[c] * light[c]);
    }
  };
  if (!only.empty() && lights.lamps.empty()) {
    walls->look(camera, only, [&](std::size_t pixel, const Hit& hit) {
      view.depth[pixel] = static_cast<float>(hit.distance);
      show(pixel, lights.ambient);
    });
    return view;
  }
  std::vector<std::uint32_t> some;
  std::shared_ptr<const WallView> all;
  if (only.empty()) {
    all = walls->seenFrom(camera);
    view.depth = all->depth;
  } else {
    some.assign(view.depth.size(), WallView::kNone);
    walls->look(camera, only, [&](std::size_t pixel, const Hit& hit) {
      view.depth[pixel] = static_cast<float>(hit.distance);
      some[pixel] = hit.triangle;
    });
  }
  const std::vector<std::uint32_t>& faceOf = all ? all->face : some;
  if (lights.lamps.empty()) {
    parallelRanges(faceOf.size(), kFewPixels, [&](std::size_t begin, std::size_t end) {
      for (std::size_t pixel = begin; pixel < end; ++pixel) {
        if (faceOf[pixel] != WallView::kNone)
          show(pixel, lights.ambient);
      }
    });
    return view;
  }
  WallLight found;
  WallLight* const kept = smoke.interval.light ? smoke.interval.light.get() : known;
  const LampsOnWalls lamps(smoke, lights, blocks, *walls, all ? all->number : 0,
                           kept ? *kept : found);
  const PixelsOfFaces seen(faceOf, walls->faces().size(), only);
  const auto vertices = smoke.locator->mesh().vertices();
  parallelRanges(walls->faces().size(), kFewFaces, [&](std::size_t begin, std::size_t end) {
    std::vector<Vec3> points;
    std::vector<Rgb> light;
    for (std::size_t face = begin; face < end; ++face) {
      const auto pixels = seen.of(face);
      if (pixels.empty())
        continue;
      const WallFace& wall = walls->faces()[face];
      const double height = wall.inwards.dot(vertices[wall.vertices[0]]);
      points.clear();
      for (const std::uint32_t pixel : pixels) {
        const Segment ray = rayOf(pixel);
        points.push_back(
            ray.at((height - wall.inwards.dot(ray.origin)) / wall.inwards.dot(ray.direction)));
      }
      light.assign(points.size(), lights.ambient);
      lamps.addTo(light, points, face);
      for (std::size_t i = 0; i < pixels.size(); ++i) show(pixels[i], light[i]);
    }
  });
  return view;
}

}  // namespace volute
