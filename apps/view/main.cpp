// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// What `volute view` runs; the command's options are declared in volute/cli/commands/view.cpp.
#include <nlohmann/json.hpp>

#include "volute/base/output_file.hpp"
#include "volute/capture/open_capture.hpp"
#include "volute/cli/commands/commands.hpp"
#include "volute/cli/program.hpp"
#include "volute/cli/scene_arguments.hpp"
#include "volute/cli/volume_output.hpp"
#include "volute/film/film_job.hpp"
#include "volute/gl/gl_device.hpp"
#include "volute/io/image_file.hpp"
#include "volute/lighting/light_cache.hpp"
#include "volute/viewer/headless_viewer.hpp"
#include "volute/viewer/open_document.hpp"
#include "volute/viewer/window.hpp"
#include "volute/volume_files/volume_input.hpp"

namespace volute::cli {
namespace {

/// Who draws; nothing: whoever the scene's own look says.
std::optional<ViewRenderer> rendererOf(const Arguments& arguments) {
  const auto name = arguments.find<std::string>("renderer");
  if (!name)
    return std::nullopt;
  return *name == "gl"    ? ViewRenderer::kGl
         : *name == "cpu" ? ViewRenderer::kCpu
                          : ViewRenderer::kAuto;
}

Status run(const Arguments& arguments, Context& context) {
  const std::string path = arguments.positionals().empty() ? "" : arguments.positional(0);
  const Pixels size = arguments.get<Pixels>("size");
  const auto renderer = rendererOf(arguments);
  const ViewerStart start{path,
                          arguments.find<double>("time"),
                          size.width,
                          size.height,
                          {.renderer = renderer,
                           .cpu = cpuMayDraw("a picture").has_value(),
                           .scale = arguments.get<double>("interface-scale")},
                          arguments.find<std::string>("compare").value_or("")};
  if (path.empty() && !start.other.empty())
    return fail(ErrorCode::kInvalidArgument, "--compare: expected a FILE to compare it with");
  const bool gl = renderer == ViewRenderer::kGl ||
                  (renderer != ViewRenderer::kCpu && graphicsHardwarePresent());
  VOLUTE_ASSIGN(const auto method, smokeMethodOf(arguments, gl));
  nlohmann::ordered_json members = nlohmann::ordered_json::object();
  if (!path.empty()) {
    VOLUTE_ASSIGN(members, mediumMembers(path, arguments));
  }
  VOLUTE_ASSIGN(auto cache, lightCache(arguments, context));
  std::vector<std::string> more;
  for (std::size_t i = 1; i < arguments.positionals().size(); ++i)
    more.push_back(arguments.positional(i));
  if (!more.empty()) {
    VOLUTE_ASSIGN(const bool capture, isCapture(path));
    if (capture)
      return fail(ErrorCode::kInvalidArgument, "{}: a capture is shown alone, without {}", path,
                  more.front());
  }
  const auto open = documentOpener({context.maxMemory, path, std::move(members), std::move(cache),
                                    method, start.time, std::move(more)});
  const auto target = arguments.find<std::string>("screenshot");
  if (!target)
    return runViewerWindow(open, start, context.progress);
  if (path.empty())
    return fail(ErrorCode::kInvalidArgument, "--screenshot: expected a FILE to be shown on it");
  if (extensionOf(*target) != ".png")
    return fail(ErrorCode::kInvalidArgument, "--screenshot: '{}' is no .png", *target);
  VOLUTE_TRY(checkTarget(*target));
  VOLUTE_ASSIGN(const Image image,
                viewerScreenshot(open, start, !arguments.flag("no-panels"), context.progress));
  VOLUTE_TRY(writeImage(*target, image));
  if (context.json) {
    context.printJson({{"output", *target}, {"width", image.width}, {"height", image.height}});
  }
  return {};
}

}  // namespace
}  // namespace volute::cli

int main(int argc, char** argv) {
  volute::cli::Command command = volute::cli::viewCommand();
  command.run = volute::cli::run;
  return volute::cli::runProgram(command, argc, argv);
}
