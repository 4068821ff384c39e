// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "fuzz/input_folder.hpp"
#include "volute/io/image_file.hpp"

// Errors are fine; pictures that are not as large as they say are not.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const volute::fuzz::InputFolder folder("picture");
  const bool png = size > 0 && data[0] == 0x89;
  const auto file = folder.save(png ? "a.png" : "a.exr", volute::fuzz::textOf(data, size));
  volute::ImageReadOptions options;
  options.maxMemory = 16 << 20;
  if (const auto image = volute::readImage(file, options)) {
    volute::fuzz::require(image->pixels.size() ==
                          std::size_t(image->width) * image->height * image->channels);
  }
  return 0;
}
