// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <cstdlib>

#include "SPERR_C_API.h"
#include "peer.hpp"

// One frame: SPERR has three axes.
std::size_t volute_peer_encode(const float* values, const std::size_t* sides, double tolerance,
                               unsigned char** bytes) {
  constexpr int kPointwiseError = 3;
  void* made = nullptr;
  std::size_t size = 0;
  const int failed =
      C_API::sperr_comp_3d(values, 1, sides[3], sides[2], sides[1], sides[3], sides[2], sides[1],
                           kPointwiseError, tolerance, 1, &made, &size);
  *bytes = static_cast<unsigned char*>(made);
  return failed == 0 ? size : 0;
}

int volute_peer_decode(const unsigned char* bytes, std::size_t size, const std::size_t* sides,
                       float* values) {
  void* made = nullptr;
  std::size_t x = 0, y = 0, z = 0;
  const int failed = C_API::sperr_decomp_3d(bytes, size, 1, 1, &x, &y, &z, &made);
  if (failed == 0)
    std::copy_n(static_cast<const float*>(made), sides[1] * sides[2] * sides[3], values);
  std::free(made);
  return failed;
}
