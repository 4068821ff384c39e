// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "volute/base/team.hpp"
#include "volute/grid/frame_source.hpp"
#include "volute/grid/grid_description.hpp"
#include "volute/io/reading.hpp"
#include "volute/io/volume_sink.hpp"
#include "volute/report/report.hpp"
#include "volute/volume_files/volume_input.hpp"

namespace volute {

/// A grid to be written.
struct WrittenGrid {
  FrameSource* frames = nullptr;
  double rms = 1e-3;  ///< relative RMS error that it may have in a .volute
  /// What .vdb and .volute files say of it beside its values; of its frames and first voxel.
  std::optional<GridDescription> description{};
  OwnError ownError{};  ///< that the frames have; a .volute states the sums
};

/// Adds "frames" and "size", in voxels.
void addSize(Report& report, const VolumeInfo& info);

/// Whether a target holds several grids: a .volute, .vdb files, or names with {grid} in them.
bool holdsSeveralGrids(const std::string& target);

/// An error where that is not so.
[[nodiscard]] Status checkHoldsGrids(const std::vector<std::string>& names, const std::string& path,
                                     const std::string& target);

/// Whether files of a target's kind say when their frames are shown.
bool statesTimes(const std::string& target);

/// What a volume has besides its values and its VolumeInfo.
struct Besides {
  bool turned = false;    ///< its voxels do not lie along the axes, or move
  bool metadata = false;  ///< of a cache
};

/// Tells what a volume says that files of the target's kind have no place for.
void remarkOnWhatIsLost(const VolumeInfo& info, const Besides& besides, const std::string& target,
                        Reading& reading);

/// Tells which files have names of a pattern's frames, and are none of those that are written.
void remarkOnOtherFrames(const std::string& target, const VolumeInfo& info, Reading& reading);

/// Writes frames that are computed to a file of any format: a .volute, or what createSink() takes.
/// Several grids go into one file, or each into its own where the name has {grid} in it.
class VolumeWriter {
 public:
  /// Before the long work: a target that cannot be written ("output: ...") is told now. All but the
  /// target must outlive it.
  /// @param provenance  of a .volute
  /// @param fileMetadata  of the frames of a cache
  [[nodiscard]] static Result<VolumeWriter> open(std::vector<WrittenGrid> grids, std::string target,
                                                 std::string provenance, Reading& reading,
                                                 Team& team, FrameMetadata fileMetadata = {});

  /// Adds bytes and errors of a .volute to the report. Collective.
  [[nodiscard]] Status write(Report& report);

 private:
  VolumeWriter(std::vector<WrittenGrid> grids, std::string target, std::string provenance,
               Reading& reading, Team& team)
      : grids_(std::move(grids)),
        target_(std::move(target)),
        provenance_(std::move(provenance)),
        reading_(&reading),
        team_(&team) {}

  [[nodiscard]] Status writeVolute(Report& report);
  [[nodiscard]] Status writeCache();

  std::vector<WrittenGrid> grids_;
  std::string target_, provenance_;
  FrameMetadata fileMetadata_;
  Reading* reading_;
  Team* team_;
  std::vector<std::unique_ptr<FrameSink>> sinks_;  // of each grid, where it has a file of its own
  std::unique_ptr<CacheSink> cache_;               // of all
};

}  // namespace volute
