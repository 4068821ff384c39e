// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "fuzz/input_folder.hpp"
#include "volute/io/surface.hpp"

extern "C" const volute::SurfacePlugin* voluteGltfPlugin();

// .gltf and .glb. Errors are fine; corners that are not finite and materials that are not there are
// not.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const volute::fuzz::InputFolder folder("gltf");
  const auto mesh =
      voluteGltfPlugin()->read(folder.save("a.gltf", volute::fuzz::textOf(data, size)));
  if (!mesh)
    return 0;
  for (const volute::Triangle& triangle : mesh->triangles) {
    volute::fuzz::require(triangle.material < mesh->materials.size());
    for (const volute::Vec3& corner : triangle.corners) volute::fuzz::require(corner.allFinite());
  }
  return 0;
}
