// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "volute/cli/arguments.hpp"
#include "volute/cli/context.hpp"
#include "volute/cli/render_job.hpp"
#include "volute/scene/camera_file.hpp"

namespace volute::cli {

/// What a file on the command line shows: a scene, or a volume as a scene of its own.
struct RenderSubject {
  bool scene = false;
  std::vector<VolumeLayer> layers;
  std::vector<FogLayer> fogs;
  std::vector<SmokeLayer> smokes;
  std::vector<Sign> signs;
  SceneLights lights;
  TriangleScene geometry;
  std::vector<BillboardLayer> billboards;
  std::vector<FdsLayer> fdsCases;
  PictureLaw law;
  std::optional<CameraDescription> camera;
  Rgb background = Rgb::Zero();
};

/// By its name: a scene, smoke on a mesh, an FDS case or a volume, with the options of `volute
/// render`. Errors name the file or the option.
[[nodiscard]] Result<RenderSubject> openSubject(const std::string& path, const Arguments& arguments,
                                                Context& context);

}  // namespace volute::cli
