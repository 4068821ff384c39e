// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>

#include "volute/media/scene_medium.hpp"
#include "volute/media/sight.hpp"

namespace volute {

/// Any medium as sight lines ask for it: its own optical depth along each, exact for its basis, and
/// nothing opaque. It knows itself everywhere; beyond its bounds the air is clear.
class RaySight final : public SightField {
 public:
  explicit RaySight(std::shared_ptr<SceneMedium> medium) : medium_(std::move(medium)) {}

  std::string description() const override;

  std::vector<Remark> remarks() const override { return medium_->remarks; }

  std::span<const double> times() const override { return medium_->info().times; }

  int numberOf(std::size_t time) const override { return medium_->info().numbers[time]; }

  bool clearBeyond() const override { return true; }

  bool interpolates() const override { return medium_->info().moves; }

 protected:
  Box3 ownBounds() const override { return medium_->info().bounds; }

  [[nodiscard]] Result<std::shared_ptr<const SightSnapshot>> readOwn(std::size_t time) override {
    return readOwnAt(medium_->info().times[time]);
  }

  [[nodiscard]] Result<std::shared_ptr<const SightSnapshot>> readOwnAt(double time) override;

 private:
  std::shared_ptr<SceneMedium> medium_;
};

/// Media at one time, seen through as they are by nature.
std::shared_ptr<const SightSnapshot> sightThrough(std::vector<AnyMedium> media);

}  // namespace volute
