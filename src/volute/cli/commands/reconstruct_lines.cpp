// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/commands/reconstruct_lines.hpp"

#include <algorithm>
#include <array>

#include "volute/base/file_name.hpp"
#include "volute/base/write_file.hpp"
#include "volute/capture/open_capture.hpp"
#include "volute/cli/capture_input.hpp"
#include "volute/cli/reconstruction_output.hpp"
#include "volute/cli/volume_output.hpp"
#include "volute/report/json.hpp"
#include "volute/tomography/line_reconstruction.hpp"

namespace volute::cli {
namespace {

/// Finished volumes.
class LineVolumes final : public FrameSource {
 public:
  LineVolumes(VolumeInfo info, std::vector<std::vector<float>> volumes)
      : info_(std::move(info)), volumes_(std::move(volumes)) {}

  const VolumeInfo& info() const override { return info_; }

  Status readFrame(int index, std::span<float> values) override {
    std::ranges::copy(volumes_[static_cast<std::size_t>(index)], values.begin());
    return {};
  }

 private:
  VolumeInfo info_;
  std::vector<std::vector<float>> volumes_;
};

/// What is there for cameras alone.
Status refuseCameraOptions(const Arguments& arguments) {
  constexpr std::array kCameras{"velocity",    "hold-out",       "error-bars", "refine",
                                "refined",     "max-saturated",  "images",     "color",
                                "solver",      "regularization", "sparsity",   "temporal",
                                "noise-sigma", "rays-per-pixel", "no-hull",    "coarse-to-fine",
                                "warm-start",  "no-warm-start"};
  for (const char* name : kCameras) {
    if (arguments.given(name))
      return fail(ErrorCode::kInvalidArgument, "--{} is for cameras, and {} has lines", name,
                  arguments.positional(0));
  }
  return {};
}

/// As it was stated, else the box around the lines' ends, with 32 voxels on its longest side.
Result<VolumeGeometry> geometryOf(const LineFile& lines, const CaptureOptions& options,
                                  const std::string& file, Context& context) {
  constexpr int kUsual = 32;
  VolumeGeometry geometry;
  if (options.bounds) {
    geometry.bounds = *options.bounds;
  } else {
    for (const LineFrame& frame : lines.frames) {
      for (const LineMeasurement& one : frame.lines) {
        geometry.bounds.extend(one.line.origin);
        geometry.bounds.extend(one.line.at(one.line.end));
      }
    }
    if (!geometry.bounds.size().allFinite() || geometry.bounds.empty())
      return fail(
          ErrorCode::kInvalidArgument,
          "{}: does not say where the volume is, as its lines have no ends or are flat; state "
          "its outer faces in metres with --bounds X0,Y0,Z0,X1,Y1,Z1",
          file);
    const Vec3 &low = geometry.bounds.min, &high = geometry.bounds.max;
    context.progress.remark(fmt::format(
        "{}: the volume is the box around the lines' ends, {:g},{:g},{:g},{:g},{:g},{:g} "
        "(--bounds)",
        file, low.x(), low.y(), low.z(), high.x(), high.y(), high.z()));
  }
  geometry.resolution = options.resolution.value_or(std::array{kUsual, 0, 0});
  if (geometry.resolution[1] == 0)
    geometry.resolution = cubicResolution(geometry.bounds, geometry.resolution[0]);
  return geometry;
}

/// Lines that the volume is not crossed by are an error, or are left out.
Status leaveOutBeside(LineFrame& frame, const VolumeGeometry& geometry, bool force,
                      const std::string& file, Context& context) {
  const auto beside = linesBeside(frame.lines, geometry);
  if (beside.empty() || !force)
    return {};
  context.progress.remark(
      fmt::format("warning: {}: {} of {} lines of frame {} miss the volume and "
                  "are left out",
                  file, beside.size(), frame.lines.size(), frame.number));
  for (auto at = beside.rbegin(); at != beside.rend(); ++at)
    frame.lines.erase(frame.lines.begin() + static_cast<std::ptrdiff_t>(*at));
  return {};
}

VolumeInfo infoOf(const LineFile& lines, const VolumeGeometry& geometry, Basis basis) {
  VolumeInfo info;
  info.name = lines.opticalDepths ? "extinction" : "density";
  info.unit = lines.opticalDepths ? "1/m" : "";
  info.x = geometry.resolution[0], info.y = geometry.resolution[1], info.z = geometry.resolution[2];
  info.bounds = geometry.bounds;
  info.basis = basis;
  constexpr double kFramesPerSecond = 25;
  for (const LineFrame& frame : lines.frames) {
    info.frameNumbers.push_back(frame.number);
    info.times.push_back(
        lines.hasTimes ? frame.time : (frame.number - lines.frames[0].number) / kFramesPerSecond);
  }
  info.frames = static_cast<int>(lines.frames.size());
  return info;
}

/// The frames that were asked for.
Status choose(LineFile& lines, const FrameRange& range) {
  const int first = range.begin.value_or(lines.frames.front().number);
  const int last = lines.frames.back().number;
  std::erase_if(lines.frames, [&](const LineFrame& frame) {
    return frame.number < first || (range.end && frame.number >= *range.end) ||
           (frame.number - first) % range.step != 0;
  });
  if (!lines.frames.empty())
    return {};
  return fail(ErrorCode::kInvalidArgument, "--frames selects nothing; the last frame is {}", last);
}

Status checkSizes(const LineFile& lines, const VolumeGeometry& geometry, std::uint64_t maxMemory) {
  VOLUTE_TRY(checkVolumeSize(geometry, maxMemory));
  const std::uint64_t bytes = 4 * geometry.voxels() * lines.frames.size();
  if (bytes <= maxMemory / 2)
    return {};
  return fail(
      ErrorCode::kTooLarge,
      "{} frames of {} voxels need {} MiB, more than half of the {} MiB that are allowed; take "
      "them in parts with --frames, or allow more (--max-memory)",
      lines.frames.size(), geometry.voxels(), bytes >> 20, maxMemory >> 20);
}

/// Solves all frames; adds what is to be said of each.
Result<std::vector<std::vector<float>>> solveFrames(LineFile& lines, const VolumeGeometry& geometry,
                                                    const LineOptions& options, bool force,
                                                    const std::string& file, Json& records,
                                                    Context& context) {
  constexpr double kOften = 0.5;
  std::vector<std::vector<float>> volumes;
  bool told = false;
  for (LineFrame& frame : lines.frames) {
    context.progress.detail(fmt::format("frame {}", frame.number));
    VOLUTE_TRY(leaveOutBeside(frame, geometry, force, file, context));
    auto found = reconstructLines(frame.lines, geometry, options, context.progress);
    if (!found)
      return fail(found.error().code, "{}, frame {}: {}", file, frame.number,
                  found.error().message);
    if (found->crossed < kOften && !told) {
      told = true;
      context.progress.remark(fmt::format(
          "lines pass {:.0f} % of the voxels of frame {}: what is between is guessed from its "
          "neighbours",
          100 * found->crossed, frame.number));
    }
    records.push_back({{"frame", frame.number},
                       {"lines", frame.lines.size()},
                       {"lambda", jsonNumber(found->lambda)},
                       {"iterations", found->iterations},
                       {"residual", jsonNumber(found->residual)},
                       {"left_out", jsonNumber(found->leftOut)},
                       {"spread", lines.hasSigma ? jsonNumber(found->spread) : Json()},
                       {"crossed_share", jsonNumber(found->crossed)}});
    volumes.push_back(std::move(found->volume));
  }
  context.progress.detail("");
  return volumes;
}

double meanOf(const Json& records, const char* figure) {
  double sum = 0;
  for (const Json& one : records) sum += one[figure].is_number() ? one[figure].get<double>() : 0;
  return sum / static_cast<double>(records.size());
}

}  // namespace

bool isLineFile(const std::string& path) {
  return extensionOf(path) == ".csv";
}

Status runReconstructLines(const Arguments& arguments, Context& context) {
  const std::string& file = arguments.positional(0);
  const auto target = arguments.get<std::string>("output");
  VOLUTE_TRY(refuseCameraOptions(arguments));
  if (context.team.size() > 1)
    return fail(ErrorCode::kUnsupported, "{}: lines are for one process; leave mpirun out", file);
  VOLUTE_ASSIGN(const auto options, captureOptionsOf(arguments, context));
  VOLUTE_ASSIGN(auto lines, readLines(file));
  VOLUTE_TRY(choose(lines, options.frames));
  VOLUTE_ASSIGN(const auto geometry, geometryOf(lines, options, file, context));
  VOLUTE_TRY(checkSizes(lines, geometry, context.maxMemory));
  LineOptions how;
  if (arguments.given("basis") && arguments.get<std::string>("basis") == "trilinear")
    how.basis = Basis::kTrilinear;
  how.lambda = arguments.find<double>("lambda");
  how.iterations = arguments.find<int>("iterations");
  how.maxMemory = context.maxMemory / 2;
  auto records = Json::array();
  VOLUTE_ASSIGN(auto volumes,
                solveFrames(lines, geometry, how, arguments.flag("force"), file, records, context));
  LineVolumes source(infoOf(lines, geometry, how.basis), std::move(volumes));
  VOLUTE_TRY(source.info().validate(file));
  const VolumeInfo& info = source.info();
  Report report;
  report.add("output", target)
      .add("grid", info.name, info.unit.empty() ? info.name : info.name + " [" + info.unit + "]")
      .add("frames", info.frames, fmt::format("{}", info.frames))
      .add("size", {info.x, info.y, info.z},
           fmt::format("{} x {} x {} voxels", info.x, info.y, info.z));
  VOLUTE_ASSIGN(auto writer,
                ReconstructionWriter::open(source, nullptr,
                                           {target, arguments.get<double>("rms"),
                                            fmt::format("reconstructed from {}", file)},
                                           context));
  VOLUTE_TRY(writer.write(report, context));
  report.add("left_out", jsonNumber(meanOf(records, "left_out")),
             fmt::format("{:.3f} (relative L2 of lines that were left out in turn)",
                         meanOf(records, "left_out")));
  report.add("residual", jsonNumber(meanOf(records, "residual")),
             fmt::format("{:.3f} (of the lines that were fitted)", meanOf(records, "residual")));
  if (const auto page = arguments.find<std::string>("report")) {
    auto json = report.json();
    json["lines"] = records;
    VOLUTE_TRY(writeFile(*page, dumpJson(json) + "\n"));
  }
  context.print(report);
  return {};
}

}  // namespace volute::cli
