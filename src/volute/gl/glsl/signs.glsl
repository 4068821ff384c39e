// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Signs: flat pictures seen from their front alone, as render/sign.cpp has them; follows ray.glsl. A pixel whose
// centre's ray meets one gets its picture, averaged over the pixel inside the sign's borders.

layout(rgba32f, binding = 1) writeonly uniform image2D seen;  // radiance; w: [m] along the ray, NOWHERE where no sign is
layout(r32i, binding = 2) writeonly uniform iimage2D numbers; // which sign, or -1

// Five a sign: middle from the picture's origin [m] and width; normal, unit length, and height; right; down; the picture's first
// texel, columns and rows as bits.
layout(std430) readonly buffer Signs { vec4 signs[]; };
layout(std430) readonly buffer Texels { vec4 texels[]; };

uniform int count;

const int SAMPLES = 4;
const float ON_WALL = 1e-3;  // [m]: this far behind a wall they are still before it
const float NOWHERE = 3e38;

// u and v from 0 to 1, and the distance; w = 0 where it misses.
vec4 meetSign(int sign, vec3 o, vec3 d) {
  vec4 middle = signs[5 * sign];
  vec4 normal = signs[5 * sign + 1];
  float facing = dot(d, normal.xyz);
  if (!(facing < 0.0)) return vec4(0.0);
  float s = dot(middle.xyz - o, normal.xyz) / facing;
  if (!(s > rayBegin)) return vec4(0.0);
  vec3 from = o + s * d - middle.xyz;
  vec2 place = 0.5 + vec2(dot(from, signs[5 * sign + 2].xyz) / middle.w, dot(from, signs[5 * sign + 3].xyz) / normal.w);
  bool inside = all(greaterThanEqual(place, vec2(0.0))) && all(lessThanEqual(place, vec2(1.0)));
  return inside ? vec4(place, s, 1.0) : vec4(0.0);
}

vec3 pictureAt(int sign, vec2 place) {
  ivec4 shape = floatBitsToInt(signs[5 * sign + 4]);
  vec2 at = clamp(place * vec2(shape.yz) - 0.5, vec2(0.0), vec2(shape.yz) - 1.0);
  ivec2 low = ivec2(at);
  ivec2 high = min(low + 1, shape.yz - 1);
  vec2 share = at - vec2(low);
  vec3 top = mix(texels[shape.x + low.y * shape.y + low.x].rgb, texels[shape.x + low.y * shape.y + high.x].rgb, share.x);
  vec3 bottom = mix(texels[shape.x + high.y * shape.y + low.x].rgb, texels[shape.x + high.y * shape.y + high.x].rgb, share.x);
  return mix(top, bottom, share.y);
}

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, size))) return;
  int number = -1;
  vec4 nearest = vec4(0.0, 0.0, NOWHERE, 0.0);
  float wall = NOWHERE;
  double ahead = 0.0LF;
  if (castRay(pixel)) {
    wall = rayEnd;
    float end = wall < NOWHERE ? wall + 1e-5 * (wall + rayAhead) + ON_WALL : NOWHERE;
    ahead = exactAhead;
    for (int i = 0; i < count; ++i) {
      vec4 place = meetSign(i, rayOrigin, rayDirection);
      if (place.w == 0.0 || !(place.z < min(end, nearest.z))) continue;
      nearest = place;
      number = i;
    }
  }
  imageStore(numbers, pixel, ivec4(number));
  if (number < 0) {
    imageStore(seen, pixel, vec4(0.0, 0.0, 0.0, NOWHERE));
    return;
  }
  vec3 sum = vec3(0.0);
  int hits = 0;
  for (int i = 0; i < SAMPLES * SAMPLES; ++i) {
    castRayAt(vec2(pixel) + (vec2(i % SAMPLES, i / SAMPLES) + 0.5) / float(SAMPLES), pixel);
    vec4 place = meetSign(number, rayOrigin, rayDirection);
    if (place.w == 0.0) continue;
    sum += pictureAt(number, place.xy);
    ++hits;
  }
  vec3 color = hits > 0 ? sum / float(hits) : pictureAt(number, nearest.xy);
  imageStore(seen, pixel, vec4(color, float(double(min(nearest.z, wall)) + ahead)));
}
