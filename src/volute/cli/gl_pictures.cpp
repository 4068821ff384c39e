// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/gl_pictures.hpp"

#include "volute/gl/gl_device.hpp"
#include "volute/gl/gl_scene_renderer.hpp"

namespace volute::cli {

Result<std::unique_ptr<SceneRenderer>> openGlRenderer(bool hardwareOnly, GlSmokeMethod method) {
  return createGlRenderer(hardwareOnly, method);
}

Result<Report> describeGl() {
  VOLUTE_ASSIGN(const auto gl, HeadlessGl::create());
  const GlDevice& device = gl.device();
  Report report;
  report.add("device", device.renderer)
      .add("vendor", device.vendor)
      .add("opengl", device.version)
      .add("shading_language", device.shadingLanguage)
      .add("hardware", device.hardware,
           device.hardware ? "yes" : "no: the CPU draws, and --renderer auto means cpu");
  for (const auto& [name, value] : device.limits())
    report.add(name, value, fmt::format("{}", value));
  return report;
}

bool glIsLikely() {
  return graphicsHardwarePresent();
}

}  // namespace volute::cli
