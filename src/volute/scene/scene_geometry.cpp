// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/scene_geometry.hpp"

#include "volute/io/json_members.hpp"
#include "volute/io/surface_file.hpp"
#include "volute/media/placement.hpp"

namespace volute {
namespace {

using Json = nlohmann::json;

/// +y of the file becomes +z, as in glTF's own convention: (x, y, z) -> (x, -z, y).
Mat4 yUpwards() {
  Mat4 turn = Mat4::Identity();
  turn.row(1) << 0, 0, -1, 0;
  turn.row(2) << 0, 1, 0, 0;
  return turn;
}

Result<SceneGeometry> parseEntry(const Json& json, const std::string& file,
                                 const std::string& path) {
  constexpr std::string_view kNames[] = {"file", "transform", "up"};
  const Members members(json, file, path);
  VOLUTE_TRY(members.check(kNames));
  SceneGeometry entry;
  VOLUTE_TRY(members.text("file", entry.file, "the name of a .glb, .gltf, .obj or .vtp file"));
  entry.file = besides(file, entry.file);
  if (!isSurfacePath(entry.file)) {
    return fail(ErrorCode::kInvalidData,
                "{}: {}: '{}' is no known geometry; expected .glb, .gltf, .obj or .vtp", file,
                members.where("file"), entry.file);
  }
  if (members.has("transform")) {
    VOLUTE_ASSIGN(entry.transform,
                  parseTransform(members.at("transform"), file, members.where("transform")));
  }
  std::string up = "z";
  if (members.has("up"))
    VOLUTE_TRY(members.text("up", up, "\"y\" or \"z\""));
  if (up != "y" && up != "z")
    return fail(ErrorCode::kInvalidData, "{}: {}: '{}' is unknown; expected y or z", file,
                members.where("up"), up);
  if (up == "y")
    entry.transform = entry.transform * yUpwards();
  return entry;
}

}  // namespace

Result<std::vector<SceneGeometry>> parseGeometry(const Json& json, const std::string& file,
                                                 const std::string& path) {
  if (!json.is_array())
    return fail(ErrorCode::kInvalidData, "{}: {}: expected a list", file, path);
  std::vector<SceneGeometry> entries;
  for (std::size_t i = 0; i < json.size(); ++i) {
    VOLUTE_ASSIGN(auto entry, parseEntry(json[i], file, fmt::format("{}/{}", path, i)));
    entries.push_back(std::move(entry));
  }
  return entries;
}

Result<TriangleScene> loadGeometry(const std::vector<SceneGeometry>& entries,
                                   const Reading& reading) {
  TriangleMesh all;
  for (const SceneGeometry& entry : entries) {
    VOLUTE_ASSIGN(const auto mesh, readSurfaces(entry.file, reading.maxMemory));
    const auto first = static_cast<std::uint32_t>(all.materials.size());
    for (Triangle triangle : transformed(mesh.triangles, entry.transform)) {
      triangle.material += first;
      all.triangles.push_back(triangle);
    }
    all.materials.insert(all.materials.end(), mesh.materials.begin(), mesh.materials.end());
  }
  return TriangleScene::build(std::move(all.triangles), std::move(all.materials));
}

}  // namespace volute
