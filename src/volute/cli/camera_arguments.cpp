// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/camera_arguments.hpp"

namespace volute::cli {

Result<std::optional<CameraDescription>> cameraOf(const Arguments& arguments) {
  const auto eye = arguments.find<Vec3>("eye");
  const auto target = arguments.find<Vec3>("target");
  const auto fov = arguments.find<double>("fov");
  const auto ortho = arguments.find<double>("ortho");
  const bool byHand = eye || target || arguments.given("up") || fov || ortho;
  if (const auto file = arguments.find<std::string>("camera")) {
    if (byHand)
      return fail(
          ErrorCode::kInvalidArgument,
          "--camera names a whole view; leave out --eye, --target, --up, --fov and --ortho");
    VOLUTE_ASSIGN(auto camera, readCamera(*file));
    return camera;
  }
  if (!byHand)
    return std::nullopt;
  if (!eye || !target || fov.has_value() == ortho.has_value()) {
    return fail(ErrorCode::kInvalidArgument,
                "a view needs --eye, --target, and one of --fov and --ortho");
  }
  VOLUTE_ASSIGN(const auto members, membersOf(cameraFields(), arguments));
  VOLUTE_ASSIGN(auto camera, parseCamera(members, {}));
  return camera;
}

}  // namespace volute::cli
