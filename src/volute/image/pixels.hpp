// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

namespace volute {

/// The size of a picture in pixels.
struct Pixels {
  int width = 0;
  int height = 0;
  bool operator==(const Pixels&) const = default;
};

}  // namespace volute
