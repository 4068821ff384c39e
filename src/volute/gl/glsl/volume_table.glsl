// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// The number of each brick that is not empty, in tables of 8^3 entries below each other: grid/brick_table.hpp. The atlases
// that it counts in come after it.

uniform isampler3D M_bricks;     // the entries, one after the other: 1024 x 1024 x as many as there are
uniform int M_levels;            // of tables
uniform ivec3 M_topStride;       // in entries of the topmost table
uniform ivec3 M_atlasBricks;     // how many bricks the atlases have along each axis

// From the volume's first brick to the one that cells and voxels here count from: floats of cells far away are coarse.
uniform ivec3 M_base;

int M_gap;  // of what M_number() found to be empty: binary logarithm of its bricks a side

int M_entry(int i) { return texelFetch(M_bricks, ivec3(i & 1023, i >> 10 & 1023, i >> 20), 0).r; }

int M_number(ivec3 brick) {
  ivec3 at = brick + 1;
  M_gap = 3 * (M_levels - 1);
  ivec3 top = (at >> M_gap) * M_topStride;
  int entry = M_entry(top.x + top.y + top.z);
  for (int level = 1; level < M_levels && entry >= 0; ++level) {
    M_gap -= 3;
    ivec3 within = at >> M_gap & 7;
    entry = M_entry(entry + (within.z << 6 | within.y << 3 | within.x));
  }
  return entry;
}

ivec3 M_place(int number) {
  return ivec3(number % M_atlasBricks.x, number / M_atlasBricks.x % M_atlasBricks.y,
               number / (M_atlasBricks.x * M_atlasBricks.y));
}
