// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "fuzz/input_folder.hpp"
#include "volute/io/netcdf_length.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const volute::fuzz::InputFolder folder("netcdf");
  (void)volute::checkNetcdfLength(folder.save("a.ex2", volute::fuzz::textOf(data, size)));
  return 0;
}
