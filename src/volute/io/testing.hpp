// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <filesystem>
#include <iterator>
#include <string>
#include <vector>

#include "volute/base/damage_testing.hpp"
#include "volute/base/program.hpp"
#include "volute/grid/sequence.hpp"

/// What the tests of this module share.
namespace volute::testing {

/// A folder that lives as long as the test.
class TempFolder : public ScratchFolder {
 public:
  std::size_t entries() const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(path()), {}));
  }
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

/// Expects that `write(folder)` fails on a disk that is full after so many bytes of a file, and
/// leaves nothing.
template <class Write>
void expectFullDiskLeavesNothing(rlim_t bytes, const Write& write) {
  const TempFolder folder;
  {
    const FullDisk full(bytes);
    const Status status = write(folder);
    ASSERT_FALSE(status);
    EXPECT_EQ(status.error().code, ErrorCode::kIo);
  }
  EXPECT_EQ(folder.entries(), 0u);
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
