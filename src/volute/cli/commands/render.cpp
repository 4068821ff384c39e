// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/render/render.hpp"

#include <algorithm>
#include <cmath>

#include "volute/base/output_file.hpp"
#include "volute/cli/camera_file.hpp"
#include "volute/cli/commands/commands.hpp"
#include "volute/cli/picture_writer.hpp"
#include "volute/cli/render_job.hpp"
#include "volute/cli/scene_file.hpp"
#include "volute/cli/volume_output.hpp"
#include "volute/image/srgb.hpp"
#include "volute/io/frame_pattern.hpp"

namespace volute::cli {
namespace {

constexpr Pixels kUsualSize{800, 600};
constexpr double kUsualRate = 25;  ///< frames a second

/// What a file on the command line shows: a scene, or a volume as a scene of its own.
struct Subject {
  bool scene = false;
  std::vector<VolumeLayer> layers;
  std::vector<FogLayer> fogs;
  std::vector<SmokeLayer> smokes;
  std::vector<Sign> signs;
  SceneLights lights;
  TriangleScene geometry;
  std::vector<BillboardLayer> billboards;
  std::vector<FdsLayer> fdsCases;
  PictureLaw law;
  std::optional<CameraDescription> camera;
  Rgb background = Rgb::Zero();
};

InputOptions inputOptions(const Arguments& arguments) {
  return {.grid = arguments.find<std::string>("grid").value_or(""),
          .bounds = arguments.find<Box3>("bounds"),
          .partial = arguments.flag("partial")};
}

std::optional<Basis> basisOf(const Arguments& arguments) {
  const auto name = arguments.find<std::string>("basis");
  if (!name)
    return std::nullopt;
  return *name == "box" ? Basis::kBox : Basis::kTrilinear;
}

Result<Subject> openVolumeSubject(const std::string& path, const Arguments& arguments,
                                  Context& context) {
  Appearance appearance;
  appearance.emission = arguments.get<double>("emission");
  // Fire does not absorb by default; an optical depth of nothing would say nothing.
  appearance.extinction =
      arguments.find<double>("extinction").value_or(arguments.given("aov") ? 1 : 0);
  appearance.basis = basisOf(arguments);
  Subject subject;
  VOLUTE_ASSIGN(auto layer, VolumeLayer::open(path, inputOptions(arguments), appearance, context));
  subject.layers.push_back(std::move(layer));
  return subject;
}

/// Where light that was computed is kept; nothing when it is not to be, or cannot.
Result<std::optional<LightCache>> lightCache(const Arguments& arguments, Context& context) {
  const auto limit = arguments.get<Bytes>("cache-size").count;
  const auto folder = arguments.find<std::string>("cache");
  if (limit == 0 || folder == "none")
    return std::nullopt;
  if (folder) {
    VOLUTE_ASSIGN(auto cache, LightCache::open(*folder, limit));
    return cache;
  }
  if (LightCache::usualFolder().empty())
    return std::nullopt;
  auto cache = LightCache::open(LightCache::usualFolder(), limit);
  if (cache)
    return std::optional(std::move(*cache));
  context.progress.remark("light is not kept: " + cache.error().message);
  return std::nullopt;
}

Result<std::shared_ptr<const SmokeLighting>> smokeLighting(const SceneLights& lights,
                                                           const TriangleScene& geometry,
                                                           const Arguments& arguments,
                                                           Context& context) {
  SmokeLighting lighting{lights, std::nullopt, blocksOf(geometry), keyOf(geometry)};
  if (!lights.lamps.empty()) {
    VOLUTE_ASSIGN(lighting.cache, lightCache(arguments, context));
  }
  return std::make_shared<const SmokeLighting>(std::move(lighting));
}

/// A case alone: black smoke before white, so that the picture is what passes of the light.
Result<Subject> openSmokeSubject(const std::string& path, const Arguments& arguments,
                                 Context& context) {
  for (const char* name : {"grid", "bounds", "emission", "extinction", "basis"}) {
    if (arguments.given(name))
      return fail(ErrorCode::kInvalidArgument, "--{} is for volumes of voxels; {} is a mesh", name,
                  path);
  }
  VOLUTE_ASSIGN(const auto description, smokeOf(path, arguments));
  VOLUTE_ASSIGN(const auto lighting, smokeLighting({}, {}, arguments, context));
  Subject subject;
  VOLUTE_ASSIGN(auto smoke, SmokeLayer::open(description, lighting, context));
  subject.smokes.push_back(std::move(smoke));
  subject.law = description.law;
  subject.background = Rgb::Ones();
  return subject;
}

/// An FDS case alone, in even white light and before white.
Result<Subject> openFdsSubject(const std::string& path, const Arguments& arguments,
                               Context& context) {
  for (const char* name :
       {"grid", "bounds", "emission", "extinction", "basis", "quantity", "unit"}) {
    if (arguments.given(name)) {
      return fail(ErrorCode::kInvalidArgument,
                  "--{}: the FDS case {} says this itself; --field names one of its sources", name,
                  path);
    }
  }
  VOLUTE_ASSIGN(const auto description, smokeOf(path, arguments));
  Subject subject;
  subject.lights.ambient = Rgb::Ones();
  VOLUTE_ASSIGN(auto fds, FdsLayer::open(description, subject.lights.ambient, context));
  subject.fdsCases.push_back(std::move(fds));
  subject.law = description.law;
  subject.background = Rgb::Ones();
  return subject;
}

/// The scene's, or the command line's instead.
Result<PictureLaw> lawOf(const SceneDescription& scene, const Arguments& arguments) {
  PictureLaw law = scene.smokes.empty() ? PictureLaw{} : scene.smokes.front().law;
  if (const auto mode = arguments.find<std::string>("mode")) {
    VOLUTE_ASSIGN(law.mode, pictureMode(*mode));
  }
  if (const auto c = arguments.find<std::string>("C")) {
    auto found = visibilityLaw(*c);
    if (!found)
      return fail(ErrorCode::kInvalidArgument, "--C: {}", found.error().message);
    law.c = found->c;
  }
  return law;
}

Status openSmokes(const SceneDescription& scene, const Arguments& arguments, Subject& subject,
                  Context& context) {
  VOLUTE_ASSIGN(subject.law, lawOf(scene, arguments));
  if (scene.smokes.empty())
    return {};
  VOLUTE_ASSIGN(const auto lighting,
                smokeLighting(scene.lights, subject.geometry, arguments, context));
  for (const SmokeDescription& description : scene.smokes) {
    if (isSmvPath(description.file)) {
      VOLUTE_ASSIGN(auto fds, FdsLayer::open(description, scene.lights.ambient, context));
      subject.fdsCases.push_back(std::move(fds));
      continue;
    }
    VOLUTE_ASSIGN(auto smoke, SmokeLayer::open(description, lighting, context));
    subject.smokes.push_back(std::move(smoke));
  }
  return {};
}

Status openBillboards(const SceneDescription& scene, Subject& subject, Context& context) {
  for (const SceneBillboard& board : scene.billboards) {
    VOLUTE_ASSIGN(auto volume, VolumeLayer::open(board.file, {}, board.appearance, context));
    BillboardOptions options = board.options;
    options.shown = volume.info().bounds;
    subject.billboards.push_back({std::move(volume), options});
  }
  return {};
}

Result<Subject> openScene(const std::string& path, const Arguments& arguments, Context& context) {
  for (const char* name : {"grid", "bounds", "emission", "extinction", "field", "quantity", "unit",
                           "scale", "mass-extinction", "soot-yield", "material", "burning",
                           "density-field", "albedo", "clamp"}) {
    if (!arguments.given(name))
      continue;
    return fail(ErrorCode::kInvalidArgument, "--{} is for a single file; write it into the scene",
                name);
  }
  VOLUTE_ASSIGN(auto scene, readScene(path));
  Subject subject;
  subject.scene = true;
  subject.camera = scene.camera;
  subject.background = scene.background;
  subject.signs = std::move(scene.signs);
  for (SceneVolume& volume : scene.volumes) {
    volume.appearance.basis = basisOf(arguments);
    VOLUTE_ASSIGN(auto layer, VolumeLayer::open(volume.file, inputOptions(arguments),
                                                volume.appearance, context));
    subject.layers.push_back(std::move(layer));
  }
  subject.lights = scene.lights;
  VOLUTE_ASSIGN(subject.geometry, loadGeometry(scene.geometry, context));
  VOLUTE_TRY(openBillboards(scene, subject, context));
  for (FogDescription& description : scene.fogs) {
    description.scattering.shadows = fogShadows(subject.geometry, scene.lights.suns);
    VOLUTE_ASSIGN(auto fog, FogLayer::open(description, scene.lights.suns, context));
    subject.fogs.push_back(std::move(fog));
  }
  VOLUTE_TRY(openSmokes(scene, arguments, subject, context));
  return subject;
}

Result<Subject> openSubject(const std::string& path, const Arguments& arguments, Context& context) {
  if (extensionOf(path) == ".json")
    return openScene(path, arguments, context);
  if (isSmvPath(path))
    return openFdsSubject(path, arguments, context);
  return isSmokeCase(path) ? openSmokeSubject(path, arguments, context)
                           : openVolumeSubject(path, arguments, context);
}

Moment momentAt(const std::vector<VolumeLayer>& layers, double time) {
  Moment moment{.time = time};
  for (const VolumeLayer& layer : layers) moment.positions.push_back(layer.positionAt(time));
  if (!layers.empty())
    moment.number = layers.front().info().frameNumbers[moment.positions.front()];
  return moment;
}

/// Frames are those of the first volume; the others are shown as they are at its times.
Moment momentOf(const std::vector<VolumeLayer>& layers, int position) {
  Moment moment = momentAt(layers, layers.front().timeOf(position));
  moment.positions.front() = position;
  moment.number = layers.front().info().frameNumbers[position];
  return moment;
}

/// Scenes without a volume: frame n is at n / 25 s; without --frames as many as the fog has maps.
Result<std::vector<Moment>> momentsOfFog(const Arguments& arguments, const Subject& subject,
                                         const std::string& target) {
  const bool several = isFilmPath(target) || FramePattern::isPattern(target);
  const auto chosen = arguments.find<FrameRange>("frames");
  if (const auto time = arguments.find<double>("time"))
    return std::vector{Moment{.time = *time}};
  if (!chosen && !several)
    return std::vector{Moment{}};
  double last = 0;
  for (const FogLayer& fog : subject.fogs) last = std::max(last, fog.timeOf(fog.frames() - 1));
  const FrameRange range = chosen.value_or(FrameRange{});
  const int begin = range.begin.value_or(0);
  const int end = range.end.value_or(static_cast<int>(std::lround(last * kUsualRate)) + 1);
  std::vector<Moment> moments;
  for (int n = begin; n < end; n += range.step)
    moments.push_back({.number = n, .time = n / kUsualRate});
  if (moments.empty())
    return fail(ErrorCode::kInvalidArgument, "--frames: there is no frame from {} to {}", begin,
                end);
  if (moments.size() > 1 && !several) {
    return fail(ErrorCode::kInvalidArgument,
                "{} pictures do not fit into '{}'; put %04d for the frame's number into its name",
                moments.size(), target);
  }
  return moments;
}

/// Pictures 25 times a second, of so many seconds each.
Result<std::vector<Moment>> momentsOfFilm(double first, double last, double speed) {
  constexpr double kMost = 1e6;
  const double count = std::round((last - first) / speed * kUsualRate) + 1;
  if (count > kMost) {
    return fail(ErrorCode::kInvalidArgument,
                "a film of {:.0f} s at --speed {:g} has {:.0f} pictures; choose a higher --speed",
                last - first, speed, count);
  }
  std::vector<Moment> moments;
  for (int i = 0; i < static_cast<int>(count); ++i)
    moments.push_back({.number = i, .time = std::min(first + i * speed / kUsualRate, last)});
  return moments;
}

/// The stored steps of a case of smoke.
struct Steps {
  std::string file;
  std::vector<double> times;  ///< [s], of the scene

  template <class Layer>
  explicit Steps(const Layer& layer) : file(layer.description().file) {
    for (int i = 0; i < layer.steps(); ++i) times.push_back(layer.timeOf(i));
  }
};

/// Frames are the steps of the case; films go through its time, 25 pictures a second.
Result<std::vector<Moment>> momentsOfSmoke(const Steps& smoke, const Arguments& arguments,
                                           const Subject& subject, const std::string& target,
                                           Progress& progress) {
  const int steps = static_cast<int>(smoke.times.size());
  if (const auto time = arguments.find<double>("time"))
    return std::vector{Moment{.time = *time}};
  const bool film = isFilmPath(target), several = film || FramePattern::isPattern(target);
  if (!arguments.given("frames") && !several) {
    if (steps > 1 && !subject.scene) {
      progress.remark(
          fmt::format("showing the first of {} steps; --time or --frames choose others", steps));
    }
    return std::vector{Moment{.time = subject.scene ? 0 : smoke.times.front()}};
  }
  const FrameRange range = arguments.find<FrameRange>("frames").value_or(FrameRange{});
  const int begin = std::max(range.begin.value_or(0), 0);
  const int end = std::min(range.end.value_or(steps), steps);
  if (begin >= end) {
    return fail(ErrorCode::kInvalidArgument,
                "--frames: {} has the steps 0 to {}; there is none from {} to {}", smoke.file,
                steps - 1, begin, range.end.value_or(steps));
  }
  if (film) {
    return momentsOfFilm(smoke.times[begin], smoke.times[end - 1], arguments.get<double>("speed"));
  }
  std::vector<Moment> moments;
  for (int n = begin; n < end; n += range.step)
    moments.push_back({.number = n, .time = smoke.times[n]});
  if (moments.size() > 1 && !several) {
    return fail(ErrorCode::kInvalidArgument,
                "{} pictures do not fit into '{}'; put %04d for the frame's number into its name",
                moments.size(), target);
  }
  return moments;
}

Result<std::vector<Moment>> momentsOf(const Arguments& arguments, const Subject& subject,
                                      const std::string& target, Progress& progress) {
  const auto& layers = subject.layers;
  if (layers.empty() && !subject.smokes.empty())
    return momentsOfSmoke(Steps(subject.smokes.front()), arguments, subject, target, progress);
  if (layers.empty() && !subject.fdsCases.empty())
    return momentsOfSmoke(Steps(subject.fdsCases.front()), arguments, subject, target, progress);
  if (layers.empty())
    return momentsOfFog(arguments, subject, target);
  if (const auto time = arguments.find<double>("time"))
    return std::vector{momentAt(layers, *time)};
  const VolumeInfo& info = layers.front().info();
  const bool several = isFilmPath(target) || FramePattern::isPattern(target);
  if (!arguments.given("frames") && !several) {
    if (subject.scene)
      return std::vector{momentAt(layers, 0)};
    if (info.frames > 1) {
      progress.remark(fmt::format(
          "showing the first of {} frames; --time or --frames choose others", info.frames));
    }
    return std::vector{momentOf(layers, 0)};
  }
  VOLUTE_ASSIGN(const auto positions,
                selectPositions(info, arguments.find<FrameRange>("frames").value_or(FrameRange{})));
  if (positions.size() > 1 && !several) {
    return fail(ErrorCode::kInvalidArgument,
                "{} pictures do not fit into '{}'; put %04d for the frame's number into its name",
                positions.size(), target);
  }
  std::vector<Moment> moments;
  for (const int position : positions) moments.push_back(momentOf(layers, position));
  return moments;
}

/// From the times of the first and the last picture; films of one picture have the usual rate.
double framesPerSecond(const std::vector<Moment>& moments) {
  if (moments.size() < 2)
    return kUsualRate;
  return static_cast<double>(moments.size() - 1) / (moments.back().time - moments.front().time);
}

Result<Camera> chooseCamera(const Arguments& arguments, const Subject& subject) {
  VOLUTE_ASSIGN(auto description, cameraOf(arguments));
  if (!description)
    description = subject.camera;
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

RenderOptions renderOptions(const Arguments& arguments, const Subject& subject) {
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

/// What OpenGL does not draw, in the plural; empty when it draws all.
std::string_view beyondGl(const Subject& subject) {
  if (!subject.billboards.empty())
    return "billboards";
  if (!subject.fdsCases.empty())
    return "FDS cases";
  if (std::ranges::any_of(subject.fogs, &FogLayer::sunlit))
    return "fog that suns light";
  return subject.law.factor() != 1 && !subject.fogs.empty() ? "fog in threshold mode" : "";
}

/// Null for the processor. `auto` takes OpenGL where hardware draws all that the subject has.
Result<std::shared_ptr<GlPictures>> chooseGl(const Arguments& arguments, const Subject& subject) {
  const auto renderer = arguments.get<std::string>("renderer");
  const auto beyond = beyondGl(subject);
  if (renderer == "gl" && !beyond.empty()) {
    return fail(ErrorCode::kUnsupported,
                "--renderer gl does not draw {} yet; choose cpu or leave it out", beyond);
  }
  if (renderer == "gl")
    return GlPictures::open(false);
  if (renderer != "auto" || !beyond.empty() || !glIsLikely())
    return nullptr;
  auto gl = GlPictures::open(true);
  return gl ? std::move(*gl) : nullptr;
}

Result<RenderJob> makeJob(const Arguments& arguments, const std::string& target, Context& context) {
  const std::string& path = arguments.positional(0);
  RenderTotals totals;
  Subject subject;
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
  VOLUTE_ASSIGN(auto gl, chooseGl(arguments, subject));
  RenderJob job{std::move(subject.layers),
                std::move(subject.fogs),
                camera,
                options,
                std::move(moments),
                rate,
                totals};
  job.gl = std::move(gl);
  job.smokes = std::move(subject.smokes);
  job.signs = std::move(subject.signs);
  job.law = subject.law;
  job.lights = std::move(subject.lights);
  job.geometry = subject.geometry;
  job.billboards = std::move(subject.billboards);
  job.fdsCases = std::move(subject.fdsCases);
  job.legend = arguments.flag("legend");
  job.measuresLight = stepsLead && !subject.scene;
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

/// A single picture reports its own progress; of several each is one step.
class CancelOnly final : public Progress {
 public:
  explicit CancelOnly(const Progress& outer) : outer_(outer) {}

  bool cancelled() const override { return outer_.cancelled(); }

 private:
  const Progress& outer_;
};

/// Renders and writes every moment; settles the exposure first when it is to be found.
Status renderAll(RenderJob& job, const std::string& target, Development& development,
                 Progress& progress) {
  const std::size_t count = job.moments.size();
  const std::size_t middle = count / 2;
  CancelOnly steps(progress);
  Progress& each = count > 1 ? static_cast<Progress&>(steps) : progress;
  std::optional<Image> tried;
  const bool fixed = job.options.aov == Aov::kTransmittance || extensionOf(target) == ".exr" ||
                     (job.measuresLight && job.options.aov == Aov::kNone);
  if (development.exposure == 0 && fixed) {
    development.exposure = 1;
  } else if (development.exposure == 0) {
    VOLUTE_ASSIGN(tried, job.picture(job.moments[middle], each));
    development.exposure = suggestExposure(*tried);
    progress.remark(fmt::format("exposure {:.4g}, from frame {}", development.exposure,
                                job.moments[middle].number));
  }
  VOLUTE_ASSIGN(const auto writer, writerFor(target, job, development));
  for (std::size_t i = 0; i < count; ++i) {
    const Moment& moment = job.moments[i];
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
  VOLUTE_ASSIGN(auto file, OutputFile::create(target));
  const std::string text = dumpJson(job.stats());
  VOLUTE_TRY(file.write(std::as_bytes(std::span(text))));
  return file.commit();
}

Status checkTargets(const Arguments& arguments, const std::string& target) {
  if (!isPicturePath(target) && !isFilmPath(target)) {
    return fail(ErrorCode::kInvalidArgument,
                "--output: '{}' is of no known format; expected .png, .exr, .mp4 or .webm", target);
  }
  if (const auto stats = arguments.find<std::string>("stats"))
    VOLUTE_TRY(checkTarget(*stats, true));
  return checkTarget(target);
}

Status run(const Arguments& arguments, Context& context) {
  const auto target = arguments.get<std::string>("output");
  VOLUTE_TRY(checkTargets(arguments, target));
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
       .kind = kFile,
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
      {.name = "legend", .help = "draw mode, mass extinction, C and time into .png and films"},
      {.name = "cache",
       .kind = kFile,
       .value = "DIR",
       .help = "where the light of lamps in smoke is kept, or none; else volute/light in the "
               "user's cache folder"},
      {.name = "cache-size",
       .kind = kBytes,
       .value = "BYTES",
       .help = "what it may take there",
       .initial = "1G"},
      {.name = "stats",
       .kind = kFile,
       .value = "FILE.json",
       .help = "write what was visited, the time of each stage and the peak memory"},
      {.name = "partial", .help = "use what is intact of a damaged .volute"}};
  const std::vector<Option> smoke = smokeOptions();
  options.insert(options.end(), smoke.begin(), smoke.end());
  return options;
}

}  // namespace

Command renderCommand() {
  return {.name = "render",
          .summary = "Takes pictures or a film of a volume",
          .examples = {"volute render fire.volute -o fire.png --size 640x480 --time 0.8",
                       "volute render fire.volute -o fire.mp4 --frames 0:48",
                       "volute render smoke.volute -o depth.exr --aov optical-depth --eye 0,-4,1 "
                       "--target 0,0,1 --fov 40"},
          .description =
              "Integrates emission and absorption along each pixel's ray, exactly for the volume's "
              "basis. Without a camera one is "
              "chosen that frames the bounds. .exr files hold linear values; .png and films are "
              "exposed and sRGB. --exposure auto takes "
              "one factor for all pictures, from the middle one, and says it. Without --time and "
              "--frames a film or a pattern shows all "
              "frames, a single still the first, or of a scene what it shows at 0 s.",
          .positionals = {{.name = "FILE",
                           .help = "a volume (.volute, .npy, .vdb, .vti, .pvd), smoke on a mesh "
                                   "(.vtu, .pvd, .case, .e, "
                                   ".foam), an FDS case (.smv) or a scene (.json)"}},
          .options = renderOptionTable(),
          .oneOf = {{{"time", "frames"}, false}, {{"fov", "ortho"}, false}},
          .run = run};
}

}  // namespace volute::cli
