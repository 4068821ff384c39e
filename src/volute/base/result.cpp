// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/result.hpp"

#include <utility>

#include "volute/base/remark.hpp"

namespace volute {

tl::unexpected<Error> failWith(ErrorCode code, Hints hints, fmt::string_view format,
                               fmt::format_args args) {
  Error error{code, fmt::vformat(format, args)};
  error.hints = std::move(hints);
  return tl::unexpected<Error>(std::move(error));
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
