// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/lighting/light_memory.hpp"

namespace volute {

std::optional<std::vector<float>> LightMemory::find(const std::string& key) {
  const auto found = places_.find(key);
  if (found == places_.end())
    return std::nullopt;
  kept_.splice(kept_.begin(), kept_, found->second);
  return found->second->values;
}

void LightMemory::store(const std::string& key, std::span<const float> values) {
  if (values.size_bytes() > limit_ || places_.contains(key))
    return;
  kept_.push_front({key, {values.begin(), values.end()}});
  places_[key] = kept_.begin();
  bytes_ += values.size_bytes();
  while (bytes_ > limit_) {
    bytes_ -= kept_.back().values.size() * sizeof(float);
    places_.erase(kept_.back().key);
    kept_.pop_back();
  }
}

}  // namespace volute
