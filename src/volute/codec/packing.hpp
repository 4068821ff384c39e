// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <vector>

#include "volute/base/result.hpp"

namespace volute {

/// A packed payload (docs/format.md, section 3): stored, or zstd when that is smaller. The content
/// is the `planes` one after the other; long planes get entropy tables of their own, as their
/// statistics differ. The result depends on the planes and the version of zstd alone. No content
/// gives no bytes.
std::vector<std::byte> pack(std::initializer_list<std::span<const std::byte>> planes);

/// The content of a packed payload. Refuses one without a byte, and one that says it holds more
/// than `limit` bytes, before allocating anything; the messages start with a verb and want a
/// subject from the caller.
[[nodiscard]] Result<std::vector<std::byte>> unpack(std::span<const std::byte> packed,
                                                    std::uint64_t limit);

}  // namespace volute
