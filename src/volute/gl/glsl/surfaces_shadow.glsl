// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// The ways from what is seen to a lamp, for the march through the media; follows triangles.glsl and lamp.glsl.

layout(local_size_x = 8, local_size_y = 8) in;

layout(rgba32f, binding = 0) uniform image2D ways;  // direction; w = 0 where no light arrives
layout(r32f, binding = 1) writeonly uniform image2D distances;  // [m] to the lamp

uniform sampler2D normals;
uniform sampler2D points;
uniform dvec3 originInGeometry;
uniform int again;   // others were in the way before
uniform dvec3 lampInGeometry;
uniform float lift;  // of a shadow's ray from its surface, and its end's from a lamp, which may be in the plane of another,
                     // times 1 + its place: more than rounding moves it

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, textureSize(normals, 0)))) return;
  vec4 normal = texelFetch(normals, pixel, 0);
  vec3 point = texelFetch(points, pixel, 0).xyz;
  vec4 way = towardsLamp(point);
  dvec3 at = originInGeometry + dvec3(point);
  float lifted = lift * (1.0 + float(max(max(abs(at.x), abs(at.y)), abs(at.z))));
  bool lit = normal.w >= 0.0 && dot(normal.xyz, way.xyz) * way.w > lifted && irradianceAt(point) != vec3(0.0);
  if (again != 0) lit = imageLoad(ways, pixel).w != 0.0;
  if (lit) {
    at += lifted * normal.xyz;
    dvec3 to = lampIsSun != 0 ? dvec3(way.xyz) : lampInGeometry - at;
    double far = lampIsSun != 0 ? double(way.w) : length(to);
    lit = meetTriangles(at, to / length(to), far - lifted, true).triangle < 0;
  }
  imageStore(ways, pixel, vec4(way.xyz, lit ? 1.0 : 0.0));
  imageStore(distances, pixel, vec4(way.w));
}
