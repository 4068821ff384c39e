// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "volute/base/progress.hpp"
#include "volute/fog/polar_table.hpp"
#include "volute/gl/gl_medium.hpp"
#include "volute/gl/gl_programs.hpp"
#include "volute/gl/gl_rays.hpp"

namespace volute {

/// PolarFog's twin: pictures of fog alone by two look-ups a pixel. The table is filled on the
/// device, anew for each eye and each map.
class PolarPass {
 public:
  /// Light and optical depth into an RGBA32F texture of the camera's size. kUnsupported, before
  /// anything is drawn, where no table serves: PolarTable::make. kCancelled between parts.
  /// @param map  gives the fog's map
  [[nodiscard]] Status draw(const FogMedium& fog, double factor, const PolarOptions& options,
                            const std::function<Result<std::shared_ptr<const GlFogMap>>()>& map,
                            const Camera& camera, const GlRays& rays, GLuint picture,
                            GlPrograms& programs, GlPasses& passes, Progress& progress);

 private:
  Status fillTable(const FogShader& shader, const PolarLayout& layout, const Vec3& eye,
                   GlPrograms& programs, GlPasses& passes, Progress& progress);
  void bind(const GlProgram& program, const FogShader& shader, const PolarLayout& layout,
            const Vec3& eye) const;

  std::shared_ptr<const GlFogMap> map_;
  GlTexture table_;
  int columns_ = 0, rows_ = 0;  ///< of the table
  std::string filled_;          ///< what the table was filled for, besides the map
};

}  // namespace volute
