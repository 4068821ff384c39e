// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Fog, cell by cell along a ray that meets other media too; M_ stands for the medium's own prefix. Follows fog_walk.glsl,
// whose functions it uses; M_sunlight(place, s) is what suns add to the fog's own light, M_findShadows() and M_nextShadow()
// know of the shadows that surfaces throw. Levels of detail follow each other
// along the ray, in each the zones of the height profile, in each the cells; M_TOP: what is above the fog's top is cut.

uniform vec3 M_fogColor;    // radiance of infinitely thick fog
uniform float M_fogFactor;  // of the extinction, for which suns' shadows do not ask

vec2 M_o, M_d;            // the ray seen from above, in cells of the level
float M_height, M_rise;   // above the map's origin
float M_farthest;         // [m] from the eye
int M_level, M_zone;      // those after the stretch that the ray is in
int M_inLevel, M_inZone;
float M_from;             // where the level begins
ivec4 M_rect;
ivec2 M_cell;
vec2 M_planes;
float M_end;              // the ray is in this cell or gap up to here
float M_stretchBegin, M_stretchEnd;
bool M_on;
bool M_waits;             // before the stretch
float M_c[FOG_SIDE * FOG_SIDE];
#if M_BY_ANGLE
uniform float M_levelMetres;  // where the finest level ends
#endif
#if M_TOP
uniform sampler2D M_topMap;   // [m] above the map's origin, linear between nodes, 0 outside
uniform vec2 M_topCorner;     // of the cell before the first node, from the picture's origin [m]
uniform float M_topCell;      // [m]
bool M_below;

float M_topAt(ivec2 node) {
  bool there = all(greaterThanEqual(node, ivec2(0))) && all(lessThan(node, textureSize(M_topMap, 0)));
  return there ? texelFetch(M_topMap, node, 0).r : 0.0;
}

// Cuts s..M_end where the ray leaves a cell of the top or passes the top itself, and says on which side of it it is.
void M_cutAtTop(float s) {
  vec2 o = (rayOrigin.xy - M_topCorner) / M_topCell;
  vec2 d = rayDirection.xy / M_topCell;
  ivec2 cell = ivec2(floor(o + d * s));
  for (int axis = 0; axis < 2; ++axis) {
    float plane = fogNextPlane(cell[axis], o[axis], d[axis]);
    for (int k = 0; k < 3 && plane <= s; ++k) {
      cell[axis] += d[axis] > 0.0 ? 1 : -1;
      plane = fogNextPlane(cell[axis], o[axis], d[axis]);
    }
    if (plane > s) M_end = min(M_end, plane);
  }
  float a = M_topAt(cell - 1);
  float b = M_topAt(cell - ivec2(0, 1)) - a;
  float c = M_topAt(cell - ivec2(1, 0)) - a;
  float e = M_topAt(cell) - a - b - c;
  vec2 p = o + d * s - vec2(cell);
  // The top above the ray, c0 + c1 t + c2 t^2 from s on.
  float c0 = a + b * p.x + c * p.y + e * p.x * p.y - (M_height + M_rise * s);
  float c1 = b * d.x + c * d.y + e * (p.x * d.y + p.y * d.x) - M_rise;
  float c2 = e * d.x * d.y;
  float discriminant = c1 * c1 - 4.0 * c2 * c0;
  if (discriminant >= 0.0) {
    float q = -0.5 * (c1 + (c1 < 0.0 ? -1.0 : 1.0) * sqrt(discriminant));
    float least = 1e-6 * (1.0 + abs(s));  // nearer ones are where it has just passed
    float first = c2 != 0.0 ? q / c2 : -1.0;
    float second = q != 0.0 ? c0 / q : -1.0;
    if (first > least) M_end = min(M_end, s + first);
    if (second > least) M_end = min(M_end, s + second);
  }
  float t = 0.5 * (M_end - s);
  M_below = c0 + t * (c1 + t * c2) > 0.0;
}
#endif

// Where the ray leaves the padded map and the heights of the profile [m from the eye].
float M_exit() {
  vec3 local = rayOrigin - fogCorner;
  vec2 size = vec2(fogLevels[0].xy) * fogCell;
  float begin = -rayAhead;
  float end = 1e30;
  bool met = fogClip(local.x, rayDirection.x, 0.0, size.x, begin, end) &&
             fogClip(local.y, rayDirection.y, 0.0, size.y, begin, end) &&
             fogClip(local.z, rayDirection.z, fogZoneHeights[0].x, fogZoneHeights[FOG_ZONES - 1].y, begin, end);
  return met ? end + rayAhead : 0.0;
}

float M_levelEnd(int level) {
#if M_BY_ANGLE
  return level == FOG_LEVELS - 1 ? rayEnd : min(M_levelMetres * exp2(float(level)) - rayAhead, rayEnd);
#endif
  if (level == FOG_LEVELS - 1 || fogMu >= 1.0) return rayEnd;
  float share = 1.0;
  for (int k = level; k < FOG_LEVELS - 1; ++k) share *= fogMu;
  return min(share * M_farthest - rayAhead, rayEnd);
}

void M_enter(float s) {
  M_planes = vec2(fogNextPlane(M_cell.x, M_o.x, M_d.x), fogNextPlane(M_cell.y, M_o.y, M_d.y));
  M_end = min(min(M_planes.x, M_planes.y), M_stretchEnd);
  float decay = fogZones[M_inZone].z * abs(M_rise);
  if (decay > 1e-20) M_end = min(M_end, s + 1.0 / decay);
  M_end = max(M_end, s);
#if M_TOP
  M_cutAtTop(s);
#endif
  M_end = M_nextShadow(s, M_end);
  fogCoefficients(M_cell, M_inLevel, M_c);
}

// To the next stretch that the ray passes, or to the end.
void M_seek(float s) {
  M_on = false;
  M_waits = false;
  while (M_level < FOG_LEVELS) {
    float levelEnd = M_levelEnd(M_level);
    if (M_zone >= FOG_ZONES || levelEnd <= M_from) {
      M_from = max(M_from, levelEnd);
      ++M_level;
      M_zone = 0;
      continue;
    }
    M_inLevel = M_level;
    M_inZone = M_rise >= 0.0 ? M_zone : FOG_ZONES - 1 - M_zone;
    ++M_zone;
    float begin = max(M_from, s);
    float end = levelEnd;
    float perCell = exp2(-float(M_inLevel)) / fogCell;
    M_o = (rayOrigin.xy - fogCorner.xy) * perCell;
    M_d = rayDirection.xy * perCell;
    M_rect = fogRect(M_inLevel);
    if (begin < end && fogClipZone(M_inZone, M_height, M_rise, begin, end) &&
        fogClip(M_o.x, M_d.x, float(M_rect.x), float(M_rect.z), begin, end) &&
        fogClip(M_o.y, M_d.y, float(M_rect.y), float(M_rect.w), begin, end) && begin < end) {
      M_stretchBegin = begin;
      M_stretchEnd = end;
      M_end = begin;
      M_waits = true;
      return;
    }
  }
  M_end = FARTHEST;
}

void M_begin() {
  M_findShadows();
  M_height = rayOrigin.z - fogCorner.z;
  M_rise = rayDirection.z;
  M_farthest = rayEnd < 1e30 ? rayEnd + rayAhead : M_exit();
  M_level = 0;
  M_zone = 0;
  M_from = rayBegin;
  M_seek(rayBegin);
}

// One call of M_enter() and one of M_seek(): what is called in two branches is there twice, and a device may run both.
void M_next() {
  float s = M_end;
  bool seek = false;
  if (M_waits) {
    M_waits = false;
    M_on = true;
    M_cell = clamp(ivec2(floor(M_o + M_d * s + 1e-4 * sign(M_d))), M_rect.xy, M_rect.zw - 1);
  } else if (s >= M_stretchEnd) {
    seek = true;
  } else if (min(M_planes.x, M_planes.y) <= s) {  // else a long way through an exponential profile, or the top is met
    int axis = M_planes.x <= M_planes.y ? 0 : 1;
    M_cell[axis] += M_d[axis] > 0.0 ? 1 : -1;
    seek = M_cell[axis] < M_rect[axis] || M_cell[axis] >= M_rect[axis + 2];
  }
  if (seek) M_seek(s);
  else M_enter(s);
}

void M_sample(float s, inout float k, inout vec3 e) {
  if (!M_on) return;
#if M_TOP
  if (!M_below) return;
#endif
  vec2 place = clamp(M_o + M_d * s - vec2(M_cell), 0.0, 1.0);
  float here = M_fogFactor * fogSpline(M_c, place) * fogProfile(fogZones[M_inZone], M_height + M_rise * s);
  k += here;
  e += here * (M_fogColor + M_sunlight(rayOrigin + s * rayDirection, s));
}
