// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "volute/io/number_file.hpp"
#include "volute/io/volume_source.hpp"

namespace volute {

/// An array of a .npz, as a .npy file of its own.
struct NpzArray {
  NumberFile file;
  std::string name;
  std::vector<std::string> others{};  ///< names of other arrays that are volumes by their axes
  std::vector<std::string> rest{};    ///< names of those that are not
};

/// The array options.grid of a .npz, else the only one with three to five axes, else the usual one.
/// What is packed (numpy.savez_compressed) is unpacked into memory, at most options.maxMemory
/// bytes, and checked against its checksum; so is what is not packed, up to 256 MiB, which take a
/// fifth of a second. Nothing in the file is trusted.
[[nodiscard]] Result<NpzArray> openNpzArray(const std::filesystem::path& path,
                                            const SourceOptions& options);

}  // namespace volute
