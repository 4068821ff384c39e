// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>

namespace volute::fuzz {

/// What an input that must not happen does.
inline void require(bool holds) {
  if (!holds)
    std::abort();
}

inline std::string_view textOf(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// A folder in memory for the files of one input; it goes with the process.
class InputFolder {
 public:
  explicit InputFolder(const char* target) {
    const std::filesystem::path memory = "/dev/shm";
    path_ =
        (std::filesystem::is_directory(memory) ? memory : std::filesystem::temp_directory_path()) /
        ("volute-fuzz-" + std::string(target) + '-' + std::to_string(::getpid()));
    std::filesystem::create_directories(path_);
  }

  ~InputFolder() { std::filesystem::remove_all(path_); }

  InputFolder(const InputFolder&) = delete;
  InputFolder& operator=(const InputFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

  /// Writes a file, and returns its name.
  std::filesystem::path save(const char* name, std::string_view bytes) const {
    const auto file = path_ / name;
    std::ofstream(file, std::ios::binary)
        .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    return file;
  }

 private:
  std::filesystem::path path_;
};

/// Parts of an input: each but the last ends where a line "%%" begins.
inline std::string_view nextPart(std::string_view& rest) {
  constexpr std::string_view kCut = "\n%%\n";
  const std::size_t end = rest.find(kCut);
  const std::string_view part = rest.substr(0, end);
  rest = end == rest.npos ? std::string_view() : rest.substr(end + kCut.size());
  return part;
}

}  // namespace volute::fuzz
