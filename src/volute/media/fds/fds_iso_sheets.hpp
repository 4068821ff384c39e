// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "volute/fds/fds_case.hpp"
#include "volute/fds/fds_iso.hpp"
#include "volute/media/reading.hpp"

namespace volute {

/// Translucent surfaces on which a quantity of an FDS case has given values.
class FdsIsoSheets {
 public:
  /// @param text  "TEMPERATURE 60", or several values as "TEMPERATURE 60,200": the quantity as FDS
  ///              names it. Read from 3D slices or PLOT3D, of nodes where
  ///              there are some; kNotFound without such, kInvalidArgument
  ///              where the text says no value.
  [[nodiscard]] static Result<FdsIsoSheets> open(const SmvIndex& index, const std::string& text,
                                                 Reading& reading);

  /// The surfaces at a time of the case [s], one a value.
  [[nodiscard]] Result<std::vector<FdsIso>> at(double time) const;

  /// For people: "TEMPERATURE = 60 C".
  std::string words() const;

  std::span<const double> levels() const { return levels_; }

 private:
  FdsIsoSheets() = default;

  std::shared_ptr<FdsCase> case_;
  std::string quantity_, unit_;
  std::vector<double> levels_;  ///< ascending
};

}  // namespace volute
