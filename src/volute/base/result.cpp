// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/result.hpp"

#include <algorithm>
#include <cctype>
#include <utility>

#include "volute/base/remark.hpp"

namespace volute {
namespace {

/// Names in files can be as long as the files. What is no sentence, having no spaces, is cut.
std::string cutLongWords(std::string message) {
  constexpr std::size_t kLongest = 1024, kKept = 80, kMaxMessage = 65536;
  if (message.size() <= kLongest)
    return message;
  const auto begins = [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80; };
  std::string out;
  for (auto at = message.begin(); at != message.end() && out.size() < kMaxMessage;) {
    auto end =
        std::find_if(at, message.end(), [](unsigned char c) { return std::isspace(c) != 0; });
    const auto length = static_cast<std::size_t>(end - at);
    if (length > kLongest) {
      // Characters of UTF-8 stay whole.
      const auto head = std::find_if(at + kKept, end, begins);
      const auto tail = std::find_if(end - kKept / 2, end, begins);
      out.append(at, head);
      out += fmt::format("...({} bytes)...", tail - head);
      out.append(tail, end);
    } else {
      out.append(at, end);
    }
    if (end != message.end())
      out += *end++;
    at = end;
  }
  if (out.size() >= kMaxMessage)
    out += "...";
  return out;
}

}  // namespace

tl::unexpected<Error> failWith(ErrorCode code, Hints hints, fmt::string_view format,
                               fmt::format_args args) {
  Error error{code, cutLongWords(fmt::vformat(format, args))};
  error.hints = std::move(hints);
  return tl::unexpected<Error>(std::move(error));
}

Error inFile(Error error, std::string_view path, std::string_view member) {
  error.path = path;
  error.member = member;
  error.statement = std::move(error.message);
  error.message =
      cutLongWords(member.empty() ? fmt::format("{}: {}", path, error.statement)
                                  : fmt::format("{}: {}: {}", path, member, error.statement));
  return error;
}

std::string_view remarkName(RemarkCode code) {
  switch (code) {
    case RemarkCode::kNote:
      return "note";
    case RemarkCode::kAssumed:
      return "assumed";
    case RemarkCode::kLeftOut:
      return "left-out";
    case RemarkCode::kDamaged:
      return "damaged";
    case RemarkCode::kChanged:
      return "changed";
    case RemarkCode::kFallback:
      return "fallback";
    case RemarkCode::kDoubtful:
      return "doubtful";
  }
  return "note";
}

std::string_view errorName(ErrorCode code) {
  switch (code) {
    case ErrorCode::kInvalidArgument:
      return "invalid-argument";
    case ErrorCode::kNotFound:
      return "not-found";
    case ErrorCode::kInvalidData:
      return "invalid-data";
    case ErrorCode::kTruncated:
      return "truncated";
    case ErrorCode::kUnsupported:
      return "unsupported";
    case ErrorCode::kTooLarge:
      return "too-large";
    case ErrorCode::kIo:
      return "io";
    case ErrorCode::kCancelled:
      return "cancelled";
  }
  return "invalid-data";
}

}  // namespace volute
