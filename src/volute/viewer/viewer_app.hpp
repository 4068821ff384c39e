// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>

#include "volute/gl/gl_device.hpp"
#include "volute/viewer/film_export.hpp"
#include "volute/viewer/loader.hpp"
#include "volute/viewer/paint_tool.hpp"
#include "volute/viewer/timeline.hpp"
#include "volute/viewer/view_camera.hpp"
#include "volute/viewer/view_picture.hpp"
#include "volute/viewer/viewer_input.hpp"

namespace volute {

/// What the panels show and change, and what is written into the boxes.
struct ViewerSettings {
  ViewLook look{};
  bool panels = true;
  bool help = false;
  bool painting = false;    ///< the left button paints fog
  std::string sceneName{};  ///< where the scene would be saved
  std::string mapName{};    ///< and the map of fog
  std::string filmName = "film.mp4";
  int filmSize = 1;  ///< 640 x 360, 1280 x 720, 1920 x 1080, the window's
};

/// What parts of the last frame took [ms].
struct FrameCosts {
  double loaded = 0;   ///< to take over what the loader has
  double panels = 0;   ///< input and panels
  double picture = 0;  ///< OpenGL's picture, or asking the processor for one
  double shown = 0;    ///< picture and panels into the window
};

/// Where a control was drawn in the last frame [pixels]. Scripts find the controls by their names.
struct ControlPlace {
  float left = 0, top = 0, right = 0, bottom = 0;
};

/// The viewer without its window: given what a person did, draws a frame into the framebuffer that
/// is bound. Needs a current context of OpenGL 4.5; one at a time in a program (Dear ImGui's).
class ViewerApp {
 public:
  [[nodiscard]] static Result<std::unique_ptr<ViewerApp>> create(OpenDocument open);
  ~ViewerApp();

  void open(const std::string& path, double time = 0);

  /// One frame. Errors of documents are shown, not returned; what is returned ends the viewer.
  [[nodiscard]] Status frame(const ViewerInput& input);

  /// Whether all that was asked of documents is done.
  bool idle() const { return loader_.idle() && !loading_.busy && pending_.empty(); }

  /// Whether all is loaded and the picture is drawn as finely as it will be.
  bool settled() const;

  /// How soon another frame is worth its while if nobody does anything [s].
  double patience() const;

  /// True once after a person asked for a screenshot.
  bool takeScreenshotWish() { return std::exchange(screenshotWish_, false); }

  void wishScreenshot() { screenshotWish_ = true; }

  void say(std::string message) { message_ = std::move(message); }

  ViewerSettings& settings() { return settings_; }

  Timeline& timeline() { return timeline_; }

  const Timeline& timeline() const { return timeline_; }

  ViewCamera& camera() { return camera_; }

  PaintTool& paint() { return paint_; }

  const DocumentInfo* document() const { return document_ ? &*document_ : nullptr; }

  const std::string& error() const { return error_; }

  const FrameCosts& costs() const { return costs_; }

  const FrameTimes& times() const { return picture_.times(); }

  const ViewPicture& picture() const { return picture_; }

  const GlDevice& device() const { return device_; }

  const LoaderState& loading() const { return loading_; }

  const std::string& message() const { return message_; }

  const std::map<std::string, ControlPlace>& controls() const { return controls_; }

  /// The item that ImGui drew last is the control of this name.
  void mark(const std::string& name);

  void markPlace(const std::string& name, const ControlPlace& place) { controls_[name] = place; }

  void resetView(int width, int height);  ///< the document's own, else wholeView()
  void wholeView(int width, int height);
  void lookFrom(const StartView& view);

  /// Changes a parameter of the document, as soon as the loader comes to it.
  void setParameter(const Parameter& parameter, const std::vector<double>& value);

  void saveScene();
  void saveMap();
  void undoPainting();
  void redoPainting();

  /// Hands what was painted to the document.
  void sendMap();

  void beginFilm(const ViewerInput& input);

  void cancelFilm() { film_.reset(); }

  const FilmExport* film() const { return film_.get(); }

  /// The map of fog from above, in colours, as a texture: row 0 at the largest y.
  GLuint planTexture();

 private:
  ViewerApp(OpenDocument open, GlDevice device, ViewPicture picture);

  void feed(const ViewerInput& input);
  void takeLoaded(const ViewerInput& input);
  void takeDocument(DocumentInfo opened, const ViewerInput& input);
  void beginWith(double time);
  void control(const ViewerInput& input);
  void walk(const ViewerInput& input);
  void keys(const ViewerInput& input);
  void press(Key key, const ViewerInput& input);
  void paintInView(const ViewerInput& input);
  void goOnWithFilm();
  void usePanels(const ViewerInput& input);
  Status drawPicture(const ViewerInput& input);
  void show(const ViewerInput& input);
  PictureWish wish(const ViewerInput& input) const;
  DisplayLook displayLook() const;
  StartView startView() const;

  GlDevice device_;
  ViewPicture picture_;
  Loader loader_;
  LoaderState loading_;
  Timeline timeline_;
  ViewCamera camera_;
  ViewerSettings settings_;
  PaintTool paint_;
  GlTexture plan_;
  int planWidth_ = 0, planHeight_ = 0;
  bool planStale_ = true;
  std::unique_ptr<FilmExport> film_;
  std::optional<DocumentInfo> document_;
  std::optional<LoadedScene> scene_;
  std::map<std::string, std::vector<double>> pending_;  ///< parameters on their way
  std::map<std::string, ControlPlace> controls_;
  FrameCosts costs_;
  std::string error_, message_, lastMessage_;
  double requested_ = 0;           ///< the time that the loader was asked for
  std::optional<double> opening_;  ///< at which time another file is being opened
  double exposure_ = 1;            ///< that fits the first picture
  bool exposureFound_ = false;
  bool viewSet_ = false;
  bool moving_ = false;  ///< a person is turning it, or it plays
  ViewerInput seen_;     ///< the last
  double lastX_ = 0, lastY_ = 0;
  bool dragging_ = false, strokes_ = false;
  bool screenshotWish_ = false;
};

}  // namespace volute
