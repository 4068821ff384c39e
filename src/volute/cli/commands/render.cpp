// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <utility>

#include "volute/base/interrupt.hpp"
#include "volute/base/write_file.hpp"
#include "volute/cli/commands/commands.hpp"
#include "volute/cli/file_kind.hpp"
#include "volute/cli/gl_pictures.hpp"
#include "volute/cli/program.hpp"
#include "volute/cli/ranks.hpp"
#include "volute/cli/scene_arguments.hpp"
#include "volute/cli/shared_options.hpp"
#include "volute/cli/values.hpp"
#include "volute/cli/volume_output.hpp"
#include "volute/film/film_job.hpp"
#include "volute/film/picture_writer.hpp"
#include "volute/film/render_request.hpp"
#include "volute/film/write_film.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/media/camera_file.hpp"
#include "volute/volume_files/volume_input.hpp"

namespace volute::cli {
namespace {

/// Where a picture is seen from, where the scene chose it.
void remarkOnCamera(const FilmJob& job, Progress& progress) {
  if (!job.cameraPath || job.cameraPath->reason.empty())
    return;
  const Vec3 &eye = job.cameraPath->view.eye, &target = job.cameraPath->view.target;
  progress.remark(
      fmt::format("seen {} (--eye {:.2f},{:.2f},{:.2f} --target {:.2f},{:.2f},{:.2f} "
                  "--fov {:g})",
                  job.cameraPath->reason, eye.x(), eye.y(), eye.z(), target.x(), target.y(),
                  target.z(), job.cameraPath->fov.value_or(0)));
}

/// A film of one picture may be meant to be longer.
void remarkOnOnePicture(const FilmJob& job, const std::string& target, const Arguments& arguments,
                        Progress& progress) {
  if (job.frames.size() != 1 || !isFilmPath(target))
    return;
  const bool moves = std::ranges::any_of(job.scene.media(),
                                         [](const auto& medium) { return medium->info().moves; });
  std::string longer;
  if (moves && arguments.given("time"))
    longer = ": --time holds the fog";
  else if (moves && !leaderOf(job.scene))
    longer = fmt::format(": --frames 0:{:.0f} makes ten seconds, in which the wind moves the fog",
                         10 * arguments.find<double>("fps").value_or(kUsualRate));
  progress.remark("a film of one picture" + longer);
}

/// What --aov names, where it takes a .exr with named channels, and --alpha; empty: it is one
/// picture.
Result<std::vector<std::string>> layersOf(const Arguments& arguments, const std::string& target) {
  if (arguments.flag("alpha")) {
    if (!isPicturePath(target))
      return fail(ErrorCode::kInvalidArgument, "--alpha is for .png and .exr; '{}' is none",
                  target);
    return std::vector<std::string>{"beauty", "alpha"};
  }
  const auto aov = arguments.find<std::string>("aov").value_or("");
  VOLUTE_ASSIGN(auto layers, ofOption("aov", parseLayers(aov)));
  if (!layers.empty() && extensionOf(target) != ".exr") {
    return fail(
        ErrorCode::kInvalidArgument,
        "--aov {}: only a .exr has room for it; {} shows optical-depth or transmittance alone", aov,
        target);
  }
  return layers;
}

/// Whether the command line asks for a contour of the visibility S = C / K.
bool contoursVisibility(const Arguments& arguments) {
  return arguments.given("isosurface") ||
         (arguments.given("slice") && arguments.get<std::string>("slice-shows") == "visibility");
}

/// --mode and --C change the law of a scene. A C that changes nothing is refused on the command
/// line, and remarked on in a scene.
Status takeLaw(const Arguments& arguments, Scene& scene, Progress& progress) {
  PictureLaw law = scene.law();
  if (const auto mode = arguments.findGiven<std::string>("mode")) {
    VOLUTE_ASSIGN(law.mode, pictureMode(*mode));
  }
  if (const auto c = arguments.findGiven<std::string>("C"); c && scene.isFile()) {
    auto found = visibilityLaw(*c);
    if (!found)
      return fail(ErrorCode::kInvalidArgument, "--C: {}", found.error().message);
    law.c = found->c;
  }
  scene.setLaw(law);
  if (law.mode == PictureMode::kThreshold || contoursVisibility(arguments))
    return {};
  constexpr std::string_view kIdleC =
      "plays no part in a photometric picture; choose the mode threshold, or leave it out";
  if (arguments.given("C") && scene.isFile())
    return fail(ErrorCode::kInvalidArgument, "--C: {}", kIdleC);
  for (std::size_t i = 0; i < scene.media().size(); ++i) {
    if (!scene.media()[i]->info().lawByC)
      continue;
    if (!scene.isFile())
      return fail(ErrorCode::kInvalidArgument, "--C: {}", kIdleC);
    progress.remark(
        {RemarkCode::kDoubtful,
         fmt::format("{}: {}/C: {}", scene.path(), scene.description().media[i].path, kIdleC)});
  }
  return {};
}

/// What OpenGL does not draw; empty when it draws all.
std::string_view beyondGl(const Arguments& arguments) {
  for (const char* option : {"slice", "isosurface"}) {
    if (arguments.given(option))
      return option;
  }
  return "";
}

/// `auto` takes OpenGL where hardware draws all that is asked for.
Result<std::unique_ptr<SceneRenderer>> rendererOf(const Arguments& arguments, bool together) {
  const auto name = arguments.get<std::string>("renderer");
  const auto beyond = beyondGl(arguments);
  if (name == "gl" && !beyond.empty()) {
    return fail(ErrorCode::kUnsupported,
                "--renderer gl does not draw --{} yet; choose cpu or leave it out", beyond);
  }
  const bool gl = name == "gl" || (name == "auto" && beyond.empty() && !together && glIsLikely());
  if (gl) {
    VOLUTE_ASSIGN(const auto method, smokeMethodOf(arguments, true));
    auto renderer = openGlRenderer(name == "auto", method);
    if (renderer || name == "gl") {
      if (!renderer)
        renderer.error().hints = {Hint::set("renderer", "cpu")};
      return renderer;
    }
  }
  VOLUTE_TRY(smokeMethodOf(arguments, false));
  return std::make_unique<CpuRenderer>(name == "reference" ? Renderer::kReference : Renderer::kCpu);
}

/// --slice and --isosurface; nothing when neither is given.
Result<std::optional<Contour>> contourOf(const Arguments& arguments, const Scene& scene) {
  const auto slice = arguments.find<std::string>("slice");
  const auto surface = arguments.find<double>("isosurface");
  if (!slice && !surface)
    return std::nullopt;
  Contour contour;
  if (slice) {
    VOLUTE_ASSIGN(contour, parseSlice(*slice));
    const auto shows = arguments.get<std::string>("slice-shows");
    contour.shows = shows == "extinction"      ? Contour::Shows::kExtinction
                    : shows == "concentration" ? Contour::Shows::kConcentration
                                               : Contour::Shows::kVisibility;
  } else {
    contour.kind = Contour::Kind::kSurface;
    contour.visibility = *surface;
  }
  contour.c = scene.law().c;
  VOLUTE_TRY(checkContour(contour, scene));
  return contour;
}

/// One ray through each pixel's centre, the file's own basis, light in proportion.
bool isMeasured(const Arguments& arguments) {
  return arguments.flag("measured") || arguments.given("aov") ||
         arguments.get<std::string>("renderer") == "reference";
}

/// 0 stands for auto.
Result<double> exposureOf(const Arguments& arguments) {
  const auto text = arguments.get<std::string>("exposure");
  if (text == "auto")
    return 0;
  const auto number = parseNumber(text);
  if (number && *number > 0)
    return *number;
  return fail(ErrorCode::kInvalidArgument,
              "--exposure: '{}' is neither auto nor a number greater than 0", text);
}

Result<RenderRequest> requestOf(const Arguments& arguments, const std::string& target) {
  RenderRequest request;
  request.frames = {target,
                    arguments.find<double>("time"),
                    arguments.find<FrameRange>("frames"),
                    arguments.get<double>("speed"),
                    arguments.find<double>("orbit"),
                    arguments.find<double>("fps").value_or(kUsualRate)};
  VOLUTE_TRY(takeCamera(arguments, request));
  request.size = arguments.find<Pixels>("size");
  if (arguments.flag("alpha"))
    request.background = Rgb::Zero(), request.legend = false;
  if (arguments.given("background"))
    request.background = Rgb(arguments.get<Vec3>("background").array());
  if (request.background && !(*request.background >= 0).all())
    return fail(ErrorCode::kInvalidArgument,
                "--background: radiance is 0 or more in each of its three numbers");
  const auto aov = arguments.find<std::string>("aov");
  request.aov = aov == "transmittance"   ? Aov::kTransmittance
                : aov == "optical-depth" ? Aov::kOpticalDepth
                                         : Aov::kNone;
  request.measured = isMeasured(arguments);
  VOLUTE_ASSIGN(request.exposure, exposureOf(arguments));
  VOLUTE_TRY(takeTone(arguments.get<std::string>("tone"), request));
  request.bloom = arguments.find<double>("bloom").value_or(0);
  request.samples = arguments.get<int>("samples");
  request.shutter = arguments.find<double>("shutter").value_or(0);
  const auto map = arguments.get<std::string>("colormap");
  if (map != "grey")
    request.colors = map == "viridis" ? ColorMap::kViridis : ColorMap::kInferno;
  if (arguments.flag("legend") || arguments.flag("no-legend"))
    request.legend = arguments.flag("legend");
  return request;
}

/// --partial: for an interrupted picture, where it can be kept, and for the damage of .volute
/// files.
Status takePartial(const Arguments& arguments, int ranks, FilmJob& job) {
  if (!arguments.flag("partial"))
    return {};
  job.partial = job.frames.size() == 1 && ranks == 1 && !job.contour &&
                job.options.aov == Aov::kNone && job.layers.empty() && !(job.shutter > 0);
  if (job.partial) {
    Interrupt::expectWriting();
    return {};
  }
  const FileKind file = readKind(arguments.positional(0));
  if (file.kind == kSceneKind || file.kind == kVoluteKind)
    return {};
  return fail(ErrorCode::kInvalidArgument,
              "--partial changes nothing here: it keeps the drawn part of an interrupted picture "
              "(one picture, by one process, without --aov, --slice and --isosurface), or the "
              "intact part of a damaged .volute");
}

/// Of several pictures of what has frames of its own.
/// @param ratedFile  whether a rate says when they are
Status refuseIdleRate(const Arguments& arguments, const std::string& target, const FilmJob& job,
                      bool ratedFile) {
  const SceneMedium* leader = leaderOf(job.scene);
  if (!leader || leader->info().times.size() < 2)
    return {};
  const MediumInfo& info = leader->info();
  const bool between = info.interpolates && (isFilmPath(target) || arguments.given("shutter"));
  if (arguments.given("speed") && !between && !isFilmPath(target))
    return fail(ErrorCode::kInvalidArgument,
                "--speed has no effect: single pictures show the frames of {} at their own times",
                info.file);
  if (!arguments.given("fps") || between || ratedFile)
    return {};
  return fail(ErrorCode::kInvalidArgument,
              "--fps has no effect: the frames of {} have times of their own{}", info.file,
              job.scene.isFile() ? "; \"fps\" of a volume in the scene sets them" : "");
}

/// What says nothing of one picture.
Status refuseIdleView(const Arguments& arguments, const std::string& target, const FilmJob& job) {
  const auto& media = job.scene.description().media;
  const bool ratedFile = !job.scene.isFile() && media.front().kind->fields().find("fps");
  if (isFilmPath(target) || job.frames.size() > 1)
    return refuseIdleRate(arguments, target, job, ratedFile);
  if (arguments.given("shutter"))
    return {};
  const bool rated = arguments.given("frames") || ratedFile;
  for (const auto& [name, idle] : {std::pair("speed", true), std::pair("fps", !rated)}) {
    if (arguments.given(name) && idle)
      return fail(ErrorCode::kInvalidArgument, "--{} has no effect on one picture", name);
  }
  return {};
}

/// What is measured is not rounded.
Status refuseHalf(const Arguments& arguments, const FilmJob& job) {
  const bool light = std::ranges::any_of(
      job.layers, [](const auto& layer) { return layer == "beauty" || layer == "alpha"; });
  if (!arguments.flag("half") || !arguments.given("aov") || light)
    return {};
  return fail(ErrorCode::kInvalidArgument,
              "--half is for colours and alpha; --aov {} is measured and stays float32: leave one "
              "of them out",
              arguments.get<std::string>("aov"));
}

/// A slice or an isosurface shows values, not light.
Status refuseInContour(const Arguments& arguments) {
  const auto contour = beyondGl(arguments);
  for (const char* name : {"samples", "scattering", "albedo", "asymmetry", "background"}) {
    if (!contour.empty() && arguments.given(name))
      return fail(ErrorCode::kInvalidArgument,
                  "--{} has no effect on --{}, which shows values and no light", name, contour);
  }
  return {};
}

Result<FilmJob> makeJob(const Arguments& arguments, const std::string& target,
                        const RenderRequest& request, Context& context) {
  FilmTotals totals;
  auto opened = [&] {
    const Stopwatch watch(totals.open);
    return openScene(arguments.positional(0), arguments, context, request.measured);
  }();
  VOLUTE_TRY(opened);
  FilmJob job{std::move(*opened), Camera::framing({}, 1, 1), {}, nullptr};
  job.totals = std::move(totals);
  Scene& scene = job.scene;
  VOLUTE_TRY(takeLaw(arguments, scene, context.progress));
  VOLUTE_ASSIGN(job.layers, layersOf(arguments, target));
  VOLUTE_TRY(refuseHalf(arguments, job));
  job.together = arguments.flag("by-pieces") && context.team.size() > 1;
  if (arguments.flag("by-pieces") && !job.together) {
    context.progress.remark({RemarkCode::kLeftOut,
                             "--by-pieces has no effect: there is one process, which holds all; "
                             "mpirun starts several"});
  }
  if (job.together && !scene.media().empty() && !scene.media().front()->info().sharesAll &&
      scene.media().front()->info().times.size() > 1 && !arguments.given("time") &&
      !arguments.given("frames")) {
    return fail(
        ErrorCode::kUnsupported,
        "--by-pieces: ranks do not look for a time that has something to see; add --time or "
        "--frames");
  }
  VOLUTE_ASSIGN(job.contour, contourOf(arguments, scene));
  VOLUTE_TRY(prepare(job, request, context.maxMemory, context.progress));
  VOLUTE_TRY(refuseIdleView(arguments, target, job));
  if (!job.reason.empty())
    context.progress.remark(job.reason + "; --time or --frames choose others");
  remarkOnCamera(job, context.progress);
  remarkOnOnePicture(job, target, arguments, context.progress);
  VOLUTE_ASSIGN(job.renderer, rendererOf(arguments, job.together));
  job.mayFallBack = arguments.get<std::string>("renderer") == "auto";
  job.tree = arguments.get<std::string>("volume-method") == "tree";
  VOLUTE_TRY(ofOption("by-pieces", checkTogether(job)));
  VOLUTE_TRY(takePartial(arguments, context.team.size(), job));
  VOLUTE_TRY(scaleContour(job, context.progress, context.team));
  return job;
}

/// What makes light visible, and nothing else, is for pictures that measure nothing.
Status refuseInMeasured(const Arguments& arguments) {
  if (!isMeasured(arguments))
    return {};
  const bool toned = arguments.given("tone") && arguments.get<std::string>("tone") != "none";
  const bool smooth = arguments.given("samples") && arguments.get<int>("samples") > 1;
  for (const auto& [name, given] :
       {std::pair("tone", toned), std::pair("bloom", arguments.given("bloom")),
        std::pair("samples", smooth),
        std::pair("scattering",
                  arguments.find<std::string>("scattering") == std::string("multiple"))}) {
    if (!given)
      continue;
    const char* measured = arguments.flag("measured") ? "--measured"
                           : arguments.given("aov")   ? "--aov"
                                                      : "--renderer reference";
    return fail(ErrorCode::kInvalidArgument,
                "--{} changes light; {} shows it as it is: leave one of them out", name, measured);
  }
  return {};
}

/// What shows nothing in the kind of picture that is written.
Status refuseIdleLight(const Arguments& arguments, const std::string& target, Progress& progress) {
  const auto aov = arguments.find<std::string>("aov").value_or("");
  for (const char* name : {"background", "emission"}) {
    if (arguments.given(name) && (aov == "optical-depth" || aov == "transmittance"))
      progress.remark({RemarkCode::kLeftOut,
                       fmt::format("--{} has no effect: --aov {} shows no light", name, aov)});
  }
  const auto exposure = arguments.get<std::string>("exposure"),
             tone = arguments.get<std::string>("tone");
  const bool exposed = exposure != "auto" && parseNumber(exposure) != 1;
  const bool toned = tone != "auto" && tone != "none";
  for (const auto& [name, given] : {std::pair("exposure", exposed), std::pair("tone", toned),
                                    std::pair("bloom", arguments.given("bloom")),
                                    std::pair("legend", arguments.given("legend")),
                                    std::pair("colormap", arguments.given("colormap"))}) {
    if (given && extensionOf(target) == ".exr")
      return fail(ErrorCode::kInvalidArgument,
                  "--{} has no effect: a .exr holds light as it is; write a .png or a film", name);
  }
  return {};
}

Status checkRenderTargets(const Arguments& arguments, const std::string& target) {
  if (!isPicturePath(target) && !isFilmPath(target)) {
    return fail(ErrorCode::kInvalidArgument,
                "--output: '{}' has an unknown format; expected .png, .exr, .mp4 or .webm", target);
  }
  if (const auto stats = arguments.find<std::string>("stats"))
    VOLUTE_TRY(checkTarget(*stats, true));
  return checkTarget(target);
}

/// What a picture and the samples at its edges need, the next ones need again.
void keepPictures(const Camera& camera) {
  constexpr std::size_t kOfAPixel = 64;  // bytes: colours, depths, light and shares of it
  keepFreedMemory(kOfAPixel * static_cast<std::size_t>(camera.width()) *
                  static_cast<std::size_t>(camera.height()));
}

Status runRender(const Arguments& arguments, Context& context) {
  const auto target = arguments.get<std::string>("output");
  VOLUTE_TRY(checkRenderTargets(arguments, target));
  VOLUTE_TRY(refuseInMeasured(arguments));
  VOLUTE_TRY(refuseIdleLight(arguments, target, context.progress));
  VOLUTE_TRY(refuseInContour(arguments));
  if (!isFilmPath(target))
    VOLUTE_TRY(checkFolderIsShared(target, context.team));
  VOLUTE_ASSIGN(const auto request, requestOf(arguments, target));
  VOLUTE_ASSIGN(auto job, makeJob(arguments, target, request, context));
  keepPictures(job.camera);
  VOLUTE_ASSIGN(auto development, developmentOf(request, job));
  VOLUTE_TRY(takeFileStyle(arguments, target, development));
  VOLUTE_TRY(
      writeFilm(job, target, development, context.maxMemory, context.progress, context.team));
  VOLUTE_ASSIGN(const auto stats, sumOfFilmStats(job, context.team));
  VOLUTE_TRY(writeStats(arguments, context, stats));
  if (context.json) {
    Report report;
    report.add("output", target)
        .add("exposure", development.style.exposure)
        .add("tone", development.style.view ? development.style.view->name()
                                            : std::string(nameOf(development.style.tone)));
    auto json = report.json();
    json.update(stats);
    context.printJson(std::move(json));
  }
  return {};
}

std::vector<Option> renderOptionTable() {
  using enum ValueKind;
  std::vector<Option> options = {
      outputOption("OUT",
                   ".png, .exr (linear values), .mp4 or .webm; several stills need %04d for the "
                   "frame's number",
                   ".png"),
      {.name = "size",
       .kind = kPixels,
       .value = "WxH",
       .help = "size of the picture [pixels]; if not given, that of the camera file, else 800x600"},
      {.name = "time", .kind = kNumber, .value = "T", .help = "show the frame at T [s]"},
      framesOption(),
      {.name = "renderer",
       .kind = kChoice,
       .value = "NAME",
       .help = "renderer; auto: gl with a suitable graphics card, else cpu",
       .initial = "auto",
       .choices = {"auto", "cpu", "gl", "reference"}},
      smokeMethodOption(": march from face to face, or projected tetrahedra; auto: projected on a "
                        "rasteriser that runs on the CPU, else march",
                        {"smoke", kSceneKind}),
      {.name = "volume-method",
       .kind = kChoice,
       .value = "NAME",
       .help = "how a .volute is drawn: bricks of the file's own values, or the tree of 16 frames "
               "in memory, which rounds them once more and which OpenGL walks for each voxel",
       .initial = "bricks",
       .choices = {"bricks", "tree"},
       .kinds = {"volume", kSceneKind}},
      {.name = "camera",
       .kind = kFile,
       .value = "FILE.json",
       .help = "camera, as a scene's camera object: eye, target, up, fov or ortho, size"},
      {.name = "orbit",
       .kind = kNumber,
       .value = "DEGREES",
       .help = "turn the camera around its target, counterclockwise from above, by this angle "
               "over a film or sequence; a single frame turns once in 10 s"},
      {.name = "aov",
       .kind = kText,
       .value = "NAME,..",
       .help = "write measured channels instead of a picture: optical-depth or transmittance as "
               "one channel Y, or for a .exr several of beauty (R, G, B), alpha (A), z (Z, depth "
               "at which half of the light is lost [m]), transmittance, optical-depth"},
      {.name = "slice",
       .kind = kText,
       .value = "AXIS=M",
       .help = "show local values on a plane instead of the smoke, such as z=1.8 [m]; for smoke "
               "on a mesh"},
      {.name = "slice-shows",
       .kind = kChoice,
       .value = "NAME",
       .help = "quantity on the plane: the local visibility S = C / K up to 30 m, the extinction "
               "K, or the concentration (mass per volume) in the field's unit",
       .initial = "visibility",
       .choices = {"visibility", "extinction", "concentration"},
       .beside = "slice"},
      {.name = "isosurface",
       .kind = kNumber,
       .value = "S",
       .help = "show the surface of local visibility C / K = S [m] instead of the smoke",
       .positive = true},
      {.name = "exposure",
       .kind = kText,
       .value = "S|auto",
       .help = "exposure factor for .png and films; auto: brightest parts near white, once for "
               "all pictures of a sequence",
       .initial = "auto"},
      {.name = "tone",
       .kind = kText,
       .value = "NAME",
       .help =
           "tone curve for .png and films: filmic and agx desaturate bright light, shoulder "
           "dims colours above 0.7 and keeps their hue, none clips; auto: filmic; for measured "
           "transmittance none, with flames shoulder; by OpenColorIO: aces (ACES 1.0 for sRGB), "
           "ocio, ocio:VIEW or ocio:DISPLAY/VIEW of the configuration that $OCIO names",
       .initial = "auto"},
      {.name = "bloom",
       .kind = kNumber,
       .value = "S",
       .help = "share of the light that glows around its source; the total is preserved",
       .least = 0,
       .most = 1},
      {.name = "shutter",
       .kind = kNumber,
       .value = "S",
       .help =
           "motion blur: the mean of the light from each frame on, over S of the time to the next "
           "frame (0.5: 180 degrees), of as many instants as change no value by more than 1/256 "
           "of the brightest; a file alone moves as --interpolate auto says",
       .most = 1,
       .positive = true},
      {.name = "samples",
       .kind = kInteger,
       .value = "N",
       .help = "rays per pixel at edges; 1 elsewhere",
       .initial = "8",
       .least = 1,
       .most = 256},
      {.name = "by-pieces",
       .help = "each rank (mpirun) holds some pieces of a .pvtu or some meshes of an FDS case, and "
               "all draw each picture together: for what is larger than the memory of one machine"},
      {.name = "measured",
       .help = "light as it is, for measurements: one ray through each pixel's centre, the file's "
               "own basis (box if it states none), no preset, tone curve, bloom or dithering; "
               "implied by --aov and --renderer reference"},
      {.name = "background",
       .kind = kVector,
       .value = "R,G,B",
       .help = "linear radiance behind the volume",
       .initial = "0,0,0"},
      {.name = "alpha",
       .help = "write what hides the background as alpha, without a background: into a .png "
               "straight (colours are not multiplied by it; flames have as much alpha as they are "
               "bright, so that in linear light all is over black as without --alpha), into a "
               ".exr premultiplied"},
      {.name = "scattering",
       .kind = kChoice,
       .value = "HOW",
       .help = "how often light is scattered: single is exact, multiple an approximation that is "
               "brighter in dense clouds; if not given, the scene's, else single",
       .choices = {"single", "multiple"}},
      {.name = "colormap",
       .kind = kChoice,
       .value = "NAME",
       .help = "colour map of volumes with one channel, in .png and films; a file's values are "
               "shown without a preset then, unless --preset is given",
       .initial = "grey",
       .choices = {"grey", "viridis", "inferno"}},
      {.name = "speed",
       .kind = kNumber,
       .value = "S",
       .help = "seconds of smoke per second of film",
       .initial = "1",
       .positive = true},
      rateOption("frames per second of a sequence, whose frame n is at (n - first) / F, and of a "
                 "film; if not given, the times that the files state, else 25"),
      {.name = "legend", .help = "draw mode, field, C, time and colour scale into .png and films"},
      {.name = "no-legend", .help = "no legend in pictures of an FDS case alone"},
      statsOption(),
      {.name = "partial",
       .help = "use the intact part of a damaged .volute; of a single picture that is interrupted, "
               "write what is drawn"}};
  auto camera = fieldOptions({&cameraFields()});
  for (Option& option : camera) option.kinds.clear();
  std::ranges::find(camera, "up", &Option::name)->instead = "file-up";
  for (const auto& more : {camera, mediumOptions(), lightCacheOptions(), fileStyleOptions()})
    options.insert(options.end(), more.begin(), more.end());
  return options;
}

}  // namespace

Command renderCommand() {
  return {
      .name = "render",
      .summary = "Renders pictures or films of volumes, smoke, FDS cases and scenes",
      .examples = {"volute render fire.volute",
                   "volute render fire.volute -o fire.png --size 640x480 --time 0.8",
                   "volute render fire.volute -o fire.mp4 --frames 0:48",
                   "volute render smoke.volute -o depth.exr --aov optical-depth --eye 0,-4,1 "
                   "--target 0,0,1 --fov 40"},
      .description =
          "Integrates emission and absorption along each pixel's ray, exactly for the volume's "
          "basis. Without a camera, the bounds are framed; what is left out of --eye, --target, "
          "--up, --fov and --ortho is the scene's camera's, or of the view that frames the bounds. "
          "An FDS case is shown from outside as a "
          "cutaway (--building inside: from within its largest room, at eye level). .exr files "
          "hold linear values; .png and films are exposed and sRGB. --exposure auto uses one "
          "factor for all pictures, from some of them, and prints it. Without --time and "
          "--frames, a film or a pattern shows all frames; a single still shows the first frame "
          "with visible content, for an FDS case a time with smoke in its rooms, for a scene 0 s.",
      .positionals = {{.name = "FILE",
                       .help = "a volume (.volute, .npy, .npz, .vdb, .nvdb, .vti, .pvd, .nc, .h5, "
                               ".zarr), smoke on a mesh "
                               "(.vtu, .vtk, .pvd, .case, .e, "
                               ".foam), an FDS case (.smv) or a scene (.json)"}},
      .options = renderOptionTable(),
      .oneOf = {{{"time", "frames"}, false},
                {{"legend", "no-legend"}, false},
                {{"fov", "ortho"}, false},
                {{"slice", "isosurface", "aov", "alpha"}, false},
                {{"alpha", "background"}, false},
                {{"alpha", "legend"}, false},
                {{"alpha", "colormap"}, false}},
      .ranks = true,
      .run = runRender};
}

}  // namespace volute::cli
