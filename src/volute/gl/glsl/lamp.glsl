// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// A lamp, as lighting/lamp.cpp has it.

uniform int lampIsSun;
uniform vec3 lampPlace;      // of a spot, from the camera's eye [m]
uniform vec3 lampDirection;  // its light travels that way; unit length
uniform float lampCosine;    // no light outside of this cone
uniform float lampEdge;      // share of the half angle on which it grows
uniform float lampRadius;    // [m]
uniform vec3 lampIntensity;

vec3 irradianceAt(vec3 point) {
  if (lampIsSun != 0) return lampIntensity;
  vec3 away = point - lampPlace;
  float distance = length(away);
  float share = 1.0;
  if (distance > 0.0 && lampCosine > -1.0) {  // all around has no rim
    float cosine = dot(away, lampDirection) / distance;
    if (cosine < lampCosine) return vec3(0.0);
    if (lampEdge > 0.0) {
      float rim = acos(lampCosine);
      float t = clamp((rim - acos(min(cosine, 1.0))) / (lampEdge * rim), 0.0, 1.0);
      share = t * t * (3.0 - 2.0 * t);
    }
  }
  float reach = max(distance, lampRadius);
  return share / (reach * reach) * lampIntensity;
}

// Unit length, and how far.
vec4 towardsLamp(vec3 point) {
  if (lampIsSun != 0) return vec4(-lampDirection, NOWHERE);
  vec3 way = lampPlace - point;
  float distance = length(way);
  return distance > 0.0 ? vec4(way / distance, distance) : vec4(0.0);
}
