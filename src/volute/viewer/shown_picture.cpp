// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "volute/viewer/shown_picture.hpp"

#include <epoxy/gl.h>

#include <array>
#include <cstdint>

#include "volute/image/srgb.hpp"

namespace volute {

Image shownPicture(int width, int height) {
  std::vector<std::uint8_t> bytes(3 * static_cast<std::size_t>(width) * height);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, bytes.data());
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  std::array<float, 256> decoded;
  for (int i = 0; i < 256; ++i) decoded[i] = static_cast<float>(srgbDecode(i / 255.0));
  Image image(width, height);
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* row = &bytes[3 * static_cast<std::size_t>(height - 1 - y) * width];
    for (int i = 0; i < 3 * width; ++i)
      image.pixels[3 * static_cast<std::size_t>(y) * width + i] = decoded[row[i]];
  }
  return image;
}

}  // namespace volute
