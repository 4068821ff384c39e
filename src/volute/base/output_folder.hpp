// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <string_view>

#include "volute/base/result.hpp"

namespace volute {

/// A folder in the making beside `target`, so that a folder of results appears whole or not at all:
/// files go to path(); commit() renames it; otherwise the destructor removes it with all in it. Of
/// a symbolic link the folder that it leads to is replaced.
class PendingFolder {
 public:
  /// A folder `target` that is there is replaced in commit() when it is empty or holds a file named
  /// `mark`, which says that this program made it; else it is an error. Files in it that no run
  /// wrote stay where they are (with ".kept" at the end where a new one has the name).
  [[nodiscard]] static Result<PendingFolder> create(const std::filesystem::path& target,
                                                    std::string_view mark);

  ~PendingFolder();
  PendingFolder(PendingFolder&& other) noexcept;
  PendingFolder& operator=(PendingFolder&&) = delete;

  const std::filesystem::path& path() const { return temporary_; }

  const std::filesystem::path& target() const { return target_; }

  /// Call it once, when all files are closed.
  [[nodiscard]] Status commit();

 private:
  PendingFolder(std::filesystem::path temporary, std::filesystem::path target,
                std::filesystem::path place)
      : temporary_(std::move(temporary)), target_(std::move(target)), place_(std::move(place)) {}

  std::filesystem::path temporary_;
  std::filesystem::path target_;  // as it was named
  std::filesystem::path place_;   // where it is, symbolic links followed
};

}  // namespace volute
