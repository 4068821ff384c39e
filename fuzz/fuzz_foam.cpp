// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "fuzz/input_folder.hpp"
#include "volute/io/foam_files.hpp"

// A file of OpenFOAM, as a field and as a list.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text = volute::fuzz::textOf(data, size);
  (void)volute::checkFoamText(text, "internalField");
  (void)volute::checkFoamText(text, "points");
  return 0;
}
