// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "volute/base/result.hpp"

namespace volute {

/// A file without a name that disappears with its object: where bytes wait whose place in the
/// output is not known yet.
class Spool {
 public:
  /// In `folder`, which must be writable; kIo otherwise.
  [[nodiscard]] static Result<Spool> create(const std::filesystem::path& folder);

  ~Spool();
  Spool(Spool&& other) noexcept;
  Spool& operator=(Spool&& other) = delete;

  /// Appends; a full disk shows here or in flush().
  [[nodiscard]] Status write(std::span<const std::byte> bytes);

  /// Empties it.
  [[nodiscard]] Status clear();

  /// Fills `bytes` with what begins at `offset`; it must have been written.
  [[nodiscard]] Status read(std::uint64_t offset, std::span<std::byte> bytes);

  std::uint64_t size() const { return written_ + pending_.size(); }

 private:
  Spool(int descriptor, std::string folder) : descriptor_(descriptor), folder_(std::move(folder)) {}

  Status flush();

  int descriptor_ = -1;
  std::string folder_;
  std::vector<std::byte> pending_;
  std::uint64_t written_ = 0;
};

}  // namespace volute
