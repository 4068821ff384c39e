// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/window.hpp"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "volute/io/image_file.hpp"
#include "volute/viewer/shown_picture.hpp"
#include "volute/viewer/viewer_app.hpp"

namespace volute {
namespace {

std::optional<Key> keyOf(int key) {
  switch (key) {
    case GLFW_KEY_SPACE:
      return Key::kSpace;
    case GLFW_KEY_LEFT:
      return Key::kLeft;
    case GLFW_KEY_RIGHT:
      return Key::kRight;
    case GLFW_KEY_UP:
      return Key::kUp;
    case GLFW_KEY_DOWN:
      return Key::kDown;
    case GLFW_KEY_HOME:
      return Key::kHome;
    case GLFW_KEY_END:
      return Key::kEnd;
    case GLFW_KEY_EQUAL:
    case GLFW_KEY_KP_ADD:
      return Key::kPlus;
    case GLFW_KEY_MINUS:
    case GLFW_KEY_KP_SUBTRACT:
      return Key::kMinus;
    case GLFW_KEY_F1:
      return Key::kF1;
    case GLFW_KEY_1:
    case GLFW_KEY_KP_1:
      return Key::k1;
    case GLFW_KEY_3:
    case GLFW_KEY_KP_3:
      return Key::k3;
    case GLFW_KEY_7:
    case GLFW_KEY_KP_7:
      return Key::k7;
    case GLFW_KEY_F11:
      return Key::kF11;
    case GLFW_KEY_F12:
      return Key::kF12;
    case GLFW_KEY_ESCAPE:
      return Key::kEscape;
    case GLFW_KEY_A:
      return Key::kA;
    case GLFW_KEY_C:
      return Key::kC;
    case GLFW_KEY_D:
      return Key::kD;
    case GLFW_KEY_E:
      return Key::kE;
    case GLFW_KEY_F:
      return Key::kF;
    case GLFW_KEY_H:
      return Key::kH;
    case GLFW_KEY_M:
      return Key::kM;
    case GLFW_KEY_O:
      return Key::kO;
    case GLFW_KEY_P:
      return Key::kP;
    case GLFW_KEY_Q:
      return Key::kQ;
    case GLFW_KEY_S:
      return Key::kS;
    case GLFW_KEY_V:
      return Key::kV;
    case GLFW_KEY_X:
      return Key::kX;
    case GLFW_KEY_W:
      return Key::kW;
    case GLFW_KEY_Y:
      return Key::kY;
    case GLFW_KEY_Z:
      return Key::kZ;
    case GLFW_KEY_BACKSPACE:
      return Key::kBackspace;
    case GLFW_KEY_DELETE:
      return Key::kDelete;
    case GLFW_KEY_ENTER:
    case GLFW_KEY_KP_ENTER:
      return Key::kEnter;
    default:
      return std::nullopt;
  }
}

void appendUtf8(std::string& text, unsigned code) {
  const auto add = [&](unsigned byte) { text += static_cast<char>(byte); };
  if (code < 0x80) {
    add(code);
  } else if (code < 0x800) {
    add(0xC0 | code >> 6), add(0x80 | (code & 0x3F));
  } else if (code < 0x10000) {
    add(0xE0 | code >> 12), add(0x80 | (code >> 6 & 0x3F)), add(0x80 | (code & 0x3F));
  } else {
    add(0xF0 | code >> 18), add(0x80 | (code >> 12 & 0x3F)), add(0x80 | (code >> 6 & 0x3F));
    add(0x80 | (code & 0x3F));
  }
}

/// GLFW, started; ended with its owner.
class Window {
 public:
  static Result<std::unique_ptr<Window>> create(int width, int height) {
    std::unique_ptr<Window> window(new Window);
    if (!glfwInit()) {
      return fail(ErrorCode::kUnsupported,
                  "no display to open a window; --screenshot OUT.png needs none");
    }
    window->started_ = true;
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    window->window_ = glfwCreateWindow(width, height, "Volute", nullptr, nullptr);
    if (!window->window_) {
      return fail(ErrorCode::kUnsupported,
                  "this display's driver has no OpenGL 4.5; update the graphics driver");
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

  /// What happened since the last call. If that is nothing, waits so long for something [s]: a
  /// frame that shows nothing new takes time from those who load and draw.
  ViewerInput input(double patience) {
    heard_.pressed.clear();
    heard_.dropped.clear();
    heard_.typed.clear();
    heard_.closes = heard_.twice = false;
    heard_.wheel = 0;
    const ViewerInput before = heard_;
    constexpr double kFrame = 1.0 / 60;
    const double wait = last_ + (busy() ? kFrame : patience) - glfwGetTime();
    if (wait > 0)
      glfwWaitEventsTimeout(wait);
    else
      glfwPollEvents();
    glfwGetFramebufferSize(window_, &heard_.width, &heard_.height);
    int width = 1, height = 1;
    glfwGetWindowSize(window_, &width, &height);
    glfwGetCursorPos(window_, &heard_.mouseX, &heard_.mouseY);
    heard_.mouseX *= static_cast<double>(heard_.width) / std::max(width, 1);
    heard_.mouseY *= static_cast<double>(heard_.height) / std::max(height, 1);
    constexpr int kButtons[] = {GLFW_MOUSE_BUTTON_LEFT, GLFW_MOUSE_BUTTON_RIGHT,
                                GLFW_MOUSE_BUTTON_MIDDLE};
    for (int i = 0; i < 3; ++i)
      heard_.buttons[i] = glfwGetMouseButton(window_, kButtons[i]) == GLFW_PRESS;
    constexpr int kFramesAfter = 6;  // panels answer an event in the frames after it
    lively_ = same(before, heard_) ? std::max(lively_ - 1, 0) : kFramesAfter;
    heard_.closes = glfwWindowShouldClose(window_);
    glfwSetWindowShouldClose(window_, GLFW_FALSE);  // the viewer may have to ask
    const double now = glfwGetTime();
    heard_.seconds = wait > kFrame ? kFrame : now - last_;  // nothing moved while it rested
    last_ = now;
    return heard_;
  }

 private:
  Window() = default;

  static ViewerInput& heardBy(GLFWwindow* window) {
    return static_cast<Window*>(glfwGetWindowUserPointer(window))->heard_;
  }

  void listen() {
    glfwSetKeyCallback(window_, [](GLFWwindow* window, int code, int, int action, int mods) {
      ViewerInput& heard = heardBy(window);
      heard.shift = mods & GLFW_MOD_SHIFT;
      heard.control = mods & GLFW_MOD_CONTROL;
      const auto key = keyOf(code);
      if (!key)
        return;
      if (action == GLFW_RELEASE) {
        heard.held.erase(*key);
        return;
      }
      heard.held.insert(*key);
      heard.pressed.push_back(*key);
    });
    glfwSetCharCallback(window_, [](GLFWwindow* window, unsigned code) {
      appendUtf8(heardBy(window).typed, code);
    });
    glfwSetMouseButtonCallback(window_, [](GLFWwindow* window, int button, int action, int) {
      if (button != GLFW_MOUSE_BUTTON_LEFT || action != GLFW_PRESS)
        return;
      constexpr double kTwice = 0.35;  // [s]
      auto& own = *static_cast<Window*>(glfwGetWindowUserPointer(window));
      const double now = glfwGetTime();
      own.heard_.twice = now - std::exchange(own.pressed_, now) < kTwice;
    });
    glfwSetScrollCallback(window_,
                          [](GLFWwindow* window, double, double y) { heardBy(window).wheel += y; });
    glfwSetDropCallback(window_, [](GLFWwindow* window, int count, const char** paths) {
      if (count > 0)
        heardBy(window).dropped = paths[0];
    });
  }

  /// Whether nothing happened from one to the other.
  static bool same(const ViewerInput& a, const ViewerInput& b) {
    return b.pressed.empty() && b.typed.empty() && b.dropped.empty() && b.wheel == 0 &&
           a.mouseX == b.mouseX && a.mouseY == b.mouseY && a.width == b.width &&
           a.height == b.height && std::ranges::equal(a.buttons, b.buttons);
  }

  /// Whether a person holds something, or has just done something.
  bool busy() const {
    return lively_ > 0 || !heard_.held.empty() || heard_.buttons[0] || heard_.buttons[1] ||
           heard_.buttons[2];
  }

  bool started_ = false;
  GLFWwindow* window_ = nullptr;
  int lively_ = 0;  ///< frames that follow soon
  ViewerInput heard_;
  double last_ = 0;
  double pressed_ = -1;  ///< when the left button was [s]
  int place_[4]{};       ///< of the window before it filled the screen
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

}  // namespace

Status runViewerWindow(OpenDocument open, const ViewerStart& start, Progress& progress) {
  VOLUTE_ASSIGN(const auto window, Window::create(start.width, start.height));
  ViewerOptions options = start.options;
  options.desktop = true;
  options.scale *= window->scale();
  options.recent = RecentFiles::usualFile();
  VOLUTE_ASSIGN(const auto app, ViewerApp::create(std::move(open), options));
  app->clipboard().use([&] { return window->clipboard(); },
                       [&](const std::string& text) { window->setClipboard(text); });
  if (!start.path.empty())
    app->open(start.path, start.time);
  app->onNews([] { glfwPostEmptyEvent(); });
  double skipped = 0;  // [s] since the last frame
  while (!app->ends() && !progress.cancelled()) {
    ViewerInput input = window->input(app->patience());
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
        app->leaveFor("");
      continue;  // minimised
    }
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    VOLUTE_TRY(app->frame(input));
    if (app->takeScreenshotRequest()) {
      const std::string name = screenshotName();
      app->showAgain(false);
      const Status written = writeImage(name, shownPicture(input.width, input.height));
      app->showAgain();
      app->say(written ? name + " is written" : written.error().message);
    }
    if (app->takeFullScreenRequest())
      window->toggleFullScreen();
    window->setTitle(app->title());
    if (app->drew())
      window->show();
  }
  return {};
}

}  // namespace volute
