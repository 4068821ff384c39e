// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// The transmittance splat: for each tet (an instance) the box of pixels that it may touch, a strip of four vertices.
// What the ray has in it is found in each pixel, exactly, so that a box that is a pixel too large costs no accuracy.

layout(std430) readonly buffer Places { vec4 places[]; };        // [m], from the mesh's middle
layout(std430) readonly buffer Extinctions { float extinctions[]; };  // [1/m]
layout(std430) readonly buffer Tets { ivec4 tets[]; };
layout(std430) readonly buffer Planes { vec4 planes[]; };        // of each face: unit normal into its first tet, and
                                                                 // its distance from the mesh's middle [m]
layout(std430) readonly buffer TetFaces { ivec4 tetFaces[]; };   // across each vertex: 4 * face, + 1 for the second tet,
                                                                 // + 2 on the boundary

uniform vec3 eye;         // [m], from the mesh's middle
uniform mat3 toView;      // right, down and forward in rows
uniform mat3 toImage;     // from there to the picture's pixels, homogeneous
uniform vec2 halfSize;    // [pixels]
uniform float nearest;    // [m]; what is nearer is too short to count
uniform int orthographic;
uniform float negligible; // [1/m]: thinner smoke is left out

flat out vec4 across[4];     // of the face across each vertex: normal inwards, and the eye's distance inwards [m]
flat out vec4 extinctionPerMetre;  // of each vertex, over its distance from that face
flat out vec4 sharePerMetre;
flat out int seconds;        // bits: the tet is the face's second
flat out int boundaries;     // bits: the face has no second

void widen(vec3 seen, inout vec2 low, inout vec2 high) {
  vec3 pixel = toImage * seen;
  low = min(low, pixel.xy / pixel.z);
  high = max(high, pixel.xy / pixel.z);
}

void main() {
  ivec4 tet = tets[gl_InstanceID];
  vec4 extinction = vec4(extinctions[tet.x], extinctions[tet.y], extinctions[tet.z], extinctions[tet.w]);
  seconds = 0;
  boundaries = 0;
  for (int i = 0; i < 4; ++i) {
    int face = tetFaces[gl_InstanceID][i];
    vec4 plane = planes[face >> 2];
    precise float away = dot(plane.xyz, eye) - plane.w;
    float inwards = (face & 1) == 0 ? 1.0 : -1.0;
    across[i] = inwards * vec4(plane.xyz, away);
    seconds |= (face & 1) << i;
    boundaries |= (face >> 1 & 1) << i;
    sharePerMetre[i] = 1.0 / abs(dot(plane.xyz, places[tet[i]].xyz) - plane.w);
  }
  extinctionPerMetre = extinction * sharePerMetre;
  gl_Position = vec4(2.0, 2.0, 0.0, 1.0);
  if (max(max(extinction.x, extinction.y), max(extinction.z, extinction.w)) <= negligible) return;
  // The box of the part that is not nearer than `nearest`: of its vertices, and of where its edges cross that plane.
  float from = orthographic != 0 ? 0.0 : nearest;
  vec3 seen[4];
  vec2 low = vec2(1e30);
  vec2 high = vec2(-1e30);
  for (int i = 0; i < 4; ++i) {
    seen[i] = toView * (places[tet[i]].xyz - eye);
    if (orthographic != 0) seen[i].z = 1.0;
    if (seen[i].z > from) widen(seen[i], low, high);
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = i + 1; j < 4; ++j) {
      if ((seen[i].z > from) == (seen[j].z > from)) continue;
      float share = clamp((from - seen[i].z) / (seen[j].z - seen[i].z), 0.0, 1.0);
      widen(vec3(mix(seen[i].xy, seen[j].xy, share), from), low, high);
    }
  }
  if (low.x > high.x) return;  // behind the eye
  low = clamp((low - 0.1) / halfSize - 1.0, -1.0, 1.0);
  high = clamp((high + 0.1) / halfSize - 1.0, -1.0, 1.0);
  gl_Position = vec4((gl_VertexID & 1) == 0 ? low.x : high.x, (gl_VertexID & 2) == 0 ? low.y : high.y, 0.0, 1.0);
}
