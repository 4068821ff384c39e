// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Corners of opaque things, before a pinhole or a parallel camera; row 0 of the picture is its top.

#ifdef PICTURE
out vec2 place;  // of the picture, from its top left
uniform vec3 corner, alongRight, alongDown;
#else
layout(location = 0) in vec3 corner;
layout(location = 1) in vec3 cornerLight;
out vec3 light;
#endif
out vec3 fromEye;
out float ahead;  // [m] along the view

uniform vec3 eye, right, down, forward;
// Half the picture's width and height at distance 1, the nearest that is drawn [m]; of a parallel
// camera in the world [m], 1 / (4 the farthest).
uniform vec3 lens;
uniform int parallel;
uniform vec3 middle;  // where `forward` is in the picture, -1..1

void main() {
#ifdef PICTURE
  place = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  vec3 at = corner + place.x * alongRight + place.y * alongDown;
#else
  vec3 at = corner;
  light = cornerLight;
#endif
  fromEye = at - eye;
  ahead = dot(fromEye, forward);
  vec2 across = vec2(dot(fromEye, right), dot(fromEye, down)) / lens.xy;
  gl_Position = parallel != 0 ? vec4(across + middle.xy, 0.5 - ahead * lens.z, 1.0)
                              : vec4(across + middle.xy * ahead, lens.z, ahead);  // nearest / ahead
}
