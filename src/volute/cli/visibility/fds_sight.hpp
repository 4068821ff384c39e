// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <vector>

#include "volute/fds/fds_case.hpp"
#include "volute/visibility/sight_field.hpp"

namespace volute::cli {

/// One moment of an FDS case.
class FdsInstant final : public SightInstant {
 public:
  FdsInstant(FdsField field, FdsObstructions obstructions)
      : field_(std::move(field)), obstructions_(std::move(obstructions)) {}

  void look(std::span<const SightLine> lines, std::span<Sight> sights) const override;
  void places(std::span<const Vec3> points, std::span<Place> places) const override;
  void extinction(std::span<const Vec3> points, std::span<double> extinction) const override;

 private:
  Place placeAt(const Vec3& point) const;

  FdsField field_;
  FdsObstructions obstructions_;
};

/// An FDS case over time: obstructions come and go.
class FdsSight final : public SightField {
 public:
  explicit FdsSight(FdsCase fds) : case_(std::move(fds)) {}

  std::span<const double> times() const override { return case_.times(); }

  Box3 bounds() const override { return case_.bounds(); }

  [[nodiscard]] Result<std::shared_ptr<const SightInstant>> read(std::size_t time) override;

 private:
  FdsCase case_;
};

}  // namespace volute::cli
