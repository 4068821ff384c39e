// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// One tet on one pixel's ray: the light that it sends and, in alpha, what it lets through (Staubli et al. 2005,
// equations 6 to 13).

in vec4 frontField;
in vec4 backField;
in float gap;
in float depth;

uniform int orthographic;
uniform vec3 rayCorner;    // the ray of image point (0, 0), 1 m along the view
uniform vec3 rayRight;     // and one pixel further
uniform vec3 rayDown;
uniform int around;        // the eye is inside: the triangle is the back, and the front the eye
uniform vec4 eyeField;
uniform int opaqueGiven;
uniform sampler2D opaque;  // [m] along the ray
uniform sampler2D weights; // w0 and w1 over (d / (1 + d)) of both ends' depths
uniform int dither;        // of alpha, for targets of 8 bits

layout(location = 0) out vec4 result;

// Equation 7 for thin segments: the integrals of 1 - e^-t, to the third order of t = a s + b s^2.
vec2 thinWeights(float d0, float d1, float passed) {
  float a = d0;
  float b = 0.5 * (d1 - d0);
  float t1 = a / 2.0 + b / 3.0;
  float t2 = a * a / 3.0 + a * b / 2.0 + b * b / 5.0;
  float t3 = a * a * a / 4.0 + 0.6 * a * a * b + 0.5 * a * b * b + b * b * b / 7.0;
  float w0 = t1 - t2 / 2.0 + t3 / 6.0;
  return vec2(w0, 1.0 - passed - w0);
}

vec2 tableWeights(float d0, float d1) {
  vec2 d = vec2(d0, d1);
  float side = float(textureSize(weights, 0).x);
  return texture(weights, (d / (1.0 + d) * (side - 1.0) + 0.5) / side).rg;
}

void main() {
  vec2 pixel = gl_FragCoord.xy;
  float scale = orthographic != 0 ? 1.0 : length(rayCorner + pixel.x * rayRight + pixel.y * rayDown);
  vec4 f0 = frontField;
  vec4 f1 = backField;
  float from;
  float length;
  if (around != 0) {
    f0 = eyeField;
    from = 0.0;
    length = depth * scale;
  } else if (orthographic != 0) {
    from = depth;
    length = gap;
  } else {
    f1 /= 1.0 - gap;
    from = depth * scale;
    length = from * gap / (1.0 - gap);
  }
  if (opaqueGiven != 0) {
    float room = texelFetch(opaque, ivec2(pixel), 0).r - from;
    if (room <= 0.0) discard;
    if (room < length) {
      f1 = mix(f0, f1, room / length);
      length = room;
    }
  }
  if (!(length > 0.0)) discard;
  float d0 = max(f0.x, 0.0) * length;
  float d1 = max(f1.x, 0.0) * length;
  float passed = exp(-0.5 * (d0 + d1));
  vec2 w01 = d0 + d1 < 0.1 ? thinWeights(d0, d1, passed) : tableWeights(d0, d1);
  vec3 light = w01.x * f0.yzw + w01.y * f1.yzw;
  if (dither != 0) {  // equations 12 and 13; the light follows, for it is as much as does not pass
    float steps = 255.0 * passed;
    float rounded = (floor(steps) + (fract(steps) > fract(256.0 * steps) ? 1.0 : 0.0)) / 255.0;
    light *= passed < 1.0 ? (1.0 - rounded) / (1.0 - passed) : 0.0;
    passed = rounded;
  }
  result = vec4(light, passed);
}
