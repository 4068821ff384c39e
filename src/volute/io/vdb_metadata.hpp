// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

// What OpenVDB's files and grids say besides their voxels.
#include <openvdb/openvdb.h>

#include <string>
#include <string_view>

#include "volute/io/lattice.hpp"

namespace volute {

// Metadata of grids that OpenVDB has no names for: their time [s], the axis that points upwards
// where the program that wrote the file has another, and the unit of the values.
constexpr const char* kTimeKey = "volute:time";
constexpr const char* kUpKey = "volute:up";
constexpr const char* kUnitKey = "volute:unit";

/// A program that writes caches, and its up axis.
struct VdbProgram {
  std::string_view name;
  char up;
};

/// By what metadata of a file or a grid say; null: nothing.
const VdbProgram* programOf(const openvdb::MetaMap& map);

/// An entry of text; empty: there is none.
std::string textEntry(const openvdb::MetaMap& map, const char* key);

/// The axis that metadata of a grid state; 0: none.
char statedUp(const openvdb::MetaMap& map);

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
