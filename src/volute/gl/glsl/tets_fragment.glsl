// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// One tet on one pixel's ray: the light that it sends and, in alpha, what it lets through (Staubli et al. 2005,
// equations 6 to 13). Which faces the ray meets is decided by edges alone, the lower vertex first, the same in all their
// tets: each place of the ray is in one of two neighbours, not in both or neither. Extinction and source are linear.

flat in int tetNumber;

uniform samplerBuffer places;   // of vertices, from the eye [m]
uniform isamplerBuffer tets;    // vertices, ascending
uniform samplerBuffer fields;   // of vertices: extinction [1/m], source
uniform mat3 toView;            // right, down and forward in rows
uniform mat3 toRay;             // from a pixel, homogeneous: 1 m along the view, or (orthographic) from the eye [m]
uniform int orthographic;
uniform int opaqueGiven;
uniform sampler2D opaque;       // [m] along the ray
uniform sampler2D weights;      // w0 and w1 over (d / (1 + d)) of both ends' depths
uniform int dither;             // of alpha, for targets of 8 bits

layout(location = 0) out vec4 result;

vec2 at[4];    // the vertices, seen along the ray
vec4 distances; // along the view [m]

// Twice the areas that the ray and the edges 01, 02, 03, 12, 13, 23 span.
float edges[6];

float areaOf(vec2 a, vec2 b) {
  precise float first = a.x * b.y;
  precise float second = a.y * b.x;
  precise float area = first - second;
  return area;
}

// On which side of an edge the ray passes, for the ray moved by an infinitely small step across itself: so that one
// through an edge or a vertex has one answer for all faces.
bool sideOf(float area, vec2 a, vec2 b) {
  if (area != 0.0) return area > 0.0;
  return a.y != b.y ? a.y > b.y : b.x > a.x;
}

// Which faces the ray meets, by the vertices across, from the sides of the edges.
bvec4 metBy(bool s[6]) {
  return bvec4(s[3] == s[5] && s[3] != s[4], s[1] == s[5] && s[1] != s[2], s[0] == s[4] && s[0] != s[2],
               s[0] == s[3] && s[0] != s[1]);
}

// One face alone is met where rounding makes the edges disagree: the ray passes the nearest of the edges from the vertex
// across on the other side.
bvec4 metBesides(bvec4 met, bool s[6]) {
  ivec3 from = met.x ? ivec3(0, 1, 2) : met.y ? ivec3(0, 3, 4) : met.z ? ivec3(1, 3, 5) : ivec3(2, 4, 5);
  vec3 near = abs(vec3(edges[from.x], edges[from.y], edges[from.z]));
  int least = near.x <= near.y && near.x <= near.z ? from.x : near.y <= near.z ? from.y : from.z;
  s[least] = !s[least];
  return metBy(s);
}

// The shares of the vertices where the ray meets the face across one.
vec4 sharesOn(int across) {
  vec4 w = across == 0 ? vec4(0.0, edges[5], -edges[4], edges[3])
           : across == 1 ? vec4(edges[5], 0.0, -edges[2], edges[1])
           : across == 2 ? vec4(edges[4], -edges[2], 0.0, edges[0])
                         : vec4(edges[3], -edges[1], edges[0], 0.0);
  float sum = w.x + w.y + w.z + w.w;
  w = sum != 0.0 ? clamp(w / sum, 0.0, 1.0) : vec4(notEqual(ivec4(across), ivec4(0, 1, 2, 3)));
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
  return texture(weights, (d / (1.0 + d) * (side - 1.0) + 0.5) / side).rg;
}

void main() {
  vec3 ray = toRay * vec3(gl_FragCoord.xy, 1.0);
  ivec4 tet = texelFetch(tets, tetNumber);
  for (int i = 0; i < 4; ++i) {
    vec3 place = toView * texelFetch(places, tet[i]).xyz;
    at[i] = place.xy - (orthographic != 0 ? 1.0 : place.z) * ray.xy;
    distances[i] = place.z;
  }
  bool sides[6];
  int edge = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = i + 1; j < 4; ++j) {
      edges[edge] = areaOf(at[i], at[j]);
      sides[edge] = sideOf(edges[edge], at[i], at[j]);
      ++edge;
    }
  }
  bvec4 met = metBy(sides);
  int count = int(met.x) + int(met.y) + int(met.z) + int(met.w);
  if (count == 0) discard;
  if (count == 1) met = metBesides(met, sides);
  vec4 w0 = sharesOn(met.x ? 0 : met.y ? 1 : 2);
  vec4 w1 = sharesOn(met.w ? 3 : met.z ? 2 : 1);
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
  mat4 field = mat4(texelFetch(fields, tet.x), texelFetch(fields, tet.y), texelFetch(fields, tet.z),
                    texelFetch(fields, tet.w));
  vec4 f0 = field * w0;
  vec4 f1 = field * w1;
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
