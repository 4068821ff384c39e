// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <string>

namespace volute {

/// Frames whose source knows what wrote them.
class WrittenFrames {
 public:
  virtual ~WrittenFrames() = default;

  /// The program, whose up axis VolumeInfo::up is then; empty: unknown.
  virtual const std::string& writer() const = 0;

  /// That of the grid, "fog volume"; empty: unknown.
  virtual const std::string& gridClass() const = 0;
};

}  // namespace volute
