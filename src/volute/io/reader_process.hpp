// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "volute/io/reader_job.hpp"

namespace volute {

/// Reads untrusted files with a library that may crash on them, or be taken over by them: in a
/// child process with limits on memory and time, so that a crash or a hang becomes an error. The
/// child can read what its job names, use memory, and answer; all else is refused to it
/// (confinement.hpp). It is forked at the first call and serves all that follow; after it died the
/// next call forks another, and so does one whose child waits for a lock that another thread held
/// at the fork. It ends when this process does. Bulk values come back through shared memory. For
/// one thread at a time.
///
/// Replies and values are what a stranger's file makes of them: whoever calls checks them.
class ReaderProcess {
 public:
  using Serve = ReaderJob::Serve;

  /// Memory and time that one call may take.
  struct Limits {
    std::uint64_t memory = std::uint64_t{1}
                           << 30;  ///< bytes on top of what the process has; the values not counted
    double seconds = 10;           ///< of CPU time, for one call
  };

  explicit ReaderProcess(ReaderJob job);

  /// For libraries that crash or hang on what is ours: the child is forked from this process, sees
  /// its memory as it was at the first call, and may do what this process may.
  explicit ReaderProcess(Serve unconfined);

  ~ReaderProcess();
  ReaderProcess(const ReaderProcess&) = delete;
  ReaderProcess& operator=(const ReaderProcess&) = delete;

  /// Serves one request with memory for `valueCount` floats. `file` is named when the child dies.
  /// Replies and requests are at most kMaxMessage bytes. A new memory limit counts from the next
  /// child on.
  [[nodiscard]] Result<std::string> call(const std::string& file, std::string_view request,
                                         std::size_t valueCount, const Limits& limits);

  /// The values of the last call. The child may still write to them: copy, then check the copy.
  std::span<const float> values() const { return {values_, valueCount_}; }

  /// The process that serves, 0 when there is none.
  pid_t child() const { return child_ > 0 ? child_ : 0; }

  static constexpr std::size_t kMaxMessage = 128 << 10;

 private:
  Status start(const std::string& file, std::uint64_t memory);
  Status reserve(const std::string& file, std::size_t valueCount);
  int stop();

  ReaderJob job_;
  Serve unconfined_;  // instead of the job
  pid_t child_ = -1;
  int socket_ = -1;
  int lifeline_ = -1;
  int shared_ = -1;  // descriptor of the memory with the values
  float* values_ = nullptr;
  std::size_t valueCount_ = 0;
  std::size_t mappedBytes_ = 0;
};

}  // namespace volute
