// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "volute/base/progress.hpp"
#include "volute/fog/polar_table.hpp"
#include "volute/gl/gl_medium.hpp"
#include "volute/gl/gl_programs.hpp"
#include "volute/gl/gl_rays.hpp"
#include "volute/gl/scene_shader.hpp"

namespace volute {

/// Pictures of fog alone that no sun lights, with nothing of what a march through any media carries
/// along: walked as fog_walk.glsl has it, or by two look-ups a pixel as PolarFog has it.
class FogPasses {
 public:
  /// Light and optical depth into an RGBA32F texture of the camera's size. kUnsupported, before
  /// anything is drawn, where fog has to be marched: with a top, with levels by angle, from an eye
  /// far away or none. kCancelled between parts.
  /// @param polar  a table, filled on the device, anew for each eye and each map, where one serves
  ///               (PolarTable::make); else the fog is walked
  /// @param map    gives the fog's map
  /// @param rowsAtOnce  of the picture, between which the caller may stop
  [[nodiscard]] Status draw(const FogMedium& fog, double factor,
                            const std::optional<PolarOptions>& polar, GlQuantity quantity,
                            const std::function<Result<std::shared_ptr<const GlFogMap>>()>& map,
                            const Camera& camera, const GlRays& rays, GLuint picture,
                            int rowsAtOnce, GlPrograms& programs, GlPasses& passes,
                            Progress& progress);

  /// Drops map and table unless they have been drawn with since the last call.
  void sweep();

 private:
  [[nodiscard]] Result<PolarLayout> tableFor(const FogMedium& fog, const FogShader& shader,
                                             const Vec3& eye, const PolarOptions& options,
                                             GlPrograms& programs, GlPasses& passes,
                                             Progress& progress);
  Status fillTable(const FogShader& shader, const PolarLayout& layout, const Vec3& eye,
                   GlPrograms& programs, GlPasses& passes, Progress& progress);
  void bindTable(const GlProgram& program, const PolarLayout& layout) const;

  std::shared_ptr<const GlFogMap> map_;
  GlTexture table_;
  int columns_ = 0, rows_ = 0;  ///< of the table
  std::string filled_;          ///< what the table was filled for, besides the map
  bool used_ = false;
};

}  // namespace volute
