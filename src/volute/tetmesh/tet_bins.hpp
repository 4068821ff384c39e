// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "volute/tetmesh/tet_mesh.hpp"
#include "volute/tetmesh/tet_raster.hpp"

namespace volute {

/// Tets sorted into a picture's square tiles, in the order in which they came.
class TetBins {
 public:
  /// Those of `order` (empty: all as they are numbered) that are not `dark`.
  TetBins(const TetMesh& mesh, const ScreenView& view, int side, std::span<const char> dark,
          std::span<const std::int32_t> order = {});

  int across() const { return across_; }

  int down() const { return down_; }

  /// Calls use(tets) for a tile's lists, one after the other.
  template <class Use>
  void forEach(std::size_t tile, const Use& use) const {
    for (const Chunk& chunk : chunks_)
      use(std::span<const BinnedTet>(chunk.tets.data() + chunk.begin[tile],
                                     chunk.tets.data() + chunk.begin[tile + 1]));
  }

 private:
  struct Chunk {
    std::vector<BinnedTet> tets;
    std::vector<std::int32_t> begin;  // of each tile, and the end
  };

  void bin(const ScreenView& view, std::span<const char> dark, std::span<const std::int32_t> tets,
           Chunk& chunk) const;

  const TetMesh& mesh_;
  int side_, across_, down_;
  std::vector<SplatVertex> vertices_;
  std::vector<Chunk> chunks_;
};

}  // namespace volute
