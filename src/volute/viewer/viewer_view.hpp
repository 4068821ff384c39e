// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <optional>
#include <string>

#include "volute/image/view_transform.hpp"
#include "volute/viewer/camera_path.hpp"
#include "volute/viewer/playback.hpp"
#include "volute/viewer/viewer_settings.hpp"

namespace volute {

/// How the document is looked at: from where, how bright, in which colours; and the picture of it.
class ViewerView {
 public:
  ViewerView(ViewerSettings& settings, ViewerDocument& document, const Playback& playback,
             ViewPicture picture)
      : settings_(settings),
        document_(document),
        playback_(playback),
        cameraPath_(document),
        picture_(std::move(picture)) {}

  ViewCamera& camera() { return camera_; }

  const ViewCamera& camera() const { return camera_; }

  CameraPath& cameraPath() { return cameraPath_; }

  ViewPicture& picture() { return picture_; }

  const ViewPicture& picture() const { return picture_; }

  /// Another document was opened: nothing of the one before stays.
  void forget();

  /// As the document wants to be seen, once: true then.
  bool begin(int width, int height);

  void reset(int width, int height);  ///< the document's own, else whole()
  void whole(int width, int height);

  /// From this side, at what the camera turns around.
  void lookFrom(const Vec3& side);

  /// What panels cover of a window of this width.
  ViewCamera::Insets insets(int width) const;

  /// The look, as scene files keep it.
  ViewLook look() const;

  DisplayLook display() const;

  /// Why the tone that is chosen is not shown; empty: it is.
  std::string toneError() const;

  /// The background as a display shows it, 0..1.
  Rgb backgroundShown() const;

  /// Makes or takes the picture, and finds an exposure in it.
  void draw(const PictureRequest& request);

  /// Whether the picture, at rest, has nothing that a display would show.
  bool blank() const { return blank_ && looked_ == picture_.state().version; }

 private:
  /// The exposure that fits the first picture of a document.
  struct FirstExposure {
    double value = 1;
    bool found = false;
    bool tried = false;  ///< from a picture that was not fine
  };

  /// The view transform of SceneLook::tone.
  const Result<const ViewTransform*>& colorView(int tone) const;
  void lookForSomething(const DocumentInfo& document);

  ViewerSettings& settings_;
  ViewerDocument& document_;
  const Playback& playback_;
  ViewCamera camera_;
  CameraPath cameraPath_;
  ViewPicture picture_;
  FirstExposure exposure_;
  mutable std::array<std::optional<Result<const ViewTransform*>>, 2> colorViews_;
  bool begun_ = false;
  bool blank_ = false;  ///< the picture of this version
  int looked_ = 0;
};

}  // namespace volute
