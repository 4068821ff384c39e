// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "volute/fds/fds_case.hpp"
#include "volute/fds/iso_file.hpp"
#include "volute/io/reading.hpp"
#include "volute/math/vec.hpp"
#include "volute/medium/any_medium.hpp"

namespace volute {

/// Translucent surfaces on which a quantity of an FDS case has given values.
class FdsIsoSheets {
 public:
  /// @param text  "TEMPERATURE 60", or several values as "TEMPERATURE 60,200": the quantity as FDS
  ///              names it. From 3D slices or PLOT3D, of nodes where there are some, else from
  ///              the case's isosurface files (.iso) where they have these values. The quantity
  ///              alone: all surfaces of these files. kNotFound where the case has none of them,
  ///              kInvalidArgument where the text says neither.
  [[nodiscard]] static Result<FdsIsoSheets> open(const SmvIndex& index, const std::string& text,
                                                 Reading& reading);

  /// The surfaces at a time of the case [s]; of files those of the stored time that is nearest.
  [[nodiscard]] Result<std::vector<AnyMedium>> at(double time) const;

  /// For people: "TEMPERATURE = 60 C", and of files when they are of.
  std::string words() const;

  std::span<const double> levels() const { return levels_; }

 private:
  FdsIsoSheets() = default;

  Status openFiles(const SmvIndex& index, bool all, Reading& reading);
  Result<std::vector<AnyMedium>> stored(double time) const;
  std::vector<Rgb> colours() const;

  std::shared_ptr<FdsCase> case_;  // null: from files
  std::vector<std::shared_ptr<const FdsIsoFile>> files_;
  std::string quantity_, unit_;
  std::vector<double> levels_;  // ascending
  std::uint64_t maxMemory_ = 0;
};

}  // namespace volute
