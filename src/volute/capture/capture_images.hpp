// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <map>
#include <memory>
#include <vector>

#include "volute/base/progress.hpp"
#include "volute/capture/background_drift.hpp"
#include "volute/capture/capture.hpp"
#include "volute/capture/stored_values.hpp"
#include "volute/image/image.hpp"
#include "volute/io/film_frames.hpp"

namespace volute {

/// One camera's picture of one frame as radiance, or as optical depths where the capture is one of
/// absorption.
struct CameraPicture {
  Image radiance;             ///< measured minus background, linear RGB; negative values are kept;
                              ///< or optical depths
  Image background;           ///< what was subtracted, linear RGB; empty: nothing
  std::vector<float> weight;  ///< (height, width), 0 = saturated or masked, else 1; of optical
                              ///< depths the light that is left, see OpticalDepths
  std::vector<std::uint8_t> atLeast;  ///< (height, width), bit c: channel c is saturated, or lets
                                      ///< no light through; `radiance` is the bound
  std::optional<BackgroundDrift> drift;  ///< of the background, where it was found and undone
  double brightest = 0;                  ///< of the measured channels, background included
  double saturatedShare = 0;             ///< of the pixels that are not masked
  double opaqueShare = 0;             ///< of the pixels with a lit background, those without light
  double litBackgroundSaturated = 0;  ///< of them, those whose background is saturated
  double levelLeft = 0;               ///< see OpticalDepths
  double maskedShare = 0;             ///< of all pixels
  double transparentShare = 0;        ///< of all pixels of floats, those with alpha < 1
  double transparentMask = 0;         ///< of all pixels, those that are transparent in the mask
  bool grey = false;                  ///< one channel in the file
  bool mosaic = false;                ///< brightness goes by the place in blocks of 2 x 2 pixels
  std::optional<StoredPlateau> plateau;  ///< where the capture states no saturation
  int bitsHolding = 0;  ///< see bitsHolding(); 0 also where the capture states bits or saturation
  double largest = 65535;  ///< the integer that is 1 in its file
  /// What all pixels beside the volume show, as a stored value: a black level, which was
  /// subtracted; 0: nothing.
  double storedPedestal = 0;
  /// Where each channel stops counting, see channelLimits(); nothing: all at one value.
  std::optional<std::array<double, 3>> channelLimits{};
  double counts = 0;             ///< the largest of floats that are whole numbers; 0: they are not
  bool dividedIntegers = false;  ///< floats as encoded integers divided, see areDividedIntegers()
};

/// Reads the pictures of a capture: makes them linear, applies gain and white, subtracts the
/// background as it has drifted, or divides by it and takes the logarithm, and finds what does not
/// count. Every error names the camera and the frame.
class CaptureImages {
 public:
  /// Reads masks and backgrounds; estimates those backgrounds that are not given from the empty
  /// frames, if there are any. `capture` must outlive it.
  [[nodiscard]] static Result<CaptureImages> open(const Capture& capture, std::uint64_t maxMemory,
                                                  Progress& progress);

  /// @param camera  position in the capture.
  /// @param frame  number; where it lies between two of the camera's pictures they are mixed, as
  ///   light, by the time. kNotFound when there is no such picture, kInvalidData for a size that is
  ///   not the camera's, a value that is not finite, or a .png with transparent pixels.
  [[nodiscard]] Result<CameraPicture> read(std::size_t camera, int frame);

  /// True when the camera's pictures have something subtracted.

 private:
  /// A picture as it is stored, 1 = white, before anything is made of it.
  struct Stored {
    Image image;
    std::array<double, 3> saturation{};    // a channel that reads this or more is saturated
    bool linear = false;                   // floats
    Response response = Response::srgb();  // of others
    double transparentShare = 0;
    std::optional<StoredPlateau> plateau;
    int bitsHolding = 0;
    double largest = 65535;  // the integer that is 1
    bool mosaic = false;
    std::vector<std::uint8_t> there{};  // of each pixel; 0: the file holds nothing; empty: all
    std::optional<std::array<double, 3>> channelLimits{};
    double counts = 0;
    bool dividedIntegers = false;
  };

  CaptureImages(const Capture& capture, std::uint64_t maxMemory)
      : capture_(&capture), maxMemory_(maxMemory) {}

  /// One picture as light, before anything is subtracted.
  struct Seen {
    int number = -1;
    Image light;                        // linear RGB
    std::vector<std::uint8_t> atLeast;  // (height, width), bit c: channel c is saturated
    double transparentShare = 0;
    bool grey = false;
    bool mosaic = false;
    std::optional<StoredPlateau> plateau;
    int bitsHolding = 0;
    double largest = 65535;
    std::optional<Response> response;   // by which it became light; none: floats
    std::vector<std::uint8_t> there{};  // see Stored
    std::optional<std::array<double, 3>> channelLimits{};
    double counts = 0;
    bool dividedIntegers = false;
  };

  // `number` is the picture's, `frame` that which it is for: messages name it.
  std::string nameOf(std::size_t camera, int frame) const;
  [[nodiscard]] Result<Seen> readSeen(std::size_t camera, int number, int frame);
  [[nodiscard]] Result<Seen> readKept(std::size_t camera, int number, int frame);
  [[nodiscard]] Result<Seen> readAt(std::size_t camera, int frame);
  [[nodiscard]] Result<Stored> readStored(std::size_t camera, int number, int frame);
  [[nodiscard]] Result<Stored> readFile(std::size_t camera, const std::filesystem::path& path,
                                        const std::string& name, int page = 0) const;
  void findIntegers(std::size_t camera, Stored& stored) const;
  [[nodiscard]] Status checkSize(std::size_t camera, const Image& image,
                                 const std::string& name) const;
  void subtractBackground(std::size_t camera, CameraPicture& picture) const;
  void subtractPedestal(std::size_t camera, const std::optional<Response>& response,
                        CameraPicture& picture);
  Image linearised(std::size_t camera, const Stored& stored) const;
  [[nodiscard]] Result<Image> medianBackground(std::size_t camera, Progress& progress);
  [[nodiscard]] Status openMask(std::size_t camera);
  [[nodiscard]] Status openDark(std::size_t camera);
  [[nodiscard]] Status withoutDark(std::size_t camera, Stored& stored) const;
  [[nodiscard]] Status openBackground(std::size_t camera, Progress& progress);

  const Capture* capture_;
  std::uint64_t maxMemory_;
  std::vector<std::vector<char>> masks_;                       // 0 = ignore; empty: none
  std::vector<double> transparentMasks_;                       // shares of their pixels
  std::vector<Stored> darks_;                                  // without pixels: none
  std::vector<Image> backgrounds_;                             // linear RGB; empty: none
  std::vector<std::vector<std::uint8_t>> backgroundsAtLeast_;  // as Seen::atLeast
  std::vector<std::vector<std::uint8_t>> beside_;  // pixels that show the background; empty: none
  std::map<std::size_t, FilmFrames> films_;
  // Of cameras between whose pictures frames lie, the last two: the next frame needs them again.
  std::map<std::size_t, std::array<Seen, 2>> kept_;
};

/// Before any picture is read: kNotFound when a mask or a background is missing, or more than half
/// of a camera's pictures, or so many of a frame's that fewer than three cameras see it; a picture
/// of 0 bytes is missing. Names the first, and how many the cameras have. Those that a camera's
/// shift of frames takes beyond the first and the last frame do not count. Films are opened, for
/// they may not be there, be of another size, begin later or end earlier; their frames are counted
/// and not decoded.
/// @param force  go on without the pictures of frames
/// @param maxMemory  [bytes] that decoding a film may take.
/// @return sentences on those that are missing here and there: the other cameras tell alone.
[[nodiscard]] Result<std::vector<std::string>> checkPicturesThere(
    const Capture& capture, bool force = false, std::uint64_t maxMemory = std::uint64_t{4} << 30);

}  // namespace volute
