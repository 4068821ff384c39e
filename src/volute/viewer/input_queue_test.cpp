// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/input_queue.hpp"

#include <gtest/gtest.h>

namespace volute {
namespace {

/// Frames until nothing waits.
std::vector<ViewerInput> framesOf(InputQueue& queue) {
  std::vector<ViewerInput> frames;
  while (queue.waits()) frames.push_back(queue.next());
  return frames;
}

TEST(InputQueue, EveryClickIsSeenHoweverFewFramesThereAre) {
  InputQueue queue;
  queue.moveTo(30, 40);
  for (int i = 0; i < 20; ++i) queue.button(0, true, i), queue.button(0, false, i + 0.01);
  int presses = 0, releases = 0;
  bool down = false;
  for (const ViewerInput& frame : framesOf(queue)) {
    presses += frame.buttons[0] && !down;
    releases += !frame.buttons[0] && down;
    down = frame.buttons[0];
    EXPECT_EQ(frame.mouseX, 30);
    EXPECT_FALSE(frame.twice);
  }
  EXPECT_EQ(presses, 20);
  EXPECT_EQ(releases, 20);
  EXPECT_EQ(framesOf(queue).size(), 0U);
}

TEST(InputQueue, AButtonGoesDownWhereTheMouseWas) {
  InputQueue queue;
  queue.moveTo(1, 2);
  queue.moveTo(3, 4);
  queue.button(0, true, 0);
  queue.moveTo(9, 9);
  queue.button(0, false, 0.1);
  const auto frames = framesOf(queue);
  ASSERT_EQ(frames.size(), 4U);
  EXPECT_EQ(frames[0].mouseX, 3) << "moves without a click between them are one";
  EXPECT_FALSE(frames[0].buttons[0]);
  EXPECT_TRUE(frames[1].buttons[0]);
  EXPECT_EQ(frames[1].mouseX, 3);
  EXPECT_TRUE(frames[2].buttons[0]);
  EXPECT_EQ(frames[2].mouseX, 9);
  EXPECT_FALSE(frames[3].buttons[0]);
}

TEST(InputQueue, TwiceIsTwoPressesWithinATime) {
  InputQueue queue;
  for (const double time : {1.0, 1.2, 2.0})
    queue.button(0, true, time), queue.button(0, false, time);
  std::vector<bool> twice;
  for (const ViewerInput& frame : framesOf(queue)) {
    if (frame.buttons[0])
      twice.push_back(frame.twice);
  }
  EXPECT_EQ(twice, (std::vector<bool>{false, true, false}));
}

TEST(InputQueue, QuickChordsKeepTheirModifiers) {
  InputQueue queue;
  queue.modifiers(false, true);
  queue.key(Key::kC, true, false, true);
  queue.key(Key::kC, false, false, true);
  queue.modifiers(false, false);
  queue.key(Key::kC, true, false, false);
  queue.key(Key::kC, false, false, false);
  std::vector<bool> control;
  for (const ViewerInput& frame : framesOf(queue)) {
    for (const Key key : frame.pressed) {
      EXPECT_EQ(key, Key::kC);
      EXPECT_TRUE(frame.held.contains(key));
      control.push_back(frame.control);
    }
  }
  EXPECT_EQ(control, (std::vector<bool>{true, false}));
}

TEST(InputQueue, TextAndTheKeysThatEditItStayInOrder) {
  InputQueue queue;
  const auto tap = [&](Key key) {
    queue.key(key, true, false, false), queue.key(key, false, false, false);
  };
  queue.type("a"), queue.type("b");
  tap(Key::kBackspace), tap(Key::kBackspace);
  queue.type("c");
  tap(Key::kEnter);
  std::string all;
  for (const ViewerInput& frame : framesOf(queue)) {
    EXPECT_LE(frame.pressed.size(), 1U);
    EXPECT_TRUE(frame.typed.empty() || frame.pressed.empty());
    all += frame.typed;
    if (!frame.pressed.empty())
      all += frame.pressed[0] == Key::kEnter ? '!' : '<';
  }
  EXPECT_EQ(all, "ab<<c!");
}

TEST(InputQueue, LetterKeysOfATextDoNotSplitIt) {
  InputQueue queue;
  for (const auto& [key, letter] : {std::pair(Key::kC, "c"), std::pair(Key::kA, "a")}) {
    queue.key(key, true, false, false);
    queue.type(letter);
  }
  const auto frames = framesOf(queue);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(frames[0].typed, "ca");
}

TEST(InputQueue, EveryFileThatIsDroppedAndTheWheelCount) {
  InputQueue queue;
  queue.turn(1), queue.turn(-3);
  queue.drop("a"), queue.drop("b");
  queue.close();
  const auto frames = framesOf(queue);
  ASSERT_EQ(frames.size(), 2U);
  EXPECT_EQ(frames[0].wheel, -2);
  EXPECT_EQ(frames[0].dropped, "a");
  EXPECT_EQ(frames[1].dropped, "b");
  EXPECT_EQ(frames[1].wheel, 0);
  EXPECT_TRUE(frames[1].closes);
}

TEST(KeyNamed, IsByTheLayoutsLetters) {
  EXPECT_EQ(keyNamed("z"), Key::kZ);
  EXPECT_EQ(keyNamed("Y"), Key::kY);
  EXPECT_EQ(keyNamed("+"), Key::kPlus);
  EXPECT_EQ(keyNamed("b"), Key::kB);
  EXPECT_EQ(keyNamed("j"), std::nullopt);
  EXPECT_EQ(keyNamed("\u00df"), std::nullopt);
  EXPECT_EQ(keyNamed(""), std::nullopt);
}

}  // namespace
}  // namespace volute
