// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <vector>

#include "volute/tomography/beam_kernels.hpp"
#include "volute/tomography/ray_kernels.hpp"
#include "volute/tomography/support.hpp"
#include "volute/tomography/view.hpp"

namespace volute {

/// A pixel that takes part.
struct PixelRow {
  std::int32_t view;
  std::int32_t pixel;  ///< y * width + x
};

/// The pixels of a camera that take part: those not 0 in `mask`; all if it is empty.
struct ProjectorView {
  const Camera* camera = nullptr;
  std::span<const std::uint8_t> mask{};
};

/// The matrix S of p - b = S a (Ahrenberg et al. 2005, equation 5) and its transpose, in float, on
/// all threads, with the same result for any number of them. Colours go together: vectors hold four
/// floats R G B 0 for each unknown or pixel. Rows are the pixels whose rays meet an unknown, view
/// by view.
///
/// Rays are walked anew in each product: the rays of a pixel together as a beam, or one by one
/// where they are too far apart for that, and with the box basis. Where the weights of all rows fit
/// into `tableBytes`, they are written down at the start instead, by rows and by unknowns, which
/// pays after a few products.
class Projector {
 public:
  Projector(std::span<const ProjectorView> views, std::shared_ptr<const Support> support,
            int raysPerPixel, std::uint64_t tableBytes);

  /// Any lines, of which each that meets an unknown is a row: pixel i of view 0 is line i. They end
  /// where their segments do.
  Projector(std::span<const Segment> lines, std::shared_ptr<const Support> support,
            std::uint64_t tableBytes);

  std::size_t unknowns() const { return support_->size(); }

  std::size_t rows() const { return rows_.size(); }

  std::span<const PixelRow> pixels() const { return rows_; }

  const Support& support() const { return *support_; }

  bool usesTable() const { return !byRow_.begin.empty(); }

  /// What one product holds besides its arguments [bytes]: copies of the unknowns with zeros around
  /// and a gradient for each chunk of rows. 0 with a table.
  std::uint64_t productBytes() const;

  /// Rows whose rays walk together; 0 with a table.
  std::size_t beams() const { return beamRows_.size(); }

  /// pixels = S unknowns.
  void forward(std::span<const float> unknowns, std::span<float> pixels) const;

  /// unknowns = S' pixels.
  void adjoint(std::span<const float> pixels, std::span<float> unknowns) const;

  /// back[0..3] = what is to be spread along the rays of a row, from sum[0..3].
  using Turn = std::function<void(std::size_t row, const float* sum, float* back)>;

  /// pixels = S unknowns, and result = S' turn(pixels), in one walk. `turn` is called from several
  /// threads.
  void thereAndBack(std::span<const float> unknowns, const Turn& turn, std::span<float> pixels,
                    std::span<float> result) const;

 private:
  /// Rows that are summed up on their own. They are added in order, so that the threads do not
  /// matter. All go through the same of the two lattices: that of the support, or the same with x
  /// and y exchanged.
  struct Chunk {
    bool turned = false;
    std::size_t firstBeam = 0, lastBeam = 0;
    std::size_t firstLoose = 0, lastLoose = 0;      ///< in looseRows_; none when turned
    std::int32_t firstNode = 0, lastNode = 0;       ///< what they reach
    std::size_t firstUnknown = 0, lastUnknown = 0;  ///< of the planes that they reach

    std::size_t beams() const { return lastBeam - firstBeam; }
  };

  /// A sparse matrix: row i has the weights [begin[i], begin[i+1]).
  struct Table {
    std::vector<std::uint64_t> begin;
    std::vector<NodeWeight> weights;
  };

  /// Working memory of products: taking it anew each time costs as much as a walk.
  struct Scratch {
    std::array<std::vector<float>, 2> lattice;  ///< the unknowns with zeros around, and turned
    std::vector<std::vector<float>> parts;      ///< each chunk's gradient
  };

  class ScratchUse;
  struct TurnContext;

  BeamRange beamsOf(const Chunk& chunk) const {
    return {beamFields_, chunk.firstBeam, chunk.beams()};
  }

  void addView(int view, const ProjectorView& what);
  void addLines(std::span<const Segment> lines);
  void finish(std::uint64_t tableBytes);
  std::vector<std::int32_t> rowPlanes() const;
  void cutChunks();
  void reach(Chunk& chunk) const;
  bool writeTables(std::uint64_t bytes);
  void writeTable(std::size_t firstRow, std::size_t lastRow,
                  std::span<const std::int32_t> unknownAt, Table& table) const;
  void transposeTable();
  void multiply(const Table& table, std::span<const float> values, std::span<float> sums) const;
  void toLattices(std::span<const float> unknowns, Scratch& scratch) const;
  void rawWeights(std::size_t first, std::size_t count,
                  std::span<std::vector<NodeWeight>> raw) const;
  static std::vector<float> valuesOf(std::span<const std::uint32_t> rowOf,
                                     std::span<const float> pixels);
  void putRows(const Chunk& chunk, std::span<const float> sums, std::span<float> pixels) const;
  void forwardLoose(std::size_t first, std::size_t last, const float* lattice,
                    std::span<float> pixels) const;
  void adjointLoose(const Chunk& chunk, std::span<const float> pixels, float* gradient) const;
  void turnLoose(const Chunk& chunk, const Turn& turn, const float* lattice,
                 std::span<float> pixels, float* gradient) const;
  template <class Work>
  void sumChunks(std::vector<std::vector<float>>& parts, std::span<float> unknowns,
                 Work&& work) const;
  std::span<const std::int32_t> latticeNodes(bool turned) const;
  void addParts(std::span<const std::vector<float>> parts, std::span<float> unknowns) const;

  std::shared_ptr<const Support> support_;
  int raysPerPixel_;
  WalkLattice lattice_;
  std::vector<std::int32_t> turnedNodes_;  ///< of the unknowns; empty when no beam is turned
  std::vector<PixelRow> rows_;
  // Of each row either a beam or loose rays; in the order of the chunks once those are cut.
  std::vector<std::uint32_t> beamRows_;  ///< of each beam
  BeamFields beamFields_;
  std::vector<Beam> beams_;         ///< while chunks or tables are made, as all beams may be needed
  std::vector<BeamRay> beamRays_;   ///< raysPerPixel for each of these
  std::vector<WalkRay> looseRays_;  ///< raysPerPixel for each loose row
  std::vector<std::uint32_t> looseRows_;
  std::vector<Chunk> chunks_;
  Table byRow_, byUnknown_;  ///< empty without a table
  mutable std::mutex scratchMutex_;
  mutable Scratch scratch_;
};

/// The ray of a segment through the cells that unknowns reach into; length 0 when it meets none.
WalkRay walkRay(const Support& support, const Segment& segment, const TouchedPart& touched);

}  // namespace volute
