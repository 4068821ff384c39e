// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <utility>
#include <vector>

#include "volute/base/assert.hpp"
#include "volute/medium/any_medium.hpp"

namespace volute {

/// Another medium, turned or mirrored about the origin and then moved: x in the world is
/// turn * (x in the medium) + offset. Segments are brought into the medium's frame, where their
/// parameters are the same; so it is as exact and as fast as the medium.
class TurnedMedium {
 public:
  /// @param turn  orthogonal: a rotation, or one with a mirror
  TurnedMedium(AnyMedium medium, const Mat3& turn, const Vec3& offset)
      : medium_(std::move(medium)), turn_(turn), offset_(offset) {
    VOLUTE_ASSERT((turn.transpose() * turn - Mat3::Identity()).norm() < 1e-6);
  }

  /// The smallest box along the axes around the turned one.
  Box3 bounds() const {
    const Box3 own = medium_.bounds();
    if (!own.min.allFinite() || !own.max.allFinite()) {
      const Vec3 endless = Vec3::Constant(std::numeric_limits<double>::infinity());
      return {-endless, endless};
    }
    Box3 box;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 point((corner & 1 ? own.max : own.min).x(), (corner & 2 ? own.max : own.min).y(),
                       (corner & 4 ? own.max : own.min).z());
      box.extend(turn_ * point + offset_);
    }
    return box;
  }

  double extinction(const Vec3& point) const { return medium_.extinction(own(point)); }

  Rgb emission(const Vec3& point) const { return medium_.emission(own(point)); }

  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
    medium_.opticalDepth(own(segments), depths);
  }

  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const {
    medium_.pieces(own(segments), pieces);
  }

  void radiance(std::span<const Segment> segments, std::span<Radiance> out) const {
    medium_.radiance(own(segments), out);
  }

 private:
  Vec3 own(const Vec3& point) const { return turn_.transpose() * (point - offset_); }

  std::vector<Segment> own(std::span<const Segment> segments) const {
    std::vector<Segment> turned(segments.begin(), segments.end());
    for (Segment& segment : turned) {
      segment.origin = own(segment.origin);
      segment.direction = turn_.transpose() * segment.direction;
    }
    return turned;
  }

  AnyMedium medium_;
  Mat3 turn_;
  Vec3 offset_;
};

}  // namespace volute
