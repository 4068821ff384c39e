// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/render/render.hpp"

#include <sys/resource.h>

#include <chrono>
#include <utility>

#include "volute/base/output_file.hpp"
#include "volute/cli/camera_file.hpp"
#include "volute/cli/commands/commands.hpp"
#include "volute/cli/picture_writer.hpp"
#include "volute/cli/volume_layer.hpp"
#include "volute/cli/volume_output.hpp"
#include "volute/image/srgb.hpp"
#include "volute/io/frame_pattern.hpp"

namespace volute::cli {
namespace {

using Clock = std::chrono::steady_clock;

/// Milliseconds of each stage, and what was looked at.
struct Totals {
  double open = 0, slices = 0, render = 0, write = 0;
  std::uint64_t rays = 0, segments = 0, pieces = 0;
  std::uint64_t voxels = 0, bricksVisited = 0, bricksSkipped = 0, bricksStored = 0;
  int pictures = 0;
};

class Stopwatch {
 public:
  explicit Stopwatch(double& total) : total_(total) {}

  ~Stopwatch() {
    total_ += std::chrono::duration<double, std::milli>(Clock::now() - begin_).count();
  }

  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  double& total_;
  Clock::time_point begin_ = Clock::now();
};

struct Job {
  VolumeLayer layer;
  Camera camera;
  RenderOptions options;
  std::vector<int> positions;  ///< of the frames to render
  Totals totals;
  std::optional<Image> tried = std::nullopt;  ///< the picture that the exposure was taken from
  int triedPosition = -1;
};

Result<Image> renderFrame(Job& job, int position, Progress& progress) {
  if (job.tried && position == job.triedPosition)
    return *std::exchange(job.tried, std::nullopt);
  std::optional<VoxelMedium> medium;
  {
    const Stopwatch watch(job.totals.slices);
    VOLUTE_ASSIGN(medium, job.layer.mediumAt(position));
  }
  const Stopwatch watch(job.totals.render);
  const std::vector<AnyMedium> media{AnyMedium(*medium)};
  RenderStats stats;
  VOLUTE_ASSIGN(auto image, render(job.camera, media, job.options, progress, &stats));
  const MarchCounts counts = medium->counts();
  Totals& totals = job.totals;
  totals.rays += stats.rays;
  totals.segments += stats.segments;
  totals.pieces += stats.pieces;
  totals.voxels += counts.voxels;
  totals.bricksVisited += counts.bricksVisited;
  totals.bricksSkipped += counts.bricksSkipped;
  totals.bricksStored += medium->slice().storedBricks();
  ++totals.pictures;
  return image;
}

Result<std::vector<int>> positionsOf(const Arguments& arguments, const VolumeInfo& info,
                                     const std::string& target, Progress& progress) {
  if (const auto time = arguments.find<double>("time"))
    return std::vector{info.frameAt(*time)};
  const bool several = isFilmPath(target) || FramePattern::isPattern(target);
  if (!arguments.given("frames") && !several) {
    if (info.frames > 1)
      progress.remark(fmt::format(
          "showing the first of {} frames; --time or --frames choose others", info.frames));
    return std::vector{0};
  }
  VOLUTE_ASSIGN(auto positions,
                selectPositions(info, arguments.find<FrameRange>("frames").value_or(FrameRange{})));
  if (positions.size() > 1 && !several) {
    return fail(ErrorCode::kInvalidArgument,
                "{} pictures do not fit into '{}'; put %04d for the frame's number into its name",
                positions.size(), target);
  }
  return positions;
}

Result<Camera> chooseCamera(const Arguments& arguments, const VolumeInfo& info) {
  constexpr Pixels kUsual{800, 600};
  VOLUTE_ASSIGN(const auto description, cameraOf(arguments));
  Pixels size = arguments.find<Pixels>("size").value_or(kUsual);
  if (!description)
    return Camera::framing(info.bounds, size.width, size.height);
  if (!arguments.given("size"))
    size = description->size.value_or(kUsual);
  return makeCamera(*description, size);
}

RenderOptions renderOptions(const Arguments& arguments) {
  RenderOptions options;
  const auto renderer = arguments.get<std::string>("renderer");
  options.renderer = renderer == "reference" ? Renderer::kReference : Renderer::kCpu;
  options.background = arguments.get<Vec3>("background").array();
  if (const auto aov = arguments.find<std::string>("aov")) {
    options.aov = *aov == "transmittance" ? Aov::kTransmittance : Aov::kOpticalDepth;
  }
  return options;
}

Appearance appearanceOf(const Arguments& arguments) {
  Appearance appearance;
  appearance.emission = arguments.get<double>("emission");
  // Fire does not absorb by default; an optical depth of nothing would say nothing.
  appearance.extinction =
      arguments.find<double>("extinction").value_or(arguments.given("aov") ? 1 : 0);
  if (const auto basis = arguments.find<std::string>("basis")) {
    appearance.basis = *basis == "box" ? Basis::kBox : Basis::kTrilinear;
  }
  return appearance;
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

Result<Development> developmentOf(const Arguments& arguments, Job& job, const std::string& target,
                                  Context& context) {
  Development development;
  if (const auto map = arguments.find<std::string>("colormap"); map && *map != "grey") {
    if (job.layer.info().channels != 1 && job.options.aov == Aov::kNone) {
      return fail(ErrorCode::kInvalidArgument,
                  "--colormap is for volumes with one channel and for --aov; this one is RGB");
    }
    development.colorMap = *map == "viridis" ? ColorMap::kViridis : ColorMap::kInferno;
  }
  VOLUTE_ASSIGN(development.exposure, exposureOf(arguments));
  if (development.exposure > 0 || extensionOf(target) == ".exr")
    return development;
  if (job.options.aov == Aov::kTransmittance) {
    development.exposure = 1;
    return development;
  }
  const int middle = job.positions[job.positions.size() / 2];
  VOLUTE_ASSIGN(job.tried, renderFrame(job, middle, context.progress));
  job.triedPosition = middle;
  development.exposure = suggestExposure(*job.tried);
  context.progress.remark(fmt::format("exposure {:.4g}, from frame {}", development.exposure,
                                      job.layer.info().frameNumbers[middle]));
  return development;
}

/// From the times of the first and the last picture; films of one picture have the usual rate.
double framesPerSecond(const VolumeInfo& info, const std::vector<int>& positions) {
  constexpr double kUsual = 25;
  const double seconds = info.times[positions.back()] - info.times[positions.front()];
  return seconds > 0 ? static_cast<double>(positions.size() - 1) / seconds : kUsual;
}

Result<std::unique_ptr<PictureWriter>> writerFor(const std::string& target, const Job& job,
                                                 const Development& development) {
  if (!isFilmPath(target))
    return stillWriter(target, development);
  return filmWriter(target, development, job.camera.width(), job.camera.height(),
                    framesPerSecond(job.layer.info(), job.positions));
}

nlohmann::ordered_json statsJson(const Job& job) {
  const Totals& t = job.totals;
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  nlohmann::ordered_json json{
      {"renderer", job.options.renderer == Renderer::kReference ? "reference" : "cpu"},
      {"size", {job.camera.width(), job.camera.height()}},
      {"pictures", t.pictures},
      {"rays", t.rays},
      {"segments", t.segments},
      {"pieces", t.pieces},
      {"voxels_visited", t.voxels},
      {"bricks_visited", t.bricksVisited},
      {"bricks_skipped", t.bricksSkipped},
      {"bricks_stored", t.bricksStored},
      {"milliseconds",
       {{"open", t.open}, {"slices", t.slices}, {"render", t.render}, {"write", t.write}}},
      {"peak_memory_bytes", static_cast<std::uint64_t>(usage.ru_maxrss) * 1024}};
  if (const VoluteReader* reader = job.layer.reader()) {
    json["bytes_read"] = reader->bytesRead();
    json["blocks_decoded"] = reader->blocksDecoded();
    const TreeCounts& counts = job.layer.treeCounts();
    json["tree_nodes"] = counts.nodes;
    json["tree_bytes"] = counts.treeBytes;
    json["nodes_visited"] = counts.nodesVisited;
  }
  return json;
}

Status writeStats(const Job& job, const std::string& target) {
  VOLUTE_ASSIGN(auto file, OutputFile::create(target));
  const std::string text = dumpJson(statsJson(job));
  VOLUTE_TRY(file.write(std::as_bytes(std::span(text))));
  return file.commit();
}

/// A single picture reports its own progress; of several each is one step.
class CancelOnly final : public Progress {
 public:
  explicit CancelOnly(const Progress& outer) : outer_(outer) {}

  bool cancelled() const override { return outer_.cancelled(); }

 private:
  const Progress& outer_;
};

Status renderAll(Job& job, PictureWriter& writer, Progress& progress) {
  const auto& positions = job.positions;
  CancelOnly steps(progress);
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const int number = job.layer.info().frameNumbers[positions[i]];
    if (progress.cancelled())
      return fail(ErrorCode::kCancelled, "stopped before frame {}", number);
    VOLUTE_ASSIGN(const auto image,
                  renderFrame(job, positions[i],
                              positions.size() > 1 ? static_cast<Progress&>(steps) : progress));
    const Stopwatch watch(job.totals.write);
    VOLUTE_TRY(writer.write(image, number));
    if (positions.size() > 1)
      progress.report("rendering", static_cast<double>(i + 1),
                      static_cast<double>(positions.size()));
  }
  const Stopwatch watch(job.totals.write);
  return writer.finish();
}

Status checkFormats(const std::string& path, const std::string& target,
                    const Arguments& arguments) {
  if (extensionOf(path) == ".json") {
    return fail(
        ErrorCode::kUnsupported,
        "{}: scene files are not rendered by this version; give the volume itself with --camera {}",
        path, path);
  }
  if (!isPicturePath(target) && !isFilmPath(target)) {
    return fail(ErrorCode::kInvalidArgument,
                "--output: '{}' is of no known format; expected .png, .exr, .mp4 or .webm", target);
  }
  if (const auto stats = arguments.find<std::string>("stats")) {
    VOLUTE_TRY(checkTarget(*stats, true));
  }
  return checkTarget(target);
}

Status run(const Arguments& arguments, Context& context) {
  const std::string& path = arguments.positional(0);
  const auto target = arguments.get<std::string>("output");
  VOLUTE_TRY(checkFormats(path, target, arguments));
  InputOptions input;
  input.grid = arguments.find<std::string>("grid").value_or("");
  input.bounds = arguments.find<Box3>("bounds");
  input.partial = arguments.flag("partial");
  Totals totals;
  std::optional<VolumeLayer> layer;
  {
    const Stopwatch watch(totals.open);
    VOLUTE_ASSIGN(layer, VolumeLayer::open(path, input, appearanceOf(arguments), context));
  }
  VOLUTE_ASSIGN(auto positions, positionsOf(arguments, layer->info(), target, context.progress));
  VOLUTE_ASSIGN(const auto camera, chooseCamera(arguments, layer->info()));
  Job job{std::move(*layer), camera, renderOptions(arguments), std::move(positions), totals};
  VOLUTE_ASSIGN(const auto development, developmentOf(arguments, job, target, context));
  VOLUTE_ASSIGN(const auto writer, writerFor(target, job, development));
  VOLUTE_TRY(renderAll(job, *writer, context.progress));
  if (const auto stats = arguments.find<std::string>("stats")) {
    VOLUTE_TRY(writeStats(job, *stats));
  }
  if (context.json) {
    Report report;
    report.add("output", target).add("exposure", development.exposure);
    auto json = report.json();
    json.update(statsJson(job));
    context.print(dumpJson(json));
  }
  return {};
}

std::vector<Option> renderOptionTable() {
  using enum ValueKind;
  return {
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
       .help = "who renders; auto is cpu",
       .initial = "auto",
       .choices = {"auto", "cpu", "reference"}},
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
      {.name = "stats",
       .kind = kFile,
       .value = "FILE.json",
       .help = "write what was visited, the time of each stage and the peak memory"},
      {.name = "partial", .help = "use what is intact of a damaged .volute"}};
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
              "frames, a single still the first.",
          .positionals = {{.name = "FILE", .help = "a volume: .volute, .npy, .vdb, .vti or .pvd"}},
          .options = renderOptionTable(),
          .oneOf = {{{"time", "frames"}, false}, {{"fov", "ortho"}, false}},
          .run = run};
}

}  // namespace volute::cli
