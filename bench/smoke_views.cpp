// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "bench/smoke_views.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "volute/io/mesh_source.hpp"
#include "volute/tetmesh/made_meshes.hpp"
#include "volute/tetmesh/tet_reference.hpp"

namespace volute::bench {
namespace {

Vec3 centreOf(const TetMesh& mesh, const Tet& tet) {
  Vec3 centre = Vec3::Zero();
  for (const std::int32_t v : tet) centre += 0.25 * mesh.vertices()[v];
  return centre;
}

SmokeCase inMetres(SmokeCase smoke) {
  constexpr float kPerGram = 0.15F;  // extinction of 1 g/m3 of the field [1/m]
  for (auto& field : smoke.extinction) {
    for (float& value : field) value *= kPerGram;
  }
  return smoke;
}

const Tet& nearestTet(const TetMesh& mesh, const Vec3& point) {
  return *std::ranges::min_element(
      mesh.tets(), {}, [&](const Tet& tet) { return (centreOf(mesh, tet) - point).squaredNorm(); });
}

}  // namespace

SmokeCase madeSmokeCase(std::string name, double cell) {
  SmokeCase made{std::move(name), hallMesh(cell, 1), {}};
  for (int i = 0; i < 4; ++i) made.extinction.push_back(plume(*made.mesh, i, 1));
  return inMetres(std::move(made));
}

Result<SmokeCase> readSmokeCase(const BenchInput& input) {
  const MeshOptions options{.field = "smoke", .negatives = Negatives::kClamp};
  VOLUTE_ASSIGN(auto source, MeshSource::open(input.volume, options));
  SmokeCase read{std::filesystem::path(input.volume).filename().string(), nullptr, {}};
  const std::size_t count = source.times().size();
  for (std::size_t i = count - std::min<std::size_t>(count, 4); i < count; ++i) {
    VOLUTE_ASSIGN(auto frame, source.read(i));
    if (frame.mesh != read.mesh)
      read.extinction.clear();
    read.mesh = frame.mesh;
    read.extinction.push_back(std::move(frame.values));
  }
  for (const float share : {0.97F, 0.94F, 0.91F}) {
    if (read.extinction.size() >= 4)
      break;
    auto& thinner = read.extinction.emplace_back(read.extinction.front());
    for (float& value : thinner) value *= share;
  }
  return inMetres(std::move(read));
}

std::vector<SmokeEye> smokeEyes(const TetLocator& locator) {
  const TetMesh& mesh = locator.mesh();
  const auto at = [&](double x, double y, double z) {
    return Vec3(mesh.bounds().min + mesh.bounds().size().cwiseProduct(Vec3(x, y, z)));
  };
  Vec3 inside = at(0.08, 0.57, 0.28);
  if (locator.find(inside) < 0)
    inside = centreOf(mesh, nearestTet(mesh, inside));
  return {{"outside", at(-0.32, -1.2, 2.3), at(0.5, 0.5, 0.33), 36},
          {"inside", inside, at(0.86, 0.5, 0.4), 60}};
}

std::vector<SmokeEye> eyesOnMesh(const TetMesh& mesh, const SmokeEye& near) {
  const Tet& tet = nearestTet(mesh, near.eye);
  const auto vertex = [&](int k) { return mesh.vertices()[tet[k]]; };
  const auto eye = [&](const char* name, const Vec3& at) {
    return SmokeEye{name, at, near.target, near.fov};
  };
  return {eye("on a vertex", vertex(0)), eye("on an edge", 0.5 * (vertex(0) + vertex(1))),
          eye("on a face", (vertex(0) + vertex(1) + vertex(2)) / 3)};
}

std::vector<float> opaqueDepth(const SmokeView& view) {
  if (view.sign.empty())
    return {};
  const Camera camera = view.camera();
  const auto width = static_cast<std::size_t>(view.width);
  std::vector<float> depth(width * view.height, std::numeric_limits<float>::infinity());
  const Vec3 across = view.sign[1] - view.sign[0], down = view.sign[3] - view.sign[0];
  const Vec3 normal = across.cross(down);
  // The sign stands before the eye: its corners' pixels are its box.
  Box3 box;
  for (const Vec3& corner : view.sign) {
    const Vec3 from = (corner - camera.eye()) / camera.pixelSize();
    box.extend(Vec3(from.dot(camera.right()), from.dot(camera.down()), 0) /
               ((corner - camera.eye()).dot(camera.forward())));
  }
  const int x0 = std::max(0, static_cast<int>(std::floor(box.min.x() + 0.5 * view.width)));
  const int x1 = std::min(view.width, static_cast<int>(std::ceil(box.max.x() + 0.5 * view.width)));
  const int y0 = std::max(0, static_cast<int>(std::floor(box.min.y() + 0.5 * view.height)));
  const int y1 =
      std::min(view.height, static_cast<int>(std::ceil(box.max.y() + 0.5 * view.height)));
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) {
      const Segment ray = pixelRay(camera, x, y, {});
      const double distance = normal.dot(view.sign[0] - ray.origin) / normal.dot(ray.direction);
      const Vec3 at = ray.origin + distance * ray.direction - view.sign[0];
      const double u = at.dot(across) / across.squaredNorm(), v = at.dot(down) / down.squaredNorm();
      if (distance > 0 && u >= 0 && u <= 1 && v >= 0 && v <= 1)
        depth[static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x)] =
            static_cast<float>(distance);
    }
  }
  return depth;
}

std::string SmokeSetting::name() const {
  return fmt::format("{}, {}, {}x{}{}", smoke.name, eye.name, width, height,
                     sign ? ", exit sign" : "");
}

SmokeView SmokeSetting::view(int field, int turn, int move) const {
  const Vec3 towards = eye.target - eye.eye;
  const Vec3 across = towards.cross(Vec3::UnitZ()).normalized();
  SmokeView view;
  view.eye = eye.eye + 0.005 * towards.norm() * move * across;
  view.target = eye.target + 0.01 * towards.norm() * turn * across;
  view.fov = eye.fov;
  view.width = width;
  view.height = height;
  view.field = field;
  if (sign) {
    const Vec3 centre = eye.eye + 0.8 * towards;
    const Vec3 right = 0.04 * towards.norm() * across, up = 0.4 * right.norm() * Vec3::UnitZ();
    view.sign = {centre - right + up, centre + right + up, centre + right - up,
                 centre - right - up};
  }
  return view;
}

}  // namespace volute::bench
