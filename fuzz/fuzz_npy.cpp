// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <vector>

#include "fuzz/input_folder.hpp"
#include "volute/io/npy.hpp"
#include "volute/io/volume_source.hpp"

// An array, or an archive of them. Errors are fine; frames that are not as large as they say are
// not.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const volute::fuzz::InputFolder folder("npy");
  const auto text = volute::fuzz::textOf(data, size);
  const auto file = folder.save(text.starts_with("PK") ? "a.npz" : "a.npy", text);
  volute::SourceOptions options;
  options.maxMemory = 16 << 20;
  const auto source = volute::openNpy(file, options);
  if (!source)
    return 0;
  const volute::VolumeInfo& info = (*source)->info();
  volute::fuzz::require(info.frames > 0 && info.x > 0 && info.y > 0 && info.z > 0);
  volute::fuzz::require(info.frameValues() <= (16 << 20) / sizeof(float));
  std::vector<float> values(info.frameValues());
  (void)(*source)->readFrame(info.frames - 1, values);
  return 0;
}
