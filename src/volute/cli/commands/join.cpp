// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/codec/join.hpp"

#include "volute/cli/commands/commands.hpp"
#include "volute/cli/shared_options.hpp"
#include "volute/cli/volume_output.hpp"
#include "volute/io/frame_pattern.hpp"
#include "volute/volume_files/compression_report.hpp"
#include "volute/volume_files/volume_input.hpp"

namespace volute::cli {
namespace {

Status runJoin(const Arguments& arguments, Context& context) {
  const auto target = arguments.get<std::string>("output");
  std::vector<std::filesystem::path> parts;
  for (const std::string& path : arguments.positionals()) {
    if (!isVolutePath(path))
      return fail(ErrorCode::kInvalidArgument, "'{}' does not end in .volute", path);
    parts.emplace_back(path);
  }
  if (!isVolutePath(target)) {
    return fail(ErrorCode::kInvalidArgument, "--output: '{}' does not end in .volute", target);
  }
  VOLUTE_TRY(checkTarget(target));
  const JoinOptions options{arguments.find<double>("rms"), context.maxMemory,
                            arguments.find<double>("fps")};
  VOLUTE_ASSIGN(const auto result, join(parts, target, options, context.progress));
  const VolumeInfo& frames = result.info;
  if (const auto gaps = missingNumbers(frames.frameNumbers, frames.frameScale); !gaps.empty()) {
    context.progress.remark(
        Remark(RemarkCode::kDoubtful, fmt::format("{}: {}; a part may be missing", target, gaps))
            .in(target));
  }
  Report report;
  report.add("output", target)
      .add("parts", parts.size(), fmt::format("{}", parts.size()))
      .add("frames", frames.frames, fmt::format("{}", frames.frames))
      .add("exact", result.copied,
           result.copied ? "yes: blocks were copied as they are" : "no: decoded and encoded again")
      .add("relative_rms_to_parts", result.partsRms);
  addFaintFrames(report, result.faint, frames);
  report.add("relative_rms", result.relativeRms)
      .add("max_error", result.maxError)
      .add("bytes", result.fileBytes, bytesText(result.fileBytes));
  context.print(report);
  return {};
}

}  // namespace

Command joinCommand() {
  return {
      .name = "join",
      .summary = "Joins .volute files in the order of their frames",
      .examples = {"volute join part1.volute part2.volute -o fire.volute"},
      .description =
          "For sequences reconstructed or compressed in parts, on several machines. The parts may "
          "be given in any order; they must have the same voxels, bounds, channels, basis and up "
          "axis, and frame numbers that do not overlap; a gap between them is told. All grids of "
          "caches are joined, by name: their "
          "extents may differ, and a part may lack a grid; the joined grid has the smallest "
          "extent that contains all parts, with the cache's background elsewhere.\n\nIf all parts "
          "but the last have a multiple of 16 frames and the same extent, and blocks of all parts "
          "as "
          "many frames (compress --access), blocks are "
          "copied and no value changes; parts compressed separately keep their quantisation. The "
          "result states the RMS over all parts, relative to their common range, and the largest "
          "of their maximum errors. Other parts are decoded and encoded again, which adds to "
          "their error: the result says how much, with the frames that span less than a tenth of "
          "the common range, and the file states the sum as a bound for the error to the "
          "originals.",
      .positionals = {{.name = "PART", .help = ".volute files", .several = true}},
      .options = {outputOption("OUT.volute", "the file to write"),
                  rmsOption(
                      "RMS error to the parts if they must be encoded again, relative to their "
                      "common range; if not given, as large as their own"),
                  rateOption(
                      "frames per second of the whole: frame n is at (n - first) / F; if not "
                      "given, the times of the parts")},
      .run = runJoin};
}

}  // namespace volute::cli
