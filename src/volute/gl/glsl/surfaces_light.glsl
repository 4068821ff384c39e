// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Adds what a lamp sends back from each surface (Lambert); follows lamp.glsl.

layout(local_size_x = 8, local_size_y = 8) in;

layout(rgba32f, binding = 0) uniform image2D picture;

layout(std430) readonly buffer Materials { vec4 materials[]; };

uniform sampler2D normals;
uniform sampler2D points;
uniform sampler2D ways;
uniform sampler2D passed;  // w: the media's optical depth on the way
uniform int passedGiven;

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, textureSize(normals, 0)))) return;
  vec4 way = texelFetch(ways, pixel, 0);
  if (way.w == 0.0) return;
  vec4 normal = texelFetch(normals, pixel, 0);
  float share = passedGiven != 0 ? exp(-texelFetch(passed, pixel, 0).w) : 1.0;
  vec3 base = materials[2 * int(normal.w)].rgb;
  vec3 light = base / 3.14159265358979 * irradianceAt(texelFetch(points, pixel, 0).xyz) * dot(normal.xyz, way.xyz) * share;
  imageStore(picture, pixel, imageLoad(picture, pixel) + vec4(light, 0.0));
}
