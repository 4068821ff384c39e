// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Opaque surfaces' depths, a little behind them, so that the depth test culls nothing that is before them.

uniform sampler2D opaque;  // [m] along the ray
uniform vec3 rayCorner;
uniform vec3 rayRight;
uniform vec3 rayDown;
uniform int orthographic;
uniform float nearest;
uniform float farthest;

void main() {
  float s = texelFetch(opaque, ivec2(gl_FragCoord.xy), 0).r;
  vec2 pixel = gl_FragCoord.xy;
  if (orthographic != 0) {
    gl_FragDepth = clamp(0.5 - 0.25 * s / farthest - 1e-5, 0.0, 1.0);
  } else {
    float w = s / length(rayCorner + pixel.x * rayRight + pixel.y * rayDown);
    gl_FragDepth = clamp(nearest / w * (1.0 - 1e-4), 0.0, 1.0);
  }
}
