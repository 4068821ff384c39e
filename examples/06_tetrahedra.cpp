// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// Smoke on a mesh of tetrahedra, as simulations have it: values at vertices, linear in each tet.

#include <fmt/format.h>

#include <cmath>

#include "volute/io/image_file.hpp"
#include "volute/render/render.hpp"
#include "volute/tetmesh/tet_medium.hpp"

namespace {

/// The corners of a cube of 1 m, cut into six tets around its diagonal.
volute::Result<std::shared_ptr<const volute::TetMesh>> cube() {
  std::vector<volute::Vec3> corners;
  for (int i = 0; i < 8; ++i) corners.emplace_back(i & 1, i >> 1 & 1, i >> 2);
  return volute::TetMesh::build(
      std::move(corners),
      {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}},
      "the cube");
}

volute::Status lookThrough() {
  VOLUTE_ASSIGN(const auto mesh, cube());
  // Thicker to the top: z is linear, so that the mesh holds it exactly. [1/m]
  std::vector<float> extinction;
  for (const volute::Vec3& vertex : mesh->vertices())
    extinction.push_back(static_cast<float>(3 * vertex.z()));
  const volute::AnyMedium smoke(
      volute::TetMedium(std::make_shared<volute::TetLocator>(mesh), extinction));

  // Straight up through the middle: the integral of 3 z over 0..1.
  const volute::Segment up{volute::Vec3(0.4, 0.3, -1), volute::Vec3::UnitZ(), 0, 10};
  double depth = 0;
  smoke.opticalDepth({&up, 1}, {&depth, 1});
  fmt::print("optical depth {:.6f}\n", depth);
  if (std::abs(depth - 1.5) > 1e-9)
    return volute::fail(volute::ErrorCode::kInvalidData, "it should be 1.5");

  volute::Progress quiet;
  const auto camera = volute::Camera::framing(smoke.bounds(), 160, 120);
  VOLUTE_ASSIGN(const auto image,
                volute::render(camera, {&smoke, 1}, {.background = volute::Rgb(1, 1, 1)}, quiet));
  return volute::writeImage("smoke.png", image);
}

}  // namespace

int main() {
  if (const auto done = lookThrough(); !done) {
    fmt::print(stderr, "{}\n", done.error().message);
    return 1;
  }
}
