// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "volute/lighting/diffuse_light.hpp"
#include "volute/lighting/light_field.hpp"

namespace volute {

/// The parts of a segment from which surfaces keep a lamp's light entirely, in order and apart from
/// each other; replaces the third.
using ShadowsOn = std::function<void(const Segment&, const Lamp&, std::vector<Interval>&)>;

/// Any medium in the light of lamps that it scatters once, beside what it sends itself:
///   L = integral of (e + K sum of albedo phase irradiance T V) exp(-t) ds
/// with T of each lamp's LightField, and V, which surfaces keep off, by intervals of each ray, so
/// that their edges cost no accuracy.
///
/// A Medium and FastMedium. emission() at a point, which knows no direction, has the mean of the
/// phase function, and knows nothing of surfaces.
class LitMedium {
 public:
  struct Options {
    Scattering scattering{};
    Box3 lit{};           ///< finite: outside of it the medium is too thin to be lit
    double step = 1;      ///< [m] on which its extinction changes
    ShadowsOn shadows{};  ///< may be empty
    std::shared_ptr<const DiffuseLight> again{};  ///< light scattered before; null: none is
  };

  /// @param fields  one for each lamp
  LitMedium(AnyMedium medium, std::vector<LightField> fields, Options options);

  Box3 bounds() const { return medium_.bounds(); }

  double extinction(const Vec3& point) const { return medium_.extinction(point); }

  Rgb emission(const Vec3& point) const;

  void opticalDepth(std::span<const Segment> segments, std::span<double> depths) const {
    medium_.opticalDepth(segments, depths);
  }

  /// Those of the medium, cut until a parabola through the light at begin, middle and end of each
  /// is within 2e-4 of it (relative to the brightest) halfway between, or they were cut 12 times or
  /// are shorter than half a cell of a field.
  void pieces(std::span<const Segment> segments, std::span<std::vector<Piece>> pieces) const;

  /// By the medium's own fast path in steps, and the light at the middle of each, or of its parts
  /// where the light changes faster or the step is thick.
  void radiance(std::span<const Segment> segments, std::span<Radiance> out) const;

  bool dependsOnEnd() const { return medium_.dependsOnEnd(); }

  std::span<const LightField> fields() const { return fields_; }

  const Options& options() const { return options_; }

 private:
  class Ray;

  /// What is scattered towards the eye, of extinction 1.
  struct Source {
    Rgb light = Rgb::Zero();
    double cell = 0;  ///< LightField::Sample::cell, the least of all lamps
  };

  /// Places of a ray at which a sun's light is asked for at once, and what of it they send on.
  struct SunPlaces {
    std::vector<Vec3> points;
    std::vector<double> given, shares;
  };

  Source source(const Ray& ray, const Vec3& point) const;
  double goesOn(double share, double cosine) const;
  double evenFor(const Ray& ray, const Vec3& point) const;
  void add(Ray& ray, std::span<const Segment> steps, const Radiance& own,
           std::span<const double> depths, std::size_t k, std::span<SunPlaces> suns,
           Radiance& sum) const;
  void addSuns(const Ray& ray, std::span<SunPlaces> suns, Radiance& sum) const;
  void cut(const Ray& ray, const Piece& piece, int cuts, std::vector<Piece>& out) const;

  AnyMedium medium_;
  std::vector<LightField> fields_;
  Options options_;
};

}  // namespace volute
