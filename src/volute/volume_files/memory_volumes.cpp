// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/volume_files/memory_volumes.hpp"

#include <algorithm>
#include <filesystem>

namespace volute {

Status MemoryVolumes::add(const std::string& name, VolumeInfo info, NumberArray array) {
  return take(name, {std::move(info), std::move(array)});
}

Status MemoryVolumes::add(const std::string& name, VolumeInfo info, ValueFunction value) {
  return take(name, {std::move(info), std::move(value)});
}

namespace {

Result<std::string> wholeName(const std::string& name, std::string_view what) {
  if (name.empty() || name.find('/') != std::string::npos) {
    return fail(ErrorCode::kInvalidArgument,
                "'{}' names no {} in memory; expected a name without '/'", name, what);
  }
  return std::string(MemoryVolumes::kPrefix) + name;
}

std::string lastPart(const std::string& file) {
  return std::filesystem::path(file).filename().string();
}

}  // namespace

Status MemoryVolumes::add(const std::string& name, MemoryMesh mesh) {
  VOLUTE_ASSIGN(const std::string whole, wholeName(name, "mesh"));
  VOLUTE_TRY(mesh.validate(whole));
  meshes_.insert_or_assign(whole + ".vtu", std::make_shared<const MemoryMesh>(std::move(mesh)));
  return {};
}

Status MemoryVolumes::take(const std::string& name, Volume volume) {
  VOLUTE_ASSIGN(const std::string whole, wholeName(name, "volume"));
  VOLUTE_TRY(volume.info.validate(whole));
  volumes_.insert_or_assign(whole, std::move(volume));
  return {};
}

bool MemoryVolumes::isName(const std::string& file) {
  return lastPart(file).starts_with(kPrefix);
}

void MemoryVolumes::add(const MemoryVolumes& other) {
  for (const auto& [name, volume] : other.volumes_) volumes_.insert_or_assign(name, volume);
  for (const auto& [name, mesh] : other.meshes_) meshes_.insert_or_assign(name, mesh);
}

void MemoryVolumes::keep(std::span<const std::string> names) {
  const auto gone = [&](const std::string& whole) {
    return std::ranges::none_of(names, [&](const std::string& name) {
      const std::string kept = std::string(kPrefix) + name;
      return whole == kept || whole == kept + ".vtu";
    });
  };
  std::erase_if(volumes_, [&](const auto& one) { return gone(one.first); });
  std::erase_if(meshes_, [&](const auto& one) { return gone(one.first); });
}

std::unique_ptr<FrameSource> MemoryVolumes::open(const std::string& file) const {
  const auto found = volumes_.find(lastPart(file));
  if (found == volumes_.end())
    return nullptr;
  const auto& [info, values] = found->second;
  if (const auto* value = std::get_if<ValueFunction>(&values))
    return std::make_unique<FunctionSource>(info, *value);
  return std::make_unique<ArraySource>(info, std::get<NumberArray>(values));
}

std::shared_ptr<const MemoryMesh> MemoryVolumes::mesh(const std::string& file) const {
  const auto found = meshes_.find(lastPart(file));
  return found == meshes_.end() ? nullptr : found->second;
}

}  // namespace volute
