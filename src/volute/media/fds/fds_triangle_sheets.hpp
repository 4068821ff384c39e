// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "volute/fds/iso_file.hpp"
#include "volute/geometry/triangle_scene.hpp"
#include "volute/medium/medium.hpp"

namespace volute {

/// Triangles as translucent sheets a millimetre thick, as FdsIso has them: a medium. Darker the
/// steeper they stand, smooth from corner to corner. A ray meets 64 of them at most: nothing passes
/// more. Cheap to copy.
class FdsTriangleSheets {
 public:
  static constexpr double kOpacity = 0.4;  ///< share of the light that each sheet takes

  /// @param frames   of the meshes, one triangle at least, with levels that are places in `colours`
  /// @param colours  radiance of what faces up
  [[nodiscard]] static Result<FdsTriangleSheets> build(std::span<const FdsIsoFrame> frames,
                                                       std::span<const Rgb> colours);

  /// Of the sheets, which have a thickness where the triangles lie in a plane.
  Box3 bounds() const;

  /// A sheet has no thickness that a point would find.
  double extinction(const Vec3&) const { return 0; }

  Rgb emission(const Vec3&) const { return Rgb::Zero(); }

  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const;
  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const;
  void radiance(std::span<const Segment> segments, std::span<Radiance> out) const;

  /// Where a segment meets the triangles, ascending.
  std::vector<Hit> crossings(const Segment& segment) const;

 private:
  FdsTriangleSheets() = default;

  Rgb shaded(const Segment& segment, const Hit& hit) const;

  TriangleScene scene_;
  /// Of each triangle's corners: how much the surface faces up there, 0..1.
  std::shared_ptr<const std::vector<std::array<float, 3>>> up_;
};

}  // namespace volute
