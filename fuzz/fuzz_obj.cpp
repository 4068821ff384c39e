// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <string>

#include "volute/io/obj.hpp"

// Errors are fine; crashes, corners that are not finite and materials that are not there are not.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const int file = ::memfd_create("fuzz.obj", 0);
  if (::ftruncate(file, 0) != 0 || ::pwrite(file, data, size, 0) != static_cast<ssize_t>(size))
    std::abort();
  const auto mesh = volute::readObj("/proc/self/fd/" + std::to_string(file), 64 << 20);
  if (!mesh)
    return 0;
  for (const volute::Triangle& triangle : mesh->triangles) {
    if (triangle.material >= mesh->materials.size())
      std::abort();
    for (const volute::Vec3& corner : triangle.corners) {
      if (!corner.allFinite())
        std::abort();
    }
  }
  return 0;
}
