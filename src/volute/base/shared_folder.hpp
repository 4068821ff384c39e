// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>

#include "volute/base/result.hpp"

namespace volute {

/// A folder of intermediate files that several processes may use at once, each with a shared lock
/// on it (flock): the last one may empty and remove it. Where a file system has no locks, each
/// process looks as if it were alone.
class SharedFolder {
 public:
  /// Makes the folder, or takes the one that is there; never one that another process is removing.
  /// @param purpose  names what it holds in errors: "finished frames"
  [[nodiscard]] static Result<SharedFolder> open(const std::filesystem::path& path,
                                                 std::string_view purpose);

  SharedFolder(SharedFolder&& other) noexcept;
  SharedFolder& operator=(SharedFolder&& other) noexcept;
  ~SharedFolder();  ///< gives the lock back

  const std::filesystem::path& path() const { return path_; }

  /// Removes the files for which `ours(name)` holds, and the folder unless something else is in it.
  /// Does nothing while another process uses it. After this the object must not be used.
  template <typename Ours>
  void remove(const Ours& ours) const {
    std::error_code error;
    if (!isOnlyUser())
      return;
    for (const auto& entry : std::filesystem::directory_iterator(path_, error)) {
      std::error_code kept;
      if (entry.is_regular_file(kept) && ours(entry.path().filename().string()))
        std::filesystem::remove(entry.path(), kept);
    }
    std::filesystem::remove(path_, error);
  }

 private:
  SharedFolder(std::filesystem::path path, int lock) : path_(std::move(path)), lock_(lock) {}

  bool isOnlyUser() const;

  std::filesystem::path path_;
  int lock_;  // descriptor of the folder, with a lock; -1: moved from
};

}  // namespace volute
