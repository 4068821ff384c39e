// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// The ray of a pixel. Places are relative to the picture's origin, which is the eye or, for an eye that is far, near what
// is seen [m]; and so that floats are fine there, a ray's s counts from where it comes nearest to that, the rayAhead-th
// metre from the eye.

layout(local_size_x = 8, local_size_y = 8) in;

layout(rgba32f, binding = 0) writeonly uniform image2D picture;  // light towards the eye, and the optical depth

uniform ivec2 size;        // [pixels]
uniform int firstRow;      // of this dispatch
uniform dvec3 eyeFromOrigin;  // [m]
uniform dvec3 forward;     // unit length
uniform dvec3 right;       // one pixel, at distance 1 or (orthographic) in the world [m]
uniform dvec3 down;
uniform dvec2 principal;   // the image point that `forward` meets
uniform int orthographic;
uniform int opaqueGiven;
uniform sampler2D opaque;  // [m] along the ray from the eye to the nearest opaque surface; FARTHEST where there is none
uniform int lensGiven;
uniform sampler2D lens;    // directions of cameras with a lens; w = 0 where it does not reach
uniform int originsGiven;  // with the lens, for rays that are no camera's: these begin in their origins
uniform sampler2D origins; // from the picture's origin [m]; of a camera's lens what is left of its directions beyond float

uniform int cuts;             // planes: media are seen where dot(xyz, place) <= w
uniform vec4 cutPlanes[24];

const float FARTHEST = 3e38;

vec3 light = vec3(0.0);  // what has come out of the ray so far
float depth = 0.0;       // optical

dvec3 exactOrigin;      // where s = 0
dvec3 exactDirection;
double exactAhead;
vec3 rayOrigin;         // the same
vec3 rayDirection;
float rayAhead = 0.0;   // [m] from the eye, or its plane, to rayOrigin
float rayBegin;
float rayEnd = FARTHEST;
float rayFrom = -FARTHEST;  // what is before does not count, though the media are entered at rayBegin

// Through an image point of a pixel; false where there is no ray. With a lens, through the pixel's centre.
bool castRayAt(vec2 place, ivec2 pixel) {
  dvec2 at = dvec2(place) - principal;
  dvec3 aside = at.x * right + at.y * down;
  vec4 bent = lensGiven != 0 ? texelFetch(lens, pixel, 0) : vec4(1.0);
  vec4 more = originsGiven != 0 ? texelFetch(origins, pixel, 0) : vec4(0.0);
  float stop = opaqueGiven != 0 ? texelFetch(opaque, pixel, 0).r : FARTHEST;
  if (originsGiven != 0) {
    rayOrigin = more.xyz;
    rayDirection = bent.xyz;
    rayBegin = -FARTHEST;
    rayFrom = 0.0;
    rayEnd = stop;
    return bent.w != 0.0;
  }
  exactOrigin = eyeFromOrigin;
  if (orthographic != 0) {
    exactOrigin += aside;
    exactDirection = forward;
  } else {
    exactDirection = forward + aside;
    if (lensGiven != 0) exactDirection = dvec3(bent.xyz) + dvec3(texelFetch(origins, pixel, 0).xyz);
    exactDirection /= sqrt(dot(exactDirection, exactDirection));
  }
  exactAhead = -dot(exactOrigin, exactDirection);
  if (orthographic == 0) exactAhead = max(exactAhead, 0.0LF);
  exactOrigin += exactAhead * exactDirection;
  rayOrigin = vec3(exactOrigin);
  rayDirection = vec3(exactDirection);
  rayAhead = float(exactAhead);
  rayBegin = orthographic != 0 ? -FARTHEST : -rayAhead;
  rayEnd = stop < FARTHEST ? float(double(stop) - exactAhead) : FARTHEST;
  rayFrom = -FARTHEST;
  for (int i = 0; i < cuts; ++i) {
    double climbs = dot(dvec3(cutPlanes[i].xyz), exactDirection);
    double below = double(cutPlanes[i].w) - dot(dvec3(cutPlanes[i].xyz), exactOrigin);
    if (climbs > 0.0LF) rayEnd = min(rayEnd, float(below / climbs));
    else if (climbs < 0.0LF) rayFrom = max(rayFrom, float(below / climbs));
    else if (below < 0.0LF) rayEnd = -FARTHEST;
  }
  return bent.w != 0.0;
}

// False where there is no pixel or no ray.
bool castRay(ivec2 pixel) {
  return all(lessThan(pixel, size)) && castRayAt(vec2(pixel) + 0.5, pixel);
}

// Cuts begin..end to where o + d s is within lo..hi; false when it never is.
bool clipAxis(float o, float d, float lo, float hi, inout float begin, inout float end) {
  if (d == 0.0) return o >= lo && o <= hi;
  float a = (lo - o) / d;
  float b = (hi - o) / d;
  begin = max(begin, min(a, b));
  end = min(end, max(a, b));
  return begin < end;
}

// The same for all axes of a box.
bool clipBox(vec3 o, vec3 d, vec3 lo, vec3 hi, inout float begin, inout float end) {
  return clipAxis(o.x, d.x, lo.x, hi.x, begin, end) && clipAxis(o.y, d.y, lo.y, hi.y, begin, end) &&
         clipAxis(o.z, d.z, lo.z, hi.z, begin, end);
}
