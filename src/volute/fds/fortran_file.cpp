// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/fds/fortran_file.hpp"

#include <array>

namespace volute {
namespace {

constexpr std::uint64_t kMarker = sizeof(std::int32_t);

std::uint64_t lengthOf(std::int32_t marker) {
  const auto wide = static_cast<std::int64_t>(marker);
  return static_cast<std::uint64_t>(wide < 0 ? -wide : wide);
}

}  // namespace

Result<FortranFile> FortranFile::open(const std::filesystem::path& path) {
  VOLUTE_ASSIGN(auto file, InputFile::open(path));
  return FortranFile(std::move(file));
}

Result<std::int32_t> FortranFile::marker(std::uint64_t offset, std::string_view what) const {
  if (offset + kMarker > size()) {
    return fail(ErrorCode::kTruncated, "{}: ends at byte {}, within {}", path().string(), size(),
                what);
  }
  std::int32_t value = 0;
  VOLUTE_TRY(file_.read(offset, std::as_writable_bytes(std::span(&value, 1))));
  return value;
}

Result<std::uint64_t> FortranFile::walk(std::uint64_t offset, std::uint64_t length, std::byte* into,
                                        std::string_view what) const {
  std::uint64_t left = length;
  for (bool first = true;; first = false) {
    VOLUTE_ASSIGN(const std::int32_t leading, marker(offset, what));
    const std::uint64_t part = lengthOf(leading);
    const bool last = leading >= 0;
    if (last ? part != left : (part >= left || part == 0)) {
      return fail(ErrorCode::kInvalidData,
                  "{}: byte {}: the record marker of {} says {}, expected {}: the file is damaged",
                  path().string(), offset, what, leading, left);
    }
    const std::uint64_t end = offset + kMarker + part;
    if (end + kMarker > size()) {
      return fail(ErrorCode::kTruncated, "{}: ends at byte {}, within {}, which goes on to byte {}",
                  path().string(), size(), what, end + kMarker);
    }
    if (into != nullptr) {
      VOLUTE_TRY(file_.read(offset + kMarker, std::span(into + (length - left), part)));
    }
    VOLUTE_ASSIGN(const std::int32_t trailing, marker(end, what));
    if (lengthOf(trailing) != part || (trailing < 0) == first) {
      return fail(ErrorCode::kInvalidData,
                  "{}: byte {}: the record marker after {} says {}, the one before it {}: the file "
                  "is damaged",
                  path().string(), end, what, trailing, leading);
    }
    left -= part;
    offset = end + kMarker;
    if (last)
      return offset;
  }
}

Result<std::uint64_t> FortranFile::read(std::uint64_t offset, std::span<std::byte> bytes,
                                        std::string_view what) const {
  return walk(offset, bytes.size(), bytes.data(), what);
}

Result<std::uint64_t> FortranFile::skip(std::uint64_t offset, std::uint64_t length,
                                        std::string_view what) const {
  return walk(offset, length, nullptr, what);
}

}  // namespace volute
