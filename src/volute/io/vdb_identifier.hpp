// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace volute {

/// Where the identifier of an OpenVDB file begins [bytes]: after the magic number, versions and the
/// flag for grid offsets.
inline constexpr int kVdbIdentifierPlace = 21;

/// The one that files of ours have in place of a random one, so that the same frames give the same
/// bytes.
std::string vdbIdentifier(std::uint32_t content, int number);

/// Whether a file has such an identifier.
bool hasOwnIdentifier(const std::filesystem::path& file);

}  // namespace volute
