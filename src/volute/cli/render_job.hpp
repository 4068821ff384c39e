// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "volute/base/stopwatch.hpp"
#include "volute/camera/camera.hpp"
#include "volute/cli/gl_pictures.hpp"
#include "volute/cli/picture_writer.hpp"
#include "volute/render/render.hpp"
#include "volute/scene/fds_layer.hpp"
#include "volute/scene/fog_layer.hpp"
#include "volute/scene/scene_geometry.hpp"
#include "volute/scene/scene_signs.hpp"
#include "volute/scene/smoke_contour.hpp"
#include "volute/scene/still.hpp"
#include "volute/scene/volume_layer.hpp"

namespace volute::cli {

/// A picture to take.
struct Moment {
  int number = 0;                ///< of the frame, for names
  std::vector<int> positions{};  ///< of the frame of each layer
  double time = 0;               ///< [s], of the scene
};

/// What takes the place of a picture's mode where a contour is drawn.
std::string modeOf(const SmokeContour& contour);

/// Milliseconds of each stage, and what was looked at, over all pictures.
struct RenderTotals {
  double open = 0, slices = 0, render = 0, write = 0;
  std::uint64_t rays = 0, segments = 0, pieces = 0;
  std::uint64_t voxels = 0, bricksVisited = 0, bricksSkipped = 0, bricksStored = 0;
  int pictures = 0;
  double surfaces = 0;
  std::uint64_t surfacePixels = 0, shadowRays = 0;
};

/// Volumes, fog, smoke, surfaces, signs, a camera and the moments to be seen.
struct RenderJob {
  std::vector<VolumeLayer> layers;
  std::vector<FogLayer> fogs;
  Camera camera;
  RenderOptions options;
  std::vector<Moment> moments;
  double framesPerSecond = 25;  ///< of a film
  RenderTotals totals;
  std::shared_ptr<GlPictures> gl{};  ///< takes the pictures when it is not null
  bool glIsWish = false;             ///< the processor takes them, with a remark, where `gl` cannot
  GlSmokeMethod smokeMethod = GlSmokeMethod::kAuto;
  GlVolumeMethod volumeMethod = GlVolumeMethod::kBricks;
  std::vector<SmokeLayer> smokes{};
  std::vector<Sign> signs{};
  PictureLaw law{};
  ProcessorDrawer drawer{};
  SceneLights lights{};
  TriangleScene geometry{};
  std::vector<BillboardLayer> billboards{};
  std::vector<FdsLayer> fdsCases{};
  std::optional<TriangleScene> fixedGeometry{};  ///< the scene's own, once there are buildings
  std::vector<std::uint64_t> buildings{};        ///< FdsLayer::surfacesAt() of those in `geometry`
  std::optional<SmokeContour> contour{};         ///< drawn instead of the smoke
  bool legend = false;                           ///< drawn into visible pictures
  bool measuresLight = false;                    ///< shares of white light: 1 is white

  /// The linear picture of a moment.
  [[nodiscard]] Result<Image> picture(const Moment& moment, Progress& progress);

  /// The same by the renderer that is chosen, or its error.
  [[nodiscard]] Result<Image> pictureBy(const Moment& moment, Progress& progress);

  /// What the picture of a moment says about itself; the legend only where it is asked for.
  PictureText textOf(const Moment& moment) const;

  /// What --stats writes.
  nlohmann::ordered_json stats() const;

  /// All that pictures of a moment need; `volumes` are those of `layers` in it.
  [[nodiscard]] Result<Still> stillAt(const Moment& moment, std::vector<VoxelMedium>& volumes);

  [[nodiscard]] Result<Image> pictureOf(const Still& still, const Moment& moment,
                                        Progress& progress, StillCounts& counts);

  /// `geometry` becomes the scene's and all that is opaque in the FDS cases at a time.
  [[nodiscard]] Status placeBuildings(double time);

  /// A billboard, to be drawn for each camera.
  [[nodiscard]] Result<MediumForCamera> mediumOf(BillboardLayer& board, double time) const;
};

}  // namespace volute::cli
