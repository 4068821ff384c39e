// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "volute/base/result.hpp"

namespace volute {

/// A grid of one frame as opaque bytes: a whole OpenVDB file with this grid alone, in parts.
class KeptBytes {
 public:
  /// Size of each part but the last [bytes].
  static constexpr std::size_t kPart = std::size_t{16} << 20;

  virtual ~KeptBytes() = default;

  /// Size of all parts together [bytes].
  virtual std::uint64_t size() const = 0;

  /// The next part, good until the next call; empty after the last one.
  [[nodiscard]] virtual Result<std::span<const std::byte>> next() = 0;
};

}  // namespace volute
