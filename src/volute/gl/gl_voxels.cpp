// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/gl/gl_voxels.hpp"

#include <cmath>
#include <cstdint>
#include <set>

#include "volute/gl/gl_device.hpp"
#include "volute/grid/brick_slice.hpp"
#include "volute/medium/affine_medium.hpp"

namespace volute {

CellGrid cellsOf(const Box3& bounds, const std::array<int, 3>& voxels, Basis basis) {
  const Vec3 voxel = bounds.size().cwiseQuotient(Vec3(voxels[0], voxels[1], voxels[2]));
  if (basis == Basis::kBox)
    return {bounds.min, voxel, voxels};
  return {bounds.min - 0.5 * voxel, voxel, {voxels[0] + 1, voxels[1] + 1, voxels[2] + 1}};
}

Box3 turnedBounds(const CellGrid& cells, const Mat3& turn, const Vec3& offset) {
  const Vec3 size = cells.cell.cwiseProduct(Vec3(cells.count[0], cells.count[1], cells.count[2]));
  return AffineMap(turn, offset).around({cells.origin, cells.origin + size});
}

void bindCells(const GlProgram& program, const std::string& prefix, const Vec3& origin,
               const CellGrid& cells, const CellRange& range, double emission, double extinction,
               const Mat3& turn, const Vec3& offset) {
  const auto name = [&](const char* rest) { return prefix + rest; };
  const AffineMap place(turn, offset);
  std::array<int, 3> base{}, low{}, high{};
  Vec3 first;  // the corner that cells are counted from
  for (std::size_t axis = 0; axis < 3; ++axis) {
    base[axis] = std::max(range.begin[axis] >> 3, 0);
    low[axis] = range.begin[axis] - 8 * base[axis], high[axis] = range.end[axis] - 8 * base[axis];
    first[axis] = cells.plane(static_cast<int>(axis), 8 * base[axis]);
  }
  const Vec3 inCells = (place.toOwn(origin) - first).cwiseQuotient(cells.cell);
  program.set(name("base").c_str(), base);
  program.set(name("origin").c_str(), inCells);
  program.set(name("turn").c_str(), place.inverse());
  program.set(name("perMetre").c_str(), Vec3(cells.cell.cwiseInverse()));
  program.set(name("lo").c_str(), low);
  program.set(name("hi").c_str(), high);
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
        ErrorCode::kTooLarge, Hint::set("renderer", "cpu"),
        "a volume has {} bricks that are not empty, and the graphics device's textures hold "
        "{}",
        count, std::int64_t{across} * across * up);
  }
  return std::array<int, 3>{x, y, static_cast<int>(std::max<std::int64_t>(z, 1))};
}

}  // namespace

GlTexture GlBricks::makeAtlas(GLenum format) const {
  return makeTexture3d(format, arranged[0] * side, arranged[1] * side, arranged[2] * height);
}

namespace {

/// Of a ray: it meets no more cells, or empty parts of tables, than lie behind each other along the
/// axes.
double mostCellsOf(const MarchGrid& grid, const CellGrid& cells, const CellRange& range) {
  double all = 3, passed = 3;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    all += range.end[axis] - range.begin[axis];
    constexpr int kBits = BrickTable::kNodeBits;
    std::set<int> places;
    for (const BrickSlice::Entry& entry : grid.bricks) places.insert(entry.place[axis] + 1);
    for (int level = 0; level < grid.table.levels(); ++level) {
      passed += static_cast<double>(places.size() << kBits);
      std::set<int> above;
      for (const int place : places) above.insert(place >> kBits);
      places = std::move(above);
    }
    passed += cells.count[axis] >> kBits * grid.table.levels();
  }
  return std::min(all, passed);
}

}  // namespace

void GlBricks::bind(const GlProgram& program, const std::string& prefix,
                    GlBindings& bindings) const {
  program.set((prefix + "atlasBricks").c_str(), arranged);
  program.set((prefix + "levels").c_str(), levels);
  program.set((prefix + "topStride").c_str(), topStride);
  program.set((prefix + "bricks").c_str(), bindings.texture);
  glBindTextureUnit(static_cast<GLuint>(bindings.texture++), table.name());
}

Result<GlBricks> makeGlBricks(const CellGrid& cells, int side, int height, const MarchGrid& grid) {
  constexpr int kCells = BrickSlice::kSide;
  GlBricks made;
  made.cells = cells, made.range = {cells.count, {0, 0, 0}};
  made.side = side, made.height = height;
  made.stored = static_cast<std::size_t>(grid.stored);
  for (const BrickSlice::Entry& entry : grid.bricks) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      made.range.begin[axis] = std::min(made.range.begin[axis], entry.place[axis] * kCells);
      made.range.end[axis] = std::max(
          made.range.end[axis], std::min((entry.place[axis] + 1) * kCells, cells.count[axis]));
    }
  }
  VOLUTE_ASSIGN(made.arranged, arrange(static_cast<std::int64_t>(made.stored), side, height));
  made.levels = grid.table.levels(), made.topStride = grid.table.topStride();
  made.mostCells = mostCellsOf(grid, cells, made.range);
  constexpr int kSide = 1024;  // as volume_table.glsl has it
  const auto entries = grid.table.entries();
  const auto layers = static_cast<int>((entries.size() - 1) / (kSide * kSide)) + 1;
  const auto rows = layers > 1 ? kSide : static_cast<int>((entries.size() - 1) / kSide) + 1;
  VOLUTE_TRY(checkTextureSize("a volume's table of bricks", kSide, rows, layers));
  std::vector<std::int32_t> all(entries.begin(), entries.end());
  all.resize(static_cast<std::size_t>(layers) * static_cast<std::size_t>(rows) * kSide);
  made.table = makeTexture3d(GL_R32I, kSide, rows, layers);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  glTextureSubImage3D(made.table.name(), 0, 0, 0, 0, kSide, rows, layers, GL_RED_INTEGER, GL_INT,
                      all.data());
  return made;
}

}  // namespace volute
