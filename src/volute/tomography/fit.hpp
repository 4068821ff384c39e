// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "volute/tomography/frame_problem.hpp"
#include "volute/tomography/solvers.hpp"

namespace volute {

/// A prior and how strong it is.
struct PriorStrength {
  Regularization regularization = Regularization::kNone;
  double lambda = 0;    ///< times the largest eigenvalue
  double sparsity = 0;  ///< of total variation, times lambda
};

/// A prior and what came of it.
struct Fit {
  PriorStrength prior;
  int iterations = 0;
  int searchIterations = 0;  ///< of the fits that chose the strength, or when to stop
  std::string_view stoppedBy = "iterations";
  std::vector<float> unknowns;
  std::vector<float> projected;  ///< S a
  double heldOutError = 0;
  std::optional<TomographyChoice> choice;
};

/// Views, options and scales that fits of one frame share.
struct FitSetup {
  const FrameProblem& problem;
  std::span<const TomographyView> views;
  const TomographyOptions& options;
  double largest;  ///< eigenvalue of S' W^2 S
  double typical;  ///< typicalValue()
  Progress& progress;
  std::span<const float> expected{};  ///< unknowns to pull towards; empty: none
};

/// A typical value of a voxel [radiance/m]: the largest entry of S' W^2 (p - b) over the largest
/// eigenvalue. Total variation is proportional to the light, least squares to its square: strengths
/// count in it.
double typicalValue(const LeastSquares& data, double largest);

/// Of total variation where nobody says. 0 for fewer than four views: of them none can be held out,
/// and pixels of the same views do not tell whether dark voxels are dark.
double usualSparsity(std::size_t views);

/// A random share of the rows, chosen by `seed`: 1 for those held out of a fit.
std::vector<std::uint8_t> heldOutRows(std::size_t rows, std::uint32_t seed);

/// The views that are held out, each by itself, to see how well others predict it: that whose
/// nearest neighbour, in angle, is at the median distance, of five views or fewer another one, too.
/// None of fewer than `fewest`.
std::vector<std::size_t> viewsToHoldOut(std::span<const TomographyView> views, const Vec3& centre,
                                        std::size_t fewest = 4);

/// How many pixels on a side may become one without the volume being able to tell: a voxel stays
/// nearly two pixels wide. 1 where single pixels say more than their mean.
int pixelsTogether(std::span<const TomographyView> views, const VolumeGeometry& geometry,
                   const TomographyOptions& options);

/// The data with the rows held out.
LeastSquares withoutRows(const LeastSquares& data, std::span<const std::uint8_t> heldOut);

/// Weighted relative L2 of the data over the rows that are held out.
double heldOutError(const LeastSquares& data, std::span<const std::uint8_t> heldOut,
                    std::span<const float> projected);

/// When to stop besides after so many iterations.
struct StopRule {
  int iterations = 0;
  double squaredResidual = 0;               ///< of the data: stops at or below
  std::span<const std::uint8_t> heldOut{};  ///< stops when their error rises; empty: none
  double settled = 0;  ///< stops when ten iterations change the volume by no more, relative L2
  // Of several fits, for the progress: the most iterations of those before, and of all.
  int before = 0, all = 0;
};

inline constexpr double kSettled = 1e-3;  ///< what counts as settled

/// Runs the solver of the options on `data` from `start`.
[[nodiscard]] Result<Fit> runFit(const FitSetup& setup, const LeastSquares& data,
                                 const PriorStrength& prior, std::vector<float> start,
                                 const StopRule& stop);

/// Chooses the prior, unless the options have the choice, and fits all pixels. Total variation goes
/// from strong to weak, with sparsity and without (in the order of
/// what is usual for so many views), each fit going on from the one before, until the
/// error over the held-out pixels has risen; plain iterations go on until it rises. The least error
/// is chosen. With four views or more the held-out pixels are those of one camera, of four or five
/// views those of two in turn, for other pixels of the same cameras would be predicted ever better
/// by a volume that fits the noise.
[[nodiscard]] Result<Fit> chooseFit(const FitSetup& setup, std::vector<float> start);

}  // namespace volute
