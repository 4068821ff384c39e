// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Light and transmittance to light and optical depth.

layout(local_size_x = 8, local_size_y = 8) in;

layout(rgba32f, binding = 0) writeonly uniform image2D picture;

uniform sampler2D blended;

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, textureSize(blended, 0)))) return;
  vec4 value = texelFetch(blended, pixel, 0);
  imageStore(picture, pixel, vec4(value.rgb, -log(clamp(value.a, 1e-37, 1.0))));
}
