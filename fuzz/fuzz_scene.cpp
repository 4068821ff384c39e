// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <nlohmann/json.hpp>

#include "fuzz/input_folder.hpp"
#include "volute/io/json_file.hpp"
#include "volute/scene/kinds.hpp"
#include "volute/scene/scene_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const volute::fuzz::InputFolder folder("scene");
  volute::registerUsualMedia();
  const std::string file = folder.save("scene.json", volute::fuzz::textOf(data, size)).string();
  const auto json = volute::readJson(file);
  if (!json)
    return 0;
  const auto scene = volute::parseScene(*json, file);
  if (!scene)
    return 0;
  // What kinds make of their entries; the files that these name are not there.
  volute::Progress quiet;
  volute::Reading reading{quiet, 1 << 20};
  const volute::OpenOptions options;
  const volute::TriangleScene nothing;
  for (const volute::MediumEntry& entry : scene->media) {
    volute::MediumContext context{reading, options, scene->lights, nothing, file, entry.path};
    (void)entry.kind->open(*entry.json, context);
  }
  return 0;
}
