// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/synth/poisson.hpp"

#include "volute/base/parallel.hpp"

namespace volute {
namespace {

constexpr int kSmooth = 2;     // sweeps before and after a coarser level
constexpr int kCoarsest = 40;  // sweeps on the coarsest, at most 15 cells wide
constexpr std::size_t kPoissonGrain = 8;

// Beyond an open face lies minus the inner value (zero on the face), beyond the floor the same
// value.
void fillGhosts(Field& p) {
  const int last = p.x - 2;
  for (int k = 1; k <= last; ++k) {
    for (int j = 1; j <= last; ++j) {
      p.at(0, j, k) = -p.at(1, j, k);
      p.at(last + 1, j, k) = -p.at(last, j, k);
    }
    for (int i = 0; i <= last + 1; ++i) {
      p.at(i, 0, k) = -p.at(i, 1, k);
      p.at(i, last + 1, k) = -p.at(i, last, k);
    }
  }
  for (int j = 0; j <= last + 1; ++j) {
    for (int i = 0; i <= last + 1; ++i) {
      p.at(i, j, 0) = p.at(i, j, 1);
      p.at(i, j, last + 1) = -p.at(i, j, last);
    }
  }
}

float neighbours(const Field& p, std::size_t at) {
  const std::size_t row = p.x;
  const std::size_t plane = row * p.y;
  const float* v = p.values.data();
  return (v[at - 1] + v[at + 1]) + (v[at - row] + v[at + row]) + (v[at - plane] + v[at + plane]);
}

// Gauss-Seidel in red-black order: the cells of one colour do not see each other, so threads cannot
// change the result.
void relax(Field& p, const Field& right, int sweeps) {
  const int size = p.x - 2;
  for (int half = 0; half < 2 * sweeps; ++half) {
    fillGhosts(p);
    parallelRanges(size, kPoissonGrain, [&](std::size_t begin, std::size_t end) {
      for (int k = static_cast<int>(begin) + 1; k <= static_cast<int>(end); ++k) {
        for (int j = 1; j <= size; ++j) {
          const int first = 1 + ((j + k + half) & 1);
          for (std::size_t at = p.index(first, j, k), stop = p.index(size, j, k); at <= stop;
               at += 2) {
            p.values[at] = (neighbours(p, at) - right.values[at]) * (1.0f / 6.0f);
          }
        }
      }
    });
  }
  fillGhosts(p);
}

void computeResidual(const Field& p, const Field& right, Field& residual) {
  const int size = p.x - 2;
  parallelRanges(size, kPoissonGrain, [&](std::size_t begin, std::size_t end) {
    for (int k = static_cast<int>(begin) + 1; k <= static_cast<int>(end); ++k) {
      for (int j = 1; j <= size; ++j) {
        for (std::size_t at = p.index(1, j, k), stop = p.index(size, j, k); at <= stop; ++at) {
          residual.values[at] = right.values[at] - (neighbours(p, at) - 6 * p.values[at]);
        }
      }
    }
  });
}

// The mean of eight residuals, times 4: the coarse laplacian is per coarse cell, twice as wide.
void restrictTo(const Field& fine, Field& coarse) {
  const int size = coarse.x - 2;
  parallelRanges(size, kPoissonGrain, [&](std::size_t begin, std::size_t end) {
    for (int k = static_cast<int>(begin) + 1; k <= static_cast<int>(end); ++k) {
      for (int j = 1; j <= size; ++j) {
        for (int i = 1; i <= size; ++i) {
          float sum = 0;
          for (int d = 0; d < 4; ++d) {
            const std::size_t at = fine.index(2 * i - 1, 2 * j - 1 + (d & 1), 2 * k - 1 + (d >> 1));
            sum += fine.values[at] + fine.values[at + 1];
          }
          coarse.at(i, j, k) = 0.5f * sum;
        }
      }
    }
  });
}

// Trilinear between cell centres; the ghosts of `coarse` carry the border conditions.
void addInterpolated(const Field& coarse, Field& fine) {
  const int size = fine.x - 2;
  parallelRanges(size, kPoissonGrain, [&](std::size_t begin, std::size_t end) {
    for (int k = static_cast<int>(begin) + 1; k <= static_cast<int>(end); ++k) {
      for (int j = 1; j <= size; ++j) {
        for (int i = 1; i <= size; ++i) {
          const auto coordinate = [](int fineCell) {
            return 0.5f * static_cast<float>(fineCell) + 0.25f;
          };
          fine.at(i, j, k) += sample(coarse, coordinate(i), coordinate(j), coordinate(k));
        }
      }
    }
  });
}

}  // namespace

PoissonSolver::PoissonSolver(int size) {
  for (int n = size;; n /= 2) {
    const Field field(n + 2, n + 2, n + 2);
    levels_.push_back({n, field, field, field});
    if (n % 2 != 0 || n <= 4)
      break;
  }
}

void PoissonSolver::solve(int cycles) {
  for (int i = 0; i < cycles; ++i) cycle(0);
}

void PoissonSolver::cycle(std::size_t level) {
  Level& fine = levels_[level];
  if (level + 1 == levels_.size()) {
    relax(fine.solution, fine.right, kCoarsest);
    return;
  }
  Level& coarse = levels_[level + 1];
  relax(fine.solution, fine.right, kSmooth);
  computeResidual(fine.solution, fine.right, fine.residual);
  restrictTo(fine.residual, coarse.right);
  std::ranges::fill(coarse.solution.values, 0.0f);
  cycle(level + 1);
  addInterpolated(coarse.solution, fine.solution);
  relax(fine.solution, fine.right, kSmooth);
}

}  // namespace volute
