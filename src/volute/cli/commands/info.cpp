// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <nlohmann/json.hpp>

#include "volute/capture/capture_report.hpp"
#include "volute/capture/open_capture.hpp"
#include "volute/cli/commands/commands.hpp"
#include "volute/cli/file_kind.hpp"
#include "volute/cli/gl_pictures.hpp"
#include "volute/cli/shared_options.hpp"
#include "volute/scene/describe_file.hpp"

namespace volute::cli {
namespace {

/// The graphics device, before the files if there are any.
Status showGl(const Arguments& arguments, Context& context) {
  VOLUTE_ASSIGN(const auto report, describeGl());
  if (context.json && arguments.positionals().empty())
    context.printJson(report.json());
  else if (context.json)
    return fail(ErrorCode::kInvalidArgument, "--gl with --json takes no FILE");
  else
    context.print(report.text());
  return {};
}

Status runInfo(const Arguments& arguments, Context& context) {
  if (arguments.positionals().empty() && !arguments.flag("gl"))
    return fail(ErrorCode::kInvalidArgument, "FILE is missing; give a file, or --gl");
  if (arguments.flag("gl")) {
    VOLUTE_TRY(showGl(arguments, context));
    if (arguments.positionals().empty())
      return {};
  }
  std::vector<FileKind> kinds;
  for (const auto& path : arguments.positionals()) kinds.push_back(readKind(path));
  VOLUTE_TRY(refuseIdle(arguments, kinds));
  const DescribeRequest request{arguments.find<std::string>("field").value_or(""),
                                arguments.flag("values"), arguments.flag("blocks"),
                                arguments.find<double>("fps")};
  bool damaged = false;
  nlohmann::ordered_json files = nlohmann::ordered_json::array();
  const auto& paths = arguments.positionals();
  for (const auto& path : paths) {
    VOLUTE_ASSIGN(const bool capture, isCapture(path));
    VOLUTE_ASSIGN(const auto found, capture ? describeCapture(path, context.maxMemory)
                                            : describeFile(path, request, context));
    damaged = damaged || found.damaged;
    files.push_back(found.report.json());
    if (!context.json)
      context.print(fmt::format("{}{}", files.size() > 1 ? "\n" : "", found.report.text()));
  }
  if (context.json)
    context.printJson(paths.size() == 1 ? files[0] : nlohmann::ordered_json{{"files", files}});
  if (damaged)
    return fail(ErrorCode::kInvalidData, "parts are damaged or cannot be used; the rest was shown");
  return {};
}

}  // namespace

Command infoCommand() {
  using enum ValueKind;
  return {
      .name = "info",
      .summary = "Describes a file and checks that it is intact",
      .examples = {"volute info fire.volute", "volute info smoke.npy --values --json",
                   "volute info case.smv", "volute info hall.pvd", "volute info --gl"},
      .description =
          "For a volume: size, frames, times, bounds and all grids; for a .volute also the "
          "requested and the reached error, and whether every byte is intact. A damaged .volute "
          "is described as far as it is intact, and the exit code is 1. For a picture (.png, "
          ".exr): size and range. For an FDS case (.smv): meshes, obstructions, files, the source "
          "of smoke with its times, and truncated files. For smoke on a mesh (.vtu, .pvtu, .vtk, "
          ".pvd, .case, .e, .foam): times, cells, the tetrahedra they are split into, and fields "
          "with their ranges. For a scene: its media. For a capture: its cameras and missing "
          "pictures.",
      .positionals =
          {{.name = "FILE",
            .help = "a volume, a picture, smoke on a mesh, an FDS case, a scene or a capture",
            .several = true,
            .optional = true}},
      .options = {fieldOption("grid or field of a file with several; source of an FDS case",
                              {"volume", kVoluteKind, "fds"}),
                  filesRateOption({"volume", kVoluteKind}),
                  {.name = "blocks",
                   .help = "for a .volute: each block's offset, transform and size",
                   .kinds = {kVoluteKind}},
                  {.name = "values",
                   .help = "read all frames and count zeros and non-finite values, with minimum "
                           "and maximum",
                   .kinds = {"volume", "smoke", "fds"}},
                  {.name = "gl",
                   .help = "show the graphics device that --renderer gl uses, and its limits"}},
      .run = runInfo};
}

}  // namespace volute::cli
