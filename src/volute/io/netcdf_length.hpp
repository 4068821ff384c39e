// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>

#include "volute/base/result.hpp"

namespace volute {

/// Whether a classic netCDF file (CDF-1, -2, -5), which Exodus files may be, reaches the last value
/// of each variable: kTruncated when its end is missing, which readers fill with zeros: clear air.
/// What pads the last value to four bytes may be missing, since no reader looks at it. Of HDF5
/// (netCDF-4) the library sees that itself.
/// @param others  whether files of other kinds pass; else they are kInvalidData
[[nodiscard]] Status checkNetcdfLength(const std::filesystem::path& path, bool others = false);

}  // namespace volute
