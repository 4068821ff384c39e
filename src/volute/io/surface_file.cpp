// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/surface_file.hpp"

#include <algorithm>
#include <cstring>
#include <sstream>
#include <string>

#include "volute/base/assert.hpp"
#include "volute/base/file_name.hpp"
#include "volute/base/input_file.hpp"
#include "volute/base/printable.hpp"
#include "volute/io/lattice_source.hpp"
#include "volute/io/level_set_surface.hpp"
#include "volute/io/obj.hpp"
#include "volute/io/plugin.hpp"
#include "volute/io/reader_process.hpp"
#include "volute/io/volume_source.hpp"

namespace volute {
namespace {

/// How much a file holds, as it crosses from the child.
struct SurfaceSize {
  std::uint64_t triangles = 0, materials = 0;

  std::size_t floats() const {
    return (triangles * sizeof(Triangle) + materials * sizeof(Material)) / sizeof(float);
  }
};

/// The child's side: the first call reads the file and says how much it is, the second hands it
/// over.
Result<ReaderProcess::Serve> serveSurfaces(std::string_view parameters) {
  const std::filesystem::path file(parameters);
  const bool gltf = extensionOf(file) != ".vtp";
  VOLUTE_ASSIGN(const SurfacePlugin* plugin, gltf ? loadGltfPlugin() : loadVtkSurfacePlugin());
  return [file, plugin, mesh = std::shared_ptr<TriangleMesh>()](
             std::string_view, std::span<float> values) mutable -> Result<std::string> {
    if (!mesh) {
      VOLUTE_ASSIGN(auto read, plugin->read(file));
      mesh = std::make_shared<TriangleMesh>(std::move(read));
      const SurfaceSize size{mesh->triangles.size(), mesh->materials.size()};
      std::string reply = toMessage(size);
      for (const std::string& remark : mesh->remarks) reply += remark + '\n';
      return reply;
    }
    auto* to = reinterpret_cast<std::byte*>(values.data());
    const std::size_t bytes = mesh->triangles.size() * sizeof(Triangle);
    if (bytes > 0)
      std::memcpy(to, mesh->triangles.data(), bytes);
    if (!mesh->materials.empty())
      std::memcpy(to + bytes, mesh->materials.data(), mesh->materials.size() * sizeof(Material));
    return std::string();
  };
}

Status checkMemory(const std::string& file, std::uint64_t triangles, std::uint64_t maxMemory) {
  if (triangles <= maxMemory / sizeof(Triangle))
    return {};
  return fail(ErrorCode::kTooLarge, Hint::raise("max_memory"),
              "{}: {} triangles need more than the {} MiB of memory allowed", file, triangles,
              maxMemory >> 20);
}

/// A .vtp is one file; glTF names others below its folder.
ReaderJob surfaceReader(const std::filesystem::path& path) {
  const bool alone = extensionOf(path) == ".vtp";
  const auto folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  return {serveSurfaces, path.string(), {alone ? path : folder}};
}

/// What came from the process that reads the file.
Status checkSurfaces(const TriangleMesh& mesh, const std::string& file) {
  for (const Triangle& triangle : mesh.triangles) {
    if (triangle.material >= mesh.materials.size())
      return fail(ErrorCode::kInvalidData, "{}: a triangle of material {}; there are {}", file,
                  triangle.material, mesh.materials.size());
    for (const Vec3& corner : triangle.corners) {
      if (!corner.allFinite())
        return fail(ErrorCode::kInvalidData, "{}: a triangle with a corner that is no place", file);
    }
  }
  return {};
}

Result<TriangleMesh> readInChild(const std::filesystem::path& path, std::uint64_t maxMemory) {
  const std::string file = path.string();
  VOLUTE_ASSIGN(const auto opened, InputFile::open(path));
  ReaderProcess process(surfaceReader(path));
  const ReaderProcess::Limits limits{.memory = maxMemory,
                                     .seconds = 3 + 1e-6 * static_cast<double>(opened.size())};
  VOLUTE_ASSIGN(const std::string reply, process.call(file, {}, 0, limits));
  const std::size_t head = std::min(reply.size(), sizeof(SurfaceSize));
  VOLUTE_ASSIGN(const auto size, fromMessage<SurfaceSize>(std::string_view(reply).substr(0, head)));
  VOLUTE_TRY(checkMemory(file, size.triangles, maxMemory));
  if (size.materials > maxMemory / sizeof(Material))
    return fail(ErrorCode::kTooLarge, "{}: {} materials are too many", file, size.materials);
  VOLUTE_TRY(process.call(file, {}, size.floats(), limits));
  TriangleMesh mesh;
  mesh.triangles.resize(size.triangles);
  mesh.materials.resize(size.materials);
  const auto* from = reinterpret_cast<const std::byte*>(process.values().data());
  const std::size_t bytes = size.triangles * sizeof(Triangle);
  if (bytes > 0)
    std::memcpy(static_cast<void*>(mesh.triangles.data()), from, bytes);
  if (size.materials > 0)
    std::memcpy(static_cast<void*>(mesh.materials.data()), from + bytes,
                size.materials * sizeof(Material));
  VOLUTE_TRY(checkSurfaces(mesh, file));
  std::istringstream remarks(reply.substr(head));
  for (std::string remark; std::getline(remarks, remark);)
    mesh.remarks.push_back(printable(remark));
  return mesh;
}

Result<TriangleMesh> readLevelSet(const std::filesystem::path& path, std::uint64_t maxMemory) {
  VOLUTE_ASSIGN(const auto grids, listGrids(path, maxMemory));
  const auto found = std::ranges::find_if(grids, [](const GridFacts& grid) {
    return grid.readable && std::string_view(grid.gridClass) == "level set";
  });
  if (found == grids.end()) {
    return fail(ErrorCode::kInvalidData,
                "{}: has no level set; expected one, whose surface is geometry; other grids are "
                "volumes of a scene",
                path.string());
  }
  SourceOptions options;
  options.grid = found->name;
  options.maxMemory = maxMemory;
  VOLUTE_ASSIGN(const auto source, openSource(path, options));
  std::optional<GridMatrix> place;
  if (const auto* placed = dynamic_cast<const PlacedFrames*>(source.get());
      placed && !placed->places().empty())
    place = placed->places().front();
  Bricks bricks;
  VOLUTE_TRY(source->readBricks(0, bricks));
  VOLUTE_ASSIGN(auto surface,
                LevelSetSurface::make(std::move(bricks), source->info(), place, maxMemory));
  TriangleMesh mesh{{}, {Material()}, {{std::move(surface)}}};
  mesh.up = source->info().up;
  return mesh;
}

}  // namespace

bool isSurfacePath(const std::filesystem::path& path) {
  const std::string extension = extensionOf(path);
  return extension == ".glb" || extension == ".gltf" || extension == ".obj" ||
         extension == ".vtp" || isVdbPath(path);
}

Result<TriangleMesh> readSurfaces(const std::filesystem::path& path, std::uint64_t maxMemory) {
  if (!isSurfacePath(path)) {
    return fail(ErrorCode::kUnsupported,
                "{}: no known geometry; expected .glb, .gltf, .obj, .vtp, .vdb or .nvdb",
                path.string());
  }
  if (isVdbPath(path))
    return readLevelSet(path, maxMemory);
  if (extensionOf(path) != ".obj")
    return readInChild(path, maxMemory);
  VOLUTE_ASSIGN(auto mesh, readObj(path, maxMemory));
  VOLUTE_TRY(checkMemory(path.string(), mesh.triangles.size(), maxMemory));
  return mesh;
}

}  // namespace volute
