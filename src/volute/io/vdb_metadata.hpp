// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

// What OpenVDB's files and grids say besides their voxels.
#include <openvdb/openvdb.h>

#include <string>

#include "volute/io/lattice.hpp"

namespace volute {

constexpr const char* kTimeKey = "volute:time";

/// The same name again, and none at all ("[0]"), is told apart by OpenVDB itself.
std::string nameInFile(const std::string& name);

/// The same as OpenVDB writes it.
/// @param own  the grid's own name
std::string uniqueNameOf(const std::string& name, const std::string& own);

/// All entries but those that are kept elsewhere, of types that nobody knows too.
MetadataList listMetadata(const openvdb::MetaMap& map);

/// The same the other way; leaves out what cannot be. What no type of OpenVDB's own needs is
/// written as bytes.
void putMetadata(const MetadataList& list, openvdb::MetaMap& map);

}  // namespace volute
