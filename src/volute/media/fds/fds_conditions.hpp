// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "volute/fds/smv_index.hpp"
#include "volute/media/sight.hpp"

namespace volute {

/// What people breathe and stand in, from slices, PLOT3D files and devices of a case, the best of
/// them at each place and time: "temperature" [degrees
/// C], "radiant-flux" [kW/m2], gases by their names [mol/mol]. The radiant flux is a quarter of the
/// integrated intensity: the mean over the surface of a small body. kNotFound names what FDS would
/// have to write; any other error what is there and cannot be read.
[[nodiscard]] Result<std::unique_ptr<PointField>> fdsConditions(const SmvIndex& index,
                                                                std::string_view quantity,
                                                                std::uint64_t maxMemory);

/// A quantity by the name that FDS gives it, from all that stores it, in the unit of the first; and
/// that unit. kNotFound where nothing does.
[[nodiscard]] Result<std::pair<std::unique_ptr<PointField>, std::string>> fdsStored(
    const SmvIndex& index, const std::string& quantity, std::uint64_t maxMemory);

/// The names of all quantities that a case stores in the air, each once.
std::vector<std::string> fdsQuantities(const SmvIndex& index);

/// Burners of the case's input file (vents and obstructions whose surface has HRRPUA or MLRPUA),
/// and where it stores a heat release of flames, by its .s3d or PLOT3D files of HRRPUV, at up to
/// fifty of its times: in columns of cells. Empty where neither is known.
[[nodiscard]] Result<std::vector<FirePlace>> fdsFires(const SmvIndex& index,
                                                      std::uint64_t maxMemory);

/// FDS version, cells, heat release and devices: CHID_hrr.csv and CHID_devc.csv beside the index. A
/// file that is missing or cut off is a remark.
CaseFacts fdsFacts(const SmvIndex& index);

}  // namespace volute
