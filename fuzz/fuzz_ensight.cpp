// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "fuzz/input_folder.hpp"
#include "volute/io/ensight_files.hpp"

// An input is a case, its geometry a.geo and its field a.smoke, with lines "%%" between them.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const volute::fuzz::InputFolder folder("ensight");
  std::string_view rest = volute::fuzz::textOf(data, size);
  const auto file = folder.save("a.case", volute::fuzz::nextPart(rest));
  folder.save("a.geo", volute::fuzz::nextPart(rest));
  folder.save("a.smoke", volute::fuzz::nextPart(rest));
  if (volute::checkEnsightCase(file))
    (void)volute::checkEnsight(file, "smoke", 0);
  return 0;
}
