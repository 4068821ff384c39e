// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Vertices of projected tetrahedra (Staubli et al. 2005, Figure 3). The triangles drawn are the tets' fronts, so that
// the depth test culls those behind walls and no others. On each triangle front and back are planes; what is affine on
// the back is, times w / w of the back, affine on the front, and so are gap and backField: the rasteriser interpolates
// them exactly, clipped or not.

layout(location = 0) in vec4 place;  // from the eye [m]; gap: 1 - w / w of the back, or (orthographic) the length [m]
layout(location = 1) in vec4 front;  // extinction [1/m], source
layout(location = 2) in vec4 back;   // the same, times 1 - gap

uniform mat3 toView;      // right, down and forward in rows
uniform mat3 toImage;     // from there to the picture's pixels, homogeneous
uniform vec2 halfSize;    // [pixels]
uniform float nearest;    // [m]; depths are nearest / w
uniform int orthographic;
uniform float farthest;   // [m] from the eye's plane, where orthographic

out vec4 frontField;
out vec4 backField;
out float gap;
out float depth;  // along the view [m]

void main() {
  frontField = front;
  backField = back;
  gap = place.w;
  vec3 seen = toView * place.xyz;
  depth = seen.z;
  if (orthographic != 0) {
    vec2 pixel = (toImage * vec3(seen.xy, 1.0)).xy;
    gl_Position = vec4(pixel / halfSize - 1.0, 0.5 - 0.25 * seen.z / farthest, 1.0);
  } else {
    vec3 pixel = toImage * seen;
    gl_Position = vec4(pixel.xy / halfSize - seen.z, nearest, seen.z);
  }
}
