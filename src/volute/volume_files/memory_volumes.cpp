// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/volume_files/memory_volumes.hpp"

#include <filesystem>

namespace volute {

Status MemoryVolumes::add(const std::string& name, VolumeInfo info, NumberArray array) {
  return take(name, {std::move(info), std::move(array)});
}

Status MemoryVolumes::add(const std::string& name, VolumeInfo info, ValueFunction value) {
  return take(name, {std::move(info), std::move(value)});
}

Status MemoryVolumes::take(const std::string& name, Volume volume) {
  if (name.empty() || name.find('/') != std::string::npos) {
    return fail(ErrorCode::kInvalidArgument,
                "'{}' names no volume in memory; expected a name without '/'", name);
  }
  const std::string whole = std::string(kPrefix) + name;
  VOLUTE_TRY(volume.info.validate(whole));
  volumes_.insert_or_assign(whole, std::move(volume));
  return {};
}

bool MemoryVolumes::isName(const std::string& file) {
  return std::filesystem::path(file).filename().string().starts_with(kPrefix);
}

void MemoryVolumes::add(const MemoryVolumes& other) {
  for (const auto& [name, volume] : other.volumes_) volumes_.insert_or_assign(name, volume);
}

std::unique_ptr<FrameSource> MemoryVolumes::open(const std::string& file) const {
  const auto found = volumes_.find(std::filesystem::path(file).filename().string());
  if (found == volumes_.end())
    return nullptr;
  const auto& [info, values] = found->second;
  if (const auto* value = std::get_if<ValueFunction>(&values))
    return std::make_unique<FunctionSource>(info, *value);
  return std::make_unique<ArraySource>(info, std::get<NumberArray>(values));
}

}  // namespace volute
