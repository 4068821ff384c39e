// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "volute/grid/sequence.hpp"

/// What the tests of this module share.
namespace volute::testing {

/// A folder that lives as long as the test.
class TempFolder {
 public:
  TempFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "volute-io-XXXXXX").string();
    if (!::mkdtemp(name.data()))
      std::abort();
    path_ = name;
  }

  ~TempFolder() { std::filesystem::remove_all(path_); }

  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;

  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

  const std::filesystem::path& path() const { return path_; }

  std::size_t entries() const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(path_), {}));
  }

 private:
  std::filesystem::path path_;
};

/// While it lives, files cannot grow beyond `bytes`: a stand-in for a full disk.
class FullDisk {
 public:
  explicit FullDisk(rlim_t bytes) {
    ::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }

  ~FullDisk() { ::setrlimit(RLIMIT_FSIZE, &before_); }

  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;

 private:
  rlimit before_{};
};

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

/// Values that repeat nowhere near, about half of them zero, away from the outer voxels.
inline Sequence makeBlob(int frames, int z, int y, int x, int channels = 1) {
  Sequence sequence = makeSequence(frames, z, y, x, channels);
  std::uint32_t state = 1;
  for (float& value : sequence.values) {
    state = state * 1664525u + 1013904223u;
    value = state >> 31 ? static_cast<float>(state >> 8 & 0xFFFF) / 4096.0f : 0.0f;
  }
  return sequence;
}

/// Fails with the message of a Result.
template <class T>
::testing::AssertionResult ok(const T& result) {
  if (result)
    return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << result.error().message;
}

}  // namespace volute::testing

/// `declaration` from a Result that must have a value.
#define ASSERT_VALUE(declaration, expression)                              \
  auto VOLUTE_CONCAT(testResult, __LINE__) = (expression);                 \
  ASSERT_TRUE(::volute::testing::ok(VOLUTE_CONCAT(testResult, __LINE__))); \
  declaration = std::move(*VOLUTE_CONCAT(testResult, __LINE__))
