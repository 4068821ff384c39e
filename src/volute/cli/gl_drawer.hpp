// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/cli/gl_pictures.hpp"
#include "volute/scene/still.hpp"

namespace volute::cli {

/// kUnsupported where VOLUTE_CPU_RENDERER=off forbids the processor to draw: tests set it to see
/// that all was drawn by OpenGL.
[[nodiscard]] Status processorMayDraw(const char* what);

/// OpenGL, for the pictures of a still of which `subject` says the same.
class GlDrawer final : public StillDrawer {
 public:
  GlDrawer(GlPictures& gl, const GlSubject& subject) : gl_(gl), subject_(subject) {}

  bool drawsMedia() const override { return false; }

  Result<SurfacePicture> surfaces(const StillView& view, Progress& progress) override;
  Result<SurfaceView> walls(const StillView& view, std::size_t smoke) override;
  Result<std::vector<SignPixel>> findSigns(const StillView& view) override;
  Result<Image> color(const StillView& view, const RenderOptions& options, Progress& progress,
                      RenderStats& stats) override;
  Result<Image> opticalDepth(const StillView& view, const RenderOptions& options,
                             Progress& progress, RenderStats& stats) override;
  Status addSigns(const StillView& view, std::span<const SignPixel> seen,
                  const RenderOptions& options, Progress& progress, Image& image) override;

 private:
  GlPictures& gl_;
  GlSubject subject_;
};

}  // namespace volute::cli
