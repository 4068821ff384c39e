// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <memory>
#include <span>
#include <string>

#include "volute/base/result.hpp"

namespace volute {

/// From light to what a display shows, as a colour management system has it.
class ViewTransform {
 public:
  virtual ~ViewTransform() = default;

  /// Display and view: "sRGB/ACES 1.0".
  virtual std::string name() const = 0;

  /// Linear light of sRGB's primaries becomes the display's code values, 0 to 1, in place: RGB
  /// pixels. May be called by several threads.
  virtual void apply(std::span<float> pixels) const = 0;
};

/// Functions of the plug-in for colour management.
struct ViewPlugin {
  /// The Academy's rendering for a display of sRGB (ACES 1.0, SDR video).
  Result<std::unique_ptr<const ViewTransform>> (*aces)();
  /// A view of the configuration that the environment's OCIO names.
  /// @param view  "VIEW" or "DISPLAY/VIEW"; empty: the configuration's own choice
  Result<std::unique_ptr<const ViewTransform>> (*configured)(const std::string& view);
};

}  // namespace volute
