// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Voxels that absorb, may send light of their own (M_CHANNELS 4: extinction, then red, green and blue) and may scatter
// light (M_LIT), from atlases of the bricks that are not empty; each has the 9^3 voxels around its 8^3 cells.

uniform sampler3D M_atlas;
#if M_LIT
uniform usampler3D M_light;      // square roots of shares of the largest, in 11, 11 and 10 bits
uniform vec3 M_lightScale;
#endif

const int M_side = 9;

ivec3 M_corner;  // texel of the open brick that is voxel (0, 0, 0)

bool M_open(ivec3 brick) {
  int number = M_number(M_base + brick);
  if (number < 0) return false;
  M_corner = M_place(number) * M_side - brick * 8 + 1;
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
