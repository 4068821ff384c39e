// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "fuzz/input_folder.hpp"
#include "volute/fds/fds_input.hpp"

// Input of FDS. Errors are fine; factors that are no numbers above 0 are not.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const volute::fuzz::InputFolder folder("fds_input");
  folder.save("a.fds", volute::fuzz::textOf(data, size));
  const auto input = volute::FdsInput::read(folder.path() / "a.fds");
  if (!input)
    return 0;
  volute::fuzz::require(input->visibilityFactor.value_or(1) > 0);
  volute::fuzz::require(input->maximumVisibility.value_or(1) > 0);
  return 0;
}
