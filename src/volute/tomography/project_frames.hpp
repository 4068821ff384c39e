// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/capture/capture.hpp"
#include "volute/capture/image_name.hpp"
#include "volute/grid/frame_source.hpp"

namespace volute {

/// A volume that pictures are taken of, and what stands in for what its file does not say.
struct ProjectedFrames {
  std::unique_ptr<FrameSource> source;
  Basis basis = Basis::kTrilinear;
  std::vector<int> numbers;    ///< one a frame, for the names of pictures
  std::vector<int> positions;  ///< of the chosen frames
};

/// The names of the pictures of all chosen frames and cameras. kInvalidArgument ("output: ...")
/// where they are no .exr, where several would have one name, and where one is a picture of the
/// capture that is there: it cannot be taken again.
[[nodiscard]] Result<std::vector<std::string>> projectedPictures(const ProjectedFrames& subject,
                                                                 const Capture& capture,
                                                                 const ImageName& name);

/// Writes them: projectVolume() of each frame through each camera, a linear float .exr with R, G,
/// B. kTooLarge where a frame does not fit into the memory, kInvalidData for values that are not
/// finite.
/// @param raysPerPixel  1 or 4
/// @param maxMemory  [bytes]
[[nodiscard]] Status projectFrames(ProjectedFrames& subject, const Capture& capture,
                                   const ImageName& name, int raysPerPixel, std::uint64_t maxMemory,
                                   Progress& progress);

}  // namespace volute
