// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "volute/base/input_file.hpp"
#include "volute/base/number_type.hpp"

namespace volute {

/// Numbers of any type in a file, or in a part of one, that are read as floats.
class NumberFile {
 public:
  /// All of `file`.
  explicit NumberFile(InputFile file) : file_(std::move(file)), size_(file_.size()) {}

  /// `size` bytes of `file` from `begin` on.
  NumberFile(InputFile file, std::uint64_t begin, std::uint64_t size)
      : file_(std::move(file)), begin_(begin), size_(size) {}

  /// A file whose unpacked content is `unpacked`.
  NumberFile(InputFile file, std::vector<std::byte> unpacked)
      : file_(std::move(file)), size_(unpacked.size()), unpacked_(std::move(unpacked)) {}

  const std::filesystem::path& path() const { return file_.path(); }

  std::uint64_t size() const { return size_; }  ///< [bytes]

  [[nodiscard]] Status read(std::uint64_t offset, std::span<std::byte> bytes) const;

  /// Fills `values` with the numbers from `offset` [bytes] on, rounded to floats. Finite numbers
  /// that are beyond all floats are kInvalidData.
  [[nodiscard]] Status read(const NumberType& type, std::uint64_t offset, std::span<float> values);

  /// The largest difference between a number and its float, of all read so far.
  double rounding() const { return rounding_; }

  /// From now on floats are of differences from `offset`.
  void takeOffset(double offset) { offset_ = offset, rounding_ = 0; }

  double offset() const { return offset_; }

 private:
  InputFile file_;
  std::uint64_t begin_ = 0, size_ = 0;
  std::vector<std::byte> unpacked_;  // empty: it is in the file
  std::vector<std::byte> bytes_;     // to be converted
  double rounding_ = 0, offset_ = 0;
};

}  // namespace volute
