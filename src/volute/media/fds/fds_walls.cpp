// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fds/fds_walls.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "volute/fds/geometry_file.hpp"
#include "volute/image/srgb.hpp"

namespace volute {

Result<TriangleMesh> fdsWalls(const SmvIndex& index, std::vector<Remark>& remarks) {
  TriangleMesh mesh;
  for (const FdsSurface& surface : index.surfaces) {
    mesh.materials.push_back({Rgb(srgbDecode(surface.colour[0]), srgbDecode(surface.colour[1]),
                                  srgbDecode(surface.colour[2])),
                              Rgb::Zero()});
  }
  const auto plain = static_cast<std::int32_t>(mesh.materials.size());
  mesh.materials.emplace_back();
  for (const FdsOtherFile& other : index.others) {
    if (other.kind != kFdsWallsKind)
      continue;
    VOLUTE_ASSIGN(const auto read, readGeometryFile(other.file));
    if (read.moves) {
      remarks.push_back({RemarkCode::kLeftOut,
                         fmt::format("{}: walls of triangles that come or move are left out: they "
                                     "block no sight line",
                                     other.file.string())});
    }
    for (std::size_t i = 0; i < read.triangles.size(); ++i) {
      Triangle triangle;
      for (std::size_t corner = 0; corner < 3; ++corner) {
        const auto& [x, y, z] = read.vertices[static_cast<std::size_t>(read.triangles[i][corner])];
        triangle.corners[corner] = Vec3(x, y, z);
      }
      const std::int32_t surface = read.surfaces[i];
      triangle.material =
          static_cast<std::uint32_t>(surface >= 0 && surface < plain ? surface : plain);
      mesh.triangles.push_back(triangle);
    }
  }
  return mesh;
}

}  // namespace volute
