// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Light that was scattered before, towards the eye, as lighting/diffuse_light.cpp has it: trilinear between the middles of
// cells. M_ stands for the medium's own prefix.

layout(std430) readonly buffer M_Again { uint M_againWords[]; };  // of each cell three times: radiance, its change along x, y, z

uniform vec3 M_againLow;       // from the picture's origin [m]
uniform vec3 M_againPerMetre;  // cells
uniform ivec3 M_againCells;
uniform vec3 M_againAlbedo;

vec3 M_again(vec3 place) {
  vec3 at = (place - M_againLow) * M_againPerMetre - 0.5;
  if (any(lessThan(at, vec3(-1.0))) || any(greaterThan(at, vec3(M_againCells)))) return vec3(0.0);
  vec3 inside = clamp(at, vec3(0.0), vec3(M_againCells - 1));
  ivec3 first = ivec3(inside);
  ivec3 second = min(first + 1, M_againCells - 1);
  vec3 share = inside - vec3(first);
  vec4 sum[3] = vec4[3](vec4(0.0), vec4(0.0), vec4(0.0));
  for (int corner = 0; corner < 8; ++corner) {
    bvec3 high = bvec3((corner & 1) != 0, (corner & 2) != 0, (corner & 4) != 0);
    vec3 weights = mix(1.0 - share, share, high);
    ivec3 cell = ivec3(high.x ? second.x : first.x, high.y ? second.y : first.y, high.z ? second.z : first.z);
    int word = 12 * (cell.x + M_againCells.x * (cell.y + M_againCells.y * cell.z));
    for (int c = 0; c < 3; ++c) {
      for (int k = 0; k < 4; ++k) sum[c][k] += weights.x * weights.y * weights.z * uintBitsToFloat(M_againWords[word + 4 * c + k]);
    }
  }
  vec3 light;
  for (int c = 0; c < 3; ++c) light[c] = max(sum[c].x - dot(sum[c].yzw, rayDirection), 0.0);
  return M_againAlbedo * light;
}
