// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/io/vdb_metadata.hpp"

#include <openvdb/io/GridDescriptor.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <sstream>

namespace volute {
namespace {

/// What OpenVDB writes of itself, and what we keep elsewhere.
bool isKeptElsewhere(const std::string& name) {
  using openvdb::GridBase;
  return name == GridBase::META_GRID_CLASS || name == GridBase::META_GRID_NAME ||
         name == GridBase::META_FILE_BBOX_MIN || name == GridBase::META_FILE_BBOX_MAX ||
         name == GridBase::META_FILE_COMPRESSION || name == GridBase::META_FILE_MEM_BYTES ||
         name == GridBase::META_FILE_VOXEL_COUNT || name == GridBase::META_FILE_DELAYED_LOAD;
}

constexpr std::size_t kSizeBytes = sizeof(openvdb::Index32);  // before a value of metadata

/// As what people and programs state calls them.
constexpr VdbProgram kPrograms[] = {
    {"Houdini", 'y'},  {"Blender", 'z'}, {"Bifrost", 'y'},   {"EmberGen", 'y'},  {"JangaFX", 'y'},
    {"LiquiGen", 'y'}, {"GeoGen", 'y'},  {"Maya", 'y'},      {"Cinema 4D", 'y'}, {"Katana", 'y'},
    {"Unreal", 'z'},   {"3ds Max", 'z'}, {"Mantaflow", 'z'}, {"RealFlow", 'y'}};

}  // namespace

const VdbProgram* programOf(const openvdb::MetaMap& map) {
  const auto named = [](std::string_view name) {
    return std::ranges::find(kPrograms, name, &VdbProgram::name);
  };
  for (const char* key : {"creator", "software", "application", "generator", "author"}) {
    const std::string stated = textEntry(map, key);
    for (const VdbProgram& program : kPrograms) {
      if (stated.find(program.name) != std::string::npos)
        return &program;
    }
  }
  for (auto entry = map.beginMeta(); entry != map.endMeta(); ++entry) {
    if (entry->first.find("bifrost") != std::string::npos)
      return named("Bifrost");
  }
  // Mantaflow's, which is Blender's solver.
  if (map["file_base_resolution"] && map["file_voxel_size"])
    return named("Blender");
  return nullptr;
}

std::string textEntry(const openvdb::MetaMap& map, const char* key) {
  const auto stated = map.getMetadata<openvdb::StringMetadata>(key);
  return stated ? stated->value() : std::string();
}

char statedUp(const openvdb::MetaMap& map) {
  const std::string up = textEntry(map, kUpKey);
  return up == "x" || up == "y" || up == "z" ? up.front() : '\0';
}

std::string nameInFile(const std::string& name) {
  const auto bracket = name.rfind('[');
  const bool second = bracket != std::string::npos && name.back() == ']' &&
                      bracket + 2 < name.size() &&
                      name.find_first_not_of("0123456789", bracket + 1) == name.size() - 1;
  return second ? name.substr(0, bracket) : name;
}

std::string uniqueNameOf(const std::string& name, const std::string& own) {
  if (own == name)
    return name;
  return openvdb::io::GridDescriptor::addSuffix(own, std::atoi(name.c_str() + own.size() + 1));
}

MetadataList listMetadata(const openvdb::MetaMap& map) {
  MetadataList list;
  for (auto it = map.beginMeta(); it != map.endMeta(); ++it) {
    if (isKeptElsewhere(it->first))
      continue;
    std::ostringstream bytes;
    it->second->write(bytes);
    list.push_back({it->first, it->second->typeName(), bytes.str().substr(kSizeBytes)});
  }
  return list;
}

void putMetadata(const MetadataList& list, openvdb::MetaMap& map) {
  using openvdb::Metadata;
  for (const GridMetadata& entry : list) {
    if (entry.name.empty() || isKeptElsewhere(entry.name) || entry.name == kTypeEntry ||
        entry.name == kNumberEntry || entry.type.starts_with("__"))
      continue;
    const bool known = Metadata::isRegisteredType(entry.type);
    const Metadata::Ptr metadata = known ? Metadata::createMetadata(entry.type)
                                         : std::make_shared<openvdb::UnknownMetadata>(entry.type);
    if (known && entry.type != "string" && metadata->size() != entry.value.size())
      continue;
    const auto size = static_cast<openvdb::Index32>(entry.value.size());
    std::string bytes(kSizeBytes, '\0');
    std::memcpy(bytes.data(), &size, kSizeBytes);
    std::istringstream in(bytes + entry.value);
    metadata->read(in);
    map.insertMeta(entry.name, *metadata);
  }
}

}  // namespace volute
