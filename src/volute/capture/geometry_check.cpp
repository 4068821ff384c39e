// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/capture/geometry_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace volute {
namespace {

/// The volume as a camera sees it.
struct Sight {
  int behind = 0;  ///< of the eight corners
  Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity());
  Vec2 high = Vec2::Constant(-std::numeric_limits<double>::infinity());
};

Sight sightOf(const Box3& bounds, const Camera& camera) {
  Sight sight;
  for (int i = 0; i < 8; ++i) {
    const Vec3 offset = bounds.corner(i) - camera.eye();
    const double depth = offset.dot(camera.forward());
    if (!(depth > 0)) {
      ++sight.behind;
      continue;
    }
    // Without the lens, which may fold far points back into the image.
    const Vec2 place(offset.dot(camera.right()) / depth / camera.pixelWidth(),
                     offset.dot(camera.down()) / depth / camera.pixelSize());
    sight.low = sight.low.cwiseMin(camera.principalPoint() + place);
    sight.high = sight.high.cwiseMax(camera.principalPoint() + place);
  }
  return sight;
}

std::string distanceText(const Camera& camera, const Box3& bounds) {
  return fmt::format(
      "the camera stands {:.4g} m from the centre of a volume of {:.4g} x {:.4g} x "
      "{:.4g} m",
      (bounds.centre() - camera.eye()).norm(), bounds.size().x(), bounds.size().y(),
      bounds.size().z());
}

/// cx and cy that are exchanged are centred in an image with its sides exchanged.
std::optional<std::string> swappedSides(const Camera& camera) {
  constexpr double kNear = 0.03;
  const double width = camera.width(), height = camera.height();
  const Vec2 point = camera.principalPoint();
  const Vec2 offSwapped(std::abs(point.x() / height - 0.5), std::abs(point.y() / width - 0.5));
  const Vec2 off(std::abs(point.x() / width - 0.5), std::abs(point.y() / height - 0.5));
  if (!(offSwapped.maxCoeff() < kNear && off.minCoeff() > 2 * kNear))
    return std::nullopt;
  return fmt::format(
      "the principal point ({:.1f}, {:.1f}) is far off the middle of {} x {} pixels and is the "
      "middle of {} x {}: width and height are swapped",
      point.x(), point.y(), camera.width(), camera.height(), camera.height(), camera.width());
}

/// A principal point in the middle of an image of the same shape, but larger or smaller.
std::optional<std::string> otherResolution(const Camera& camera) {
  constexpr double kSame = 0.06, kLarger = 1.4;
  const double width = camera.width(), height = camera.height();
  const double x = 2 * camera.principalPoint().x() / width;
  const double y = 2 * camera.principalPoint().y() / height;
  if (!(std::abs(x - y) < kSame * x && (x > kLarger || x < 1 / kLarger)))
    return std::nullopt;
  return fmt::format(
      "the principal point ({:.1f}, {:.1f}) is the middle of about {:.0f} x {:.0f} pixels, and the "
      "pictures have {} x {}: scale K with the pictures",
      camera.principalPoint().x(), camera.principalPoint().y(), x * width, y * height,
      camera.width(), camera.height());
}

/// A principal point in a corner of the picture: not filled in, counted from the middle, or of
/// another picture. Each coordinate by itself only where it is that of a border to the digit.
std::optional<std::string> inTheCorner(const Camera& camera) {
  constexpr double kNear = 0.05, kRounding = 1e-6;
  const Vec2 point = camera.principalPoint();
  const Vec2 size(camera.width(), camera.height());
  const auto isBorder = [](double off) {  // in either convention of pixel centres
    return std::abs(off) < kRounding || std::abs(off - 0.5) < kRounding;
  };
  std::array<bool, 2> near{}, at{}, far{};
  for (int axis = 0; axis < 2; ++axis) {
    const double off = size[axis] - point[axis];
    far[axis] = std::abs(off) < std::abs(point[axis]);
    near[axis] = std::min(std::abs(point[axis]), std::abs(off)) < kNear * size[axis];
    at[axis] = isBorder(point[axis]) || isBorder(off);
  }
  const bool corner = near[0] && near[1];
  if ((!corner && !at[0] && !at[1]) || (corner && far[0] && far[1]))
    return std::nullopt;  // the last is the middle of a larger picture
  const bool beyond = (near[0] && far[0]) || (near[1] && far[1]);
  return fmt::format(
      "the principal point ({:.1f}, {:.1f}) lies at the {} of the picture of {} x {} pixels; it is "
      "about the middle, ({:.1f}, {:.1f}), for most cameras: {}",
      point.x(), point.y(), corner ? "corner" : "border", camera.width(), camera.height(),
      0.5 * size.x(), 0.5 * size.y(),
      beyond ? "is it that of a larger picture?" : "was it left out, or counted from the middle?");
}

std::optional<std::string> faultOf(const Camera& camera, const Box3& bounds) {
  constexpr double kTiny = 0.05;
  if (auto corner = inTheCorner(camera))
    return corner;
  if (auto swapped = swappedSides(camera))
    return swapped;
  if (auto other = otherResolution(camera))
    return other;
  if (bounds.contains(camera.eye())) {
    return fmt::format(
        "the camera stands inside the volume, at ({:.4g}, {:.4g}, {:.4g}): are bounds and t in the "
        "same unit, metres?",
        camera.eye().x(), camera.eye().y(), camera.eye().z());
  }
  const Sight sight = sightOf(bounds, camera);
  const double depth = (bounds.centre() - camera.eye()).dot(camera.forward());
  if (sight.behind == 8) {
    return fmt::format(
        "the volume lies behind the camera, its centre {:.4g} m behind: R and t take world points "
        "to the camera (x right, y down, z forward); were they inverted?",
        -depth);
  }
  if (sight.behind > 0)
    return std::nullopt;
  if (sight.high.x() <= 0 || sight.high.y() <= 0 || sight.low.x() >= camera.width() ||
      sight.low.y() >= camera.height()) {
    return fmt::format(
        "the volume lies outside the image: it would appear at x {:.0f} to {:.0f}, y {:.0f} to "
        "{:.0f} of {} x {} pixels; check R, t and the bounds",
        sight.low.x(), sight.high.x(), sight.low.y(), sight.high.y(), camera.width(),
        camera.height());
  }
  const double extent = (sight.high - sight.low).maxCoeff();
  if (extent < kTiny * std::max(camera.width(), camera.height())) {
    return fmt::format(
        "the volume covers only {:.1f} of {} pixels: {}; is one of them in centimetres or "
        "millimetres?",
        extent, std::max(camera.width(), camera.height()), distanceText(camera, bounds));
  }
  return std::nullopt;
}

}  // namespace

std::vector<GeometryFault> checkGeometry(const Capture& capture) {
  std::vector<GeometryFault> faults;
  for (const CaptureCamera& camera : capture.cameras) {
    if (auto message = faultOf(camera.camera, capture.volume.bounds))
      faults.push_back({camera.name, fmt::format("camera {}: {}", camera.name, *message)});
  }
  return faults;
}

}  // namespace volute
