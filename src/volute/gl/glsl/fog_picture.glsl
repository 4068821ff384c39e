// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Fog alone, walked (fog_walk.glsl) or by its polar table (fog_polar.glsl); follows ray.glsl and those.

uniform vec3 color;    // radiance of infinitely thick fog
uniform float factor;  // of its extinction

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, firstRow);
  if (any(greaterThanEqual(pixel, size))) return;
  float t = 0.0;
  if (castRay(pixel)) {
    float distance = min(rayEnd, 1e30);
#if FOG_BY_TABLE
    t = factor * fogPolarOpticalDepth(vec3(0.0), rayDirection, distance);
#else
    t = factor * fogOpticalDepth(vec3(0.0), rayDirection, distance);
#endif
  }
  imageStore(picture, pixel, vec4((t < 1e-3 ? t * (1.0 - 0.5 * t) : 1.0 - exp(-t)) * color, t));
}
