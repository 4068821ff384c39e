// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>

#include "volute/cli/commands/commands.hpp"
#include "volute/cli/file_kind.hpp"
#include "volute/cli/sibling_program.hpp"
#include "volute/cli/scene_arguments.hpp"

namespace volute::cli {
namespace {

/// The viewer is a program of its own: no other command needs a window.
Status runView(const Arguments& /*arguments*/, Context& context) {
  return becomeSibling("volute-view", "./dev build builds it from Volute's sources", context);
}

std::vector<Option> viewOptions() {
  using enum ValueKind;
  std::vector<Option> options = {
      {.name = "screenshot",
       .kind = kOutput,
       .value = "OUT.png",
       .help = "write the viewer's frame instead of opening a window"},
      {.name = "time",
       .kind = kNumber,
       .value = "T",
       .help = "begin at T [s], whatever the scene's view says"},
      {.name = "size",
       .kind = kPixels,
       .value = "WxH",
       .help = "of the window or the screenshot [pixels]",
       .initial = "1280x800"},
      {.name = "renderer",
       .kind = kChoice,
       .value = "NAME",
       .help = "who draws, whatever the scene's view says: auto is OpenGL on a graphics card, else "
               "the CPU",
       .choices = {"auto", "gl", "cpu"}},
      {.name = "smoke-method",
       .kind = kChoice,
       .value = "NAME",
       .help = "how OpenGL draws smoke on a mesh that is the only medium, as for render",
       .initial = "auto",
       .choices = {"auto", "march", "splat", "projected"}},
      {.name = "no-panels", .help = "a screenshot of the picture alone"}};
  for (const auto& more : {mediumOptions(), lightCacheOptions()})
    options.insert(options.end(), more.begin(), more.end());
  for (Option& option : options) std::erase(option.kinds, kSceneKind);  // a scene says it itself
  const auto quantity = std::ranges::find(options, "quantity", &Option::name);
  quantity->help += "; else soot-density";
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
          "Ctrl O opens a file. "
          "Files are read in the background and read again when they change on disk; another one "
          "can be dropped on the window. Panels change what the medium has: "
          "exposure, smoke potential, Km and C, mu and levels, lights, signs. Signs and lights are "
          "added to the wall that one looks at, put elsewhere by a click, removed; Ctrl Z takes it "
          "back. Fog is painted with a brush, on the ground or on a plan, and not lost unasked. "
          "What was changed is saved as a scene or as a map; films are made beside. OpenGL 4.5 "
          "draws on a graphics card, else the CPU, as it does what a card refuses. A .png is "
          "taken for a map of fog, a mesh's field for soot in kg/m3.\n\n"
          "--screenshot draws the same frame without a display, once all is loaded.",
      .positionals =
          {{.name = "FILE",
            .help = "a volume (.volute, .npy, .vdb, .vti, .pvd), smoke on a mesh (.vtu, "
                    ".vtk, .pvd, .case, .e, .foam), an FDS case (.smv), a map of fog (.png, "
                    ".exr), a capture or a scene (.json); without one, drop it on the window",
            .optional = true}},
      .options = viewOptions(),
      .run = runView};
}

}  // namespace volute::cli
