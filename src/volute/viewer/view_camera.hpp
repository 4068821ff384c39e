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

  /// Sees all of the bounds, from the side that is up as it is.
  void frame(const Box3& bounds, int width, int height);

  void set(const StartView& view);

  Mode mode() const { return mode_; }

  void setMode(Mode mode) { mode_ = mode; }

  /// The mouse was dragged by so many pixels: around the target, or the head turns.
  void drag(double right, double down);

  /// Moves the eye and the target across the picture by so many pixels of one of `height`.
  void pan(double right, double down, int height);

  /// Wheel clicks: nearer, or (walking) forward.
  void zoom(double clicks);

  /// Walks so many metres, at the level of the eye.
  void walk(double forward, double right, double up);

  Camera camera(int width, int height) const;

  StartView view() const { return {eye_, target(), upwards(), fov_, ortho_}; }

  bool operator==(const ViewCamera&) const = default;

  Vec3 eye() const { return eye_; }

  double distance() const { return distance_; }  ///< to the target [m]

  double fov() const { return fov_; }

  void setFov(double degrees);

  bool parallel() const { return ortho_ > 0; }

  double ortho() const { return ortho_; }  ///< [m], the height of its view volume; 0: a pinhole

  void setOrtho(double height);  ///< of a parallel one [m], > 0

  /// Towards the side that is up, of unit length.
  Vec3 upwards() const { return frame_.col(2); }

 private:
  Vec3 forward() const;
  Vec3 right() const;

  Vec3 target() const { return eye_ + distance_ * forward(); }

  Mode mode_ = Mode::kOrbit;
  Vec3 eye_ = Vec3(0, -3, 0);
  Mat3 frame_ = Mat3::Identity();  ///< in columns: two directions that are level, and up
  double yaw_ = 0;                 ///< 0 looks along the second of them, grows to the left
  double pitch_ = 0;               ///< up
  double distance_ = 3;
  double fov_ = 40;
  double ortho_ = 0;
};

}  // namespace volute
