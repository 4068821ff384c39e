// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_voxels.hpp"

#include <cmath>
#include <cstdint>

#include "volute/gl/gl_device.hpp"
#include "volute/grid/brick_slice.hpp"

namespace volute {

CellGrid cellsOf(const Box3& bounds, const std::array<int, 3>& voxels, Basis basis) {
  const Vec3 voxel = bounds.size().cwiseQuotient(Vec3(voxels[0], voxels[1], voxels[2]));
  if (basis == Basis::kBox)
    return {bounds.min, voxel, voxels};
  return {bounds.min - 0.5 * voxel, voxel, {voxels[0] + 1, voxels[1] + 1, voxels[2] + 1}};
}

Box3 turnedBounds(const CellGrid& cells, const Mat3& turn, const Vec3& offset) {
  const Vec3 size = cells.cell.cwiseProduct(Vec3(cells.count[0], cells.count[1], cells.count[2]));
  Box3 box;
  for (int i = 0; i < 8; ++i) {
    const Vec3 share(i & 1, i >> 1 & 1, i >> 2);
    box.extend(turn * (cells.origin + size.cwiseProduct(share)) + offset);
  }
  return box;
}

void bindCells(const GlProgram& program, const std::string& prefix, const Vec3& origin,
               const CellGrid& cells, const CellRange& range, double emission, double extinction,
               const Mat3& turn, const Vec3& offset) {
  const auto name = [&](const char* rest) { return prefix + rest; };
  const Vec3 unturned = turn.transpose() * (origin - offset);
  const Vec3 inCells = (unturned - cells.origin).cwiseQuotient(cells.cell);
  program.set(name("origin").c_str(), inCells);
  program.set(name("turn").c_str(), Mat3(turn.transpose()));
  program.set(name("perMetre").c_str(), Vec3(cells.cell.cwiseInverse()));
  program.set(name("lo").c_str(), range.begin);
  program.set(name("hi").c_str(), range.end);
  program.set(name("emission").c_str(), static_cast<float>(emission));
  program.set(name("extinction").c_str(), static_cast<float>(extinction));
}

namespace {

/// How many bricks stand side by side on each axis of an atlas, for `count` of them.
Result<std::array<int, 3>> arrange(std::int64_t count, int side, int height) {
  GLint most = 0;
  glGetIntegerv(GL_MAX_3D_TEXTURE_SIZE, &most);
  const int across = most / side;
  const int up = most / height;
  const auto cube = static_cast<int>(std::ceil(std::cbrt(static_cast<double>(count))));
  const int x = std::clamp(cube, 1, across);
  const int y = std::clamp<int>(static_cast<int>((count + x - 1) / x), 1, x);
  std::int64_t z = (count + std::int64_t{x} * y - 1) / (std::int64_t{x} * y);
  if (z > up) {
    return fail(
        ErrorCode::kTooLarge,
        "a volume has {} bricks that are not empty, and the graphics device's textures hold "
        "{}; render with --renderer cpu",
        count, std::int64_t{across} * across * up);
  }
  return std::array<int, 3>{x, y, static_cast<int>(std::max<std::int64_t>(z, 1))};
}

}  // namespace

GlTexture GlBricks::makeAtlas(GLenum format) const {
  return makeTexture3d(format, arranged[0] * side, arranged[1] * side, arranged[2] * height);
}

Result<GlBricks> makeGlBricks(const CellGrid& cells, int side, int height, const MarchGrid& grid) {
  constexpr int kCells = BrickSlice::kSide;
  GlBricks made;
  made.cells = cells, made.range = {cells.count, {0, 0, 0}};
  made.side = side, made.height = height;
  std::array<int, 3> count{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    count[axis] = (cells.count[axis] + kCells - 1) / kCells;
  made.stored = static_cast<std::size_t>(grid.stored);
  for (const BrickSlice::Entry& entry : grid.bricks) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      made.range.begin[axis] = std::min(made.range.begin[axis], entry.place[axis] * kCells);
      made.range.end[axis] = std::max(
          made.range.end[axis], std::min((entry.place[axis] + 1) * kCells, cells.count[axis]));
    }
  }
  VOLUTE_ASSIGN(made.arranged, arrange(static_cast<std::int64_t>(made.stored), side, height));
  VOLUTE_TRY(checkTextureSize("a volume's table of bricks", count[0], count[1], count[2]));
  std::vector<std::int32_t> numbers(static_cast<std::size_t>(count[0]) *
                                        static_cast<std::size_t>(count[1]) *
                                        static_cast<std::size_t>(count[2]),
                                    BrickTable::kEmpty);
  for (const auto& [place, stored] : grid.bricks) {
    const std::size_t row =
        static_cast<std::size_t>(place[2]) * static_cast<std::size_t>(count[1]) +
        static_cast<std::size_t>(place[1]);
    numbers[row * static_cast<std::size_t>(count[0]) + static_cast<std::size_t>(place[0])] = stored;
  }
  made.table = makeTexture3d(GL_R32I, count[0], count[1], count[2]);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTextureSubImage3D(made.table.name(), 0, 0, 0, 0, count[0], count[1], count[2], GL_RED_INTEGER,
                      GL_INT, numbers.data());
  return made;
}

}  // namespace volute
