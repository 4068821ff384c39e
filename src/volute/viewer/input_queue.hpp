// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <string_view>

#include "volute/viewer/viewer_input.hpp"

namespace volute {

/// What a person did, in order, until frames show it: a press and its release, two presses of a
/// key, or a click after the mouse moved come in frames of their own, however few frames there are.
class InputQueue {
 public:
  void moveTo(double x, double y);  ///< [points]
  /// @param time  [s]
  void button(int number, bool down, double time);
  void key(Key key, bool down, bool shift, bool control);

  /// A key that means nothing here may change these.
  void modifiers(bool shift, bool control);

  void turn(double clicks);  ///< the wheel
  void type(std::string text);
  void drop(std::string file);
  void close();

  /// Whether something happened that no frame has shown.
  bool waits() const { return !events_.empty(); }

  /// Of the next frame; its size, scale and seconds are not filled.
  ViewerInput next();

 private:
  struct Event {
    enum class Kind { kMove, kButton, kKey, kModifiers, kWheel, kText, kDrop, kClose };

    Kind kind = Kind::kMove;
    double x = 0, y = 0;  ///< place, or clicks
    int button = 0;
    std::optional<Key> key{};
    bool down = false, shift = false, control = false, twice = false;
    std::string text{};
  };

  struct Frame;

  static bool follows(const Event& event, const Frame& frame);
  void take(Event& event, Frame& frame);

  std::deque<Event> events_;
  ViewerInput now_;          ///< what stays from frame to frame
  double pressedAt_ = -1e9;  ///< when the left button was [s]
};

/// The key whose cap says this in the layout of the keyboard; nothing for a letter that means
/// nothing here.
std::optional<Key> keyNamed(std::string_view label);

}  // namespace volute
