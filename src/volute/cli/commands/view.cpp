// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/base/output_file.hpp"
#include "volute/cli/commands/commands.hpp"
#include "volute/cli/smoke_arguments.hpp"
#include "volute/cli/volume_output.hpp"
#include "volute/io/image_file.hpp"
#include "volute/scene/volume_input.hpp"
#include "volute/viewer/headless_viewer.hpp"
#include "volute/viewer/open_document.hpp"
#include "volute/viewer/window.hpp"

namespace volute::cli {
namespace {

Status run(const Arguments& arguments, Context& context) {
  const std::string path = arguments.positionals().empty() ? "" : arguments.positional(0);
  const double time = arguments.find<double>("time").value_or(0);
  const Pixels size = arguments.get<Pixels>("size");
  nlohmann::ordered_json smoke = nlohmann::ordered_json::object();
  for (const char* name : {"field", "quantity", "unit"}) {
    if (const auto value = arguments.find<std::string>(name))
      smoke[name] = *value;
  }
  VOLUTE_ASSIGN(auto cache, lightCache(arguments, context));
  const auto open = documentOpener({context.maxMemory, std::move(smoke), std::move(cache)});
  const auto target = arguments.find<std::string>("screenshot");
  if (!target)
    return runViewerWindow(open, path, time, size.width, size.height, context.progress);
  if (path.empty())
    return fail(ErrorCode::kInvalidArgument, "--screenshot: expected a FILE to be shown on it");
  if (extensionOf(*target) != ".png")
    return fail(ErrorCode::kInvalidArgument, "--screenshot: '{}' is no .png", *target);
  VOLUTE_TRY(checkTarget(*target));
  VOLUTE_ASSIGN(const Image image,
                viewerScreenshot(open, path, time, size.width, size.height,
                                 !arguments.flag("no-panels"), context.progress));
  return writeImage(*target, image);
}

std::vector<Option> viewOptions() {
  using enum ValueKind;
  std::vector<Option> options = {
      {.name = "screenshot",
       .kind = kFile,
       .value = "OUT.png",
       .help = "write the viewer's frame instead of opening a window"},
      {.name = "time", .kind = kNumber, .value = "T", .help = "begin at T [s]"},
      {.name = "size",
       .kind = kPixels,
       .value = "WxH",
       .help = "of the window or the screenshot [pixels]",
       .initial = "1280x800"},
      {.name = "field",
       .kind = kText,
       .value = "NAME",
       .help = "of a mesh, or an FDS case's source"},
      {.name = "quantity",
       .kind = kText,
       .value = "NAME",
       .help = "what a mesh's field holds, as in a scene [default soot-density]"},
      {.name = "unit",
       .kind = kText,
       .value = "UNIT",
       .help = "of a mesh's density: kg/m3, g/m3, mg/m3"},
      {.name = "no-panels", .help = "a screenshot of the picture alone"}};
  const auto cache = lightCacheOptions();
  options.insert(options.end(), cache.begin(), cache.end());
  return options;
}

}  // namespace

Command viewCommand() {
  using enum ValueKind;
  return {
      .name = "view",
      .summary = "Shows volumes, smoke, fog, captures and scenes in a window",
      .examples = {"volute view fire.volute", "volute view scene.json --time 0.8",
                   "volute view fire.volute --screenshot fire.png"},
      .description =
          "Turn with the left mouse button, move across with the right one, F1 shows the rest. "
          "Files are read in the background, coarse levels first, and read again when they change "
          "on disk; another one can be dropped on the window. Panels change what the medium has: "
          "exposure, smoke potential, Km and C, mu and levels, lights, signs. Fog is painted with "
          "a "
          "brush, on the ground or on a plan. What was changed is saved as a scene or as a map; "
          "films are made beside. Draws with OpenGL 4.5, and what that cannot draw by the "
          "processor. A .png is taken for a map of fog, a mesh's field for soot in kg/m3.\n\n"
          "--screenshot draws the same frame without a display, once all is loaded.",
      .positionals =
          {{.name = "FILE",
            .help = "a volume (.volute, .npy, .vdb, .vti, .pvd), smoke on a mesh (.vtu, "
                    ".vtk, .pvd, .case, .e, .foam), an FDS case (.smv), a map of fog (.png, "
                    ".exr), a capture or a scene (.json); without one, drop it on the window",
            .optional = true}},
      .options = viewOptions(),
      .run = run};
}

}  // namespace volute::cli
