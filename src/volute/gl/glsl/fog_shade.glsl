// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// The parts of a ray that surfaces keep a lamp from, as geometry/shadow_intervals.cpp finds them: where the plane through
// the ray and the lamp cuts triangles. M_ stands for the medium's own prefix, @ for the lamp's number. Follows light_field.glsl.
// A ray with more than MOST parts in shadow loses the narrowest lights between them.

const int M_MOST@ = 24;

float M_darkBegin@[M_MOST@];
float M_darkEnd@[M_MOST@];
int M_darkCount@ = 0;

void M_closeDark@(int at) {  // the light behind part `at`
  M_darkEnd@[at] = M_darkEnd@[at + 1];
  --M_darkCount@;
  for (int k = at + 1; k < M_darkCount@; ++k) {
    M_darkBegin@[k] = M_darkBegin@[k + 1];
    M_darkEnd@[k] = M_darkEnd@[k + 1];
  }
}

// One more part, united with those that it touches.
void M_addDark@(float begin, float end) {
  float gap = 1e-6 * (1.0 + abs(begin));
  int at = 0;
  while (at < M_darkCount@ && M_darkEnd@[at] < begin - gap) ++at;
  if (at == M_darkCount@ || M_darkBegin@[at] > end + gap) {
    if (M_darkCount@ == M_MOST@) {
      int narrowest = 0;
      for (int k = 1; k < M_MOST@ - 1; ++k) {
        if (M_darkBegin@[k + 1] - M_darkEnd@[k] < M_darkBegin@[narrowest + 1] - M_darkEnd@[narrowest]) narrowest = k;
      }
      M_closeDark@(narrowest);
      if (narrowest < at) --at;
    }
    for (int k = M_darkCount@; k > at; --k) {
      M_darkBegin@[k] = M_darkBegin@[k - 1];
      M_darkEnd@[k] = M_darkEnd@[k - 1];
    }
    M_darkBegin@[at] = begin;
    M_darkEnd@[at] = end;
    ++M_darkCount@;
    return;
  }
  M_darkBegin@[at] = min(M_darkBegin@[at], begin);
  M_darkEnd@[at] = max(M_darkEnd@[at], end);
  while (at + 1 < M_darkCount@ && M_darkBegin@[at + 1] <= M_darkEnd@[at] + gap) {
    float farther = max(M_darkEnd@[at], M_darkEnd@[at + 1]);
    M_closeDark@(at);
    M_darkEnd@[at] = farther;
  }
}

float M_most@(vec3 f, vec3 centre, vec3 across) { return dot(f, centre) + dot(abs(f), across); }

void M_findDark@() {
  M_darkCount@ = 0;
  float from = M_cone@.x;
  float to = M_cone@.y;
  if (from >= to) return;
  vec3 way = M_towards@(rayOrigin);
  float near = M_lampIsSun@ != 0 ? 0.0 : 1.0;
  vec3 normal = cross(rayDirection, way);
  if (dot(normal, normal) < 1e-12 * dot(way, way)) {  // towards the lamp or away from it: a little aside
    way += 1e-5 * length(way) * (abs(rayDirection.x) < 0.6 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0));
    normal = cross(rayDirection, way);
  }
  float square = dot(normal, normal);
  vec3 along = cross(way, normal) / square;
  vec3 across = cross(normal, rayDirection) / square;
  normal *= inversesqrt(square);
  vec3 origin = vec3(M_shadeOrigin) + rayOrigin;
  int stack[48];
  int top = 0;
  stack[0] = 0;
  while (top >= 0) {
    int node = stack[top--];
    vec4 low = M_shadeNodes[2 * node];
    vec4 high = M_shadeNodes[2 * node + 1];
    vec3 centre = 0.5 * (low.xyz + high.xyz) - origin;
    vec3 size = 0.5 * (high.xyz - low.xyz);
    if (abs(dot(normal, centre)) > dot(abs(normal), size) + 1e-5 || M_most@(across, centre, size) < 0.0 ||
        (near > 0.0 && -M_most@(-across, centre, size) > 1.0) || M_most@(along + near * from * across, centre, size) < from ||
        (to < 1e30 && -M_most@(-(along + near * to * across), centre, size) > to))
      continue;
    int first = floatBitsToInt(low.w);
    int count = floatBitsToInt(high.w);
    if (count == 0) {
      stack[++top] = first;
      stack[++top] = first + 1;
      continue;
    }
    for (int t = first; t < first + count; ++t) {
      vec3 corner[3];
      float height[3];
      for (int i = 0; i < 3; ++i) {
        corner[i] = vec3(M_shadeCorners[3 * t + i].xyz - M_shadeOrigin) - rayOrigin;
        height[i] = dot(normal, corner[i]);
      }
      vec3 cut[2];
      int cuts = 0;
      for (int i = 0; i < 3 && cuts < 2; ++i) {
        int a = i;
        int b = (i + 1) % 3;
        if ((height[a] < 0.0) == (height[b] < 0.0)) continue;
        if (height[a] >= 0.0) {  // the neighbour that shares this edge finds the same point
          a = b;
          b = i;
        }
        cut[cuts++] = corner[a] + height[a] / (height[a] - height[b]) * (corner[b] - corner[a]);
      }
      if (cuts < 2) continue;
      vec3 face = cross(corner[1] - corner[0], corner[2] - corner[0]);
      vec3 over = M_towards@(rayOrigin) - corner[0];
      if (near > 0.0 && abs(dot(face, over)) < 2e-6 * (1.0 + length(over) + length(rayOrigin)) * length(face))
        continue;  // the lamp is in its plane: no way to it crosses the triangle
      float a0 = dot(along, cut[0]), a1 = dot(along, cut[1]);
      float c0 = dot(across, cut[0]), c1 = dot(across, cut[1]);
      if (max(c0, c1) <= 0.0 || (near > 0.0 && min(c0, c1) >= 1.0)) continue;
      float slope = c0 != c1 ? (a1 - a0) / (c1 - c0) : 0.0;  // before the lamp, and behind the ray
      vec2 c = clamp(vec2(c0, c1), 0.0, near > 0.0 ? 1.0 : FARTHEST);
      a0 += slope * (c.x - c0);
      a1 += slope * (c.y - c1);
      if (near > 0.0) {
        a0 = c.x < 1.0 ? a0 / (1.0 - c.x) : sign(a0) * FARTHEST;
        a1 = c.y < 1.0 ? a1 / (1.0 - c.y) : sign(a1) * FARTHEST;
      }
      float begin = max(min(a0, a1), from);
      float end = min(max(a0, a1), to);
      if (begin < end) M_addDark@(begin, end);
    }
  }
}

// The next edge of a shadow after s.
float M_nextEdge@(float s, float before) {
  for (int k = 0; k < M_darkCount@; ++k) {
    if (M_darkBegin@[k] > s) before = min(before, M_darkBegin@[k]);
    if (M_darkEnd@[k] > s) before = min(before, M_darkEnd@[k]);
  }
  return before;
}

bool M_isDark@(float s) {
  for (int k = 0; k < M_darkCount@; ++k) {
    if (s > M_darkBegin@[k] && s < M_darkEnd@[k]) return true;
  }
  return false;
}
