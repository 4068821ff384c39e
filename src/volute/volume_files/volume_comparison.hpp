// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "volute/grid/compare.hpp"
#include "volute/grid/select_frames.hpp"
#include "volute/image/image.hpp"
#include "volute/report/report.hpp"
#include "volute/volume_files/volume_input.hpp"

namespace volute {

/// What of two volumes is compared, and how they are read.
struct ComparisonRequest {
  std::string fields{};  ///< the grids of a cache, "density,flame"; all of them where it is empty
  FrameRange frames{};
  std::optional<Box3> bounds{};             ///< of volumes that state none [m]
  std::optional<double> framesPerSecond{};  ///< of both, instead of the times of their files
  bool partial = false;
  bool drawErrors = false;  ///< fill VolumeComparison::errors
  bool overAll = false;     ///< the worst frame and grid are those over all voxels, not the support
};

/// How far a grid of B is from the one of that name in A.
struct GridComparison {
  std::string name;
  bool empty = false;  ///< in both
  bool overAll = false;
  Difference whole{};
  std::vector<Difference> byFrame{};
  std::vector<int> frameNumbers{};  ///< of byFrame, in A
  FrameScale frameScale{};
  std::vector<double> times{};  ///< of byFrame, in A [s]

  double relativeRms() const { return empty ? 0 : whole.relativeRms(); }

  /// Over the support, or all voxels.
  double wantedRms() const { return empty ? 0 : overAll ? relativeRms() : whole.supportRms(); }

  double psnr() const { return empty ? std::numeric_limits<double>::infinity() : whole.psnr(); }
};

struct VolumeComparison {
  std::vector<GridComparison> grids;  ///< none where all are compared as bytes
  /// Grids that one side or both hold as bytes, and whether all frames have the same.
  std::vector<std::pair<std::string, bool>> kept{};
  bool caches = false;  ///< one side or both has several grids, and they were compared by name
  /// Of each grid the frame that differs most, its largest differences along y, seen from the
  /// front: x to the right, z up. Of caches side by side, each divided by its range.
  std::optional<Image> errors{};

  /// The grid with the largest relative RMS, over what was asked for; an empty one if there is
  /// none.
  const GridComparison& worst() const;

  /// Whether there were numbers to compare.
  bool measured() const { return !std::ranges::all_of(grids, &GridComparison::empty); }
};

/// Compares two volumes of any format frame by frame in the order of their frames, and caches grid
/// by grid, over all that one side takes. Errors: as openVolume(); kInvalidData when sizes or
/// grids do not fit.
[[nodiscard]] Result<VolumeComparison> compareVolumes(const std::string& a, const std::string& b,
                                                      const ComparisonRequest& request,
                                                      Reading& reading);

/// A PSNR [dB] in JSON: null where all is equal, -1000 where no error can be stated.
nlohmann::ordered_json psnrJson(double psnr);

/// The rows that a comparison has beyond those of pictures: the support, places, frames, and grids.
void addDetails(Report& report, const VolumeComparison& comparison);

}  // namespace volute
