// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/render/billboard.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "volute/render/render.hpp"

namespace volute {
namespace {

constexpr int kMaxColumns = 4096;           ///< of a texture
constexpr double kThickness = 1e-4;         ///< of the height
constexpr double kMinTransmittance = 1e-7;  ///< so that the extinction stays finite

/// Four channels between four texels; beyond the outer centres it is theirs.
std::array<double, 4> bilinear(const Image& texture, double across, double down) {
  const double x = std::clamp(across * texture.width - 0.5, 0.0, texture.width - 1.0);
  const double y = std::clamp(down * texture.height - 0.5, 0.0, texture.height - 1.0);
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const int x1 = std::min(x0 + 1, texture.width - 1), y1 = std::min(y0 + 1, texture.height - 1);
  const double u = x - x0, v = y - y0;
  std::array<double, 4> value;
  for (int c = 0; c < 4; ++c) {
    value[c] = (1 - v) * ((1 - u) * texture.at(x0, y0, c) + u * texture.at(x1, y0, c)) +
               v * ((1 - u) * texture.at(x0, y1, c) + u * texture.at(x1, y1, c));
  }
  return value;
}

}  // namespace

Camera billboardView(const Box3& volume, const Camera& camera, const BillboardOptions& options) {
  const Vec3 way = options.position - camera.eye();
  const bool faces = !camera.isOrthographic() && way.norm() > 0;
  const Vec3 forward = faces ? Vec3(way.normalized()) : camera.forward();
  const Box3& bounds = options.shown.empty() ? volume : options.shown;
  const double shape = options.width / options.height;
  const int rows = std::clamp(static_cast<int>(std::lround(std::min(kMaxColumns / shape, 1e9))), 1,
                              std::max(options.rows, 1));
  const int columns = std::max(
      1, static_cast<int>(std::lround(std::min(rows * shape, static_cast<double>(kMaxColumns)))));
  const Vec3 middle = bounds.centre();
  return Camera::orthographic({middle - bounds.size().norm() * forward, middle, -camera.down()},
                              bounds.size().z(), columns, rows);
}

Result<Billboard> Billboard::draw(const AnyMedium& volume, const Camera& camera,
                                  const BillboardOptions& options, Progress& progress) {
  if (!(options.width > 0) || !(options.height > 0) || options.rows < 1) {
    return fail(ErrorCode::kInvalidArgument,
                "a billboard of {} x {} m with {} rows; expected a size of more than 0",
                options.width, options.height, options.rows);
  }
  Billboard board;
  board.options_ = options;
  const Camera view = billboardView(volume.bounds(), camera, options);
  board.right_ = view.right(), board.down_ = view.down(), board.forward_ = view.forward();
  board.thickness_ = kThickness * options.height;
  RenderOptions clear;
  VOLUTE_ASSIGN(const auto light, render(view, {&volume, 1}, clear, progress));
  clear.aov = Aov::kTransmittance;
  VOLUTE_ASSIGN(const auto passed, render(view, {&volume, 1}, clear, progress));
  auto texture = std::make_shared<Image>(view.width(), view.height(), 4);
  for (int y = 0; y < texture->height; ++y) {
    for (int x = 0; x < texture->width; ++x) {
      float brightest = 0;
      for (int c = 0; c < 3; ++c) {
        texture->at(x, y, c) = light.at(x, y, c);
        brightest = std::max(brightest, light.at(x, y, c));
      }
      texture->at(x, y, 3) = options.alpha == BillboardAlpha::kIntensity
                                 ? 1 - std::min(brightest, 1.0f)
                                 : passed.at(x, y);
    }
  }
  board.texture_ = std::move(texture);
  return board;
}

Box3 Billboard::bounds() const {
  Box3 box;
  for (int corner = 0; corner < 8; ++corner) {
    const auto sign = [&](int bit) { return corner & bit ? 0.5 : -0.5; };
    box.extend(options_.position + sign(1) * options_.width * right_ +
               sign(2) * options_.height * down_ + sign(4) * thickness_ * forward_);
  }
  return box;
}

Interval Billboard::crossing(const Segment& segment, double& across, double& down) const {
  const double speed = segment.direction.dot(forward_);
  if (speed == 0)
    return {};
  const double middle = (options_.position - segment.origin).dot(forward_) / speed;
  const Vec3 place = segment.at(middle) - options_.position;
  across = place.dot(right_) / options_.width + 0.5;
  down = place.dot(down_) / options_.height + 0.5;
  if (!(across >= 0 && across <= 1 && down >= 0 && down <= 1))
    return {};
  const double half = 0.5 * thickness_ / std::abs(speed);
  return {middle - half, middle + half};
}

Billboard::Sheet Billboard::at(double across, double down, double length) const {
  const auto texel = bilinear(*texture_, across, down);
  const double passed = std::clamp(texel[3], kMinTransmittance, 1.0);
  const double depth = -std::log(passed);
  // Light emitted evenly and absorbed on its way: emission * length * (1 - e^-depth) / depth.
  const double left = depth > 1e-9 ? (1 - passed) / depth : 1;
  return {depth / length, Rgb(texel[0], texel[1], texel[2]) / (left * length)};
}

double Billboard::extinction(const Vec3& point) const {
  double across = 0, down = 0;
  const Segment through{point, forward_, 0, 0};
  const Interval part = crossing(through, across, down);
  return part.begin <= 0 && part.end >= 0 && !part.empty() ? at(across, down, thickness_).extinction
                                                           : 0;
}

Rgb Billboard::emission(const Vec3& point) const {
  double across = 0, down = 0;
  const Segment through{point, forward_, 0, 0};
  const Interval part = crossing(through, across, down);
  return part.begin <= 0 && part.end >= 0 && !part.empty() ? at(across, down, thickness_).emission
                                                           : Rgb::Zero();
}

void Billboard::opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
  for (std::size_t i = 0; i < segments.size(); ++i) {
    double across = 0, down = 0;
    const Interval whole = crossing(segments[i], across, down);
    const Interval part = whole.intersect({segments[i].begin, segments[i].end});
    depths[i] = part.empty() ? 0 : at(across, down, whole.length()).extinction * part.length();
  }
}

void Billboard::pieces(std::span<const Segment> segments,
                       std::span<std::vector<Piece>> pieces) const {
  for (std::size_t i = 0; i < segments.size(); ++i) {
    pieces[i].clear();
    double across = 0, down = 0;
    const Interval whole = crossing(segments[i], across, down);
    const Interval part = whole.intersect({segments[i].begin, segments[i].end});
    if (part.empty())
      continue;
    const Sheet sheet = at(across, down, whole.length());
    Piece piece;
    piece.begin = part.begin, piece.end = part.end;
    piece.extinction.c[0] = sheet.extinction;
    for (int c = 0; c < 3; ++c) piece.emission[c].c[0] = sheet.emission[c];
    pieces[i].push_back(piece);
  }
}

}  // namespace volute
