// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "fuzz/input_folder.hpp"
#include "volute/io/foam_files.hpp"

// What is read of a field's head.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const volute::fuzz::InputFolder folder("foam");
  std::filesystem::create_directory(folder.path() / "10");
  folder.save("10/soot", volute::fuzz::textOf(data, size));
  (void)volute::foamDimensions(folder.path() / "a.foam", "soot", 10);
  (void)volute::foamFields(folder.path() / "a.foam", 10);
  return 0;
}
