// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include "volute/medium/conformance_checks.hpp"

namespace volute::conformance {

/// Where a fault may sit. What is not set stays as it was.
struct Fault {
  std::string name;
  std::function<Segment(Segment)> segment{};  ///< on the way in, for every call
  std::function<double(const Segment&, double)> depth{};
  std::function<void(const Segment&, std::vector<Piece>&)> pieces{};
  std::function<void(const Segment&, Radiance&)> radiance{};
  std::function<double(const Vec3&, double)> point{};  ///< extinction at a point
  std::function<Box3(Box3)> bounds{};
  std::function<void(std::span<double>)> depthBatch{};  ///< over the answers to a whole batch
  std::function<std::vector<double>(std::vector<double>)>
      coefficients{};  ///< on the way into withCoefficients
  bool appendsPieces = false;
  bool depthByPieces = false;  ///< the fault of the pieces is in the depth as well, so both agree
};

/// A good medium with one fault.
template <LinearMedium M>
class Faulty {
 public:
  Faulty(M medium, Fault fault) : medium_(std::move(medium)), fault_(std::move(fault)) {}

  Box3 bounds() const { return fault_.bounds ? fault_.bounds(medium_.bounds()) : medium_.bounds(); }

  double extinction(const Vec3& point) const {
    const double value = medium_.extinction(point);
    return fault_.point ? fault_.point(point, value) : value;
  }

  Rgb emission(const Vec3& point) const { return medium_.emission(point); }

  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
    for (std::size_t i = 0; i < segments.size(); ++i) {
      const Segment segment = changed(segments[i]);
      if (fault_.depthByPieces) {
        depths[i] = 0;
        for (const Piece& piece : piecesOf(segments[i])) depths[i] += pieceOpticalDepth(piece);
      } else {
        medium_.opticalDepth({&segment, 1}, depths.subspan(i, 1));
      }
      if (fault_.depth)
        depths[i] = fault_.depth(segments[i], depths[i]);
    }
    if (fault_.depthBatch)
      fault_.depthBatch(depths);
  }

  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const {
    for (std::size_t i = 0; i < segments.size(); ++i) {
      if (!fault_.appendsPieces)
        pieces[i].clear();
      for (const Piece& piece : piecesOf(segments[i])) pieces[i].push_back(piece);
    }
  }

  void radiance(std::span<const Segment> segments, std::span<Radiance> out) const {
    for (std::size_t i = 0; i < segments.size(); ++i) {
      out[i] = composite(piecesOf(segments[i]));
      if (fault_.radiance)
        fault_.radiance(segments[i], out[i]);
    }
  }

  std::vector<double> coefficients() const { return medium_.coefficients(); }

  Faulty withCoefficients(std::span<const double> coefficients) const {
    std::vector<double> changed(coefficients.begin(), coefficients.end());
    if (fault_.coefficients)
      changed = fault_.coefficients(changed);
    return Faulty(medium_.withCoefficients(changed), fault_);
  }

 private:
  Segment changed(const Segment& segment) const {
    return fault_.segment ? fault_.segment(segment) : segment;
  }

  std::vector<Piece> piecesOf(const Segment& segment) const {
    const Segment changedSegment = changed(segment);
    std::vector<Piece> pieces;
    medium_.pieces({&changedSegment, 1}, {&pieces, 1});
    if (fault_.pieces)
      fault_.pieces(segment, pieces);
    return pieces;
  }

  M medium_;
  Fault fault_;
};

}  // namespace volute::conformance
