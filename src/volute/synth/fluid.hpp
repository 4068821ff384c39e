// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <vector>

#include "volute/synth/field.hpp"
#include "volute/synth/poisson.hpp"

namespace volute {

/// A fluid of constant density in a cube that is open to still air on the sides and the top and
/// stands on a floor. Stam's stable fluids on a staggered grid with MacCormack advection of scalars
/// and vorticity confinement. A step is advect, then addForces, then project. All results are the
/// same for any number of threads.
class Fluid {
 public:
  /// @param size  cells on a side; @param extent  [m], the side of the cube.
  Fluid(int size, float extent, int scalars);

  int size() const { return size_; }

  float cellSize() const { return cellSize_; }  ///< [m]

  /// What the fluid carries, at cell centres, size^3 each.
  std::vector<Field>& scalars() { return scalars_; }

  const std::vector<Field>& scalars() const { return scalars_; }

  /// Accelerations [m/s^2] at cell centres along x, y, z; addForces uses them up and sets them to
  /// zero.
  std::array<Field, 3>& force() { return force_; }

  /// Rate [1/s] at which the fluid swells in each cell, as a burning gas does; holds until it is
  /// changed.
  Field& expansion() { return expansion_; }

  /// Velocities [m/s] on the faces: component c has one sample more along axis c.
  const std::array<Field, 3>& velocity() const { return velocity_; }

  /// Carries scalars and velocities along for dt [s].
  void advect(float dt);

  /// Adds `force`, and brings back the small eddies that the grid smears: `confinement` is
  /// dimensionless, about 0..1.
  void addForces(float dt, float confinement);

  /// Makes the divergence of the velocity equal to `expansion` and lets nothing through the floor.
  void project();

  /// The largest |divergence - expansion| [1/s] of any cell.
  float divergenceError() const;

 private:
  void traceBack(float dt);
  void carryScalar(Field& field);
  void carryVelocity(int component);
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
  Field expansion_;
  std::vector<Field> scalars_;
  PoissonSolver poisson_;
  std::array<Field, 3> path_;  // where a cell's matter comes from, relative to it, in cells
  Field moved_, corrected_;
};

}  // namespace volute
