// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "volute/fds/fds_grid.hpp"
#include "volute/medium/medium.hpp"

namespace volute {

/// Extinction [1/m] of one lattice at one time, x fastest. `low` and `high` bound what quantised
/// files may stand for (high may be infinite); empty: `value` is what FDS wrote.
struct FdsValues {
  std::vector<float> value;
  std::vector<float> low;
  std::vector<float> high;
};

/// What a cell of a lattice holds.
enum class FdsCell : std::uint8_t {
  kGas,
  kSolid,    ///< an obstruction: no value
  kUnknown,  ///< gas, but neither stored frame has a value for it
};

/// The optical depth of a segment and what it may be at least and at most.
struct FdsDepth {
  double value = 0;
  double low = 0;
  double high = 0;          ///< may be infinite: a byte at its end
  double uncovered = 0;     ///< [m] of the segment outside of all that the source covers
  double insideSolids = 0;  ///< [m] of the segment inside obstructions
};

/// A snapshot of a case's smoke as a medium: extinction constant in each cell, or trilinear between
/// nodes, zero inside obstructions and outside of the meshes. The light that it scatters towards us
/// is the same everywhere.
///
/// Exact, in double. Cheap to copy: what it holds is shared and const.
class FdsField {
 public:
  /// One entry of `values` and of `cells` for each lattice of `grid`, with as many elements as the
  /// lattice has values and cells, or none where the grid does not hold it. Values at nodes of gas
  /// cells must be finite and >= 0.
  FdsField(std::shared_ptr<const FdsGrid> grid,
           std::vector<std::shared_ptr<const FdsValues>> values,
           std::vector<std::shared_ptr<const std::vector<FdsCell>>> cells);

  /// The same smoke in another light, the same everywhere.
  FdsField withSource(const Rgb& source) const;

  /// Other values of the same lattices, as many.
  FdsField withValues(std::vector<std::shared_ptr<const FdsValues>> values) const;

  const FdsGrid& grid() const { return *grid_; }

  const FdsValues& values(std::size_t lattice) const { return *values_[lattice]; }

  const std::vector<FdsCell>& cells(std::size_t lattice) const { return *cells_[lattice]; }

  /// Values of each lattice; shared, not copied.
  std::span<const std::shared_ptr<const FdsValues>> allValues() const { return values_; }

  std::span<const std::shared_ptr<const std::vector<FdsCell>>> allCells() const { return cells_; }

  const Rgb& source() const { return source_; }

  Box3 bounds() const { return grid_->bounds(); }

  /// A cell of a lattice.
  struct Place {
    int lattice = 0;
    std::array<int, 3> cell{};
  };

  /// In which cell a point is; nothing outside of what the source covers.
  std::optional<Place> placeOf(const Vec3& point) const;

  /// The kind of cell at a place.
  FdsCell cellIn(const Place& place) const;
  std::optional<FdsCell> cellAt(const Vec3& point) const;

  double extinction(const Vec3& point) const;

  /// The same of a point whose place is known.
  double extinction(const Place& place, const Vec3& point) const;

  Rgb emission(const Vec3& point) const;

  /// On all cores, several segments at once.
  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const;

  /// The same one after the other, which the fast way is tested against.
  void opticalDepthReference(std::span<const Segment> segments, std::span<double> depths) const;

  /// The optical depths with their bounds, and how much of each segment has no value. Segments must
  /// be finite. On all cores.
  void depths(std::span<const Segment> segments, std::span<FdsDepth> out) const;

  void depthsReference(std::span<const Segment> segments, std::span<FdsDepth> out) const;

  /// One piece for each cell.
  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const;

  void radiance(std::span<const Segment> segments, std::span<Radiance> out) const;

 private:
  struct Lines;
  struct Marches;

  double depthOf(const Segment& segment) const;
  const Marches& marches() const;
  Lines march(std::span<const Segment> segments) const;
  FdsDepth bandOf(const Segment& segment) const;
  std::vector<Piece> piecesOf(const Segment& segment) const;

  std::shared_ptr<const FdsGrid> grid_;
  std::vector<std::shared_ptr<const FdsValues>> values_;
  std::vector<std::shared_ptr<const std::vector<FdsCell>>> cells_;
  Rgb source_ = Rgb::Zero();
  std::shared_ptr<Marches> marches_;  // made when they are asked for
};

}  // namespace volute
