// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <fmt/core.h>

#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>

#include "volute/base/hint.hpp"

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

/// "invalid-data".
std::string_view errorName(ErrorCode code);

/// What went wrong, for people and for programs.
struct Error {
  ErrorCode code = ErrorCode::kInvalidData;
  /// One sentence: what, where (file, frame, byte, JSON path), what was expected. It names no
  /// option of a command and no argument of a function: these are in `hints`.
  std::string message;
  std::string path{};    ///< the file; empty: not known, or none
  std::string member{};  ///< the place in the file; without a file the setting: "bounds"
  Hints hints{};         ///< settings that would help
  /// The message without the file and the member that it begins with: "expected a number", where
  /// the two are known apart; else empty. Without `path` it is the message, which then names no
  /// file: inFile() adds one.
  std::string statement{};
};

/// A value or an Error. Functions that return one are marked [[nodiscard]].
template <class T>
using Result = tl::expected<T, Error>;
using Status = Result<void>;

[[nodiscard]] tl::unexpected<Error> failWith(ErrorCode code, Hints hints, fmt::string_view format,
                                             fmt::format_args args);

/// `return fail(ErrorCode::kNotFound, "{}: no grid named '{}'", file, grid);`
template <class... Args>
[[nodiscard]] tl::unexpected<Error> fail(ErrorCode code, fmt::format_string<Args...> format,
                                         Args&&... args) {
  return failWith(code, {}, format, fmt::make_format_args(args...));
}

/// `return fail(ErrorCode::kTooLarge, Hint::raise("max_memory"), "{}: needs {} MiB", file, size);`
template <class... Args>
[[nodiscard]] tl::unexpected<Error> fail(ErrorCode code, Hint hint,
                                         fmt::format_string<Args...> format, Args&&... args) {
  return failWith(code, {std::move(hint)}, format, fmt::make_format_args(args...));
}

template <class... Args>
[[nodiscard]] tl::unexpected<Error> fail(ErrorCode code, Hints hints,
                                         fmt::format_string<Args...> format, Args&&... args) {
  return failWith(code, std::move(hints), format, fmt::make_format_args(args...));
}

/// About a setting, which each interface names in its own terms: failFor("slice", kInvalidArgument,
/// "'{}' is not a plane", text) is "--slice: 'w' is not a plane" for the command.
template <class... Args>
[[nodiscard]] tl::unexpected<Error> failFor(std::string_view setting, ErrorCode code, Hint hint,
                                            fmt::format_string<Args...> format, Args&&... args) {
  auto failed = failWith(code, {std::move(hint)}, format, fmt::make_format_args(args...));
  failed.value().member = setting;
  return failed;
}

template <class... Args>
[[nodiscard]] tl::unexpected<Error> failFor(std::string_view setting, ErrorCode code,
                                            fmt::format_string<Args...> format, Args&&... args) {
  auto failed = failWith(code, {}, format, fmt::make_format_args(args...));
  failed.value().member = setting;
  return failed;
}

/// The error, whose message names no file, as one about a file and a member of it, if given:
/// "expected a number" becomes "s.json: /media/0: expected a number".
[[nodiscard]] Error inFile(Error error, std::string_view path, std::string_view member = {});

/// failIn("s.json", "/media/0", ErrorCode::kInvalidData, "expected {}", kinds) is
/// "s.json: /media/0: expected ..."; without a member, "s.json: expected ...".
template <class... Args>
[[nodiscard]] tl::unexpected<Error> failIn(std::string_view path, std::string_view member,
                                           ErrorCode code, fmt::format_string<Args...> format,
                                           Args&&... args) {
  auto failed = failWith(code, {}, format, fmt::make_format_args(args...));
  return tl::unexpected<Error>(inFile(std::move(failed.value()), path, member));
}

/// The same result; an error that names neither file nor setting yet is one in `path`, at `member`.
template <class T>
[[nodiscard]] Result<T> ofFile(Result<T> result, std::string_view path,
                               std::string_view member = {}) {
  if (!result && result.error().path.empty() && result.error().member.empty())
    result.error().path = path, result.error().member = member;
  return result;
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
