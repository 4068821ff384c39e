// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors

// Volumes from pictures and from measured lines.

#include <array>
#include <memory>
#include <vector>

#include "scene_bridge.hpp"
#include "volute/base/output_name.hpp"
#include "volute/capture/capture_check.hpp"
#include "volute/capture/open_capture.hpp"
#include "volute/capture/write_capture.hpp"
#include "volute/codec/compress.hpp"
#include "volute/io/output_names.hpp"
#include "volute/tomography/capture_refinement.hpp"
#include "volute/tomography/line_volumes.hpp"
#include "volute/tomography/reconstructed_frames.hpp"
#include "volute/tomography/reconstruction_report.hpp"
#include "volute/tomography/settings_check.hpp"
#include "volute/tomography/soot_frames.hpp"
#include "volute/tomography/velocity_frames.hpp"
#include "volute/volume_files/volume_input.hpp"
#include "volute/volume_files/volume_writer.hpp"

namespace volute::python {
namespace {

ReconstructionSettings settingsOf(const OrderedJson& said, const Capture& capture,
                                  std::uint64_t maxMemory) {
  ReconstructionSettings settings;
  TomographyOptions& options = settings.tomography;
  const auto take = [&](const char* key, auto& to) {
    if (said.contains(key))
      to = said[key].get<std::decay_t<decltype(to)>>();
  };
  const auto takeOptional = [&]<class T>(const char* key, std::optional<T>& to) {
    if (said.contains(key))
      to = said[key].get<T>();
  };
  options.basis = said.value("basis", "trilinear") == "box" ? Basis::kBox : Basis::kTrilinear;
  options.solver = *tomographySolverByName(said.value("solver", "apg"));
  options.regularization = *regularizationByName(said.value("regularization", "auto"));
  takeOptional("lambda", options.lambda);
  takeOptional("sparsity", options.sparsity);
  takeOptional("iterations", options.iterations);
  take("rays_per_pixel", options.raysPerPixel);
  take("hull", options.hull);
  take("coarse_to_fine", options.coarseToFine);
  take("temporal", options.temporal);
  take("warm_start", settings.warmStart);
  take("force", settings.force);
  take("error_bars", settings.errorBars);
  take("temperature", settings.flame);
  options.noiseSigma = capture.fittedNoise();
  options.maxMemory = maxMemory;
  return settings;
}

CaptureOptions captureOptions(const OrderedJson& said, std::uint64_t maxMemory) {
  CaptureOptions options;
  options.maxMemory = maxMemory;
  if (said.contains("images"))
    options.images = said["images"].get<std::string>();
  if (said.contains("bounds")) {
    const auto b = said["bounds"].get<std::array<std::array<double, 3>, 2>>();
    options.bounds = Box3{Vec3(b[0][0], b[0][1], b[0][2]), Vec3(b[1][0], b[1][1], b[1][2])};
  }
  if (said.contains("resolution"))
    options.resolution = said["resolution"].get<std::array<int, 3>>();
  if (said.contains("frames")) {
    const OrderedJson& range = said["frames"];
    const auto bound = [](const OrderedJson& number) {
      return number.is_null() ? std::nullopt : std::optional(number.get<double>());
    };
    options.frames = {bound(range[0]), bound(range[1]), range[2].get<int>()};
  }
  if (said.contains("noise_sigma"))
    options.noiseSigma = said["noise_sigma"].get<double>();
  return options;
}

/// What compression cost in the pictures, as the command has it.
Status addFile(ReconstructedFrames& frames, const std::string& output,
               const ReconstructionSettings& settings, OrderedJson& report, Reading& reading) {
  if (settings.flame)
    return {};
  InputOptions input;
  input.grid = frames.info().name;
  VOLUTE_ASSIGN(const auto written, openVolume(output, input, reading));
  return addResidualOfFile(frames, *written.source, report, reading.progress);
}

/// All frames of a grid, one behind the other.
Result<std::vector<float>> framesOf(FrameSource& grid) {
  const VolumeInfo& info = grid.info();
  std::vector<float> values(info.values());
  for (int i = 0; i < info.frames; ++i)
    VOLUTE_TRY(
        grid.readFrame(i, std::span(values).subspan(i * info.frameValues(), info.frameValues())));
  return values;
}

/// Values of shape (t, z, y, x, c) where `output` is empty; else a .volute file is written.
py::tuple reconstructCapture(const std::string& path, const std::string& output, double rms,
                             const std::string& optionsJson, std::uint64_t maxMemory,
                             const py::object& listener) {
  using namespace py::literals;
  const OrderedJson said = jsonOf(optionsJson);
  constexpr double kEstimateRms = 5e-3;  // less than what the estimates are off by
  std::vector<float> values, sigma, speeds;
  VolumeInfo info;
  OrderedJson report;
  run(listener, [&](Progress& progress) -> Status {
    VOLUTE_TRY(checkReplacesNothing(output, {path}));
    const auto refined = said.value("refined", std::string());
    if (!refined.empty()) {
      VOLUTE_TRY(checkOutput(refined));
      VOLUTE_TRY(checkReplacesNothing(refined, {path}, "refined"));
    }
    VOLUTE_ASSIGN(const Capture given, openCapture(path, captureOptions(said, maxMemory)));
    remarkOn(given, progress);
    const auto heldOut = said.value("hold_out", std::vector<std::string>{});
    ReconstructionSettings settings = settingsOf(said, given, maxMemory);
    VOLUTE_TRY(checkSettings(settings, given));
    remarkOnUnused(settings, given, progress);
    const bool moves = said.value("velocity", false);
    if (moves && given.frames.size() < 2)
      return fail(ErrorCode::kInvalidArgument, "velocity: needs two frames or more");
    VOLUTE_TRY(checkVolumeSize({given.volume.bounds, given.volume.resolution}, maxMemory));
    if (settings.flame && (!given.spectrum.stated() || given.measured != Measured::kEmission))
      return fail(ErrorCode::kInvalidArgument,
                  "temperature: {} states no \"spectrum\" of light that the medium sends itself",
                  given.file.string());
    VOLUTE_TRY(checkCapture(given, heldOut, settings.force, maxMemory, progress));
    const bool refine = said.value("refine", true);
    VOLUTE_ASSIGN(const CaptureRefinement refinement,
                  refineCapture(given, heldOut, refine ? Refine::kAuto : Refine::kNever, maxMemory,
                                progress));
    if (!refined.empty())
      VOLUTE_TRY(writeCapture(refined, refinement.capture));
    settings.causeNamed = refinement.namesCause();
    settings.causeNamedIn = refinement.faultyFrames;
    const Capture& capture = refinement.capture;
    const std::string target = output.empty() ? "-" : output;
    VOLUTE_ASSIGN(const auto frames,
                  ReconstructedFrames::open(capture, settings, heldOut, target, progress));
    std::unique_ptr<VelocityFrames> velocity;
    if (moves) {
      VOLUTE_ASSIGN(velocity, VelocityFrames::open(*frames, {}, target, progress));
    }
    const Status done = [&]() -> Status {
      VOLUTE_TRY(frames->solveAll());
      Team alone;
      if (velocity)
        VOLUTE_TRY(velocity->solveAll(alone));
      VOLUTE_ASSIGN(report, reconstructionReport(refinement, settings, *frames, velocity.get()));
      info = frames->info();
      if (!output.empty()) {
        std::vector<WrittenGrid> grids{{frames.get(), rms}};
        if (velocity)
          grids.push_back({velocity.get(), std::max(rms, kEstimateRms)});
        if (settings.errorBars)
          grids.push_back({&frames->errorBars(), std::max(rms, kEstimateRms)});
        std::optional<SootFrames> soot;
        if (settings.flame) {
          soot.emplace(*frames, capture.spectrum);
          for (FrameSource* grid : soot->grids()) grids.push_back({grid, rms});
          VOLUTE_TRY(soot->addTo(report, progress));
        }
        Reading reading{progress, maxMemory};
        Report written;
        VOLUTE_ASSIGN(auto writer, VolumeWriter::open(std::move(grids), output,
                                                      fmt::format("reconstructed from {}",
                                                                  capture.file.filename().string()),
                                                      reading, alone));
        VOLUTE_TRY(writer.write(written));
        return addFile(*frames, output, settings, report, reading);
      }
      std::uint64_t bytes = info.rawBytes() * (settings.errorBars ? 2 : 1);
      if (velocity)
        bytes += velocity->info().rawBytes();
      if (bytes > maxMemory) {
        return fail(
            ErrorCode::kTooLarge,
            "{} MiB of values, more than the {} MiB allowed; give `output` or raise max_memory",
            (bytes >> 20) + 1, maxMemory >> 20);
      }
      VOLUTE_ASSIGN(values, framesOf(*frames));
      if (settings.errorBars) {
        VOLUTE_ASSIGN(sigma, framesOf(frames->errorBars()));
      }
      if (velocity) {
        VOLUTE_ASSIGN(speeds, framesOf(*velocity));
      }
      return {};
    }();
    if (velocity)
      velocity->work().leave(done.has_value());
    frames->work().leave(done.has_value());  // what was finished serves when the call is made again
    return done;
  });
  py::object array = py::none(), bars = py::none(), motion = py::none();
  if (output.empty()) {
    if (!sigma.empty())
      bars = owned(std::move(sigma), {info.frames, info.z, info.y, info.x, info.channels});
    if (!speeds.empty())
      motion = owned(std::move(speeds), {info.frames, info.z, info.y, info.x, 3});
    array = owned(std::move(values), {info.frames, info.z, info.y, info.x, info.channels});
  }
  const py::dict place("grid"_a = info.name, "unit"_a = info.unit,
                       "bounds"_a = boundsTuple(info.bounds), "times"_a = info.times,
                       "frame_numbers"_a = info.frameNumbers,
                       "basis"_a = std::string(basisName(info.basis)));
  return py::make_tuple(array, place, report.dump(), bars, motion);
}

/// (ends (n, 6), values (n,), sigmas (n,), frame of each (n,)) of measured lines, and times of
/// frames.
LineFile linesOf(const py::tuple& said) {
  using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
  const auto ends = said[0].cast<Doubles>(), values = said[1].cast<Doubles>();
  const auto sigmas = said[2].cast<std::optional<Doubles>>();
  const auto frames = said[3].cast<std::vector<int>>();
  const auto times = said[4].cast<std::vector<double>>();
  LineFile lines;
  lines.opticalDepths = lines.hasTimes = true;
  lines.hasSigma = sigmas.has_value();
  for (std::size_t i = 0; i < times.size(); ++i)
    lines.frames.push_back({static_cast<int>(i), times[i], {}});
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const double* end = ends.data() + 6 * i;
    const Vec3 from(end[0], end[1], end[2]), to(end[3], end[4], end[5]);
    const double length = (to - from).norm();
    lines.frames[static_cast<std::size_t>(frames[i])].lines.push_back(
        {{from, (to - from) / length, 0, length},
         values.data()[i],
         sigmas ? sigmas->data()[i] : 1,
         static_cast<int>(i) + 1});
  }
  return lines;
}

/// Of a .csv, or of what linesOf() takes: (values (t, z, y, x), where they are, report).
py::tuple reconstructFromLines(const py::object& source, const std::string& options,
                               std::uint64_t maxMemory, const py::object& listener) {
  const auto said = jsonOf(options);
  const CaptureOptions where = captureOptions(said, maxMemory);
  LineOptions how;
  if (said.value("basis", "box") == "trilinear")
    how.basis = Basis::kTrilinear;
  if (said.contains("lambda"))
    how.lambda = said["lambda"].get<double>();
  if (said.contains("iterations"))
    how.iterations = said["iterations"].get<int>();
  const bool leaveOut = said.value("force", false);
  const bool isFile = py::isinstance<py::bytes>(source);
  const auto file = isFile ? source.cast<std::string>() : std::string("lines");
  LineFile lines = isFile ? LineFile() : linesOf(source.cast<py::tuple>());
  LineVolumes found = run(listener, [&](Progress& progress) {
    return isFile ? reconstructLineFile(file, where, how, leaveOut, progress)
                  : reconstructLineFrames(std::move(lines), file, where, how, leaveOut, progress);
  });
  using namespace py::literals;
  const VolumeInfo& info = found.volumes.info;
  const py::dict place("grid"_a = info.name, "unit"_a = info.unit,
                       "bounds"_a = boundsTuple(info.bounds), "times"_a = info.times,
                       "frame_numbers"_a = info.frameNumbers,
                       "basis"_a = std::string(basisName(info.basis)));
  return py::make_tuple(
      owned(std::move(found.volumes.values), {info.frames, info.z, info.y, info.x}), place,
      found.records.dump());
}

}  // namespace

void addReconstruction(py::module_& m) {
  using namespace py::literals;
  m.def("reconstruct", &reconstructCapture, "path"_a, "output"_a, "rms"_a, "options"_a,
        "max_memory"_a, "listener"_a);
  m.def("reconstruct_lines", &reconstructFromLines, "source"_a, "options"_a, "max_memory"_a,
        "listener"_a);
}

}  // namespace volute::python
