// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Keys and the mouse over the picture, as the help promises them.

#include "volute/viewer/controls_testing.hpp"

namespace volute {
namespace {

class KeyControls : public WideControls {
 protected:
  static constexpr double kX = 0.5 * kWide, kY = 320;  ///< beside the panels

  void SetUp() override {
    WideControls::SetUp();
    if (!script_)
      return;
    script_->input().height = 800;
    open("blob.npy");  // of two frames, and soon drawn
    script_->move(kX, kY);
  }

  Vec3 eye() { return app().view().camera().eye(); }

  Vec3 ahead() { return (app().view().camera().view().target - eye()).normalized(); }

  Vec3 aside() { return ahead().cross(app().view().camera().view().up).normalized(); }

  /// What walks so: how far the eye came [m].
  Vec3 walked(std::set<Key> keys, int frames = 6) {
    const Vec3 begun = eye();
    script_->holdKeys(std::move(keys), frames);
    return eye() - begun;
  }
};

TEST_F(KeyControls, TheWheelGoesNearerAndFarther) {
  const double far = app().view().camera().distance();
  const int wide = script_->input().width, high = script_->input().height;
  const Vec2 pointer(0.48 * wide, 0.4 * high);
  script_->move(pointer.x(), pointer.y());
  const Vec3 begun = eye();
  const auto camera = [&] { return app().view().camera().camera(wide, high); };
  const Segment ray = camera().ray(pointer.x(), pointer.y());
  const Vec3 under = app().tools().pointer.placeAlong(ray).position;
  expectSeen("nearer", [&] { script_->wheel(2); });
  EXPECT_LT(app().view().camera().distance(), far);
  EXPECT_NEAR((*camera().project(under) - pointer).norm(), 0, 1e-6)
      << "what is under the pointer stays there";
  expectSeen("farther", [&] { script_->wheel(-2); });
  EXPECT_LT((eye() - begun).norm(), 1e-9) << "as far as before";
  script_->move(100, 60);
  script_->wheel(2);
  EXPECT_LT((eye() - begun).norm(), 1e-9) << "over a panel it is the panel's";
}

TEST_F(KeyControls, TheRightAndTheMiddleButtonAndShiftMoveAcross) {
  const StartView begun = app().view().camera().view();
  const Vec3 direction = ahead();
  std::vector<Vec3> moves;
  const auto across = [&](const char* what, int button, bool shift) {
    app().view().camera().set(begun);
    script_->input().shift = shift;
    expectSeen(what, [&] { script_->drag(kX, kY, kX + 80, kY + 30, button); });
    script_->input().shift = false;
    moves.emplace_back(eye() - begun.eye);
    EXPECT_LT((ahead() - direction).norm(), 1e-9) << what;
  };
  across("right", 1, false);
  across("middle", 2, false);
  across("Shift", 0, true);
  EXPECT_GT(moves[0].norm(), 0.05 * app().view().camera().distance());
  EXPECT_LT(moves[0].dot(aside()), 0) << "what is seen follows the mouse";
  EXPECT_NEAR(moves[0].dot(direction), 0, 1e-9);
  EXPECT_LT((moves[1] - moves[0]).norm(), 1e-9);
  EXPECT_LT((moves[2] - moves[0]).norm(), 1e-9);
  app().view().camera().set(begun);
  expectSeen("left", [&] { script_->drag(kX, kY, kX + 80, kY + 30); });
  EXPECT_GT((ahead() - direction).norm(), 0.1) << "it turns";
}

TEST_F(KeyControls, TimeObeysSpaceAndArrowsHomeAndEnd) {
  const Timeline& time = app().playback().timeline();
  expectSeen("End", [&] { script_->press(Key::kEnd); });
  EXPECT_EQ(time.time(), time.last());
  expectSeen("Home", [&] { script_->press(Key::kHome); });
  EXPECT_EQ(time.time(), time.first());
  expectSeen("Right", [&] { script_->press(Key::kRight); });
  EXPECT_EQ(time.frame(), 1);
  expectSeen("Left", [&] { script_->press(Key::kLeft); });
  EXPECT_EQ(time.frame(), 0);
  script_->input().seconds = 0.1 * time.last();
  script_->press(Key::kSpace);
  EXPECT_TRUE(time.playing());
  script_->frames(5);
  script_->press(Key::kSpace);
  EXPECT_FALSE(time.playing());
  const double stopped = time.time();
  EXPECT_GT(stopped, 0.3 * time.last());
  EXPECT_LT(stopped, 0.8 * time.last());
  script_->frames(5);
  EXPECT_EQ(time.time(), stopped);
}

TEST_F(KeyControls, PlusAndMinusAreHalfAStop) {
  const Image begun = picture();
  expectSeen("plus", [&] { script_->press(Key::kPlus); });
  EXPECT_EQ(app().settings().look.stops, 0.5);
  expectSeen("minus", [&] { script_->press(Key::kMinus); });
  EXPECT_LT(difference(begun, picture()), 1e-6);
  expectSeen("minus", [&] { script_->press(Key::kMinus); });
  EXPECT_EQ(app().settings().look.stops, -0.5);
}

TEST_F(KeyControls, FSeesAllAndMWalks) {
  ASSERT_TRUE(script_->click("Whole view"));
  const StartView whole = app().view().camera().view();
  script_->drag(kX, kY, kX + 60, kY - 20);
  script_->wheel(3);
  expectSeen("F", [&] { script_->press(Key::kF); });
  EXPECT_LT((eye() - whole.eye).norm(), 1e-9);
  EXPECT_EQ(app().view().camera().fov(), whole.fov);
  script_->press(Key::kM);
  EXPECT_EQ(app().view().camera().mode(), ViewCamera::Mode::kWalk);
  expectSeen("the head turns", [&] { script_->drag(kX, kY, kX + 60, kY); });
  EXPECT_LT((eye() - whole.eye).norm(), 1e-9);
  script_->press(Key::kM);
  EXPECT_EQ(app().view().camera().mode(), ViewCamera::Mode::kOrbit);
  expectSeen("it goes around", [&] { script_->drag(kX, kY, kX + 60, kY); });
  EXPECT_GT((eye() - whole.eye).norm(), 0.05 * app().view().camera().distance());
}

TEST_F(KeyControls, HeldLettersWalk) {
  EXPECT_EQ(walked({Key::kW}).norm(), 0) << "it does not walk";
  script_->press(Key::kM);
  const Vec3 up = app().view().camera().view().up, right = aside(), level = up.cross(right);
  Vec3 forth;
  expectSeen("W", [&] { forth = walked({Key::kW}); });
  EXPECT_GT(forth.dot(level), 0.01 * app().view().camera().distance());
  EXPECT_LT(forth.cross(level).norm(), 1e-9) << "at the level of the eye";
  expectSeen("S", [&] { EXPECT_LT((walked({Key::kS}) + forth).norm(), 1e-9); });
  const double pace = forth.norm();
  Vec3 there;
  expectSeen("D", [&] { there = walked({Key::kD}); });
  EXPECT_LT((there - pace * right).norm(), 1e-9);
  expectSeen("A", [&] { EXPECT_LT((walked({Key::kA}) + there).norm(), 1e-9); });
  expectSeen("E", [&] { there = walked({Key::kE}); });
  EXPECT_LT((there - pace * up).norm(), 1e-9);
  expectSeen("Q", [&] { EXPECT_LT((walked({Key::kQ}) + there).norm(), 1e-9); });
  EXPECT_LT((walked({Key::kW, Key::kD}) - pace * (level + right)).norm(), 1e-9);
  EXPECT_LT((walked({Key::kW}, 12) - 2 * forth).norm(), 1e-9) << "twice as long, twice as far";
  script_->input().shift = true;
  EXPECT_LT((walked({Key::kW}) - 4 * forth).norm(), 1e-9) << "Shift: faster";
}

TEST_F(KeyControls, CtrlSSavesTheScene) {
  ASSERT_TRUE(script_->write("scene", folder_.path("by_key.json")));
  ASSERT_TRUE(script_->click("/media/0/extinction", 0.3));
  load();
  ASSERT_TRUE(script_->settle());  // what is kept is the exposure of a finished picture
  script_->move(kX, kY);
  const auto begun = eye();
  script_->press(Key::kM);
  script_->input().held = {Key::kS};
  script_->press(Key::kS, true);
  script_->input().held.clear();
  load();
  EXPECT_EQ(app().document().error(), "");
  EXPECT_EQ(eye(), begun) << "S with Ctrl is no step back";
  ASSERT_TRUE(std::filesystem::exists(folder_.path("by_key.json")));
  expectTheSameAfter("by_key.json");
}

TEST_F(KeyControls, CtrlAndAClickWriteASlidersNumber) {
  expectSeen("exposure", [&] {
    script_->input().control = true;
    ASSERT_TRUE(script_->click("exposure"));
    script_->input().control = false;
    script_->type("1.25");
    script_->press(Key::kEnter);
  });
  EXPECT_EQ(app().settings().look.stops, 1.25);
}

TEST_F(KeyControls, ACommaIsADecimalPointInANumberOnly) {
  script_->input().control = true;
  ASSERT_TRUE(script_->click("exposure"));
  script_->input().control = false;
  script_->type("0,5");
  script_->press(Key::kEnter);
  EXPECT_EQ(app().settings().look.stops, 0.5);
  ASSERT_TRUE(script_->click("scene", 0.3));
  script_->type("0,5");
  EXPECT_EQ(app().settings().sceneName, "0,5");
}

TEST_F(KeyControls, LettersInABoxAreText) {
  ASSERT_TRUE(script_->click("scene", 0.3));
  script_->input().typed = "mfh";
  script_->press(Key::kM);
  script_->press(Key::kF);
  script_->press(Key::kH);
  EXPECT_EQ(app().view().camera().mode(), ViewCamera::Mode::kOrbit);
  EXPECT_TRUE(app().settings().panels);
  EXPECT_EQ(app().settings().sceneName, "mfh");
}

TEST_F(KeyControls, HHidesThePanelsAndF1ShowsHelp) {
  ASSERT_TRUE(script_->settle());
  const Image panels = viewer_->picture();
  script_->press(Key::kH);
  script_->frames(2);
  EXPECT_FALSE(script_->has("exposure"));
  EXPECT_GT(difference(panels, viewer_->picture()), 0.1);
  const Image bare = viewer_->picture();
  script_->press(Key::kF1);
  script_->frames(3);
  EXPECT_GT(difference(bare, viewer_->picture()), 0.1);
  script_->press(Key::kEscape);
  script_->frames(2);
  EXPECT_LT(difference(bare, viewer_->picture()), 0.01);
  script_->press(Key::kH);
  script_->frames(3);
  EXPECT_TRUE(script_->has("exposure"));
  EXPECT_FALSE(app().window().takeScreenshotRequest());
  script_->press(Key::kF12);
  EXPECT_TRUE(app().window().takeScreenshotRequest());
}

}  // namespace
}  // namespace volute
