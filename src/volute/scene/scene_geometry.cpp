// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/scene/scene_geometry.hpp"

#include <nlohmann/json.hpp>
#include <utility>

#include "volute/base/file_name.hpp"
#include "volute/io/surface_file.hpp"
#include "volute/media/field_members.hpp"
#include "volute/media/placement.hpp"

namespace volute {
namespace {

/// +y of the file becomes +z, as in glTF's own convention: (x, y, z) -> (x, -z, y).
Mat4 yUpwards() {
  return affine(Mat3(1, 0, 0, 0, 0, -1, 0, 1, 0), Vec3::Zero());
}

FieldValue geometryTransform(const SceneGeometry& entry) {
  return transformValue(entry.transform);
}

Status setGeometryTransform(SceneGeometry& entry, const FieldValue& value) {
  VOLUTE_ASSIGN(entry.transform, transformFrom(value));
  return {};
}

bool isYUp(const SceneGeometry& entry, const TriangleMesh& mesh) {
  const std::string extension = extensionOf(entry.file);
  const bool gltf = extension == ".glb" || extension == ".gltf";
  return entry.up == UpAxis::kY || (entry.up == UpAxis::kFormat && (gltf || mesh.up == 'y'));
}

FieldValue geometryFile(const SceneGeometry& entry) {
  return entry.file;
}

Status setGeometryFile(SceneGeometry& entry, const FieldValue& value) {
  entry.file = value.get<std::string>();
  if (isSurfacePath(entry.file))
    return {};
  return fail(
      ErrorCode::kInvalidData,
      "'{}' is not a known geometry format; expected .glb, .gltf, .obj, .vtp, .vdb or .nvdb",
      entry.file);
}

}  // namespace

const FieldTable& geometryFields() {
  using enum FieldType;
  static constexpr std::string_view kUps[] = {"format", "y", "z"};
  // clang-format off: a row is read as one
  static const FieldRow kFields[] = {
      {.name = "file", .type = kFile,
       .access = customMember<SceneGeometry, geometryFile, setGeometryFile>(),
       .help = ".glb, .gltf, .obj, .vtp, or the level set of a .vdb or .nvdb", .required = true},
      {.name = "transform", .type = kNumbers,
       .access = customMember<SceneGeometry, geometryTransform, setGeometryTransform>(),
       .help = "affine, row-major, last row 0, 0, 0, 1", .count = 16},
      {.name = "up", .type = kChoice, .access = member<&SceneGeometry::up>(),
       .help = "up axis of the file; y turns its +y upwards before the transform; format: y of .glb "
               "and .gltf, as glTF has it, and of level sets by programs with y upwards; z of the others",
       .choices = kUps, .older = "z"}};
  // clang-format on
  static const FieldTable kTable = fieldTable<SceneGeometry>(
      {.name = "geometry", .sentence = "opaque surfaces", .fields = kFields});
  return kTable;
}

Result<TriangleScene> loadGeometry(const std::vector<SceneGeometry>& entries,
                                   const Reading& reading) {
  TriangleMesh all;
  for (const SceneGeometry& entry : entries) {
    VOLUTE_ASSIGN(auto mesh, readSurfaces(entry.file, reading.maxMemory));
    for (const std::string& remark : mesh.remarks)
      reading.progress.remark({RemarkCode::kDoubtful, fmt::format("{}: {}", entry.file, remark)});
    // A million triangles are 80 MB, and each copy of them costs as much as reading them.
    const bool turned = isYUp(entry, mesh);
    if (turned && entry.up == UpAxis::kFormat && mesh.up == 'y')
      reading.progress.remark(
          Remark(RemarkCode::kAssumed,
                 fmt::format("{}: its y is turned upwards, as it was written by a program whose y "
                             "points there; \"up\": \"z\" leaves it",
                             entry.file))
              .in(entry.file));
    const Mat4 placed = turned ? Mat4(entry.transform * yUpwards()) : entry.transform;
    if (placed != Mat4::Identity()) {
      mesh.triangles = transformed(mesh.triangles, placed);
      for (CurvedPart& part : mesh.curved) part.surface = part.surface->moved(placed);
    }
    if (all.materials.empty()) {
      all = std::move(mesh);
      continue;
    }
    append(all, std::move(mesh));
  }
  return TriangleScene::of(std::move(all));
}

}  // namespace volute
