// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// A tet's optical depth on a pixel's ray, to be summed by blending. The ray is inside between its faces' planes, which
// both tets beside a face compute to the same bit. The extinction is affine.

flat in vec4 across[4];
flat in vec4 extinctionPerMetre;
flat in vec4 sharePerMetre;
flat in int seconds;
flat in int boundaries;

uniform vec3 rayCorner;    // the ray of image point (0, 0): its direction, or (orthographic) its origin from the eye [m]
uniform vec3 rayRight;     // and one pixel further
uniform vec3 rayDown;
uniform vec3 forward;
uniform int orthographic;
uniform vec3 eye;          // [m], from the mesh's middle
uniform float grazing;     // [m]
uniform int opaqueGiven;
uniform sampler2D opaque;  // [m] along the ray

layout(location = 0) out vec4 result;

void main() {
  vec3 place = rayCorner + gl_FragCoord.x * rayRight + gl_FragCoord.y * rayDown;
  vec3 direction = orthographic != 0 ? forward : normalize(place);
  // Rays in planes or along edges are those of tets that lie aside: towards the mesh's middle, in a direction that no
  // plane has by design.
  vec3 aside = -eye - (orthographic != 0 ? place : vec3(0.0));
  aside += 1e3 * grazing * vec3(0.3713, 0.8291, 0.4189);
  aside -= dot(aside, direction) * direction;
  vec4 away;   // from the planes at the ray's origin, inwards [m]
  vec4 along;  // what a metre of the ray adds
  float begin = orthographic != 0 ? -3e38 : 0.0;
  float end = opaqueGiven != 0 ? texelFetch(opaque, ivec2(gl_FragCoord.xy), 0).r : 3e38;
  for (int i = 0; i < 4; ++i) {
    precise float rise = dot(across[i].xyz, direction);
    precise float from = orthographic != 0 ? across[i].w + dot(across[i].xyz, place) : across[i].w;
    away[i] = from;
    along[i] = rise;
    if (abs(rise) < 1e-6 && abs(from) < grazing) {  // in the plane, up to rounding
      if ((boundaries >> i & 1) != 0) continue;     // there is no other tet that could have it
      float side = dot(across[i].xyz, aside);
      if (side < 0.0 || (side == 0.0 && (seconds >> i & 1) != 0)) discard;
      continue;
    }
    if (rise > 0.0) begin = max(begin, -from / rise);
    if (rise < 0.0) end = min(end, -from / rise);
    if (rise == 0.0 && from < 0.0) discard;
  }
  if (!(begin < end)) discard;
  vec4 middle = max(away + 0.5 * (begin + end) * along, 0.0);
  float mean = dot(middle, extinctionPerMetre) / max(dot(middle, sharePerMetre), 1e-6);
  result = vec4(0.0, 0.0, 0.0, (end - begin) * mean);
}
