// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/geometry_file.hpp"

#include <cmath>

#include "volute/fds/frame_scan.hpp"

namespace volute {
namespace {

constexpr int kMaxHeaderWords = 1 << 20;

/// Numbers of vertices, triangles and tetrahedra.
Result<std::array<std::int32_t, 3>> geometryCounts(const FortranFile& file, std::uint64_t& offset) {
  std::array<std::int32_t, 3> counts{};
  float time = 0;
  const std::uint64_t begin = offset;
  VOLUTE_ASSIGN(offset, file.readInto(offset, std::span(&time, 1), "the time"));
  VOLUTE_ASSIGN(offset, file.readInto(offset, std::span(counts), "the numbers of triangles"));
  for (const std::int32_t count : counts) {
    // Before memory is taken for them.
    if (count < 0 || static_cast<std::uint64_t>(count) * 12 > file.size()) {
      return fail(ErrorCode::kInvalidData,
                  "{}: byte {}: {} vertices, {} triangles and {} tetrahedra in {} bytes: the file "
                  "is damaged",
                  file.path().string(), begin, counts[0], counts[1], counts[2], file.size());
    }
  }
  return counts;
}

}  // namespace

Result<FdsGeometry> readGeometryFile(const std::filesystem::path& path) {
  VOLUTE_ASSIGN(const auto file, FortranFile::open(path));
  std::uint64_t offset = 0;
  VOLUTE_TRY(readCount(file, offset, "the header's first word", 1, 1));
  VOLUTE_ASSIGN(const int version, readCount(file, offset, "the version", 0, 1 << 30));
  if (version != 2) {
    return fail(ErrorCode::kUnsupported, "{}: is of version {} of geometry files; expected 2",
                path.string(), version);
  }
  std::array<std::int32_t, 3> header{};  // numbers of more words, and whether something stays
  VOLUTE_ASSIGN(offset, file.readInto(offset, std::span(header), "the header"));
  for (int i = 0; i < 2; ++i) {
    if (header[i] < 0 || header[i] > kMaxHeaderWords) {
      return fail(ErrorCode::kInvalidData, "{}: its header has {} more words: the file is damaged",
                  path.string(), header[i]);
    }
    if (header[i] > 0) {
      VOLUTE_ASSIGN(offset, file.skip(offset, 4 * static_cast<std::uint64_t>(header[i]),
                                      "more words of the header"));
    }
  }
  if (header[2] != 0 && header[2] != 1) {
    return fail(ErrorCode::kInvalidData,
                "{}: its header says {} where it says 1 of what stays: "
                "the file is damaged",
                path.string(), header[2]);
  }
  FdsGeometry read;
  if (header[2] == 1) {
    VOLUTE_ASSIGN(const auto counts, geometryCounts(file, offset));
    read.vertices.resize(static_cast<std::size_t>(counts[0]));
    read.triangles.resize(static_cast<std::size_t>(counts[1]));
    read.surfaces.resize(read.triangles.size());
    if (counts[0] > 0) {
      VOLUTE_ASSIGN(offset, file.readInto(offset, std::span(read.vertices), "the vertices"));
    }
    if (counts[1] > 0) {
      const auto triangles = static_cast<std::uint64_t>(counts[1]);
      VOLUTE_ASSIGN(offset, file.readInto(offset, std::span(read.triangles), "the triangles"));
      VOLUTE_ASSIGN(offset, file.readInto(offset, std::span(read.surfaces), "the surfaces"));
      VOLUTE_ASSIGN(offset, file.skip(offset, 24 * triangles, "places of textures"));
    }
    if (counts[2] > 0) {
      const auto volumes = static_cast<std::uint64_t>(counts[2]);
      VOLUTE_ASSIGN(offset, file.skip(offset, 16 * volumes, "the tetrahedra"));
      VOLUTE_ASSIGN(offset, file.skip(offset, 4 * volumes, "the materials"));
    }
  }
  if (offset < file.size()) {
    const auto moving = geometryCounts(file, offset);  // a case that runs may end within them
    if (!moving && moving.error().code != ErrorCode::kTruncated)
      return tl::unexpected(moving.error());
    read.moves = moving && (*moving)[1] > 0;
  }
  for (std::size_t i = 0; i < read.vertices.size(); ++i) {
    const auto& [x, y, z] = read.vertices[i];
    if (!std::isfinite(x) || !std::isfinite(y) || !std::isfinite(z)) {
      return fail(ErrorCode::kInvalidData, "{}: vertex {} is at {}, {}, {}: the file is damaged",
                  path.string(), i + 1, x, y, z);
    }
  }
  const auto vertices = static_cast<std::int32_t>(read.vertices.size());
  for (auto& triangle : read.triangles) {
    for (std::int32_t& corner : triangle) {
      if (corner < 1 || corner > vertices) {
        return fail(ErrorCode::kInvalidData,
                    "{}: a triangle of vertex {}, where there are {}: the file is damaged",
                    path.string(), corner, vertices);
      }
      --corner;  // Fortran counts from 1
    }
  }
  return read;
}

}  // namespace volute
