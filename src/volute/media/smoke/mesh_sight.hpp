// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>

#include "volute/media/sight.hpp"
#include "volute/media/smoke/mesh_air.hpp"
#include "volute/media/smoke/smoke_medium.hpp"

namespace volute {

/// Smoke on tetrahedra over time, at its stored steps.
class MeshSight final : public SightField {
 public:
  /// @param air  fields with quantities of the air, besides those with usual names
  MeshSight(std::shared_ptr<SmokeMedium> smoke, std::vector<MeshAirField> air)
      : smoke_(std::move(smoke)), air_(std::move(air)) {}

  [[nodiscard]] Result<std::unique_ptr<PointField>> conditions(std::string_view quantity) override;

  std::string description() const override;

  std::vector<Remark> remarks() const override { return smoke_->remarks; }

  std::optional<double> largestRead() const override { return largest_; }

  std::vector<Remark> remarksOn(double largest) const override;

  std::span<const double> times() const override { return smoke_->source().times(); }

  int numberOf(std::size_t time) const override { return smoke_->source().numberOf(time); }

 protected:
  Box3 ownBounds() const override { return smoke_->bounds(); }

  [[nodiscard]] Result<std::shared_ptr<const SightSnapshot>> readOwn(std::size_t time) override;

 private:
  std::shared_ptr<SmokeMedium> smoke_;
  std::vector<MeshAirField> air_;
  std::vector<std::shared_ptr<MeshGasRead>> gases_;      // in units that are said
  std::optional<std::vector<MeshFieldSummary>> fields_;  // when they were asked for
  std::optional<MeshFieldNames> names_;                  // the same
  std::shared_ptr<const TetLocator> locator_;            // of the last mesh
  std::uint64_t meshes_ = 0;                             // how many there were
  double largest_ = 0;                                   // that was read [1/m]
};

}  // namespace volute
