// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "volute/fds/fds_building.hpp"
#include "volute/fds/fds_flame.hpp"
#include "volute/media/clock.hpp"
#include "volute/media/field.hpp"
#include "volute/optics/extinction.hpp"
#include "volute/optics/visibility.hpp"

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

/// A medium of kind "smoke" in a scene that is an FDS case, or a case on the command line.
struct FdsDescription {
  FieldOrigin origin;                          ///< of its entry, for errors
  std::string file;                            ///< the case
  std::string field;                           ///< a source of it; empty: the best
  double scale = 1;                            ///< of its extinction
  double massExtinction = kFdsMassExtinction;  ///< Km [m2/kg]
  PictureLaw law;
  bool givesC = false;              ///< `law.c` was said, not assumed
  Rgb albedo = Rgb::Constant(0.3);  ///< share of what is taken from light that is scattered
  Clock clock;
  FdsLook look;
};

const FieldTable& fdsFields();

[[nodiscard]] Result<FdsDescription> parseFds(const nlohmann::json& json,
                                              const FieldOrigin& origin);

}  // namespace volute
