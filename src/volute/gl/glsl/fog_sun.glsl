// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// How much fog lies between a place and a sun, as fog/sun_shadow.cpp has it; M_ stands for the medium's own prefix, and
// @ for the lamp's number. Follows fog_walk.glsl. Places are from the picture's origin [m].

uniform sampler2D M_sunMaps@;    // (rho, I_0, I_1, S), read by texelFetch
uniform vec3 M_sunWay@;          // to the sun, unit length
uniform vec3 M_sunCorner@;       // of the maps, from the picture's origin [m]; z: the step from one texel to the next
uniform float M_sunDecay@;       // [1/m]

vec4 M_sunMapsAt@(vec2 at) {
  ivec2 shape = textureSize(M_sunMaps@, 0);
  at = clamp(at, vec2(0.0), vec2(shape) - 1.0);
  ivec2 low = min(ivec2(at), shape - 2);
  vec2 share = at - vec2(low);
  vec4 a = mix(texelFetch(M_sunMaps@, low, 0), texelFetch(M_sunMaps@, low + ivec2(1, 0), 0), share.x);
  vec4 b = mix(texelFetch(M_sunMaps@, low + ivec2(0, 1), 0), texelFetch(M_sunMaps@, low + 1, 0), share.x);
  return mix(a, b, share.y);
}

// I_0, I_1 and S at a place that may lie before the maps.
vec3 M_sunMoments@(vec2 place) {
  vec2 at = (place - M_sunCorner@.xy) / M_sunCorner@.z;
  vec2 last = vec2(textureSize(M_sunMaps@, 0)) - 1.0;
  float late = 0.0;
  if (any(lessThan(at, vec2(0.0))) || any(greaterThan(at, last))) {
    vec2 way = M_sunWay@.xy / M_sunCorner@.z;
    float begin = -FARTHEST;
    float end = FARTHEST;
    if (!clipAxis(at.x, way.x, 0.0, last.x, begin, end) || !clipAxis(at.y, way.y, 0.0, last.y, begin, end)) return vec3(0.0);
    if (end <= 0.0) return vec3(0.0);
    late = max(begin, 0.0);
    at += late * way;
  }
  vec4 found = M_sunMapsAt@(at);
  float faded = late > 0.0 ? exp(-M_sunDecay@ * M_sunWay@.z * late) : 1.0;
  return vec3(found.y, found.z + late * found.y, found.w * faded);
}

float M_sunZone@(vec4 zone, vec2 heights, vec3 place) {
  const float STEEP_CELLS = 3.0;
  const float NODES[3] = float[](0.1127016653792583, 0.5, 0.8872983346207417);
  const float WEIGHTS[3] = float[](0.2777777777777778, 0.4444444444444444, 0.2777777777777778);
  float height = place.z - fogCorner.z;
  float begin = max(0.0, (heights.x - height) / M_sunWay@.z);
  float end = (heights.y - height) / M_sunWay@.z;
  if (!(begin < end)) return 0.0;
  if (zone.z != 0.0)
    return fogProfile(zone, height + begin * M_sunWay@.z) * M_sunMoments@(place.xy + begin * M_sunWay@.xy).z;
  float cells = (end - begin) * length(M_sunWay@.xy) / fogCell;
  if (cells < STEEP_CELLS) {
    float depth = 0.0;
    int parts = int(cells) + 1;
    float length = (end - begin) / float(parts);
    vec2 last = vec2(textureSize(M_sunMaps@, 0)) - 1.0;
    for (int k = 0; k < 3 * parts; ++k) {
      float t = begin + length * (float(k / 3) + NODES[k % 3]);
      vec2 at = (place.xy + t * M_sunWay@.xy - M_sunCorner@.xy) / M_sunCorner@.z;
      if (any(lessThan(at, vec2(0.0))) || any(greaterThan(at, last))) continue;
      depth += WEIGHTS[k % 3] * length * fogProfile(zone, height + t * M_sunWay@.z) * M_sunMapsAt@(at).x;
    }
    return depth;
  }
  vec3 from = M_sunMoments@(place.xy + begin * M_sunWay@.xy);
  vec3 to = M_sunMoments@(place.xy + end * M_sunWay@.xy);
  float depth = fogProfile(zone, height) * (from.x - to.x);
  if (zone.y != 0.0) depth += zone.y * M_sunWay@.z * (from.y + begin * from.x - (to.y + end * to.x));
  return depth;
}

// The share of its light that the fog lets through.
float M_known@(vec3 place) {
  float depth = 0.0;
  for (int zone = 0; zone < FOG_ZONES; ++zone) depth += M_sunZone@(fogZones[zone], fogZoneHeights[zone], place);
  return exp(-max(depth, 0.0));
}
