// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "volute/base/stopwatch.hpp"
#include "volute/camera/camera.hpp"
#include "volute/cli/picture_writer.hpp"
#include "volute/cli/render_moments.hpp"
#include "volute/media/contour.hpp"
#include "volute/scene/scene.hpp"
#include "volute/scene/scene_renderer.hpp"

namespace volute::cli {

/// What takes the place of a picture's mode where a contour is drawn.
std::string modeOf(const Contour& contour);

/// The most memory that this program has held [bytes].
std::uint64_t peakMemoryBytes();

/// Milliseconds of each stage, and what was looked at, over all pictures.
struct RenderTotals {
  double open = 0, snapshots = 0, render = 0, write = 0;
  int pictures = 0;
  PictureCounts counts;
  nlohmann::ordered_json media = nlohmann::ordered_json::object();  ///< MediumAt::counts()
};

/// A scene, who renders it, and the moments to be seen.
struct RenderJob {
  Scene scene;
  Camera camera;
  RenderOptions options;
  std::unique_ptr<SceneRenderer> renderer;
  bool mayFallBack = false;  ///< the CPU takes them, with a remark, where `renderer` cannot
  std::vector<Moment> moments{};
  double framesPerSecond = kUsualRate;  ///< of a film
  std::optional<Contour> contour{};     ///< drawn instead of the media
  bool tree = false;                    ///< InstantRequest::tree
  bool legend = false;                  ///< drawn into visible pictures
  bool measured = true;                 ///< light as it is
  int samples = 1;                      ///< rays in a pixel where there are edges
  PictureStyle style{};                 ///< by which edges are found
  std::optional<CameraDescription> way{};  ///< of a camera that moves
  double orbit = 0;                     ///< [radians], over all moments
  Vec3 orbitCentre = Vec3::Zero();
  std::vector<std::string> layers{};  ///< of --aov, where a .exr takes several; else empty
  RenderTotals totals{};

  /// All `layers` of a moment, by the names of their channels: R, G, B, A, Z, transmittance.Y,
  /// optical-depth.Y.
  [[nodiscard]] Result<std::vector<ImageChannel>> layersAt(const Moment& moment,
                                                           Progress& progress);

  /// The linear picture of a moment.
  [[nodiscard]] Result<Image> picture(const Moment& moment, Progress& progress);

  /// What the picture of a moment says about itself; the legend only where it is asked for.
  PictureText textOf(const Moment& moment) const;

  /// What --stats writes.
  nlohmann::ordered_json stats() const;

 private:
  Camera cameraAt(const Moment& moment) const;
  [[nodiscard]] Result<Image> pictureOf(const Snapshot& snapshot, const Camera& camera,
                                        Progress& progress, PictureCounts& counts);
};

/// Whether a picture shows shares of white light: 1 is white.
bool measuresLight(const Scene& scene);

/// kUnsupported where VOLUTE_CPU_RENDERER=off forbids the CPU to draw: tests set it to see that all
/// was drawn by OpenGL.
[[nodiscard]] Status cpuMayDraw(const char* what);

}  // namespace volute::cli
