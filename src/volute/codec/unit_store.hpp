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
#include "volute/base/shared_folder.hpp"

namespace volute {

/// Finished units of a long job in a folder that all ranks share: a job that was interrupted finds
/// them there, with any number of ranks. A unit has a record, and bytes that are no longer needed
/// once the next pass over the units begins. Files that are damaged, or of another job, count as
/// not there.
class UnitStore {
 public:
  /// Makes the folder, or takes the one that is there. `key`: a digest of all that decides about
  /// what units give.
  [[nodiscard]] static Result<UnitStore> open(const std::filesystem::path& folder,
                                              const std::string& key);

  /// The record of a unit in a pass.
  std::optional<std::vector<std::byte>> record(int pass, std::int64_t unit) const;
  std::optional<std::vector<std::byte>> bytes(int pass, std::int64_t unit) const;

  /// Each is there whole or not at all; bytes first.
  [[nodiscard]] Status store(int pass, std::int64_t unit, std::span<const std::byte> record,
                             std::span<const std::byte> bytes) const;

  /// Removes the bytes of a unit.
  void dropBytes(int pass, std::int64_t unit) const;

  /// Removes all that is this class's, and the folder if nothing else is in it; the last process
  /// that uses the folder does so. Nothing may be done after it.
  void remove() const;

 private:
  UnitStore(SharedFolder folder, std::string key)
      : folder_(std::move(folder)), key_(std::move(key)) {}

  std::filesystem::path fileOf(int pass, std::int64_t unit, const char* extension) const;

  SharedFolder folder_;
  std::string key_;
};

}  // namespace volute
