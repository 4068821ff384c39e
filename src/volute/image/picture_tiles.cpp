// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/image/picture_tiles.hpp"

#include <algorithm>
#include <cmath>

namespace volute {
namespace {

constexpr int kSmallestTile = 64;  // [pixels] a side

}  // namespace

std::vector<PictureTile> pictureTiles(int width, int height, int about) {
  const double side = std::sqrt(static_cast<double>(width) * height / std::max(about, 1));
  const auto count = [&](int length) {
    const int most = std::max(1, length / kSmallestTile);
    return std::clamp(static_cast<int>(std::lround(length / side)), 1, most);
  };
  const int columns = count(width), rows = count(height);
  std::vector<PictureTile> tiles;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const int left = column * width / columns, top = row * height / rows;
      tiles.push_back(
          {left, top, (column + 1) * width / columns - left, (row + 1) * height / rows - top});
    }
  }
  std::ranges::stable_sort(tiles, {}, [&](const PictureTile& tile) {
    const double x = tile.left + 0.5 * (tile.width - width);
    const double y = tile.top + 0.5 * (tile.height - height);
    return x * x / (1.0 * width * width) + y * y / (1.0 * height * height);
  });
  return tiles;
}

}  // namespace volute
