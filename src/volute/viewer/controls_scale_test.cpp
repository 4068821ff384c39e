// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Panels on displays that want larger letters.
#include "volute/viewer/controls_testing.hpp"

namespace volute {
namespace {

class ScaleControls : public Controls {
 protected:
  /// A window of so many pixels on a display that wants things so much larger.
  void show(int columns, int rows, double scale) {
    ViewerInput& input = script_->input();
    input.scale = scale;
    input.width = static_cast<int>(columns / scale), input.height = static_cast<int>(rows / scale);
    input.columns = columns, input.rows = rows;
    ASSERT_TRUE(script_->settle());
    script_->frames(4);
  }

  void expectWhole(const std::string& what) {
    const ViewerInput& input = script_->input();
    EXPECT_FALSE(app().window().controls().empty());
    for (const auto& [name, at] : app().window().controls()) {
      EXPECT_FALSE(at.cut) << name << " is cut off, " << what;
      EXPECT_GE(at.left, 0) << name << ", " << what;
      EXPECT_LE(at.right, input.width) << name << ", " << what;
      EXPECT_LE(at.bottom, input.height + 1) << name << ", " << what;
    }
  }
};

TEST_F(ScaleControls, NothingIsCutOffAtAnyScale) {
  open("smoke.json");
  for (const double scale : {1.0, 1.5, 2.0, 3.0}) {
    for (const auto& [columns, rows] : {std::pair(950, 570), {1280, 800}, {660, 1060}}) {
      if (scale > 2 && columns > 1000)
        continue;  // larger than any display
      const std::string what = fmt::format("{} x {} points, scale {}", columns, rows, scale);
      SCOPED_TRACE(what);
      ASSERT_NO_FATAL_FAILURE(
          show(static_cast<int>(columns * scale), static_cast<int>(rows * scale), scale));
      const Image shown = viewer_->picture();
      EXPECT_EQ(shown.width, static_cast<int>(columns * scale));
      EXPECT_EQ(shown.height, static_cast<int>(rows * scale));
      expectWhole(what);
      if (script_->has("More")) {
        ASSERT_NO_FATAL_FAILURE(openMore());
      }
      expectWhole(what + ", with all of the time");
      script_->press(Key::kF1);
      script_->frames(3);
      EXPECT_TRUE(script_->has("help"));
      EXPECT_FALSE(script_->has("help is cut"));
      script_->press(Key::kF1);
      script_->frames(2);
    }
  }
}

TEST_F(ScaleControls, AClickHitsWhatIsThere) {
  open("smoke.json");
  ASSERT_NO_FATAL_FAILURE(show(1900, 1140, 2));
  const double before = app().settings().look.stops;
  ASSERT_TRUE(script_->click("exposure", 0.1));
  EXPECT_NE(app().settings().look.stops, before);
}

}  // namespace
}  // namespace volute
