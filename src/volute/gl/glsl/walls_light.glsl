// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Adds what a lamp sends back from the walls of a mesh (Lambert), as scene/smoke_walls.cpp has it: where the corners of a
// triangle see the lamp alike, what reaches a point is between them; elsewhere each pixel looks by itself. Follows
// triangles.glsl and lamp.glsl.

layout(local_size_x = 8, local_size_y = 8) in;

layout(rgba32f, binding = 0) uniform image2D picture;

layout(std430) readonly buffer Shares { vec4 shares[]; };  // of the lamp's light at the corners of each triangle

uniform sampler2D normals;  // w: the triangle
uniform sampler2D points;
uniform sampler2D ways;     // w: 0 where something is in the way
uniform sampler2D passed;   // w: the smoke's optical depth on the way
uniform dvec3 originInGeometry;
uniform vec3 color;
uniform float alike;        // shares are, within this

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, textureSize(normals, 0)))) return;
  vec4 normal = texelFetch(normals, pixel, 0);
  if (normal.w < 0.0) return;
  vec3 point = texelFetch(points, pixel, 0).xyz;
  vec4 way = texelFetch(ways, pixel, 0);
  float cosine = dot(normal.xyz, way.xyz);
  vec3 arriving = irradianceAt(point);
  if (cosine <= 0.0 || arriving == vec3(0.0)) return;
  int triangle = int(normal.w);
  vec3 known = shares[triangle].xyz;
  float share = way.w == 0.0 ? 0.0 : exp(-texelFetch(passed, pixel, 0).w);
  if (max(max(known.x, known.y), known.z) - min(min(known.x, known.y), known.z) <= alike) {
    dvec3 a = corners[3 * triangle].xyz;
    dvec3 u = corners[3 * triangle + 1].xyz - a;
    dvec3 v = corners[3 * triangle + 2].xyz - a;
    dvec3 w = originInGeometry + dvec3(point) - a;
    dvec3 across = cross(u, v);
    double area = dot(across, across);
    double second = dot(cross(w, v), across) / area;
    double third = dot(cross(u, w), across) / area;
    share = dot(max(vec3(1.0LF - second - third, second, third), 0.0), known);
  }
  imageStore(picture, pixel, imageLoad(picture, pixel) + vec4(color * arriving * (share * cosine / 3.14159265358979), 0.0));
}
