// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/volume/compression_report.hpp"

#include <algorithm>
#include <cmath>

#include "volute/media/volume/volume_writer.hpp"

namespace volute {
namespace {

void addRatios(Report& report, std::uint64_t raw, std::uint64_t bytes,
               std::optional<std::uint64_t> inputBytes) {
  const auto ratio = [&](std::uint64_t of) {
    return static_cast<double>(of) / static_cast<double>(bytes);
  };
  report.add("ratio", jsonNumber(ratio(raw)), fmt::format("{:.4g} (of dense floats)", ratio(raw)));
  if (inputBytes) {
    report.add("input_bytes", *inputBytes, bytesText(*inputBytes))
        .add("ratio_to_input", jsonNumber(ratio(*inputBytes)),
             fmt::format("{:.4g} (of the files on disk)", ratio(*inputBytes)));
  }
}

}  // namespace

Report compressionReport(const std::string& target, const CompressedGrids& result, int frames,
                         std::optional<std::uint64_t> inputBytes) {
  Report report;
  report.add("output", target)
      .add("frames", frames, fmt::format("{}", frames))
      .add("raw_bytes", result.rawBytes(), bytesText(result.rawBytes()))
      .add("bytes", result.fileBytes, bytesText(result.fileBytes));
  addRatios(report, result.rawBytes(), result.fileBytes, inputBytes);
  auto list = nlohmann::ordered_json::array();
  std::string text;
  double worst = 0;
  for (const CompressedGrid& grid : result.grids) {
    const CompressReport& one = grid.report;
    const double psnr = -20 * std::log10(one.relativeRms);
    const bool empty = grid.info.x == 0;
    worst = std::max(worst, one.relativeRms);
    list.push_back({{"name", grid.name},
                    {"size", {grid.info.x, grid.info.y, grid.info.z}},
                    {"channels", grid.info.channels},
                    {"empty", empty},
                    {"raw_bytes", one.rawBytes},
                    {"bytes", one.fileBytes},
                    {"relative_rms", one.relativeRms},
                    {"psnr", jsonNumber(empty ? INFINITY : psnr)},
                    {"max_error", one.maxError},
                    {"minimum", one.valueMin},
                    {"maximum", one.valueMax}});
    text += fmt::format("\n  {:<16} ", grid.name);
    text += empty ? std::string("empty")
                  : fmt::format(
                        "{} x {} x {}{}, {:.4g} to {:.4g}: {}, relative rms {:.3g}, max error "
                        "{:.3g}",
                        grid.info.x, grid.info.y, grid.info.z,
                        grid.info.channels == 3 ? " x 3" : "", one.valueMin, one.valueMax,
                        bytesText(one.fileBytes), one.relativeRms, one.maxError);
  }
  const double speed =
      static_cast<double>(result.rawBytes()) / 1e6 / std::max(result.seconds, 1e-9);
  report.add("grids", list, text)
      .add("relative_rms", jsonNumber(worst), fmt::format("{:.6g} (of the worst grid)", worst))
      .add("seconds", jsonNumber(result.seconds), fmt::format("{:.2f} s", result.seconds))
      .add("megabytes_per_second", jsonNumber(speed), fmt::format("{:.3g} MB/s", speed));
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
  report.add("relative_rms", result.relativeRms)
      .add("psnr", jsonNumber(-20 * std::log10(result.relativeRms)),
           fmt::format("{:.2f} dB", -20 * std::log10(result.relativeRms)))
      .add("max_error", result.maxError)
      .add("seconds", jsonNumber(result.seconds), fmt::format("{:.2f} s", result.seconds))
      .add("megabytes_per_second", jsonNumber(speed), fmt::format("{:.3g} MB/s", speed));
  return report;
}

}  // namespace volute
