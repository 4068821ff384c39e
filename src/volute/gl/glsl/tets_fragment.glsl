// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// One tet on one pixel's ray: the light that it sends and, in alpha, what it lets through (Staubli et al. 2005,
// equations 6 to 13). Which faces the ray meets is decided by edges alone, the lower vertex first, the same in all their
// tets: each place of the ray is in one of two neighbours, not in both or neither. Extinction and source are linear.

flat in vec3 seen[4];   // the vertices, ascending, along the view's axes [m]
flat in vec4 field[4];  // extinction [1/m], source

uniform mat3 toRay;             // from a pixel, homogeneous: 1 m along the view, or (orthographic) from the eye [m]
uniform int orthographic;
uniform int opaqueGiven;
uniform sampler2D opaque;       // [m] along the ray
uniform sampler2D weights;      // w0 and w1 over (d / (1 + d)) of both ends' depths
uniform int dither;             // of alpha, for targets of 8 bits

layout(location = 0) out vec4 result;

vec2 at[4];  // the vertices, seen along the ray

// Twice the areas that the ray spans with the edges between the vertices.
float e01, e02, e03, e12, e13, e23;

float areaOf(vec2 a, vec2 b) {
  precise float first = a.x * b.y;
  precise float second = a.y * b.x;
  precise float area = first - second;
  return area;
}

// On which side of an edge the ray passes, for the ray moved by an infinitely small step across itself: so that one
// through an edge or a vertex has one answer for all faces.
bool sideOf(float area, vec2 a, vec2 b) {
  return (area != 0.0 ? area : a.y != b.y ? a.y - b.y : b.x - a.x) > 0.0;
}

// The sides of the edges 01, 02, 03 and of 12, 13, 23.
bvec3 fromFirst, others;

// Which faces the ray meets, by the vertices across.
bvec4 metFaces() {
  return bvec4(others.x == others.z && others.x != others.y, fromFirst.y == others.z && fromFirst.y != fromFirst.z,
               fromFirst.x == others.y && fromFirst.x != fromFirst.z,
               fromFirst.x == others.x && fromFirst.x != fromFirst.y);
}

// One face alone is met where rounding makes the edges disagree: the ray passes the nearest of the edges from the vertex
// across on the other side.
bvec4 metBesides(bvec4 met) {
  vec3 near = abs(met.x ? vec3(e01, e02, e03) : met.y ? vec3(e01, e12, e13) : met.z ? vec3(e02, e12, e23)
                                                                                    : vec3(e03, e13, e23));
  bool first = near.x <= near.y && near.x <= near.z;
  bool second = !first && near.y <= near.z;
  bool third = !first && !second;
  if (met.x) fromFirst = bvec3(fromFirst.x != first, fromFirst.y != second, fromFirst.z != third);
  else if (met.y) {
    fromFirst.x = fromFirst.x != first;
    others.xy = bvec2(others.x != second, others.y != third);
  } else if (met.z) {
    fromFirst.y = fromFirst.y != first;
    others.xz = bvec2(others.x != second, others.z != third);
  } else {
    fromFirst.z = fromFirst.z != first;
    others.yz = bvec2(others.y != second, others.z != third);
  }
  return metFaces();
}

// The shares of the vertices where the ray meets the face across one.
vec4 sharesOn(int across) {
  vec4 w = across == 0 ? vec4(0.0, e23, -e13, e12)
           : across == 1 ? vec4(e23, 0.0, -e03, e02)
           : across == 2 ? vec4(e13, -e03, 0.0, e01)
                         : vec4(e12, -e02, e01, 0.0);
  float sum = w.x + w.y + w.z + w.w;
  if (sum == 0.0) return vec4(notEqual(ivec4(across), ivec4(0, 1, 2, 3))) / 3.0;
  w = clamp(w / sum, 0.0, 1.0);
  return w / (w.x + w.y + w.z + w.w);
}

// Equation 7 for thin segments: the integrals of 1 - e^-t, to the third order of t = a s + b s^2.
vec2 thinWeights(float d0, float d1, float passed) {
  float a = d0;
  float b = 0.5 * (d1 - d0);
  float t1 = a / 2.0 + b / 3.0;
  float t2 = a * a / 3.0 + a * b / 2.0 + b * b / 5.0;
  float t3 = a * a * a / 4.0 + 0.6 * a * a * b + 0.5 * a * b * b + b * b * b / 7.0;
  float w0 = t1 - t2 / 2.0 + t3 / 6.0;
  return vec2(w0, 1.0 - passed - w0);
}

vec2 tableWeights(float d0, float d1) {
  vec2 d = vec2(d0, d1);
  float side = float(textureSize(weights, 0).x);
  return textureLod(weights, (d / (1.0 + d) * (side - 1.0) + 0.5) / side, 0.0).rg;
}

void main() {
  vec3 ray = toRay * vec3(gl_FragCoord.xy, 1.0);
  for (int i = 0; i < 4; ++i) at[i] = seen[i].xy - (orthographic != 0 ? 1.0 : seen[i].z) * ray.xy;
  e01 = areaOf(at[0], at[1]);
  e02 = areaOf(at[0], at[2]);
  e03 = areaOf(at[0], at[3]);
  e12 = areaOf(at[1], at[2]);
  e13 = areaOf(at[1], at[3]);
  e23 = areaOf(at[2], at[3]);
  fromFirst = bvec3(sideOf(e01, at[0], at[1]), sideOf(e02, at[0], at[2]), sideOf(e03, at[0], at[3]));
  others = bvec3(sideOf(e12, at[1], at[2]), sideOf(e13, at[1], at[3]), sideOf(e23, at[2], at[3]));
  bvec4 met = metFaces();
  if (!any(met)) discard;
  if (int(met.x) + int(met.y) + int(met.z) + int(met.w) == 1) met = metBesides(met);
  vec4 w0 = sharesOn(met.x ? 0 : met.y ? 1 : 2);
  vec4 w1 = sharesOn(met.w ? 3 : met.z ? 2 : 1);
  vec4 distances = vec4(seen[0].z, seen[1].z, seen[2].z, seen[3].z);  // along the view
  float from = dot(w0, distances);
  float to = dot(w1, distances);
  if (from > to) {
    vec4 other = w0;
    w0 = w1;
    w1 = other;
    float behind = from;
    from = to;
    to = behind;
  }
  if (orthographic == 0) {
    if (to <= 0.0) discard;
    if (from < 0.0) {  // the eye is inside
      w0 = mix(w0, w1, -from / (to - from));
      from = 0.0;
    }
    float scale = length(ray);
    from *= scale;
    to *= scale;
  }
  float way = to - from;
  if (!(way > 0.0)) discard;
  if (opaqueGiven != 0) {
    float room = texelFetch(opaque, ivec2(gl_FragCoord.xy), 0).r - from;
    if (room <= 0.0) discard;
    if (room < way) {
      w1 = mix(w0, w1, room / way);
      way = room;
    }
  }
  mat4 corners = mat4(field[0], field[1], field[2], field[3]);
  vec4 f0 = corners * w0;
  vec4 f1 = corners * w1;
  float d0 = max(f0.x, 0.0) * way;
  float d1 = max(f1.x, 0.0) * way;
  float passed = exp(-0.5 * (d0 + d1));
  vec2 w01 = d0 + d1 < 0.1 ? thinWeights(d0, d1, passed) : tableWeights(d0, d1);
  vec3 light = w01.x * f0.yzw + w01.y * f1.yzw;
  if (dither != 0) {  // equations 12 and 13; the light follows, for it is as much as does not pass
    float steps = 255.0 * passed;
    float rounded = (floor(steps) + (fract(steps) > fract(256.0 * steps) ? 1.0 : 0.0)) / 255.0;
    light *= passed < 1.0 ? (1.0 - rounded) / (1.0 - passed) : 0.0;
    passed = rounded;
  }
  result = vec4(light, passed);
}
