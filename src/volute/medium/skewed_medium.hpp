// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <Eigen/LU>
#include <utility>
#include <vector>

#include "volute/medium/any_medium.hpp"

namespace volute {

/// Another medium under any affine map: x in the world is linear * (x in the medium) + offset.
/// Extinction and emission stay per metre of the world. Segments are brought into the medium's own
/// space, where a metre of the world is another length in each direction; so it is as exact as the
/// medium. TurnedMedium is faster where nothing is sheared.
class SkewedMedium {
 public:
  /// @param linear  can be undone
  SkewedMedium(AnyMedium medium, const Mat3& linear, const Vec3& offset)
      : medium_(std::move(medium)), linear_(linear), inverse_(linear.inverse()), offset_(offset) {}

  /// The smallest box along the axes around it; the medium's own box is finite.
  Box3 bounds() const {
    const Box3 own = medium_.bounds();
    Box3 box;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3 point((corner & 1 ? own.max : own.min).x(), (corner & 2 ? own.max : own.min).y(),
                       (corner & 4 ? own.max : own.min).z());
      box.extend(linear_ * point + offset_);
    }
    return box;
  }

  double extinction(const Vec3& point) const { return medium_.extinction(own(point)); }

  Rgb emission(const Vec3& point) const { return medium_.emission(own(point)); }

  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
    std::vector<double> lengths;
    medium_.opticalDepth(own(segments, lengths), depths);
    for (std::size_t i = 0; i < segments.size(); ++i) depths[i] /= lengths[i];
  }

  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const {
    std::vector<double> lengths;
    medium_.pieces(own(segments, lengths), pieces);
    for (std::size_t i = 0; i < segments.size(); ++i) {
      for (Piece& piece : pieces[i]) {
        piece.begin /= lengths[i], piece.end /= lengths[i], piece.decay *= lengths[i];
        stretch(piece.extinction, lengths[i]);
        for (Polynomial& channel : piece.emission) stretch(channel, lengths[i]);
      }
    }
  }

 private:
  /// Of an argument that is `length` times as large.
  static void stretch(Polynomial& polynomial, double length) {
    double power = 1;
    for (double& c : polynomial.c) {
      c *= power;
      power *= length;
    }
  }

  Vec3 own(const Vec3& point) const { return inverse_ * (point - offset_); }

  /// @param lengths  of a metre of each segment, in the medium
  std::vector<Segment> own(std::span<const Segment> segments, std::vector<double>& lengths) const {
    std::vector<Segment> brought(segments.begin(), segments.end());
    for (Segment& segment : brought) {
      segment.origin = own(segment.origin);
      segment.direction = inverse_ * segment.direction;
      const double length = segment.direction.norm();
      segment.direction /= length;
      segment.begin *= length, segment.end *= length;
      lengths.push_back(length);
    }
    return brought;
  }

  AnyMedium medium_;
  Mat3 linear_, inverse_;
  Vec3 offset_;
};

}  // namespace volute
