// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/media/ray_sight.hpp"

namespace volute {
namespace {

Segment lineSegment(const SightLine& line) {
  const double length = line.length();
  const Vec3 direction = length > 0 ? Vec3((line.target - line.eye) / length) : Vec3::UnitX();
  return {line.eye, direction, 0, length};
}

class RaySightSnapshot final : public BasicSightSnapshot {
 public:
  explicit RaySightSnapshot(std::vector<AnyMedium> media) : media_(std::move(media)) {}

  void look(std::span<const SightLine> lines, std::span<Sight> sights) const override {
    std::vector<Segment> segments;
    for (const SightLine& line : lines) segments.push_back(lineSegment(line));
    std::vector<double> depths(lines.size());
    for (Sight& sight : sights) sight = {};
    for (const AnyMedium& medium : media_) {
      medium.opticalDepth(segments, depths);
      for (std::size_t i = 0; i < depths.size(); ++i) sights[i].depth += depths[i];
    }
    for (Sight& sight : sights) sight.low = sight.high = sight.depth;
  }

  void places(std::span<const Vec3> points, std::span<Place> places) const override {
    for (std::size_t i = 0; i < points.size(); ++i) places[i] = Place::kGas;
  }

  void extinction(std::span<const Vec3> points, std::span<double> extinction) const override {
    for (std::size_t i = 0; i < points.size(); ++i) {
      extinction[i] = 0;
      for (const AnyMedium& medium : media_) extinction[i] += medium.extinction(points[i]);
    }
  }

 private:
  std::vector<AnyMedium> media_;
};

}  // namespace

std::string RaySight::description() const {
  return fmt::format("{}: {}, along rays", medium_->info().file, medium_->info().what);
}

Result<std::shared_ptr<const SightSnapshot>> RaySight::readOwnAt(double time) {
  Progress quiet;
  VOLUTE_ASSIGN(const auto now, medium_->at({.time = time}, quiet));
  std::vector<AnyMedium> media;
  now->addMedia(media);
  return sightThrough(std::move(media));
}

std::shared_ptr<const SightSnapshot> sightThrough(std::vector<AnyMedium> media) {
  return std::make_shared<const RaySightSnapshot>(std::move(media));
}

}  // namespace volute
