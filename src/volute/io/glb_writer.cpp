// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/glb_writer.hpp"

#include <nlohmann/json.hpp>

#include "volute/base/output_file.hpp"

namespace volute {
namespace {

using Json = nlohmann::ordered_json;

std::vector<double> list(const Rgb& color) {
  return {color[0], color[1], color[2]};
}

Json materialJson(const Material& material) {
  std::vector<double> base = list(material.baseColor);
  base.push_back(1);
  Json json = {{"pbrMetallicRoughness", {{"baseColorFactor", base}, {"metallicFactor", 0}}},
               {"doubleSided", true}};
  const double strength = material.emission.maxCoeff();
  if (strength > 0)  // factors are at most 1
    json["emissiveFactor"] = list(material.emission / std::max(strength, 1.0));
  if (strength > 1)
    json["extensions"] = {{"KHR_materials_emissive_strength", {{"emissiveStrength", strength}}}};
  return json;
}

/// The JSON around the bytes of `binary`, which it fills.
Json document(const TriangleMesh& mesh, std::vector<float>& binary) {
  Json accessors = Json::array(), primitives = Json::array(), materials = Json::array();
  for (std::uint32_t m = 0; m < mesh.materials.size(); ++m) {
    Box3 box;
    std::size_t count = 0;
    const std::size_t begin = binary.size();
    for (const Triangle& triangle : mesh.triangles) {
      if (triangle.material != m)
        continue;
      for (const Vec3& corner : triangle.corners) {
        const Vec3 rounded = corner.cast<float>().cast<double>();
        box.extend(rounded);
        for (int axis = 0; axis < 3; ++axis) binary.push_back(static_cast<float>(rounded[axis]));
        ++count;
      }
    }
    materials.push_back(materialJson(mesh.materials[m]));
    if (count == 0)
      continue;
    primitives.push_back({{"attributes", {{"POSITION", accessors.size()}}}, {"material", m}});
    accessors.push_back({{"bufferView", 0},
                         {"byteOffset", begin * sizeof(float)},
                         {"componentType", 5126},
                         {"count", count},
                         {"type", "VEC3"},
                         {"min", list(box.min.array())},
                         {"max", list(box.max.array())}});
  }
  const std::size_t bytes = binary.size() * sizeof(float);
  return {{"asset", {{"version", "2.0"}, {"generator", "Volute"}}},
          {"extensionsUsed", {"KHR_materials_emissive_strength"}},
          {"scene", 0},
          {"scenes", {{{"nodes", {0}}}}},
          // Its y is upwards, the mesh's z.
          {"nodes", {{{"mesh", 0}, {"matrix", {1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1}}}}},
          {"meshes", {{{"primitives", primitives}}}},
          {"materials", materials},
          {"accessors", accessors},
          {"bufferViews", {{{"buffer", 0}, {"byteLength", bytes}}}},
          {"buffers", {{{"byteLength", bytes}}}}};
}

}  // namespace

Status writeGlb(const std::filesystem::path& path, const TriangleMesh& mesh) {
  constexpr std::uint64_t kMax = 0xFFFF0000;  // lengths have 32 bits
  if (mesh.triangles.size() * 9 * sizeof(float) > kMax) {
    return fail(ErrorCode::kTooLarge, "{}: {} triangles are more than a .glb file can hold",
                path.string(), mesh.triangles.size());
  }
  std::vector<float> binary;
  std::string json = document(mesh, binary).dump();
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const auto jsonBytes = static_cast<std::uint32_t>(json.size());
  const auto binaryBytes = static_cast<std::uint32_t>(binary.size() * sizeof(float));
  const std::uint32_t head[5] = {0x46546C67, 2, 28 + jsonBytes + binaryBytes, jsonBytes,
                                 0x4E4F534A};
  const std::uint32_t second[2] = {binaryBytes, 0x004E4942};
  VOLUTE_ASSIGN(auto file, OutputFile::create(path));
  VOLUTE_TRY(file.write(std::as_bytes(std::span(head))));
  VOLUTE_TRY(file.write(std::as_bytes(std::span(json))));
  VOLUTE_TRY(file.write(std::as_bytes(std::span(second))));
  VOLUTE_TRY(file.write(std::as_bytes(std::span(binary))));
  return file.commit();
}

}  // namespace volute
