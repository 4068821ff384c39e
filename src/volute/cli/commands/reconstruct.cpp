// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/reconstruct.hpp"

#include <algorithm>
#include <filesystem>

#include "volute/base/write_file.hpp"
#include "volute/capture/capture_check.hpp"
#include "volute/capture/write_capture.hpp"
#include "volute/cli/capture_input.hpp"
#include "volute/cli/commands/commands.hpp"
#include "volute/cli/commands/reconstruct_lines.hpp"
#include "volute/cli/ranks.hpp"
#include "volute/cli/reconstruction_output.hpp"
#include "volute/cli/volume_output.hpp"
#include "volute/media/volume/volume_input.hpp"
#include "volute/tomography/capture_refinement.hpp"
#include "volute/tomography/hold_out_rotation.hpp"
#include "volute/tomography/layout.hpp"
#include "volute/tomography/reconstructed_frames.hpp"
#include "volute/tomography/reconstruction_page.hpp"
#include "volute/tomography/reconstruction_report.hpp"
#include "volute/tomography/run_key.hpp"
#include "volute/tomography/velocity_frames.hpp"

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
  options.noiseSigma = arguments.find<double>("noise-sigma");
  if (!options.noiseSigma)
    options.noiseSigma = capture.noiseSigma;
  options.maxMemory = context.maxMemory;
  settings.limits.saturated = arguments.get<double>("max-saturated");
  settings.warmStart = !arguments.flag("no-warm-start");
  settings.force = arguments.flag("force");
  return settings;
}

void remarkOnLayout(const Capture& capture, Context& context) {
  constexpr std::size_t kNarrowest = 5;
  const CameraLayout layout(capture);
  const std::size_t pairs = layout.angles.size();
  if (context.verbose || pairs <= kNarrowest) {
    if (pairs > 0)
      context.progress.remark(
          fmt::format("degrees between lines of sight, modulo 180: {}", layout.narrowest(pairs)));
  } else {
    context.progress.remark(
        fmt::format("degrees between lines of sight, modulo 180, the {} narrowest of {} pairs "
                    "(--verbose: all): {}",
                    kNarrowest, pairs, layout.narrowest(kNarrowest)));
  }
  if (const auto advice = layout.advice())
    context.progress.remark(*advice);
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
  if (const auto bars = arguments.find<std::string>("error-bars")) {
    if (isVolutePath(*bars))
      return fail(ErrorCode::kInvalidArgument,
                  "--error-bars: '{}': expected .npy, or a pattern %04d.vdb or %04d.vti", *bars);
    VOLUTE_TRY(checkTarget(*bars, true));
  }
  if (arguments.flag("velocity"))
    VOLUTE_TRY(checkVelocityTarget(target));
  if (arguments.given("rms") && !isVolutePath(target)) {
    return fail(ErrorCode::kInvalidArgument,
                "--rms is the error of a compressed file; '{}' does not end in .volute", target);
  }
  return checkTarget(target, true);
}

Result<std::unique_ptr<ReconstructedFrames>> openFrames(const Capture& capture,
                                                        const ReconstructionSettings& settings,
                                                        const std::vector<std::string>& heldOut,
                                                        const std::string& target,
                                                        Context& context) {
  VOLUTE_ASSIGN(auto views,
                ViewReader::open(capture, heldOut, context.maxMemory, context.progress));
  VOLUTE_ASSIGN(const auto work, WorkFolder::open(target));
  const bool before = work.any();
  auto frames = ReconstructedFrames::open(capture, settings, std::move(views), work,
                                          frameKeys(capture, settings, heldOut), context.progress);
  if (!frames) {
    if (!before && context.team.leads())
      work.remove();
    return frames;
  }
  if (before) {
    context.progress.remark(
        fmt::format("{}: an earlier run finished {} of {} frames with these options and inputs",
                    work.path().string(), (*frames)->resumed(), (*frames)->info().frames));
  }
  return frames;
}

Result<std::unique_ptr<VelocityFrames>> openVelocity(ReconstructedFrames& frames,
                                                     const std::vector<std::string>& keys,
                                                     const std::string& target, Context& context) {
  VOLUTE_ASSIGN(auto work, WorkFolder::open(target + ".velocity"));
  return VelocityFrames::open(frames, {}, std::move(work), keys, context.progress);
}

Refine refineOf(const Arguments& arguments) {
  const auto name = arguments.get<std::string>("refine");
  return name == "auto" ? Refine::kAuto : name == "always" ? Refine::kAlways : Refine::kNever;
}

/// The cameras to hold out; none with `auto`, which leaves each out in turn.
Result<std::vector<std::string>> heldOutOf(const Arguments& arguments, bool& inTurn) {
  auto names =
      arguments.find<std::vector<std::string>>("hold-out").value_or(std::vector<std::string>{});
  inTurn = std::ranges::find(names, "auto") != names.end();
  if (inTurn && names.size() > 1)
    return fail(ErrorCode::kInvalidArgument,
                "--hold-out auto leaves each camera out in turn; name no other camera");
  if (inTurn)
    names.clear();
  if (!inTurn && arguments.find<std::string>("error-bars"))
    return fail(ErrorCode::kInvalidArgument,
                "--error-bars: needs volumes without each camera: --hold-out auto");
  return names;
}

Result<CaptureRefinement> refinedCapture(const Capture& capture, const Arguments& arguments,
                                         const std::vector<std::string>& heldOut,
                                         Context& context) {
  VOLUTE_ASSIGN(auto refinement, refineCapture(capture, heldOut, refineOf(arguments),
                                               context.maxMemory, context.progress));
  for (const std::string& text : refinement.faults) context.progress.remark("warning: " + text);
  if (!refinement.faults.empty() && !refinement.used)
    context.progress.remark("the calibration is not refined before that is mended");
  if (refinement.used) {
    context.progress.remark(fmt::format(
        "calibration refined with the volume on frame{} {}: {:.1f} % of the pictures are not "
        "explained, instead of {:.1f} % (relative L2, coarse voxels; --refine never leaves it)",
        refinement.frames.size() == 1 ? "" : "s", fmt::join(refinement.frames, ", "),
        100 * refinement.after, 100 * refinement.before));
    for (const std::string& text : describeCorrections(refinement)) context.progress.remark(text);
    for (const std::string& text : outstandingCorrections(refinement))
      context.progress.remark("warning: " + text);
  }
  if (const auto file = arguments.find<std::string>("refined"))
    VOLUTE_TRY(writeCapture(*file, refinement.capture));
  return refinement;
}

Status writeErrorBars(const std::string& target, HoldOutRotation& rotation, Context& context) {
  VOLUTE_ASSIGN(auto sink, openSink(target, rotation.errorBars().info(), true));
  return copyFrames(rotation.errorBars(), *sink, "writing error bars", context.progress);
}

/// What leaving out each camera said: the headline, a table, and a verdict.
Status addRotation(HoldOutRotation& rotation, const Arguments& arguments, const Capture& capture,
                   nlohmann::ordered_json& json, Report& report, Context& context) {
  const double fitted = json["residual"].is_number() ? json["residual"].get<double>() : 0;
  const auto verdict = captureVerdict(capture, rotation.cameras(), fitted);
  json["held_out_psnr"] = jsonNumber(rotation.psnr());
  json["held_out_in_turn"] = rotation.json();
  json["verdict"] = verdict;
  std::vector<std::string> texts;
  for (const LeftOutCamera& camera : rotation.cameras())
    texts.push_back(fmt::format("{} {:.2f} dB, {:.3f}", camera.name, camera.psnr, camera.residual));
  report.add("verdict", verdict)
      .add("held_out_in_turn", json["held_out_in_turn"], fmt::format("{}", fmt::join(texts, "; ")));
  if (const auto file = arguments.find<std::string>("error-bars"))
    VOLUTE_TRY(writeErrorBars(*file, rotation, context));
  return {};
}

Status runFrames(ReconstructedFrames& frames, VelocityFrames* velocity, const Arguments& arguments,
                 const CaptureRefinement& refinement, const ReconstructionSettings& settings,
                 HoldOutRotation* rotation, Context& context) {
  const Capture& capture = refinement.capture;
  const auto target = arguments.get<std::string>("output");
  VOLUTE_ASSIGN(auto writer,
                ReconstructionWriter::open(
                    frames, velocity,
                    {target, arguments.get<double>("rms"),
                     fmt::format("reconstructed from {}", capture.file.filename().string())},
                    context));
  VOLUTE_TRY(frames.solveAll(context.team));
  if (velocity)
    VOLUTE_TRY(velocity->solveAll(context.team));
  VOLUTE_ASSIGN(auto json, reconstructionReport(capture, settings, frames));
  if (velocity) {
    VOLUTE_ASSIGN(json["velocity"], velocity->json());
  }
  json["refinement"] = refinementJson(refinement);
  for (const std::string& text : refinement.faults) json["warnings"].push_back(text);
  for (const std::string& text : outstandingCorrections(refinement))
    json["warnings"].push_back(text);
  const VolumeInfo& info = frames.info();
  Report report;
  report.add("output", target)
      .add("frames", info.frames, fmt::format("{}", info.frames))
      .add("size", {info.x, info.y, info.z},
           fmt::format("{} x {} x {} voxels", info.x, info.y, info.z))
      .add("channels", info.channels, fmt::format("{}", info.channels));
  if (rotation)
    VOLUTE_TRY(addRotation(*rotation, arguments, capture, json, report, context));
  VOLUTE_TRY(writer.write(report, context));
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

Status runReconstruct(const Arguments& arguments, Context& context) {
  const auto target = arguments.get<std::string>("output");
  if (context.json && target == "-") {
    return fail(ErrorCode::kInvalidArgument,
                "--json and '--output -' both want standard output; leave one");
  }
  VOLUTE_TRY(checkReconstructTargets(arguments, target));
  if (context.team.size() > 1 && target == "-") {
    return fail(ErrorCode::kInvalidArgument,
                "--output -: several processes keep finished frames in a folder beside the output; "
                "give it a name");
  }
  VOLUTE_TRY(checkFolderIsShared(target, context.team));
  context.resultsToStderr = target == "-";
  if (isLineFile(arguments.positional(0)))
    return runReconstructLines(arguments, context);
  VOLUTE_ASSIGN(const auto options, captureOptionsOf(arguments, context));
  VOLUTE_ASSIGN(const auto capture, openCapture(arguments.positional(0), options));
  remarkOn(capture, context);
  if (arguments.flag("velocity") && capture.frames.size() < 2)
    return fail(ErrorCode::kInvalidArgument, "--velocity: needs two frames or more");
  bool inTurn = false;
  VOLUTE_ASSIGN(const auto heldOut, heldOutOf(arguments, inTurn));
  if (inTurn && (context.team.size() > 1 || target == "-")) {
    return fail(ErrorCode::kInvalidArgument,
                "--hold-out auto: for one process, and an output with a name");
  }
  auto settings = settingsOf(arguments, capture, context);
  const VolumeGeometry geometry{capture.volume.bounds, capture.volume.resolution};
  VOLUTE_TRY(checkVolumeSize(geometry, context.maxMemory));
  VOLUTE_TRY(checkCapture(capture, heldOut, settings.force, context.maxMemory, context.progress));
  remarkOnLayout(capture, context);
  VOLUTE_ASSIGN(const auto refinement, refinedCapture(capture, arguments, heldOut, context));
  settings.causeNamed = !refinement.faults.empty() && !refinement.used;
  std::unique_ptr<HoldOutRotation> rotation;
  if (inTurn) {
    VOLUTE_ASSIGN(rotation, HoldOutRotation::run(capture, settings, refineOf(arguments), target,
                                                 context.maxMemory, context.progress));
  }
  VOLUTE_ASSIGN(auto frames, openFrames(refinement.capture, settings, heldOut, target, context));
  std::unique_ptr<VelocityFrames> velocity;
  if (arguments.flag("velocity")) {
    VOLUTE_ASSIGN(velocity, openVelocity(*frames, frameKeys(refinement.capture, settings, heldOut),
                                         target, context));
  }
  const Status status = context.team.agree(runFrames(*frames, velocity.get(), arguments, refinement,
                                                     settings, rotation.get(), context));
  if (!context.team.leads())
    return status;
  const bool whole = status || target == "-";
  if (velocity && (whole || !velocity->work().any()))
    velocity->work().remove();
  if (!status && target != "-" && frames->work().any()) {
    context.progress.remark(
        fmt::format("finished frames are kept in {}; the same command continues from there",
                    frames->work().path().string()));
  } else {
    frames->work().remove();
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
               "chosen from the data",
       .least = 0},
      {.name = "sparsity",
       .kind = kNumber,
       .value = "F",
       .help =
           "with total variation: penalty on light in dark voxels, relative to lambda; if not "
           "given, 2.5, or 0 if the data prefer it",
       .least = 0},
      {.name = "noise-sigma",
       .kind = kNumber,
       .value = "S",
       .help = "noise of a pixel's channel [radiance]; if not given, that of the capture",
       .positive = true},
      {.name = "rays-per-pixel",
       .kind = kChoice,
       .value = "N",
       .help = "1: through the pixel's centre; 4: mean of four rays at its quarter points",
       .initial = "4",
       .choices = {"1", "4"}},
      {.name = "no-hull", .help = "solve for all voxels, not only those where every camera sees "
                                  "light"},
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
      {.name = "output",
       .letter = 'o',
       .kind = kOutput,
       .value = "OUT",
       .help = ".volute, .npy (float32, t,z,y,x[,c]), %04d.vdb, %04d.vti, .pvd, or - for a .npy",
       .derived = ".volute"},
      {.name = "resolution",
       .kind = kText,
       .value = "N[,N,N]",
       .help = "voxels in x, y, z, or cubic voxels with N on the longest side; if not given, that "
               "of the capture"},
      {.name = "frames",
       .kind = kFrames,
       .value = "A:B[:S]",
       .help = "frames with numbers A <= n < B; volute join joins parts"},
      {.name = "rms",
       .kind = kNumber,
       .value = "R",
       .help = "relative RMS error of the compressed .volute",
       .initial = "0.001",
       .most = 1,
       .positive = true},
      {.name = "velocity",
       .help = "estimate the velocity [m/s] between frames; written as grid 'velocity' of a .volute "
               "or %04d.vdb, or to a file of its own with {grid} in OUT"},
      {.name = "hold-out",
       .kind = kText,
       .value = "NAME",
       .help = "hold this camera out for comparison; auto: also reconstruct without each camera "
               "in turn, and report how well the others predict it",
       .several = true},
      {.name = "error-bars",
       .kind = kOutput,
       .value = "FILE",
       .help = "with --hold-out auto: write standard deviations of voxels to .npy, %04d.vdb or "
               "%04d.vti"},
      {.name = "refine",
       .kind = kChoice,
       .value = "WHEN",
       .help = "refine poses, focal lengths, principal points and gains together with the volume; "
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
       .help = "write all measurements, and FILE.html with plots and pictures"},
      statsOption(),
      {.name = "max-saturated",
       .kind = kNumber,
       .value = "SHARE",
       .help = "largest share of saturated pixels among the lit ones; other pictures are refused",
       .initial = "0.5",
       .least = 0,
       .most = 1},
      {.name = "force", .help = "continue despite detected faults, or with fewer than 3 views"}};
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
      .positionals = {{.name = "CAPTURE", .help = "the cameras and their pictures, or a .csv of lines"}},
      .options = reconstructOptionTable(),
      .oneOf = {{{"warm-start", "no-warm-start"}, false}},
      .ranks = true,
      .run = runReconstruct};
}

}  // namespace volute::cli
