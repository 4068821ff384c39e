// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

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

/// The work of a reader's process.
struct ReaderJob {
  /// Runs in the child, once for each call: takes the request and returns the reply, and may fill
  /// `values`. The message of an error begins with the file of the call, or with Error::path where
  /// another file is at fault; what it throws, and errors of `make`, name none.
  using Serve =
      std::function<Result<std::string>(std::string_view request, std::span<float> values)>;

  /// Makes it from the parameters, in the child and before that gives up its rights: libraries are
  /// loaded here. A function of the program, because the child may come from a process that was
  /// forked before anything was known (ReaderHelper).
  using Make = Result<Serve> (*)(std::string_view parameters);

  Make make = nullptr;
  std::string parameters{};
  std::vector<std::filesystem::path> readable{};  ///< files, and folders with all below them
  /// Loads the libraries that `make` needs, where that takes long: called once in the process that
  /// children are forked from, if there is one for them (ReaderHelper), so that each child has
  /// them.
  void (*prepare)() = nullptr;
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
  // NOLINTNEXTLINE(bugprone-suspicious-stringview-data-usage,bugprone-multi-level*): bytes
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
