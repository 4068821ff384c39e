// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/reconstruct.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "volute/base/file_name.hpp"
#include "volute/base/write_file.hpp"
#include "volute/capture/capture_check.hpp"
#include "volute/capture/write_capture.hpp"
#include "volute/cli/capture_input.hpp"
#include "volute/cli/commands/commands.hpp"
#include "volute/cli/ranks.hpp"
#include "volute/cli/shared_options.hpp"
#include "volute/cli/volume_output.hpp"
#include "volute/tomography/hold_out_rotation.hpp"
#include "volute/tomography/layout.hpp"
#include "volute/tomography/line_volumes.hpp"
#include "volute/tomography/reconstruction_page.hpp"
#include "volute/tomography/reconstruction_report.hpp"
#include "volute/tomography/settings_check.hpp"
#include "volute/tomography/soot_frames.hpp"
#include "volute/volume_files/volume_input.hpp"
#include "volute/volume_files/volume_writer.hpp"

namespace volute::cli {
namespace {

ReconstructionSettings settingsOf(const Arguments& arguments, const Capture& capture,
                                  const Context& context) {
  ReconstructionSettings settings;
  TomographyOptions& options = settings.tomography;
  options.basis = arguments.get<std::string>("basis") == "box" ? Basis::kBox : Basis::kTrilinear;
  // The names are choices, so they are known.
  options.solver = *tomographySolverByName(arguments.get<std::string>("solver"));
  options.regularization = *regularizationByName(arguments.get<std::string>("regularization"));
  options.lambda = arguments.find<double>("lambda");
  options.sparsity = arguments.find<double>("sparsity");
  options.iterations = arguments.find<int>("iterations");
  options.raysPerPixel = arguments.get<std::string>("rays-per-pixel") == "1" ? 1 : 4;
  options.hull = !arguments.flag("no-hull");
  options.coarseToFine = arguments.flag("coarse-to-fine");
  options.temporal = arguments.get<double>("temporal");
  options.noiseSigma = capture.fittedNoise();
  options.maxMemory = context.maxMemory;
  settings.limits.saturated = arguments.get<double>("max-saturated");
  settings.warmStart = !arguments.flag("no-warm-start");
  settings.force = arguments.flag("force");
  settings.errorBars = arguments.flag("error-bars");
  settings.flame = arguments.flag("temperature");
  settings.singleScattering = arguments.get<std::string>("lighting") == "single-scattering";
  return settings;
}

Status checkLighting(const Capture& capture) {
  if (capture.measured == Measured::kAbsorption)
    return fail(ErrorCode::kInvalidArgument,
                "--lighting single-scattering: pictures of a lit background give extinction "
                "already; leave it");
  if (capture.lighting.lamps.empty())
    return fail(
        ErrorCode::kInvalidArgument,
        "--lighting single-scattering: {} states no lamps; add \"lamps\", each with a sun's "
        "direction and radiance or a point's position and intensity",
        capture.file.string());
  return {};
}

Status checkTemperature(const Capture& capture, const ReconstructionSettings& settings) {
  if (settings.singleScattering || capture.measured == Measured::kAbsorption)
    return fail(
        ErrorCode::kInvalidArgument,
        "--temperature: of light that a flame sends by itself; leave lamps and backgrounds");
  if (!capture.spectrum.stated())
    return fail(ErrorCode::kInvalidArgument,
                "--temperature: {} does not state what the channels see of each wavelength; add "
                "\"spectrum\" with sensitivities and what a black body gives",
                capture.file.string());
  return {};
}

Status writeReport(const std::string& file, const nlohmann::ordered_json& json,
                   ReconstructedFrames& frames, Progress& progress) {
  VOLUTE_TRY(writeFile(file, dumpJson(json) + "\n"));
  auto page = std::filesystem::path(file);
  return writeReconstructionPage(page.replace_extension(".html"), json, frames, progress);
}

Status checkReconstructTargets(const Arguments& arguments, const std::string& target) {
  if (const auto report = arguments.find<std::string>("report")) {
    VOLUTE_TRY(checkTarget(*report));
    if (extensionOf(*report) != ".json") {
      return fail(ErrorCode::kInvalidArgument,
                  "--report: '{}' does not end in .json; a page .html is written beside it",
                  *report);
    }
  }
  if (const auto refined = arguments.find<std::string>("refined"))
    VOLUTE_TRY(checkTarget(*refined));
  for (const char* more : {"velocity", "error-bars", "temperature"}) {
    if (arguments.flag(more) && !holdsSeveralGrids(target)) {
      return fail(ErrorCode::kInvalidArgument,
                  "--{}: '{}' holds one grid; put {{grid}} into its name, as in "
                  "fire_{{grid}}.npy, or write a .volute or %04d.vdb",
                  more, target);
    }
  }
  if (arguments.flag("error-bars") && arguments.get<std::string>("lighting") != "constant")
    return fail(ErrorCode::kInvalidArgument,
                "--error-bars: not with --lighting single-scattering; its extinction is no linear "
                "function of the pictures");
  if (arguments.given("rms") && !isVolutePath(target)) {
    return fail(ErrorCode::kInvalidArgument,
                "--rms is the error of a compressed file; '{}' does not end in .volute", target);
  }
  return {};
}

Refine refineOf(const Arguments& arguments) {
  const auto name = arguments.get<std::string>("refine");
  return name == "auto" ? Refine::kAuto : name == "always" ? Refine::kAlways : Refine::kNever;
}

/// The cameras to hold out; none with `auto`, which leaves each out in turn.
Result<std::vector<std::string>> heldOutOf(const Arguments& arguments, bool& inTurn) {
  auto names = arguments.all("hold-out");
  inTurn = std::ranges::find(names, "auto") != names.end();
  if (inTurn && names.size() > 1)
    return fail(ErrorCode::kInvalidArgument,
                "--hold-out auto leaves each camera out in turn; name no other camera");
  if (inTurn)
    names.clear();
  return names;
}

Result<VolumeWriter> openWriter(std::vector<WrittenGrid> grids, const std::string& target,
                                const std::string& from, Context& context) {
  return VolumeWriter::open(std::move(grids), target, "reconstructed from " + from, context,
                            context.team);
}

/// What leaving out each camera said.
void addRotation(HoldOutRotation& rotation, const Capture& capture, nlohmann::ordered_json& json,
                 Report& report) {
  rotation.addTo(json, capture);
  std::vector<std::string> texts;
  for (const LeftOutCamera& camera : rotation.cameras())
    texts.push_back(fmt::format("{} {:.2f} dB, {:.3f}", camera.name, camera.psnr, camera.residual));
  report.add("verdict", json["verdict"].get<std::string>())
      .add("held_out_in_turn", json["held_out_in_turn"], fmt::format("{}", fmt::join(texts, "; ")));
}

/// What compression cost in the pictures.
Status addFile(ReconstructedFrames& frames, const std::string& target,
               const ReconstructionSettings& settings, nlohmann::ordered_json& json,
               Context& context) {
  if (!isVolutePath(target) || settings.singleScattering || settings.flame || !context.team.leads())
    return {};
  InputOptions input;
  input.grid = frames.info().name;
  VOLUTE_ASSIGN(const auto written, openVolume(target, input, context));
  return addResidualOfFile(frames, *written.source, json, context.progress);
}

void addTemperature(const nlohmann::ordered_json& soot, Report& report) {
  const auto& mean = soot["mean_temperature"];
  report.add("mean_temperature", mean,
             mean.is_number()
                 ? fmt::format("{:.0f} K, weighted by the light; at most {:.0f} K",
                               mean.get<double>(), soot["greatest_temperature"].get<double>())
                 : "not determined");
  report.add("optical_depth", soot["optical_depth"],
             fmt::format("{:.3g} at 550 nm, at most along x", soot["optical_depth"].get<double>()));
}

Status runFrames(ReconstructedFrames& frames, VelocityFrames* velocity, const Arguments& arguments,
                 const CaptureRefinement& refinement, const ReconstructionSettings& settings,
                 HoldOutRotation* rotation, Context& context) {
  constexpr double kEstimateRms = 5e-3;  // less than what the estimates are off by
  const Capture& capture = refinement.capture;
  const auto target = arguments.get<std::string>("output");
  const double rms = arguments.get<double>("rms");
  std::vector<WrittenGrid> grids{{&frames, rms}};
  if (velocity)
    grids.push_back({velocity, std::max(rms, kEstimateRms)});
  if (settings.errorBars)
    grids.push_back({&frames.errorBars(), std::max(rms, kEstimateRms)});
  std::optional<SootFrames> soot;
  if (settings.flame) {
    soot.emplace(frames, capture.spectrum);
    for (FrameSource* grid : soot->grids()) grids.push_back({grid, rms});
  }
  VOLUTE_ASSIGN(auto writer,
                openWriter(std::move(grids), target, capture.file.filename().string(), context));
  VOLUTE_TRY(frames.solveAll(context.team));
  if (velocity)
    VOLUTE_TRY(velocity->solveAll(context.team));
  VOLUTE_ASSIGN(auto json, reconstructionReport(refinement, settings, frames, velocity));
  const VolumeInfo& info = frames.info();
  Report report;
  report.add("output", target);
  addSize(report, info);
  report.add("channels", info.channels, fmt::format("{}", info.channels));
  if (rotation)
    addRotation(*rotation, capture, json, report);
  VOLUTE_TRY(writer.write(report));
  VOLUTE_TRY(addFile(frames, target, settings, json, context));
  if (soot) {
    VOLUTE_TRY(soot->addTo(json, context.progress));
    addTemperature(json["soot"], report);
  }
  if (velocity)
    report.add("mean_speed", json["velocity"]["mean_speed"],
               fmt::format("{:.3g} m/s", json["velocity"].value("mean_speed", 0.0)));
  if (const auto file = arguments.find<std::string>("report")) {
    if (context.team.leads())
      VOLUTE_TRY(writeReport(*file, json, frames, context.progress));
  }
  addSummary(json, report);
  VOLUTE_TRY(writeStats(arguments, context, report.json()));
  context.print(report);
  return {};
}

/// Measured lines instead of pictures; the targets have been checked.
Status runLines(const Arguments& arguments, Context& context) {
  const std::string& file = arguments.positional(0);
  const auto target = arguments.get<std::string>("output");
  for (const char* name :
       {"velocity",       "hold-out",       "error-bars", "temperature",   "refine",
        "refined",        "max-saturated",  "images",     "color",         "solver",
        "regularization", "sparsity",       "temporal",   "noise-sigma",   "rays-per-pixel",
        "no-hull",        "coarse-to-fine", "warm-start", "no-warm-start", "lighting"}) {
    if (arguments.given(name))
      return fail(ErrorCode::kInvalidArgument, "--{} is for cameras, and {} has lines", name, file);
  }
  if (context.team.size() > 1)
    return fail(ErrorCode::kUnsupported, "{}: lines are for one process; leave mpirun out", file);
  VOLUTE_ASSIGN(const auto where, captureOptionsOf(arguments, context));
  LineOptions how;
  if (arguments.given("basis") && arguments.get<std::string>("basis") == "trilinear")
    how.basis = Basis::kTrilinear;
  how.lambda = arguments.find<double>("lambda");
  how.iterations = arguments.find<int>("iterations");
  VOLUTE_ASSIGN(const auto found,
                reconstructLineFile(file, where, how, arguments.flag("force"), context.progress));
  SequenceSource source(found.volumes);
  const VolumeInfo& info = source.info();
  Report report;
  report.add("output", target)
      .add("grid", info.name, info.unit.empty() ? info.name : info.name + " [" + info.unit + "]");
  addSize(report, info);
  VOLUTE_ASSIGN(auto writer,
                openWriter({{&source, arguments.get<double>("rms")}}, target, file, context));
  VOLUTE_TRY(writer.write(report));
  const double residual = found.mean("residual");
  if (how.lambda) {
    report.add("left_out", nullptr, "not measured, for --lambda was given");
  } else {
    const double leftOut = found.mean("left_out");
    report.add("left_out", jsonNumber(leftOut),
               fmt::format("{:.3f} (relative L2 of lines that were left out in turn)", leftOut));
  }
  report.add("residual", jsonNumber(residual),
             fmt::format("{:.3f} (of the lines that were fitted)", residual));
  if (const auto page = arguments.find<std::string>("report")) {
    auto json = report.json();
    json["lines"] = found.records;
    VOLUTE_TRY(writeFile(*page, dumpJson(json) + "\n"));
  }
  VOLUTE_TRY(writeStats(arguments, context, report.json()));
  context.print(report);
  return {};
}

Status runReconstruct(const Arguments& arguments, Context& context) {
  const auto target = arguments.get<std::string>("output");
  VOLUTE_TRY(checkReconstructTargets(arguments, target));
  VOLUTE_TRY(checkTarget(target, context));
  if (context.team.size() > 1 && target == "-") {
    return fail(ErrorCode::kInvalidArgument,
                "--output -: several processes keep finished frames in a folder beside the output; "
                "give it a name");
  }
  VOLUTE_TRY(checkFolderIsShared(target, context.team));
  if (extensionOf(arguments.positional(0)) == ".csv")
    return runLines(arguments, context);
  VOLUTE_ASSIGN(auto options, captureOptionsOf(arguments, context));
  options.noiseSigma = arguments.find<double>("noise-sigma");
  VOLUTE_ASSIGN(const auto capture, openCapture(arguments.positional(0), options));
  remarkOn(capture, context.progress);
  if (arguments.flag("velocity") && capture.frames.size() < 2)
    return fail(ErrorCode::kInvalidArgument, "--velocity: needs two frames or more");
  bool inTurn = false;
  VOLUTE_ASSIGN(const auto heldOut, heldOutOf(arguments, inTurn));
  if (inTurn && (context.team.size() > 1 || target == "-")) {
    return fail(ErrorCode::kInvalidArgument,
                "--hold-out auto: for one process, and an output with a name");
  }
  auto settings = settingsOf(arguments, capture, context);
  VOLUTE_TRY(checkSettings(settings, capture));
  if (settings.singleScattering)
    VOLUTE_TRY(checkLighting(capture));
  if (settings.flame)
    VOLUTE_TRY(checkTemperature(capture, settings));
  remarkOnUnused(settings, capture, context.progress);
  const VolumeGeometry geometry{capture.volume.bounds, capture.volume.resolution};
  VOLUTE_TRY(checkVolumeSize(geometry, context.maxMemory));
  VOLUTE_TRY(checkCapture(capture, heldOut, settings.force, context.maxMemory, context.progress));
  CameraLayout(capture).remark(context.verbose, context.progress);
  VOLUTE_ASSIGN(const auto refinement, refineCapture(capture, heldOut, refineOf(arguments),
                                                     context.maxMemory, context.progress));
  if (const auto file = arguments.find<std::string>("refined"))
    VOLUTE_TRY(writeCapture(*file, refinement.capture));
  settings.causeNamed = refinement.namesCause();
  settings.causeNamedIn = refinement.faultyFrames;
  std::unique_ptr<HoldOutRotation> rotation;
  if (inTurn) {
    VOLUTE_ASSIGN(rotation, HoldOutRotation::run(capture, settings, refineOf(arguments), target,
                                                 context.maxMemory, context.progress));
  }
  VOLUTE_ASSIGN(const auto frames, ReconstructedFrames::open(refinement.capture, settings, heldOut,
                                                             target, context.progress));
  std::unique_ptr<VelocityFrames> velocity;
  if (arguments.flag("velocity")) {
    VOLUTE_ASSIGN(velocity, VelocityFrames::open(*frames, {}, target, context.progress));
  }
  const Status status = context.team.agree(
      runFrames(*frames, velocity.get(), arguments, refinement, settings, rotation.get(), context));
  if (velocity)
    velocity->work().leave(status.has_value());
  if (frames->work().leave(status.has_value()) && context.team.leads()) {
    context.progress.remark(
        fmt::format("finished frames are kept in {}; the same command continues from there",
                    frames->work().path().string()));
  }
  return status;
}

std::vector<Option> solverOptions() {
  using enum ValueKind;
  return {
      {.name = "basis",
       .kind = kChoice,
       .value = "NAME",
       .help = "interpolation between voxel centres, stored in the file",
       .initial = "trilinear",
       .choices = {"trilinear", "box"}},
      {.name = "solver",
       .kind = kChoice,
       .value = "NAME",
       .help = "accelerated projected gradient, or classic methods for comparison",
       .initial = "apg",
       .choices = {"apg", "mlem", "sirt", "cgls"}},
      {.name = "iterations",
       .kind = kInteger,
       .value = "N",
       .help = "exactly N iterations; if not given, until convergence (regularization none: by "
               "noise or held-out pixels)",
       .least = 1,
       .most = 100000},
      {.name = "regularization",
       .kind = kChoice,
       .value = "NAME",
       .help = "prior for volumes that fit equally well; auto: chosen from the data",
       .initial = "auto",
       .choices = {"auto", "none", "tv", "smooth", "wavelet"}},
      {.name = "lambda",
       .kind = kNumber,
       .value = "F",
       .help = "strength of the prior, relative to the largest eigenvalue of S'S; if not given, "
               "chosen from the data, or 1e-5 with smooth and wavelet",
       .least = 0},
      {.name = "sparsity",
       .kind = kNumber,
       .value = "F",
       .help = "with total variation: penalty on light in dark voxels, relative to lambda; if not "
               "given, 2.5, or 0 with fewer than 4 cameras or if the data prefer it",
       .least = 0},
      {.name = "noise-sigma",
       .kind = kNumber,
       .value = "S",
       .help = "noise of the light of a pixel's channel [radiance]; if not given, that of the "
               "capture",
       .positive = true},
      raysOption(),
      {.name = "no-hull",
       .help = "solve for all voxels, not only those where every camera sees "
               "light"},
      {.name = "lighting",
       .kind = kChoice,
       .value = "MODEL",
       .help = "constant: the medium sends the same light in all directions; single-scattering: it "
               "scatters that of the capture's lamps, and the result is extinction [1/m]",
       .initial = "constant",
       .choices = {"constant", "single-scattering"}},
      {.name = "coarse-to-fine", .help = "solve at half the resolution first"},
      {.name = "warm-start", .help = "start each frame from the previous one (default)"},
      {.name = "no-warm-start", .help = "start each frame from zero"},
      {.name = "temporal",
       .kind = kNumber,
       .value = "F",
       .help = "pull each frame towards the previous one, moved along, by F times the largest "
               "eigenvalue of S'S",
       .initial = "0",
       .least = 0}};
}

std::vector<Option> reconstructOptionTable() {
  using enum ValueKind;
  std::vector<Option> options = {
      outputOption("OUT",
                   ".volute, .npy (float32, t,z,y,x[,c]), .nc, .h5, %04d.vdb, %04d.vti, .pvd, or - "
                   "for a .npy",
                   ".volute"),
      {.name = "resolution",
       .kind = kText,
       .value = "N[,N,N]",
       .help = "voxels in x, y, z, or cubic voxels with N on the longest side; if not given, that "
               "of the capture"},
      framesOption("frames with numbers A <= n < B; volute join joins parts"),
      rmsOption("relative RMS error of the compressed .volute", "0.001"),
      {.name = "velocity",
       .help =
           "estimate the velocity [m/s] between frames; written as grid 'velocity' of a .volute "
           "or %04d.vdb, or to a file of its own with {grid} in OUT"},
      {.name = "error-bars",
       .help = "estimate the standard deviation of each voxel; written as grid 'emission_sigma' "
               "(extinction_sigma) of a .volute or %04d.vdb, or to a file of its own with {grid} "
               "in OUT"},
      {.name = "temperature",
       .help = "of flames: temperature [K] and extinction of the soot from the colours, by the "
               "capture's spectrum; grids beside the emission, as with --error-bars"},
      {.name = "hold-out",
       .kind = kText,
       .value = "NAME",
       .help = "hold this camera out for comparison; auto: also reconstruct without each camera "
               "in turn, and report how well the others predict it",
       .several = true},
      {.name = "refine",
       .kind = kChoice,
       .value = "WHEN",
       .help = "refine poses, focal lengths, principal points, gains, lenses and responses with "
               "the volume; "
               "auto: if cameras disagree and refinement makes them agree much better",
       .initial = "auto",
       .choices = {"auto", "never", "always"}},
      {.name = "refined",
       .kind = kOutput,
       .value = "FILE.json",
       .help = "write the capture with the calibration that was used"},
      {.name = "report",
       .kind = kOutput,
       .value = "FILE.json",
       .help = "write all measurements, and of cameras FILE.html with plots and pictures"},
      statsOption(),
      {.name = "max-saturated",
       .kind = kNumber,
       .value = "SHARE",
       .help = "largest share of saturated pixels among the lit ones; other pictures are refused",
       .initial = "0.5",
       .least = 0,
       .most = 1},
      {.name = "force",
       .help = "continue despite detected faults and missing pictures, or with "
               "fewer than 3 views"}};
  for (const auto& table : {captureOptionTable(), solverOptions()})
    options.insert(options.end(), table.begin(), table.end());
  return options;
}

}  // namespace

Command reconstructCommand() {
  return {
      .name = "reconstruct",
      .summary = "Reconstructs volumes of fire from calibrated cameras",
      .examples = {"volute reconstruct capture.json -o fire.volute --report fire.json",
                   "volute reconstruct transforms.json -o fire.npy --images "
                   "'in/{camera}_%04d.png' --bounds=-1,-1,0,1,1,3 --resolution 96",
                   "volute reconstruct capture.json -o smoke.volute --velocity",
                   "volute reconstruct capture.json -o fire_{grid}.npy --error-bars",
                   "volute reconstruct capture.json -o part2.volute --frames 100:200",
                   "volute reconstruct lamps.csv -o smoke.volute --bounds=0,0,0,6,4,3"},
      .description =
          "Solves each frame for the emission whose line integrals match the pictures: "
          "non-negative least squares over all cameras and colours, with zeros where a camera "
          "sees nothing. CAPTURE is a capture.json, a NeRF transforms.json, the folder of a "
          "COLMAP model or an OpenCV .yml, or a .csv of optical depths along lines; "
          "docs/capture.md describes them.\n\nImplausible "
          "captures are refused, with camera, frame and number: mirrored or scaled rotations, "
          "mismatched units or sizes, missing, black or saturated pictures, non-finite values, "
          "backgrounds that moved, an empty hull. Doubtful cases give a warning.\n\nFinished "
          "frames are kept in OUT.work beside the output until it is complete; an interrupted run "
          "continues from there when it is started again.",
      .positionals = {{.name = "CAPTURE",
                       .help = "the cameras and their pictures, or a .csv of lines"}},
      .options = reconstructOptionTable(),
      .oneOf = {{{"warm-start", "no-warm-start"}, false}},
      .ranks = true,
      .run = runReconstruct};
}

}  // namespace volute::cli
