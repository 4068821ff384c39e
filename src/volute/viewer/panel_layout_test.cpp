// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/panel_layout.hpp"

#include <gtest/gtest.h>

namespace volute {
namespace {

using enum SidePanel;

TEST(PanelLayout, ALargeWindowBeginsWithBothSidesOpen) {
  for (const auto& [width, height] :
       {std::pair{1024.F, 640.F}, {1280.F, 720.F}, {1920.F, 1080.F}}) {
    PanelLayout layout;
    layout.fit(width, height, 0);
    EXPECT_TRUE(layout.isOpen(kPicture) && layout.isOpen(kScene));
    EXPECT_FALSE(layout.isOpen(kPaint));
    const float free = width - layout.width(kPicture) - layout.width(kScene) - 4 * kPanelMargin;
    EXPECT_GT(free, width / 3) << width;
  }
}

TEST(PanelLayout, ASmallWindowHasOneOpenAtMost) {
  PanelLayout layout;
  layout.fit(640, 400, 0);
  for (const SidePanel panel : {kPicture, kPaint, kScene}) EXPECT_FALSE(layout.isOpen(panel));
  layout.set(kScene, true);
  layout.set(kPicture, true);
  EXPECT_FALSE(layout.isOpen(kScene));
  EXPECT_TRUE(layout.isOpen(kPicture));
  EXPECT_LT(kPanelMargin + layout.width(kPicture), 320) << "the middle stays free";
  EXPECT_LT(kPanelMargin + layout.width(kScene), 320);
  layout.fit(640, 400, 0);
  EXPECT_TRUE(layout.isOpen(kPicture)) << "as a person left it";
}

TEST(PanelLayout, TitlesOfANarrowWindowDoNotOverlap) {
  PanelLayout layout;
  layout.fit(450, 250, 0);
  const auto both = [&] { return layout.shownWidth(kPicture) + layout.shownWidth(kScene); };
  EXPECT_LE(both(), 450 - 2 * kPanelMargin - kPanelGap);
  for (const SidePanel panel : {kPicture, kScene}) {
    layout.set(panel, true);
    EXPECT_EQ(layout.shownWidth(panel), layout.width(panel));
    EXPECT_LE(both(), 450 - 2 * kPanelMargin - kPanelGap);
  }
  layout.fit(1280, 720, 0);
  layout.set(kScene, false);
  EXPECT_EQ(layout.shownWidth(kScene), layout.width(kScene));
}

TEST(PanelLayout, AWindowThatIsMadeSmallerAndLargerBeginsAnew) {
  PanelLayout layout;
  layout.fit(1280, 720, 0);
  layout.set(kPaint, true);
  layout.fit(640, 400, 0);
  for (const SidePanel panel : {kPicture, kPaint, kScene}) EXPECT_FALSE(layout.isOpen(panel));
  layout.fit(1280, 720, 0);
  EXPECT_TRUE(layout.isOpen(kPicture) && layout.isOpen(kScene));
}

TEST(PanelLayout, OnTheLeftWhatDoesNotFitCloses) {
  PanelLayout layout;
  layout.measure(kPicture, 400);
  layout.measure(kPaint, 500);
  layout.fit(1280, 720, 67);
  EXPECT_EQ(layout.most(kPicture), 720 - 20 - 67 - 4 - 19) << "a closed one keeps its title";
  layout.set(kPaint, true);
  EXPECT_FALSE(layout.isOpen(kPicture));
  EXPECT_TRUE(layout.isOpen(kScene));
  EXPECT_EQ(layout.most(kPaint), 720 - 20 - 67 - 4 - 19);
  layout.set(kPicture, true);
  EXPECT_FALSE(layout.isOpen(kPaint));
  layout.fit(1280, 1080, 67);
  layout.set(kPaint, true);
  EXPECT_TRUE(layout.isOpen(kPicture)) << "here both fit";
  EXPECT_EQ(layout.most(kPicture), 1080 - 20 - 67 - 4 - 500);
  layout.measure(kPicture, 700);
  layout.fit(1280, 1080, 67);
  EXPECT_FALSE(layout.isOpen(kPicture)) << "it has become too high for both";
}

TEST(PanelLayout, NothingMovesWhileAButtonIsHeld) {
  PanelLayout layout;
  layout.measure(kPicture, 400);
  layout.measure(kPaint, 300);
  layout.fit(1280, 900, 0);
  layout.set(kPaint, true);
  EXPECT_EQ(layout.lowerTop(410), 414);
  layout.fit(1280, 900, 0, true);
  layout.measure(kPicture, 700);
  EXPECT_EQ(layout.lowerTop(710), 414);
  EXPECT_TRUE(layout.isOpen(kPicture));
  layout.fit(1280, 900, 0, false);
  layout.measure(kPicture, 700);
  EXPECT_TRUE(layout.still() && layout.isOpen(kPicture)) << "the button has just gone up";
  layout.fit(1280, 900, 0, false);
  layout.measure(kPicture, 700);
  EXPECT_EQ(layout.lowerTop(710), 714);
  layout.fit(1280, 900, 0, false);
  EXPECT_FALSE(layout.isOpen(kPicture)) << "both do not fit any more";
  layout.fit(1280, 800, 0, true);
  EXPECT_FALSE(layout.still()) << "another window";
}

TEST(PanelLayout, AClosedOneHasItsTitleBeforeItWasEverOpen) {
  PanelLayout layout;
  layout.fit(640, 400, 0);
  layout.set(kPaint, true);
  EXPECT_EQ(layout.most(kPaint), 400 - 20 - 4 - 19);
}

TEST(PanelLayout, WhatIsNotThereTakesNothing) {
  PanelLayout layout;
  layout.measure(kPaint, 0);
  layout.fit(1280, 720, 0);
  EXPECT_EQ(layout.most(kPicture), 700);
  EXPECT_EQ(layout.most(kScene), 700);
}

}  // namespace
}  // namespace volute
