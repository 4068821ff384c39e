// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/layout.hpp"

#include <fmt/ranges.h>

#include <algorithm>

namespace volute {

CameraLayout::CameraLayout(const Capture& capture) {
  std::vector<Camera> cameras;
  for (const CaptureCamera& camera : capture.cameras) {
    names.push_back(camera.name);
    cameras.push_back(camera.camera);
  }
  angles = sightAngles(cameras, capture.volume.bounds.centre());
}

std::string CameraLayout::narrowest(std::size_t most) const {
  std::vector<SightAngle> sorted = angles;
  std::ranges::stable_sort(sorted, {}, &SightAngle::degrees);
  sorted.resize(std::min(most, sorted.size()));
  std::vector<std::string> texts;
  for (const SightAngle& pair : sorted)
    texts.push_back(fmt::format("{}-{} {:.0f}", names[pair.a], names[pair.b], pair.degrees));
  return fmt::format("{}", fmt::join(texts, ", "));
}

void CameraLayout::remark(bool all, Progress& progress) const {
  constexpr std::size_t kNarrowest = 5;
  const std::size_t pairs = angles.size();
  constexpr std::string_view kWhat = "degrees between lines of sight, modulo 180";
  if (pairs > kNarrowest && !all) {
    progress.remark({RemarkCode::kNote,
                     fmt::format("{}, the {} narrowest of {} pairs: {}", kWhat, kNarrowest, pairs,
                                 narrowest(kNarrowest)),
                     {Hint::set("verbose").so("lists all")}});
  } else if (pairs > 0) {
    progress.remark(fmt::format("{}: {}", kWhat, narrowest(pairs)));
  }
  if (const auto remark = advice())
    progress.remark(*remark);
}

}  // namespace volute
