// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <optional>

#include "volute/gl/gl_medium.hpp"
#include "volute/gl/gl_passes.hpp"
#include "volute/gl/gl_rays.hpp"
#include "volute/render/billboard.hpp"

namespace volute {

/// Billboard's twin: a rectangle that shows the picture of a volume, in order among other media.
class BillboardPass {
 public:
  /// @param view  billboardView(), and `drawn` the picture that it saw: light and optical depth
  [[nodiscard]] Result<std::unique_ptr<GlMedium>> make(const BillboardOptions& options,
                                                       const Camera& view, GLuint drawn,
                                                       GlPasses& passes);

 private:
  std::optional<GlProgram> program_;
};

}  // namespace volute
