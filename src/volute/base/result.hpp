// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <fmt/format.h>

#include <string>
#include <tl/expected.hpp>
#include <utility>

namespace volute {

/// What kind of thing went wrong. The sentence for people is in Error::message.
enum class ErrorCode {
  kInvalidArgument,  ///< a value that the caller gave makes no sense
  kNotFound,         ///< a file, a grid, a name is not there
  kInvalidData,      ///< a file says something impossible or fails its checksum
  kTruncated,        ///< a file ends before its data do
  kUnsupported,      ///< valid, but a part or version that this build does not know
  kTooLarge,         ///< does not fit in the memory that was allowed
  kIo,               ///< the operating system refused to read or write
  kCancelled,        ///< the caller asked to stop
};

/// One sentence for people: what, where (file, frame, byte, JSON path), what was expected, what to
/// do.
struct Error {
  ErrorCode code = ErrorCode::kInvalidData;
  std::string message;
};

/// A value or an Error. Functions that return one are marked [[nodiscard]].
template <class T>
using Result = tl::expected<T, Error>;
using Status = Result<void>;

/// `return fail(ErrorCode::kNotFound, "{}: no grid named '{}'", file, grid);`
template <class... Args>
[[nodiscard]] tl::unexpected<Error> fail(ErrorCode code, fmt::format_string<Args...> format,
                                         Args&&... args) {
  return tl::unexpected<Error>(Error{code, fmt::format(format, std::forward<Args>(args)...)});
}

}  // namespace volute

/// Leaves the function with the error of `expression` (a Result), if it has one.
#define VOLUTE_TRY(expression)                                                   \
  do {                                                                           \
    if (auto voluteStatus = (expression); !voluteStatus)                         \
      return ::tl::unexpected<::volute::Error>(std::move(voluteStatus).error()); \
  } while (false)

#define VOLUTE_CONCAT_(a, b) a##b
#define VOLUTE_CONCAT(a, b) VOLUTE_CONCAT_(a, b)

/// `VOLUTE_ASSIGN(auto file, InputFile::open(path));` declares `file`, or leaves with the error.
#define VOLUTE_ASSIGN(declaration, expression)                     \
  auto VOLUTE_CONCAT(voluteResult, __LINE__) = (expression);       \
  if (!VOLUTE_CONCAT(voluteResult, __LINE__))                      \
    return ::tl::unexpected<::volute::Error>(                      \
        std::move(VOLUTE_CONCAT(voluteResult, __LINE__)).error()); \
  declaration = std::move(*VOLUTE_CONCAT(voluteResult, __LINE__))
