// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "volute/base/result.hpp"

namespace volute {

/// Lists of floats kept on disk under a digest of what they were made from, so that the same light
/// is not computed twice. Files appear whole or not at all, carry a checksum, and several programs
/// may share a folder. What is damaged, cut off or of another version counts as not there.
class LightCache {
 public:
  /// Makes the folder. The files that were used least lately go when all together are larger than
  /// `limit` bytes.
  [[nodiscard]] static Result<LightCache> open(const std::filesystem::path& folder,
                                               std::uint64_t limit);

  /// XDG_CACHE_HOME/volute/light, else ~/.cache/volute/light; empty where there is no home.
  static std::filesystem::path usualFolder();

  /// The values kept under a key, if there are just so many.
  std::optional<std::vector<float>> find(const std::string& key, std::size_t count) const;

  [[nodiscard]] Status store(const std::string& key, std::span<const float> values) const;

  const std::filesystem::path& folder() const { return folder_; }

 private:
  LightCache(std::filesystem::path folder, std::uint64_t limit)
      : folder_(std::move(folder)), limit_(limit) {}

  void removeOldest() const;
  std::filesystem::path fileOf(const std::string& key) const;

  std::filesystem::path folder_;
  std::uint64_t limit_ = 0;
};

}  // namespace volute
