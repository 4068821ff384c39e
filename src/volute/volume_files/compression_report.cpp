// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/volume_files/compression_report.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "volute/report/json_text.hpp"
#include "volute/volume_files/volume_writer.hpp"

namespace volute {
namespace {

void addRatios(Report& report, std::uint64_t raw, std::uint64_t bytes,
               std::optional<std::uint64_t> inputBytes) {
  const auto ratio = [&](std::uint64_t of) {
    return static_cast<double>(of) / static_cast<double>(bytes);
  };
  report.add("ratio", jsonNumber(ratio(raw)),
             raw > 0 ? fmt::format("{:.4g} (of dense floats)", ratio(raw)) : std::string());
  if (inputBytes) {
    report.add("input_bytes", *inputBytes, bytesText(*inputBytes))
        .add("ratio_to_input", jsonNumber(ratio(*inputBytes)),
             fmt::format("{:.4g} (of the files on disk)", ratio(*inputBytes)));
  }
}

/// "0 to 1.9".
std::string supportRangeText(const CompressReport& one) {
  std::string text = fmt::format("{:.4g} to {:.4g}", one.support.low, one.support.high);
  if (one.support.robust) {
    text += fmt::format(": without values apart, which rule the extremes, {:.4g} and {:.4g}",
                        one.valueMin, one.valueMax);
  }
  return text;
}

/// The number of a frame; none of an empty grid.
nlohmann::ordered_json frameJson(const VolumeInfo& info, int position) {
  const auto at = static_cast<std::size_t>(position);
  if (at >= info.frameNumbers.size())
    return nullptr;
  return jsonFrame(info.frameNumbers[at], info.frameScale);
}

nlohmann::ordered_json faintFramesJson(std::span<const FaintFrame> faint, const VolumeInfo& info) {
  auto list = nlohmann::ordered_json::array();
  for (const FaintFrame& frame : faint) {
    list.push_back({{"frame", frameJson(info, frame.position)},
                    {"range", frame.range},
                    {"relative_rms", jsonNumber(frame.relativeRms)}});
  }
  return list;
}

/// The first of them by name.
std::string faintFramesText(std::span<const FaintFrame> faint, const VolumeInfo& info) {
  constexpr std::size_t kNamed = 4;
  std::string text;
  for (std::size_t i = 0; i < std::min(kNamed, faint.size()); ++i) {
    const FaintFrame& frame = faint[i];
    text += fmt::format("{}frame {} spans {:.3g}: relative to that {:.3g}", i > 0 ? "; " : "",
                        info.frameText(static_cast<std::size_t>(frame.position)), frame.range,
                        frame.relativeRms);
  }
  if (faint.size() > kNamed)
    text += fmt::format("; and {} more", faint.size() - kNamed);
  return text;
}

/// Where the greatest error is.
std::string worstPlaceText(const CompressReport& one, const VolumeInfo& info) {
  if (info.frameNumbers.empty())
    return "nowhere";
  return fmt::format("frame {}, voxel ({}, {}, {})",
                     info.frameText(static_cast<std::size_t>(one.support.worstFrame)),
                     one.support.worstVoxel[0], one.support.worstVoxel[1],
                     one.support.worstVoxel[2]);
}

nlohmann::ordered_json worstPlaceJson(const CompressReport& one, const VolumeInfo& info) {
  return {{"frame", frameJson(info, one.support.worstFrame)}, {"voxel", one.support.worstVoxel}};
}

}  // namespace

void addFaintFrames(Report& report, std::span<const JoinReport::Faint> faint,
                    const VolumeInfo& info) {
  auto list = nlohmann::ordered_json::array();
  std::string text;
  for (const JoinReport::Faint& grid : faint) {
    list.push_back({{"grid", grid.grid}, {"frames", faintFramesJson(grid.frames, info)}});
    text += fmt::format("{}'{}': {}", text.empty() ? "" : "; ", grid.grid,
                        faintFramesText(grid.frames, info));
  }
  report.add("faint_frames", list, text);
}

void addKept(Report& report, std::span<const KeptResult> kept) {
  auto list = nlohmann::ordered_json::array();
  std::string text;
  for (const KeptResult& grid : kept) {
    list.push_back({{"name", grid.name}, {"type", grid.type}, {"bytes", grid.bytes}});
    text +=
        fmt::format("\n  {:<16} {}, without loss, {}", grid.name, grid.type, bytesText(grid.bytes));
  }
  report.add("kept", list, text);
}

Report compressionReport(const std::string& target, const CompressedGrids& result, int frames,
                         std::optional<std::uint64_t> inputBytes) {
  Report report;
  report.add("output", target)
      .add("frames", frames, fmt::format("{}", frames))
      .add("raw_bytes", result.rawBytes(),
           result.rawBytes() > 0 ? bytesText(result.rawBytes()) : std::string())
      .add("bytes", result.fileBytes, bytesText(result.fileBytes));
  addRatios(report, result.rawBytes(), result.fileBytes, inputBytes);
  auto list = nlohmann::ordered_json::array();
  std::string text;
  double worst = 0, worstOverSupport = 0;
  for (const CompressedGrid& grid : result.grids) {
    const CompressReport& one = grid.report;
    const double psnr = -20 * std::log10(one.relativeRms);
    const bool empty = grid.info.x == 0;
    worst = std::max(worst, one.relativeRms);
    worstOverSupport = std::max(worstOverSupport, one.support.rms);
    list.push_back({{"name", grid.name},
                    {"size", {grid.info.x, grid.info.y, grid.info.z}},
                    {"channels", grid.info.channels},
                    {"empty", empty},
                    {"raw_bytes", one.rawBytes},
                    {"bytes", one.fileBytes},
                    {"block_frames", one.blockFrames},
                    {"support_rms", one.support.rms},
                    {"support_share", one.support.share},
                    {"support_range", {one.support.low, one.support.high}},
                    {"robust_range", one.support.robust},
                    {"relative_rms", one.relativeRms},
                    {"psnr", jsonNumber(empty ? INFINITY : psnr)},
                    {"max_error", one.maxError},
                    {"max_error_at", worstPlaceJson(one, grid.info)},
                    {"faint_frames", faintFramesJson(one.faintFrames, grid.info)},
                    {"minimum", one.valueMin},
                    {"maximum", one.valueMax},
                    {"replaced_values", grid.replaced}});
    text += fmt::format("\n  {:<16} ", grid.name);
    text +=
        empty ? std::string("empty")
              : fmt::format(
                    "{} x {} x {}{}, {:.3g} % in use, {}: {}, relative rms {:.3g} over what is "
                    "in use, {:.3g} over all; max error {:.3g} ({})",
                    grid.info.x, grid.info.y, grid.info.z, grid.info.channels == 3 ? " x 3" : "",
                    100 * one.support.share, supportRangeText(one), bytesText(one.fileBytes),
                    one.support.rms, one.relativeRms, one.maxError, worstPlaceText(one, grid.info));
    if (!one.faintFrames.empty())
      text += fmt::format("\n    faint: {}", faintFramesText(one.faintFrames, grid.info));
  }
  const double speed =
      static_cast<double>(result.rawBytes()) / 1e6 / std::max(result.seconds, 1e-9);
  report.add("grids", list, text);
  if (!result.kept.empty())
    addKept(report, result.kept);
  // Of numbers that were coded; people read none where there are none.
  const auto of = [&](std::string one) { return result.rawBytes() > 0 ? one : std::string(); };
  report
      .add("support_rms", jsonNumber(worstOverSupport),
           of(fmt::format("{:.6g} (over what is in use, of the worst grid)", worstOverSupport)))
      .add("relative_rms", jsonNumber(worst), of(fmt::format("{:.6g} (of the worst grid)", worst)))
      .add("seconds", jsonNumber(result.seconds), fmt::format("{:.2f} s", result.seconds))
      .add("megabytes_per_second", jsonNumber(speed), of(fmt::format("{:.3g} MB/s", speed)));
  return report;
}

Report compressionReport(const std::string& target, const VolumeInfo& info,
                         const CompressReport& result, std::optional<std::uint64_t> inputBytes) {
  const double speed = static_cast<double>(result.rawBytes) / 1e6 / std::max(result.seconds, 1e-9);
  Report report;
  report.add("output", target);
  addSize(report, info);
  report.add("channels", info.channels, fmt::format("{}", info.channels))
      .add("raw_bytes", result.rawBytes, bytesText(result.rawBytes))
      .add("bytes", result.fileBytes, bytesText(result.fileBytes));
  addRatios(report, result.rawBytes, result.fileBytes, inputBytes);
  const SupportError& support = result.support;
  report
      .add("support_rms", support.rms,
           fmt::format("{:.6g} (over what is in use, relative to its range)", support.rms))
      .add("support_share", support.share,
           fmt::format("{:.4g} % of all voxels", 100 * support.share))
      .add("support_range", {support.low, support.high}, supportRangeText(result))
      .add("robust_range", support.robust, "")
      .add("faint_frames", faintFramesJson(result.faintFrames, info),
           faintFramesText(result.faintFrames, info))
      .add("relative_rms", result.relativeRms,
           fmt::format("{:.6g} (over all voxels)", result.relativeRms))
      .add("psnr", jsonNumber(-20 * std::log10(result.relativeRms)),
           fmt::format("{:.2f} dB", -20 * std::log10(result.relativeRms)))
      .add("max_error", result.maxError,
           fmt::format("{:.6g}, in {}", result.maxError, worstPlaceText(result, info)))
      .add("max_error_at", worstPlaceJson(result, info), "")
      .add("block_frames", result.blockFrames,
           fmt::format("{} decoded together", result.blockFrames))
      .add("seconds", jsonNumber(result.seconds), fmt::format("{:.2f} s", result.seconds))
      .add("megabytes_per_second", jsonNumber(speed), fmt::format("{:.3g} MB/s", speed));
  return report;
}

}  // namespace volute
