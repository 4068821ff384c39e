// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "volute/base/result.hpp"

namespace volute {

/// What a reader's process is for.
struct ReaderJob {
  /// Runs in the child, once for each call: takes the request and returns the reply, and may fill
  /// `values`.
  using Serve =
      std::function<Result<std::string>(std::string_view request, std::span<float> values)>;

  /// Makes it from the parameters, in the child and before that gives up its rights: libraries are
  /// loaded here. A function of the program, because the child may come from a process that was
  /// forked before anything was known (ReaderHelper).
  using Make = Result<Serve> (*)(std::string_view parameters);

  Make make = nullptr;
  std::string parameters{};
  std::vector<std::filesystem::path> readable{};  ///< files, and folders with all below them
};

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

  /// What a call may use.
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

/// A value as a message to or from the other process.
template <class T>
std::string toMessage(const T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

/// kInvalidData where the size is not T's: it comes from a process that read a file nobody vouches
/// for.
template <class T>
Result<T> fromMessage(std::string_view message) {
  static_assert(std::is_trivially_copyable_v<T>);
  if (message.size() != sizeof(T)) {
    return fail(ErrorCode::kInvalidData,
                "the process that reads the file answered with {} bytes; expected {}",
                message.size(), sizeof(T));
  }
  T value;
  std::memcpy(&value, message.data(), sizeof value);
  return value;
}

/// A byte that came as a flag may be neither true nor false: any but 0 is true.
inline void settleFlag(bool& flag) {
  unsigned char byte = 0;
  std::memcpy(&byte, &flag, 1);
  flag = byte != 0;
}

}  // namespace volute
