// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/cli/gl_pictures.hpp"

// In the place of gl_pictures.cpp in builds without OpenGL.

namespace volute::cli {
namespace {

tl::unexpected<Error> noOpenGl() {
  return fail(
      ErrorCode::kUnsupported,
      "this build has no OpenGL; configure with -DVOLUTE_WITH_GL=ON, or use --renderer cpu");
}

}  // namespace

Result<std::unique_ptr<SceneRenderer>> openGlRenderer(bool, GlSmokeMethod) {
  return noOpenGl();
}

Result<Report> describeGl() {
  return noOpenGl();
}

bool glIsLikely() {
  return false;
}

}  // namespace volute::cli
