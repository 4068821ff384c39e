// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "volute/base/result.hpp"

namespace volute {

/// Whether a file is one of particles (.prt5, by its first bytes) or names some (.smv).
bool mayHoldPeople(const std::filesystem::path& path);

/// The walks of FDS+Evac's people as a table id,time,x,y,floor: those of one file of particles, or
/// of all that a case's index names for evacuation meshes. Their z is the middle of their mesh, and
/// the floor is EVAC_Z_OFFSET of the input file below it, or 1 m, FDS's default.
/// @param most  [bytes] of the table
[[nodiscard]] Result<std::string> fdsPeopleTable(const std::filesystem::path& path,
                                                 std::uint64_t most);

}  // namespace volute
