// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <string>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/base/result.hpp"
#include "volute/math/vec.hpp"
#include "volute/tomography/view.hpp"

namespace volute {

/// A mistake in a capture that is not a number a little off.
struct CaptureFault {
  enum class Kind {
    kMirrored,    ///< left and right
    kFlipped,     ///< above and below
    kUpsideDown,  ///< turned by half a turn
    kTurnedLeft,  ///< turned by a quarter, counterclockwise
    kTurnedRight,
    kExchanged,  ///< two cameras' pictures, or calibrations
    kOrder,      ///< all cameras' pictures, or calibrations, in another order
    kEncoded,    ///< stored as sRGB and taken as linear
    kDecoded,    ///< stored linearly and taken as sRGB
    kExponent,   ///< stored by another curve: its light to a power
    kGain,       ///< brighter or darker than the others by a factor
    kZoom,       ///< of another focal length by much
    kLens,       ///< of a lens that bends much more, or less, than the calibration has it
    kShift,      ///< all principal points about half a pixel off
    kChannels,   ///< red, green and blue in another order than the others'
    kBalance,    ///< red, green and blue brighter or darker than the others', each by a factor
    kBox,        ///< the volume's bounds cut what is seen
  };

  Kind kind = Kind::kMirrored;
  std::vector<std::size_t> cameras;  ///< positions among the views; empty: all of them
  double value = 1;                  ///< kGain, kZoom: the factor that mends it; kExponent; kLens:
                                     ///< what is added to k1; kShift: pixels to the right and
                                     ///< down; kChannels, kOrder: which order
  double before = 0, after = 0;      ///< misfit of the views, as matchOf() has it, root mean square
  std::string text;                  ///< for people: what it is, the evidence, what to do
  bool byFrame = false;              ///< kGain: in each frame another one
  Rgb factors = Rgb::Ones();         ///< kBalance: on red, green and blue, that mend it
};

/// Each mistake is one hypothesis among all. Where no coarse volume explains the pictures, all are
/// tried by fits of such a volume to the pictures without the mistake; the best, and the responses
/// of all cameras in any case, are then compared on a finer volume: by what is left of the
/// pictures, and by how the other cameras predict those that are held out. One that is better in
/// both, and clearly better than the others, is named; then the next is looked for. While the
/// bounds cut much of the light nothing else is told. Nothing for pictures that agree, for fewer
/// than four views, and where nothing that is tried explains them. Only cameras that stand out most
/// are tried; exchanges need pictures of one size. What is wrong with
/// colours is looked for last.
/// @param white  one a view: the radiance of a stored value of 1; empty where views do not hold
///   light: responses are then not tried.
/// @param pixelCentre  where the calibration has the centre of the first pixel, for the sentence
[[nodiscard]] Result<std::vector<CaptureFault>> findCaptureFaults(
    const std::vector<TomographyView>& views, std::span<const double> white,
    const VolumeGeometry& geometry, Progress& progress, double pixelCentre = 0.5);

/// Mistakes of the kinds that one picture of some cameras can have by itself: turned, exchanged,
/// brighter or darker, also by channel, channels in another order. For frames beside that which
/// findCaptureFaults() was asked about.
[[nodiscard]] Result<std::vector<CaptureFault>> findPictureFaults(
    const std::vector<TomographyView>& views, const VolumeGeometry& geometry, Progress& progress);

/// Whether pictures of another frame are explained better without this mistake of some cameras,
/// too.
[[nodiscard]] Result<bool> hasCaptureFault(const CaptureFault& fault,
                                           const std::vector<TomographyView>& views,
                                           std::span<const double> white,
                                           const VolumeGeometry& geometry, Progress& progress);

/// The factor on a view's light that fits what others predict, on coarse voxels; 1 where these have
/// no volume in common.
[[nodiscard]] Result<double> gainByOthers(const TomographyView& view,
                                          std::vector<TomographyView> others,
                                          const VolumeGeometry& geometry, const Progress& progress);

/// The sentence on a gain that is not the same in all frames.
/// @param frames, gains  those that were looked at
[[nodiscard]] std::string describeGains(const std::string& camera, std::span<const int> frames,
                                        std::span<const double> gains);

/// The sentence on a mistake.
/// @param pixelCentre  as above
[[nodiscard]] std::string describeFault(const CaptureFault& fault,
                                        const std::vector<TomographyView>& views,
                                        double pixelCentre);

/// The sentence on a mistake that is in these frames alone.
[[nodiscard]] std::string describeInFrames(const CaptureFault& fault,
                                           const std::vector<TomographyView>& views,
                                           std::span<const int> frames);

}  // namespace volute
