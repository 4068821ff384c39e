// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// A table for one eye, after fog_walk.glsl: all rays of one azimuth see the same density, one above the other, so
//   M_k(azimuth, r) = integral of rho r'^k dr' up to r, k = 0 and 1,
// serve every pixel with two look-ups for each zone of the profile.
//
//   vec4 fogPolarEntry(vec3 eye, ivec2 texel, ivec2 size)
//
// is what texel (radius, azimuth) of a size.x by size.y table holds: (M_0, rho, M_1, rho r). Draw it into an RGBA32F
// target whenever the eye moves; with fogPolarSectors = 4 the table has four sectors of size.y / 4 azimuths.
//
//   float fogPolarOpticalDepth(vec3 eye, vec3 direction, float distance)
//
// is fogOpticalDepth from the table's eye. Steep and very short rays are walked, and so are those beside the sector.

uniform highp sampler2D fogPolar;  // RGBA32F, read by texelFetch
uniform vec2 fogPolarYaw;          // cos and sin of the azimuth in the middle
uniform float fogPolarTangent;     // of half the angle; 1 with four sectors
uniform int fogPolarSectors;       // 1, or 4 to look all around
uniform vec2 fogPolarRadii;        // [m] the first radius, and from one to the next

vec4 fogPolarEntry(vec3 eye, ivec2 texel, ivec2 size) {
  int azimuths = size.y / fogPolarSectors;
  float q = (2.0 * float(texel.y % azimuths) / float(azimuths - 1) - 1.0) * fogPolarTangent;
  vec2 ahead = fogPolarYaw;
  for (int turn = texel.y / azimuths; turn > 0; --turn) ahead = vec2(-ahead.y, ahead.x);
  vec2 direction = normalize(ahead + q * vec2(-ahead.y, ahead.x));
  float r = fogPolarRadii.x + float(texel.x) * fogPolarRadii.y;
  vec2 o = (eye.xy - fogCorner.xy) / fogCell;
  vec2 d = direction / fogCell;
  float m0 = fogStretch(o, d, 0.0, 1.0, 0.0, r, 0, fogMapCells, vec4(1.0, 0.0, 0.0, 0.0), 1e30);
  float m1 = fogStretch(o, d, 0.0, 1.0, 0.0, r, 0, fogMapCells, vec4(0.0, 1.0, 0.0, 0.0), 1e30);
  vec2 at = o + d * r;
  float rho = 0.0;
  if (all(greaterThanEqual(at, vec2(fogMapCells.xy))) && all(lessThan(at, vec2(fogMapCells.zw)))) {
    float c[FOG_SIDE * FOG_SIDE];
    fogCoefficients(ivec2(floor(at)), 0, c);
    rho = fogSpline(c, fract(at));
  }
  return vec4(m0, rho, m1, rho * r);
}

// (M_0, M_1) at a radius, between rows `row` and `row + 1`: linear between azimuths, Hermite's cubic between radii.
vec2 fogPolarLook(int row, float share, float r) {
  int radii = textureSize(fogPolar, 0).x;
  float place = clamp((r - fogPolarRadii.x) / fogPolarRadii.y, 0.0, float(radii) - 1.001);
  int column = int(place);
  float x = place - float(column);
  vec4 a = mix(texelFetch(fogPolar, ivec2(column, row), 0), texelFetch(fogPolar, ivec2(column, row + 1), 0), share);
  vec4 b = mix(texelFetch(fogPolar, ivec2(column + 1, row), 0), texelFetch(fogPolar, ivec2(column + 1, row + 1), 0), share);
  float rest = 1.0 - x;
  vec2 bend = x * rest * fogPolarRadii.y * (a.yw * rest - b.yw * x);
  return a.xz + x * x * (3.0 - 2.0 * x) * (b.xz - a.xz) + bend;
}

float fogPolarOpticalDepth(vec3 eye, vec3 direction, float distance) {
  float level = length(direction.xy);
  vec2 turned = vec2(dot(direction.xy, fogPolarYaw), dot(direction.xy, vec2(-fogPolarYaw.y, fogPolarYaw.x)));
  int sector = 0;
  if (fogPolarSectors == 4) {  // forwards, left, backwards, right
    if (abs(turned.y) > abs(turned.x)) {
      sector = 1;
      turned = vec2(turned.y, -turned.x);
    }
    if (turned.x < 0.0) {
      sector += 2;
      turned = -turned;
    }
  }
  float q = turned.x > 0.0 ? turned.y / turned.x : 1e30;
  if (level <= 0.15 || distance * level <= fogCell || abs(q) > fogPolarTangent * 1.0001)
    return fogOpticalDepth(eye, direction, distance);
  int azimuths = textureSize(fogPolar, 0).y / fogPolarSectors;
  float place = clamp((q + fogPolarTangent) * float(azimuths - 1) / (2.0 * fogPolarTangent), 0.0, float(azimuths) - 1.001);
  int row = sector * azimuths + int(place);
  float share = fract(place);
  float height = eye.z - fogCorner.z;
  float sum = 0.0;
  for (int zone = 0; zone < FOG_ZONES; ++zone) {
    float begin = 0.0;
    float end = distance;
    if (!fogClipZone(zone, height, direction.z, begin, end)) continue;
    vec2 moments = fogPolarLook(row, share, end * level);
    if (begin * level > fogPolarRadii.x) moments -= fogPolarLook(row, share, begin * level);
    sum += fogProfile(fogZones[zone], height) * moments.x + fogZones[zone].y * direction.z / level * moments.y;
  }
  return max(sum, 0.0) / level;
}
