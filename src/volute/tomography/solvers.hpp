// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "volute/tomography/least_squares.hpp"
#include "volute/tomography/prior.hpp"

namespace volute {

/// Called by a solver after each iteration; false stops it.
/// @param projected  S a.
using SolverWatch = std::function<bool(int iteration, std::span<const float> unknowns,
                                       std::span<const float> projected)>;

/// Each changes `unknowns` from where they are (four floats for each), and returns how many
/// iterations it made.

/// The proximal optimized gradient method (Taylor, Hendrickx and Glineur 2017) with adaptive
/// restart (Kim and Fessler 2018, POGM'). One product with S and one with S' an iteration, in one
/// walk.
/// @param largest  the largest eigenvalue of S' W^2 S.
int solveApg(const LeastSquares& problem, double largest, Prior& prior, int iterations,
             std::vector<float>& unknowns, const SolverWatch& watch);

/// Multiplicative: a *= S'(W^2 p / S a) / S' W^2 1. Starts from a constant where `unknowns` are 0.
int solveMlem(const LeastSquares& problem, int iterations, std::vector<float>& unknowns,
              const SolverWatch& watch);

/// a += C S' R (p - S a), with C and R the inverse column and row sums.
int solveSirt(const LeastSquares& problem, bool nonNegative, int iterations,
              std::vector<float>& unknowns, const SolverWatch& watch);

/// Conjugate gradients on the normal equations, each channel on its own; clamped at the end if
/// `nonNegative`.
int solveCgls(const LeastSquares& problem, bool nonNegative, int iterations,
              std::vector<float>& unknowns, const SolverWatch& watch);

}  // namespace volute
