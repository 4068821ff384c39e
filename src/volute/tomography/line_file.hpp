// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "volute/base/result.hpp"
#include "volute/medium/medium.hpp"

namespace volute {

/// One measured line integral.
struct LineMeasurement {
  Segment line;          ///< [m]; from one point to another, or from a point on in a direction
  double value = 0;      ///< integral along it; an optical depth has no unit
  double sigma = 1;      ///< standard deviation of the value
  int row = 0;           ///< of the file, from 1
  bool atLeast = false;  ///< the value is this or more
};

/// Measurements of all lines at one time.
struct LineFrame {
  int number = 0;
  double time = 0;  ///< [s]
  std::vector<LineMeasurement> lines;
};

/// Measured lines of any number of times.
struct LineFile {
  bool opticalDepths = false;     ///< what is looked for is extinction [1/m]
  bool hasSigma = false;          ///< else all weigh alike
  bool hasTimes = false;          ///< else frames are numbers, or there is one
  std::vector<LineFrame> frames;  ///< ascending, by number and time; one at least
  std::vector<std::string> remarks;
};

/// Reads a .csv with a row of names of columns, in any order and any case, with units in them
/// ("time [ms]") or in a row below:
/// - x0, y0, z0, x1, y1, z1: both ends [m]; or x, y, z, dx, dy, dz: a point and a direction of any
///   length, in which the line goes on without an end;
/// - optical_depth, transmittance (of which the depth is -ln; at most 1.2, or in %),
///   optical_density or absorbance (-log10 of it), or value: any other integral;
/// - sigma, if known: the standard deviation of that column, in its unit;
/// - frame (whole numbers from 0 on) or time [s], where there are several.
/// Rows that are empty or begin with # do not count. Errors name the file, the line and the column;
/// a column with another name is one.
/// @param maxMemory  [bytes], of the text and what is made of it; kTooLarge else
[[nodiscard]] Result<LineFile> readLines(
    const std::filesystem::path& file,
    std::uint64_t maxMemory = std::numeric_limits<std::uint64_t>::max());

}  // namespace volute
