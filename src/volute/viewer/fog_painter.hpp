// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "volute/camera/lens.hpp"
#include "volute/fog/fog_map.hpp"
#include "volute/fog/fog_medium.hpp"
#include "volute/image/image.hpp"
#include "volute/media/fog/fog_file.hpp"

namespace volute {

/// What is held in a hand over a map of fog.
struct FogBrush {
  enum class Kind {
    kAdd,
    kRemove,
    kSmooth,  ///< moves every coefficient towards the mean of those around it
  };

  Kind kind = Kind::kAdd;
  double radius = 10;  ///< [m], > 0
  /// How much in a second at the brush's middle: share of the map's largest value, or of the way to
  /// the mean.
  double strength = 0.5;
  double softness = 1;  ///< 0: as strong up to the rim; 1: fades from the middle to the rim

  /// 0..1, at a distance from the middle [m].
  double weight(double distance) const;
};

/// A coefficient of a map.
struct FogPlace {
  int column = 0, row = 0;  ///< row 0 at the smallest y

  bool operator==(const FogPlace&) const = default;
};

/// Where the wind has blown a map, and what it brings in.
struct FogDrift {
  Vec2 by = Vec2::Zero();  ///< [m]
  FogBorder border = FogBorder::kZero;
};

/// Where a coefficient of a map that drifts is shown.
struct FogPeak {
  FogPlace place;
  Vec2 at;  ///< where it has most weight [m]
};

/// Paints the coefficients of a map of fog (Giroud and Biri 2010, section 5): strokes of a brush,
/// and single coefficients. Values stay within 0 and the map's largest. Strokes can be undone.
class FogPainter {
 public:
  /// @param origin  [m] of the corner x = y = 0; see FogMap for what the numbers mean
  /// @param degree  of the splines
  /// @param most  [1/m] > 0, the extinction of a pixel of value 1
  FogPainter(SplineGrid coefficients, const Vec2& origin, double cell, int degree, double most);

  /// The map of a fog as it is.
  FogPainter(const FogMedium& fog, double most);

  const SplineGrid& coefficients() const { return grid_; }  ///< [1/m]

  double most() const { return most_; }  ///< [1/m]

  double cell() const { return cell_; }  ///< [m]

  /// The map lies elsewhere, or has splines of another degree.
  void place(const Vec2& origin, int degree);

  /// The map is where the wind has blown it: what is painted goes to the coefficients shown there.
  void blow(const FogDrift& drift) { drift_ = drift; }

  /// The same map with another largest value [1/m] and cell [m]: values, and those that undo()
  /// gives back, are shares of the largest.
  void rescale(double most, double cell);

  /// What the map covers in calm air [m], from its corner of least coordinates.
  Vec2 origin() const { return origin_; }

  Vec2 size() const;

  /// Where a coefficient has most weight in calm air [m].
  Vec2 peakOf(const FogPlace& place) const;

  /// The coefficient shown nearest, if `at` [m] is on the map.
  std::optional<FogPlace> nearest(const Vec2& at) const;

  /// Those shown around `at` [m], so many to each side of the nearest.
  std::vector<FogPeak> around(const Vec2& at, int cells) const;

  /// Where a point of the map in calm air is now [m].
  Vec2 blown(const Vec2& calm) const;

  double valueOf(const FogPlace& place) const { return grid_.at(place.column, place.row); }

  /// What belongs together for undo() begins here. Without it each call is one by itself.
  void begin();
  void end();

  /// The brush moves from one point to another [m] in so many seconds. True if anything changed.
  bool paint(const FogBrush& brush, const Vec2& from, const Vec2& to, double seconds);

  /// One coefficient [1/m], clamped.
  bool set(const FogPlace& place, double value);

  /// All coefficients [1/m].
  bool fill(double value);

  bool canUndo() const { return !past_.empty(); }

  bool canRedo() const { return !future_.empty(); }

  bool undo();
  bool redo();

  /// As a picture of fog maps: 0..1, row 0 at the largest y.
  Image picture() const;

  /// Whether it differs from what was saved last, or from what it began with; so it does in the
  /// middle of a stroke.
  bool changed() const { return begun_.has_value() || version_ != savedVersion_; }

  /// Of what it is now, and of nothing that is painted later.
  std::size_t version() const { return version_; }

  void markSaved(std::size_t version) { savedVersion_ = version; }

  /// What it began with is in no file.
  void markUnsaved() { savedVersion_ = kNever; }

 private:
  /// A rectangle of coefficients before and after.
  struct Step {
    int column = 0, row = 0, columns = 0, rows = 0;
    std::vector<double> before, after;
    std::size_t versionBefore = 0, versionAfter = 0;
  };

  static constexpr std::size_t kNever = static_cast<std::size_t>(-1);

  struct Shown;
  Shown shown(int axis) const;
  bool covers(const Vec2& at) const;
  std::vector<std::pair<std::size_t, double>> under(const FogBrush& brush, const Vec2& at) const;
  bool dab(const FogBrush& brush, const Vec2& at, double seconds);
  double meanAround(int i, int j) const;
  void apply(const Step& step, const std::vector<double>& values);

  SplineGrid grid_;
  Vec2 origin_;
  double cell_;
  int degree_;
  double most_;
  FogDrift drift_;
  std::optional<SplineGrid> begun_;  ///< the map when the stroke began
  std::deque<Step> past_;
  std::vector<Step> future_;
  std::size_t version_ = 0, savedVersion_ = 0, versions_ = 0;
};

}  // namespace volute
