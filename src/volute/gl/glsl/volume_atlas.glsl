// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Voxels from an atlas of the bricks that are not empty. Each has the voxels of its 8^3 cells: 8 a side (box), or 9, so
// that the corners of a cell are always in one brick (trilinear). Channels stand above each other along z.

uniform sampler3D M_atlas;

#if M_TRILINEAR
const int M_side = 9;
#else
const int M_side = 8;
#endif

ivec3 M_corner;  // texel of the open brick that is voxel (0, 0, 0)

bool M_open(ivec3 brick) {
  int number = M_number(M_base + brick);
  if (number < 0) return false;
  M_corner = M_place(number) * ivec3(M_side, M_side, M_side * M_CHANNELS) - brick * 8 + (M_side - 8);
  return true;
}

#if M_CHANNELS == 1
float M_voxel(ivec3 voxel) { return texelFetch(M_atlas, M_corner + voxel, 0).r; }
#else
vec3 M_voxel(ivec3 voxel) {
  ivec3 at = M_corner + voxel;
  return vec3(texelFetch(M_atlas, at, 0).r, texelFetch(M_atlas, at + ivec3(0, 0, M_side), 0).r,
              texelFetch(M_atlas, at + ivec3(0, 0, 2 * M_side), 0).r);
}
#endif
