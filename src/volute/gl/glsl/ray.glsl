// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// The ray of a pixel. Places are relative to the camera's eye [m], so that floats are fine around it.

layout(local_size_x = 8, local_size_y = 8) in;

layout(rgba32f, binding = 0) writeonly uniform image2D picture;  // light towards the eye, and the optical depth

uniform ivec2 size;        // [pixels]
uniform int firstRow;      // of this dispatch
uniform vec3 forward;      // unit length
uniform vec3 right;        // one pixel, at distance 1 or (orthographic) in the world [m]
uniform vec3 down;
uniform vec2 principal;    // the image point that `forward` meets
uniform int orthographic;
uniform int opaqueGiven;
uniform sampler2D opaque;  // [m] along the ray to the nearest opaque surface; FARTHEST where there is none
uniform int lensGiven;
uniform sampler2D lens;    // directions of cameras with a lens; w = 0 where it does not reach
uniform int originsGiven;  // with the lens, for rays that are no camera's
uniform sampler2D origins; // from the eye [m]

const float FARTHEST = 3e38;

vec3 light = vec3(0.0);  // what has come out of the ray so far
float depth = 0.0;       // optical

vec3 rayOrigin = vec3(0.0);
vec3 rayDirection;
float rayBegin = 0.0;
float rayEnd = FARTHEST;
float rayFrom = -FARTHEST;  // what is before does not count, though the media are entered at rayBegin

// Through an image point of a pixel; false where there is no ray. With a lens, through the pixel's centre.
bool castRayAt(vec2 place, ivec2 pixel) {
  vec2 at = place - principal;
  if (orthographic != 0) {
    rayOrigin = at.x * right + at.y * down;
    rayDirection = forward;
    rayBegin = -FARTHEST;
  } else {
    rayDirection = normalize(forward + at.x * right + at.y * down);
  }
  if (opaqueGiven != 0) rayEnd = texelFetch(opaque, pixel, 0).r;
  if (lensGiven == 0) return true;
  vec4 bent = texelFetch(lens, pixel, 0);
  rayDirection = bent.xyz;
  if (originsGiven != 0) {
    rayOrigin = texelFetch(origins, pixel, 0).xyz;
    rayBegin = -FARTHEST;
    rayFrom = 0.0;
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
