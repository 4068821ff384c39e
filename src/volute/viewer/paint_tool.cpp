// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/paint_tool.hpp"

#include <algorithm>
#include <cmath>

namespace volute {
namespace {

constexpr double kFarDown = -1e6;      ///< [m] that counts as no lower end
constexpr double kPixelsForAll = 200;  ///< that a coefficient is dragged from 0 to the largest

FogBrush::Kind brushKind(PaintTool::Kind kind) {
  return kind == PaintTool::Kind::kSmooth   ? FogBrush::Kind::kSmooth
         : kind == PaintTool::Kind::kRemove ? FogBrush::Kind::kRemove
                                            : FogBrush::Kind::kAdd;
}

}  // namespace

void PaintTool::take(const FogCanvas& canvas, int opened) {
  const FogPainter fresh(*canvas.fog, canvas.most);
  const bool sameMap = holds(canvas) &&
                       painter_->coefficients().columns == fresh.coefficients().columns &&
                       painter_->coefficients().rows == fresh.coefficients().rows;
  const bool worked =
      sameMap && (painter_->changed() || painter_->canUndo() || painter_->canRedo());
  const bool stays = worked && (opened_ == opened || painter_->changed());
  if (stays) {
    painter_->rescale(canvas.most, fresh.cell());
    unsent_ = opened_ != opened;  // the file was read again, but the strokes are still wanted
  } else {
    painter_ = fresh;
    if (canvas.unsaved)
      painter_->markUnsaved();
    if (!sameMap)
      brush.radius = std::max(2 * fresh.cell(), 0.06 * fresh.size().minCoeff());
  }
  painter_->place(fresh.origin(), canvas.fog->options().degree);
  painter_->blow(drift_);
  canvas_ = canvas;
  opened_ = opened;
  const Interval heights = canvas.fog->profile().heights();
  const double base = canvas.fog->domainCorner().z();
  const double low = heights.begin > kFarDown ? heights.begin : 0;
  lowest_ = ground_ = base + low;
  stem_ =
      std::clamp(heights.end - low, 0.05 * fresh.size().minCoeff(), 0.25 * fresh.size().minCoeff());
}

void PaintTool::setTime(double time) {
  if (!painter_)
    return;
  drift_ = {time * canvas_.wind.head<2>(), canvas_.border};
  ground_ = lowest_ + time * canvas_.wind.z();
  painter_->blow(drift_);
}

std::optional<Vec2> PaintTool::onGround(const Segment& ray) const {
  const bool above = ray.origin.z() > ground_ || ray.begin < 0;  // a parallel ray begins anywhere
  if (!(ray.direction.z() < 0) || !above)
    return std::nullopt;
  const Vec3 place = ray.at((ground_ - ray.origin.z()) / ray.direction.z());
  return Vec2(place.head<2>());
}

bool PaintTool::hold(const PaintHand& hand) {
  brush.kind = brushKind(kind);
  const bool begins = hand.pressed && !pressed_, ends = !hand.pressed && pressed_;
  pressed_ = hand.pressed;
  onPlan_ = hand.onPlan;
  const auto from = std::exchange(from_, hand.at);
  at_ = hand.at && hand.onPlan ? painter_->blown(*hand.at) : hand.at;
  if (hand.onPlan)
    painter_->blow({});
  hovered_ = hand.at && kind == Kind::kCoefficient ? painter_->nearest(*hand.at) : std::nullopt;
  bool changed = false;
  if (begins) {
    painter_->begin();
    held_ = hovered_;
    heldAt_ = at_;
  }
  if (hand.pressed && kind == Kind::kCoefficient && held_) {
    const double step = hand.up / kPixelsForAll * painter_->most();
    changed = !begins && step != 0 && painter_->set(*held_, painter_->valueOf(*held_) + step);
  } else if (hand.pressed && kind != Kind::kCoefficient && hand.at) {
    changed = painter_->paint(brush, begins || !from ? *hand.at : *from, *hand.at, hand.seconds);
  }
  if (ends) {
    painter_->end();
    held_.reset();
  }
  painter_->blow(drift_);
  return changed;
}

}  // namespace volute
