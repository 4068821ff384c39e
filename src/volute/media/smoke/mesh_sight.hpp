// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <optional>

#include "volute/io/mesh_source.hpp"
#include "volute/media/sight.hpp"
#include "volute/media/smoke/mesh_air.hpp"
#include "volute/optics/extinction.hpp"
#include "volute/tetmesh/tet_locator.hpp"

namespace volute {

/// Smoke on tetrahedra over time, read a step at a time.
class MeshSight final : public SightField {
 public:
  /// Reads the first step, for its bounds. `density` is the gas's, of mass fractions.
  [[nodiscard]] static Result<std::unique_ptr<MeshSight>> open(MeshSource source,
                                                               std::optional<MeshSource> density,
                                                               const SmokeModel& model,
                                                               const std::string& name);

  /// Which fields hold quantities of the air, besides those with usual names.
  void nameAir(std::vector<MeshAirField> fields, std::uint64_t maxMemory) {
    air_ = std::move(fields);
    maxMemory_ = maxMemory;
  }

  [[nodiscard]] Result<std::unique_ptr<PointField>> conditions(std::string_view quantity) override;

  std::string description() const override {
    return fmt::format("{}: field '{}' as {} on tetrahedra", name_, fieldName_,
                       nameOf(model_.quantity));
  }

  std::vector<Remark> remarks() const override { return remarks_; }

  /// Nobody chose the field.
  void remarkOnOthers();

  std::span<const double> times() const override { return source_.times(); }

  int numberOf(std::size_t time) const override { return source_.numberOf(time); }

 protected:
  Box3 ownBounds() const override { return bounds_; }

  [[nodiscard]] Result<std::shared_ptr<const SightInstant>> readOwn(std::size_t time) override;

 private:
  MeshSight(MeshSource source, std::optional<MeshSource> density, const SmokeModel& model,
            std::string name)
      : source_(std::move(source)),
        density_(std::move(density)),
        model_(model),
        name_(std::move(name)) {}

  MeshSource source_;
  std::optional<MeshSource> density_;
  SmokeModel model_;
  std::string name_, fieldName_, otherFields_;
  std::vector<Remark> remarks_;
  std::vector<MeshAirField> air_;
  std::uint64_t maxMemory_ = std::uint64_t{4} << 30;
  std::optional<std::vector<MeshFieldSummary>> fields_;  // when they were asked for
  Box3 bounds_;
  std::shared_ptr<const TetLocator> locator_;  // of the last mesh
  std::uint64_t meshes_ = 0;                   // how many there were
  std::shared_ptr<const SightInstant> first_;  // until it is asked for
};

}  // namespace volute
