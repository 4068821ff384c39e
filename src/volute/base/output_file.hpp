// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>

#include "volute/base/result.hpp"

namespace volute {

/// A name beside `target` for an output in the making, so that the target appears whole or not at
/// all: whoever writes goes to path(); commit() makes it durable and renames it; otherwise the
/// destructor removes it. A file that is replaced hands on its mode and owner; of a symbolic link
/// the file that it leads to is replaced.
class PendingFile {
 public:
  /// Creates the empty temporary file; kIo when the folder cannot be written, and for targets that
  /// are there and are write-protected or no regular files. The temporary name keeps the target's
  /// extension, which some libraries go by.
  /// @param name  of the target in errors; empty: its own
  [[nodiscard]] static Result<PendingFile> create(const std::filesystem::path& target,
                                                  const std::string& name = {});

  ~PendingFile();
  PendingFile(PendingFile&& other) noexcept;
  PendingFile& operator=(PendingFile&& other) noexcept;

  const std::filesystem::path& path() const { return temporary_; }

  const std::filesystem::path& target() const { return target_; }

  /// Of the target, in errors.
  const std::string& name() const { return name_; }

  /// fsync, then rename over the target, then fsync its folder. Call it once.
  [[nodiscard]] Status commit();

 private:
  PendingFile(std::filesystem::path target, std::filesystem::path place, std::string name);

  std::filesystem::path temporary_;  // empty: there is none
  std::filesystem::path target_;     // as it was named
  std::filesystem::path place_;      // where it is, symbolic links followed
  std::string name_;
};

/// While it is so, no output of this process gets its name, a folder neither: commit() is
/// kCancelled. For any thread.
void withholdOutputs(bool withheld);

/// kCancelled while outputs are withheld.
[[nodiscard]] Status checkNotWithheld(const std::string& name);

/// A PendingFile with a descriptor: bytes in order, then commit(). "-" as the target is standard
/// output.
class OutputFile {
 public:
  /// @param name  of the target in errors; empty: its own
  [[nodiscard]] static Result<OutputFile> create(const std::filesystem::path& target,
                                                 const std::string& name = {});

  ~OutputFile();
  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&& other) = delete;

  /// Appends. kIo names the target and the system's reason (a full disk, say).
  [[nodiscard]] Status write(std::span<const std::byte> bytes);

  [[nodiscard]] Status commit();

  std::uint64_t size() const { return size_; }

 private:
  OutputFile(int descriptor, std::unique_ptr<PendingFile> pending)
      : descriptor_(descriptor), pending_(std::move(pending)) {}

  std::string name() const;

  int descriptor_ = -1;
  std::unique_ptr<PendingFile> pending_;  // null for standard output
  std::uint64_t size_ = 0;
};

}  // namespace volute
