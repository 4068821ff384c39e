// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "fuzz/input_folder.hpp"
#include "volute/io/json_file.hpp"
#include "volute/scene/scene_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const volute::fuzz::InputFolder folder("scene");
  (void)volute::readScene(folder.save("scene.json", volute::fuzz::textOf(data, size)).string());
  return 0;
}
