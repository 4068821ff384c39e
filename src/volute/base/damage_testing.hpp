// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

/// Files that are cut off or whose bits are flipped, for tests of readers.
namespace volute::testing {

inline std::string readBytes(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Some file systems make overwriting wait for the disk; a new file does not.
inline void writeBytes(const std::filesystem::path& path, const std::string& bytes) {
  std::filesystem::remove(path);
  std::ofstream(path, std::ios::binary)
      .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

inline std::string withFlippedBit(std::string bytes, std::size_t bit) {
  bytes[bit / 8] = static_cast<char>(bytes[bit / 8] ^ 1 << bit % 8);
  return bytes;
}

/// Writes the first 0, `step`, 2 * `step`, ... of `bytes` to `file`, each of which `read(file)`
/// must refuse.
template <class Read>
void expectCutsRefused(const std::filesystem::path& file, const std::string& bytes,
                       const Read& read, std::size_t step = 1) {
  for (std::size_t length = 0; length < bytes.size(); length += step) {
    writeBytes(file, bytes.substr(0, length));
    EXPECT_FALSE(read(file)) << "cut at " << length << " of " << bytes.size();
  }
}

}  // namespace volute::testing
