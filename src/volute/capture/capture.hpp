// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "volute/base/remark.hpp"
#include "volute/camera/camera.hpp"
#include "volute/capture/response.hpp"
#include "volute/capture/spectrum.hpp"
#include "volute/math/box.hpp"

namespace volute {

class FolderFiles;

/// What pictures tell of the medium along a line of sight.
enum class Measured {
  kEmission,    ///< its light, in front of a background that is subtracted where it is known
  kAbsorption,  ///< its optical depth: how much it weakens a background that is lit
};

/// Where the time of a frame lies among a camera's pictures.
struct PicturePlace {
  int number = 0;    ///< of the picture at that time, or of the last before it
  double share = 0;  ///< of the time to the next picture that has gone by, 0..1; 0: `number` alone
};

/// Where the pictures of one camera are, and what their values mean.
struct PictureSource {
  std::string image;            ///< the files: %04d, %d or #### stands for the frame; empty: a film
  int pages = 1;                ///< above 1: of one file, a .tif, whose page n is picture number n
  bool linear = false;          ///< the files hold floats, which are light
  std::filesystem::path video;  ///< the film; empty: files
  double videoStart = 0;        ///< the frame at which the film's first picture, or file number 0,
                                ///< was taken
  double frameShift = 0;        ///< the picture of frame n is that of n + frameShift: its clock is
                                ///< wrong by so many frames
  double rate = 1;              ///< pictures for each frame of the capture
  int filmPictures = 0;         ///< how many the film has; 0: they were not counted
  /// Of films whose pictures do not follow each other evenly: where each lies, counted in pictures
  /// of the steady rate from the first, ascending. Empty: at 0, 1, 2 and so on.
  std::vector<double> filmPlaces{};
  std::filesystem::path background;  ///< a picture without the medium; empty: none
  std::filesystem::path dark;  ///< a picture with the lens covered, subtracted from all others, as
                               ///< they are stored; empty: none
  std::filesystem::path mask;  ///< 0 = ignore the pixel (obstructors); empty: none
  double exposure = 1;         ///< by which its linear values, its background's too, are
                               ///< divided
  double gain = 1;             ///< a factor on its linear values; of kAbsorption, where
                               ///< that cancels out, on its optical depths
  Rgb channelGain = Rgb::Ones();  ///< the same for each channel, besides `gain`
  bool gainByFrame = false;       ///< besides, each frame has a gain of its own, which what the
                                  ///< other cameras predict tells (auto exposure); kEmission
  std::vector<int> leftOut{};     ///< frames of which its picture is not that: as if none were
  double exponent = 1;            ///< a power of the linear values, 1 = white, before white
                                  ///< and gain: mends a response that is nearly right
  /// Of integers and films; floats (.exr, .pfm, some .tif and .npy) are linear. Without it what
  /// each .png or .tif states, else sRGB.
  std::optional<Response> response;
  /// A channel that reads this or more is saturated: a stored value, 1 = white. Without it 250/255
  /// for films, nothing for floats, and for integers 1, or less where many pixels read one largest
  /// value.
  std::optional<double> saturation;
  int bits = 0;           ///< of the values in files of more: white is 2^bits - 1; 0: the files'
  double black = 0;       ///< the stored value of darkness in integers and films, 1 = white
  bool bottomUp = false;  ///< the first row is the lowest, of background and mask as well

  /// The factor of linear values of kEmission.
  double lightGain() const { return gain / exposure; }

  /// What shows frame `n`: a whole picture where one was taken within a hundredth of the time
  /// between pictures, else two.
  PicturePlace placeOf(int frame) const;

  /// The file of picture `number`.
  std::filesystem::path fileOf(int number) const;

  /// Whether the file of picture `number` is there and has it; of files alone.
  bool isThere(int number) const;

  /// The numbers of the pictures that are there, ascending; of files alone.
  std::vector<int> numbersThere(FolderFiles& folders) const;

  /// Where picture `number` of the film lies, see filmPlaces.
  double placeInFilm(int number) const {
    return filmPlaces.empty() ? number : filmPlaces[static_cast<std::size_t>(number)];
  }
};

/// One calibrated camera of a capture.
struct CaptureCamera {
  std::string name;
  Camera camera;
  PictureSource pictures;
  double reprojectionError = 0;  ///< how far off its sights are, root mean square [pixels]; 0: not
                                 ///< stated
};

/// A lamp of the laboratory that lights the medium.
struct CaptureLamp {
  bool sun = true;                  ///< else a point
  Vec3 direction = -Vec3::UnitZ();  ///< of a sun: the way its light travels; unit
  Vec3 position = Vec3::Zero();     ///< of a point [m]
  Rgb light = Rgb::Ones();          ///< sun: what arrives, per area that faces it; point: power per
                                    ///< solid angle; in the unit of the pictures' radiance
};

/// Lamps around a medium that scatters.
struct CaptureLighting {
  std::vector<CaptureLamp> lamps;
  Rgb albedo = Rgb::Ones();  ///< share of the extinguished light that is scattered, 0..1
};

/// The place of the volume that is looked for.
struct CaptureVolume {
  Box3 bounds;                      ///< outer voxel faces [m]
  std::array<int, 3> resolution{};  ///< voxels on x, y, z
};

/// What cameras saw of a medium, and how to read it. Voxel (i, j, k) is centred at
/// bounds.min + (i + 0.5, j + 0.5, k + 0.5) voxel sizes.
struct Capture {
  std::filesystem::path file;  ///< where it was read from
  std::string kind;            ///< "capture.json", "NeRF transforms", "COLMAP", "OpenCV"
  Measured measured = Measured::kEmission;
  double pixelCentre = 0.5;  ///< of the file's coordinates; the cameras have it settled
  std::vector<CaptureCamera> cameras;
  std::vector<int> frames;  ///< ascending; those that were chosen
  /// All that the file states; empty: none, they are those of which there are pictures.
  std::vector<int> statedFrames;
  int firstFrame = 0;  ///< of the whole capture, or 0 where a camera is a film or states when it
                       ///< begins: its time is 0 s
  CaptureVolume volume;
  CaptureLighting lighting;          ///< without lamps: not stated
  CaptureSpectrum spectrum;          ///< of the channels; not stated: colours are no spectrum
  double framesPerSecond = 25;       ///< the time of frame n is that of n / framesPerSecond
  double white = 1;                  ///< linear radiance of a value of 1
  std::optional<double> noiseSigma;  ///< of one pixel's channel, as radiance: of the light, also
                                     ///< of kAbsorption
  std::vector<int> emptyFrames;      ///< frames without the medium, to estimate backgrounds from
  std::vector<Remark> remarks;       ///< what a person should know: conventions, unknown keys

  /// The noise of what a reconstruction fits; nothing: to be estimated, as that of optical depths,
  /// which is `noiseSigma` over the light of each pixel.
  std::optional<double> fittedNoise() const {
    return measured == Measured::kEmission ? noiseSigma : std::nullopt;
  }
};

/// The position of a camera; nothing when there is none of that name.
std::optional<std::size_t> findCamera(const Capture& capture, const std::string& name);

}  // namespace volute
