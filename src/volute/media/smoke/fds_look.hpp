// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <optional>
#include <string>

#include "volute/fds/fds_flame.hpp"
#include "volute/media/field.hpp"

namespace volute {

/// What is shown of an FDS case besides its smoke and its building.
struct FdsLook {
  bool fire = true;
  FlameLaw flame;                ///< its cutoff unless `cutoff` or the case says another
  std::optional<double> cutoff;  ///< [kW/m3]; nothing: the case's HRRPUVCUT
  bool devices = false;          ///< as marks
  std::string slice;             ///< the quantity of a 2D slice, as FDS names it; empty: none
  std::optional<std::array<double, 2>> sliceRange;  ///< of its colours; nothing: all its values
};

/// The smoke of an FDS case: a SmokeDescription.
const FieldTable& fdsFields();

}  // namespace volute
