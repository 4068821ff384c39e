// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// What each pixel's ray meets first: how far, the normal towards the eye, and the material; follows ray.glsl and
// triangles.glsl.

layout(r32f, binding = 1) writeonly uniform image2D distances;  // [m] from the eye; NOWHERE where nothing is met
layout(rgba32f, binding = 2) writeonly uniform image2D normals; // w: the material, or -1
layout(rgba32f, binding = 3) writeonly uniform image2D points;  // from the picture's origin [m]

layout(std430) readonly buffer Materials { vec4 materials[]; }; // two each: base color, emission

layout(std430) readonly buffer Normals { vec4 cornerNormals[]; };  // three a triangle of a curved surface, else 0; w: how
                                                                   // far that may stand out [m]
uniform int smoothed;  // there are such

uniform dvec3 originInGeometry;  // the picture's origin, from the geometry's middle [m]
uniform float reach;         // [m] from the middle to the geometry's farthest corner
uniform vec3 ambient;        // radiance

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, size))) return;
  Hit hit = Hit(double(NOWHERE), -1);
  if (castRay(pixel)) {
    // From before all there is, but not before a pinhole's eye.
    double back = length(originInGeometry + exactOrigin) + double(reach);
    if (orthographic == 0) back = min(back, exactAhead);
    hit = meetTriangles(originInGeometry + exactOrigin - back * exactDirection, exactDirection, double(NOWHERE), false);
    if (hit.triangle >= 0) hit.s -= back;
  }
  imageStore(distances, pixel, vec4(hit.triangle >= 0 ? float(hit.s + exactAhead) : NOWHERE));
  if (hit.triangle < 0) {
    imageStore(normals, pixel, vec4(0.0, 0.0, 0.0, -1.0));
    imageStore(points, pixel, vec4(0.0));
    imageStore(picture, pixel, vec4(0.0));
    return;
  }
  dvec4 a = corners[3 * hit.triangle];
  dvec3 ab = corners[3 * hit.triangle + 1].xyz - a.xyz;
  dvec3 ac = corners[3 * hit.triangle + 2].xyz - a.xyz;
  vec3 normal = vec3(normalize(cross(ab, ac)));
  if (dot(normal, rayDirection) > 0.0) normal = -normal;
  float lift = 0.0;
  if (smoothed != 0 && cornerNormals[3 * hit.triangle].w > 0.0) {
    dvec3 across = cross(ab, ac);
    dvec3 at = originInGeometry + exactOrigin + hit.s * exactDirection - a.xyz;
    float second = clamp(float(dot(cross(at, ac), across) / dot(across, across)), 0.0, 1.0);
    float third = clamp(float(dot(cross(ab, at), across) / dot(across, across)), 0.0, 1.0 - second);
    vec3 curved = normalize((1.0 - second - third) * cornerNormals[3 * hit.triangle].xyz +
                            second * cornerNormals[3 * hit.triangle + 1].xyz +
                            third * cornerNormals[3 * hit.triangle + 2].xyz);
    if (dot(curved, normal) < 0.0) curved = -curved;
    float along = dot(curved, rayDirection);  // what is seen is seen from that side
    normal = along < 0.0 ? curved : normalize(curved - (along + 1e-6) * rayDirection);
    lift = cornerNormals[3 * hit.triangle].w;
  }
  int material = int(a.w);
  imageStore(normals, pixel, vec4(normal, float(material)));
  imageStore(picture, pixel, vec4(materials[2 * material + 1].rgb + materials[2 * material].rgb * ambient, 1.0));
  imageStore(points, pixel, vec4(vec3(exactOrigin + hit.s * exactDirection) + lift * normal, 0.0));
}
