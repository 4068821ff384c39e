// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "volute/base/result.hpp"

namespace volute {

/// A file open for reading at any place. Reads are thread-safe (pread) and never move a shared
/// position.
class InputFile {
 public:
  /// Fails with kNotFound or kIo, naming the path and the system's reason. What is no regular file
  /// (a folder, pipe, socket or device) is refused without waiting for whoever is at its other end.
  /// All reading begins here; libraries that open files by name are given what this has opened
  /// once.
  [[nodiscard]] static Result<InputFile> open(const std::filesystem::path& path);

  /// Bytes that are no file; they must outlive it.
  /// @param name  for messages
  static InputFile ofBytes(std::span<const std::byte> bytes, const std::string& name);

  ~InputFile();
  InputFile(InputFile&& other) noexcept;
  InputFile& operator=(InputFile&& other) noexcept;

  /// Fails as open() does, for a file that somebody else will open.
  [[nodiscard]] static Status check(const std::filesystem::path& path);

  /// Where `path` is /dev/stdin or /dev/fd/N (as shells name <(...)) and a pipe: reads it to its
  /// end into a file without a name, which takes the pipe's place, so that it is opened, and opened
  /// again, as other files are. Only for names that the user gave: it waits for the other end.
  [[nodiscard]] static Status spool(const std::string& path);

  std::uint64_t size() const { return size_; }

  const std::filesystem::path& path() const { return path_; }

  /// Fills `bytes` from `offset` on, whole; kTruncated when the file ends before that.
  [[nodiscard]] Status read(std::uint64_t offset, std::span<std::byte> bytes) const;

 private:
  InputFile(int descriptor, std::uint64_t size, std::filesystem::path path)
      : descriptor_(descriptor), size_(size), path_(std::move(path)) {}

  int descriptor_ = -1;
  std::uint64_t size_ = 0;
  std::filesystem::path path_;
  const std::byte* bytes_ = nullptr;  // instead of a descriptor
};

}  // namespace volute
