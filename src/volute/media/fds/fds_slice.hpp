// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>

#include "volute/fds/fds_case.hpp"
#include "volute/geometry/triangle_scene.hpp"
#include "volute/media/reading.hpp"

namespace volute {

/// 2D slices of one quantity of an FDS case as coloured sheets. Opaque: what lies behind is hidden.
class FdsSliceSheet {
 public:
  /// `quantity` as FDS names it. `range` of the colours (viridis); without one it is that of all
  /// values at all times, for which all are read. kNotFound when the case has no such 2D slice; the
  /// error names those that it has.
  [[nodiscard]] static Result<FdsSliceSheet> open(const SmvIndex& index,
                                                  const std::string& quantity,
                                                  std::optional<std::array<double, 2>> range,
                                                  Reading& reading);

  const std::string& quantity() const { return quantity_; }

  const std::string& unit() const { return unit_; }

  const std::array<double, 2>& range() const { return range_; }

  /// Adds the sheets at a time of the case [s]: a square a cell with the colour of its value, or of
  /// the mean of its corners; cells within obstructions have none.
  [[nodiscard]] Status addTo(TriangleMesh& mesh, double time) const;

 private:
  FdsSliceSheet() = default;

  Status findRange(Reading& reading);

  std::shared_ptr<FdsCase> case_;
  std::string quantity_, unit_;
  std::array<double, 2> range_{};
};

}  // namespace volute
