// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Opaque things that are known for each pixel, as surface_fragment.glsl gives them, with the depth that
// surface_vertex.glsl gives to what is so far away.

in vec2 place;
layout(location = 0) out vec4 sent;
layout(location = 1) out float howFar;

uniform sampler2D known;  // radiance, distance along the ray [m]; infinite where nothing is
uniform vec3 lens;        // as in surface_vertex.glsl, and the next two
uniform int parallel;
uniform vec3 middle;

void main() {
  vec4 at = texelFetch(known, ivec2(gl_FragCoord.xy), 0);
  if (isinf(at.a)) discard;
  sent = vec4(at.rgb, 1.0);
  howFar = at.a;
  vec2 aside = (2.0 * gl_FragCoord.xy / vec2(textureSize(known, 0)) - 1.0 - middle.xy) * lens.xy;
  float ahead = at.a / sqrt(1.0 + dot(aside, aside));  // of a pinhole
  gl_FragDepth = parallel != 0 ? 0.5 - at.a * lens.z : lens.z / ahead;
}
