// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <cmath>

#include "volute/cli/commands/commands.hpp"
#include "volute/cli/field_options.hpp"
#include "volute/cli/fog_export.hpp"
#include "volute/film/picture_writer.hpp"
#include "volute/cli/volume_output.hpp"
#include "volute/base/stopwatch.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/io/image_file.hpp"
#include "volute/media/camera_file.hpp"
#include "volute/media/volume/volume_input.hpp"
#include "volute/media/fog/fog_scene_medium.hpp"
#include "volute/media/volume/volume_input.hpp"
#include "volute/render/render.hpp"
#include "volute/scene/scene_geometry.hpp"

namespace volute::cli {
namespace {

/// The files of one picture; names that are patterns have the frame's number filled in.
struct Frame {
  int number = 0;
  std::string color, depth, camera;
};

struct DepthRule {
  bool alongRay = false;
  double sky = 0;  ///< [m] from here on it is sky
};

Result<std::string> nameOf(const std::string& name, int number) {
  if (!FramePattern::isPattern(name))
    return name;
  VOLUTE_ASSIGN(const auto pattern, FramePattern::parse(name));
  return pattern.format(number).string();
}

/// All frames of the colour's pattern that are chosen, or the one picture.
Result<std::vector<Frame>> framesOf(const Arguments& arguments) {
  const auto color = arguments.get<std::string>("color");
  const auto depth = arguments.get<std::string>("depth");
  const auto camera = arguments.get<std::string>("camera");
  if (!FramePattern::isPattern(color)) {
    if (arguments.given("frames"))
      return fail(ErrorCode::kInvalidArgument, "--frames is for pictures whose name has a %04d");
    return std::vector{Frame{0, color, depth, camera}};
  }
  const auto range = arguments.find<FrameRange>("frames").value_or(FrameRange{});
  VOLUTE_ASSIGN(const auto pattern, FramePattern::parse(color));
  VOLUTE_ASSIGN(const auto files, pattern.list());
  std::vector<Frame> frames;
  for (const NumberedFile& file : files) {
    const int first = range.begin.value_or(files.front().number);
    if (file.number < first || (range.end && file.number >= *range.end) ||
        (file.number - first) % range.step != 0)
      continue;
    VOLUTE_ASSIGN(auto itsDepth, nameOf(depth, file.number));
    VOLUTE_ASSIGN(auto itsCamera, nameOf(camera, file.number));
    frames.push_back({file.number, file.path.string(), std::move(itsDepth), std::move(itsCamera)});
  }
  if (frames.empty())
    return fail(ErrorCode::kInvalidArgument, "--frames: no picture of '{}' is chosen", color);
  return frames;
}

Result<Image> readColor(const std::string& path, const Context& context) {
  VOLUTE_ASSIGN(auto image, readImage(path, {.maxMemory = context.maxMemory}));
  if (image.channels == 3)
    return image;
  Image rgb(image.width, image.height);
  for (std::size_t i = 0; i < image.pixels.size(); ++i)
    std::fill_n(rgb.pixels.begin() + static_cast<std::ptrdiff_t>(3 * i), 3, image.pixels[i]);
  return rgb;
}

/// Distances along the pixels' rays [m], infinite for the sky.
Result<std::vector<float>> readDepth(const std::string& path, const Camera& camera,
                                     const DepthRule& rule, const Context& context) {
  VOLUTE_ASSIGN(auto image, readImage(path, {.raw = true, .maxMemory = context.maxMemory}));
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
      if (depth >= rule.sky)
        depth = std::numeric_limits<float>::infinity();
      const double cosine = camera.ray(x + 0.5, y + 0.5).direction.dot(camera.forward());
      if (!rule.alongRay)
        depth = static_cast<float>(depth / cosine);
    }
  }
  return std::move(image.pixels);
}

Result<Camera> cameraFor(const Frame& frame, const Image& color) {
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

/// A frame of any renderer behind the fog.
Result<Image> fogged(const Frame& frame, const FogLayer& layer, const Arguments& arguments,
                     Context& context) {
  VOLUTE_ASSIGN(const auto color, readColor(frame.color, context));
  VOLUTE_ASSIGN(const auto camera, cameraFor(frame, color));
  const DepthRule rule{
      arguments.get<std::string>("depth-kind") == "ray",
      arguments.find<double>("sky-depth").value_or(std::numeric_limits<double>::infinity())};
  VOLUTE_ASSIGN(const auto depth, readDepth(frame.depth, camera, rule, context));
  const double time =
      arguments.find<double>("time").value_or(frame.number / arguments.get<double>("rate"));
  VOLUTE_ASSIGN(const auto now, FogSceneMedium(layer).at({.time = time}, context.progress));
  std::vector<AnyMedium> medium;
  VOLUTE_TRY(now->addMediaFor(camera, medium));
  RenderOptions options;
  options.behind = &color;
  if (arguments.get<std::string>("renderer") == "reference")
    options.renderer = Renderer::kReference;
  return render(camera, medium, options, context.progress, nullptr, depth);
}

Status fogPictures(const std::vector<Frame>& frames, const FogLayer& layer,
                   const std::string& target, const Arguments& arguments, Context& context) {
  std::unique_ptr<PictureWriter> writer;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (context.progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped before frame {}", frames[i].number);
    VOLUTE_ASSIGN(const auto image, fogged(frames[i], layer, arguments, context));
    if (!writer && isFilmPath(target)) {
      VOLUTE_ASSIGN(
          writer, filmWriter(target, {}, image.width, image.height, arguments.get<double>("rate")));
    } else if (!writer) {
      VOLUTE_ASSIGN(writer, imageFileWriter(target, {}));
    }
    VOLUTE_TRY(writer->write(image, frames[i].number));
    context.progress.report("fog", static_cast<double>(i + 1), static_cast<double>(frames.size()));
  }
  return writer->finish();
}

/// What a map of fog is by the options of its table.
Result<FogDescription> fogOf(const Arguments& arguments, const std::string& map) {
  VOLUTE_ASSIGN(auto members, membersOf(fogFields(), arguments));
  members["map"] = map;
  return parseFog(members, {});
}

/// --sun, --sun-radiance: at most one.
Result<std::vector<FogSun>> sunsOf(const Arguments& arguments) {
  if (!arguments.given("sun"))
    return std::vector<FogSun>{};
  VOLUTE_ASSIGN(const auto members, membersOf(sunFields(), arguments));
  VOLUTE_ASSIGN(const auto sun, readAs<FogSun>(sunFields(), members, {}));
  return std::vector{sun};
}

/// What shadows the sun in the fog.
Status addGeometry(const Arguments& arguments, FogDescription& description,
                   const std::vector<FogSun>& suns, const Context& context) {
  const auto file = arguments.find<std::string>("geometry");
  if (!file)
    return {};
  VOLUTE_ASSIGN(const auto geometry, loadGeometry({{*file, Mat4::Identity()}}, context));
  description.scattering.shadows = fogShadows(geometry, suns);
  return {};
}

Status checkUse(const Arguments& arguments) {
  for (const char* name : {"color", "depth", "camera", "output"}) {
    if (!arguments.given(name)) {
      return fail(ErrorCode::kInvalidArgument,
                  "--{} is missing; expected --color, --depth, --camera and --output, or "
                  "--export-glsl",
                  name);
    }
  }
  const auto target = arguments.get<std::string>("output");
  if (!isPicturePath(target) && !isFilmPath(target)) {
    return fail(ErrorCode::kInvalidArgument,
                "--output: '{}' is of no known format; expected .png, .exr, .mp4 or .webm", target);
  }
  return checkTarget(target);
}

Status runFog(const Arguments& arguments, Context& context) {
  const auto folder = arguments.find<std::string>("export-glsl");
  const bool pictures = arguments.given("color") || arguments.given("output") || !folder;
  if (pictures)
    VOLUTE_TRY(checkUse(arguments));
  VOLUTE_ASSIGN(auto description, fogOf(arguments, arguments.positional(0)));
  VOLUTE_ASSIGN(const auto suns, sunsOf(arguments));
  VOLUTE_TRY(addGeometry(arguments, description, suns, context));
  VOLUTE_ASSIGN(const auto layer, FogLayer::open(description, suns, context));
  Report report;
  if (folder) {
    VOLUTE_TRY(exportFogShader(layer.fogAt(arguments.find<double>("time").value_or(0)), *folder));
    report.add("shader", *folder);
  }
  if (pictures) {
    const auto target = arguments.get<std::string>("output");
    VOLUTE_ASSIGN(const auto frames, framesOf(arguments));
    if (frames.size() > 1 && !isFilmPath(target) && !FramePattern::isPattern(target)) {
      return fail(ErrorCode::kInvalidArgument,
                  "{} pictures do not fit into '{}'; put %04d for the frame's number into its name",
                  frames.size(), target);
    }
    double milliseconds = 0;
    {
      const Stopwatch watch(milliseconds);
      VOLUTE_TRY(fogPictures(frames, layer, target, arguments, context));
    }
    report.add("output", target)
        .add("pictures", static_cast<int>(frames.size()), fmt::format("{}", frames.size()))
        .add("milliseconds", milliseconds, fmt::format("{:.0f}", milliseconds));
  }
  context.print(report);
  return {};
}

std::vector<Option> fogCommandOptions() {
  using enum ValueKind;
  std::vector<Option> options = {
      {.name = "color",
       .kind = kFile,
       .value = "IMAGE",
       .help = "the frame without fog: .exr (linear) or .png (sRGB); %04d for several"},
      {.name = "depth",
       .kind = kFile,
       .value = "DEPTH.exr",
       .help = "one channel [m], inf for the sky; of the frame's size"},
      {.name = "camera",
       .kind = kFile,
       .value = "CAMERA.json",
       .help = "a scene's camera object that the frame was taken with"},
      {.name = "output",
       .letter = 'o',
       .kind = kOutput,
       .value = "OUT",
       .help = ".exr (linear), .png (sRGB), .mp4 or .webm; several stills need %04d"},
      {.name = "depth-kind",
       .kind = kChoice,
       .value = "KIND",
       .help = "z: along the view axis; ray: from the eye",
       .initial = "z",
       .choices = {"z", "ray"}},
      {.name = "sky-depth",
       .kind = kNumber,
       .value = "M",
       .help = "depths from here on are sky, as some renderers write 1e10 [m]",
       .positive = true}};
  const auto more = fieldOptions({&fogFields(), &sunFields()});
  options.insert(options.end(), more.begin(), more.end());
  const std::vector<Option> last = {
      {.name = "frames",
       .kind = kFrames,
       .value = "A:B[:S]",
       .help = "of pictures with %04d: those with numbers A <= n < B, every S-th"},
      {.name = "rate",
       .kind = kNumber,
       .value = "F",
       .help = "frames a second, of a film and for wind and sequences of maps",
       .initial = "25",
       .positive = true},
      {.name = "time",
       .kind = kNumber,
       .value = "T",
       .help = "the fog at T, instead of the frame's number / rate [s]"},
      {.name = "geometry",
       .kind = kFile,
       .value = "FILE",
       .help = "surfaces that shadow the sun in the fog: .glb, .gltf, .obj or .vtp [m]",
       .beside = "sun"},
      {.name = "renderer",
       .kind = kChoice,
       .value = "NAME",
       .help = "who integrates",
       .initial = "auto",
       .choices = {"auto", "cpu", "reference"}},
      {.name = "export-glsl",
       .kind = kFile,
       .value = "FOLDER",
       .help = "write the fog as shader functions (OpenGL 4.5, OpenGL ES 3.0), its texture and how "
               "to use them"}};
  options.insert(options.end(), last.begin(), last.end());
  return options;
}

}  // namespace

Command fogCommand() {
  return {
      .name = "fog",
      .summary = "Puts fog from a painted map over a frame of any renderer",
      .examples = {"volute fog valley.png --color frame.exr --depth depth.exr --camera camera.json "
                   "-o foggy.png --cell 2 --sigma-max 0.05 --profile exponential:0,20",
                   "volute fog valley.png --color in_%04d.png --depth depth_%04d.exr --camera "
                   "camera_%04d.json -o flight.mp4",
                   "volute fog valley.png --export-glsl shaders --degree 2 --profile slab:0,10"},
      .description =
          "Each pixel's fog is integrated exactly from the eye to the frame's depth: out = T color "
          "+ (1 - T) fog-color. The map is a greyscale picture, 8 or 16 bits or .exr, a pattern of "
          "pictures or a volume one voxel high; pixel / maximum x sigma-max is the extinction, "
          "without sRGB decoding; its bottom row has the smallest y.",
      .positionals = {{.name = "MAP", .help = "the painted map of fog"}},
      .options = fogCommandOptions(),
      .run = runFog};
}

}  // namespace volute::cli
