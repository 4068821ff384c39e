// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include <algorithm>
#include <cstdlib>
#include <exception>

#include "SZ3/api/sz.hpp"
#include "peer.hpp"

namespace {

SZ3::Config configOf(const std::size_t* sides) {
  if (sides[0] > 1)
    return {sides[0], sides[1], sides[2], sides[3]};
  return {sides[1], sides[2], sides[3]};
}

}  // namespace

std::size_t volute_peer_encode(const float* values, const std::size_t* sides, double tolerance,
                               unsigned char** bytes) {
  try {
    SZ3::Config config = configOf(sides);
    config.errorBoundMode = SZ3::EB_ABS;
    config.absErrorBound = tolerance;
    std::size_t size = 0;
    char* made = SZ_compress(config, values, size);
    *bytes = static_cast<unsigned char*>(std::malloc(size));
    std::copy_n(made, size, *bytes);
    delete[] made;
    return size;
  } catch (const std::exception&) {
    return 0;
  }
}

int volute_peer_decode(const unsigned char* bytes, std::size_t size, const std::size_t* sides,
                       float* values) {
  try {
    SZ3::Config config = configOf(sides);
    float* to = values;
    SZ_decompress(config, reinterpret_cast<const char*>(bytes), size, to);
    return 0;
  } catch (const std::exception&) {
    return 1;
  }
}
