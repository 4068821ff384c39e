// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/panel_layout.hpp"

#include <algorithm>

namespace volute {
namespace {

constexpr float kWide = 860;  ///< from here on a third of the width is free between both sides
constexpr float kTall = 850;  ///< from here on there is enough of the picture below them
constexpr float kMin[] = {250, 250, 280};  ///< width, with all that is written in it
constexpr float kMax[] = {300, 300, 310};
constexpr float kShare[] = {0.235F, 0.235F, 0.245F};  ///< of the window

}  // namespace

void PanelLayout::fit(float width, float height, float below, bool held) {
  const bool same = roomy_ && width == width_ && height == height_;
  still_ = same && (held || held_);
  held_ = held;
  if (still_)
    return;
  width_ = width, height_ = height;
  free_ = height - 2 * kPanelMargin - below;
  const bool roomy = width >= kWide || height >= kTall;
  if (roomy_ != roomy) {
    roomy_ = roomy;
    of(SidePanel::kPicture).open = of(SidePanel::kScene).open = roomy;
    of(SidePanel::kPaint).open = false;
    last_ = SidePanel::kPicture;
  }
  closeWhatDoesNotFit();
}

void PanelLayout::set(SidePanel panel, bool open) {
  of(panel).open = open;
  if (!open)
    return;
  last_ = panel;
  closeWhatDoesNotFit();
}

void PanelLayout::closeWhatDoesNotFit() {
  if (!roomy()) {
    for (const SidePanel panel : {SidePanel::kPicture, SidePanel::kPaint, SidePanel::kScene}) {
      if (panel != last_)
        of(panel).open = false;
    }
    return;
  }
  Of &upper = of(SidePanel::kPicture), &lower = of(SidePanel::kPaint);
  if (!upper.open || !lower.open || upper.height + kPanelGap + lower.height <= free_)
    return;
  (last_ == SidePanel::kPaint ? upper : lower).open = false;
}

void PanelLayout::measure(SidePanel panel, float height) {
  if (!still_)
    of(panel).height = height;
}

float PanelLayout::lowerTop(float above) {
  if (!still_)
    lowerTop_ = above + kPanelGap;
  return lowerTop_;
}

float PanelLayout::width(SidePanel panel) const {
  const auto i = static_cast<std::size_t>(panel);
  return std::clamp(kShare[i] * width_, kMin[i], kMax[i]);
}

float PanelLayout::shownWidth(SidePanel panel) const {
  if (isOpen(panel))
    return width(panel);
  const float free = width_ - 2 * kPanelMargin - kPanelGap;
  float others = free / 2;
  for (const SidePanel other : {SidePanel::kPicture, SidePanel::kPaint, SidePanel::kScene}) {
    if (isOpen(other) && (other == SidePanel::kScene) != (panel == SidePanel::kScene))
      others = std::max(others, width(other));
  }
  return std::min(width(panel), free - others);
}

float PanelLayout::most(SidePanel panel) const {
  const Of &upper = of(SidePanel::kPicture), &lower = of(SidePanel::kPaint);
  const auto taken = [](const Of& other) {
    return other.height <= 0 ? 0 : kPanelGap + (other.open ? other.height : kTitle);
  };
  const float rest = panel == SidePanel::kPicture ? free_ - taken(lower)
                     : panel == SidePanel::kPaint ? free_ - taken(upper)
                                                  : free_;
  return std::max(rest, kTitle);
}

}  // namespace volute
