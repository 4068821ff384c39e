// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "volute/fds/fds_building.hpp"
#include "volute/fds/fds_flame.hpp"
#include "volute/media/field.hpp"

namespace volute {

/// How a building is drawn.
enum class FdsBuildingView {
  kWhole,
  kOpen,    ///< from outside the outer walls towards the eye, and the roof, are left out
  kInside,  ///< as kWhole, and first seen from within
};

/// What is shown of an FDS case besides its smoke and its building.
struct FdsLook {
  bool fire = true;
  FlameLaw flame;  ///< its cutoff unless `cutoff` or the case says another
  std::optional<double>
      emission;                  ///< FlameLaw::emission; nothing: it, or less, so that flames show
  std::optional<double> cutoff;  ///< [kW/m3]; nothing: the case's HRRPUVCUT
  FdsBuildingView building = FdsBuildingView::kWhole;
  std::vector<FdsCut> cuts;  ///< FdsCut::above is settled by the eye; from nowhere it is true
  bool devices = false;      ///< as marks
  std::string slice;         ///< the quantity of a 2D slice, as FDS names it; empty: none
  std::string iso;           ///< a quantity and its values on surfaces; empty: none
  std::string particles;     ///< all, a class of them or a quantity of theirs; empty: none
  std::optional<std::array<double, 2>> sliceRange;  ///< of its colours; nothing: all its values
};

/// The smoke of an FDS case: a SmokeDescription.
const FieldTable& fdsFields();

}  // namespace volute
