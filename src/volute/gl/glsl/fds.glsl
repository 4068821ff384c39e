// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// The smoke or the fire of an FDS case: lattices with planes at any distance, side by side; M_ stands for the medium's own
// prefix. Values are constant in each cell or trilinear between nodes; obstructions and what no lattice covers are empty.
// A coarse table of parts says which lattice is where (FdsGrid). All is in one buffer; gl_fds.cpp writes it. M_sunlight(place, s)
// is what lamps add, M_findShadows() and M_nextShadow() know of the shadows that surfaces throw (gl_lamps.cpp).

layout(std430) readonly buffer M_Words { uint M_words[]; };

uniform vec3 M_origin;      // the picture's, from the middle of all [m]
uniform ivec3 M_partCount;  // of the table, along each axis
uniform ivec3 M_partPlanes; // where the planes of each axis begin [words]
uniform int M_table;
uniform int M_lattices;     // nine words each: planes, cells, values, bits of gas, nodal
uniform float M_extinction; // of a unit of the values [1/m]
uniform vec3 M_source;      // light that a unit of the values sends [1/m], without lamps

vec3 M_o;           // the ray's origin from the middle
ivec3 M_ahead;      // -1 or 1 on each axis
ivec3 M_part;
vec3 M_partLeaves;  // where the ray leaves the part on each axis
float M_partEnd;
int M_lattice;      // its words, or -1
ivec3 M_planesAt, M_cells;
ivec3 M_cell;
vec3 M_leaves;      // where the ray leaves the cell on each axis
vec3 M_low, M_perCell;
float M_c[8];       // values of the cell's corners
float M_end;        // the ray is in this cell, or in a part without a lattice, up to here
float M_stop;
bool M_on;          // in gas
bool M_waits;       // still before the case

float M_real(int at) { return uintBitsToFloat(M_words[at]); }

float M_crossing(int axis, int at) {
  return rayDirection[axis] == 0.0 ? FARTHEST : (M_real(at) - M_o[axis]) / rayDirection[axis];
}

void M_finish() {
  M_on = false;
  M_waits = false;
  M_end = FARTHEST;
  M_stop = -FARTHEST;
}

// Which of `count` gaps between the planes from `at` on holds a place; one on a plane belongs to the upper gap.
int M_gap(int at, int count, float place) {
  int low = 0;
  int high = count;
  while (high - low > 1) {
    int middle = (low + high) / 2;
    if (M_real(at + middle) <= place) low = middle;
    else high = middle;
  }
  return low;
}

int M_leastOf(vec3 v) { return v.x <= v.y ? (v.x <= v.z ? 0 : 2) : (v.y <= v.z ? 1 : 2); }

// What is in M_cell, and how far it goes.
void M_enterCell(float s) {
  for (int axis = 0; axis < 3; ++axis) {
    int plane = M_planesAt[axis] + M_cell[axis];
    M_low[axis] = M_real(plane);
    M_perCell[axis] = 1.0 / (M_real(plane + 1) - M_low[axis]);
    M_leaves[axis] = M_crossing(axis, plane + (M_ahead[axis] > 0 ? 1 : 0));
  }
  M_end = min(min(min(M_leaves.x, M_leaves.y), min(M_leaves.z, M_partEnd)), M_stop);
  int place = (M_cell.z * M_cells.y + M_cell.y) * M_cells.x + M_cell.x;
  M_on = (M_words[int(M_words[M_lattice + 7]) + (place >> 5)] >> (place & 31) & 1u) != 0u;
  if (!M_on) return;
  M_end = M_nextShadow(s, M_end);
  bool nodal = M_words[M_lattice + 8] != 0u;
  int values = int(M_words[M_lattice + 6]);
  int node = (M_cell.z * (M_cells.y + 1) + M_cell.y) * (M_cells.x + 1) + M_cell.x;
  ivec3 stride = ivec3(1, M_cells.x + 1, (M_cells.x + 1) * (M_cells.y + 1));
  for (int i = 0; i < 8; ++i) {
    int corner = node + (i & 1) * stride.x + (i >> 1 & 1) * stride.y + (i >> 2) * stride.z;
    M_c[i] = M_real(values + (nodal ? corner : place));
  }
}

// Into M_part, at s; true where a lattice is there, whose cell is to be entered.
bool M_enterPart(float s) {
  int part = (M_part.z * M_partCount.y + M_part.y) * M_partCount.x + M_part.x;
  for (int axis = 0; axis < 3; ++axis)
    M_partLeaves[axis] = M_crossing(axis, M_partPlanes[axis] + M_part[axis] + (M_ahead[axis] > 0 ? 1 : 0));
  M_partEnd = min(M_partLeaves.x, min(M_partLeaves.y, M_partLeaves.z));
  int lattice = int(M_words[M_table + part]);
  M_on = false;
  M_end = min(M_partEnd, M_stop);
  M_lattice = lattice < 0 ? -1 : M_lattices + 9 * lattice;
  if (lattice < 0) return false;
  vec3 place = M_o + s * rayDirection;
  for (int axis = 0; axis < 3; ++axis) {
    M_planesAt[axis] = int(M_words[M_lattice + axis]);
    M_cells[axis] = int(M_words[M_lattice + 3 + axis]);
    M_cell[axis] = M_gap(M_planesAt[axis], M_cells[axis], place[axis]);
  }
  return true;
}

void M_begin() {
  M_findShadows();
  M_o = M_origin + rayOrigin;
  float begin = rayBegin;
  float end = rayEnd;
  vec3 low, high;
  for (int axis = 0; axis < 3; ++axis) {
    M_ahead[axis] = rayDirection[axis] < 0.0 ? -1 : 1;
    low[axis] = M_real(M_partPlanes[axis]);
    high[axis] = M_real(M_partPlanes[axis] + M_partCount[axis]);
  }
  if (!clipBox(M_o, rayDirection, low, high, begin, end)) {
    M_finish();
    return;
  }
  M_stop = end;
  M_on = false;
  M_waits = true;
  M_end = begin;
}

// Into what comes after M_end. One call of each function: what is called in two branches is there twice, and a device may
// run both.
void M_next() {
  float s = M_end;
  bool inside = s < M_stop;
  bool ofPart = true;  // into another part, else into the part's next cell
  if (M_waits) {
    M_waits = false;
    vec3 place = M_o + s * rayDirection;
    for (int axis = 0; axis < 3; ++axis) M_part[axis] = M_gap(M_partPlanes[axis], M_partCount[axis], place[axis]);
  } else if (inside && M_lattice >= 0 && s < M_partEnd) {
    int axis = M_leastOf(M_leaves);
    if (M_leaves[axis] <= s) M_cell[axis] += M_ahead[axis];  // else its light changes here
    ofPart = false;
    if (M_cell[axis] < 0 || M_cell[axis] >= M_cells[axis]) {
      M_on = false;  // rounding: the part ends here too
      M_lattice = -1;
      M_end = min(M_partEnd, M_stop);
      return;
    }
  } else if (inside) {
    int axis = M_leastOf(M_partLeaves);
    M_part[axis] += M_ahead[axis];
    inside = M_part[axis] >= 0 && M_part[axis] < M_partCount[axis];
  }
  if (!inside) {
    M_finish();
    return;
  }
  if (!ofPart || M_enterPart(s)) M_enterCell(s);
}

// Adds the medium at s, which is in the cell.
void M_sample(float s, inout float k, inout vec3 e) {
  if (!M_on) return;
  vec3 p = clamp((M_o + s * rayDirection - M_low) * M_perCell, 0.0, 1.0);
  vec4 across = vec4((1.0 - p.x) * (1.0 - p.y), p.x * (1.0 - p.y), (1.0 - p.x) * p.y, p.x * p.y);
  float v = (1.0 - p.z) * dot(across, vec4(M_c[0], M_c[1], M_c[2], M_c[3])) +
            p.z * dot(across, vec4(M_c[4], M_c[5], M_c[6], M_c[7]));
  k += M_extinction * v;
  e += v * (M_source + M_extinction * M_sunlight(rayOrigin + s * rayDirection, s));
}
