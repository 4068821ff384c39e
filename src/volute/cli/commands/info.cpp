// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/capture_report.hpp"
#include "volute/capture/open_capture.hpp"
#include "volute/cli/commands/commands.hpp"
#include "volute/cli/field_options.hpp"
#include "volute/cli/file_kind.hpp"
#include "volute/cli/gl_pictures.hpp"
#include "volute/scene/describe_file.hpp"

namespace volute::cli {
namespace {

/// The graphics device, before the files if there are any.
Status showGl(const Arguments& arguments, Context& context) {
  VOLUTE_ASSIGN(const auto report, describeGl());
  if (context.json && arguments.positionals().empty())
    context.print(dumpJson(report.json()));
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
                                arguments.flag("values"), arguments.flag("blocks")};
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
    context.print(
        dumpJson(paths.size() == 1 ? files[0] : nlohmann::ordered_json{{"files", files}}));
  if (damaged)
    return fail(ErrorCode::kInvalidData,
                "not everything is intact or can be used; what is was shown");
  return {};
}

}  // namespace

Command infoCommand() {
  using enum ValueKind;
  return {
      .name = "info",
      .summary = "Says what is in a file and whether it is whole",
      .examples = {"volute info fire.volute", "volute info smoke.npy --values --json",
                   "volute info case.smv", "volute info hall.pvd", "volute info --gl"},
      .description =
          "Sizes, frames, times and bounds of a volume, and all grids of a file with several; of a "
          ".volute also what error was asked "
          "for and reached, and whether every "
          "byte is intact. Pictures (.png, .exr) show their size and range. A damaged .volute "
          "is described as far as it is intact, "
          "and the exit code is 1. An FDS case (.smv) shows its meshes, obstructions and files, "
          "which of them says how thick the smoke is, at which times, and what is cut off. Smoke "
          "on "
          "a mesh (.vtu, .pvtu, .vtk, .pvd, .case, .e, .foam) shows its times, cells, the "
          "tetrahedra that they are split into, and its fields with their ranges. A scene lists its "
          "media, a capture its cameras and which of their pictures are missing.",
      .positionals = {{.name = "FILE",
                       .help = "a volume, a picture, smoke on a mesh, an FDS case, a scene or a capture",
                       .several = true,
                       .optional = true}},
      .options = {fieldOption("which one of a file with several; which source of an FDS case",
                              {"volume", kVoluteKind, "fds"}),
                  {.name = "blocks",
                   .help = "of a .volute, each block's place, transform and size",
                   .kinds = {kVoluteKind}},
                  {.name = "values",
                   .help = "read all frames for their minimum, maximum, zeros and values that "
                           "are not finite",
                   .kinds = {"volume", "smoke", "fds"}},
                  {.name = "gl",
                   .help = "the graphics device that --renderer gl draws with, and its limits"}},
      .run = runInfo};
}

}  // namespace volute::cli
