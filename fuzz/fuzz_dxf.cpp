// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "fuzz/input_folder.hpp"
#include "volute/visibility/plan_underlay.hpp"

// A drawing as it is laid over a case of 20 m x 10 m. Errors are fine; lines that are nowhere are
// not.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const volute::fuzz::InputFolder folder("dxf");
  const auto file = folder.save("a.dxf", volute::fuzz::textOf(data, size));
  volute::UnderlayOptions options{{0, 0}, {20, 10}, {}, 1 << 20};
  std::vector<volute::Remark> remarks;
  const auto underlay = volute::readUnderlay(file, options, remarks);
  if (!underlay)
    return 0;
  for (const auto& [from, to] : underlay->lines)
    volute::fuzz::require(from.allFinite() && to.allFinite());
  return 0;
}
