// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

namespace volute {

/// How a smoke is drawn that is alone in its picture. One among other media is marched with them,
/// and so is any under a camera with a lens.
enum class GlSmokeMethod {
  kAuto,   ///< kProject where the CPU rasterises, which is several times as fast there; else kMarch
  kMarch,  ///< from face to face, in a compute shader
  kProject,  ///< TetProjector, for drivers whose compute shaders are slow
};

}  // namespace volute
