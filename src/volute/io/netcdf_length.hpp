// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>

#include "volute/base/result.hpp"

namespace volute {

/// Whether a netCDF file, which Exodus files are, has all that its header says: kTruncated when its
/// end is missing. Readers fill what is missing with zeros: clear air.
///
/// Classic files (CDF-1, -2, -5) must reach the last value of each variable; what pads the last
/// one to four bytes may be missing, since no reader looks at it. Files with HDF5 inside (netCDF-4)
/// must have the length that their superblock says. Others are kInvalidData.
[[nodiscard]] Status checkNetcdfLength(const std::filesystem::path& path);

}  // namespace volute
