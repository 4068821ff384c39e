// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/iso_file.hpp"

#include <algorithm>
#include <cmath>

#include "volute/fds/frame_scan.hpp"

namespace volute {
namespace {

constexpr int kMaxLevels = 1000;
constexpr int kMaxWords = 1 << 20;  // of the header's list of whole numbers

/// A mesh and a cell around it.
Box3 roomOf(const FdsMesh& mesh) {
  Box3 room = mesh.bounds();
  for (int axis = 0; axis < 3; ++axis) {
    const auto& planes = mesh.planes[axis];
    room.min[axis] -= planes[1] - planes[0];
    room.max[axis] += planes.back() - planes[planes.size() - 2];
  }
  return room;
}

}  // namespace

Result<FdsIsoFile> FdsIsoFile::open(const FdsIsoEntry& entry, const FdsMesh& mesh) {
  VOLUTE_ASSIGN(auto opened, FortranFile::open(entry.file));
  FdsIsoFile iso(std::move(opened));
  iso.room_ = roomOf(mesh);
  VOLUTE_ASSIGN(const std::uint64_t offset, iso.readHeader());
  const FortranFile& file = iso.file_;
  VOLUTE_TRY(scanFrames(
      file, offset, iso.frames_, [&](std::uint64_t& place, std::size_t frame) -> Result<double> {
        std::array<float, 2> head{};  // the time, and a whole number without a meaning here
        const std::uint64_t begin = place;
        VOLUTE_ASSIGN(place, file.readInto(place, std::span(head), frameName("time", frame)));
        VOLUTE_ASSIGN(const double time, checkedTime(file, begin, frame, head[0]));
        VOLUTE_ASSIGN(const auto sizes, iso.readSizes(place, frame));
        const auto vertices = static_cast<std::uint64_t>(sizes[0]);
        const auto triangles = static_cast<std::uint64_t>(sizes[1]);
        if (vertices > 0) {
          VOLUTE_ASSIGN(place, file.skip(place, 12 * vertices, frameName("vertices", frame)));
        }
        if (triangles > 0) {
          VOLUTE_ASSIGN(place, file.skip(place, 12 * triangles, frameName("triangles", frame)));
          VOLUTE_ASSIGN(place, file.skip(place, 4 * triangles, frameName("levels", frame)));
        }
        return time;
      }));
  for (std::size_t frame = 0; frame < iso.frames_.times.size(); ++frame) {
    std::uint64_t place = iso.frames_.offsets[frame];
    VOLUTE_ASSIGN(place, file.skip(place, 8, frameName("time", frame)));
    VOLUTE_ASSIGN(const auto sizes, iso.readSizes(place, frame));
    iso.words_.push_back(3 * static_cast<std::uint64_t>(sizes[0]) +
                         4 * static_cast<std::uint64_t>(sizes[1]));
  }
  return iso;
}

Result<std::uint64_t> FdsIsoFile::readHeader() {
  std::uint64_t offset = 0;
  VOLUTE_TRY(readCount(file_, offset, "the header's first word", 1, 1));
  VOLUTE_ASSIGN(const int version, readCount(file_, offset, "the version", 0, 1 << 30));
  if (version != 1) {
    return fail(ErrorCode::kUnsupported, "{}: is of version {} of isosurface files; expected 1",
                file_.path().string(), version);
  }
  VOLUTE_ASSIGN(const int levels, readCount(file_, offset, "the number of levels", 0, kMaxLevels));
  levels_.resize(static_cast<std::size_t>(levels));
  if (levels > 0) {
    VOLUTE_ASSIGN(offset, file_.readInto(offset, std::span(levels_), "the levels"));
  }
  for (const float level : levels_) {
    if (!std::isfinite(level)) {
      return fail(ErrorCode::kInvalidData, "{}: a level of its surfaces is {}: the file is damaged",
                  file_.path().string(), level);
    }
  }
  VOLUTE_ASSIGN(const int words, readCount(file_, offset, "a number of words", 0, kMaxWords));
  if (words > 0) {
    VOLUTE_ASSIGN(offset, file_.skip(offset, 4 * static_cast<std::uint64_t>(words), "the words"));
  }
  std::array<std::int32_t, 2> fixed{};
  VOLUTE_ASSIGN(offset, file_.readInto(offset, std::span(fixed), "the number of fixed triangles"));
  if (fixed != std::array<std::int32_t, 2>{}) {
    return fail(ErrorCode::kUnsupported,
                "{}: has {} vertices and {} triangles that stay; expected none, as FDS writes it",
                file_.path().string(), fixed[0], fixed[1]);
  }
  return offset;
}

Result<std::array<std::int32_t, 2>> FdsIsoFile::readSizes(std::uint64_t& offset,
                                                          std::size_t frame) const {
  std::array<std::int32_t, 2> sizes{};
  const std::uint64_t begin = offset;
  VOLUTE_ASSIGN(offset, file_.readInto(offset, std::span(sizes), frameName("sizes", frame)));
  if (sizes[0] < 0 || sizes[1] < 0 || (sizes[1] > 0 && (sizes[0] == 0 || levels_.empty()))) {
    return fail(ErrorCode::kInvalidData,
                "{}: byte {}: frame {} has {} triangles of {} vertices and {} levels: the file is "
                "damaged",
                file_.path().string(), begin + 4, frame, sizes[1], sizes[0], levels_.size());
  }
  return sizes;
}

Result<FdsIsoFrame> FdsIsoFile::readFrame(std::size_t frame) const {
  std::uint64_t offset = frames_.offsets[frame];
  VOLUTE_ASSIGN(offset, file_.skip(offset, 8, frameName("time", frame)));
  VOLUTE_ASSIGN(const auto sizes, readSizes(offset, frame));
  FdsIsoFrame read;
  read.vertices.resize(static_cast<std::size_t>(sizes[0]));
  read.triangles.resize(static_cast<std::size_t>(sizes[1]));
  read.levels.resize(read.triangles.size());
  if (!read.vertices.empty()) {
    VOLUTE_ASSIGN(offset,
                  file_.readInto(offset, std::span(read.vertices), frameName("vertices", frame)));
  }
  if (!read.triangles.empty()) {
    VOLUTE_ASSIGN(offset,
                  file_.readInto(offset, std::span(read.triangles), frameName("triangles", frame)));
    VOLUTE_ASSIGN(offset,
                  file_.readInto(offset, std::span(read.levels), frameName("levels", frame)));
  }
  const auto wrong = [&](const std::string& what) {
    return fail(ErrorCode::kInvalidData, "{}: frame {} (t = {} s): {}: the file is damaged",
                file_.path().string(), frame, frames_.times[frame], what);
  };
  for (const auto& [x, y, z] : read.vertices) {
    if (!room_.contains(Vec3(x, y, z)))
      return wrong(fmt::format("a vertex at {}, {}, {} m, outside of the mesh", x, y, z));
  }
  for (auto& triangle : read.triangles) {
    for (std::int32_t& corner : triangle) {
      if (corner < 1 || corner > sizes[0])
        return wrong(fmt::format("a triangle of vertex {}, where there are {}", corner, sizes[0]));
      --corner;  // Fortran counts from 1
    }
  }
  for (std::int32_t& level : read.levels) {
    if (level < 1 || level > static_cast<std::int32_t>(levels_.size()))
      return wrong(
          fmt::format("a triangle of level {}, where there are {}", level, levels_.size()));
    --level;
  }
  return read;
}

}  // namespace volute
