// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// How much of a lamp's light comes through all media to a place, from the bricks of its light field
// (lighting/light_field.hpp), and what a unit of extinction there sends back along the ray. M_ stands for the medium's own
// prefix, @ for the lamp's number; M_field is a storage block of all fields.

uniform int M_lampIsSun@;
uniform vec3 M_lampPlace@;     // from the picture's origin [m]; of a sun unit length, towards it
uniform vec3 M_lampWay@;       // in which it shines; unit length
uniform vec4 M_lampShape@;     // cosine of its cone, share of the half angle on which it grows, radius [m]; asymmetry of the fog
uniform vec3 M_lampLight@;     // albedo times intensity

vec3 M_towards@(vec3 place) { return M_lampIsSun@ != 0 ? M_lampPlace@ : M_lampPlace@ - place; }

#if M_BRICKS@
uniform int M_fieldFirst@;     // its first word
uniform mat3 M_fieldAxes@;     // from a place to one in roots, with
uniform vec3 M_fieldOffset@;
uniform ivec3 M_fieldRoots@;
uniform vec2 M_fieldReach@;    // of a lamp: the distance to which steps are even [m], and roots for a factor of e
uniform vec4 M_balls@[M_BALLS@ + 1];  // of finite media: where they are, from the picture's origin, and how large

float M_share@(vec3 place) {
  const int NODES = 9;
  const int STRIDE = 2 + NODES * NODES * NODES;
  vec3 at;
  int word;
  if (M_lampIsSun@ != 0) {
    at = clamp(M_fieldAxes@ * place + M_fieldOffset@, vec3(0.0), vec3(M_fieldRoots@));
    ivec3 root = min(ivec3(at), M_fieldRoots@ - 1);
    at = clamp(at - vec3(root), 0.0, 1.0);
    word = root.x + M_fieldRoots@.x * (root.y + M_fieldRoots@.y * root.z);
  } else {
    vec3 away = place - M_lampPlace@;
    vec3 size = abs(away);
    int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    float most = max(size[axis], 1e-20);
    float far = clamp(log(1.0 + length(away) / M_fieldReach@.x) * M_fieldReach@.y, 0.0, float(M_fieldRoots@.z));
    int root = min(int(far), M_fieldRoots@.z - 1);
    at = vec3(0.5 + 0.5 * away[(axis + 1) % 3] / most, 0.5 + 0.5 * away[(axis + 2) % 3] / most, far - float(root));
    at = clamp(at, 0.0, 1.0);
    word = (2 * axis + (away[axis] < 0.0 ? 1 : 0)) * M_fieldRoots@.z + root;
  }
  word = M_fieldFirst@ + STRIDE * word;
  for (int first = int(M_field[word]); first >= 0; first = int(M_field[word])) {
    int axes = int(M_field[word + 1]);
    int part = 0;
    int bit = 1;
    for (int axis = 0; axis < 3; ++axis) {
      if ((axes >> axis & 1) == 0) continue;
      at[axis] *= 2.0;
      if (at[axis] >= 1.0) {
        at[axis] -= 1.0;
        part |= bit;
      }
      bit <<= 1;
    }
    word = M_fieldFirst@ + STRIDE * (first + part);
  }
  at *= float(NODES - 1);
  ivec3 low = min(ivec3(at), NODES - 2);
  at -= vec3(low);
  word += 2 + low.x + NODES * (low.y + NODES * low.z);
  float plane[2];
  for (int k = 0; k < 2; ++k) {
    int from = word + k * NODES * NODES;
    float a = mix(uintBitsToFloat(M_field[from]), uintBitsToFloat(M_field[from + 1]), at.x);
    float b = mix(uintBitsToFloat(M_field[from + NODES]), uintBitsToFloat(M_field[from + NODES + 1]), at.x);
    plane[k] = mix(a, b, at.y);
  }
  return mix(plane[0], plane[1], at.z);
}
#else
float M_share@(vec3 place) { return 1.0; }
#endif

vec3 M_sun@(vec3 place) {
  vec3 way = M_towards@(place);
  float distance = length(way);
  float arriving = 1.0;
  if (M_lampIsSun@ == 0) {
    float cosine = distance > 0.0 ? -dot(way, M_lampWay@) / distance : 1.0;
    if (cosine < M_lampShape@.x) return vec3(0.0);
    if (M_lampShape@.y > 0.0 && M_lampShape@.x > -1.0) {
      float rim = acos(M_lampShape@.x);
      float t = clamp((rim - acos(min(cosine, 1.0))) / (M_lampShape@.y * rim), 0.0, 1.0);
      arriving = t * t * (3.0 - 2.0 * t);
    }
    float reach = max(distance, M_lampShape@.z);
    arriving /= reach * reach;
  }
  float g = M_lampShape@.w;
  float turned = distance > 0.0 ? dot(way, rayDirection) / distance : 0.0;
  float phase = (1.0 - g * g) / (12.566370614359172 * pow(1.0 + g * g - 2.0 * g * turned, 1.5));
  return M_lampLight@ * (arriving * phase * M_share@(place) * M_known@(place));
}

vec2 M_cone@;  // where the ray may be in a spot's cone

void M_findCone@() {
  M_cone@ = vec2(max(rayBegin, rayFrom), rayEnd);
  if (M_lampIsSun@ != 0 || M_lampShape@.x <= 0.0) return;
  vec3 away = rayOrigin - M_lampPlace@;
  float along = dot(away, M_lampWay@), rises = dot(rayDirection, M_lampWay@), square = M_lampShape@.x * M_lampShape@.x;
  float p = rises * rises - square;
  float q = along * rises - square * dot(away, rayDirection);
  float root = q * q - p * (along * along - square * dot(away, away));
  if (abs(p) < 1e-6) return;
  vec2 met = vec2(FARTHEST, -FARTHEST);  // nowhere
  if (root > 0.0) {
    vec2 edges = (vec2(-q) + vec2(-1.0, 1.0) * sign(p) * sqrt(root)) / p;
    edges += vec2(-1e-4, 1e-4) * sign(-p) * (1.0 + abs(edges));
    if (p > 0.0) met = rises > 0.0 ? vec2(edges.y, FARTHEST) : vec2(-FARTHEST, edges.x);
    else if (along + 0.5 * (edges.x + edges.y) * rises > 0.0) met = edges;
  }
  M_cone@ = vec2(max(M_cone@.x, met.x), min(M_cone@.y, met.y));
}

// From a place on, shadows of finite media are even about so far (LightField::evenFor).
float M_evenFor@(vec3 place) {
  float even = 1e30;
#if M_BRICKS@
  for (int i = 0; i < M_BALLS@; ++i) {
    vec3 centre = M_balls@[i].xyz;
    float radius = M_balls@[i].w;
    float across = 0.0;
    if (M_lampIsSun@ != 0) {
      across = length(cross(place - centre, M_lampPlace@));
    } else {
      vec3 axis = centre - M_lampPlace@;
      vec3 away = place - M_lampPlace@;
      float distance = length(axis);
      if (distance > radius) {
        float along = max(dot(away, axis) / distance, 0.0);
        across = length(away - along / distance * axis);
        radius *= max(along, distance) / sqrt(distance * distance - radius * radius);
      } else {
        radius = max(radius, length(away));
      }
    }
    even = min(even, max(radius / 3.0, 0.7 * (across - radius)));
  }
#endif
  return even;
}

// How far a lamp's light is nearly a polynomial from s on.
float M_evenTo@(float s, float before) {
  if (s >= M_cone@.y) return before;
  if (s < M_cone@.x) return min(before, max(M_cone@.x, s + 1e-4 * (1.0 + abs(s))));
  vec3 place = rayOrigin + s * rayDirection;
  before = min(before, s + M_evenFor@(place));
  if (M_lampIsSun@ != 0) return before;
  // Up to where the ray enters or leaves the cone, and the part of it on which all light is.
  for (int i = 0; i < 2 && M_lampShape@.x > -1.0; ++i) {
    float cosine = i == 0 ? M_lampShape@.x : cos(acos(M_lampShape@.x) * (1.0 - M_lampShape@.y));
    vec3 away = rayOrigin - M_lampPlace@;
    float along = dot(away, M_lampWay@), rises = dot(rayDirection, M_lampWay@);
    float p = rises * rises - cosine * cosine;
    float q = along * rises - cosine * cosine * dot(away, rayDirection);
    float root = q * q - p * (along * along - cosine * cosine * dot(away, away));
    for (float side = -1.0; side < 2.0 && root > 0.0 && p != 0.0; side += 2.0) {
      float edge = (side * sqrt(root) - q) / p;
      if (edge > s + 1e-4 * (1.0 + abs(s))) before = min(before, edge);
    }
  }
  return min(before, s + max(0.3 * length(M_towards@(place)), 0.5 * M_lampShape@.z));
}
