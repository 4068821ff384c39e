// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#pragma once

#include <array>

// The one node of the hexadeca-tree, and how its 16 basis functions are numbered. Bit a of a
// child's or a coefficient's number belongs to an axis: bit 0 is x, 1 is y, 2 is z, 3 is t. A
// child's bit says which half it is; a coefficient's bit says whether it is a wavelet (1) or a
// scaling function (0) on that axis. Coefficient 0 is the mean.

namespace volute {

inline constexpr int kChildren = 16;

/// From the means of the 16 children to the mean and the 15 wavelet coefficients, and (without the
/// division) back: child o = sum over j of (-1)^popcount(o & j) coefficient j. In this form the
/// coefficients of level l are the orthonormal ones divided by 4^(l + 1), since a basis function of
/// level l covers 16^(l + 1) voxels.
inline void butterfly16(std::array<float, kChildren>& v) {
  for (int bit = 1; bit < kChildren; bit *= 2) {
    for (int i = 0; i < kChildren; ++i) {
      if (i & bit)
        continue;
      const float a = v[i];
      const float b = v[i | bit];
      v[i] = a + b;
      v[i | bit] = a - b;
    }
  }
}

/// 4^(level + 1): orthonormal coefficient / coefficient in mean form.
inline float orthonormalScale(int level) {
  return static_cast<float>(1ull << (2 * (level + 1)));
}

}  // namespace volute
