// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>

#include "volute/cli/commands/commands.hpp"
#include "volute/cli/file_kind.hpp"
#include "volute/cli/scene_arguments.hpp"
#include "volute/cli/shared_options.hpp"
#include "volute/cli/sibling_program.hpp"

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
       .help = "write the viewer's frame to a file instead of opening a window"},
      {.name = "time",
       .kind = kNumber,
       .value = "T",
       .help = "start at T [s], overriding the scene's view"},
      {.name = "compare",
       .kind = kFile,
       .value = "FILE",
       .help = "show another file on the right of a border, from the same place at the same time"},
      {.name = "size",
       .kind = kPixels,
       .value = "WxH",
       .help = "size of the window or the screenshot [pixels]",
       .initial = "1280x800"},
      {.name = "interface-scale",
       .kind = kNumber,
       .value = "S",
       .help = "size of letters and controls, times that of the display",
       .initial = "1",
       .least = 0.5,
       .most = 4},
      {.name = "renderer",
       .kind = kChoice,
       .value = "NAME",
       .help = "renderer, overriding the scene's view; auto: OpenGL on a graphics card, else the "
               "CPU",
       .choices = {"auto", "gl", "cpu"}},
      rateOption("frames per second of a sequence; if not given, the times that the files state, "
                 "else 25"),
      smokeMethodOption(", as for render"),
      {.name = "no-panels", .help = "take the screenshot of the picture only, without panels"}};
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
                   "volute view fire.volute valley.png hall.smv",
                   "volute view fire.vdb --compare fire.volute",
                   "volute view fire.volute --screenshot fire.png"},
      .description =
          "The left mouse button turns, the right one pans, F1 shows all keys. Ctrl O opens a "
          "file; a file that is dropped on the window is added to what is shown. Files are read in "
          "the background, and "
          "again when they change on disk. Panels change the parameters of media: exposure, smoke "
          "potential, Km and C, mu and levels, lights, signs. Signs and lights are added to the "
          "wall in view, moved by a click, and removed; Ctrl Z undoes changes. Fog is painted "
          "with a brush, on the ground or on a plan, and never lost without a question. Changes "
          "are saved as a scene or as a map; films are rendered in the background. OpenGL 4.5 "
          "draws on a graphics card, else the CPU, which also draws what a card cannot. A .png is "
          "taken as a map of fog, a mesh's field as soot in kg/m3.\n\n--screenshot draws the same "
          "frame without a display, once everything is loaded.",
      .positionals =
          {{.name = "FILE",
            .help = "a volume (.volute, .npy, .npz, .vdb, .vti, .pvd, .nc, .h5, .zarr), smoke on a "
                    "mesh (.vtu, "
                    ".vtk, .pvd, .case, .e, .foam), an FDS case (.smv), a map of fog (.png, "
                    ".exr), a capture or a scene (.json); several are shown in one scene; without "
                    "one, drop "
                    "it on the window",
            .several = true,
            .optional = true}},
      .options = viewOptions(),
      .run = runView};
}

}  // namespace volute::cli
