// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>

#include "volute/fds/fds_case.hpp"
#include "volute/geometry/triangle_scene.hpp"
#include "volute/io/reading.hpp"

namespace volute {

/// The plane of a case's 2D slices that gets hottest, as FdsSliceSheet::open() takes it:
/// "TEMPERATURE z=1.5"; of a case without such slices the first quantity that it has slices of.
/// Empty: it has none.
std::string hottestSlice(const SmvIndex& index);

/// 2D slices of one quantity of an FDS case, or a plane through it, as coloured sheets. Opaque:
/// what lies behind is hidden.
class FdsSliceSheet {
 public:
  /// `quantity` as FDS names it: all 2D slices of it; or with a plane, as TEMPERATURE z=1.5: those
  /// within half a cell of it, else a cut through 3D slices or PLOT3D. `range` of the colours
  /// (viridis); without one it is that of all values at all times, for which all are read.
  /// kNotFound when the case has no such slice; the error names those that it has.
  [[nodiscard]] static Result<FdsSliceSheet> open(const SmvIndex& index,
                                                  const std::string& quantity,
                                                  std::optional<std::array<double, 2>> range,
                                                  Reading& reading);

  /// With its plane, if it has one.
  const std::string& quantity() const { return quantity_; }

  const std::string& unit() const { return unit_; }

  const std::array<double, 2>& range() const { return range_; }

  /// Adds the sheets at a time of the case [s]: a square a cell with the colour of its value, or of
  /// the mean of its corners (of a cut: at its middle in the plane); cells within obstructions have
  /// none.
  [[nodiscard]] Status addTo(TriangleMesh& mesh, double time) const;

 private:
  /// The plane of a slice, as a scene states it.
  struct Plane {
    int axis = 2;
    double place = 0;  ///< [m]
  };

  struct Square;

  FdsSliceSheet() = default;

  Status findRange(Reading& reading);
  std::vector<Square> squaresOf(const FdsField& field) const;

  std::shared_ptr<FdsCase> case_;
  std::optional<Plane> plane_;
  std::string quantity_, unit_;
  std::array<double, 2> range_{};
};

}  // namespace volute
