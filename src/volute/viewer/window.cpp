// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/window.hpp"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "volute/io/image_file.hpp"
#include "volute/viewer/input_queue.hpp"
#include "volute/viewer/shown_picture.hpp"
#include "volute/viewer/viewer_app.hpp"

namespace volute {
namespace {

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
    glfwSetKeyCallback(
        window_, [](GLFWwindow* window, int code, int scancode, int action, int mods) {
          const bool shift = mods & GLFW_MOD_SHIFT, control = mods & GLFW_MOD_CONTROL;
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
      if (count > 0)
        of(window).queue_.drop(paths[0]);
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

}  // namespace

Status runViewerWindow(OpenDocument open, const ViewerStart& start, Progress& progress) {
  VOLUTE_ASSIGN(const auto window, Window::create(start.width, start.height));
  ViewerOptions options = start.options;
  options.desktop = true;
  options.recent = RecentFiles::usualFile();
  VOLUTE_ASSIGN(const auto app, ViewerApp::create(std::move(open), options));
  app->clipboard().use([&] { return window->clipboard(); },
                       [&](const std::string& text) { window->setClipboard(text); });
  if (!start.path.empty())
    app->open(start.path, start.time);
  app->onNews([] { glfwPostEmptyEvent(); });
  double skipped = 0;  // [s] since the last frame
  while (!app->ends() && !progress.cancelled()) {
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
        app->leaveFor("");
      continue;  // minimised
    }
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    VOLUTE_TRY(app->frame(input));
    if (app->takeScreenshotRequest()) {
      const std::string name = screenshotName();
      app->showAgain(false);
      const Status written = writeImage(name, shownPicture(input.columns, input.rows));
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
