// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <string_view>

#include "volute/base/input_file.hpp"
#include "volute/base/result.hpp"

static_assert(std::endian::native == std::endian::little, "FDS files are little endian");

namespace volute {

/// A file of Fortran unformatted records: u32 n | n bytes | u32 n, little endian. Records longer
/// than 2^31 - 9 bytes are split into sub-records, whose leading marker is negative when another
/// one follows, and whose trailing marker is negative when one went before.
///
/// The markers are the only integrity check that such a file has. All reads state how long the
/// record must be, so that a wrong marker (kInvalidData, with its byte) is told from a file that
/// ends too early (kTruncated): cases that still run end anywhere.
class FortranFile {
 public:
  [[nodiscard]] static Result<FortranFile> open(const std::filesystem::path& path);

  const std::filesystem::path& path() const { return file_.path(); }

  std::uint64_t size() const { return file_.size(); }

  /// Fills `bytes` with the record at `offset`, which must have that length. `what` names the
  /// record in errors. Returns where the next record begins.
  [[nodiscard]] Result<std::uint64_t> read(std::uint64_t offset, std::span<std::byte> bytes,
                                           std::string_view what) const;

  /// The same, of a trivially copyable value or array of values.
  template <class T, std::size_t N>
  [[nodiscard]] Result<std::uint64_t> readInto(std::uint64_t offset, std::span<T, N> values,
                                               std::string_view what) const {
    return read(offset, std::as_writable_bytes(values), what);
  }

  /// Checks the markers of a record of `length` bytes without reading what is between them.
  [[nodiscard]] Result<std::uint64_t> skip(std::uint64_t offset, std::uint64_t length,
                                           std::string_view what) const;

 private:
  explicit FortranFile(InputFile file) : file_(std::move(file)) {}

  Result<std::uint64_t> walk(std::uint64_t offset, std::uint64_t length, std::byte* into,
                             std::string_view what) const;
  Result<std::int32_t> marker(std::uint64_t offset, std::string_view what) const;

  InputFile file_;
};

}  // namespace volute
