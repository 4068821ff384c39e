// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "volute/geometry/triangle_scene.hpp"
#include "volute/media/sight.hpp"

namespace volute {

/// Another snapshot, with surfaces in the way, which carry people, too. Derives from the pure
/// interface, not from BasicSightSnapshot, so that no function of the other snapshot is lost.
class OccludedSight final : public SightSnapshot {
 public:
  /// Whether surfaces are sheets, or closed bodies whose triangles face outwards: within those
  /// something solid stands.
  enum class Surfaces { kSheets, kBodies };

  OccludedSight(std::shared_ptr<const SightSnapshot> media, TriangleScene surfaces,
                Surfaces what = Surfaces::kSheets)
      : media_(std::move(media)), surfaces_(std::move(surfaces)), what_(what) {}

  void look(std::span<const SightLine> lines, std::span<Sight> sights) const override;

  void bounds(std::span<const SightLine> lines, std::span<double> low,
              std::span<double> high) const override {
    media_->bounds(lines, low, high);
  }

  void blocked(std::span<const SightLine> lines, std::span<unsigned char> out) const override;
  void places(std::span<const Vec3> points, std::span<Place> places) const override;
  void extinction(std::span<const Vec3> points, std::span<double> extinction) const override;
  void extinctionBounds(std::span<const Vec3> points, std::span<double> low,
                        std::span<double> high) const override;
  void floors(std::span<const Vec3> points, double drop, std::span<double> z) const override;

  std::vector<PlanShape> shapes(double z) const override { return media_->shapes(z); }

  std::uint64_t geometry() const override { return media_->geometry(); }

  void weigh(const SightLine& line, std::vector<SightWeight>& weights, Sight& sight) const override;

  SightData data() const override { return media_->data(); }

 private:
  std::vector<std::uint8_t> occluded(std::span<const SightLine> lines) const;
  std::vector<std::uint8_t> within(std::span<const Vec3> points) const;

  std::shared_ptr<const SightSnapshot> media_;
  TriangleScene surfaces_;
  Surfaces what_;
};

}  // namespace volute
