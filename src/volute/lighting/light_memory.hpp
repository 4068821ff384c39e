// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <list>
#include <optional>
#include <span>
#include <string>
#include <unordered_map>
#include <vector>

namespace volute {

/// What a LightCache keeps on disk, kept in memory while a program runs. Of one thread.
class LightMemory {
 public:
  /// The values that were used least lately go when all together are larger than `limit` bytes.
  explicit LightMemory(std::uint64_t limit) : limit_(limit) {}

  /// The values kept under a key.
  std::optional<std::vector<float>> find(const std::string& key);

  /// Values that alone are larger than the limit are not kept.
  void store(const std::string& key, std::span<const float> values);

  std::uint64_t bytes() const { return bytes_; }

 private:
  struct Kept {
    std::string key;
    std::vector<float> values;
  };

  std::uint64_t limit_ = 0, bytes_ = 0;
  std::list<Kept> kept_;  ///< the last used first
  std::unordered_map<std::string, std::list<Kept>::iterator> places_;
};

}  // namespace volute
