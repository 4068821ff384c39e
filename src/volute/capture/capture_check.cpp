// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/capture_check.hpp"

#include <algorithm>

#include "volute/capture/capture_images.hpp"
#include "volute/capture/geometry_check.hpp"

namespace volute {

Status checkCapture(const Capture& capture, const std::vector<std::string>& heldOut, bool force,
                    std::uint64_t maxMemory, Progress& progress) {
  constexpr int kFewest = 3;
  const auto fitted = std::ranges::count_if(capture.cameras, [&](const CaptureCamera& camera) {
    return std::ranges::find(heldOut, camera.name) == heldOut.end();
  });
  std::vector<std::string> faults;
  if (fitted < kFewest) {
    faults.push_back(
        fmt::format("{} view{} {} too few to tell where light is along a ray; expected at least {}",
                    fitted, fitted == 1 ? "" : "s", fitted == 1 ? "is" : "are", kFewest));
  }
  for (const GeometryFault& fault : checkGeometry(capture)) faults.push_back(fault.message);
  if (!faults.empty() && !force)
    return fail(ErrorCode::kInvalidData, Hint::set("force").so("goes on"), "{}: {}",
                capture.file.string(), faults.front());
  for (const auto& fault : faults) progress.remark({RemarkCode::kDoubtful, "warning: " + fault});
  if (fitted == 0)
    return fail(ErrorCode::kInvalidArgument, "no camera is left to reconstruct from");
  VOLUTE_ASSIGN(const auto missing, checkPicturesThere(capture, force, maxMemory));
  for (const auto& text : missing) progress.remark({RemarkCode::kLeftOut, "warning: " + text});
  return {};
}

}  // namespace volute
