// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>

#include "volute/geometry/triangle_scene.hpp"

namespace volute {

/// Embree over the same triangles: it finds candidates in single precision, near the scene's middle
/// so that they are as good as they can be; whether and where a segment meets one is decided in
/// double from the triangle's plane.
class EmbreeScene {
 public:
  /// The triangles must outlive it; null when Embree refuses, as when there is no memory.
  static std::unique_ptr<const EmbreeScene> make(std::span<const Triangle> triangles,
                                                 const Box3& bounds);
  ~EmbreeScene();

  Hit nearest(const Segment& segment) const;
  /// The same for each, in packets: those that lie side by side cost least.
  void nearest(std::span<const Segment> segments, std::span<Hit> hits) const;
  bool occluded(const Segment& segment) const;

 private:
  struct Impl;
  explicit EmbreeScene(std::unique_ptr<const Impl> impl);
  std::unique_ptr<const Impl> impl_;
};

}  // namespace volute
