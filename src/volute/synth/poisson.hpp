// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <vector>

#include "volute/synth/field.hpp"

namespace volute {

/// Solves laplace(p) = b on a cube of cells by geometric multigrid: p = 0 on the four sides and the
/// top (open air), dp/dz = 0 on the bottom (the floor). Lengths are in cells. The result does not
/// depend on the number of threads.
class PoissonSolver {
 public:
  /// @param size  cells on a side, >= 2.
  explicit PoissonSolver(int size);

  /// One ghost cell on every side: (size + 2)^3. Keeps the last solution as the next first guess.
  const Field& pressure() const { return levels_.front().solution; }

  Field& rightSide() { return levels_.front().right; }

  /// Runs V-cycles on the right side that the caller filled in (its ghost cells are not read), then
  /// fills the ghost cells of the pressure so that differences across the border faces mean the
  /// border conditions.
  void solve(int cycles);

 private:
  struct Level {
    int size;
    Field solution, right, residual;
  };

  void cycle(std::size_t level);

  std::vector<Level> levels_;
};

}  // namespace volute
