// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Opaque triangles in a tree of boxes, and where a ray meets them: Woop, Benthin and Wald, "Watertight ray/triangle
// intersection" (2013), as geometry/triangle_hit.cpp has it, and in double as there, so that both see the same edges.
// Places are relative to the geometry's middle.

layout(std430) readonly buffer Nodes { vec4 nodes[]; };      // two a node: low corner, high corner; w as below
layout(std430) readonly buffer Corners { dvec4 corners[]; };  // three a triangle, in the order of the leaves; w of the
                                                              // first: the material's number
// w of a node's corners, as bits: first child (the second stands beside it) or first triangle; number of triangles, 0
// for an inner node.

uniform int sides;  // which triangles stop a ray: 0 all, 1 those whose front it comes to, -1 those whose back

const float NOWHERE = 3e38;

struct Hit {
  double s;      // [m] along the ray
  int triangle;  // -1: none
};

bool boxMet(vec3 o, vec3 d, vec3 low, vec3 high, float before) {
  float begin = 0.0;
  float end = before;
  for (int axis = 0; axis < 3; ++axis) {
    if (d[axis] == 0.0) {
      if (o[axis] < low[axis] || o[axis] > high[axis]) return false;
      continue;
    }
    float a = (low[axis] - o[axis]) / d[axis];
    float b = (high[axis] - o[axis]) / d[axis];
    begin = max(begin, min(a, b));
    end = min(end, max(a, b));
  }
  return begin <= end * (1.0 + 1e-5);
}

// The nearest before `most`, or any of them.
Hit meetTriangles(dvec3 o, dvec3 d, double most, bool any) {
  dvec3 a = abs(d);
  int z = a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
  int x = (z + 1) % 3;
  int y = (z + 2) % 3;
  dvec3 shear = dvec3(d[x] / d[z], d[y] / d[z], 1.0LF / d[z]);
  vec3 boxO = vec3(o);
  vec3 boxD = vec3(d);
  Hit hit = Hit(most, -1);
  int stack[48];
  int top = 0;
  stack[0] = 0;
  while (top >= 0) {
    int node = stack[top--];
    vec4 low = nodes[2 * node];
    vec4 high = nodes[2 * node + 1];
    if (!boxMet(boxO, boxD, low.xyz, high.xyz, float(hit.s))) continue;
    int first = floatBitsToInt(low.w);
    int count = floatBitsToInt(high.w);
    if (count == 0) {
      stack[++top] = first;
      stack[++top] = first + 1;
      continue;
    }
    for (int t = first; t < first + count; ++t) {
      dvec3 p[3];
      for (int i = 0; i < 3; ++i) {
        dvec3 corner = corners[3 * t + i].xyz - o;
        precise dvec3 q = dvec3(corner[x] - shear.x * corner[z], corner[y] - shear.y * corner[z], shear.z * corner[z]);
        p[i] = q;
      }
      precise double u = p[2].x * p[1].y - p[2].y * p[1].x;
      precise double v = p[0].x * p[2].y - p[0].y * p[2].x;
      precise double w = p[1].x * p[0].y - p[1].y * p[0].x;
      if ((u < 0.0LF || v < 0.0LF || w < 0.0LF) && (u > 0.0LF || v > 0.0LF || w > 0.0LF)) continue;
      double area = u + v + w;
      if (area == 0.0LF) continue;
      bool front = (area > 0.0LF) == (d[z] > 0.0LF);
      if (sides != 0 && front != (sides > 0)) continue;
      double s = (u * p[0].z + v * p[1].z + w * p[2].z) / area;
      if (!(s > 0.0LF && s < hit.s)) continue;
      hit = Hit(s, t);
      if (any) return hit;
    }
  }
  return hit;
}
