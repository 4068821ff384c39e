// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// What is seen of signs once the smoke's optical depth before them is known: each through the transmittance of its own
// law (Staubli et al. 2005, section 4.4 and equations 14 and 15).

layout(local_size_x = 8, local_size_y = 8) in;

layout(rgba32f, binding = 0) writeonly uniform image2D light;

layout(std430) readonly buffer Powers { float powers[]; };  // of each sign: it is seen through exp(-power depth)

uniform sampler2D seen;
uniform isampler2D numbers;
uniform sampler2D depths;  // w: optical depth up to the sign, natural logarithm

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, textureSize(numbers, 0)))) return;
  int number = texelFetch(numbers, pixel, 0).r;
  vec3 color = vec3(0.0);
  if (number >= 0) color = texelFetch(seen, pixel, 0).rgb * exp(-powers[number] * texelFetch(depths, pixel, 0).w);
  imageStore(light, pixel, vec4(color, 0.0));
}
