// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "volute/base/plain_number.hpp"
#include "volute/base/stopwatch.hpp"
#include "volute/cli/commands/commands.hpp"
#include "volute/cli/field_options.hpp"
#include "volute/cli/shared_options.hpp"
#include "volute/cli/volume_output.hpp"
#include "volute/film/picture_writer.hpp"
#include "volute/fog/fog_shader.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/io/image_file.hpp"
#include "volute/media/fog/fog_export.hpp"
#include "volute/media/fog/fog_frames.hpp"
#include "volute/media/light_blockers.hpp"
#include "volute/media/scene_lights.hpp"
#include "volute/scene/scene_geometry.hpp"
#include "volute/volume_files/volume_input.hpp"

namespace volute::cli {
namespace {

FogFrameOptions frameOptions(const Arguments& arguments) {
  FogFrameOptions options;
  options.colorLayer = arguments.find<std::string>("color-layer").value_or("");
  options.depthChannel = arguments.find<std::string>("depth-channel").value_or("");
  const auto kind = arguments.get<std::string>("depth-kind");
  options.depthKind = kind == "z"         ? DepthKind::kAlongAxis
                      : kind == "ray"     ? DepthKind::kAlongRay
                      : kind == "inverse" ? DepthKind::kInverse
                                          : DepthKind::kUnknown;
  options.depthScale = arguments.find<double>("depth-scale");
  options.sky = arguments.find<double>("sky-depth").value_or(options.sky);
  options.softEdges = arguments.get<std::string>("edges") == "soft";
  options.onlyFog = arguments.flag("fog-only");
  options.time = arguments.find<double>("time");
  options.rate = arguments.get<double>("fps");
  if (arguments.get<std::string>("renderer") == "reference")
    options.renderer = Renderer::kReference;
  return options;
}

/// Kinds of what is lost, with sentences.
using Lost = std::vector<std::pair<std::string, std::string>>;

/// What a target does not keep of a frame.
Lost lostIn(const std::string& target, const FramePixels& frame) {
  Lost lost;
  const FramePart& part = frame.part;
  if (extensionOf(target) == ".exr")
    return lost;
  if (!(part.data == part.display))
    lost.emplace_back("window", "pixels outside the display window");
  if (part.pixelAspect != 1)
    lost.emplace_back("aspect",
                      fmt::format("that pixels are {:g} times as wide as high", part.pixelAspect));
  const auto numbers =
      std::ranges::count_if(frame.color.pixels, [](float value) { return !std::isfinite(value); });
  if (numbers > 0)
    lost.emplace_back("numbers",
                      fmt::format("values that are infinite or no numbers ({})", numbers));
  if (frame.alpha && isFilmPath(target))
    lost.emplace_back("alpha", "alpha (it is over black)");
  return lost;
}

/// What was not said of a frame before it. How far what it shows is, is said again where it is far
/// from all that was said.
/// @param reaches  of frames before it
void tell(const FoggedFrame& frame, std::set<std::string>& told, std::vector<FrameReach>& reaches,
          Progress& progress) {
  for (const FrameRemark& remark : frame.remarks) {
    if (told.insert(remark.subject).second)
      progress.remark({remark.code, remark.text, remark.hints});
  }
  if (!(frame.reach.nearest <= frame.reach.farthest))
    return;
  const bool far = std::ranges::all_of(
      reaches, [&](const FrameReach& before) { return isFarFrom(frame.reach, before); });
  if (!far)
    return;
  if (!reaches.empty()) {
    progress.remark({RemarkCode::kDoubtful,
                     fmt::format("{}; before it was {} to {} m", frame.remarks.front().text,
                                 plainNumber(reaches.front().nearest, 4),
                                 plainNumber(reaches.front().farthest, 4))});
  }
  reaches.push_back(frame.reach);
}

/// @param several  whether it is one of several frames
/// @param told  what was said of frames before it, by kinds
void tellLost(const FoggedFrame& frame, const FogFrame& names, const std::string& target,
              bool several, std::set<std::string>& told, Progress& progress) {
  const std::string of = several ? fmt::format(" of frame {}", names.number) : "";
  std::vector<std::string> others;
  for (const std::string& channel : frame.others) {
    if (extensionOf(target) == ".exr" && told.insert("channel " + channel).second)
      others.push_back(channel);
  }
  if (!others.empty()) {
    constexpr std::size_t kShown = 6;
    const std::vector<std::string> some(
        others.begin(),
        others.begin() + static_cast<std::ptrdiff_t>(std::min(others.size(), kShown)));
    progress.remark(
        {RemarkCode::kLeftOut,
         fmt::format("{}: holds colour and alpha; {} other channel{} of {} {} left out: {}{}",
                     target, others.size(), others.size() == 1 ? "" : "s",
                     several ? fmt::format("frame {}", names.number) : "the frame",
                     others.size() == 1 ? "is" : "are", fmt::join(some, ", "),
                     others.size() > kShown ? " .." : "")});
  }
  std::vector<std::string> lost;
  for (const auto& [kind, what] : lostIn(target, frame.pixels)) {
    if (told.insert("lost " + kind).second)
      lost.push_back(what);
  }
  if (!lost.empty()) {
    progress.remark({RemarkCode::kLeftOut, fmt::format("{}: does not keep {}{}; a .exr does",
                                                       target, fmt::join(lost, ", "), of)});
  }
}

Status fogPictures(const std::vector<FogFrame>& frames, FogSceneMedium& fog,
                   const std::string& target, const Arguments& arguments, Context& context) {
  const FogFrameOptions options = frameOptions(arguments);
  Development development{.style = {.dither = true}};
  VOLUTE_TRY(takeFileStyle(arguments, target, development));
  std::unique_ptr<PictureWriter> writer;
  std::set<std::string> told;
  std::vector<FrameReach> reaches;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (context.progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped before frame {}", frames[i].number);
    VOLUTE_ASSIGN(const auto fogged, fogOver(frames[i], fog, options, context));
    if (!writer && isFilmPath(target)) {
      const PixelWindow& display = fogged.pixels.part.display;
      VOLUTE_ASSIGN(writer, filmWriter(target, development, display.width(), display.height(),
                                       arguments.get<double>("fps")));
      if (const auto even = evenSizeText(target, display.width(), display.height()); !even.empty())
        context.progress.remark({RemarkCode::kChanged, even});
    } else if (!writer) {
      VOLUTE_ASSIGN(writer, imageFileWriter(target, development));
    }
    tell(fogged, told, reaches, context.progress);
    tellLost(fogged, frames[i], target, frames.size() > 1, told, context.progress);
    VOLUTE_TRY(writer->writeFrame(fogged.pixels, frames[i].number));
    context.progress.report("fog", static_cast<double>(i + 1), static_cast<double>(frames.size()));
  }
  VOLUTE_TRY(writer->finish());
  if (const auto lost = writer->halvesLost(target))
    context.progress.remark(*lost);
  return {};
}

/// What a map of fog is by the options of its table.
Result<FogDescription> fogOf(const Arguments& arguments, const std::string& map) {
  VOLUTE_ASSIGN(auto members, membersOf(fogFields(), arguments));
  members["map"] = map;
  VOLUTE_ASSIGN(auto fog, parseFog(members, {}));
  fog.rate = arguments.get<double>("fps");
  fog.byNumber = !arguments.given("time") &&
                 (arguments.given("frames") ||
                  namesSeriesOfFiles(arguments.find<std::string>("color").value_or("")));
  return fog;
}

/// --sun, --sun-radiance: at most one.
Result<std::vector<Lamp>> sunsOf(const Arguments& arguments) {
  if (!arguments.given("sun"))
    return std::vector<Lamp>{};
  VOLUTE_ASSIGN(const auto members, membersOf(sunFields(), arguments));
  VOLUTE_ASSIGN(const auto sun, readAs<Sun>(sunFields(), members, {}));
  return std::vector{lampOf(sun)};
}

/// What shadows the sun in the fog.
Result<TriangleScene> addGeometry(const Arguments& arguments, FogDescription& description,
                                  const Context& context) {
  const auto file = arguments.find<std::string>("geometry");
  if (!file)
    return TriangleScene();
  const auto up = arguments.get<std::string>("geometry-up");
  const SceneGeometry entry{*file, Mat4::Identity(),
                            up == "y"   ? UpAxis::kY
                            : up == "z" ? UpAxis::kZ
                                        : UpAxis::kFormat};
  VOLUTE_ASSIGN(auto geometry, loadGeometry({entry}, context));
  description.shadows = shadowsOf(geometry);
  return geometry;
}

/// Geometry that is elsewhere costs time and changes nothing.
void tellOfShadows(const Arguments& arguments, const TriangleScene& geometry,
                   const std::vector<Lamp>& suns, const FogMedium& fog, Progress& progress) {
  if (!arguments.given("geometry") || shadowsFog(geometry, suns, fog))
    return;
  const auto text = [](const Vec3& p) {
    return fmt::format("{},{},{}", plainNumber(p.x()), plainNumber(p.y()), plainNumber(p.z()));
  };
  const Box3 box = geometry.bounds(), air = fog.bounds();
  progress.remark(fmt::format(
      "--geometry {}: shadows none of the fog: it is at {} to {} m, the fog at {} to {} m; its "
      "upward axis is an option (--geometry-up)",
      arguments.get<std::string>("geometry"), text(box.min), text(box.max), text(air.min),
      text(air.max)));
}

/// The numbers that --frames or --duration chooses.
Result<std::optional<FrameRange>> rangeOf(const Arguments& arguments, const std::string& color) {
  const auto seconds = arguments.find<double>("duration");
  if (!seconds)
    return arguments.find<FrameRange>("frames");
  if (arguments.given("frames") || namesSeriesOfFiles(color)) {
    return fail(ErrorCode::kInvalidArgument,
                "--duration is of a film of one still; {} says how long this one is",
                arguments.given("frames") ? "--frames" : "the pattern");
  }
  const double frames = std::round(*seconds * arguments.get<double>("fps"));
  if (!(frames >= 1 && frames < 1e6))
    return fail(ErrorCode::kInvalidArgument, "--duration {} s: {:.0f} frames; expected 1 to 999999",
                plainNumber(*seconds), frames);
  FrameRange range;
  range.begin = 0, range.end = static_cast<int>(frames);
  return range;
}

/// Of a film whose fog moves or not.
/// @param names  of the frames' files, or their patterns
void tellOfFilm(const std::vector<FogFrame>& frames, const FogFrame& names,
                const FogDescription& fog, const Arguments& arguments, Progress& progress) {
  const std::string& color = names.color;
  const bool wind = fog.wind != Vec3::Zero();
  std::vector<int> numbers;
  for (const FogFrame& frame : frames) numbers.push_back(frame.number);
  const auto gaps = missingNumbers(numbers);
  const auto missing = framesWithoutColor(names, frames);
  if (!gaps.empty() && !arguments.given("frames")) {
    progress.remark({RemarkCode::kAssumed,
                     fmt::format("{}: {}; a film goes on as if there were none", color, gaps)});
  } else if (!missing.empty()) {
    progress.remark(
        {RemarkCode::kAssumed,
         fmt::format("{}: {} of the frames with a depth {} missing, the first {}", color,
                     missing.size(), missing.size() == 1 ? "is" : "are", missing.front())});
  }
  const bool moves = namesSeriesOfFiles(color) || wind || fog.maps.size() > 1 ||
                     namesSeriesOfFiles(fog.maps.front()) || !isPicturePath(fog.maps.front());
  if (frames.size() > 1 && !namesSeriesOfFiles(color) && (!moves || arguments.given("time"))) {
    progress.remark(fmt::format("{} pictures that are the same: {}", frames.size(),
                                moves ? "--time holds the fog" : "there is no wind (--wind)"));
  }
  if (frames.size() == 1 && isFilmPath(arguments.get<std::string>("output"))) {
    progress.remark(fmt::format("a film of one picture: --duration S makes a longer one{}",
                                wind ? ", in which the wind moves the fog" : ""));
  }
  if (frames.size() == 1 && wind && !arguments.given("time"))
    progress.remark("the wind has not moved the fog at 0 s: --time S is later");
  const bool film = isFilmPath(arguments.get<std::string>("output"));
  const bool sequence = fog.maps.size() > 1 || namesSeriesOfFiles(fog.maps.front()) ||
                        !isPicturePath(fog.maps.front());
  const bool blown = wind && !arguments.given("time") && frames.size() > 1;
  if (arguments.given("fps") && !film && !sequence && !blown) {
    progress.remark({RemarkCode::kLeftOut,
                     "--fps has no effect: there is neither a film nor fog that moves from picture "
                     "to picture"});
  }
  if (fog.borderInWind() == FogBorder::kRepeat && !fog.border) {
    progress.remark(
        "what the wind blows out of the map comes in on its other side: --border repeat; others "
        "are clamp and zero");
  }
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
  for (const auto& [name, of] :
       {std::pair("color-layer", "color"), std::pair("depth-channel", "depth")}) {
    const auto file = arguments.get<std::string>(of);
    if (arguments.given(name) && extensionOf(file) != ".exr")
      return fail(ErrorCode::kInvalidArgument, "--{} is for a .exr; '{}' is none", name, file);
  }
  const auto target = arguments.get<std::string>("output");
  if (!isPicturePath(target) && !isFilmPath(target)) {
    return fail(ErrorCode::kInvalidArgument,
                "--output: '{}' has an unknown format; expected .png, .exr, .mp4 or .webm", target);
  }
  if (arguments.given("path") && arguments.get<std::string>("path") != "walk" &&
      arguments.get<std::string>("renderer") == "reference")
    return fail(ErrorCode::kInvalidArgument,
                "--path has no effect: --renderer reference integrates along every ray");
  return checkTarget(target);
}

/// What is said of pictures where none is written.
Status checkShaderAlone(const Arguments& arguments) {
  for (const char* name : {"depth", "camera", "color-layer", "depth-channel", "depth-scale",
                           "depth-kind", "sky-depth", "edges", "path", "fog-only", "frames",
                           "duration", "renderer", "film-bits", "film-quality", "half"}) {
    if (arguments.given(name))
      return fail(
          ErrorCode::kInvalidArgument,
          "--{} has no effect: --export-glsl alone writes no picture; add --color, --depth, "
          "--camera and --output, or leave it out",
          name);
  }
  return {};
}

/// What shader functions of a fog do not have of it.
void tellOfShader(const FogSceneMedium& fog, const std::vector<Lamp>& suns,
                  const Arguments& arguments, Progress& progress) {
  const auto tell = [&](RemarkCode code, const std::string& text) {
    progress.remark({code, fmt::format("{}: {}", arguments.get<std::string>("export-glsl"), text)});
  };
  if (!suns.empty())
    tell(RemarkCode::kLeftOut,
         "the shader has neither the sun nor its shadows: its fog is of one colour");
  const auto& times = fog.info().times;
  const double time = arguments.find<double>("time").value_or(0);
  if (times.size() > 1) {
    tell(RemarkCode::kLeftOut, fmt::format("the shader has the map at {} s alone, of {} maps",
                                           plainNumber(time), times.size()));
  }
  if (fog.description().wind != Vec3::Zero()) {
    tell(RemarkCode::kLeftOut,
         fmt::format("the shader has the fog at {} s: the wind does not move it, but who moves "
                     "fogCorner does",
                     plainNumber(time)));
  }
  constexpr int kLargest = 16384;  // that most OpenGL has
  const FogShader shader = fogCells(fog.fogAt(time));
  if (shader.width > kLargest || shader.height > kLargest) {
    tell(RemarkCode::kDoubtful,
         fmt::format("the texture has {} x {} texels; most devices take at most {} x {}",
                     shader.width, shader.height, kLargest, kLargest));
  }
}

Status runFog(const Arguments& arguments, Context& context) {
  const auto folder = arguments.find<std::string>("export-glsl");
  const bool pictures = arguments.given("color") || arguments.given("output") || !folder;
  VOLUTE_TRY(pictures ? checkUse(arguments) : checkShaderAlone(arguments));
  VOLUTE_ASSIGN(auto description, fogOf(arguments, arguments.positional(0)));
  VOLUTE_ASSIGN(const auto suns, sunsOf(arguments));
  VOLUTE_ASSIGN(const auto geometry, addGeometry(arguments, description, context));
  VOLUTE_ASSIGN(const auto fog, FogSceneMedium::open(description, suns, context));
  tellOfShadows(arguments, geometry, suns, fog->fogAt(0), context.progress);
  Report report;
  if (folder) {
    tellOfShader(*fog, suns, arguments, context.progress);
    VOLUTE_TRY(exportFogShader(fog->fogAt(arguments.find<double>("time").value_or(0)), *folder));
    report.add("shader", *folder);
  }
  if (pictures) {
    const auto target = arguments.get<std::string>("output");
    const FogFrame names{0, arguments.get<std::string>("color"),
                         arguments.get<std::string>("depth"), arguments.get<std::string>("camera")};
    VOLUTE_ASSIGN(const auto range, rangeOf(arguments, names.color));
    VOLUTE_ASSIGN(const auto frames, fogFrames(names, range));
    if (frames.size() > 1 && !isFilmPath(target) && !namesSeries(target)) {
      return fail(ErrorCode::kInvalidArgument,
                  "{} pictures do not fit into '{}'; put %04d for the frame's number into its name",
                  frames.size(), target);
    }
    tellOfFilm(frames, names, description, arguments, context.progress);
    double milliseconds = 0;
    {
      const Stopwatch watch(milliseconds);
      VOLUTE_TRY(fogPictures(frames, *fog, target, arguments, context));
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
      {.name = "color-layer",
       .kind = kText,
       .value = "NAME",
       .help = "layer of a .exr that is the frame, such as ViewLayer.Combined; if not given, the "
               "unnamed one, or one called Combined, rgba or beauty"},
      {.name = "depth",
       .kind = kFile,
       .value = "DEPTH.exr",
       .help = "its depth as renderers write it, of the same size, or of N times that for the "
               "softest edges; 0, inf, 65504, and 1e10 or more are sky; a .png needs "
               "--depth-scale"},
      {.name = "depth-channel",
       .kind = kText,
       .value = "NAME",
       .help = "channel of the depth; if not given, as renderers call it: Z, Depth.V, "
               "ViewLayer.Depth.Z, depth.Z, or R = G = B"},
      {.name = "depth-scale",
       .kind = kNumber,
       .value = "M",
       .help = "length of a stored unit: 0.01 for centimetres; of a .png, of a step of its "
               "integers [m]",
       .positive = true},
      {.name = "camera",
       .kind = kFile,
       .value = "CAMERA.json",
       .help = "its camera, as a scene's camera object, or a .glb or .gltf with one camera"},
      {.name = "output",
       .letter = 'o',
       .kind = kOutput,
       .value = "OUT",
       .help = ".exr (linear), .png (sRGB), .mp4 or .webm; several stills need %04d"},
      {.name = "depth-kind",
       .kind = kChoice,
       .value = "KIND",
       .help = "z: along the view axis; ray: distance from the eye; inverse: 1 / z, as Nuke writes "
               "it; auto: as the file says, else z",
       .initial = "auto",
       .choices = {"auto", "z", "ray", "inverse"}},
      {.name = "sky-depth",
       .kind = kNumber,
       .value = "M",
       .help = "treat depths from here on as sky [m]",
       .positive = true},
      {.name = "edges",
       .kind = kChoice,
       .value = "HOW",
       .help = "soft: pixels between a near and a far surface are taken apart, so that smooth "
               "edges stay smooth; hard: each pixel is at its own depth",
       .initial = "soft",
       .choices = {"soft", "hard"}}};
  const auto more = fieldOptions({&fogFields(), &sunFields()});
  options.insert(options.end(), more.begin(), more.end());
  const std::vector<Option> last = {
      {.name = "fog-only",
       .help =
           "the fog without the frame, with alpha (multiplied in for .exr, straight for .png), to "
           "be put over it"},
      framesOption("numbers A <= n < B, every S-th, of patterns with %04d, or of a still's fog"),
      {.name = "duration",
       .kind = kNumber,
       .value = "S",
       .help = "of a film of one still, in which the wind or a sequence moves the fog [s]",
       .positive = true},
      rateOption("frames per second, for films, wind and sequences of maps", "25", {"rate"}),
      {.name = "time",
       .kind = kNumber,
       .value = "T",
       .help = "time of the fog, instead of the frame's number / fps [s]"},
      {.name = "geometry",
       .kind = kFile,
       .value = "FILE",
       .help = "surfaces that shadow the sun in the fog: .glb, .gltf, .obj, .vtp or a level set "
               "(.vdb) [m]",
       .beside = "sun"},
      {.name = "geometry-up",
       .kind = kChoice,
       .value = "AXIS",
       .help = "its upward axis; auto: y of .glb and .gltf, as glTF has it, z of the others",
       .initial = "auto",
       .choices = {"auto", "y", "z"},
       .beside = "geometry"},
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
  const auto film = fileStyleOptions();
  options.insert(options.end(), film.begin(), film.end());
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
          "sigma-max, without sRGB decoding, and x alpha; of a volume value x sigma-max. The "
          "bottom row has the smallest y. Maps with numbers go with the frames of the same "
          "numbers.",
      .positionals = {{.name = "MAP", .help = "the painted map of fog"}},
      .options = fogCommandOptions(),
      .run = runFog};
}

}  // namespace volute::cli
