// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/camera/camera.hpp"
#include "volute/viewer/document.hpp"

namespace volute {

/// The viewer's camera: turns around a point, or walks from where it is; a pinhole or parallel. It
/// stays upright, along what it was told is up.
class ViewCamera {
 public:
  enum class Mode { kOrbit, kWalk };

  /// Parts of the picture that panels cover, from its borders [pixels].
  struct Insets {
    double left = 0, top = 0, right = 0, bottom = 0;
  };

  /// Sees all of the bounds between the insets, from the side that is up as it is.
  void frame(const Box3& bounds, int width, int height, const Insets& insets);

  /// Moves, without turning, to where the corners of the bounds just are between the insets.
  void fit(const Box3& bounds, int width, int height, const Insets& insets);

  void set(const StartView& view);

  Mode mode() const { return mode_; }

  void setMode(Mode mode) { mode_ = mode; }

  /// The mouse was dragged by so many pixels: around the target, or the head turns.
  void drag(double right, double down);

  /// Around the axis that is up through the pivot, to the left [rad].
  void turn(double angle);

  /// Moves the eye and the target across the picture by so many pixels of one of `height`.
  void pan(double right, double down, int height);

  /// Wheel clicks: nearer, or (walking) forward. `towards`: a point that stays where it is in the
  /// picture [m].
  void zoom(double clicks, const Vec3& towards);

  /// Turns around this point from now on.
  void setPivot(const Vec3& point);

  const Vec3& pivot() const { return pivot_; }

  /// Looks along this direction, which may be straight down, at the pivot as far away as now.
  void lookAlong(const Vec3& direction);

  Vec3 forward() const;
  Vec3 right() const;

  /// Walks so many metres, at the level of the eye.
  void walk(double forward, double right, double up);

  Camera camera(int width, int height) const;

  /// Its direction upwards has unit length.
  StartView view() const { return {eye_, target(), frame_.col(2), fov_, ortho_}; }

  bool operator==(const ViewCamera&) const = default;

  Vec3 eye() const { return eye_; }

  double distance() const { return distance_; }  ///< to the target [m]

  double fov() const { return fov_; }

  void setFov(double degrees);

  double ortho() const { return ortho_; }  ///< [m], the height of its view volume; 0: a pinhole

  void setOrtho(double height);  ///< of a parallel one [m], > 0

  /// From a pinhole to parallel rays or back; what is at the pivot stays as large as it is.
  void toggleParallel();

 private:
  void walkBy(const Vec3& step);
  Mat3 turned() const;  ///< right, forward and up in columns

  Vec3 target() const { return eye_ + distance_ * forward(); }

  Mode mode_ = Mode::kOrbit;
  Vec3 eye_ = Vec3(0, -3, 0);
  Mat3 frame_ = Mat3::Identity();  ///< in columns: two directions that are level, and up
  double yaw_ = 0;                 ///< 0 looks along the second of them, grows to the left
  double pitch_ = 0;               ///< up
  double distance_ = 3;
  Vec3 pivot_ = Vec3::Zero();  ///< turned around
  double fov_ = 40;
  double ortho_ = 0;
};

}  // namespace volute
