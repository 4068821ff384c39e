// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "volute/film/film_job.hpp"
#include "volute/scene/picture_camera.hpp"

namespace volute {

/// The content and the style of a picture or a film. Defaults are those of `volute render` for
/// every caller: the same request gives the same picture everywhere.
struct RenderRequest {
  FrameRequest frames{};
  std::optional<CameraDescription> camera{};  ///< else the scene's, else one that frames it
  ViewParts parts{};                          ///< of the scene's, or of one that frames it
  std::optional<Pixels> size{};               ///< else the camera's, else 800 x 600
  std::optional<Rgb> background{};            ///< else the scene's
  Aov aov = Aov::kNone;
  /// Light as it is: one ray through each pixel's centre, no tone curve, bloom or dithering.
  bool measured = false;
  double exposure = 0;  ///< a factor of light; 0: brightest parts near white
  /// Else filmic; for what shows measured transmittance none, or a shoulder where flames are in it.
  std::optional<ToneCurve> tone{};
  const ViewTransform* view = nullptr;  ///< instead of a tone curve
  double bloom = 0;                     ///< PictureStyle::glow
  /// Of the time from a frame to the next, in which the shutter is open: 0.5 is 180 degrees.
  double shutter = 0;
  int samples = 8;                   ///< rays in a pixel where there are edges
  std::optional<ColorMap> colors{};  ///< of what has one channel
  std::optional<bool> legend{};      ///< else that of media which want one
};

/// Sets tone or view: "auto", "none", "filmic", "agx", "shoulder", or a name of openColorView().
[[nodiscard]] Status takeTone(const std::string& name, RenderRequest& request);

/// How the scene of a file alone is opened.
struct RenderUse {
  bool measured = false;
  bool depth = false;   ///< for its optical depth
  bool tree = false;    ///< SnapshotRequest::tree
  bool moves = false;   ///< what is between its frames is shown, as through a shutter
  bool values = false;  ///< its values by a colour map
};

/// Sets options.files.measured and byTree, and adds what pictures of a file alone take for granted
/// and `options.members` leave open: an extinction for depths, interpolation.
void addUsualMembers(const std::string& path, const RenderUse& use, SceneOptions& options);

/// Sets frames, camera, options, rate, orbit, legend and samples of a job whose scene and renderer
/// are set. Errors begin with a member's name where they are about one ("frames: ...").
[[nodiscard]] Status prepare(FilmJob& job, const RenderRequest& request, std::uint64_t maxMemory,
                             Progress& progress);

/// How its pictures become visible. kInvalidArgument for colours of what has its own.
[[nodiscard]] Result<Development> developmentOf(const RenderRequest& request, const FilmJob& job);

/// The linear picture of a job's first frame, as a .exr has it.
[[nodiscard]] Result<Image> linearPicture(FilmJob& job, const Development& development,
                                          Progress& progress);

/// The picture of a job's first frame, as a .png has it: linear light that toSrgb8() turns into its
/// bytes.
/// @param development  in it the exposure that was found
[[nodiscard]] Result<Image> visiblePicture(FilmJob& job, Development& development,
                                           Progress& progress);

}  // namespace volute
