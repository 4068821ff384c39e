// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "volute/tomography/ray_kernels.hpp"
#include "volute/tomography/support.hpp"
#include "volute/tomography/view.hpp"

namespace volute {

/// A pixel that takes part.
struct PixelRow {
  std::int32_t view;
  std::int32_t pixel;  ///< y * width + x
};

/// What of a camera's image takes part: its pixels that are not 0 in `mask`; all when it is empty.
struct ProjectorView {
  const Camera* camera = nullptr;
  std::span<const std::uint8_t> mask{};
};

/// The matrix S of p - b = S a (Ahrenberg et al. 2005, equation 5) and its transpose, in float, on
/// all threads, with the same result for any number of them. Colours go together: vectors hold four
/// floats R G B 0 for each unknown or pixel. Rows are the pixels whose rays meet an unknown, view
/// by view.
///
/// Rays are walked anew in each product. Where the weights of all rows fit into `tableBytes`, they
/// are written down at the start instead, by rows and by unknowns, which pays after a few products:
/// pixels of four rays then cost little more than those of one.
class Projector {
 public:
  Projector(std::span<const ProjectorView> views, std::shared_ptr<const Support> support,
            int raysPerPixel, std::uint64_t tableBytes);

  std::size_t unknowns() const { return support_->size(); }

  std::size_t rows() const { return rows_.size(); }

  std::span<const PixelRow> pixels() const { return rows_; }

  const Support& support() const { return *support_; }

  bool usesTable() const { return !byRow_.begin.empty(); }

  /// Weights in the table; 0 without one.
  std::size_t tableSize() const { return byRow_.weights.size(); }

  /// pixels = S unknowns.
  void forward(std::span<const float> unknowns, std::span<float> pixels) const;

  /// unknowns = S' pixels.
  void adjoint(std::span<const float> pixels, std::span<float> unknowns) const;

 private:
  /// Rows that are summed up on their own. Chunks are added in order, so that the threads do not
  /// matter.
  struct Chunk {
    std::size_t firstRow = 0, lastRow = 0;
    std::int32_t firstNode = 0, lastNode = 0;  ///< what its rays reach in the lattice
  };

  /// A sparse matrix: row i has the weights [begin[i], begin[i+1]).
  struct Table {
    std::vector<std::uint64_t> begin;
    std::vector<NodeWeight> weights;
  };

  /// Working memory of products: taking it anew each time costs as much as a walk.
  struct Scratch {
    std::vector<float> lattice;             ///< the unknowns with zeros around
    std::vector<std::vector<float>> parts;  ///< each chunk's gradient
  };

  class ScratchUse;

  void addView(int view, const ProjectorView& what);
  void cutChunks();
  void reach(Chunk& chunk) const;
  bool writeTables(std::uint64_t bytes);
  void writeTable(const Chunk& chunk, std::span<const std::int32_t> unknownAt, Table& table) const;
  void transposeTable();
  void multiply(const Table& table, std::span<const float> values, std::span<float> sums) const;
  void toLattice(std::span<const float> unknowns, std::vector<float>& lattice) const;
  void addParts(std::span<const std::vector<float>> parts, std::span<float> unknowns) const;

  std::shared_ptr<const Support> support_;
  int raysPerPixel_;
  WalkLattice lattice_;
  std::vector<PixelRow> rows_;
  std::vector<WalkRay> rays_;  ///< raysPerPixel for each row
  std::vector<Chunk> chunks_;
  Table byRow_, byUnknown_;  ///< empty without a table
  mutable std::mutex scratchMutex_;
  mutable Scratch scratch_;
};

/// The ray of a segment through the cells that unknowns reach into; length 0 when it meets none.
WalkRay walkRay(const Support& support, const Segment& segment);

}  // namespace volute
