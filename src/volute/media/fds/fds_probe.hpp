// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "volute/fds/smv_index.hpp"
#include "volute/media/field_probe.hpp"

namespace volute {

/// All that a case stores in the air: slices, PLOT3D and bytes, where they are.
/// @param caseTime  from the scene's time to the case's [s]
std::unique_ptr<FieldProbe> fdsProbe(SmvIndex index, std::function<double(double)> caseTime,
                                     std::uint64_t maxMemory);

}  // namespace volute
