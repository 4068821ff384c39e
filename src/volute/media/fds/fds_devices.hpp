// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string_view>
#include <vector>

#include "volute/fds/smv_index.hpp"
#include "volute/media/sight.hpp"

namespace volute {

/// Whether a column with this name and unit is wanted.
using WantedCurve = std::function<bool(const std::string& name, const std::string& unit)>;

/// The wanted columns of CHID_hrr.csv or CHID_devc.csv over time.
[[nodiscard]] Result<std::vector<FactCurve>> readCurves(const std::filesystem::path& path,
                                                        const WantedCurve& wanted);

/// The file of the case whose name ends like that.
std::filesystem::path besideCase(const SmvIndex& index, const char* end);

/// What the devices of a quantity of FDS say, times `factor`, within 0.3 m of each; null where
/// there are none with columns in CHID_devc.csv. `quantity` is its name for people.
[[nodiscard]] Result<std::unique_ptr<PointField>> fdsDevicePoints(const SmvIndex& index,
                                                                  std::string_view fds,
                                                                  double factor,
                                                                  std::string_view quantity);

}  // namespace volute
