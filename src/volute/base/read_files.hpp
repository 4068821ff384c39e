// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <vector>

// Which files this process has read: a case names many, and one of them may be what somebody calls
// an output.

namespace volute {

/// InputFile notes each file that it opens.
void noteRead(dev_t device, ino_t number);

/// The same of a name that is asked for, whether it is there or not, and of folders that somebody
/// reads.
void noteReadName(const std::filesystem::path& path);

/// Keeps the names that are noted while it exists. One at a time.
class ReadNames {
 public:
  ReadNames();
  ~ReadNames();
  ReadNames(const ReadNames&) = delete;
  ReadNames& operator=(const ReadNames&) = delete;

  /// So far, each once, as they are sorted.
  std::vector<std::filesystem::path> names() const;
};

/// From now on PendingFile::commit() replaces none of these that has been read; it is refused with
/// kInvalidArgument.
void protectWhatIsRead(std::vector<std::filesystem::path> targets);

/// Whether `target` is protected, and the file that is at `place` now has been read.
[[nodiscard]] bool isProtected(const std::filesystem::path& target,
                               const std::filesystem::path& place);

}  // namespace volute
