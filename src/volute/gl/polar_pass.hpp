// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "volute/fog/fog_shader.hpp"
#include "volute/fog/polar_table.hpp"
#include "volute/gl/gl_passes.hpp"
#include "volute/gl/gl_program.hpp"
#include "volute/gl/gl_rays.hpp"

namespace volute {

/// PolarFog's twin: pictures of fog alone by two look-ups a pixel. The table is filled on the
/// device, anew for each eye and each map.
class PolarPass {
 public:
  /// Light and optical depth into an RGBA32F texture of the camera's size. kUnsupported, before
  /// anything is drawn, where no table serves: PolarTable::make.
  [[nodiscard]] Status draw(const FogMedium& fog, double factor, const PolarOptions& options,
                            const Camera& camera, const GlRays& rays, GLuint picture,
                            GlPasses& passes);

 private:
  struct Programs {
    GlProgram table, picture;
  };

  Result<const Programs*> programsFor(const FogShader& shader);
  void bindFog(const GlProgram& program, const FogShader& shader, const PolarLayout& layout,
               const Vec3& eye) const;

  std::map<std::string, Programs> programs_;
  GlTexture map_, table_;
  int columns_ = 0, rows_ = 0;    ///< of the table
  std::string filled_;            ///< what the table was filled for
  std::vector<float> mapTexels_;  ///< what map_ holds
};

}  // namespace volute
