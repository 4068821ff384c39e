// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/tomography/line_volumes.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "volute/base/plain_number.hpp"
#include "volute/capture/clocks.hpp"
#include "volute/report/json.hpp"

namespace volute {
namespace {

/// As it was stated, else the box around the lines' ends.
Result<VolumeGeometry> geometryOf(const LineFile& lines, const CaptureOptions& where,
                                  const std::string& file, Progress& progress) {
  constexpr int kUsual = 32;
  VolumeGeometry geometry;
  if (where.bounds) {
    geometry.bounds = *where.bounds;
  } else {
    for (const LineFrame& frame : lines.frames) {
      for (const LineMeasurement& one : frame.lines) {
        geometry.bounds.extend(one.line.origin);
        geometry.bounds.extend(one.line.at(one.line.end));
      }
    }
    if (!geometry.bounds.size().allFinite() || geometry.bounds.empty())
      return fail(
          ErrorCode::kInvalidArgument, Hint::set("bounds"),
          "{}: does not say where the volume is, as its lines have no ends or are flat; state "
          "its outer faces in metres",
          file);
    const Vec3 &low = geometry.bounds.min, &high = geometry.bounds.max;
    progress.remark(
        Remark(RemarkCode::kAssumed,
               fmt::format("{}: the volume is the box around the lines' ends, {},{},{},{},{},{}",
                           file, plainNumber(low.x()), plainNumber(low.y()), plainNumber(low.z()),
                           plainNumber(high.x()), plainNumber(high.y()), plainNumber(high.z())),
               {Hint::set("bounds")})
            .in(file));
  }
  geometry.resolution = where.resolution.value_or(std::array{kUsual, 0, 0});
  if (geometry.resolution[1] == 0)
    geometry.resolution = cubicResolution(geometry.bounds, geometry.resolution[0]);
  return geometry;
}

void leaveOutBeside(LineFrame& frame, const VolumeGeometry& geometry, const std::string& file,
                    Progress& progress) {
  const auto beside = linesBeside(frame.lines, geometry);
  if (beside.empty())
    return;
  progress.remark(
      {RemarkCode::kLeftOut,
       fmt::format("warning: {}: {} of {} lines of frame {} miss the volume and are left out", file,
                   beside.size(), frame.lines.size(), frame.number)});
  for (auto at = beside.rbegin(); at != beside.rend(); ++at)
    frame.lines.erase(frame.lines.begin() + static_cast<std::ptrdiff_t>(*at));
}

VolumeInfo infoOf(const LineFile& lines) {
  VolumeInfo info;
  info.name = lines.opticalDepths ? "extinction" : "density";
  info.unit = lines.opticalDepths ? "1/m" : "";
  for (const LineFrame& frame : lines.frames) {
    info.frameNumbers.push_back(frame.number);
    info.times.push_back(lines.hasTimes ? frame.time
                                        : (frame.number - lines.frames[0].number) / kUnstatedRate);
  }
  info.frames = static_cast<int>(lines.frames.size());
  return info;
}

void remarkOnTimes(const LineFile& lines, const std::string& file, Progress& progress) {
  if (lines.hasTimes || lines.frames.size() < 2)
    return;
  progress.remark(Remark(RemarkCode::kAssumed,
                         fmt::format("{}: its frames have no times: {} frames a second are assumed",
                                     file, kUnstatedRate))
                      .in(file));
}

/// The frames that were asked for.
Status choose(LineFile& lines, const FrameRange& range) {
  VOLUTE_ASSIGN(const auto positions, selectPositions(infoOf(lines), range));
  std::vector<LineFrame> frames;
  for (const int position : positions)
    frames.push_back(std::move(lines.frames[static_cast<std::size_t>(position)]));
  lines.frames = std::move(frames);
  return {};
}

Status checkSizes(const LineFile& lines, const VolumeGeometry& geometry, std::uint64_t maxMemory) {
  VOLUTE_TRY(checkVolumeSize(geometry, maxMemory));
  const std::uint64_t bytes = 4 * geometry.voxels() * lines.frames.size();
  if (bytes <= maxMemory / 2)
    return {};
  return fail(ErrorCode::kTooLarge,
              {Hint::set("frames").so("takes them in parts"), Hint::raise("max_memory")},
              "{} frames of {} voxels need {} MiB, more than half of the {} MiB that are allowed",
              lines.frames.size(), geometry.voxels(), bytes >> 20, maxMemory >> 20);
}

}  // namespace

double LineVolumes::mean(const char* figure) const {
  double sum = 0;
  for (const auto& one : records) sum += one[figure].is_number() ? one[figure].get<double>() : 0;
  return sum / static_cast<double>(records.size());
}

Result<LineVolumes> reconstructLineFile(const std::string& file, const CaptureOptions& where,
                                        const LineOptions& how, bool leaveOut, Progress& progress) {
  VOLUTE_ASSIGN(auto lines, readLines(file, where.maxMemory));
  return reconstructLineFrames(std::move(lines), file, where, how, leaveOut, progress);
}

Result<LineVolumes> reconstructLineFrames(LineFile lines, const std::string& file,
                                          const CaptureOptions& where, const LineOptions& how,
                                          bool leaveOut, Progress& progress) {
  constexpr double kOften = 0.5, kUnexplained = 0.9;
  for (const std::string& remark : lines.remarks) progress.remark({RemarkCode::kAssumed, remark});
  VOLUTE_TRY(choose(lines, where.frames));
  remarkOnTimes(lines, file, progress);
  VOLUTE_ASSIGN(const auto geometry, geometryOf(lines, where, file, progress));
  VOLUTE_TRY(checkSizes(lines, geometry, where.maxMemory));
  LineVolumes result;
  VolumeInfo& info = result.volumes.info;
  info = infoOf(lines);
  info.x = geometry.resolution[0], info.y = geometry.resolution[1], info.z = geometry.resolution[2];
  info.bounds = geometry.bounds;
  info.basis = how.basis;
  VOLUTE_TRY(info.validate(file));
  LineOptions half = how;
  half.maxMemory = where.maxMemory / 2;
  bool told = false, unexplainedTold = false;
  for (LineFrame& frame : lines.frames) {
    progress.detail(fmt::format("frame {}", frame.number));
    if (leaveOut)
      leaveOutBeside(frame, geometry, file, progress);
    const auto found = reconstructLines(frame.lines, geometry, half, progress);
    if (!found)
      return fail(found.error().code, found.error().hints, "{}, frame {}: {}", file, frame.number,
                  found.error().message);
    if (found->crossed < kOften && !std::exchange(told, true)) {
      progress.remark(
          {RemarkCode::kDoubtful,
           fmt::format(
               "lines pass {:.0f} % of the voxels of frame {}: what is between is guessed from its "
               "neighbours",
               100 * found->crossed, frame.number)});
    }
    if (found->residual > kUnexplained && !std::exchange(unexplainedTold, true)) {
      progress.remark(Remark(
          RemarkCode::kDoubtful,
          fmt::format("warning: frame {}: the volume explains next to nothing of what was measured "
                      "(residual {:.3g} of 1); check the lines' places, the quantity and its sign, "
                      "unless there is noise alone",
                      frame.number, found->residual)));
    }
    result.records.push_back({{"frame", frame.number},
                              {"lines", frame.lines.size()},
                              {"lambda", jsonNumber(found->lambda)},
                              {"iterations", found->iterations},
                              {"residual", jsonNumber(found->residual)},
                              {"left_out", how.lambda ? Json() : jsonNumber(found->leftOut)},
                              {"spread", lines.hasSigma ? jsonNumber(found->spread) : Json()},
                              {"crossed_share", jsonNumber(found->crossed)}});
    result.volumes.values.insert(result.volumes.values.end(), found->volume.begin(),
                                 found->volume.end());
  }
  progress.detail("");
  return result;
}

}  // namespace volute
