// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// What each pixel's ray meets first: how far, the normal towards the eye, and the material, or of WALLS the triangle;
// follows ray.glsl and triangles.glsl.

layout(r32f, binding = 1) writeonly uniform image2D distances;  // [m] along the ray; NOWHERE where nothing is met
layout(rgba32f, binding = 2) writeonly uniform image2D normals; // w: the material or triangle, or -1
layout(rgba32f, binding = 3) writeonly uniform image2D points;  // from the eye [m]

#if WALLS
uniform vec3 color;  // of all walls
#else
layout(std430) readonly buffer Materials { vec4 materials[]; }; // two each: base color, emission
#endif

uniform dvec3 eyeInGeometry;  // the camera's eye, from the geometry's middle [m]
uniform dvec3 exactForward;   // as ray.glsl has them, in double
uniform dvec3 exactRight;
uniform dvec3 exactDown;
uniform dvec2 exactPrincipal;
uniform float reach;         // [m] from the middle to the geometry's farthest corner
uniform vec3 ambient;        // radiance

void main() {
  ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
  if (any(greaterThanEqual(pixel, size))) return;
  Hit hit = Hit(double(NOWHERE), -1);
  dvec3 o = dvec3(0.0);
  dvec3 d = exactForward;
  if (castRay(pixel)) {
    dvec2 at = dvec2(pixel) + 0.5LF - exactPrincipal;
    dvec3 along = at.x * exactRight + at.y * exactDown;
    if (orthographic != 0) o = along;
    else if (lensGiven != 0) d = normalize(dvec3(rayDirection));
    else d = normalize(exactForward + along);
    // An orthographic ray begins before all there is.
    double back = orthographic != 0 ? 2.0LF * length(eyeInGeometry + o) + double(reach) : 0.0LF;
    hit = meetTriangles(eyeInGeometry + o - back * d, d, double(NOWHERE), false);
    if (hit.triangle >= 0) hit.s -= back;
  }
  imageStore(distances, pixel, vec4(float(hit.s)));
  if (hit.triangle < 0) {
    imageStore(normals, pixel, vec4(0.0, 0.0, 0.0, -1.0));
    imageStore(points, pixel, vec4(0.0));
    imageStore(picture, pixel, vec4(0.0));
    return;
  }
  dvec4 a = corners[3 * hit.triangle];
  vec3 normal = vec3(normalize(cross(corners[3 * hit.triangle + 1].xyz - a.xyz, corners[3 * hit.triangle + 2].xyz - a.xyz)));
  if (dot(normal, vec3(d)) > 0.0) normal = -normal;
#if WALLS
  imageStore(normals, pixel, vec4(normal, float(hit.triangle)));
  imageStore(picture, pixel, vec4(color * ambient, 1.0));
#else
  int material = int(a.w);
  imageStore(normals, pixel, vec4(normal, float(material)));
  imageStore(picture, pixel, vec4(materials[2 * material + 1].rgb + materials[2 * material].rgb * ambient, 1.0));
#endif
  imageStore(points, pixel, vec4(vec3(o + hit.s * d), 0.0));
}
