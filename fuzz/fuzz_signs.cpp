// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "fuzz/input_folder.hpp"
#include "volute/visibility/sign_file.hpp"

// Errors are fine; signs that stand or face nowhere are not.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const volute::fuzz::InputFolder folder("signs");
  const auto file = folder.save("signs.json", volute::fuzz::textOf(data, size));
  const auto signs = volute::readSigns(file.string());
  if (!signs)
    return 0;
  for (const volute::SafetySign& sign : *signs)
    volute::fuzz::require(sign.position.allFinite() && sign.normal.allFinite());
  return 0;
}
