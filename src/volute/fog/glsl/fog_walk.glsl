// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Fog from a painted map, integrated exactly in every cell along a ray. For OpenGL 4.5 core (#version 450) and OpenGL
// ES 3.0 (#version 300 es, precision highp float).
//
//   float fogOpticalDepth(vec3 eye, vec3 direction, float distance)
//
// is the optical depth t from the eye to eye + distance * direction, a unit vector; distances of 1e30 and more are
// infinite. A fogged pixel is exp(-t) * color + (1 - exp(-t)) * fogColor, in linear light.

uniform highp sampler2D fogMap;  // coefficients [1/m], R32F, read by texelFetch: no filter, no mipmaps
uniform vec3 fogCorner;          // [m] where the padded map begins; wind moves it
uniform float fogCell;           // [m] side of a finest cell
uniform float fogMu;             // 0..1: level L from the finest ends at fogMu^(J - L) of the distance

#define FOG_SIDE (FOG_DEGREE + 1)

// The B-splines that touch a cell, at u of 0..1, the oldest first.
void fogSplines(float u, out float w[FOG_SIDE]) {
  float v = 1.0 - u;
#if FOG_DEGREE == 0
  w[0] = 1.0;
#elif FOG_DEGREE == 1
  w[0] = v;
  w[1] = u;
#elif FOG_DEGREE == 2
  w[0] = 0.5 * v * v;
  w[1] = 0.5 + u * v;
  w[2] = 0.5 * u * u;
#else
  w[0] = v * v * v / 6.0;
  w[1] = 2.0 / 3.0 - u * u * (1.0 - 0.5 * u);
  w[2] = 2.0 / 3.0 - v * v * (1.0 - 0.5 * v);
  w[3] = u * u * u / 6.0;
#endif
}

// The (d + 1)^2 coefficients of a cell; level L's rows begin at fogLevels[L].z.
void fogCoefficients(ivec2 cell, int level, out float c[FOG_SIDE * FOG_SIDE]) {
  ivec2 corner = cell + ivec2(0, fogLevels[level].z);
  for (int j = 0; j < FOG_SIDE; ++j) {
    for (int i = 0; i < FOG_SIDE; ++i) c[j * FOG_SIDE + i] = texelFetch(fogMap, corner + ivec2(i, j), 0).r;
  }
}

// The spline of these coefficients at a place in its cell.
float fogSpline(float c[FOG_SIDE * FOG_SIDE], vec2 place) {
  float x[FOG_SIDE];
  float y[FOG_SIDE];
  fogSplines(place.x, x);
  fogSplines(place.y, y);
  float sum = 0.0;
  for (int j = 0; j < FOG_SIDE; ++j) {
    float row = 0.0;
    for (int i = 0; i < FOG_SIDE; ++i) row += x[i] * c[j * FOG_SIDE + i];
    sum += y[j] * row;
  }
  return sum;
}

// Cuts begin..end to where o + d s is within lo..hi; false when it never is.
bool fogClip(float o, float d, float lo, float hi, inout float begin, inout float end) {
  if (abs(d) < 1e-12) return o >= lo && o <= hi;
  float a = (lo - o) / d;
  float b = (hi - o) / d;
  begin = max(begin, min(a, b));
  end = min(end, max(a, b));
  return begin < end;
}

// The same for a zone of the profile and a ray at height + rise s; where it is level and on a border, the upper zone has it.
bool fogClipZone(int zone, float height, float rise, inout float begin, inout float end) {
  if (abs(rise) < 1e-12 && zone < FOG_ZONES - 1 && height >= fogZoneHeights[zone].y) return false;
  return fogClip(height, rise, fogZoneHeights[zone].x, fogZoneHeights[zone].y, begin, end);
}

// g = (value + slope h) exp(-decay h), h the height above the reference; profile = (value, slope, decay, reference).
float fogProfile(vec4 profile, float height) {
  float h = height - profile.w;
  float g = profile.x + profile.y * h;
#if FOG_EXPONENTIAL
  return profile.z == 0.0 ? g : g * exp(-profile.z * h);
#else
  return g;
#endif
}

// Where a ray passes the plane ahead of cell `cell`.
float fogNextPlane(int cell, float o, float d) {
  return abs(d) < 1e-12 ? 1e30 : (float(cell + (d > 0.0 ? 1 : 0)) - o) / d;
}

// The integral of rho g over begin..end in one level and one zone of the profile. The ray is o + d s seen from above,
// in cells of the level, and height + rise s. Gauss points per cell are as many as make it exact; where the profile is
// exponential, cells are cut at scale heights. Ends where the integral has reached `opaque`.
float fogStretch(vec2 o, vec2 d, float height, float rise, float begin, float end, int level, ivec4 rect, vec4 profile,
                 float opaque) {
  if (!fogClip(o.x, d.x, float(rect.x), float(rect.z), begin, end)) return 0.0;
  if (!fogClip(o.y, d.y, float(rect.y), float(rect.w), begin, end)) return 0.0;
  if (begin >= end) return 0.0;
  ivec2 cell = clamp(ivec2(floor(o + d * begin + 1e-4 * sign(d))), rect.xy, rect.zw - 1);
  vec2 next = vec2(fogNextPlane(cell.x, o.x, d.x), fogNextPlane(cell.y, o.y, d.y));
  float longest = profile.z * abs(rise) > 1e-20 ? 1.0 / (profile.z * abs(rise)) : 1e30;
  int most = 2 * (rect.z - rect.x + rect.w - rect.y) + 80;
  float s = begin;
  float sum = 0.0;
  for (int step = 0; step < most; ++step) {
    float plane = min(next.x, next.y);
    float to = min(min(plane, end), s + longest);
    if (to > s) {
      float c[FOG_SIDE * FOG_SIDE];
      fogCoefficients(cell, level, c);
      float mean = 0.0;
      for (int k = 0; k < FOG_POINTS; ++k) {
        float at = s + fogNodes[k] * (to - s);
        vec2 place = clamp(o + d * at - vec2(cell), 0.0, 1.0);
        mean += fogNodeWeights[k] * fogSpline(c, place) * fogProfile(profile, height + rise * at);
      }
      sum += mean * (to - s);
      s = to;
    }
    if (s >= end || sum > opaque) break;
    if (plane > s) continue;
    if (next.x <= next.y) {
      cell.x += d.x > 0.0 ? 1 : -1;
      if (cell.x < rect.x || cell.x >= rect.z) break;
      next.x = fogNextPlane(cell.x, o.x, d.x);
    } else {
      cell.y += d.y > 0.0 ? 1 : -1;
      if (cell.y < rect.y || cell.y >= rect.w) break;
      next.y = fogNextPlane(cell.y, o.y, d.y);
    }
  }
  return sum;
}

// The cells that a level may reach.
ivec4 fogRect(int level) {
  return level == 0 ? fogMapCells : ivec4(0, 0, fogLevels[level].xy);
}

#ifndef FOG_OPAQUE
#define FOG_OPAQUE 40.0  // optical depth behind which nothing is looked for
#endif

// Where a ray leaves the padded map and the heights of the profile.
float fogExit(vec3 local, vec3 direction) {
  float begin = 0.0;
  float end = 1e30;
  vec2 size = vec2(fogLevels[0].xy) * fogCell;
  bool met = fogClip(local.x, direction.x, 0.0, size.x, begin, end);
  met = fogClip(local.y, direction.y, 0.0, size.y, begin, end) && met;
  met = fogClip(local.z, direction.z, fogZoneHeights[0].x, fogZoneHeights[FOG_ZONES - 1].y, begin, end) && met;
  return met ? end : 0.0;
}

float fogOpticalDepth(vec3 eye, vec3 direction, float distance) {
  vec3 local = eye - fogCorner;
  float farthest = distance < 1e30 ? distance : fogExit(local, direction);
  int coarsest = FOG_LEVELS - 1;
  float sum = 0.0;
  float from = 0.0;
  for (int level = 0; level < FOG_LEVELS; ++level) {
    float share = 1.0;
    for (int k = level; k < coarsest; ++k) share *= fogMu;
    float to = level == coarsest || fogMu >= 1.0 ? 1e30 : share * farthest;
    to = min(to, distance);
    float perCell = exp2(-float(level)) / fogCell;
    for (int zone = 0; zone < FOG_ZONES && to > from; ++zone) {
      float begin = from;
      float end = to;
      if (!fogClipZone(zone, local.z, direction.z, begin, end)) continue;
      sum += fogStretch(local.xy * perCell, direction.xy * perCell, local.z, direction.z, begin, end, level,
                        fogRect(level), fogZones[zone], FOG_OPAQUE);
    }
    from = max(from, to);
  }
  return sum;
}
