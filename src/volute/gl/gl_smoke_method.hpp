// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

namespace volute {

/// How a smoke is drawn that is alone in its picture. One among other media is marched with them,
/// and so is any under a camera with a lens.
enum class GlSmokeMethod {
  kAuto,     ///< black smoke and optical depths by the splat, light by the march
  kMarch,    ///< from face to face, in a compute shader
  kSplat,    ///< DepthSplat: transmittance alone; light is marched
  kProject,  ///< TetProjector, for drivers whose compute shaders are slow
};

}  // namespace volute
