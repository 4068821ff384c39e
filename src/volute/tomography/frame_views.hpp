// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <span>
#include <string>
#include <vector>

#include "volute/capture/capture_images.hpp"
#include "volute/tomography/view.hpp"

namespace volute {

/// Facts of a picture besides its radiance.
struct PictureFacts {
  double brightest = 0;  ///< of the measured channels, background included
  double saturatedShare = 0;
  double maskedShare = 0;
  double transparentShare = 0;
  double opaqueShare = 0;  ///< of absorption: lets no light through
  bool grey = false;
  bool missing = false;                    ///< there is no picture
  std::optional<BackgroundDrift> drift{};  ///< of the background, undone
  bool mosaic = false;                     ///< see CameraPicture
  std::optional<StoredPlateau> plateau{};
  int bitsHolding = 0;
  double pedestal = 0;                ///< a stored value
  double largest = 65535;             ///< the integer that is 1 in its file
  double litBackgroundSaturated = 0;  ///< of absorption: shares as CameraPicture has them
  double transparentMask = 0;
  std::optional<std::array<double, 3>> channelLimits{};
  double gain = 1;    ///< of this frame, where that is found for each
  double counts = 0;  ///< floats, as CameraPicture has them
  bool dividedIntegers = false;
  double levelLeft = 0;     ///< of absorption, as CameraPicture has it
  bool gainUntold = false;  ///< the gain of this frame: too few cameras tell it
};

/// All cameras at one frame, in the order of the capture.
struct FrameViews {
  int frame = 0;
  bool opticalDepth = false;  ///< the views hold optical depths
  std::vector<TomographyView> views;
  std::vector<PictureFacts> facts;  ///< one a view
  std::vector<char> heldOut;        ///< one a view: only compared with, not fitted

  std::vector<TomographyView> chosen;  ///< a copy of those to fit; empty when that is all of them

  /// The views that are fitted.
  std::span<const TomographyView> fitted() const { return chosen.empty() ? views : chosen; }

  /// The fitted views without one of them.
  std::vector<TomographyView> fittedWithout(std::size_t view) const;

  /// True when every picture has one channel.
  bool grey() const;
};

/// Reads the frames of a capture as views for tomography.
class ViewReader {
 public:
  /// `capture` must outlive it. kInvalidArgument when a held-out camera is none of the capture's.
  [[nodiscard]] static Result<ViewReader> open(const Capture& capture,
                                               const std::vector<std::string>& heldOut,
                                               std::uint64_t maxMemory, Progress& progress);

  [[nodiscard]] Result<FrameViews> read(int frame);

  /// Views have their backgrounds from now on.
  void keepBackgrounds() { keepsBackgrounds_ = true; }

  /// One camera at any frame, one of the capture or not; nothing when there is no such picture. It
  /// has no gain by frame.
  std::optional<TomographyView> neighbour(std::size_t camera, int frame);

  /// One a camera.
  const std::vector<char>& heldOut() const { return heldOut_; }

 private:
  ViewReader(const Capture& capture, CaptureImages images, std::vector<char> heldOut)
      : capture_(&capture),
        images_(std::move(images)),
        heldOut_(std::move(heldOut)),
        greyAmongColours_(heldOut_.size()) {}

  TomographyView viewOf(std::size_t camera, CameraPicture picture) const;

  /// Makes cameras that have a gain by frame as bright as the others predict.
  Status findGains(FrameViews& frame) const;

  const Capture* capture_;
  CaptureImages images_;
  std::vector<char> heldOut_;
  std::vector<char> greyAmongColours_;  // one a camera, by the frames that were read
  bool keepsBackgrounds_ = false;
};

}  // namespace volute
