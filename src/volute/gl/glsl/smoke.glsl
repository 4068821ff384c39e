// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Smoke on tetrahedra, from face to face through the neighbours; M_ stands for the medium's own prefix. Extinction and
// source are linear in each tet. On which side of an edge a ray passes is decided by the edge alone, its lower vertex
// first, the same in all its tets, so that no ray slips between two. Rays enter by the eye's tet or by a boundary face
// that a tree of boxes finds, again and again where the mesh is not convex.

layout(std430) readonly buffer M_Vertices { vec4 M_places[]; };   // [m], from the mesh's middle
layout(std430) readonly buffer M_Fields { vec4 M_fields[]; };     // extinction [1/m], source
layout(std430) readonly buffer M_Tets { ivec4 M_tets[]; };        // vertices, ascending
layout(std430) readonly buffer M_Opposites { ivec4 M_opposites[]; };  // half-face on the other side, or -1
layout(std430) readonly buffer M_Nodes { vec4 M_nodes[]; };       // two a node: low corner, high corner; w as below
layout(std430) readonly buffer M_Faces { int M_faces[]; };        // 2 * half-face, + 1 where rays enter positively

// w of a node's corners, as bits: first child (the second stands beside it) or first face; number of faces, 0 for an
// inner node.

uniform vec3 M_origin; // the picture's, from the mesh's middle
uniform int M_eyeTet;  // -1: rays begin outside

vec3 M_o;              // the ray's origin from the mesh's middle
vec3 M_u, M_v;         // with the ray's direction a right-handed frame
int M_tet, M_in, M_out;  // the tet, and its faces by which the ray enters and leaves: the vertex across
float M_s0, M_s1;      // [m] along the ray
vec4 M_f0, M_f1;       // the field there
float M_lastEntry;
float M_end;
bool M_on;
bool M_waits;          // before the tet

struct M_Corner {
  vec2 at;     // seen along the ray
  float s;     // along the ray
  int vertex;
};

M_Corner M_cornerOf(int vertex) {
  vec3 to = M_places[vertex].xyz - M_o;
  return M_Corner(vec2(dot(to, M_u), dot(to, M_v)), dot(to, rayDirection), vertex);
}

// Twice the area that an edge and the ray's point span, the lower vertex first.
float M_edge(M_Corner a, M_Corner b) {
  precise float first = a.at.x * b.at.y;
  precise float second = a.at.y * b.at.x;
  precise float area = first - second;
  return area;
}

// On which side of the edge the ray passes, for the ray moved by an infinitely small step across itself: so that one
// through an edge or a vertex has one answer for all faces.
bool M_side(M_Corner a, M_Corner b) {
  float area = M_edge(a, b);
  if (area != 0.0) return area > 0.0;
  return a.at.y != b.at.y ? a.at.y > b.at.y : b.at.x > a.at.x;
}

// Where the ray meets the face a, b, c (ascending): between two places of its outline, which its longest side, as seen,
// has ahead of the ray and behind. So the place is on the ray for faces too that are seen edge on, whose areas are but
// rounding.
void M_meet(M_Corner a, M_Corner b, M_Corner c, out float s, out vec4 field) {
  M_Corner corner[3] = M_Corner[](a, b, c);
  vec3 lengths = vec3(dot(b.at - a.at, b.at - a.at), dot(c.at - b.at, c.at - b.at), dot(a.at - c.at, a.at - c.at));
  int p = lengths.x >= lengths.y && lengths.x >= lengths.z ? 0 : lengths.y >= lengths.z ? 1 : 2;
  int q = (p + 1) % 3, r = (p + 2) % 3;
  vec2 along = corner[q].at - corner[p].at;
  vec3 far, aside;
  for (int i = 0; i < 3; ++i) {
    far[i] = dot(corner[i].at, along);
    aside[i] = along.x * corner[i].at.y - along.y * corner[i].at.x;
  }
  int x = (far[r] < 0.0) == (far[p] < 0.0) ? q : p;  // across the ray from r
  float onSide = far[p] != far[q] ? clamp(far[p] / (far[p] - far[q]), 0.0, 1.0) : 0.5;
  float onOther = far[r] != far[x] ? clamp(far[r] / (far[r] - far[x]), 0.0, 1.0) : 0.0;
  float from = mix(aside[p], aside[q], onSide), to = mix(aside[r], aside[x], onOther);
  float between = from != to ? clamp(from / (from - to), 0.0, 1.0) : 0.5;
  vec3 w = vec3(0.0);
  w[p] += (1.0 - between) * (1.0 - onSide);
  w[q] += (1.0 - between) * onSide;
  w[r] += between * (1.0 - onOther);
  w[x] += between * onOther;
  s = w.x * a.s + w.y * b.s + w.z * c.s;
  field = w.x * M_fields[a.vertex] + w.y * M_fields[b.vertex] + w.z * M_fields[c.vertex];
}

// The three other vertices, ascending.
ivec3 M_others(int across) {
  return ivec3(across == 0 ? 1 : 0, across <= 1 ? 2 : 1, across <= 2 ? 3 : 2);
}

void M_finish() {
  M_on = false;
  M_waits = false;
  M_end = FARTHEST;
}

// Through M_tet from face M_in, where the ray is at M_s0: finds M_out, M_s1, M_f1.
void M_cross() {
  ivec4 tet = M_tets[M_tet];
  M_Corner c[4];
  for (int i = 0; i < 4; ++i) c[i] = M_cornerOf(tet[i]);
  ivec3 face = M_others(M_in);
  M_Corner i = c[face.x], j = c[face.y], k = c[face.z], l = c[M_in];
  bool turn = M_side(i, j);
  if (M_side(j, k) != turn) turn = !M_side(i, k);  // the majority, where rounding parts them
  // On which side of the lines from the corners to the vertex across the ray passes.
  bvec3 side = bvec3(face.x < M_in ? M_side(i, l) : !M_side(l, i), face.y < M_in ? M_side(j, l) : !M_side(l, j),
                     face.z < M_in ? M_side(k, l) : !M_side(l, k));
  if (all(side) || !any(side)) {  // no way out but for rounding: by the nearest line
    vec3 near = abs(vec3(M_edge(i, l), M_edge(j, l), M_edge(k, l)));
    int least = near.x <= near.y && near.x <= near.z ? 0 : near.y <= near.z ? 1 : 2;
    side[least] = !side[least];
  }
  int away = side.y == turn && side.x != turn ? 2 : side.z == turn && side.y != turn ? 0 : 1;
  M_out = face[away];
  ivec3 exits = M_others(M_out);
  M_meet(c[exits.x], c[exits.y], c[exits.z], M_s1, M_f1);
  M_s1 = max(M_s1, M_s0);
  M_end = min(M_s1, rayEnd);
  M_on = true;
}

// Of the two faces that the ray's line meets, the eye's tet is entered by the one behind.
void M_enterEyeTet() {
  ivec4 tet = M_tets[M_tet];
  M_Corner c[4];
  for (int i = 0; i < 4; ++i) c[i] = M_cornerOf(tet[i]);
  M_s0 = FARTHEST;
  M_in = 0;
  for (int across = 0; across < 4; ++across) {
    ivec3 f = M_others(across);
    bool turn = M_side(c[f.x], c[f.y]);
    if (M_side(c[f.y], c[f.z]) != turn || M_side(c[f.x], c[f.z]) == turn) continue;
    float s;
    vec4 field;
    M_meet(c[f.x], c[f.y], c[f.z], s, field);
    if (s < M_s0) {
      M_s0 = s;
      M_f0 = field;
      M_in = across;
    }
  }
}

// Boxes of faces across an axis are next to flat: rounding must not lose them.
bool M_boxMet(vec3 low, vec3 high, float before) {
  float begin = M_lastEntry;
  float end = before;
  for (int axis = 0; axis < 3; ++axis) {
    if (rayDirection[axis] == 0.0) {
      if (M_o[axis] < low[axis] || M_o[axis] > high[axis]) return false;
      continue;
    }
    float a = (low[axis] - M_o[axis]) / rayDirection[axis];
    float b = (high[axis] - M_o[axis]) / rayDirection[axis];
    begin = max(begin, min(a, b));
    end = min(end, max(a, b));
  }
  return begin <= end + 1e-6 * (abs(begin) + abs(end));
}

// To the first face after M_lastEntry by which the ray enters the mesh.
void M_seek() {
  M_on = false;
  float best = rayEnd;
  int found = -1;
  int stack[40];
  int top = 0;
  stack[0] = 0;
  while (top >= 0) {
    int node = stack[top--];
    vec4 low = M_nodes[2 * node], high = M_nodes[2 * node + 1];
    if (!M_boxMet(low.xyz, high.xyz, best)) continue;
    int first = floatBitsToInt(low.w), count = floatBitsToInt(high.w);
    if (count == 0) {
      stack[++top] = first;
      stack[++top] = first + 1;
      continue;
    }
    for (int n = first; n < first + count; ++n) {
      int halfFace = M_faces[n] >> 1;
      bool turn = (M_faces[n] & 1) != 0;
      ivec4 tet = M_tets[halfFace >> 2];
      ivec3 f = M_others(halfFace & 3);
      M_Corner a = M_cornerOf(tet[f.x]), b = M_cornerOf(tet[f.y]), c = M_cornerOf(tet[f.z]);
      if (M_side(a, b) != turn || M_side(b, c) != turn || M_side(a, c) == turn) continue;
      float s;
      vec4 field;
      M_meet(a, b, c, s, field);
      if (s <= M_lastEntry || s >= best) continue;
      best = s;
      found = halfFace;
      M_s0 = s;
      M_f0 = field;
    }
  }
  if (found < 0) {
    M_finish();
    return;
  }
  M_tet = found >> 2;
  M_in = found & 3;
  M_lastEntry = best;
  M_end = best;
  M_waits = true;
}

void M_begin() {
  M_o = M_origin + rayOrigin;
  vec3 axis = abs(rayDirection.x) < 0.6 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0);
  M_u = normalize(cross(axis, rayDirection));
  M_v = cross(rayDirection, M_u);
  M_on = false;
  M_waits = false;
  M_lastEntry = rayBegin;
  M_tet = M_eyeTet;
  if (M_tet >= 0) {
    M_enterEyeTet();
    M_end = rayBegin;
    M_waits = true;
  } else {
    M_seek();
  }
}

void M_next() {
  if (M_end >= rayEnd) {
    M_finish();
    return;
  }
  if (!M_waits) {
    int next = M_opposites[M_tet][M_out];
    if (next < 0) {
      M_seek();
      return;
    }
    M_tet = next >> 2;
    M_in = next & 3;
    M_s0 = M_s1;
    M_f0 = M_f1;
  }
  M_waits = false;
  M_cross();
}

void M_sample(float s, inout float k, inout vec3 e) {
  if (!M_on) return;
  float share = M_s1 > M_s0 ? clamp((s - M_s0) / (M_s1 - M_s0), 0.0, 1.0) : 0.0;
  vec4 field = mix(M_f0, M_f1, share);
  k += field.x;
  e += field.x * field.yzw;
}
