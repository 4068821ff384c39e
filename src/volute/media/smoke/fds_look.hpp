// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "volute/fds/fds_flame.hpp"

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

/// "fire": true, false or {"temperature", "emission", "cutoff"}; "devices": true; "slice":
/// "TEMPERATURE"; "slice_range": [20, 200]. Members of a scene's smoke; errors name the path.
[[nodiscard]] Result<FdsLook> parseFdsLook(const nlohmann::json& smoke, const std::string& file,
                                           const std::string& path);

}  // namespace volute
