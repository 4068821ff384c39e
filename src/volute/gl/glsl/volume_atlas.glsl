// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Voxels from an atlas of the bricks that are not empty. Each has the voxels of its 8^3 cells: 8 a side (box), or 9, so
// that the corners of a cell are always in one brick (trilinear). Channels stand above each other along z.

uniform isampler3D M_bricks;     // number of each brick in the atlas, -1 for an empty one
uniform sampler3D M_atlas;
uniform ivec3 M_atlasBricks;     // how many it has along each axis

#if M_TRILINEAR
const int M_side = 9;
#else
const int M_side = 8;
#endif

ivec3 M_corner;  // texel of the open brick that is voxel (0, 0, 0)

bool M_open(ivec3 brick) {
  int number = texelFetch(M_bricks, brick, 0).r;
  if (number < 0) return false;
  ivec3 place = ivec3(number % M_atlasBricks.x, number / M_atlasBricks.x % M_atlasBricks.y,
                      number / (M_atlasBricks.x * M_atlasBricks.y));
  M_corner = place * ivec3(M_side, M_side, M_side * M_CHANNELS) - brick * 8 + (M_side - 8);
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
