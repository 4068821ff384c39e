// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/synth/valley_files.hpp"

#include <nlohmann/json.hpp>
#include <system_error>

#include "volute/base/write_file.hpp"
#include "volute/image/srgb.hpp"
#include "volute/io/glb_writer.hpp"
#include "volute/io/image_file.hpp"
#include "volute/synth/valley.hpp"

namespace volute {
namespace {

constexpr double kFov = 50;

std::vector<double> list(const Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

Status writeCamera(const View3& view, const Pixels& size, const std::filesystem::path& path) {
  const nlohmann::ordered_json camera = {{"eye", list(view.eye)},
                                         {"target", list(view.target)},
                                         {"up", list(view.up)},
                                         {"fov", kFov},
                                         {"size", {size.width, size.height}}};
  return writeFile(path, camera.dump(2) + "\n");
}

/// A picture whose bytes are the values themselves: what the writer encodes is undone before.
Status writeMap(Image map, const std::filesystem::path& path) {
  for (float& value : map.pixels) value = static_cast<float>(srgbDecode(value));
  return writeImage(path, map);
}

}  // namespace

Status writeValley(const ValleyFiles& files, const std::filesystem::path& folder,
                   Progress& progress) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!std::filesystem::is_directory(folder, error))
    return failFor("output", ErrorCode::kIo, "cannot make the folder '{}'", folder.string());
  const Valley valley(files.seed);
  VOLUTE_TRY(writeMap(valley.fogMap(files.mapSize), folder / "fogmap.png"));
  if (files.geometry)
    VOLUTE_TRY(writeGlb(folder / "valley.glb", valley.surfaces(2)));
  const bool flight = files.frames > 1;
  for (int i = 0; i < files.frames; ++i) {
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped before frame {}", i);
    const std::string end = flight ? fmt::format("_{:04d}", i) : "";
    const View3 view = flight ? valley.flight(double(i) / (files.frames - 1)) : valley.view();
    const Camera camera = Camera::pinhole(view, kFov, files.size.width, files.size.height);
    const Valley::Frame frame = valley.look(camera);
    VOLUTE_TRY(writeImage(folder / ("color" + end + (flight ? ".png" : ".exr")), frame.color));
    VOLUTE_TRY(writeChannels(folder / ("depth" + end + ".exr"), files.size.width, files.size.height,
                             {{"Z", frame.depth.pixels}}, {{"Software", "Volute"}}));
    VOLUTE_TRY(writeCamera(view, files.size, folder / ("camera" + end + ".json")));
    progress.report("synthesizing", i + 1, files.frames);
  }
  return {};
}

}  // namespace volute
