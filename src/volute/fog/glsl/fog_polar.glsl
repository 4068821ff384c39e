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
// is fogOpticalDepth from the table's eye. Steep and very short rays are walked, and so are those beside the sector and
// those whose transmittance would be off by more than 1e-4, by differences between the table's entries.

uniform highp sampler2D fogPolar;  // RGBA32F, read by texelFetch
uniform vec2 fogPolarYaw;          // cos and sin of the azimuth in the middle
uniform float fogPolarTangent;     // of half the angle; 1 with four sectors
uniform int fogPolarSectors;       // 1, or 4 to look all around
uniform vec2 fogPolarRadii;        // [m] the first radius, and from one to the next
uniform vec2 fogPolarBends;        // [1/m] the map's largest |c(i - 1) - 2 c(i) + c(i + 1)| along x and y

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

// How far off fogPolarLook may be, as PolarTable estimates it: between rows by second differences and their jumps, by
// what floats hold of an azimuth, and by edges along an axis of the map (aslant: the ray's tangent to it) that change in
// less than a row; between radii by the cubic's part.
vec2 fogPolarError(int first, int azimuths, int row, float r, float aslant, float bend) {
  int radii = textureSize(fogPolar, 0).x;
  int column = int(clamp((r - fogPolarRadii.x) / fogPolarRadii.y, 0.0, float(radii) - 1.001));
  vec2 at[6];  // the row is 2
  for (int i = 0; i < 6; ++i)
    at[i] = texelFetch(fogPolar, ivec2(column, clamp(row - 2 + i, first, first + azimuths - 1)), 0).xz;
  vec2 rise = max(abs(at[3] - at[2]), max(abs(at[2] - at[1]), abs(at[4] - at[3])));
  vec2 error = 0.5 * rise;
  if (row >= first + 2 && row + 3 < first + azimuths) {
    vec2 a = at[1] - 2.0 * at[2] + at[3];
    vec2 b = at[2] - 2.0 * at[3] + at[4];
    vec2 jumps = abs(a - (at[0] - 2.0 * at[1] + at[2])) + abs(b - (at[3] - 2.0 * at[4] + at[5]));
    error = max(abs(a), abs(b)) / 8.0 + jumps * 0.1875;
  }
  error += rise * (2e-7 * float(azimuths - 1) / fogPolarTangent + 1.2e-7 * float(azimuths));
  vec4 near = texelFetch(fogPolar, ivec2(column, row), 0);
  vec4 far = texelFetch(fogPolar, ivec2(column + 1, row), 0);
  error += abs(fogPolarRadii.y * (near.yw + far.yw) - 2.0 * (far.xz - near.xz)) / 12.0;
  float apart = r * 2.0 * fogPolarTangent / (float(azimuths - 1) * fogCell);
  if (aslant <= 0.7 * apart) error += min(apart, 1.0) * 0.25 * bend * fogCell * vec2(1.0, r);
  return error;
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
  int first = sector * azimuths;
  int row = first + int(place);
  float share = fract(place);
  float height = eye.z - fogCorner.z;
  vec2 across = abs(direction.xy);
  float aslant = min(across.x, across.y) / max(across.x, across.y);
  float bend = across.x < across.y ? fogPolarBends.x : fogPolarBends.y;
  float sum = 0.0;
  float off = 0.0;
  for (int zone = 0; zone < FOG_ZONES; ++zone) {
    float begin = 0.0;
    float end = distance;
    if (!fogClipZone(zone, height, direction.z, begin, end)) continue;
    vec2 moments = fogPolarLook(row, share, end * level);
    vec2 error = fogPolarError(first, azimuths, row, end * level, aslant, bend);
    if (begin * level > fogPolarRadii.x) {
      moments -= fogPolarLook(row, share, begin * level);
      error += fogPolarError(first, azimuths, row, begin * level, aslant, bend);
    }
    vec2 factors = vec2(fogProfile(fogZones[zone], height), fogZones[zone].y * direction.z / level);
    sum += dot(factors, moments);
    off += dot(abs(factors), error);
  }
  float depth = max(sum, 0.0) / level;
  off /= level;
  return exp(min(off - depth, 0.0)) * off > 5e-5 ? fogOpticalDepth(eye, direction, distance) : depth;
}
