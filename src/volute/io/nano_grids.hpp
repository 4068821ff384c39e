// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <openvdb/Grid.h>

#include <filesystem>
#include <iosfwd>
#include <vector>

#include "volute/base/result.hpp"

namespace volute {

/// By its first bytes, of any version.
bool isNanoFile(const std::filesystem::path& path);

/// All grids of a NanoVDB file, in its order. kUnsupported for versions that this NanoVDB does not
/// read, kInvalidData for damage that shows in structure or checksums. Throws what the standard
/// library and OpenVDB throw.
[[nodiscard]] Result<std::vector<openvdb::GridBase::Ptr>> readNanoGrids(
    const std::filesystem::path& path);

/// Writes a NanoVDB file with a checksum over everything. Throws too, for types and transforms that
/// NanoVDB does not have.
void writeNanoGrids(std::ostream& stream, const std::vector<openvdb::GridBase::Ptr>& grids);

}  // namespace volute
