// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/render/render.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "volute/base/write_file.hpp"
#include "volute/cli/camera_arguments.hpp"
#include "volute/cli/commands/commands.hpp"
#include "volute/cli/picture_writer.hpp"
#include "volute/cli/render_moments.hpp"
#include "volute/cli/smoke_arguments.hpp"
#include "volute/cli/volume_output.hpp"
#include "volute/image/srgb.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/scene/camera_file.hpp"
#include "volute/scene/smoke_words.hpp"

namespace volute::cli {
namespace {

constexpr Pixels kUsualSize{800, 600};

Result<Camera> chooseCamera(const Arguments& arguments, const RenderSubject& subject) {
  VOLUTE_ASSIGN(auto description, cameraOf(arguments));
  if (!description)
    description = subject.camera;
  if (!description && subject.layers.empty() && subject.smokes.empty())
    description = subject.fdsCases.front().firstCamera();
  Pixels size = arguments.find<Pixels>("size").value_or(kUsualSize);
  if (!description) {
    const Box3 bounds = !subject.layers.empty()   ? subject.layers.front().info().bounds
                        : !subject.smokes.empty() ? subject.smokes.front().bounds()
                                                  : subject.fdsCases.front().bounds();
    return Camera::framing(bounds, size.width, size.height);
  }
  if (!arguments.given("size"))
    size = description->size.value_or(kUsualSize);
  return makeCamera(*description, size);
}

/// The linear picture, what is made of it, and its bytes for the file.
Status checkPictureMemory(const Camera& camera, const Context& context) {
  constexpr std::uint64_t kBytesAPixel = 32;
  const std::uint64_t bytes = kBytesAPixel * camera.width() * camera.height();
  if (bytes <= context.maxMemory)
    return {};
  return fail(ErrorCode::kTooLarge,
              "a picture of {} x {} pixels needs {} MiB of memory, more than the {} MiB allowed; "
              "raise --max-memory",
              camera.width(), camera.height(), (bytes >> 20) + 1, context.maxMemory >> 20);
}

RenderOptions renderOptions(const Arguments& arguments, const RenderSubject& subject) {
  RenderOptions options;
  const auto renderer = arguments.get<std::string>("renderer");
  options.renderer = renderer == "reference" ? Renderer::kReference : Renderer::kCpu;
  options.background = arguments.given("background")
                           ? Rgb(arguments.get<Vec3>("background").array())
                           : subject.background;
  if (const auto aov = arguments.find<std::string>("aov")) {
    options.aov = *aov == "transmittance" ? Aov::kTransmittance : Aov::kOpticalDepth;
  }
  return options;
}

/// What OpenGL does not draw; empty when it draws all.
std::string_view beyondGl(const Arguments& arguments) {
  for (const char* option : {"slice", "isosurface"}) {
    if (arguments.given(option))
      return option;
  }
  return "";
}

/// An option that is about OpenGL alone, unless it is as it is by itself.
Status checkGlMethod(std::string_view option, const std::string& name, const GlPictures* gl) {
  if (gl != nullptr || name == "auto" || name == "bricks")
    return {};
  return fail(ErrorCode::kInvalidArgument,
              "--{}: {} is a way to draw with OpenGL; add --renderer gl", option, name);
}

Result<GlSmokeMethod> smokeMethodOf(const Arguments& arguments, const GlPictures* gl) {
  const auto name = arguments.get<std::string>("smoke-method");
  VOLUTE_TRY(checkGlMethod("smoke-method", name, gl));
  return name == "auto"    ? GlSmokeMethod::kAuto
         : name == "march" ? GlSmokeMethod::kMarch
         : name == "splat" ? GlSmokeMethod::kSplat
                           : GlSmokeMethod::kProject;
}

Result<GlVolumeMethod> volumeMethodOf(const Arguments& arguments, const GlPictures* gl) {
  const auto name = arguments.get<std::string>("volume-method");
  VOLUTE_TRY(checkGlMethod("volume-method", name, gl));
  return name == "tree" ? GlVolumeMethod::kTree : GlVolumeMethod::kBricks;
}

/// Null for the processor. `auto` takes OpenGL where hardware draws all that the subject has.
Result<std::shared_ptr<GlPictures>> chooseGl(const Arguments& arguments) {
  const auto renderer = arguments.get<std::string>("renderer");
  const auto beyond = beyondGl(arguments);
  if (renderer == "gl" && !beyond.empty()) {
    return fail(ErrorCode::kUnsupported,
                "--renderer gl does not draw --{} yet; choose cpu or leave it out", beyond);
  }
  if (renderer == "gl") {
    auto gl = GlPictures::open(false);
    if (!gl)
      gl.error().message += "; or choose --renderer cpu";
    return gl;
  }
  if (renderer != "auto" || !beyond.empty() || !glIsLikely())
    return nullptr;
  auto gl = GlPictures::open(true);
  return gl ? std::move(*gl) : nullptr;
}

/// One plane has one scale of mass per volume.
Status checkConcentrations(std::span<const SmokeLayer> smokes) {
  const SmokeModel& first = smokes.front().description().model;
  for (const SmokeLayer& smoke : smokes) {
    const SmokeModel& model = smoke.description().model;
    if (!holdsMass(model.quantity)) {
      return fail(ErrorCode::kInvalidArgument,
                  "--slice-shows concentration: field '{}' of {} holds {}, which tells no mass per "
                  "volume; choose visibility or extinction",
                  smoke.fieldName(), smoke.description().file, nameOf(model.quantity));
    }
    if (model.quantity != first.quantity || unitOfField(model) != unitOfField(first)) {
      return fail(ErrorCode::kInvalidArgument,
                  "--slice-shows concentration: {} holds {} [{}] and {} {} [{}], which have no "
                  "scale in common; choose visibility or extinction",
                  smokes.front().description().file, nameOf(first.quantity), unitOfField(first),
                  smoke.description().file, nameOf(model.quantity), unitOfField(model));
    }
  }
  return {};
}

/// --slice and --isosurface; nothing when neither is given.
Result<std::optional<SmokeContour>> contourOf(const Arguments& arguments, const RenderJob& job) {
  const auto slice = arguments.find<std::string>("slice");
  const auto surface = arguments.find<double>("isosurface");
  if (!slice && arguments.given("slice-shows"))
    return fail(ErrorCode::kInvalidArgument, "--slice-shows is of a plane; add --slice, as z=1.8");
  if (!slice && !surface)
    return std::nullopt;
  const char* option = slice ? "--slice" : "--isosurface";
  if (job.smokes.empty())
    return fail(ErrorCode::kInvalidArgument, "{} is for smoke on a mesh; there is none", option);
  SmokeContour contour;
  if (slice) {
    VOLUTE_ASSIGN(contour, parseSlice(*slice));
    Box3 bounds;
    for (const SmokeLayer& smoke : job.smokes) {
      bounds.extend(smoke.bounds().min);
      bounds.extend(smoke.bounds().max);
    }
    const double low = bounds.min[contour.axis], high = bounds.max[contour.axis];
    if (!(contour.place >= low && contour.place < high)) {
      return fail(ErrorCode::kInvalidArgument,
                  "--slice: {} misses the mesh, which reaches from {:.6g} to {:.6g} m along {}",
                  *slice, low, high, "xyz"[contour.axis]);
    }
  }
  if (surface) {
    contour.kind = SmokeContour::Kind::kSurface;
    contour.visibility = *surface;
  }
  contour.c = job.law.c;
  if (!slice)
    return contour;
  const auto shows = arguments.get<std::string>("slice-shows");
  if (shows == "extinction")
    contour.shows = SmokeContour::Shows::kExtinction;
  if (shows == "concentration") {
    contour.shows = SmokeContour::Shows::kConcentration;
    VOLUTE_TRY(checkConcentrations(job.smokes));
  }
  return contour;
}

/// The scale of a slice's extinction or concentration, from all that will be shown.
Status scaleContour(RenderJob& job) {
  if (!job.contour || job.contour->shows == SmokeContour::Shows::kVisibility)
    return {};
  double most = 0;
  for (const Moment& moment : job.moments) {
    for (SmokeLayer& smoke : job.smokes) {
      VOLUTE_ASSIGN(const SmokeState state, smoke.at(moment.time));
      most = std::max(most, mostOn(*job.contour, {&state, 1}));
    }
  }
  job.contour->most = most > 0 ? most : 1;
  return {};
}

Result<RenderJob> makeJob(const Arguments& arguments, const std::string& target, Context& context) {
  const std::string& path = arguments.positional(0);
  RenderTotals totals;
  RenderSubject subject;
  {
    const Stopwatch watch(totals.open);
    VOLUTE_ASSIGN(subject, openSubject(path, arguments, context));
  }
  VOLUTE_ASSIGN(auto moments, momentsOf(arguments, subject, target, context.progress));
  VOLUTE_ASSIGN(const auto camera, chooseCamera(arguments, subject));
  VOLUTE_TRY(checkPictureMemory(camera, context));
  const bool smokeLeads = subject.layers.empty() && !subject.smokes.empty();
  const bool stepsLead = smokeLeads || (subject.layers.empty() && !subject.fdsCases.empty());
  const double rate = stepsLead ? kUsualRate : framesPerSecond(moments);
  const RenderOptions options = renderOptions(arguments, subject);
  VOLUTE_ASSIGN(auto gl, chooseGl(arguments));
  RenderJob job{std::move(subject.layers),
                std::move(subject.fogs),
                camera,
                options,
                std::move(moments),
                rate,
                totals};
  job.gl = std::move(gl);
  job.glIsWish = arguments.get<std::string>("renderer") == "auto";
  VOLUTE_ASSIGN(job.smokeMethod, smokeMethodOf(arguments, job.gl.get()));
  VOLUTE_ASSIGN(job.volumeMethod, volumeMethodOf(arguments, job.gl.get()));
  job.smokes = std::move(subject.smokes);
  job.signs = std::move(subject.signs);
  job.law = subject.law;
  job.lights = std::move(subject.lights);
  job.geometry = subject.geometry;
  job.billboards = std::move(subject.billboards);
  job.fdsCases = std::move(subject.fdsCases);
  job.legend = arguments.flag("legend");
  job.measuresLight = stepsLead && !subject.scene;
  VOLUTE_ASSIGN(job.contour, contourOf(arguments, job));
  VOLUTE_TRY(scaleContour(job));
  return job;
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

Result<Development> developmentOf(const Arguments& arguments, const RenderJob& job) {
  Development development;
  VOLUTE_ASSIGN(development.exposure, exposureOf(arguments));
  const auto map = arguments.get<std::string>("colormap");
  if (map == "grey")
    return development;
  for (const VolumeLayer& layer : job.layers) {
    if (layer.info().channels == 1 || job.options.aov != Aov::kNone)
      continue;
    return fail(ErrorCode::kInvalidArgument,
                "--colormap is for volumes with one channel and for --aov; this one is RGB");
  }
  if ((!job.fogs.empty() || !job.smokes.empty() || !job.geometry.empty()) &&
      job.options.aov == Aov::kNone) {
    return fail(ErrorCode::kInvalidArgument,
                "--colormap is for volumes with one channel and for --aov; this shows {}",
                !job.fogs.empty()     ? "fog"
                : !job.smokes.empty() ? "smoke"
                                      : "surfaces");
  }
  development.colorMap = map == "viridis" ? ColorMap::kViridis : ColorMap::kInferno;
  return development;
}

Result<std::unique_ptr<PictureWriter>> writerFor(const std::string& target, const RenderJob& job,
                                                 const Development& development) {
  if (!isFilmPath(target))
    return stillWriter(target, development);
  std::string comment;
  for (const auto& [name, text] : job.textOf(job.moments.front()).notes) {
    if (name != "volute.time")
      comment += fmt::format("{}{}: {}", comment.empty() ? "" : "; ", name, text);
  }
  return filmWriter(target, development, job.camera.width(), job.camera.height(),
                    job.framesPerSecond, comment);
}

/// A single picture reports its own progress; of several each is one step, with its remarks.
class CancelOnly final : public Progress {
 public:
  explicit CancelOnly(Progress& outer) : outer_(outer) {}

  void remark(std::string_view message) override { outer_.remark(message); }

  bool cancelled() const override { return outer_.cancelled(); }

 private:
  Progress& outer_;
};

/// How much is to come, before the first picture.
void remarkOnPictures(const RenderJob& job, const std::string& target, Progress& progress) {
  const std::size_t count = job.moments.size();
  const double first = job.moments.front().time, last = job.moments.back().time;
  std::string text = fmt::format("{}: {} pictures from {:g} to {:g} s", target, count, first, last);
  if (isFilmPath(target)) {
    text += fmt::format(", {:.3g} a second: a film of {:.3g} s", job.framesPerSecond,
                        static_cast<double>(count) / job.framesPerSecond);
  }
  progress.remark(text);
}

/// How long all of it takes if each picture takes as long as one did; nothing of a short while.
void remarkOnDuration(double seconds, std::size_t count, Progress& progress) {
  constexpr double kWorthSaying = 10;
  const double all = seconds * static_cast<double>(count);
  if (all < kWorthSaying)
    return;
  progress.remark(fmt::format("one picture takes {:.2g} s, all {} about {}", seconds, count,
                              all < 90     ? fmt::format("{:.0f} s", all)
                              : all < 5400 ? fmt::format("{:.0f} min", all / 60)
                                           : fmt::format("{:.1f} h", all / 3600)));
}

/// Renders and writes every moment; settles the exposure first when it is to be found.
Status renderAll(RenderJob& job, const std::string& target, Development& development,
                 Progress& progress) {
  const std::size_t count = job.moments.size();
  const std::size_t middle = count / 2;
  if (count > 1)
    remarkOnPictures(job, target, progress);
  CancelOnly steps(progress);
  Progress& each = count > 1 ? static_cast<Progress&>(steps) : progress;
  std::optional<Image> tried;
  const auto begun = std::chrono::steady_clock::now();
  const auto seconds = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  };
  bool measured = count == 1;
  const bool fixed = job.contour || job.options.aov == Aov::kTransmittance ||
                     extensionOf(target) == ".exr" ||
                     (job.measuresLight && job.options.aov == Aov::kNone);
  if (development.exposure == 0 && fixed) {
    development.exposure = 1;
  } else if (development.exposure == 0) {
    VOLUTE_ASSIGN(tried, job.picture(job.moments[middle], each));
    if (!std::exchange(measured, true))
      remarkOnDuration(seconds(), count, progress);
    development.exposure = suggestExposure(*tried);
    progress.remark(fmt::format("exposure {:.4g}, from frame {}", development.exposure,
                                job.moments[middle].number));
  }
  VOLUTE_ASSIGN(const auto writer, writerFor(target, job, development));
  for (std::size_t i = 0; i < count; ++i) {
    const Moment& moment = job.moments[i];
    if (i == 1 && !measured)
      remarkOnDuration(seconds(), count, progress);
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped before frame {}", moment.number);
    auto image =
        tried && i == middle ? Result<Image>(std::move(*tried)) : job.picture(moment, each);
    VOLUTE_TRY(image);
    const Stopwatch watch(job.totals.write);
    VOLUTE_TRY(writer->write(*image, moment.number, job.textOf(moment)));
    if (count > 1)
      progress.report("rendering", static_cast<double>(i + 1), static_cast<double>(count));
  }
  const Stopwatch watch(job.totals.write);
  return writer->finish();
}

Status writeStats(const RenderJob& job, const std::string& target) {
  return writeFile(target, dumpJson(job.stats()));
}

Status checkRenderTargets(const Arguments& arguments, const std::string& target) {
  if (!isPicturePath(target) && !isFilmPath(target)) {
    return fail(ErrorCode::kInvalidArgument,
                "--output: '{}' is of no known format; expected .png, .exr, .mp4 or .webm", target);
  }
  if (const auto stats = arguments.find<std::string>("stats"))
    VOLUTE_TRY(checkTarget(*stats, true));
  return checkTarget(target);
}

Status runRender(const Arguments& arguments, Context& context) {
  const auto target = arguments.get<std::string>("output");
  VOLUTE_TRY(checkRenderTargets(arguments, target));
  VOLUTE_ASSIGN(auto job, makeJob(arguments, target, context));
  VOLUTE_ASSIGN(auto development, developmentOf(arguments, job));
  VOLUTE_TRY(renderAll(job, target, development, context.progress));
  if (const auto stats = arguments.find<std::string>("stats"))
    VOLUTE_TRY(writeStats(job, *stats));
  if (context.json) {
    Report report;
    report.add("output", target).add("exposure", development.exposure);
    auto json = report.json();
    json.update(job.stats());
    context.print(dumpJson(json));
  }
  return {};
}

std::vector<Option> renderOptionTable() {
  using enum ValueKind;
  std::vector<Option> options = {
      {.name = "output",
       .letter = 'o',
       .kind = kOutput,
       .value = "OUT",
       .help = ".png, .exr (linear values), .mp4 or .webm; several stills need %04d for the "
               "frame's number",
       .required = true},
      {.name = "size",
       .kind = kPixels,
       .value = "WxH",
       .help = "pixels; else the camera file's, else 800x600"},
      {.name = "time", .kind = kNumber, .value = "T", .help = "the frame shown at T [s]"},
      {.name = "frames",
       .kind = kFrames,
       .value = "A:B[:S]",
       .help = "frames with numbers A <= n < B, every S-th"},
      {.name = "renderer",
       .kind = kChoice,
       .value = "NAME",
       .help = "who renders; auto is gl with a graphics card that can, else cpu",
       .initial = "auto",
       .choices = {"auto", "cpu", "gl", "reference"}},
      {.name = "smoke-method",
       .kind = kChoice,
       .value = "NAME",
       .help = "how OpenGL draws smoke on a mesh that is the only medium: from face to face, the "
               "sum over all tetrahedra (light is marched all the same), or by projected "
               "tetrahedra; auto takes the sum where no light is asked for, else the march",
       .initial = "auto",
       .choices = {"auto", "march", "splat", "projected"}},
      {.name = "volume-method",
       .kind = kChoice,
       .value = "NAME",
       .help = "how OpenGL draws a .volute: the bricks of each instant are made and uploaded, or "
               "the tree of 16 frames is, and each voxel is a walk in it",
       .initial = "bricks",
       .choices = {"bricks", "tree"}},
      {.name = "camera",
       .kind = kFile,
       .value = "FILE.json",
       .help = "a scene's camera object: eye, target, up, fov or ortho, size"},
      {.name = "eye", .kind = kVector, .value = "X,Y,Z", .help = "where the camera is [m]"},
      {.name = "target", .kind = kVector, .value = "X,Y,Z", .help = "what it looks at [m]"},
      {.name = "up",
       .kind = kVector,
       .value = "X,Y,Z",
       .help = "what is up in the picture",
       .initial = "0,0,1"},
      {.name = "fov",
       .kind = kNumber,
       .value = "DEGREES",
       .help = "vertical field of view [degrees]",
       .most = 179.99,
       .positive = true},
      {.name = "ortho",
       .kind = kNumber,
       .value = "HEIGHT",
       .help = "parallel rays; height of the view [m]",
       .positive = true},
      {.name = "aov",
       .kind = kChoice,
       .value = "NAME",
       .help = "one measured channel instead of a picture",
       .choices = {"optical-depth", "transmittance"}},
      {.name = "slice",
       .kind = kText,
       .value = "AXIS=M",
       .help = "instead of the smoke, a plane through it with its local values in colours, as "
               "z=1.8 [m]; for smoke on a mesh"},
      {.name = "slice-shows",
       .kind = kChoice,
       .value = "NAME",
       .help = "on the plane: the local visibility S = C / K up to 30 m, the extinction K, or the "
               "concentration, mass per volume in the field's unit",
       .initial = "visibility",
       .choices = {"visibility", "extinction", "concentration"}},
      {.name = "isosurface",
       .kind = kNumber,
       .value = "S",
       .help = "instead of the smoke, the surface on which the local visibility C / K is S [m]",
       .positive = true},
      {.name = "emission",
       .kind = kNumber,
       .value = "S",
       .help = "radiance per metre that one unit of the values emits",
       .initial = "1"},
      {.name = "extinction",
       .kind = kNumber,
       .value = "S",
       .help = "extinction of one unit of the values [1/m]; 0, with --aov 1",
       .least = 0},
      {.name = "basis",
       .kind = kChoice,
       .value = "NAME",
       .help = "what the values mean between voxel centres, instead of the file's own",
       .choices = {"box", "trilinear"}},
      {.name = "exposure",
       .kind = kText,
       .value = "S|auto",
       .help = "factor for .png and films; auto brings the brightest to white",
       .initial = "auto"},
      {.name = "background",
       .kind = kVector,
       .value = "R,G,B",
       .help = "linear radiance behind the volume",
       .initial = "0,0,0"},
      {.name = "colormap",
       .kind = kChoice,
       .value = "NAME",
       .help = "colours of volumes with one channel, in .png and films",
       .initial = "grey",
       .choices = {"grey", "viridis", "inferno"}},
      {.name = "grid", .kind = kText, .value = "NAME", .help = "which grid of a file with several"},
      {.name = "bounds",
       .kind = kBounds,
       .value = "X0,Y0,Z0,X1,Y1,Z1",
       .help = "as for compress [m]"},
      {.name = "speed",
       .kind = kNumber,
       .value = "S",
       .help = "seconds of smoke in a second of its film",
       .initial = "1",
       .positive = true},
      {.name = "legend",
       .help =
           "draw mode, what the smoke's field holds, C, time and the scale of colours into .png "
           "and films"},
      {.name = "stats",
       .kind = kOutput,
       .value = "FILE.json",
       .help = "write what was visited, the time of each stage and the peak memory"},
      {.name = "partial", .help = "use what is intact of a damaged .volute"}};
  for (const auto& more : {lightCacheOptions(), smokeOptions()})
    options.insert(options.end(), more.begin(), more.end());
  return options;
}

}  // namespace

Command renderCommand() {
  return {
      .name = "render",
      .summary = "Takes pictures or a film of a volume",
      .examples = {"volute render fire.volute -o fire.png --size 640x480 --time 0.8",
                   "volute render fire.volute -o fire.mp4 --frames 0:48",
                   "volute render smoke.volute -o depth.exr --aov optical-depth --eye 0,-4,1 "
                   "--target 0,0,1 --fov 40"},
      .description =
          "Integrates emission and absorption along each pixel's ray, exactly for the volume's "
          "basis. Without a camera one is "
          "chosen that frames the bounds; an FDS case with a roof is seen from within its largest "
          "room, at the height of the eyes. .exr files hold linear values; .png and films are "
          "exposed and sRGB. --exposure auto takes "
          "one factor for all pictures, from the middle one, and says it. Without --time and "
          "--frames a film or a pattern shows all "
          "frames, a single still the first, or of a scene what it shows at 0 s.",
      .positionals = {{.name = "FILE",
                       .help = "a volume (.volute, .npy, .vdb, .vti, .pvd), smoke on a mesh "
                               "(.vtu, .vtk, .pvd, .case, .e, "
                               ".foam), an FDS case (.smv) or a scene (.json)"}},
      .options = renderOptionTable(),
      .oneOf = {{{"time", "frames"}, false},
                {{"fov", "ortho"}, false},
                {{"slice", "isosurface", "aov"}, false}},
      .run = runRender};
}

}  // namespace volute::cli
