// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <utility>
#include <vector>

#include "volute/medium/any_medium.hpp"

namespace volute {

/// x in the world is linear * (x in a space of its own) + offset.
class AffineMap {
 public:
  AffineMap() = default;

  /// @param linear  can be undone
  AffineMap(const Mat3& linear, const Vec3& offset)
      : linear_(linear), inverse_(linear.inverse()), offset_(offset) {}

  const Mat3& linear() const { return linear_; }

  const Mat3& inverse() const { return inverse_; }

  Vec3 toWorld(const Vec3& own) const { return linear_ * own + offset_; }

  Vec3 toOwn(const Vec3& world) const { return inverse_ * (world - offset_); }

  /// Parameters stay metres of the world: the direction has another length where the map does not
  /// keep lengths.
  Segment toOwn(const Segment& world) const {
    return {toOwn(world.origin), inverse_ * world.direction, world.begin, world.end};
  }

  /// The smallest box along the world's axes around one along its own.
  Box3 around(const Box3& own) const {
    if (!own.min.allFinite() || !own.max.allFinite()) {
      const Vec3 endless = Vec3::Constant(std::numeric_limits<double>::infinity());
      return {-endless, endless};
    }
    Box3 box;
    for (int corner = 0; corner < 8; ++corner) box.extend(toWorld(own.corner(corner)));
    return box;
  }

  /// It turns, mirrors and moves, and nothing else.
  bool keepsLengths() const {
    constexpr double kRight = 1e-7;
    return (linear_.transpose() * linear_ - Mat3::Identity()).cwiseAbs().maxCoeff() <= kRight;
  }

  bool isIdentity() const { return linear_ == Mat3::Identity() && offset_ == Vec3::Zero(); }

 private:
  Mat3 linear_ = Mat3::Identity(), inverse_ = Mat3::Identity();
  Vec3 offset_ = Vec3::Zero();
};

/// Another medium under an affine map. Extinction and emission are per metre of the world: segments
/// are brought into the medium's space, where their parameters stay metres of the world. So it is
/// as exact and as fast as the medium, which must not rely on directions of unit length: media of
/// voxels do not.
class AffineMedium {
 public:
  AffineMedium(AnyMedium medium, const AffineMap& map) : medium_(std::move(medium)), map_(map) {}

  Box3 bounds() const { return map_.around(medium_.bounds()); }

  double extinction(const Vec3& point) const { return medium_.extinction(map_.toOwn(point)); }

  Rgb emission(const Vec3& point) const { return medium_.emission(map_.toOwn(point)); }

  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
    medium_.opticalDepth(own(segments), depths);
  }

  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const {
    medium_.pieces(own(segments), pieces);
  }

  void radiance(std::span<const Segment> segments, std::span<Radiance> out) const {
    medium_.radiance(own(segments), out);
  }

  bool dependsOnEnd() const { return medium_.dependsOnEnd(); }

 private:
  std::vector<Segment> own(std::span<const Segment> segments) const {
    std::vector<Segment> brought;
    brought.reserve(segments.size());
    for (const Segment& segment : segments) brought.push_back(map_.toOwn(segment));
    return brought;
  }

  AnyMedium medium_;
  AffineMap map_;
};

}  // namespace volute
