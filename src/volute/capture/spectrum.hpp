// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <filesystem>
#include <vector>

#include "volute/base/remark.hpp"
#include "volute/base/result.hpp"
#include "volute/math/vec.hpp"

namespace volute {

class JsonValue;

/// What the cameras' channels see of each wavelength, and how much light a value means: for the
/// temperature of flames.
struct CaptureSpectrum {
  /// Light of one wavelength.
  struct Line {
    double wavelength = 0;  ///< [nm]
    Rgb weight =
        Rgb::Zero();  ///< of a channel's sensitivity, times the width that it stands for [nm]
  };

  std::vector<Line> lines;  ///< ascending; empty: not stated
  Rgb scale =
      Rgb::Ones();  ///< a channel's value over sum(weight * spectral radiance [W/(m^2 sr nm)])
  double sootExponent = 1;  ///< extinction goes with wavelength^-sootExponent

  bool stated() const { return !lines.empty(); }

  static constexpr double kReference = 550;  ///< [nm], at which extinction is given

  /// The values of a black body [K].
  Rgb blackBody(double temperature) const;

  /// What a metre of soot with an extinction of 1/m at kReference sends where nothing takes light.
  Rgb sootEmission(double temperature) const;
};

/// Spectral radiance of a black body [W/(m^2 sr nm)] at a wavelength [nm] (Planck's law).
double planck(double wavelength, double temperature);

/// The member "spectrum" of a capture.json; tables are files relative to `folder`.
/// @param remarks  gets what is doubtful
[[nodiscard]] Result<CaptureSpectrum> readSpectrum(const JsonValue& value,
                                                   const std::filesystem::path& folder,
                                                   std::vector<Remark>& remarks);

}  // namespace volute
