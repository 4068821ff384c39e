// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <cstring>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "volute/base/result.hpp"

namespace volute {

/// Reads untrusted files with a library that may crash on them: in a child process with limits on
/// memory and time, so that a crash or a hang becomes an error. The child is forked at the first
/// call and serves all that follow; after it died the next call forks another, and so does one
/// whose child waits for a lock that another thread held at the fork. Bulk values come back through
/// shared memory. For one thread at a time.
class ReaderProcess {
 public:
  /// Runs in the child, once for each call: takes the request and returns the reply, and may fill
  /// `values`. It sees the parent's memory as it was at the first call.
  using Serve =
      std::function<Result<std::string>(std::string_view request, std::span<float> values)>;

  /// What a call may use.
  struct Limits {
    std::uint64_t memory = std::uint64_t{1}
                           << 30;  ///< bytes on top of what the process has; the values not counted
    double seconds = 10;           ///< of processor time, for one call
  };

  explicit ReaderProcess(Serve serve);
  ~ReaderProcess();
  ReaderProcess(const ReaderProcess&) = delete;
  ReaderProcess& operator=(const ReaderProcess&) = delete;

  /// Serves one request with memory for `valueCount` floats. `file` is named when the child dies.
  /// Replies and requests are at most kMaxMessage bytes. A new memory limit counts from the next
  /// child on.
  [[nodiscard]] Result<std::string> call(const std::string& file, std::string_view request,
                                         std::size_t valueCount, const Limits& limits);

  /// The values of the last call.
  std::span<const float> values() const { return {values_, valueCount_}; }

  static constexpr std::size_t kMaxMessage = 128 << 10;

 private:
  Status start(const std::string& file, std::uint64_t memory);
  Status reserve(const std::string& file, std::size_t valueCount);
  [[noreturn]] void serveForever(int socket);
  Error stop(const std::string& file);

  Serve serve_;
  pid_t child_ = -1;
  int socket_ = -1;
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

}  // namespace volute
