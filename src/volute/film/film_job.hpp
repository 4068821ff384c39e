// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "volute/base/frame_name.hpp"
#include "volute/base/stopwatch.hpp"
#include "volute/base/team.hpp"
#include "volute/camera/camera.hpp"
#include "volute/film/frame_choice.hpp"
#include "volute/film/picture_writer.hpp"
#include "volute/media/contour.hpp"
#include "volute/scene/scene.hpp"
#include "volute/scene/scene_renderer.hpp"

namespace volute {

/// What takes the place of a picture's mode where a contour is drawn.
std::string modeOf(const Contour& contour);

/// Milliseconds of each stage, which may overlap, and counts of work, over all pictures.
struct FilmTotals {
  double open = 0, snapshots = 0, render = 0;
  double convert = 0, write = 0;  ///< the latter with the former
  double wall = 0, cpu = 0;       ///< of all pictures, from the first to the last
  int pictures = 0;
  PictureCounts counts;
  nlohmann::ordered_json media = nlohmann::ordered_json::object();  ///< MediumSnapshot::counts()
  int shutterTimes = 0;     ///< of the picture that took the most
  double shutterError = 0;  ///< the largest of all pictures, in shares of its brightest value
};

/// A scene, who renders it, and the frames of its film: one for a single picture. Made by setting
/// its members; writeFilm() writes it, picture() gives one linear picture.
struct FilmJob {
  Scene scene;
  Camera camera;
  RenderOptions options;
  std::unique_ptr<SceneRenderer> renderer;
  bool mayFallBack = false;  ///< the CPU takes them, with a remark, where `renderer` cannot
  std::vector<FilmFrame> frames{};
  double framesPerSecond = kUsualRate;  ///< of a film
  FrameScale frameScale{};              ///< of the frames' numbers
  std::optional<Contour> contour{};     ///< drawn instead of the media
  bool tree = false;                    ///< SnapshotRequest::tree
  bool legend = false;                  ///< drawn into visible pictures
  bool together = false;  ///< ranks draw each picture together: they hold shares of a medium
  bool measured = true;   ///< light as it is: no tone curve, no smoothed edges
  int samples = 1;        ///< rays in a pixel where there are edges
  double shutter = 0;     ///< [s] of the scene from a frame's time on, over which light is averaged
  PictureStyle style{};   ///< by which edges are found
  std::optional<CameraDescription> cameraPath{};  ///< of a camera that moves
  double orbit = 0;                               ///< [radians], over all frames
  Vec3 orbitCentre = Vec3::Zero();
  std::vector<std::string>
      layers{};  ///< of an .exr with several: beauty, alpha, z, transmittance, optical-depth
  bool partial = false;   ///< a picture that is stopped is returned as far as it was drawn
  double drawnShare = 1;  ///< of the pixels of the last such picture
  FilmTotals totals{};
  std::string reason{};  ///< why this frame, where the request left it open

  /// All `layers` of a frame, by the names of their channels: R, G, B, A, Z, transmittance.Y,
  /// optical-depth.Y.
  [[nodiscard]] Result<std::vector<ImageChannel>> layersAt(const FilmFrame& frame,
                                                           Progress& progress);

  /// The linear picture of a frame, RGB or what options.aov names. With a shutter the mean over the
  /// middles of 3, 9, 27 or 81 equal parts of the time that it is open: as many as it takes until
  /// three times as many change no value by more than 1/256 of the brightest. Errors: what the
  /// media cannot read at that time, what the renderer cannot draw (kUnsupported, kTooLarge),
  /// kCancelled.
  [[nodiscard]] Result<Image> picture(const FilmFrame& frame, Progress& progress);

  /// The two stages of picture() without a shutter: the snapshot of a frame, and its picture. The
  /// second does not use the scene.
  [[nodiscard]] Result<SceneSnapshot> snapshotAt(const FilmFrame& frame, Progress& progress);
  [[nodiscard]] Result<Image> drawn(const SceneSnapshot& snapshot, const FilmFrame& frame,
                                    Progress& progress);

  /// Text about the picture of a frame; a legend only if requested.
  PictureText textOf(const FilmFrame& frame) const;

  /// What was done so far, and with what.
  nlohmann::ordered_json stats() const;

  /// From where a frame is seen.
  Camera cameraAt(const FilmFrame& frame) const;

 private:
  [[nodiscard]] Result<Image> pictureAt(const FilmFrame& frame, Progress& progress);
  [[nodiscard]] Result<Image> pictureOf(const SceneSnapshot& snapshot, const Camera& camera,
                                        Progress& progress, PictureCounts& counts);
  [[nodiscard]] Result<Image> draw(const SceneSnapshot& snapshot, const Camera& camera, int rays,
                                   Progress& progress, PictureCounts& counts);
  /// In tiles over a coarse picture; sets drawnShare.
  [[nodiscard]] Result<Image> drawUntilStopped(const SceneSnapshot& snapshot, const Camera& camera,
                                               Progress& progress, PictureCounts& counts);
};

/// "beauty,alpha,z" as FilmJob::layers; none where it is optical-depth or transmittance alone,
/// which is a picture, or nothing.
[[nodiscard]] Result<std::vector<std::string>> parseLayers(const std::string& list);

/// kUnsupported where ranks that hold shares of a mesh cannot draw the job's pictures together.
[[nodiscard]] Status checkTogether(const FilmJob& job);

/// Whether a picture shows shares of white light: 1 is white.
bool measuresLight(const Scene& scene);

/// kInvalidArgument where a scene has nothing for such a contour: no medium that has any, a plane
/// beyond all of them ("slice: ..."), concentrations without a scale in common ("slice-shows:
/// ...").
[[nodiscard]] Status checkContour(const Contour& contour, const Scene& scene);

/// The scale of a slice's extinction or concentration, from all frames of all ranks; nothing to do
/// for other contours. Collective.
[[nodiscard]] Status scaleContour(FilmJob& job, Progress& progress, Team& team);

/// kTooLarge where the linear picture, what is made of it, and its bytes for the file take more.
[[nodiscard]] Status checkPictureMemory(const Camera& camera, std::uint64_t maxMemory);

/// kUnsupported where VOLUTE_CPU_RENDERER=off forbids the CPU to draw: tests set it to see that all
/// was drawn by OpenGL.
[[nodiscard]] Status cpuMayDraw(const char* what);

}  // namespace volute
