// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/base/result.hpp"
#include "volute/tomography/capture_faults.hpp"
#include "volute/tomography/match.hpp"
#include "volute/tomography/reconstruct.hpp"

namespace volute {

/// A mistake that may be it.
struct FaultHypothesis {
  CaptureFault::Kind kind = CaptureFault::Kind::kMirrored;
  std::vector<std::size_t> cameras;  ///< empty: all
  double value = 1;                  ///< as in CaptureFault
  double left = 0;                   ///< of the pictures without it, root mean square
  Rgb factors = Rgb::Ones();         ///< as in CaptureFault
};

/// Where red, green and blue are found: what the value of kChannels counts.
inline constexpr std::array<std::array<int, 3>, 6> kChannelOrders{
    {{0, 1, 2}, {2, 1, 0}, {1, 0, 2}, {0, 2, 1}, {1, 2, 0}, {2, 0, 1}}};

/// Orders that cameras are mistaken for, besides two that are exchanged: the next, the previous,
/// the reverse one, and that of the digits of their numbers (0, 1, 10, 11, 2).
inline constexpr int kCameraOrders = 4;

/// Whose calibration each of n cameras' pictures fit.
/// @param order  below kCameraOrders: what the value of kOrder counts
std::vector<std::size_t> cameraOrder(int order, std::size_t n);

/// Whether it is another curve by which light is stored.
bool isResponse(CaptureFault::Kind kind);

/// Whether two cameras' pictures have one size, so that they may be exchanged.
bool areOfOneSize(const TomographyView& a, const TomographyView& b);

/// How one coarse volume explains all views.
struct Explanation {
  double all = 0;    ///< misfit, root mean square
  double lit = 0;    ///< of what is clearly brighter than the noise
  bool bad = false;  ///< some view is not explained
};

/// Views and a volume as coarse as a comparison of mistakes wants them.
class FaultLevel {
 public:
  /// @param longest  voxels on the longest side, about
  /// @param hull  whether silhouettes tell where nothing is: a mistake carves its own hull
  FaultLevel(const std::vector<TomographyView>& views, const VolumeGeometry& geometry, int longest,
             int iterations, bool hull);

  /// Grey: a mistake shows in all colours.
  const std::vector<TomographyView>& views() const { return views_; }

  const std::vector<TomographyView>& coloured() const { return coloured_; }

  const VolumeGeometry& geometry() const { return geometry_; }

  /// The pictures without a mistake, in colour where it is one of colours, grey where it is not.
  /// @param white  as in findCaptureFaults()
  std::vector<TomographyView> without(const FaultHypothesis& fault,
                                      std::span<const double> white) const;

  /// As they are, in what without() has for such a mistake.
  const std::vector<TomographyView>& as(CaptureFault::Kind kind) const;

  /// Takes a mistake out of the pictures.
  void mend(const FaultHypothesis& fault, std::span<const double> white);

  /// The volume that fits; empty where the views have no hull in common.
  Result<std::vector<float>> fitted(const std::vector<TomographyView>& views,
                                    const VolumeGeometry& geometry, const Progress& progress) const;

  /// @param volume  of `geometry`, which may be larger than the level's; empty: no volume explains
  ///   it
  ViewMatch matched(const TomographyView& view, const std::vector<float>& volume,
                    const VolumeGeometry& geometry) const;
  ViewMatch matched(const TomographyView& view, const std::vector<float>& volume) const;

  /// The factors on red, green and blue with which a view fits a volume best; nothing where a
  /// channel shows nothing of it.
  std::optional<Rgb> balanceOf(const TomographyView& view, const std::vector<float>& volume) const;

  Result<Explanation> explain(const std::vector<TomographyView>& views,
                              const VolumeGeometry& geometry, const Progress& progress) const;
  Result<Explanation> explain(const std::vector<TomographyView>& views,
                              const Progress& progress) const;

  /// Besides, what is left where there is light: values that are cut off at black have a mean that
  /// no volume explains, and other curves press it down.
  Result<Explanation> explainLit(const std::vector<TomographyView>& views,
                                 const Progress& progress) const;

  /// How far each of some cameras is from what the others predict, root mean square.
  /// @param together  whether all of them are held out at once
  Result<double> heldOut(const std::vector<TomographyView>& views,
                         const std::vector<std::size_t>& cameras, bool together,
                         const VolumeGeometry& geometry, const Progress& progress) const;
  Result<double> heldOut(const std::vector<TomographyView>& views,
                         const std::vector<std::size_t>& cameras, bool together,
                         const Progress& progress) const;

 private:
  void setGrey();

  /// @param pixels  of the pictures as they are
  std::vector<TomographyView> shifted(double pixels) const;

  VolumeGeometry geometry_;
  std::vector<TomographyView> coloured_, views_;
  std::vector<int> reductions_;         // one a view: pixels that became one
  std::vector<std::vector<char>> lit_;  // one a view: pixels that are clearly brighter than noise
  TomographyOptions options_;
};

}  // namespace volute
