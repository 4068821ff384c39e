// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// One snapshot of a volume, cell by cell along a ray; M_ stands for the medium's own prefix. Cells are voxels (box), or
// lie between eight voxel centres (trilinear: cell i is between voxels i - 1 and i). Bricks of 8^3 cells that are empty
// are stepped over, 2^M_gap a side together. M_open(brick) and M_voxel(voxel) come from volume_atlas.glsl,
// volume_tree.glsl or, of M_SHADED volumes, volume_shaded.glsl, which has M_scattered(voxel) too, where M_LIT.

uniform vec3 M_origin;    // [cells] the picture's
uniform vec3 M_perMetre;  // [cells/m]
uniform mat3 M_turn;       // from the world's axes to the volume's
uniform ivec3 M_lo;       // the cells M_lo <= i < M_hi are not all empty
uniform ivec3 M_hi;
uniform float M_emission;    // radiance per metre per unit
uniform float M_extinction;  // 1/m per unit

vec3 M_o, M_d;     // the ray in cells
ivec3 M_cell;
vec3 M_planes;     // where the ray leaves the cell, or what is empty, on each axis
float M_end;       // the ray is in this cell or gap up to here
float M_stop;
bool M_on;         // in a brick that is not empty
bool M_waits;      // still before the volume
bool M_leaps;      // in empty bricks, of which these are the cells
ivec3 M_low, M_high;
#if M_TRILINEAR
M_VALUE M_c[8];    // coefficients of 1, x, y, xy, z, xz, yz, xyz
#if M_LIT
vec3 M_l[8];       // the same of the light that a unit of extinction scatters
#endif
#else
M_VALUE M_c;
#endif

float M_plane(int axis, int low, int high) {
  return M_d[axis] == 0.0 ? FARTHEST : (float(M_d[axis] > 0.0 ? high : low) - M_o[axis]) / M_d[axis];
}

void M_finish() {
  M_on = false;
  M_waits = false;
  M_end = FARTHEST;
  M_stop = -FARTHEST;
}

#if M_TRILINEAR
void M_read() {
  for (int i = 0; i < 8; ++i) {
    ivec3 voxel = M_cell + ivec3(i & 1, i >> 1 & 1, i >> 2) - 1;
    M_c[i] = M_voxel(voxel);
#if M_LIT
    M_l[i] = M_scattered(voxel);
#endif
  }
  for (int axis = 1; axis < 8; axis *= 2) {
    for (int i = 0; i < 8; ++i) {
      if ((i & axis) == 0) continue;
      M_c[i] -= M_c[i ^ axis];
#if M_LIT
      M_l[i] -= M_l[i ^ axis];
#endif
    }
  }
}
#else
void M_read() { M_c = M_voxel(M_cell); }
#endif

// What is in M_cell, and how far it goes.
void M_enter() {
  ivec3 brick = M_cell >> 3;
  M_on = M_open(brick);
  M_leaps = !M_on;
  M_low = M_on ? M_cell : ((M_base + brick + 1 >> M_gap << M_gap) - 1 - M_base) * 8;
  M_high = M_low + (M_on ? 1 : 8 << M_gap);
  for (int axis = 0; axis < 3; ++axis) M_planes[axis] = M_plane(axis, M_low[axis], M_high[axis]);
  M_end = min(min(M_planes.x, M_planes.y), min(M_planes.z, M_stop));
  if (M_on) M_read();
}

ivec3 M_cellAt(float s) {
  vec3 place = clamp(M_o + s * M_d, vec3(M_lo), vec3(M_hi) - 0.5);
  return clamp(ivec3(floor(place)), M_lo, M_hi - 1);
}

void M_begin() {
  M_o = M_origin + M_turn * rayOrigin * M_perMetre;
  M_d = M_turn * rayDirection * M_perMetre;
  M_waits = false;
  float begin = rayBegin;
  float end = rayEnd;
  if (any(greaterThanEqual(M_lo, M_hi)) || !clipBox(M_o, M_d, vec3(M_lo), vec3(M_hi), begin, end)) {
    M_finish();
    return;
  }
  M_stop = end;
  M_on = false;
  M_waits = true;
  M_end = begin;
}

// Into what comes after M_end. One call of M_enter(): what is called in two branches is there twice, and a device may
// run both.
void M_next() {
  bool inside = M_end < M_stop;
  if (M_waits) {
    M_waits = false;
    M_cell = M_cellAt(M_end);
  } else if (inside) {
    int axis = M_planes.x <= M_planes.y ? 0 : 1;
    if (M_planes.z < M_planes[axis]) axis = 2;
    int ahead = M_d[axis] > 0.0 ? 1 : -1;
    if (M_leaps) {
      M_cell = clamp(M_cellAt(M_end), M_low, M_high - 1);
      M_cell[axis] = ahead > 0 ? M_high[axis] : M_low[axis] - 1;
    } else {
      M_cell[axis] += ahead;
    }
    inside = M_cell[axis] >= M_lo[axis] && M_cell[axis] < M_hi[axis];
    M_cell = clamp(M_cell, M_lo, M_hi - 1);
  }
  if (inside) M_enter();
  else M_finish();
}

// Adds the medium at s, which is in the cell.
void M_sample(float s, inout float k, inout vec3 e) {
  if (!M_on) return;
#if M_TRILINEAR
  vec3 p = clamp(M_o + s * M_d - vec3(M_cell), 0.0, 1.0);
  M_VALUE v = M_c[0] + p.x * M_c[1] + p.y * (M_c[2] + p.x * M_c[3]) +
              p.z * (M_c[4] + p.x * M_c[5] + p.y * (M_c[6] + p.x * M_c[7]));
#else
  M_VALUE v = M_c;
#endif
#if M_SHADED
  float taken = M_extinction * M_DENSITY(v);
  k += taken;
#if M_CHANNELS == 4
  e += M_emission * v.yzw;
#endif
#if M_LIT
  vec3 l = M_l[0] + p.x * M_l[1] + p.y * (M_l[2] + p.x * M_l[3]) +
           p.z * (M_l[4] + p.x * M_l[5] + p.y * (M_l[6] + p.x * M_l[7]));
  e += taken * l;
#endif
#else
#if M_CHANNELS == 1
  k += M_extinction * v;
#else
  k += M_extinction * (v.r + v.g + v.b) / 3.0;
#endif
  e += M_emission * vec3(v);
#endif
}
