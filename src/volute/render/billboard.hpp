// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/base/result.hpp"
#include "volute/camera/camera.hpp"
#include "volute/image/image.hpp"
#include "volute/medium/any_medium.hpp"

namespace volute {

/// How a billboard's alpha is used.
enum class BillboardAlpha {
  kTransmittance,  ///< what the medium lets through
  /// 1 - the brightest channel, clipped to 0..1: how fire, which does not absorb, hides a bright
  /// background (Ahrenberg et al. 2005, section 5.2)
  kIntensity,
};

struct BillboardOptions {
  Vec3 position = Vec3::Zero();  ///< of its middle [m]
  double width = 1;              ///< [m]
  double height = 1;             ///< [m]
  /// Of the texture; its columns follow from the shape. Fewer where these would be more than 4096.
  int rows = 256;
  BillboardAlpha alpha = BillboardAlpha::kTransmittance;
  Box3 shown{};  ///< of the volume; its height becomes the billboard's. Empty: the volume's bounds
};

/// The camera that draws a billboard's texture: parallel rays through the middle of the volume,
/// along the line from the eye to the billboard.
Camera billboardView(const Box3& volume, const Camera& camera, const BillboardOptions& options);

/// A volume drawn on a flat rectangle that faces the camera (Ahrenberg et al. 2005, section 5.2):
/// seen from the camera's side by parallel rays into a texture, without changing its shape: its
/// height fills the billboard's, its width as much as fits. Cheap to look at, and right where the
/// volume is small or far.
///
/// A Medium: a sheet 1e-4 of its height thick that sends and lets through what the texture says,
/// bilinear between texels; so it is in the right order among surfaces and other media.
class Billboard {
 public:
  /// kInvalidArgument for a size that is not positive; kCancelled when `progress` said so.
  [[nodiscard]] static Result<Billboard> draw(const AnyMedium& volume, const Camera& camera,
                                              const BillboardOptions& options, Progress& progress);

  Box3 bounds() const;
  double extinction(const Vec3& point) const;
  Rgb emission(const Vec3& point) const;
  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const;
  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const;

  /// Light and, in the fourth channel, transmittance; row 0 is the top. shape (rows, columns, 4)
  const Image& texture() const { return *texture_; }

 private:
  struct Sheet {
    double extinction = 0;
    Rgb emission = Rgb::Zero();
  };

  /// At a place of the rectangle, both from 0 to 1; for a way of `length` through the sheet.
  Sheet at(double across, double down, double length) const;
  /// Where a segment crosses the sheet; empty where it misses.
  Interval crossing(const Segment& segment, double& across, double& down) const;

  BillboardOptions options_;
  Vec3 right_, down_, forward_;  ///< of unit length
  double thickness_ = 0;
  std::shared_ptr<const Image> texture_;
};

}  // namespace volute
