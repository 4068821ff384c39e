// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// A billboard's texture from the picture of its volume: light, and what it lets through.

layout(local_size_x = 8, local_size_y = 8) in;

layout(rgba32f, binding = 0) writeonly uniform image2D sheet;

uniform sampler2D drawn;  // light and optical depth
uniform int byIntensity;  // 1 - the brightest channel passes (Ahrenberg et al. 2005, section 5.2), else what the volume lets

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, textureSize(drawn, 0)))) return;
  vec4 value = texelFetch(drawn, pixel, 0);
  float brightest = max(max(value.r, value.g), value.b);
  float passed = byIntensity != 0 ? 1.0 - clamp(brightest, 0.0, 1.0) : exp(-value.a);
  imageStore(sheet, pixel, vec4(value.rgb, passed));
}
