// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "fuzz/input_folder.hpp"
#include "volute/io/vtk_xml.hpp"

// What .vti, .vtu, .vtp, .pvd and .pvtu files say of themselves, before VTK reads them.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const volute::fuzz::InputFolder folder("vtk_xml");
  (void)volute::readVtkXml(folder.save("a.vtu", volute::fuzz::textOf(data, size)));
  return 0;
}
