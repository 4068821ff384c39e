// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "volute/viewer/comparison.hpp"
#include "volute/viewer/language.hpp"
#include "volute/viewer/recovery.hpp"
#include "volute/viewer/view_report.hpp"
#include "volute/viewer/viewer_input.hpp"
#include "volute/viewer/viewer_tools.hpp"
#include "volute/viewer/viewer_window.hpp"

namespace volute {

/// Where another viewer goes on when this one's context of OpenGL is lost.
struct ViewerRest {
  std::string path{};  ///< empty: nothing is open
  std::optional<double> time{};
  std::optional<ViewCamera> camera{};
};

/// The viewer without its window: given what a person did, draws a frame into the framebuffer that
/// is bound. Needs a current context of OpenGL 4.5; one at a time in a program (Dear ImGui's).
/// Its parts know as much as they need of each other: what is open, how it is looked at, which time
/// is shown, what a hand does to it, and the window around it.
class ViewerApp {
 public:
  [[nodiscard]] static Result<std::unique_ptr<ViewerApp>> create(OpenDocument open,
                                                                 const ViewerOptions& options = {});
  ~ViewerApp();

  /// @param time  [s] to begin at; nothing: where the document's look says, else at 0
  /// @param other  a file that it is compared with; empty: none
  void open(const std::string& path, std::optional<double> time = std::nullopt,
            std::string other = {}) {
    other_ = std::move(other);
    document_.open(path, time);
  }

  /// Where another one goes on, which open() lets it. What is unsaved is kept in a file.
  ViewerRest rest() const;

  void open(const ViewerRest& rest, std::string other = {});

  ViewerSettings& settings() { return settings_; }

  ViewerDocument& document() { return document_; }

  LeaveQuestion& leaving() { return leaving_; }

  Playback& playback() { return playback_; }

  ViewerView& view() { return view_; }

  ViewerTools& tools() { return tools_; }

  Comparison& comparison() { return comparison_; }

  const Recovery& recovery() const { return recovery_; }

  WindowLanguage& language() { return language_; }

  ViewerWindow& window() { return window_; }

  ViewReport& report() { return report_; }

  /// What a person chose: opens it, or compares it with what is open.
  void takeFile(const std::string& path);

  void saveScene();
  void beginFilm(const ViewerInput& input);

  /// One frame. Errors of documents are shown, not returned; what is returned ends the viewer.
  /// @return  whether it drew anything; else what was shown before stays
  [[nodiscard]] Result<bool> frame(const ViewerInput& input);

  /// Draws what the last frame showed once more, into the framebuffer that is bound.
  void showAgain(bool panels = true) { show(shownLook_, panels); }

  /// Whether all is loaded and the picture is drawn as finely as it will be.
  bool settled() const;

  /// Whether a frame of this input, after so many seconds, would show anything new.
  bool due(const ViewerInput& input);

  /// Time until the next frame without user input [s].
  double patience() const;

 private:
  /// What the mouse did in the last frame.
  struct PointerState {
    double x = 0, y = 0;    ///< [points]
    bool drags = false;     ///< it moves the camera
    bool strokes = false;   ///< it paints fog
    bool leftHeld = false;  ///< the left button is down
    bool placed = false;    ///< and put something somewhere
  };

  ViewerApp(OpenDocument open, const ViewerOptions& options, ViewPicture picture);

  LeaveQuestion::Actions leaveActions();
  void addFile(const std::string& path);
  void feed(const ViewerInput& input);
  void takeLoaded(const ViewerInput& input);
  void takeDocument(const DocumentNews& news, const ViewerInput& input);
  void control(const ViewerInput& input);
  void walk(const ViewerInput& input);
  void keys(const ViewerInput& input);
  void useKeyboard(const ViewerInput& input);
  void focusPanel();
  void paintInView(const ViewerInput& input);
  bool placeInView(const ViewerInput& input);
  void usePanels(const ViewerInput& input);
  void show(const DisplayLook& look, bool panels = true);
  WorkNotes::Seen seenWork() const;
  PictureRequest request(const ViewerInput& input) const;

  ViewerOptions options_;
  ViewerSettings settings_;
  ViewerDocument document_;
  Playback playback_;
  ViewerView view_;
  ViewerTools tools_;
  ViewReport report_;
  LeaveQuestion leaving_;
  Comparison comparison_;
  ViewerWindow window_;
  Recovery recovery_;
  WindowLanguage language_;
  std::string other_;               ///< that the document is compared with from when it is there
  std::optional<ViewCamera> rest_;  ///< of rest(), until the document is there
  bool timeAsked_ = false;          ///< a person said at which time to begin
  bool moving_ = false;             ///< a person is turning it, or it plays
  int lively_ = 0;                  ///< frames that follow soon
  bool steps_ = false;              ///< the next frame only goes on with playing: see due()
  double unseen_ = 0;               ///< [s] since the last frame that was drawn
  int shownVersion_ = 0;            ///< of the picture
  ViewerInput seen_;                ///< the last
  DisplayLook shownLook_;
  PointerState pointer_;
  std::size_t turn_ = 0;  ///< the panel that Tab opened last
  double fontScale_ = 1;
};

/// Of the window: the file's name, and a mark where something is in no file.
std::string titleOf(ViewerApp& app);

}  // namespace volute
