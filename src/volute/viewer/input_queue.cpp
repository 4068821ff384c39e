// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/input_queue.hpp"

#include <algorithm>
#include <cctype>
#include <utility>

namespace volute {
namespace {

/// Keys that act on the text before them.
bool edits(Key key) {
  constexpr Key kEditing[] = {Key::kLeft,      Key::kRight,  Key::kHome,  Key::kEnd,
                              Key::kBackspace, Key::kDelete, Key::kEnter, Key::kEscape};
  return std::ranges::find(kEditing, key) != std::end(kEditing);
}

}  // namespace

/// What one frame shows so far.
struct InputQueue::Frame {
  ViewerInput input{};
  bool moved = false, keys = false;
  bool changed[3]{};  ///< buttons
};

void InputQueue::moveTo(double x, double y) {
  events_.push_back({.kind = Event::Kind::kMove, .x = x, .y = y});
}

void InputQueue::button(int number, bool down, double time) {
  constexpr double kTwice = 0.35;  // [s]
  Event event{.kind = Event::Kind::kButton, .button = number, .down = down};
  if (number == 0 && down)
    event.twice = time - std::exchange(pressedAt_, time) < kTwice;
  events_.push_back(std::move(event));
}

void InputQueue::key(Key key, bool down, bool shift, bool control) {
  events_.push_back(
      {.kind = Event::Kind::kKey, .key = key, .down = down, .shift = shift, .control = control});
}

void InputQueue::modifiers(bool shift, bool control) {
  events_.push_back({.kind = Event::Kind::kModifiers, .shift = shift, .control = control});
}

void InputQueue::turn(double clicks) {
  events_.push_back({.kind = Event::Kind::kWheel, .y = clicks});
}

void InputQueue::type(std::string text) {
  events_.push_back({.kind = Event::Kind::kText, .text = std::move(text)});
}

void InputQueue::drop(std::string file) {
  events_.push_back({.kind = Event::Kind::kDrop, .text = std::move(file)});
}

void InputQueue::close() {
  events_.push_back({.kind = Event::Kind::kClose});
}

/// Whether it has to be seen after what the frame shows, not with it.
bool InputQueue::follows(const Event& event, const Frame& frame) {
  const ViewerInput& input = frame.input;
  const bool clicked = std::ranges::count(frame.changed, true) > 0;
  const bool otherModifiers = event.shift != input.shift || event.control != input.control;
  switch (event.kind) {
    case Event::Kind::kMove:
      return clicked;
    case Event::Kind::kButton:
      return frame.moved || clicked;
    case Event::Kind::kKey: {
      const bool pressed = std::ranges::count(input.pressed, *event.key) > 0;
      if (!event.down)
        return pressed;
      const bool acts = edits(*event.key) || !input.pressed.empty();
      return pressed || (otherModifiers && (frame.keys || clicked)) ||
             (acts && edits(*event.key) && !input.typed.empty()) ||
             std::ranges::any_of(input.pressed, edits);
    }
    case Event::Kind::kModifiers:
      return otherModifiers && (frame.keys || clicked);
    case Event::Kind::kWheel:
      return clicked;
    case Event::Kind::kText:
      return std::ranges::any_of(input.pressed, edits);
    case Event::Kind::kDrop:
      return !input.dropped.empty();
    case Event::Kind::kClose:
      return input.closes;
  }
  return false;
}

void InputQueue::take(Event& event, Frame& frame) {
  ViewerInput& input = frame.input;
  switch (event.kind) {
    case Event::Kind::kMove:
      frame.moved = frame.moved || event.x != input.mouseX || event.y != input.mouseY;
      input.mouseX = event.x, input.mouseY = event.y;
      break;
    case Event::Kind::kButton:
      input.buttons[event.button] = event.down;
      input.twice = input.twice || event.twice;
      frame.changed[event.button] = true;
      break;
    case Event::Kind::kKey:
      input.shift = event.shift, input.control = event.control;
      if (event.down) {
        input.held.insert(*event.key);
        input.pressed.push_back(*event.key);
        frame.keys = true;
      } else {
        input.held.erase(*event.key);
      }
      break;
    case Event::Kind::kModifiers:
      input.shift = event.shift, input.control = event.control;
      break;
    case Event::Kind::kWheel:
      input.wheel += event.y;
      break;
    case Event::Kind::kText:
      input.typed += event.text;
      break;
    case Event::Kind::kDrop:
      input.dropped = std::move(event.text);
      break;
    case Event::Kind::kClose:
      input.closes = true;
      break;
  }
}

ViewerInput InputQueue::next() {
  Frame frame{.input = now_};
  while (!events_.empty() && !follows(events_.front(), frame)) {
    take(events_.front(), frame);
    events_.pop_front();
  }
  now_ = frame.input;
  now_.pressed.clear();
  now_.typed.clear();
  now_.dropped.clear();
  now_.closes = now_.twice = false;
  now_.wheel = 0;
  return std::move(frame.input);
}

std::optional<Key> keyNamed(std::string_view label) {
  constexpr std::pair<char, Key> kKeys[] = {
      {'a', Key::kA}, {'c', Key::kC},    {'d', Key::kD},    {'e', Key::kE},     {'f', Key::kF},
      {'h', Key::kH}, {'m', Key::kM},    {'o', Key::kO},    {'p', Key::kP},     {'q', Key::kQ},
      {'s', Key::kS}, {'v', Key::kV},    {'w', Key::kW},    {'x', Key::kX},     {'y', Key::kY},
      {'z', Key::kZ}, {'+', Key::kPlus}, {'=', Key::kPlus}, {'-', Key::kMinus}, {'b', Key::kB},
      {'i', Key::kI}, {'k', Key::kK},    {'l', Key::kL},    {'1', Key::k1},     {'3', Key::k3},
      {'5', Key::k5}, {'7', Key::k7},    {'r', Key::kR}};
  if (label.size() != 1)
    return std::nullopt;
  const char letter = static_cast<char>(std::tolower(static_cast<unsigned char>(label[0])));
  const auto found = std::ranges::find(kKeys, letter, &std::pair<char, Key>::first);
  return found == std::end(kKeys) ? std::nullopt : std::optional(found->second);
}

}  // namespace volute
