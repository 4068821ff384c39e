// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "volute/base/input_file.hpp"

namespace volute {

/// What the front of a .npy file says.
struct NpyHeader {
  bool half = false;  ///< float16, else float32
  std::vector<std::uint64_t> shape;
  std::uint64_t dataOffset = 0;  ///< [bytes]
};

/// Reads the header strictly: anything but a C-ordered array of little-endian float32 or float16 is
/// an error that says so, and so is any character that numpy.save does not write there.
[[nodiscard]] Result<NpyHeader> readNpyHeader(const InputFile& file);

/// The header of a C-ordered float32 array, padded so that the data begin at a multiple of 64
/// bytes.
std::string makeNpyHeader(const std::vector<std::uint64_t>& shape);

}  // namespace volute
