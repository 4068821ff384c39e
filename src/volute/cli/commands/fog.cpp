// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <cmath>

#include "volute/base/stopwatch.hpp"
#include "volute/cli/commands/commands.hpp"
#include "volute/cli/field_options.hpp"
#include "volute/cli/shared_options.hpp"
#include "volute/cli/volume_output.hpp"
#include "volute/film/picture_writer.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/io/image_file.hpp"
#include "volute/media/fog/fog_export.hpp"
#include "volute/media/fog/fog_frames.hpp"
#include "volute/media/scene_lights.hpp"
#include "volute/media/volume/volume_input.hpp"
#include "volute/scene/scene_geometry.hpp"

namespace volute::cli {
namespace {

FogFrameOptions frameOptions(const Arguments& arguments) {
  FogFrameOptions options;
  options.depthAlongRay = arguments.get<std::string>("depth-kind") == "ray";
  options.sky = arguments.find<double>("sky-depth").value_or(options.sky);
  options.time = arguments.find<double>("time");
  options.rate = arguments.get<double>("fps");
  if (arguments.get<std::string>("renderer") == "reference")
    options.renderer = Renderer::kReference;
  return options;
}

Status fogPictures(const std::vector<FogFrame>& frames, const FogLayer& layer,
                   const std::string& target, const Arguments& arguments, Context& context) {
  const FogFrameOptions options = frameOptions(arguments);
  std::unique_ptr<PictureWriter> writer;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (context.progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped before frame {}", frames[i].number);
    VOLUTE_ASSIGN(const auto image, fogOver(frames[i], layer, options, context));
    if (!writer && isFilmPath(target)) {
      VOLUTE_ASSIGN(
          writer, filmWriter(target, {}, image.width, image.height, arguments.get<double>("fps")));
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
Result<std::vector<Sun>> sunsOf(const Arguments& arguments) {
  if (!arguments.given("sun"))
    return std::vector<Sun>{};
  VOLUTE_ASSIGN(const auto members, membersOf(sunFields(), arguments));
  VOLUTE_ASSIGN(const auto sun, readAs<Sun>(sunFields(), members, {}));
  return std::vector{sun};
}

/// What shadows the sun in the fog.
Status addGeometry(const Arguments& arguments, FogDescription& description,
                   const std::vector<Sun>& suns, const Context& context) {
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
                "--output: '{}' has an unknown format; expected .png, .exr, .mp4 or .webm", target);
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
    const FogFrame names{0, arguments.get<std::string>("color"),
                         arguments.get<std::string>("depth"), arguments.get<std::string>("camera")};
    VOLUTE_ASSIGN(const auto frames,
                  namingOptions(fogFrames(names, arguments.find<FrameRange>("frames")), arguments));
    if (frames.size() > 1 && !isFilmPath(target) && !namesSeries(target)) {
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
       .help = "the frame without fog: .exr (linear) or .png (sRGB); a pattern with %04d for "
               "several"},
      {.name = "depth",
       .kind = kFile,
       .value = "DEPTH.exr",
       .help = "its depth: one channel [m], inf for the sky, same size as the frame"},
      {.name = "camera",
       .kind = kFile,
       .value = "CAMERA.json",
       .help = "its camera, as a scene's camera object"},
      {.name = "output",
       .letter = 'o',
       .kind = kOutput,
       .value = "OUT",
       .help = ".exr (linear), .png (sRGB), .mp4 or .webm; several stills need %04d"},
      {.name = "depth-kind",
       .kind = kChoice,
       .value = "KIND",
       .help = "z: along the view axis; ray: distance from the eye",
       .initial = "z",
       .choices = {"z", "ray"}},
      {.name = "sky-depth",
       .kind = kNumber,
       .value = "M",
       .help = "treat larger depths as sky, for renderers that write 1e10 [m]",
       .positive = true}};
  const auto more = fieldOptions({&fogFields(), &sunFields()});
  options.insert(options.end(), more.begin(), more.end());
  const std::vector<Option> last = {
      framesOption("for patterns with %04d: numbers A <= n < B, every S-th"),
      rateOption("frames per second, for films, wind and sequences of maps", "25", {"rate"}),
      {.name = "time",
       .kind = kNumber,
       .value = "T",
       .help = "time of the fog, instead of the frame's number / fps [s]"},
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
       .help = "write the fog as shader functions (OpenGL 4.5, OpenGL ES 3.0), with its texture "
               "and instructions"}};
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
          "The fog in each pixel is integrated exactly from the eye to the frame's depth: out = T "
          "color + (1 - T) fog-color. The map is a greyscale picture (8 or 16 bits, or .exr), a "
          "pattern of pictures, or a volume one voxel high; the extinction is pixel / maximum x "
          "sigma-max, without sRGB decoding; its bottom row has the smallest y.",
      .positionals = {{.name = "MAP", .help = "the painted map of fog"}},
      .options = fogCommandOptions(),
      .run = runFog};
}

}  // namespace volute::cli
