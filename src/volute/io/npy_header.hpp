// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/number_type.hpp"
#include "volute/base/result.hpp"

namespace volute {

/// What the front of a .npy file says.
struct NpyHeader {
  NumberType type;
  bool fortranOrder = false;  ///< the first axis is the fastest, else the last
  std::vector<std::uint64_t> shape;
  std::uint64_t dataOffset = 0;  ///< [bytes]
};

/// The longest that readNpyHeader() takes, with what is before it [bytes].
inline constexpr std::size_t kLongestNpyHeader = 12 + 65535;

/// Reads the header strictly: anything but an array of real numbers is an error that says so, and
/// so is any character that numpy.save does not write there.
/// @param front  the beginning of the file, as much of it as there is up to kLongestNpyHeader
/// @param size  of the file [bytes]
/// @param where  its name, for messages
[[nodiscard]] Result<NpyHeader> readNpyHeader(std::span<const std::byte> front, std::uint64_t size,
                                              const std::string& where);

/// The header of a C-ordered array of float32, or of `code`, padded so that the data begin at a
/// multiple of 64 bytes.
std::string makeNpyHeader(const std::vector<std::uint64_t>& shape, std::string_view code = "<f4");

}  // namespace volute
