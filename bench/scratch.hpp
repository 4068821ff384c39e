// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <stdlib.h>

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "volute/base/result.hpp"

namespace volute::bench {

/// A folder for files of a benchmark, removed with what is in it.
class ScratchFolder {
 public:
  [[nodiscard]] static Result<ScratchFolder> create() {
    std::string name = (std::filesystem::temp_directory_path() / "volute-bench-XXXXXX").string();
    if (!::mkdtemp(name.data()))
      return fail(ErrorCode::kIo, "{}: cannot create a folder for the benchmark's files", name);
    return ScratchFolder(name);
  }

  ~ScratchFolder() {
    std::error_code ignored;
    if (!path_.empty())
      std::filesystem::remove_all(path_, ignored);
  }

  ScratchFolder(ScratchFolder&& other) noexcept : path_(std::exchange(other.path_, {})) {}

  ScratchFolder& operator=(ScratchFolder&&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  explicit ScratchFolder(std::filesystem::path path) : path_(std::move(path)) {}

  std::filesystem::path path_;
};

/// A scratch file of a benchmark, written at once. No fsync: what is timed is coding, not the disk.
[[nodiscard]] inline Status writeScratch(const std::filesystem::path& path,
                                         std::span<const std::byte> bytes) {
  std::ofstream stream(path, std::ios::binary);
  stream.write(reinterpret_cast<const char*>(bytes.data()),
               static_cast<std::streamsize>(bytes.size()));
  stream.close();
  if (!stream)
    return fail(ErrorCode::kIo, "{}: cannot write; is the disk full?", path.string());
  return {};
}

[[nodiscard]] inline Result<std::vector<std::byte>> readScratch(const std::filesystem::path& path) {
  std::error_code error;
  std::vector<std::byte> bytes(std::filesystem::file_size(path, error));
  std::ifstream stream(path, std::ios::binary);
  stream.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (error || !stream)
    return fail(ErrorCode::kIo, "{}: cannot read back what was written", path.string());
  return bytes;
}

}  // namespace volute::bench
