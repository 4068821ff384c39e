// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Voxels that absorb, may send light of their own (M_CHANNELS 4: extinction, then red, green and blue) and may scatter
// light (M_LIT), from atlases of the bricks that are not empty; each has the 9^3 voxels around its 8^3 cells.

uniform isampler3D M_bricks;     // number of each brick in the atlases, -1 for an empty one
uniform sampler3D M_atlas;
uniform ivec3 M_atlasBricks;     // how many they have along each axis
#if M_LIT
uniform usampler3D M_light;      // square roots of shares of the largest, in 11, 11 and 10 bits
uniform vec3 M_lightScale;
#endif

const int M_side = 9;

ivec3 M_corner;  // texel of the open brick that is voxel (0, 0, 0)

bool M_open(ivec3 brick) {
  int number = texelFetch(M_bricks, brick, 0).r;
  if (number < 0) return false;
  ivec3 place = ivec3(number % M_atlasBricks.x, number / M_atlasBricks.x % M_atlasBricks.y,
                      number / (M_atlasBricks.x * M_atlasBricks.y));
  M_corner = place * M_side - brick * 8 + 1;
  return true;
}

#if M_CHANNELS == 1
#define M_DENSITY(v) (v)
float M_voxel(ivec3 voxel) { return texelFetch(M_atlas, M_corner + voxel, 0).r; }
#else
#define M_DENSITY(v) (v).x
vec4 M_voxel(ivec3 voxel) { return texelFetch(M_atlas, M_corner + voxel, 0); }
#endif

#if M_LIT
vec3 M_scattered(ivec3 voxel) {
  uint bits = texelFetch(M_light, M_corner + voxel, 0).r;
  vec3 root = vec3(bits & 2047u, bits >> 11 & 2047u, bits >> 22);
  return root * root * M_lightScale;
}
#endif
