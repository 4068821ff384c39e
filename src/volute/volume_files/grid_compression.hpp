// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <map>
#include <string>
#include <vector>

#include "volute/base/team.hpp"
#include "volute/codec/compress.hpp"
#include "volute/grid/select_frames.hpp"
#include "volute/report/report.hpp"
#include "volute/volume_files/volume_grids.hpp"

namespace volute {

/// How the grids of a cache are compressed.
struct GridCompression {
  CompressOptions options;              ///< of each; a size or a ratio is that of the whole file
  std::map<std::string, double> rms{};  ///< relative RMS of single grids, by their names
  bool rmsOverAll = false;              ///< these are over all voxels, not over the support
  FrameRange frames{};
  StatedInfo stated{};
  std::vector<std::string> keep{};  ///< grids that are kept as bytes though they are volumes
  NotFinite notFinite = NotFinite::kRefuse;
  bool dropUncoded = false;  ///< what is no volume is left out, not kept as bytes
};

/// A grid that was kept as its bytes.
struct KeptResult {
  std::string name, type;
  std::uint64_t bytes = 0;  ///< in the file
};

/// Size and error of one compressed grid.
struct CompressedGrid {
  std::string name;
  VolumeInfo info;  ///< of an empty one x is 0
  CompressReport report{};
  std::uint64_t replaced = 0;  ///< values that were no finite numbers
};

struct CompressedGrids {
  std::vector<CompressedGrid> grids;
  std::uint64_t fileBytes = 0;
  double seconds = 0;
  VolumeInfo frames{};  ///< numbers and times
  std::vector<KeptResult> kept{};

  std::uint64_t rawBytes() const;
};

/// Compresses the `chosen` grids of a cache into one .volute, each with an error of its own, and
/// puts the `kept` ones into it as bytes. Collective.
[[nodiscard]] Result<CompressedGrids> compressGrids(const VolumeGrids& grids,
                                                    const std::vector<std::size_t>& chosen,
                                                    const std::string& target,
                                                    const GridCompression& how, Reading& reading,
                                                    Team& team,
                                                    const std::vector<std::size_t>& kept = {});

/// Compresses a volume of any format, or grids of a cache, as compressionReport() states it. Grids
/// that hold no volume are kept as bytes, or left out, with a remark; a single grid of which there
/// is no more to say than its values is written as a volume. Errors: what cannot be read;
/// kInvalidArgument where `input` or `how` are for one grid, or for several, and the file is
/// otherwise; kUnsupported where the target is out of reach. Collective.
/// @param input  its grid: one or several, "density,flame"; empty: all of a cache
[[nodiscard]] Result<Report> compressVolume(const std::string& path, const std::string& target,
                                            const GridCompression& how, const InputOptions& input,
                                            Reading& reading, Team& team);

/// "density=0.001,flame=0.01".
[[nodiscard]] Result<std::map<std::string, double>> parseGridRms(const std::string& text);

}  // namespace volute
