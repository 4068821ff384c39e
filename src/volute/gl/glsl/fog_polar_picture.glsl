// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Fog alone, by its polar table; follows ray.glsl and fog_polar.glsl.

uniform vec3 color;    // radiance of infinitely thick fog
uniform float factor;  // of its extinction

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy) + ivec2(0, firstRow);
  if (any(greaterThanEqual(pixel, size))) return;
  float t = castRay(pixel) ? factor * fogPolarOpticalDepth(vec3(0.0), rayDirection, min(rayEnd, 1e30)) : 0.0;
  imageStore(picture, pixel, vec4((1.0 - exp(-t)) * color, t));
}
