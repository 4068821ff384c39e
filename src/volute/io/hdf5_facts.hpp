// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "volute/base/result.hpp"

namespace volute {

/// What GDAL does not say of a file of HDF5, which those of netCDF-4 are too.
struct Hdf5Link {
  std::string name;    ///< as GDAL has names of arrays, without the first /
  std::string target;  ///< "other.h5:/soot"
};

/// The names of a file that stand for something in another one; none of a file of another kind.
std::vector<Hdf5Link> hdf5Links(const std::string& file);

struct Hdf5Chunks {
  std::uint64_t expected = 0;  ///< 1 of a dataset in one piece; 0: nothing is known
  std::uint64_t absent = 0;    ///< of them, never written
  std::string fill;            ///< what is read in their place; empty: nobody says
  /// A filter that is not here, as a sentence: chunks that it packed cannot be read. Others, which
  /// would not have become smaller, can.
  std::string lacks;
};

/// Which parts of a dataset are there. kUnsupported where its numbers lie in other files: HDF5
/// gives the fill value for what it may not open.
/// @param name  as GDAL has it: "/group/soot"
[[nodiscard]] Result<Hdf5Chunks> hdf5Chunks(const std::string& file, const std::string& name);

}  // namespace volute
