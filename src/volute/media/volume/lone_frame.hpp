// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "volute/grid/bricks.hpp"
#include "volute/grid/frame_source.hpp"

namespace volute {

/// What the grids of a single file hold, kept from the first look at them until they are drawn:
/// presets and the search for what is far away need the values before the picture does, and reading
/// them again would cost as much as the first time.
class LoneFrame {
 public:
  /// The same source, read once by all who share `frame`; as it is unless it has one frame and a
  /// topology.
  static std::unique_ptr<FrameSource> keeping(std::unique_ptr<FrameSource> source,
                                              std::shared_ptr<LoneFrame> frame);

  /// Others are forgotten.
  void keepOnly(const std::vector<std::string>& grids);

  /// From now on what is kept is given away by the next read, and nothing more is kept.
  void handOver() { last_ = true; }

 private:
  class Source;

  std::map<std::string, Bricks> kept_;  ///< by the grid's name
  bool last_ = false;
};

}  // namespace volute
