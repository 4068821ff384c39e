// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace volute {

/// CRC-32 (ISO 3309, zlib's): every flip of one bit, and every burst of up to 32, changes it.
std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t start = 0);

}  // namespace volute
