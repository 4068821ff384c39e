// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/synth/fluid.hpp"

#include <cmath>

#include "volute/base/parallel.hpp"

namespace volute {
namespace {

constexpr std::size_t kFluidGrain = 4;
constexpr int kCycles = 3;

// Calls body(i, j, k) for all samples of a lattice, planes in parallel.
template <class Body>
void forEach(int x, int y, int z, const Body& body) {
  parallelRanges(z, kFluidGrain, [&](std::size_t begin, std::size_t end) {
    for (int k = static_cast<int>(begin); k < static_cast<int>(end); ++k) {
      for (int j = 0; j < y; ++j) {
        for (int i = 0; i < x; ++i) body(i, j, k);
      }
    }
  });
}

}  // namespace

Fluid::Fluid(int size, float extent, int scalars)
    : size_(size),
      cellSize_(extent / static_cast<float>(size)),
      velocity_{Field(size + 1, size, size), Field(size, size + 1, size),
                Field(size, size, size + 1)},
      nextVelocity_(velocity_),
      vorticityLength_(size, size, size),
      scalars_(scalars, Field(size, size, size)),
      poisson_(size) {
  force_.fill(Field(size, size, size));
  vorticity_ = force_;
  path_ = force_;
  expansion_ = vorticityLength_;
  moved_ = corrected_ = vorticityLength_;
}

void Fluid::advect(float dt) {
  traceBack(dt);
  for (Field& scalar : scalars_) carryScalar(scalar);
  for (int c = 0; c < 3; ++c) carryVelocity(c);
  std::swap(velocity_, nextVelocity_);
}

// The midpoint rule, from the cell centres.
void Fluid::traceBack(float dt) {
  const float scale = -dt / cellSize_;
  forEach(size_, size_, size_, [&](int i, int j, int k) {
    const float half = 0.25f * scale;  // of the sum of two faces
    const float x = static_cast<float>(i) + 0.5f +
                    half * (velocity_[0].at(i, j, k) + velocity_[0].at(i + 1, j, k));
    const float y = static_cast<float>(j) + 0.5f +
                    half * (velocity_[1].at(i, j, k) + velocity_[1].at(i, j + 1, k));
    const float z = static_cast<float>(k) + 0.5f +
                    half * (velocity_[2].at(i, j, k) + velocity_[2].at(i, j, k + 1));
    const std::size_t at = path_[0].index(i, j, k);
    path_[0].values[at] = scale * sample(velocity_[0], x, y - 0.5f, z - 0.5f);
    path_[1].values[at] = scale * sample(velocity_[1], x - 0.5f, y, z - 0.5f);
    path_[2].values[at] = scale * sample(velocity_[2], x - 0.5f, y - 0.5f, z);
  });
}

// MacCormack: go back, come forth again, correct by half of what that changed. Where that would
// leave the range of the values around, no correction: clamping to the range draws streaks along
// the grid.
void Fluid::carryScalar(Field& field) {
  const auto tapAt = [&](int i, int j, int k, std::size_t at, float sign) {
    return Tap(field, static_cast<float>(i) + sign * path_[0].values[at],
               static_cast<float>(j) + sign * path_[1].values[at],
               static_cast<float>(k) + sign * path_[2].values[at]);
  };
  forEach(size_, size_, size_, [&](int i, int j, int k) {
    const std::size_t at = field.index(i, j, k);
    const Tap tap = tapAt(i, j, k, at, 1);
    moved_.values[at] = tap.interpolate(tap.corners(field));
  });
  forEach(size_, size_, size_, [&](int i, int j, int k) {
    const std::size_t at = field.index(i, j, k);
    const auto around = tapAt(i, j, k, at, 1).corners(field);
    const auto [low, high] = std::ranges::minmax(around);
    if (low == high) {  // nothing to correct in empty space
      corrected_.values[at] = moved_.values[at];
      return;
    }
    const Tap forth = tapAt(i, j, k, at, -1);
    const float error = field.values[at] - forth.interpolate(forth.corners(moved_));
    const float value = moved_.values[at] + 0.5f * error;
    corrected_.values[at] = value < low || value > high ? moved_.values[at] : value;
  });
  field.values.swap(corrected_.values);
}

// First order: its smearing is what keeps eddies of one cell's width from growing, and confinement
// makes up for it.
void Fluid::carryVelocity(int component) {
  const Field& from = velocity_[component];
  Field& to = nextVelocity_[component];
  const int last = size_ - 1;
  forEach(to.x, to.y, to.z, [&](int i, int j, int k) {
    const std::size_t after =
        path_[0].index(std::min(i, last), std::min(j, last), std::min(k, last));
    const std::size_t before =
        path_[0].index(std::max(i - (component == 0), 0), std::max(j - (component == 1), 0),
                       std::max(k - (component == 2), 0));
    const auto mean = [&](int c) {
      return 0.5f * (path_[c].values[before] + path_[c].values[after]);
    };
    to.at(i, j, k) = sample(from, static_cast<float>(i) + mean(0), static_cast<float>(j) + mean(1),
                            static_cast<float>(k) + mean(2));
  });
}

void Fluid::addForces(float dt, float confinement) {
  if (confinement > 0) {
    computeVorticity();
    confine(confinement);
  }
  const int n = size_;
  const float half = 0.5f * dt;
  forEach(n, n, n, [&](int i, int j, int k) {
    // Each cell gives to its lower faces the mean of itself and its lower neighbour; the border
    // faces are left to the pressure.
    if (i > 0)
      velocity_[0].at(i, j, k) += half * (force_[0].at(i, j, k) + force_[0].at(i - 1, j, k));
    if (j > 0)
      velocity_[1].at(i, j, k) += half * (force_[1].at(i, j, k) + force_[1].at(i, j - 1, k));
    if (k > 0)
      velocity_[2].at(i, j, k) += half * (force_[2].at(i, j, k) + force_[2].at(i, j, k - 1));
  });
  for (Field& component : force_) std::ranges::fill(component.values, 0.0f);
}

void Fluid::computeVorticity() {
  const int n = size_;
  const float scale = 0.25f / cellSize_;  // differences over two cells of sums of two faces
  const auto twice = [&](int c, int i, int j, int k) {
    const int step[3] = {c == 0, c == 1, c == 2};
    return velocity_[c].at(i, j, k) + velocity_[c].at(i + step[0], j + step[1], k + step[2]);
  };
  forEach(n, n, n, [&](int i, int j, int k) {
    if (i == 0 || j == 0 || k == 0 || i == n - 1 || j == n - 1 || k == n - 1)
      return;
    const auto slope = [&](int c, int axis) {
      const int s[3] = {axis == 0, axis == 1, axis == 2};
      return scale *
             (twice(c, i + s[0], j + s[1], k + s[2]) - twice(c, i - s[0], j - s[1], k - s[2]));
    };
    const float x = slope(2, 1) - slope(1, 2);
    const float y = slope(0, 2) - slope(2, 0);
    const float z = slope(1, 0) - slope(0, 1);
    const std::size_t at = vorticityLength_.index(i, j, k);
    vorticity_[0].values[at] = x;
    vorticity_[1].values[at] = y;
    vorticity_[2].values[at] = z;
    vorticityLength_.values[at] = std::sqrt(x * x + y * y + z * z);
  });
}

// Fedkiw et al. 2001: a force that turns around the places of the strongest vorticity.
void Fluid::confine(float strength) {
  const int n = size_;
  const float scale = strength * cellSize_;
  forEach(n, n, n, [&](int i, int j, int k) {
    if (i == 0 || j == 0 || k == 0 || i == n - 1 || j == n - 1 || k == n - 1)
      return;
    const Field& w = vorticityLength_;
    float x = w.at(i + 1, j, k) - w.at(i - 1, j, k);
    float y = w.at(i, j + 1, k) - w.at(i, j - 1, k);
    float z = w.at(i, j, k + 1) - w.at(i, j, k - 1);
    const float inverse = scale / (std::sqrt(x * x + y * y + z * z) + 1e-6f);
    x *= inverse, y *= inverse, z *= inverse;
    const std::size_t at = w.index(i, j, k);
    const float a = vorticity_[0].values[at];
    const float b = vorticity_[1].values[at];
    const float c = vorticity_[2].values[at];
    force_[0].values[at] += y * c - z * b;
    force_[1].values[at] += z * a - x * c;
    force_[2].values[at] += x * b - y * a;
  });
}

// Times the size of a cell.
float Fluid::divergence(int i, int j, int k) const {
  return (velocity_[0].at(i + 1, j, k) - velocity_[0].at(i, j, k)) +
         (velocity_[1].at(i, j + 1, k) - velocity_[1].at(i, j, k)) +
         (velocity_[2].at(i, j, k + 1) - velocity_[2].at(i, j, k));
}

void Fluid::project() {
  const int n = size_;
  for (int j = 0; j < n; ++j) std::ranges::fill_n(&velocity_[2].at(0, j, 0), n, 0.0f);
  forEach(n, n, n, [&](int i, int j, int k) {
    poisson_.rightSide().at(i + 1, j + 1, k + 1) =
        divergence(i, j, k) - cellSize_ * expansion_.at(i, j, k);
  });
  poisson_.solve(kCycles);
  const Field& p = poisson_.pressure();
  forEach(n + 1, n, n, [&](int i, int j, int k) {
    velocity_[0].at(i, j, k) -= p.at(i + 1, j + 1, k + 1) - p.at(i, j + 1, k + 1);
  });
  forEach(n, n + 1, n, [&](int i, int j, int k) {
    velocity_[1].at(i, j, k) -= p.at(i + 1, j + 1, k + 1) - p.at(i + 1, j, k + 1);
  });
  forEach(n, n, n + 1, [&](int i, int j, int k) {
    if (k > 0)
      velocity_[2].at(i, j, k) -= p.at(i + 1, j + 1, k + 1) - p.at(i + 1, j + 1, k);
  });
}

float Fluid::divergenceError() const {
  float most = 0;
  for (int k = 0; k < size_; ++k) {
    for (int j = 0; j < size_; ++j) {
      for (int i = 0; i < size_; ++i)
        most = std::max(most, std::fabs(divergence(i, j, k) / cellSize_ - expansion_.at(i, j, k)));
    }
  }
  return most;
}

}  // namespace volute
