// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// One triangle over the whole screen.

out vec2 place;  // 0..1, from the top left

void main() {
  vec2 corner = vec2(gl_VertexID << 1 & 2, gl_VertexID & 2);
  place = vec2(corner.x, 1.0 - corner.y);
  gl_Position = vec4(2.0 * corner - 1.0, 0.0, 1.0);
}
