// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/window.hpp"

#include "volute/base/printable.hpp"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <epoxy/gl.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <optional>

#include "volute/io/image_file.hpp"
#include "volute/viewer/input_queue.hpp"
#include "volute/viewer/shown_picture.hpp"
#include "volute/viewer/viewer_app.hpp"

namespace volute {
namespace {

constexpr std::pair<int, Key> kPlaces[] = {
    {GLFW_KEY_SPACE, Key::kSpace},   {GLFW_KEY_LEFT, Key::kLeft},
    {GLFW_KEY_RIGHT, Key::kRight},   {GLFW_KEY_UP, Key::kUp},
    {GLFW_KEY_DOWN, Key::kDown},     {GLFW_KEY_HOME, Key::kHome},
    {GLFW_KEY_END, Key::kEnd},       {GLFW_KEY_KP_ADD, Key::kPlus},
    {GLFW_KEY_F1, Key::kF1},         {GLFW_KEY_KP_SUBTRACT, Key::kMinus},
    {GLFW_KEY_F3, Key::kF3},         {GLFW_KEY_KP_1, Key::k1},
    {GLFW_KEY_KP_3, Key::k3},        {GLFW_KEY_KP_5, Key::k5},
    {GLFW_KEY_KP_7, Key::k7},        {GLFW_KEY_F11, Key::kF11},
    {GLFW_KEY_F12, Key::kF12},       {GLFW_KEY_ESCAPE, Key::kEscape},
    {GLFW_KEY_DELETE, Key::kDelete}, {GLFW_KEY_BACKSPACE, Key::kBackspace},
    {GLFW_KEY_ENTER, Key::kEnter},   {GLFW_KEY_TAB, Key::kTab},
    {GLFW_KEY_KP_ENTER, Key::kEnter}};

/// Letters and signs are those of the layout; where that has others (Greek, Cyrillic), and for all
/// other keys, the place counts.
std::optional<Key> keyOf(int key, int scancode) {
  const bool sign =
      key > GLFW_KEY_SPACE && key <= GLFW_KEY_WORLD_2 && !(key >= GLFW_KEY_0 && key <= GLFW_KEY_9);
  const char* const label = sign ? glfwGetKeyName(key, scancode) : nullptr;
  if (label && static_cast<unsigned char>(label[0]) < 0x80)
    return keyNamed(label);
  if (label && (key < GLFW_KEY_A || key > GLFW_KEY_Z))
    return std::nullopt;
  if (key > GLFW_KEY_SPACE && key <= GLFW_KEY_Z)  // what stands there on the US layout
    return keyNamed(std::string(1, static_cast<char>(key)));
  const auto place = std::ranges::find(kPlaces, key, &std::pair<int, Key>::first);
  return place == std::end(kPlaces) ? std::nullopt : std::optional(place->second);
}

/// A driver of an older OpenGL shows the window all the same, which the CPU then draws. Ends GLFW:
/// a display that is opened next finds the rasteriser.
bool useMesasRasteriser() {
  glfwTerminate();
  ::unsetenv("MESA_GL_VERSION_OVERRIDE");
  return ::setenv("LIBGL_ALWAYS_SOFTWARE", "1", 1) == 0 &&
         ::setenv("GALLIUM_DRIVER", "llvmpipe", 1) == 0 &&
         ::setenv("__GLX_VENDOR_LIBRARY_NAME", "mesa", 1) == 0;
}

/// GLFW, started; ended with its owner.
class Window {
 public:
  static Result<std::unique_ptr<Window>> create(int width, int height) {
    std::unique_ptr<Window> window(new Window);
    if (!glfwInit()) {
      return fail(ErrorCode::kUnsupported, Hint::set("screenshot").so("needs none"),
                  "no display to open a window");
    }
    window->started_ = true;
    window->make(width, height);
    if (!window->window_ && useMesasRasteriser() && glfwInit())
      window->make(width, height);
    if (!window->window_) {
      return fail(ErrorCode::kUnsupported, Hint::set("screenshot").so("needs none"),
                  "this display's driver has no OpenGL 4.5, and Mesa's rasteriser, which has it, "
                  "cannot be used instead: update the graphics driver, or install Mesa (on Debian "
                  "libgl1-mesa-dri)");
    }
    glfwMakeContextCurrent(window->window_);
    glfwSwapInterval(1);
    glfwSetWindowUserPointer(window->window_, window.get());
    window->listen();
    return window;
  }

  ~Window() {
    if (window_)
      glfwDestroyWindow(window_);
    if (started_)
      glfwTerminate();
  }

  void make(int width, int height) {
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_CONTEXT_ROBUSTNESS, GLFW_LOSE_CONTEXT_ON_RESET);
    window_ = glfwCreateWindow(width, height, "Volute", nullptr, nullptr);
  }

  void show() { glfwSwapBuffers(window_); }

  void setTitle(const std::string& title) {
    if (std::exchange(title_, title) != title)
      glfwSetWindowTitle(window_, title.c_str());
  }

  std::string clipboard() const {
    const char* text = glfwGetClipboardString(window_);
    return text ? text : "";
  }

  void setClipboard(const std::string& text) { glfwSetClipboardString(window_, text.c_str()); }

  /// How much larger than usual things are to be on this display.
  double scale() const {
    float x = 1, y = 1;
    glfwGetWindowContentScale(window_, &x, &y);
    return std::clamp(static_cast<double>(std::max(x, y)), 1.0, 4.0);
  }

  /// All of the monitor, or the window as it was.
  void toggleFullScreen() {
    if (glfwGetWindowMonitor(window_)) {
      glfwSetWindowMonitor(window_, nullptr, place_[0], place_[1], place_[2], place_[3], 0);
      return;
    }
    GLFWmonitor* monitor = glfwGetPrimaryMonitor();
    const GLFWvidmode* mode = monitor ? glfwGetVideoMode(monitor) : nullptr;
    if (!mode)
      return;
    glfwGetWindowPos(window_, &place_[0], &place_[1]);
    glfwGetWindowSize(window_, &place_[2], &place_[3]);
    glfwSetWindowMonitor(window_, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
  }

  /// Not minimised.
  void raise() {
    if (glfwGetWindowAttrib(window_, GLFW_ICONIFIED))
      glfwRestoreWindow(window_);
  }

  /// Of the next frame. If nothing happened since the last call, waits so long for something [s]: a
  /// frame that shows nothing new takes time from those who load and draw.
  /// @param scale  of letters and controls, times the display's
  ViewerInput input(double patience, double scale) {
    constexpr double kFrame = 1.0 / 60;
    const double wait = last_ + (busy() ? kFrame : patience) - glfwGetTime();
    if (wait > 0 && !queue_.waits())
      glfwWaitEventsTimeout(wait);
    else
      glfwPollEvents();
    if (glfwWindowShouldClose(window_)) {
      queue_.close();
      glfwSetWindowShouldClose(window_, GLFW_FALSE);  // the viewer may have to ask
    }
    constexpr int kFramesAfter = 6;  // panels answer an event in the frames after it
    lively_ = queue_.waits() ? kFramesAfter : std::max(lively_ - 1, 0);
    ViewerInput input = queue_.next();
    glfwGetFramebufferSize(window_, &input.columns, &input.rows);
    input.scale = scale * this->scale();
    input.width = static_cast<int>(input.columns / input.scale);
    input.height = static_cast<int>(input.rows / input.scale);
    input.mouseX /= input.scale, input.mouseY /= input.scale;
    const double now = glfwGetTime();
    input.seconds = wait > kFrame ? kFrame : now - last_;  // nothing moved while it rested
    last_ = now;
    held_ = !input.held.empty() || std::ranges::count(input.buttons, true) > 0;
    return input;
  }

 private:
  Window() = default;

  static Window& of(GLFWwindow* window) {
    return *static_cast<Window*>(glfwGetWindowUserPointer(window));
  }

  void listen() {
    glfwSetKeyCallback(window_, [](GLFWwindow* window, int code, int scancode, int action,
                                   int mods) {
      // X11 says of a modifier what was before it.
      const auto holds = [&](int mod, int left, int right) {
        const auto held = [&](int key) { return glfwGetKey(window, key) == GLFW_PRESS; };
        return code == left || code == right ? held(left) || held(right) : (mods & mod) != 0;
      };
      const bool shift = holds(GLFW_MOD_SHIFT, GLFW_KEY_LEFT_SHIFT, GLFW_KEY_RIGHT_SHIFT);
      const bool control = holds(GLFW_MOD_CONTROL, GLFW_KEY_LEFT_CONTROL, GLFW_KEY_RIGHT_CONTROL);
      if (const auto key = keyOf(code, scancode))
        of(window).queue_.key(*key, action != GLFW_RELEASE, shift, control);
      else
        of(window).queue_.modifiers(shift, control);
    });
    glfwSetCharCallback(window_, [](GLFWwindow* window, unsigned code) {
      std::string text;
      appendUtf8(text, code);
      of(window).queue_.type(std::move(text));
    });
    // In pixels: the scale of a frame is known when it is asked for.
    glfwSetCursorPosCallback(window_, [](GLFWwindow* window, double x, double y) {
      int width = 1, height = 1, columns = 1, rows = 1;
      glfwGetWindowSize(window, &width, &height);
      glfwGetFramebufferSize(window, &columns, &rows);
      of(window).queue_.moveTo(x * columns / std::max(width, 1), y * rows / std::max(height, 1));
    });
    glfwSetMouseButtonCallback(window_, [](GLFWwindow* window, int button, int action, int) {
      constexpr int kButtons[] = {GLFW_MOUSE_BUTTON_LEFT, GLFW_MOUSE_BUTTON_RIGHT,
                                  GLFW_MOUSE_BUTTON_MIDDLE};
      const auto found = std::ranges::find(kButtons, button);
      if (found != std::end(kButtons))
        of(window).queue_.button(static_cast<int>(found - kButtons), action == GLFW_PRESS,
                                 glfwGetTime());
    });
    glfwSetScrollCallback(window_,
                          [](GLFWwindow* window, double, double y) { of(window).queue_.turn(y); });
    glfwSetDropCallback(window_, [](GLFWwindow* window, int count, const char** paths) {
      for (int i = 0; i < count; ++i) of(window).queue_.drop(paths[i]);
    });
  }

  /// Whether a person holds something, or has just done something.
  bool busy() const { return lively_ > 0 || held_; }

  bool started_ = false;
  GLFWwindow* window_ = nullptr;
  int lively_ = 0;    ///< frames that follow soon
  InputQueue queue_;  ///< places in pixels
  bool held_ = false;
  double last_ = 0;
  int place_[4]{};  ///< of the window before it filled the screen
  std::string title_{};
};

/// The first name that is free.
std::string screenshotName() {
  for (int i = 1;; ++i) {
    const std::string name = fmt::format("volute_{:04d}.png", i);
    if (!std::filesystem::exists(name))
      return name;
  }
}

/// Of a driver that was reset, or a card that is gone.
bool contextIsLost() {
  return epoxy_has_gl_extension("GL_KHR_robustness") && glGetGraphicsResetStatus() != GL_NO_ERROR;
}

/// One window, until the person closes it: nothing. What is unsaved is kept for the next one.
Result<std::optional<ViewerRest>> runWindow(OpenDocument open, const ViewerStart& start,
                                            const ViewerRest& rest, Progress& progress) {
  VOLUTE_ASSIGN(const auto window, Window::create(start.width, start.height));
  ViewerOptions options = start.options;
  options.desktop = true;
  options.recent = RecentFiles::usualFile();
  VOLUTE_ASSIGN(const auto app, ViewerApp::create(std::move(open), options));
  app->window().clipboard().use([&] { return window->clipboard(); },
                                [&](const std::string& text) { window->setClipboard(text); });
  app->open(rest, start.other);
  app->view().picture().onNews([] { glfwPostEmptyEvent(); });
  double skipped = 0;  // [s] since the last frame
  while (!app->leaving().ends() && !progress.cancelled()) {
    ViewerInput input = window->input(app->patience(), options.scale);
    input.seconds += skipped;
    if (!app->due(input)) {
      skipped = input.seconds;
      continue;
    }
    skipped = 0;
    if (input.closes)
      window->raise();  // a question is seen
    if (input.width <= 0 || input.height <= 0) {
      if (input.closes)
        app->leaving().leaveFor("");
      continue;  // minimised
    }
    if (contextIsLost()) {
      const ViewerRest left = app->rest();
      return left.path.empty() ? rest : left;
    }
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    VOLUTE_ASSIGN(const bool drew, app->frame(input));
    if (app->window().takeScreenshotRequest()) {
      const std::string name = screenshotName();
      app->showAgain(false);
      const Status written = writeImage(name, shownPicture(input.columns, input.rows));
      app->showAgain();
      app->document().say(written ? name + " is written" : written.error().message, !written);
    }
    if (app->window().takeReportRequest()) {
      app->showAgain(false);
      app->report().begin(shownPicture(input.columns, input.rows));
      app->showAgain();
    }
    if (app->window().takeFullScreenRequest())
      window->toggleFullScreen();
    window->setTitle(titleOf(*app));
    if (drew)
      window->show();
  }
  return std::nullopt;
}

}  // namespace

Status runViewerWindow(OpenDocument open, const ViewerStart& start, Progress& progress) {
  constexpr int kTries = 3;  // a driver that is lost again and again is of no use,
  constexpr std::chrono::minutes kSoon{1};
  ViewerRest rest{start.path, start.time, {}};
  for (int tries = 0; tries < kTries; ++tries) {
    const auto begun = std::chrono::steady_clock::now();
    VOLUTE_ASSIGN(auto left, runWindow(open, start, rest, progress));
    if (!left)
      return {};
    rest = *std::move(left);
    if (std::chrono::steady_clock::now() - begun > kSoon)
      tries = 0;  // one that is lost once a day is
  }
  return fail(ErrorCode::kUnsupported, Hint::set("renderer"),
              "the graphics driver was reset {} times; what was not saved is offered at the next "
              "start",
              kTries);
}

}  // namespace volute
