// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "volute/camera/camera.hpp"
#include "volute/viewer/document.hpp"
#include "volute/viewer/fog_painter.hpp"

namespace volute {

/// What a hand does over a map of fog between two frames, in the 3D view or in the plan.
struct PaintHand {
  std::optional<Vec2> at;  ///< on the ground [m]; nothing: elsewhere
  bool onPlan = false;     ///< `at` is on the map as it lies in calm air
  bool pressed = false;    ///< the button is held
  double up = 0;           ///< [pixels] since the last frame
  double seconds = 0;      ///< likewise
};

/// A FogPainter in somebody's hand: strokes begin and end with the button.
class PaintTool {
 public:
  enum class Kind { kAdd, kRemove, kSmooth, kCoefficient };

  /// Takes up a canvas of a document. `opened` counts documents: the strokes of the same map stay.
  void take(const FogCanvas& canvas, int opened);

  /// Whether it holds the map of this canvas.
  bool holds(const FogCanvas& canvas) const {
    return painter_ && (canvas_.file == canvas.file || savesAs_ == canvas.file);
  }

  void drop() { painter_.reset(); }

  /// The map goes to this file: if the canvas has its name next, the strokes stay.
  void savesAs(const std::string& file) { savesAs_ = file; }

  bool has() const { return painter_.has_value(); }

  FogPainter& painter() { return *painter_; }

  const FogPainter& painter() const { return *painter_; }

  const FogCanvas& canvas() const { return canvas_; }

  /// Where the map lies at a time of the document [s]; wind blows it.
  void setTime(double time);

  /// Where a ray meets the ground of the fog.
  std::optional<Vec2> onGround(const Segment& ray) const;

  double ground() const { return ground_; }  ///< [m], its height

  /// How high a coefficient of the map's largest value is drawn [m].
  double stem() const { return stem_; }

  /// True if the map changed.
  bool hold(const PaintHand& hand);

  /// Which coefficient is under the hand or held by it.
  std::optional<FogPlace> held() const { return held_ ? held_ : hovered_; }

  /// Where that is, or was when it was taken [m].
  std::optional<Vec2> heldAt() const { return held_ ? heldAt_ : hovered_ ? at_ : std::nullopt; }

  std::optional<Vec2> at() const { return at_; }  ///< where the hand is in the scene [m]

  /// Whether a stroke on the plan goes on.
  bool onPlan() const { return pressed_ && onPlan_; }

  /// True once after take() found strokes that the document does not have.
  bool takeUnsent() { return std::exchange(unsent_, false); }

  Kind kind = Kind::kAdd;
  FogBrush brush{};  ///< its kind follows from `kind`

 private:
  FogCanvas canvas_;
  std::string savesAs_;
  int opened_ = -1;
  std::optional<FogPainter> painter_;
  FogDrift drift_;
  double lowest_ = 0, ground_ = 0, stem_ = 10;  ///< lowest_: the ground in calm air
  bool pressed_ = false, onPlan_ = false, unsent_ = false;
  std::optional<Vec2> at_, from_, heldAt_;  ///< from_: where the hand was, as it said
  std::optional<FogPlace> held_, hovered_;
};

}  // namespace volute
