// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// A billboard among other media: a rectangle without thickness; M_ stands for the medium's own prefix. What it sends and
// takes is added where the ray comes to it.

uniform sampler2D M_texture;  // light and transmittance, row 0 at the top
uniform vec3 M_middle;        // from the picture's origin [m]
uniform vec3 M_across;        // to the right, over the width [1/m]
uniform vec3 M_down;          // down, over the height
uniform vec3 M_forward;       // unit length

float M_end;
bool M_on = false;
vec2 M_place;

vec4 M_read() {
  ivec2 shape = textureSize(M_texture, 0);
  vec2 at = clamp(M_place * vec2(shape) - 0.5, vec2(0.0), vec2(shape) - 1.0);
  ivec2 low = ivec2(at);
  ivec2 high = min(low + 1, shape - 1);
  vec2 share = at - vec2(low);
  vec4 top = mix(texelFetch(M_texture, low, 0), texelFetch(M_texture, ivec2(high.x, low.y), 0), share.x);
  vec4 bottom = mix(texelFetch(M_texture, ivec2(low.x, high.y), 0), texelFetch(M_texture, high, 0), share.x);
  return mix(top, bottom, share.y);
}

void M_begin() {
  M_end = FARTHEST;
  float speed = dot(rayDirection, M_forward);
  if (speed == 0.0) return;
  float s = dot(M_middle - rayOrigin, M_forward) / speed;
  vec3 from = rayOrigin + s * rayDirection - M_middle;
  M_place = vec2(dot(from, M_across), dot(from, M_down)) + 0.5;
  bool met = all(greaterThanEqual(M_place, vec2(0.0))) && all(lessThanEqual(M_place, vec2(1.0)));
  if (met && s > max(rayBegin, rayFrom) && s < rayEnd) M_end = s;
}

void M_next() {
  M_end = FARTHEST;
  vec4 value = M_read();
  light += exp(-depth) * value.rgb;
  depth -= log(clamp(value.a, 1e-7, 1.0));
}

void M_sample(float s, inout float k, inout vec3 e) {}
