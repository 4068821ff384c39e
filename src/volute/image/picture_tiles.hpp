// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <vector>

namespace volute {

/// A part of a picture [pixels].
struct PictureTile {
  int left = 0, top = 0, width = 0, height = 0;
};

/// About so many tiles that cover a picture without overlap, those at its middle first. None is
/// smaller than 64 pixels a side, unless the picture is: each has some work of its own.
std::vector<PictureTile> pictureTiles(int width, int height, int about);

}  // namespace volute
