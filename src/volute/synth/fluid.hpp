// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <vector>

#include "volute/synth/field.hpp"
#include "volute/synth/poisson.hpp"

namespace volute {

/// An incompressible fluid in a cube that is open to still air on the sides and the top and stands on a floor.
/// Stam's stable fluids on a staggered grid with MacCormack advection and vorticity confinement. A step is advect,
/// then addForces, then project. All results are the same for any number of threads.
class Fluid {
 public:
  /// @param size  cells on a side; @param extent  [m], the side of the cube.
  Fluid(int size, float extent, int scalars);

  int size() const { return size_; }
  float cellSize() const { return cellSize_; }  ///< [m]

  /// What the fluid carries, at cell centres, size^3 each.
  std::vector<Field>& scalars() { return scalars_; }
  const std::vector<Field>& scalars() const { return scalars_; }

  /// Accelerations [m/s^2] at cell centres along x, y, z; addForces uses them up and sets them to zero.
  std::array<Field, 3>& force() { return force_; }

  /// Velocities [m/s] on the faces: component c has one sample more along axis c.
  const std::array<Field, 3>& velocity() const { return velocity_; }

  /// Carries scalars and velocities along for dt [s].
  void advect(float dt);

  /// Adds `force`, and brings back the small eddies that the grid smears: `confinement` is dimensionless, about 0..1.
  void addForces(float dt, float confinement);

  /// Makes the velocity free of divergence and lets nothing through the floor.
  void project();

  /// The largest |divergence| [1/s] of any cell.
  float maxDivergence() const;

 private:
  void traceBack(const Field& field, const std::array<float, 3>& offset, float dt);
  void carry(Field& field);
  void computeVorticity();
  void confine(float strength);
  float divergence(int i, int j, int k) const;

  int size_;
  float cellSize_;
  std::array<Field, 3> velocity_;
  std::array<Field, 3> nextVelocity_;
  std::array<Field, 3> force_;
  std::array<Field, 3> vorticity_;
  Field vorticityLength_;
  std::vector<Field> scalars_;
  PoissonSolver poisson_;
  std::array<std::vector<float>, 3> path_;  // where a sample's matter comes from, relative to it, in cells
  Field moved_, corrected_;
};

}  // namespace volute
