// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "volute/gl/gl_medium.hpp"
#include "volute/gl/gl_object.hpp"
#include "volute/grid/traversal.hpp"
#include "volute/grid/volume_info.hpp"
#include "volute/grid/voxel_march.hpp"

// What OpenGL's media of voxels share: their cells, and atlases of bricks of 8^3 cells.

namespace volute {

/// Voxels (box), or the cells between their centres (trilinear).
CellGrid cellsOf(const Box3& bounds, const std::array<int, 3>& voxels, Basis basis);

/// Of cells that are turned, then moved [m].
Box3 turnedBounds(const CellGrid& cells, const Mat3& turn, const Vec3& offset);

/// Sets what volume.glsl reads of the cells and their values.
/// @param origin  GlView::origin [m]
/// @param emission, extinction  of one unit of the values [1/m]
void bindCells(const GlProgram& program, const std::string& prefix, const Vec3& origin,
               const CellGrid& cells, const CellRange& range, double emission, double extinction,
               const Mat3& turn, const Vec3& offset);

/// Which bricks of a volume's cells are not empty, and how their atlas is arranged.
struct GlBricks {
  CellGrid cells;
  CellRange range;                ///< the cells of all stored bricks
  std::size_t stored = 0;         ///< bricks
  int side = 0, height = 0;       ///< of a brick in the atlas, along x and y, and along z [texels]
  std::array<int, 3> arranged{};  ///< bricks of the atlas along each axis
  GlTexture table;                ///< R32I: BrickTable::entries()
  int levels = 1;                 ///< of tables
  std::array<std::int32_t, 3> topStride{};
  double mostCells = 0;  ///< that one ray passes, steps over empty bricks with them

  /// Sets what volume_table.glsl reads. Takes a texture.
  void bind(const GlProgram& program, const std::string& prefix, GlBindings& bindings) const;

  /// An empty texture for all stored bricks.
  GlTexture makeAtlas(GLenum format) const;
};

/// Of the bricks that a march reads. kTooLarge where the device's textures hold fewer.
[[nodiscard]] Result<GlBricks> makeGlBricks(const CellGrid& cells, int side, int height,
                                            const MarchGrid& grid);

/// Uploads all bricks of an atlas, a layer of them at a time.
/// @param texelsOf  of a brick by its number: (height, side, side) values, until the next call
template <class Texel, class TexelsOf>
void fillAtlas(const GlBricks& bricks, const GlTexture& atlas, GLenum format, GLenum type,
               TexelsOf&& texelsOf) {
  const auto [columns, rows, layers] = bricks.arranged;
  const auto side = static_cast<std::size_t>(bricks.side);
  const std::size_t perLayer = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  std::vector<Texel> layer(perLayer * side * side * static_cast<std::size_t>(bricks.height));
  glPixelStorei(GL_UNPACK_ALIGNMENT, 4);
  for (int z = 0; z < layers; ++z) {
    const std::size_t first = static_cast<std::size_t>(z) * perLayer;
    for (std::size_t b = first; b < std::min(bricks.stored, first + perLayer); ++b) {
      const std::size_t column = (b - first) % static_cast<std::size_t>(columns);
      const std::size_t row = (b - first) / static_cast<std::size_t>(columns);
      const Texel* from = texelsOf(b);
      for (std::size_t slice = 0; slice < static_cast<std::size_t>(bricks.height); ++slice) {
        for (std::size_t y = 0; y < side; ++y, from += side) {
          const std::size_t line = (slice * static_cast<std::size_t>(rows) + row) * side + y;
          std::copy_n(from, side,
                      &layer[(line * static_cast<std::size_t>(columns) + column) * side]);
        }
      }
    }
    glTextureSubImage3D(atlas.name(), 0, 0, 0, z * bricks.height, columns * bricks.side,
                        rows * bricks.side, bricks.height, format, type, layer.data());
  }
}

}  // namespace volute
