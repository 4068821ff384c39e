// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "volute/base/output_file.hpp"
#include "volute/base/progress.hpp"
#include "volute/base/result.hpp"
#include "volute/codec/container.hpp"

namespace volute {

/// Reads a .volute file back. The head must equal the bytes that were written, a reader must find
/// the same parameters and segments in it, and each segment must have the checksum of the bytes
/// that the encoder decoded to measure the error. The errors that a report states are therefore
/// those of the file.
/// @param name       of the file, for messages
/// @param headBytes  what writeHead() gave
/// @param heads      of the grids that are not empty; their segments have their places
/// @return kIo when the file differs; kCancelled
[[nodiscard]] Status checkWritten(const InputFile& file, const std::string& name,
                                  std::span<const std::byte> headBytes,
                                  std::span<const FileHead> heads, const Progress& progress);

/// A .volute file that gets its name after checkWritten(). Standard output ("-") is not checked.
class CheckedFile {
 public:
  [[nodiscard]] static Result<CheckedFile> create(const std::filesystem::path& target,
                                                  const std::string& name = {});

  /// Takes all bytes of the file, in order.
  OutputFile& bytes() { return bytes_; }

  /// The arguments are those of checkWritten(). Call it once.
  [[nodiscard]] Status commit(std::span<const std::byte> headBytes, std::span<const FileHead> heads,
                              const Progress& progress);

 private:
  CheckedFile(std::optional<PendingFile> pending, OutputFile bytes)
      : pending_(std::move(pending)), bytes_(std::move(bytes)) {}

  std::optional<PendingFile> pending_;  // none: standard output
  OutputFile bytes_;                    // into it
};

}  // namespace volute
