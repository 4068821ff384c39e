// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

// What is told of OpenVDB's grids without showing them.
#include <string>
#include <string_view>

#include "volute/io/grid_choice.hpp"
#include "volute/io/lattice.hpp"
#include "volute/io/vdb_file.hpp"

namespace volute {

constexpr std::string_view kLevelSet = "level set";

GridEntry describeGrid(const std::string& name, const openvdb::GridBase& grid);

/// Reads the values of a grid that takes more than `limit` bytes in parts of at most that, or of
/// one layer of leaves.
GridFacts factsIn(VdbFile& file, std::size_t index, std::uint64_t limit);

/// Of a grid whose voxels cannot be read.
GridFacts unknownOf(const std::string& name, const std::string& type, std::string_view problem);

/// At most so many letters of a text.
void putText(std::string_view text, char* to, std::size_t most);

}  // namespace volute
