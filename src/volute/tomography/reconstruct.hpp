// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/base/result.hpp"
#include "volute/tomography/view.hpp"
#include "volute/wavelet/lifting.hpp"

namespace volute {

/// The least-squares solver.
enum class TomographySolver {
  kApg,   ///< accelerated projected gradient with adaptive restart
  kMlem,  ///< multiplicative (expectation maximisation); non-negative by itself
  kSirt,  ///< simultaneous iterations scaled by row and column sums
  kCgls,  ///< conjugate gradients, clamped at the end
};

/// The regularisation term; the last three need kApg.
enum class Regularization {
  kAuto,  ///< the best predictor of held-out cameras (with fewer than four views, held-out pixels):
          ///< total variation of some strength, or plain iterations stopped early; none with
          ///< solvers other than kApg
  kNone,
  kTv,       ///< total variation of all channels together: their edges are likely the same
  kSmooth,   ///< squared differences of neighbours
  kWavelet,  ///< sparse wavelet coefficients, over all shifts by one voxel (cycle spinning)
};

std::optional<TomographySolver> tomographySolverByName(std::string_view name);  ///< "apg", ...
std::string_view tomographySolverName(TomographySolver solver);
std::optional<Regularization> regularizationByName(std::string_view name);  ///< "auto", ...
std::string_view regularizationName(Regularization regularization);

/// Choices made from the data, to be reused for later frames.
struct TomographyChoice {
  Regularization regularization = Regularization::kNone;  ///< kTv or kNone
  double strength = 0;  ///< of kTv, times the largest eigenvalue and a typical voxel value
  double sparsity = 0;  ///< of kTv
  int iterations = 0;   ///< of kNone, from zero
};

struct TomographyOptions {
  Basis basis = Basis::kTrilinear;
  TomographySolver solver = TomographySolver::kApg;
  Regularization regularization = Regularization::kAuto;
  std::optional<double> lambda;  ///< strength, relative to the largest eigenvalue of S'S; none:
                                 ///< chosen, or 1e-5 with kSmooth and kWavelet
  /// With total variation: penalty on light in dark voxels, times lambda; 0: plain total variation;
  /// none: 2.5, or 0 for fewer than four
  /// views and, if the strength is chosen, where 0 predicts better; of four or five views 2.5 only
  /// where it predicts better.
  std::optional<double> sparsity;
  std::optional<TomographyChoice> choice;  ///< with kAuto: use this instead of choosing
  /// Number of iterations, after the choice of the strength if that is automatic. If none: with
  /// regularization until convergence; without, until the residual falls to noiseSigma or, if that
  /// is unknown, the error of held-out pixels rises; at most 600 iterations if the strength is
  /// chosen, else 400.
  std::optional<int> iterations;
  int raysPerPixel = 4;  ///< 1 or 4
  bool hull = true;      ///< solve only for voxels where every camera sees the medium
  bool nonNegative = true;
  bool coarseToFine = false;         ///< solve at half the resolution first
  double temporal = 0;               ///< pull towards the volume to start from, where there is one,
                                     ///< times the largest eigenvalue of S'S; kApg alone
  std::optional<double> noiseSigma;  ///< noise of a pixel's channel [radiance]
  Wavelet wavelet = Wavelet::kHaar;
  std::uint32_t seed = 1;  ///< of the held-out pixels and the cycle spinning
  std::uint64_t maxMemory = std::uint64_t{4} << 30;  ///< [bytes]
};

/// A solved frame.
struct Reconstruction {
  std::vector<float> volume;  ///< (z, y, x, 3), radiance per metre
  int iterations = 0;         ///< of the last fit
  int searchIterations = 0;   ///< of the preceding fits, which chose the strength or the stop
  Regularization regularization = Regularization::kNone;  ///< the one used
  double lambda = 0;                                      ///< used, times the largest eigenvalue
  std::string_view stoppedBy;    ///< "iterations": the number requested; "discrepancy",
                                 ///< "held-out pixels", "converged", or "limit": none of these
  double largestEigenvalue = 0;  ///< of S'S [m^2]
  double hullShare = 1;          ///< unknown voxels / all voxels
  std::size_t pixels = 0;        ///< used, over all views
  std::vector<double> residual;  ///< for each view, relative L2 of S a - (p - b) over its pixels
  double heldOutError = 0;       ///< relative L2 over the held-out pixels; 0 when none were
  double sparsity = 0;           ///< used, with total variation
  std::optional<TomographyChoice> choice;  ///< made or reused
};

/// Checks before any picture is read whether a volume can be reconstructed: kInvalidArgument for a
/// resolution out of range or empty bounds, kTooLarge if its values alone need more than
/// `maxMemory` [bytes].
[[nodiscard]] Status checkVolumeSize(const VolumeGeometry& geometry, std::uint64_t maxMemory);

/// Reconstructs one frame: min 1/2 |W (S a - (p - b))|^2 + lambda R(a), a >= 0, a = 0 outside the
/// visual hull (Ahrenberg et al. 2005, section 3). The same result for any number of threads.
/// @param warmStart  a volume of the same shape, from the previous frame; empty: none.
/// Errors: kInvalidArgument for invalid views or options, kInvalidData for images with non-finite
/// values, kNotFound for an empty hull, kTooLarge, kCancelled.
[[nodiscard]] Result<Reconstruction> reconstruct(std::span<const TomographyView> views,
                                                 const VolumeGeometry& geometry,
                                                 const TomographyOptions& options,
                                                 std::span<const float> warmStart,
                                                 Progress& progress);

}  // namespace volute
