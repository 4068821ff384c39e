// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/fog/fog_frames.hpp"

#include <algorithm>
#include <cmath>

#include "volute/base/plain_number.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/io/stored_color.hpp"
#include "volute/media/camera_file.hpp"
#include "volute/media/fog/fog_scene_medium.hpp"
#include "volute/media/fog/frame_edges.hpp"

namespace volute {
namespace {

Result<std::string> nameOf(const std::string& name, int number) {
  if (!namesSeriesOfFiles(name))
    return name;
  VOLUTE_ASSIGN(const auto pattern, FramePattern::parse(name));
  return pattern.format(number).string();
}

/// The library's error, of a file.
tl::unexpected<Error> in(const std::string& path, const Error& error) {
  return fail(error.code, error.hints, "{}: {}", path, error.message);
}

Image channelsOf(const Image& image, int first, int count) {
  Image part(image.width, image.height, count);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < count; ++c)
        part.at(x, y, c) = image.at(x, y, std::min(first + c, image.channels - 1));
    }
  }
  return part;
}

struct Color {
  FramePixels pixels;
  std::string layer{};
  std::vector<std::string> others{};  ///< channels of the file besides
};

Result<Color> readPngColor(const std::string& path, std::uint64_t maxMemory) {
  VOLUTE_ASSIGN(const auto image, readImage(path, {.maxMemory = maxMemory}));
  Color color;
  color.pixels.color = channelsOf(image, 0, 3);
  VOLUTE_ASSIGN(color.pixels.alpha, readAlpha(path, {.maxMemory = maxMemory}));
  if (color.pixels.alpha) {
    for (std::size_t i = 0; i < color.pixels.color.pixels.size(); ++i)
      color.pixels.color.pixels[i] *= color.pixels.alpha->pixels[i / 3];
  }
  color.pixels.part.data = color.pixels.part.display = {0, 0, image.width, image.height};
  VOLUTE_ASSIGN(const PngKind kind, readPngKind(path));
  color.pixels.bits = kind.bits;
  return color;
}

Result<Color> readExrColor(const std::string& path, const std::string& layer,
                           std::uint64_t maxMemory) {
  VOLUTE_ASSIGN(const auto info, readFrameInfo(path));
  auto channels = colorChannels(info.channels, layer);
  if (!channels)
    return in(path, channels.error());
  std::vector<FrameChannel> wanted{channels->rgb[0]};
  const bool grey = channels->rgb[0].name == channels->rgb[1].name;
  if (!grey)
    wanted.insert(wanted.end(), {channels->rgb[1], channels->rgb[2]});
  if (channels->alpha && channels->alpha->part == channels->rgb[0].part)
    wanted.push_back(*channels->alpha);
  VOLUTE_ASSIGN(const auto image, readFrameChannels(path, wanted, maxMemory));
  Color color{{.part = info.parts[static_cast<std::size_t>(wanted[0].part)]}, channels->layer};
  const int colors = grey ? 1 : 3;
  color.pixels.color = channelsOf(channelsOf(image, 0, colors), 0, 3);
  const auto toSrgb = srgbFromPrimaries(color.pixels.part);
  if (!toSrgb)
    return in(path, toSrgb.error());
  if (*toSrgb)
    transformColors(**toSrgb, color.pixels.color);
  if (image.channels > colors)
    color.pixels.alpha = channelsOf(image, colors, 1);
  for (const FrameChannel& channel : info.channels) {
    if (std::ranges::none_of(wanted, [&](const auto& own) { return own.name == channel.name; }))
      color.others.push_back(channel.name);
  }
  return color;
}

Result<Color> readColor(const FogFrame& frame, const FogFrameOptions& options,
                        const Reading& reading) {
  if (extensionOf(frame.color) == ".exr")
    return readExrColor(frame.color, options.colorLayer, reading.maxMemory);
  return readPngColor(frame.color, reading.maxMemory);
}

/// Depths as they are stored.
struct Depth {
  Image values{};
  PixelWindow data{}, display{};
  DepthKind kind = DepthKind::kUnknown;
  std::string what{};                                  ///< "channel 'Depth.V'"
  double scale = 1;                                    ///< [m] of a unit
  float top = std::numeric_limits<float>::infinity();  ///< the largest that can be stored
};

Result<Depth> readPngDepth(const std::string& path, const FogFrameOptions& options,
                           std::uint64_t maxMemory) {
  if (extensionOf(path) != ".png")
    return fail(ErrorCode::kInvalidData, "{}: expected the depth as .exr or .png", path);
  if (!options.depthScale) {
    return fail(
        ErrorCode::kInvalidData, Hint::set("depth_scale"),
        "{}: a .png has no metres; expected a .exr, or how many metres one of its steps is: "
        "0.01 for centimetres",
        path);
  }
  VOLUTE_ASSIGN(const auto stored, readStoredPng(path, maxMemory));
  const Image& image = stored.image;
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    if (image.pixels[i] != image.pixels[i - i % static_cast<std::size_t>(image.channels)])
      return fail(ErrorCode::kInvalidData, "{}: a picture in colours; expected the depth in grey",
                  path);
  }
  return Depth{channelsOf(image, 0, 1),
               {0, 0, image.width, image.height},
               {0, 0, image.width, image.height},
               DepthKind::kUnknown,
               "grey values",
               *options.depthScale,
               static_cast<float>(stored.largest)};
}

Result<Depth> readExrDepth(const std::string& path, const FogFrameOptions& options,
                           const std::string& layer, std::uint64_t maxMemory) {
  VOLUTE_ASSIGN(const auto info, readFrameInfo(path));
  const auto found = depthChannel(info, options.depthChannel, layer);
  if (!found)
    return in(path, found.error());
  if (!found->unit.empty() && !options.depthScale) {
    return fail(ErrorCode::kInvalidData, Hint::set("depth_scale"),
                "{}: channel '{}' is not in metres; expected how many metres its unit is: {}", path,
                found->channel.name, found->unit);
  }
  std::vector<FrameChannel> wanted{found->channel};
  if (found->same[0])
    wanted.insert(wanted.end(), {*found->same[0], *found->same[1]});
  VOLUTE_ASSIGN(const auto image, readFrameChannels(path, wanted, maxMemory));
  for (std::size_t i = 0; found->same[0] && i < image.pixels.size(); i += 3) {
    const float* pixel = &image.pixels[i];
    const bool grey = pixel[0] == pixel[1] && pixel[0] == pixel[2];
    if (!grey && !(std::isnan(pixel[0]) && std::isnan(pixel[1])))
      return fail(
          ErrorCode::kInvalidData, Hint::set("depth_channel"),
          "{}: R, G and B are not the same; expected the depth, of a picture in colours the "
          "channel that is it",
          path);
  }
  const FramePart& part = info.parts[static_cast<std::size_t>(found->channel.part)];
  return Depth{channelsOf(image, 0, 1),
               part.data,
               part.display,
               found->kind,
               fmt::format("channel '{}'", found->channel.name),
               options.depthScale.value_or(1)};
}

/// What is seen at a pixel's samples, and where.
class Distances {
 public:
  /// @param pixels  whose display window is the camera's picture; its data window is cut to where
  /// there may be depths
  static Result<Distances> make(const FogFrame& frame, Depth depth, const FogFrameOptions& options,
                                FramePart& part, std::vector<FrameRemark>& remarks) {
    Distances made(frame, std::move(depth), options);
    const Depth& own = made.depth_;
    const PixelWindow color = part.display;
    const int samples = own.display.width() / std::max(color.width(), 1);
    if (samples >= 1 && own.display.width() == samples * color.width() &&
        own.display.height() == samples * color.height()) {
      made.samples_ = samples;
      made.left_ = color.left, made.top_ = color.top;
    } else if (own.display.width() == part.data.width() &&
               own.display.height() == part.data.height()) {
      made.left_ = part.data.left, made.top_ = part.data.top;
    } else {
      return fail(ErrorCode::kInvalidData,
                  "{}: {} x {} pixels, but the colour has {} x {}; expected the same size, or a "
                  "multiple of it for soft edges",
                  frame.depth, own.display.width(), own.display.height(), color.width(),
                  color.height());
    }
    // Inside the picture what is not stored is sky; outside it nobody knows.
    const PixelWindow before = part.data, &data = own.data, &display = own.display;
    const auto pixels = [&](int beyond) { return std::max(beyond, 0) / made.samples_; };
    const PixelWindow known{
        made.left_ - pixels(display.left - data.left), made.top_ - pixels(display.top - data.top),
        made.left_ + display.width() / made.samples_ + pixels(data.right - display.right),
        made.top_ + display.height() / made.samples_ + pixels(data.bottom - display.bottom)};
    part.data = {std::max(before.left, known.left), std::max(before.top, known.top),
                 std::min(before.right, known.right), std::min(before.bottom, known.bottom)};
    if (!(part.data == before)) {
      remarks.push_back(
          {RemarkCode::kLeftOut, "cut off",
           fmt::format("{}: has no depths for all pixels of {} outside the picture; these are cut "
                       "off",
                       frame.depth, frame.color)});
    }
    return made;
  }

  int samples() const { return samples_; }

  DepthKind kind() const { return kind_; }

  /// Of all pixels of a window, at one of their samples, along their rays [m].
  Result<std::vector<float>> at(const PixelWindow& window, const Camera& camera, int column,
                                int row) {
    const bool along = kind_ == DepthKind::kAlongRay;
    std::vector<float> distances;
    distances.reserve(static_cast<std::size_t>(window.width()) * window.height());
    for (int y = window.top; y < window.bottom; ++y) {
      for (int x = window.left; x < window.right; ++x) {
        VOLUTE_ASSIGN(float distance, depthAt((x - left_) * samples_ + column + depth_.display.left,
                                              (y - top_) * samples_ + row + depth_.display.top));
        if (!along) {
          const Segment ray = camera.ray(x - window.left + 0.5, y - window.top + 0.5);
          distance = static_cast<float>(distance / ray.direction.dot(camera.forward()));
        }
        distances.push_back(distance);
      }
    }
    return distances;
  }

  /// After all of them.
  FrameRemark sentence() const {
    const std::string how = kind_ == DepthKind::kAlongRay  ? "from the eye"
                            : kind_ == DepthKind::kInverse ? "along the view axis, by 1 / z"
                                                           : "along the view axis";
    const bool nothing = !(nearest_ <= farthest_);
    std::string text = fmt::format("{}: depth by {}: ", path_, depth_.what);
    text += nothing ? std::string("nothing but sky")
                    : fmt::format("{} to {} m {}", plainNumber(nearest_, 4),
                                  plainNumber(farthest_, 4), how);
    if (sky_ > 0 && !nothing)
      text += fmt::format(", {:.3g} % sky", 100.0 * static_cast<double>(sky_) / count_);
    return {RemarkCode::kNote, nothing ? "sky" : depth_.what + how, std::move(text)};
  }

  FrameReach reach() const { return {nearest_, farthest_}; }

  bool stated() const { return stated_; }

 private:
  Distances(const FogFrame& frame, Depth depth, const FogFrameOptions& options)
      : path_(frame.depth), depth_(std::move(depth)), sky_from_(options.sky) {
    stated_ = options.depthKind != DepthKind::kUnknown || depth_.kind != DepthKind::kUnknown;
    kind_ = options.depthKind != DepthKind::kUnknown ? options.depthKind : depth_.kind;
  }

  /// [m], as it is stored; infinite for the sky.
  Result<float> depthAt(int x, int y) {
    constexpr float kInfinity = std::numeric_limits<float>::infinity();
    constexpr float kLargestHalf = 65504, kFarAway = 0.999e10F;
    ++count_;
    const float stored = depth_.data.contains(x, y)
                             ? depth_.values.at(x - depth_.data.left, y - depth_.data.top)
                             : 0;
    const bool inverse = kind_ == DepthKind::kInverse;
    const float largest = std::isinf(depth_.top) ? kLargestHalf : depth_.top;
    const bool nothing =
        stored == 0 ||
        (!inverse && (stored == largest || stored >= kFarAway || stored >= depth_.top));
    const auto metres = static_cast<float>(inverse ? depth_.scale / stored : stored * depth_.scale);
    if (nothing || metres >= sky_from_) {
      ++sky_;
      return kInfinity;
    }
    if (!(metres >= 0)) {
      return fail(ErrorCode::kInvalidData,
                  "{}: pixel {}, {} is {}; expected a depth of at least 0 m, inf for the sky",
                  path_, x, y, stored);
    }
    nearest_ = std::min<double>(nearest_, metres);
    farthest_ = std::max<double>(farthest_, metres);
    return metres;
  }

  std::string path_;
  Depth depth_;
  double sky_from_;
  DepthKind kind_ = DepthKind::kUnknown;
  bool stated_ = false;
  int samples_ = 1;  ///< along a pixel's side
  int left_ = 0, top_ = 0;
  std::uint64_t count_ = 0, sky_ = 0;
  double nearest_ = std::numeric_limits<double>::infinity(), farthest_ = 0;
};

/// Of the display window.
Result<Camera> cameraFor(const FogFrame& frame, const FramePart& part,
                         std::vector<FrameRemark>& remarks) {
  VOLUTE_ASSIGN(const auto description, readCamera(frame.camera));
  if (!description.keys.empty()) {
    return fail(
        ErrorCode::kUnsupported,
        "{}: a camera that moves (keys); expected a file for each frame, with a camera that "
        "does not",
        frame.camera);
  }
  const Pixels size{part.display.width(), part.display.height()};
  if (description.size && !(*description.size == size)) {
    return fail(ErrorCode::kInvalidData,
                "{}: a camera of {} x {} pixels, but {} has {} x {}; expected one size",
                frame.camera, description.size->width, description.size->height, frame.color,
                size.width, size.height);
  }
  const double width = size.width * part.pixelAspect;
  if (const double stated = description.aspect.value_or(width / size.height);
      std::abs(stated * size.height - width) > std::max(1.5, 0.01 * width)) {
    remarks.push_back(
        {RemarkCode::kDoubtful, "shape",
         fmt::format(
             "{}: its pictures are {:.3g} times as wide as high, {} is {:.3g} times: it may "
             "be cropped, of pixels that are not square, or another camera's; then the fog "
             "is not where the picture shows it",
             frame.camera, stated, frame.color, width / size.height)});
  }
  Camera camera = makeCamera(description, size);
  if (part.pixelAspect == 1)
    return camera;
  if (camera.isOrthographic() || !(part.pixelAspect > 0)) {
    return fail(ErrorCode::kUnsupported,
                "{}: pixels {:g} times as wide as high; expected square ones for parallel rays",
                frame.color, part.pixelAspect);
  }
  Calibration wide;
  wide.width = size.width, wide.height = size.height;
  wide.K = camera.intrinsics(), wide.R = camera.rotation();
  wide.K(0, 0) /= part.pixelAspect;
  wide.t = -wide.R * camera.eye();
  return Camera::calibrated(wide);
}

FramePixels cropped(const FramePixels& pixels, const PixelWindow& window) {
  const PixelWindow& data = pixels.part.data;
  if (data == window)
    return pixels;
  FramePixels part{Image(window.width(), window.height()), std::nullopt, pixels.part};
  part.bits = pixels.bits;
  part.part.data = window;
  if (pixels.alpha)
    part.alpha = Image(window.width(), window.height(), 1);
  for (int y = window.top; y < window.bottom; ++y) {
    for (int x = window.left; x < window.right; ++x) {
      for (int c = 0; c < 3; ++c)
        part.color.at(x - window.left, y - window.top, c) =
            pixels.color.at(x - data.left, y - data.top, c);
      if (part.alpha)
        part.alpha->at(x - window.left, y - window.top) =
            pixels.alpha->at(x - data.left, y - data.top);
    }
  }
  return part;
}

FrameSteps stepsOf(const FogFrame& frame, const FramePixels& pixels) {
  if (extensionOf(frame.color) != ".png")
    return FrameSteps::kHalf;
  return pixels.bits > 8 ? FrameSteps::kSrgb16 : FrameSteps::kSrgb8;
}

/// Adds pictures by their samples' weights.
void add(Image& sum, const Image& image, const FrameSample& sample) {
  const auto channels = static_cast<std::size_t>(image.channels);
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    sum.pixels[i] += sample.weight[i / channels] * image.pixels[i];
}

/// Distances of all samples, the picture of the fog, and what is seen through it.
struct Fogging {
  const Camera& camera;  ///< of the data window
  std::span<const AnyMedium> media;
  Renderer renderer;

  /// False: nothing is changed.
  Result<bool> over(FramePixels& pixels, const std::vector<FrameSample>& samples,
                    const std::vector<Camera>& cameras, Progress& progress) const {
    Image light(camera.width(), camera.height()), passed(camera.width(), camera.height(), 1);
    Image clear = light;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const FrameSample& sample = samples[i];
      std::vector<std::uint8_t> some;
      if (i > 0 && cameras.size() == 1) {  // elsewhere it has no weight
        for (const float weight : sample.weight) some.push_back(weight > 0);
      }
      RenderOptions how{.renderer = renderer, .behind = &sample.color, .only = some};
      const Camera& seen = cameras[std::min(i, cameras.size() - 1)];
      VOLUTE_ASSIGN(const auto one, render(seen, media, how, progress, nullptr, sample.depth));
      add(light, one, sample);
      add(clear, sample.color, sample);
      if (!pixels.alpha)
        continue;
      how.aov = Aov::kTransmittance, how.behind = nullptr;
      VOLUTE_ASSIGN(const auto through, render(seen, media, how, progress, nullptr, sample.depth));
      add(passed, through, sample);
    }
    bool changed = light.pixels != clear.pixels;
    pixels.color = std::move(light);
    if (pixels.alpha) {
      for (std::size_t i = 0; i < passed.pixels.size(); ++i) {
        float& alpha = pixels.alpha->pixels[i];
        const float now = 1 - passed.pixels[i] * (1 - alpha);
        changed = changed || now != alpha;
        alpha = now;
      }
    }
    return changed;
  }
};

}  // namespace

bool isFarFrom(const FrameReach& one, const FrameReach& other) {
  constexpr double kFar = 10;
  const auto beyond = [](const FrameReach& far, const FrameReach& near) {
    return far.nearest >= kFar * near.nearest && far.farthest >= kFar * near.farthest;
  };
  const bool both = one.nearest <= one.farthest && other.nearest <= other.farthest;
  return both && (beyond(one, other) || beyond(other, one));
}

std::vector<int> framesWithoutColor(const FogFrame& names, const std::vector<FogFrame>& frames) {
  if (!namesSeriesOfFiles(names.color) || !namesSeriesOfFiles(names.depth) || frames.empty())
    return {};
  const auto filesOf = [](const std::string& name) {
    const auto pattern = FramePattern::parse(name);
    auto files = pattern ? pattern->list() : Result<std::vector<NumberedFile>>();
    return files ? std::move(*files) : std::vector<NumberedFile>();
  };
  const auto colors = filesOf(names.color);
  std::vector<int> missing;
  for (const NumberedFile& depth : filesOf(names.depth)) {
    const int number = depth.number;
    if (number > frames.front().number && number < frames.back().number &&
        std::ranges::find(colors, number, &NumberedFile::number) == colors.end())
      missing.push_back(number);
  }
  return missing;
}

Result<std::vector<FogFrame>> fogFrames(const FogFrame& names,
                                        const std::optional<FrameRange>& chosen) {
  if (!namesSeriesOfFiles(names.color)) {
    if (!chosen)
      return std::vector{names};
    std::vector<FogFrame> frames;
    const int first = static_cast<int>(std::ceil(chosen->begin.value_or(0)));
    const double end = chosen->end.value_or(first + 1.0);
    for (int number = first; number < end; number += chosen->step) {
      frames.push_back(names);
      frames.back().number = number;
    }
    if (frames.empty())
      return failFor("frames", ErrorCode::kInvalidArgument, "no picture is chosen");
    return frames;
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
    return failFor("frames", ErrorCode::kInvalidArgument, "no picture of '{}' is chosen",
                   names.color);
  return frames;
}

/// Light that is no number, or infinite, is handed on.
void tellOfNumbers(const FogFrame& frame, const FramePixels& pixels,
                   std::vector<FrameRemark>& remarks) {
  const std::vector<float>& values = pixels.color.pixels;
  const auto isWrong = [](float value) { return !std::isfinite(value); };
  const auto first = std::ranges::find_if(values, isWrong);
  if (first == values.end())
    return;
  const auto channels = static_cast<std::size_t>(pixels.color.channels);
  const auto at = static_cast<std::size_t>(first - values.begin()) / channels;
  std::size_t count = 0;
  for (std::size_t i = at * channels; i < values.size(); i += channels)
    count += std::any_of(&values[i], &values[i] + channels, isWrong);
  const auto width = static_cast<std::size_t>(pixels.color.width);
  remarks.push_back(
      {RemarkCode::kDoubtful, "numbers",
       fmt::format("{}: pixel {}, {} is {}{}; it stays so", frame.color,
                   pixels.part.data.left + static_cast<int>(at % width),
                   pixels.part.data.top + static_cast<int>(at / width), *first,
                   count > 1 ? fmt::format(", and {} more are no finite light", count - 1) : "")});
}

Result<FoggedFrame> fogOver(const FogFrame& frame, FogSceneMedium& fog,
                            const FogFrameOptions& options, Reading& reading) {
  FoggedFrame out;
  VOLUTE_ASSIGN(auto color, readColor(frame, options, reading));
  out.others = std::move(color.others);
  tellOfNumbers(frame, color.pixels, out.remarks);
  if (extensionOf(frame.color) == ".png") {
    VOLUTE_ASSIGN(const PngKind extras, readPngKind(frame.color));
    color.pixels.part.pixelAspect = extras.pixelAspect;
    if (extras.pictures > 1) {
      out.remarks.push_back(
          {RemarkCode::kLeftOut, "pictures",
           fmt::format("{}: holds {} pictures; the first is read", frame.color, extras.pictures)});
    }
  }
  FramePart part = color.pixels.part;
  VOLUTE_ASSIGN(const auto whole, cameraFor(frame, part, out.remarks));
  VOLUTE_ASSIGN(auto depth, extensionOf(frame.depth) == ".exr"
                                ? readExrDepth(frame.depth, options, color.layer, reading.maxMemory)
                                : readPngDepth(frame.depth, options, reading.maxMemory));
  if (frame.depth == frame.color) {
    std::erase_if(out.others, [&](const std::string& name) {
      return depth.what == fmt::format("channel '{}'", name);
    });
  }
  VOLUTE_ASSIGN(auto distances,
                Distances::make(frame, std::move(depth), options, part, out.remarks));
  const PixelWindow& window = part.data;
  if (window.width() < 1 || window.height() < 1)
    return fail(ErrorCode::kInvalidData, "{}: nothing of it is in the picture of {}", frame.color,
                frame.depth);
  out.pixels = cropped(color.pixels, window);
  const Camera camera =
      whole.cropped(window.left - part.display.left, window.top - part.display.top, window.width(),
                    window.height());
  const int count = distances.samples();
  std::vector<Camera> cameras;
  std::vector<std::vector<float>> depths;
  for (int i = 0; i < count * count; ++i) {
    const int column = i % count, row = i / count;
    cameras.push_back(camera.shifted((column + 0.5) / count - 0.5, (row + 0.5) / count - 0.5));
    VOLUTE_ASSIGN(auto some, distances.at(window, cameras.back(), column, row));
    depths.push_back(std::move(some));
  }
  out.remarks.insert(out.remarks.begin(), distances.sentence());
  if (!distances.stated() && !camera.isOrthographic()) {
    out.remarks.push_back(
        {RemarkCode::kAssumed,
         "kind",
         fmt::format("{}: does not say whether depths are along the view axis (z) or from the eye "
                     "(ray); z is assumed",
                     frame.depth),
         {Hint::choose("depth_kind")}});
  }
  const double extent = fog.fogAt(0).bounds().size().head<2>().maxCoeff();
  out.reach = distances.reach();
  if (const double farthest = out.reach.farthest;
      farthest > 0 && (farthest <= 1 || farthest < 1e-3 * extent)) {
    out.remarks.push_back({RemarkCode::kAssumed,
                           "near",
                           fmt::format("{}: all that is seen is within {:.3g} m of the eye; depths "
                                       "may be normalised, in another "
                                       "unit, or 1 / z",
                                       frame.depth, farthest),
                           {Hint::set("depth_scale").so("says how many metres a unit is"),
                            Hint::set("depth_kind", "inverse").so("takes them for 1 / z")}});
  }
  std::vector<FrameSample> samples;
  if (count > 1)
    samples = samplesOf(out.pixels.color, std::move(depths));
  else if (options.softEdges)
    samples = samplesOf(out.pixels.color, std::move(depths.front()), stepsOf(frame, out.pixels));
  else
    samples = {{out.pixels.color, std::move(depths.front()),
                std::vector<float>(out.pixels.color.pixels.size() / 3, 1)}};
  if (options.onlyFog) {
    for (FrameSample& sample : samples) std::ranges::fill(sample.color.pixels, 0.0F);
    out.pixels.alpha = Image(window.width(), window.height(), 1);
  }
  const double time = options.time.value_or(frame.number / options.rate);
  const std::vector<double>& times = fog.info().times;
  constexpr double kSlack = 1e-6;  // [s], of divisions by the rate
  if (times.size() > 1 && !fog.info().loops &&
      (time < times.front() - kSlack || time > times.back() + kSlack)) {
    const bool early = time < times.front();
    out.remarks.push_back(
        {RemarkCode::kAssumed, early ? "before maps" : "after maps",
         fmt::format("{}: {} s is {} map, at {} s, which stays", fog.info().file, plainNumber(time),
                     early ? "before the first" : "after the last",
                     plainNumber(early ? times.front() : times.back()))});
  }
  VOLUTE_ASSIGN(const auto now, fog.at({.time = time}, reading.progress));
  std::vector<AnyMedium> medium;
  VOLUTE_TRY(now->addMediaFor(camera, medium));
  out.pixels.part = part;
  const Fogging fogging{camera, medium, options.renderer};
  VOLUTE_ASSIGN(const bool changed, fogging.over(out.pixels, samples, cameras, reading.progress));
  if (!changed) {
    const Box3 box = fog.fogAt(time).bounds();
    const Vec3& eye = camera.eye();
    out.remarks.push_back(
        {RemarkCode::kDoubtful, "no fog",
         fmt::format("{}: the fog changes no pixel: its map is 0 there, or elsewhere: it is at x = "
                     "{} to {}, y = {} to {}, z = {} to {} m, the camera at {}, "
                     "{}, {}",
                     frame.color, plainNumber(box.min.x()), plainNumber(box.max.x()),
                     plainNumber(box.min.y()), plainNumber(box.max.y()), plainNumber(box.min.z()),
                     plainNumber(box.max.z()), plainNumber(eye.x()), plainNumber(eye.y()),
                     plainNumber(eye.z()))});
  }
  return out;
}

}  // namespace volute
