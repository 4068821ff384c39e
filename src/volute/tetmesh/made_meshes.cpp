// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tetmesh/made_meshes.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "volute/base/assert.hpp"

namespace volute {
namespace {

/// The six tets of a cube around its diagonal from corner 0 to corner 7: one for each order of the
/// axes. Cubes side by side meet. Corner bits: x 1, y 2, z 4.
constexpr int kSix[6][4] = {{0, 1, 3, 7}, {0, 1, 5, 7}, {0, 2, 3, 7},
                            {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 4, 6, 7}};

using Keep = std::function<bool(const Vec3& centre)>;

/// Uniform in [-1, 1), the same on every platform.
double drawn(std::mt19937& random) {
  return random() / 2147483648.0 - 1;
}

std::shared_ptr<const TetMesh> cutBox(const Box3& box, const std::array<int, 3>& cells,
                                      double jitter, std::uint32_t seed, const Keep& keep) {
  const Vec3 cell = box.size().cwiseQuotient(Vec3(cells[0], cells[1], cells[2]));
  const auto index = [&](int x, int y, int z) {
    return (static_cast<std::size_t>(z) * (cells[1] + 1) + y) * (cells[0] + 1) + x;
  };
  const std::size_t points = index(cells[0], cells[1], cells[2]) + 1;
  std::vector<std::int32_t> number(points, -1);  // -1: in no kept cube
  std::vector<int> cubes(points, 0);             // kept cubes around; 8 inside
  std::vector<std::array<std::size_t, 8>> kept;
  for (int z = 0; z < cells[2]; ++z) {
    for (int y = 0; y < cells[1]; ++y) {
      for (int x = 0; x < cells[0]; ++x) {
        if (!keep(box.min + Vec3(x + 0.5, y + 0.5, z + 0.5).cwiseProduct(cell)))
          continue;
        auto& cube = kept.emplace_back();
        for (int k = 0; k < 8; ++k) {
          cube[k] = index(x + (k & 1), y + (k >> 1 & 1), z + (k >> 2));
          ++cubes[cube[k]];
        }
      }
    }
  }
  std::vector<Vec3> vertices;
  std::mt19937 random(seed);
  for (int z = 0; z <= cells[2]; ++z) {
    for (int y = 0; y <= cells[1]; ++y) {
      for (int x = 0; x <= cells[0]; ++x) {
        const std::size_t i = index(x, y, z);
        if (cubes[i] == 0)
          continue;
        number[i] = static_cast<std::int32_t>(vertices.size());
        Vec3 place(x, y, z);
        for (int axis = 0; axis < 3 && cubes[i] == 8; ++axis) place[axis] += jitter * drawn(random);
        vertices.push_back(box.min + place.cwiseProduct(cell));
      }
    }
  }
  std::vector<Tet> tets;
  for (const auto& cube : kept) {
    for (const auto& six : kSix) {
      Tet& tet = tets.emplace_back();
      for (int k = 0; k < 4; ++k) tet[k] = number[cube[six[k]]];
    }
  }
  auto mesh = TetMesh::build(std::move(vertices), std::move(tets), "made mesh");
  // A draw may turn a tet inside out; a straight box has none such.
  VOLUTE_ASSERT(mesh.has_value() || jitter > 0);
  return mesh ? *mesh : cutBox(box, cells, 0.5 * jitter, seed, keep);
}

bool inside(const Vec3& p, const Vec3& from, const Vec3& to) {
  return Box3{from, to}.contains(p);
}

}  // namespace

std::shared_ptr<const TetMesh> boxMesh(const Box3& box, const std::array<int, 3>& cells,
                                       double jitter, std::uint32_t seed) {
  return cutBox(box, cells, jitter, seed, [](const Vec3&) { return true; });
}

std::shared_ptr<const TetMesh> hallMesh(double cell, std::uint32_t seed) {
  const Box3 box{Vec3::Zero(), Vec3(28, 12, 6)};
  std::array<int, 3> cells{};
  for (int axis = 0; axis < 3; ++axis)
    cells[axis] = std::max(4, static_cast<int>(std::lround(box.size()[axis] / cell)));
  return cutBox(box, cells, 0.25, seed, [](const Vec3& p) {
    for (const double x : {5.0, 12.0}) {
      for (const double y : {3.0, 8.4}) {
        if (inside(p, Vec3(x, y, 0), Vec3(x + 0.7, y + 0.7, 6)))
          return false;
      }
    }
    const bool curtain = inside(p, Vec3(8, 0, 4.8), Vec3(8.6, 12, 6));
    const bool wall = inside(p, Vec3(20, 0, 0), Vec3(20.6, 12, 6)) &&
                      !inside(p, Vec3(20, 4.8, 0), Vec3(20.6, 7.2, 2.6));
    return !curtain && !wall;
  });
}

std::vector<float> plume(const TetMesh& mesh, double time, std::uint32_t seed) {
  const Box3& box = mesh.bounds();
  const Vec3 size = box.size();
  std::mt19937 random(seed);

  struct Eddy {
    Vec3 wave;
    double phase;
  };

  std::array<Eddy, 6> eddies;
  for (Eddy& eddy : eddies) {
    for (int axis = 0; axis < 3; ++axis) eddy.wave[axis] = 2 * drawn(random);
    eddy.phase = 3 * drawn(random);
  }
  const Vec3 seat = box.min + size.cwiseProduct(Vec3(0.85, 0.5, 0));
  std::vector<float> values;
  values.reserve(mesh.vertices().size());
  for (const Vec3& p : mesh.vertices()) {
    double swirl = 0;
    for (const Eddy& eddy : eddies)
      swirl += std::sin(eddy.wave.dot(p) + eddy.phase + 0.7 * time) / eddies.size();
    const double height = (p.z() - box.min.z()) / size.z();
    const double away = std::hypot(p.x() - seat.x(), p.y() - seat.y());
    const double width = 0.06 * size.x() * (0.4 + height);
    const double column = 8 * std::exp(-0.5 * away * away / (width * width));
    const double layer =
        1.5 * std::exp(-std::pow((1 - height) / 0.25, 2)) * std::exp(-away / (0.5 * size.x()));
    values.push_back(static_cast<float>((column + layer) * std::max(0.0, 1 + 1.2 * swirl)));
  }
  return values;
}

}  // namespace volute
