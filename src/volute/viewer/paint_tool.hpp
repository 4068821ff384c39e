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
  bool pressed = false;    ///< the button is held
  double up = 0;           ///< [pixels] since the last frame
  double seconds = 0;      ///< likewise
};

/// A FogPainter in somebody's hand: strokes begin and end with the button.
class PaintTool {
 public:
  enum class Kind { kAdd, kRemove, kSmooth, kCoefficient };

  /// Takes up a canvas of a document. `opened` counts documents: the strokes of the same map stay.
  void take(const FogCanvas& canvas, std::size_t number, int opened);

  void drop() { painter_.reset(); }

  /// The map goes to this file: if the canvas has its name next, the strokes stay.
  void savesAs(const std::string& file) { savesAs_ = file; }

  bool has() const { return painter_.has_value(); }

  FogPainter& painter() { return *painter_; }

  const FogPainter& painter() const { return *painter_; }

  const FogCanvas& canvas() const { return canvas_; }

  std::size_t number() const { return number_; }

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

  std::optional<Vec2> at() const { return at_; }  ///< where the hand is

  /// True once after take() found strokes that the document does not have.
  bool takeUnsent() { return std::exchange(unsent_, false); }

  Kind kind = Kind::kAdd;
  FogBrush brush{};  ///< its kind follows from `kind`

 private:
  FogCanvas canvas_;
  std::string savesAs_;
  std::size_t number_ = 0;
  int opened_ = -1;
  std::optional<FogPainter> painter_;
  Vec2 origin_ = Vec2::Zero();
  double ground_ = 0, stem_ = 10;
  bool pressed_ = false, unsent_ = false;
  std::optional<Vec2> at_;
  std::optional<FogPlace> held_, hovered_;
};

}  // namespace volute
