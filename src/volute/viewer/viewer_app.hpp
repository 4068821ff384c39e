// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "volute/gl/gl_device.hpp"
#include "volute/viewer/clipboard.hpp"
#include "volute/viewer/document_files.hpp"
#include "volute/viewer/film_export.hpp"
#include "volute/viewer/fog_plan.hpp"
#include "volute/viewer/loader.hpp"
#include "volute/viewer/medium_probe.hpp"
#include "volute/viewer/paint_tool.hpp"
#include "volute/viewer/panel_layout.hpp"
#include "volute/viewer/pick_wall.hpp"
#include "volute/viewer/timeline.hpp"
#include "volute/viewer/view_camera.hpp"
#include "volute/viewer/view_picture.hpp"
#include "volute/viewer/viewer_input.hpp"
#include "volute/viewer/work_notes.hpp"

namespace volute {

/// What a panel says about a file and about what is being done.
struct PanelNotice {
  enum class Kind { kText, kFaint, kError, kProgress };

  Kind kind = Kind::kText;
  std::string text{};
  bool missed = true;  ///< is seen wherever no panel says it
  double share = 0;    ///< of kProgress, 0..1

  bool operator==(const PanelNotice&) const = default;
};

/// What the panels show and change, and what is written into the boxes.
struct ViewerSettings {
  ViewLook look{};
  bool panels = true;
  bool help = false;
  PanelLayout layout{};
  std::vector<PanelNotice> notices{};  ///< as they are shown
  bool timeOpen = false;               ///< a small window's panel of time shows speed and film too
  bool painting = false;               ///< the left button paints fog
  bool probe = false;                  ///< what is under the pointer is said
  float timeHeight = 0;                ///< of the panel of time, as it was drawn [pixels]
  std::string sceneName{};             ///< where the scene would be saved
  std::string mapName{};               ///< and the map of fog
  std::string filmName = "film.mp4";
  int filmSize = 1;  ///< 640 x 360, 1280 x 720, 1920 x 1080, the window's
};

/// What parts of the last frame took [ms].
struct FrameCosts {
  double loaded = 0;   ///< to take over what the loader has
  double panels = 0;   ///< input and panels
  double picture = 0;  ///< OpenGL's picture, or asking the CPU for one
  double shown = 0;    ///< picture and panels into the window
};

/// What is settled before any file is open.
struct ViewerOptions {
  std::optional<ViewRenderer> renderer{};  ///< whatever scenes say
  /// Else what only the CPU could draw is an error: tests see so that OpenGL draws all.
  bool cpu = true;
  bool desktop = false;            ///< the desktop's dialogs are used, where it has some
  double scale = 1;                ///< of letters and controls, times the display's
  std::filesystem::path recent{};  ///< names of files that were opened; empty: nothing is kept
};

/// How a viewer begins.
struct ViewerStart {
  std::string path{};              ///< empty: no file is open
  std::optional<double> time{};    ///< [s]; nothing: where the file's own look says
  int width = 1280, height = 800;  ///< [pixels]
  ViewerOptions options{};
};

/// What the mouse did in the last frame.
struct PointerState {
  double x = 0, y = 0;    ///< [pixels]
  bool drags = false;     ///< it moves the camera
  bool strokes = false;   ///< it paints fog
  bool leftHeld = false;  ///< the left button is down
  bool placed = false;    ///< and put something somewhere
};

/// The exposure that fits the first picture of a document.
struct FirstExposure {
  double value = 1;
  bool found = false;
  bool tried = false;  ///< from a picture that was not fine
};

/// Where a control was drawn in the last frame [points]. Scripts find the controls by their names.
struct ControlPlace {
  float left = 0, top = 0, right = 0, bottom = 0;
  bool cut = false;  ///< a part is beside the panel's border
};

/// The viewer without its window: given what a person did, draws a frame into the framebuffer that
/// is bound. Needs a current context of OpenGL 4.5; one at a time in a program (Dear ImGui's).
class ViewerApp {
 public:
  [[nodiscard]] static Result<std::unique_ptr<ViewerApp>> create(OpenDocument open,
                                                                 const ViewerOptions& options = {});
  ~ViewerApp();

  /// @param time  [s] to begin at; nothing: where the document's look says, else at 0
  /// What is unsaved of the document before is lost.
  void open(const std::string& path, std::optional<double> time = std::nullopt);

  /// Opens a file, or ends the viewer (an empty name); first asks a person what to do with fog that
  /// was painted and is in no file.
  void leaveFor(const std::string& path);

  /// Whether a person wants the viewer to end, and nothing has still to be saved.
  bool ends() const { return ends_; }

  /// Where to a person wants to leave, while there are changes to be asked about.
  struct Leaving {
    enum class What { kMap, kScene };

    std::string path;  ///< empty: ends
    What what = What::kMap;
    bool saving = false;  ///< it is being written
  };

  const Leaving* leaving() const { return leaving_ ? &*leaving_ : nullptr; }

  /// The answers.
  void leaveAndSave();
  void leaveAndDiscard();

  void stay() { leaving_.reset(); }

  /// Whether fog was painted that no file has.
  bool unsavedMap() const { return paint_.has() && paint_.painter().changed(); }

  /// Whether the scene was changed and no file has it.
  bool unsavedScene() const { return document_ && document_->changed; }

  /// Of the window: the file's name, and a mark where something is in no file.
  std::string title() const;

  /// How files are named, and which may be written.
  DocumentFiles& files() { return files_; }

  /// By the desktop's dialog where there is one, else by the list.
  void askToOpen();

  /// Opens what was chosen in the list, and closes that.
  void chooseFile(const std::filesystem::path& path);

  /// What is being done that takes a while.
  const ViewerWork& work() const { return notes_.work(); }

  void stopDrawing() { picture_.stopRefining(); }

  /// What the picture that is shown lacks: "half size while it plays"; empty: nothing.
  std::string pictureNote() const;

  /// What was done last, for some seconds; empty: nothing.
  const std::string& toast() const { return notes_.toast(); }

  /// The background as a display shows it, 0..1.
  Rgb backgroundShown() const;

  /// What panels cover of a window of this size.
  ViewCamera::Insets insets(int width, int height) const;

  /// From this side, at what the camera turns around.
  void lookFromAxis(const Vec3& side);

  /// What the media are under the pointer; nothing where its ray meets none, and no surface.
  std::optional<MediumProbe::Reading> probeAt(double x, double y);

  /// Of text, between programs.
  Clipboard& clipboard() { return clipboard_; }

  /// True once after a person asked for the whole screen, or for the window again.
  bool takeFullScreenRequest() { return std::exchange(fullScreenRequested_, false); }

  /// One frame. Errors of documents are shown, not returned; what is returned ends the viewer.
  [[nodiscard]] Status frame(const ViewerInput& input);

  /// Whether the last frame drew anything; else what was shown before it stays.
  bool drew() const { return drew_; }

  /// Draws what the last frame showed once more, into the framebuffer that is bound.
  void showAgain(bool panels = true) { show(shownLook_, panels); }

  /// Of the last frame [pixels].
  std::pair<int, int> size() const { return {seen_.pixelsAcross(), seen_.pixelsDown()}; }

  /// Whether all that was asked of documents is done.
  bool idle() const {
    return loader_.idle() && !loading_.busy && pending_.empty() &&
           loaderChanges_ == loader_.changes();
  }

  /// Whether all is loaded and the picture is drawn as finely as it will be.
  bool settled() const;

  /// Whether a frame of this input, after so many seconds, would show anything new.
  bool due(const ViewerInput& input);

  /// Is called, in another thread, when a picture is there.
  void onNews(std::function<void()> wake) { picture_.onNews(std::move(wake)); }

  /// How soon to ask whether another frame is due if nobody does anything [s].
  double patience() const;

  /// True once after a person asked for a screenshot.
  bool takeScreenshotRequest() { return std::exchange(screenshotRequested_, false); }

  void requestScreenshot() { screenshotRequested_ = true; }

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

  /// Changes the document's signs and lights, as soon as the loader comes to it.
  void edit(const SceneEdit& edit);

  /// Adds a sign or a light where the middle of the picture looks at.
  void add(SceneEdit::Kind kind);

  /// The next click puts the sign or the lamp of this path there; empty: none.
  void place(const std::string& path) { placing_ = path; }

  const std::string& placing() const { return placing_; }

  /// What a ray meets, or, where that is nothing, a place as far away as the camera's target,
  /// facing the eye.
  WallPlace placeAlong(const Segment& ray) const;

  void undoChange();
  void redoChange();

  void saveScene();
  void saveMap();
  void undoPainting();
  void redoPainting();

  /// Hands what was painted to the document.
  void sendMap();

  void beginFilm(const ViewerInput& input);

  void cancelFilm() { endFilm(""); }

  const FilmExport* film() const { return film_.get(); }

  /// The map of fog from above, in colours, as a texture: row 0 at the largest y.
  GLuint planTexture();

 private:
  ViewerApp(OpenDocument open, const ViewerOptions& options, GlDevice device, ViewPicture picture);

  void feed(const ViewerInput& input);
  void takeLoaded(const ViewerInput& input);
  void takeDocument(DocumentInfo opened, const ViewerInput& input);
  void beginWith(std::optional<double> time);
  void control(const ViewerInput& input);
  void walk(const ViewerInput& input);
  void keys(const ViewerInput& input);
  void press(Key key, const ViewerInput& input);
  void paintInView(const ViewerInput& input);
  bool placeInView(const ViewerInput& input);
  void undo();
  void redo();
  void goOnLeaving(bool idle);
  void goOnWithFilm();
  void endFilm(std::string message);
  void usePanels(const ViewerInput& input);
  Status drawPicture(const ViewerInput& input);
  void show(const DisplayLook& look, bool panels = true);
  void leaveTo(const std::string& path);
  bool mayWrite(const std::string& target, std::function<void()> then);
  WorkNotes::Seen seenWork() const;
  void pivotAt(double x, double y);
  Vec3 placeUnder(double x, double y) const;
  void copyCamera();
  PictureRequest request(const ViewerInput& input) const;
  double playingBudget() const;
  DisplayLook displayLook() const;
  StartView startView() const;

  ViewerOptions options_;
  GlDevice device_;
  ViewPicture picture_;
  Loader loader_;
  LoaderState loading_;
  Timeline timeline_;
  ViewCamera camera_;
  ViewerSettings settings_;
  PaintTool paint_;
  FogPlan plan_;
  std::unique_ptr<FilmExport> film_;
  std::optional<double> filmAsked_;                 ///< the time that the loader was asked for it
  std::optional<Result<LoadedScene>> filmScene_{};  ///< the last that came for it
  std::optional<DocumentInfo> document_;
  std::optional<LoadedScene> scene_;
  std::map<std::string, std::vector<double>> pending_;  ///< parameters on their way
  int edits_ = 0;                                       ///< that were asked for
  std::string placing_;
  std::optional<Leaving> leaving_;
  DocumentFiles files_;
  WorkNotes notes_;
  MediumProbe probe_;
  Clipboard clipboard_;
  bool fullScreenRequested_ = false;
  bool ends_ = false;
  std::optional<std::size_t> savedVersion_;  ///< of the painted map, on its way to a file
  std::map<std::string, ControlPlace> controls_;
  FrameCosts costs_;
  std::string error_, message_, lastMessage_;
  std::string pictureError_;  ///< why the scene that was loaded last cannot be shown
  double requested_ = 0;      ///< the time that the loader was asked for
  /// Another file is being opened: at this time, if a person said so.
  std::optional<std::optional<double>> opening_;
  bool timeAsked_ = false;  ///< a person said at which time to begin
  FirstExposure exposure_;
  bool viewSet_ = false;
  bool moving_ = false;  ///< a person is turning it, or it plays
  bool played_ = false;  ///< in the last frame
  int lively_ = 0;       ///< frames that follow soon
  bool steps_ = false;   ///< the next frame only goes on with playing: see due()
  bool drew_ = false;
  double unseen_ = 0;     ///< [s] since the last frame that was drawn
  int shownVersion_ = 0;  ///< of the picture
  int loaderChanges_ = 0;
  ViewerInput seen_;  ///< the last
  DisplayLook shownLook_;
  PointerState pointer_;
  bool screenshotRequested_ = false;
  double fontScale_ = 1;
};

}  // namespace volute
