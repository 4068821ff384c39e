// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "volute/media/volume/appearance.hpp"
#include "volute/media/volume/lone_frame.hpp"
#include "volute/volume_files/volume_input.hpp"

namespace volute {

/// How a volume looks where nobody says it.
enum class VolumePreset {
  kNone,   ///< each value is light of its own, or what the entry says
  kAuto,   ///< one of the others, by names and ranges of the grids; none where they say nothing
  kFire,   ///< flames, as black bodies
  kSmoke,  ///< what scatters light
  kFireAndSmoke,  ///< both; the fire lights the smoke
};

/// Sets what the preset decides, from the grids of the volume and some of its frames. Says in a
/// remark what was chosen.
/// @param input  its grid becomes the one that absorbs or, of fire alone, that burns
/// @param frame  keeps what is read of a single frame
/// @param stated  whether a member of the look is said, so that the preset does not decide it; may
///                be empty: none is
/// @param depths  as OpenOptions has it: an extinction that the unit says instead is not told
/// @return the preset, of kAuto the one it found. kInvalidArgument, with the names of its grids,
/// where the volume lacks what the preset needs.
[[nodiscard]] Result<VolumePreset> applyPreset(VolumePreset preset, const std::string& path,
                                               InputOptions& input, Appearance& appearance,
                                               Reading& reading,
                                               const std::shared_ptr<LoneFrame>& frame,
                                               const std::function<bool(const char*)>& stated = {},
                                               bool depths = false);

/// The extinction of a value of 1 by the unit of the values; nothing: it is no extinction's.
std::optional<double> extinctionByUnit(const VolumeInfo& info);

}  // namespace volute
