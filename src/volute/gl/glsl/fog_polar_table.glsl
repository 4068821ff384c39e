// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Fills the table of fog_polar.glsl, whose functions it uses, for an eye at the origin.

layout(local_size_x = 8, local_size_y = 8) in;

layout(rgba32f, binding = 0) writeonly uniform image2D entries;

uniform ivec2 first;  // texel of this dispatch

void main() {
  ivec2 texel = first + ivec2(gl_GlobalInvocationID.xy);
  ivec2 shape = imageSize(entries);
  if (any(greaterThanEqual(texel, shape))) return;
  imageStore(entries, texel, fogPolarEntry(vec3(0.0), texel, shape));
}
