// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <cstddef>

// What `volute bench codec --peers FOLDER` builds of a peer's sources.
extern "C" {
/// @param sides  t, z, y, x
/// @param bytes  of malloc()
/// @return their number; 0 where it cannot be done
std::size_t volute_peer_encode(const float* values, const std::size_t* sides, double tolerance,
                               unsigned char** bytes);
/// @return 0 where it was done
int volute_peer_decode(const unsigned char* bytes, std::size_t size, const std::size_t* sides,
                       float* values);
}
