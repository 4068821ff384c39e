// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fog/fog_frames.hpp"

#include <algorithm>

#include "volute/io/frame_pattern.hpp"
#include "volute/io/image_file.hpp"
#include "volute/media/camera_file.hpp"
#include "volute/media/fog/fog_scene_medium.hpp"

namespace volute {
namespace {

Result<std::string> nameOf(const std::string& name, int number) {
  if (!namesSeriesOfFiles(name))
    return name;
  VOLUTE_ASSIGN(const auto pattern, FramePattern::parse(name));
  return pattern.format(number).string();
}

Result<Image> readColor(const std::string& path, const Reading& reading) {
  VOLUTE_ASSIGN(auto image, readImage(path, {.maxMemory = reading.maxMemory}));
  if (image.channels == 3)
    return image;
  Image rgb(image.width, image.height);
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    std::fill_n(rgb.pixels.begin() + static_cast<std::ptrdiff_t>(3 * i), 3, image.pixels[i]);
  return rgb;
}

/// Distances along the pixels' rays [m], infinite for the sky.
Result<std::vector<float>> readDepth(const std::string& path, const Camera& camera,
                                     const FogFrameOptions& options, const Reading& reading) {
  VOLUTE_ASSIGN(auto image, readImage(path, {.raw = true, .maxMemory = reading.maxMemory}));
  if (image.channels != 1) {
    return fail(ErrorCode::kInvalidData, "{}: {} channels; expected one, the depth in metres", path,
                image.channels);
  }
  if (image.width != camera.width() || image.height != camera.height()) {
    return fail(ErrorCode::kInvalidData,
                "{}: {} x {} pixels, but the colour has {} x {}; expected pictures of one size",
                path, image.width, image.height, camera.width(), camera.height());
  }
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      float& depth = image.at(x, y);
      if (!(depth >= 0)) {
        return fail(ErrorCode::kInvalidData,
                    "{}: pixel {}, {} is {}; expected a depth of at least 0 m, inf for the sky",
                    path, x, y, depth);
      }
      if (depth >= options.sky)
        depth = std::numeric_limits<float>::infinity();
      const double cosine = camera.ray(x + 0.5, y + 0.5).direction.dot(camera.forward());
      if (!options.depthAlongRay)
        depth = static_cast<float>(depth / cosine);
    }
  }
  return std::move(image.pixels);
}

Result<Camera> cameraFor(const FogFrame& frame, const Image& color) {
  VOLUTE_ASSIGN(const auto description, readCamera(frame.camera));
  const Pixels size{color.width, color.height};
  if (description.size && !(*description.size == size)) {
    return fail(ErrorCode::kInvalidData,
                "{}: a camera of {} x {} pixels, but {} has {} x {}; expected one size",
                frame.camera, description.size->width, description.size->height, frame.color,
                size.width, size.height);
  }
  return makeCamera(description, size);
}

}  // namespace

Result<std::vector<FogFrame>> fogFrames(const FogFrame& names,
                                        const std::optional<FrameRange>& chosen) {
  if (!namesSeriesOfFiles(names.color)) {
    if (chosen)
      return fail(ErrorCode::kInvalidArgument, "frames: is for pictures whose name has a %04d");
    return std::vector{names};
  }
  const FrameRange range = chosen.value_or(FrameRange{});
  VOLUTE_ASSIGN(const auto pattern, FramePattern::parse(names.color));
  VOLUTE_ASSIGN(const auto files, pattern.list());
  std::vector<FogFrame> frames;
  std::vector<int> numbers;
  for (const NumberedFile& file : files) numbers.push_back(file.number);
  for (const int position : selectPositions(numbers, {}, range)) {
    const NumberedFile& file = files[static_cast<std::size_t>(position)];
    VOLUTE_ASSIGN(auto depth, nameOf(names.depth, file.number));
    VOLUTE_ASSIGN(auto camera, nameOf(names.camera, file.number));
    frames.push_back({file.number, file.path.string(), std::move(depth), std::move(camera)});
  }
  if (frames.empty())
    return fail(ErrorCode::kInvalidArgument, "frames: no picture of '{}' is chosen", names.color);
  return frames;
}

Result<Image> fogOver(const FogFrame& frame, const FogLayer& layer, const FogFrameOptions& options,
                      Reading& reading) {
  VOLUTE_ASSIGN(const auto color, readColor(frame.color, reading));
  VOLUTE_ASSIGN(const auto camera, cameraFor(frame, color));
  VOLUTE_ASSIGN(const auto depth, readDepth(frame.depth, camera, options, reading));
  const double time = options.time.value_or(frame.number / options.rate);
  VOLUTE_ASSIGN(const auto now, FogSceneMedium(layer).at({.time = time}, reading.progress));
  std::vector<AnyMedium> medium;
  VOLUTE_TRY(now->addMediaFor(camera, medium));
  RenderOptions how;
  how.behind = &color;
  how.renderer = options.renderer;
  return render(camera, medium, how, reading.progress, nullptr, depth);
}

}  // namespace volute
