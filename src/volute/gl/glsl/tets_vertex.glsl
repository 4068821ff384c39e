// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Covers of projected tetrahedra: four corners each, gl_VertexID = 4 * tet + corner. A cover is the tet's outline (Staubli
// et al. 2005, Figure 3), a little larger, so that it has all pixels whose rays pass the tet, wherever the rasteriser's
// grid puts its corners; what the ray has in the tet is found in each pixel. Its depth is that of the tet's nearest
// vertex, so that the depth test culls tets that are behind walls and no others.

uniform samplerBuffer places;      // of vertices, from the eye [m]
uniform isamplerBuffer tets;       // vertices, ascending
uniform usamplerBuffer outlines;   // bits: two for each of the tet's vertices in turn, then how many are the outline's,
                                   // 0 where the eye is inside
uniform samplerBuffer fields;      // of vertices: extinction [1/m], source

uniform mat3 toView;      // right, down and forward in rows
uniform mat3 toImage;     // from there to the picture's pixels, homogeneous
uniform vec2 halfSize;    // [pixels]
uniform float nearest;    // [m]; depths are nearest / w
uniform int orthographic;
uniform float farthest;   // [m] from the eye's plane, where orthographic
uniform float margin;     // [pixels], more than the rasteriser's grid and rounding

flat out vec3 seen[4];    // the vertices, ascending, along the view's axes [m]
flat out vec4 field[4];   // extinction [1/m], source

const float NEEDLE = 0.1;   // sine of the least angle of an outline that is widened side by side
const float SHORT = 0.0625; // [pixels] shortest side of one

vec2 pixels[4];   // of the vertices
vec2 ordered[4];  // of the outline's in turn, then what is left

// The corner of an outline each of whose sides is moved outwards; false for needles and what rounding has bent.
bool sharpCorner(int sides, int corner, out vec2 place) {
  bool three = sides == 3;
  int mine = three ? min(corner, 2) : corner;
  vec2 along[4];
  float shortest = 3e38;
  for (int i = 0; i < 4; ++i) {
    vec2 side = (i == 2 && three ? ordered[0] : ordered[(i + 1) & 3]) - ordered[i];
    float size = length(side);
    if (i < 3 || !three) shortest = min(shortest, size);
    along[i] = side / size;
  }
  float least = 1.0;
  float most = -1.0;
  for (int i = 0; i < 4; ++i) {
    vec2 before = i > 0 ? along[(i + 3) & 3] : three ? along[2] : along[3];
    float turn = before.x * along[i].y - before.y * along[i].x;
    if (i < 3 || !three) {
      least = min(least, turn);
      most = max(most, turn);
    }
    if (i == mine) place = ordered[i] + margin / abs(turn) * (before - along[i]);
  }
  return shortest >= SHORT && (least > NEEDLE || most < -NEEDLE);
}

// A rectangle around all vertices along their largest distance.
vec2 rectangleCorner(int corner) {
  vec2 along = vec2(0.0);
  for (int i = 0; i < 3; ++i) {
    for (int j = i + 1; j < 4; ++j) {
      vec2 between = pixels[j] - pixels[i];
      if (dot(between, between) > dot(along, along)) along = between;
    }
  }
  along = along == vec2(0.0) ? vec2(1.0, 0.0) : normalize(along);
  vec2 across = vec2(-along.y, along.x);
  vec2 low = vec2(-margin);
  vec2 high = vec2(margin);
  for (int i = 1; i < 4; ++i) {
    vec2 at = vec2(dot(pixels[i] - pixels[0], along), dot(pixels[i] - pixels[0], across));
    low = min(low, at - margin);
    high = max(high, at + margin);
  }
  return pixels[0] + (corner == 1 || corner == 2 ? high.x : low.x) * along + (corner < 2 ? low.y : high.y) * across;
}

void widen(vec3 place, inout vec2 low, inout vec2 high) {
  vec3 pixel = toImage * place;
  low = min(low, pixel.xy / pixel.z);
  high = max(high, pixel.xy / pixel.z);
}

// The picture's part that has what of the tet is before the eye: of its vertices, and of where its edges come there.
vec2 boxCorner(int corner) {
  float from = 1e-3 * nearest;
  vec2 low = vec2(1e30);
  vec2 high = vec2(-1e30);
  for (int i = 0; i < 4; ++i) {
    if (orthographic != 0) widen(vec3(seen[i].xy, 1.0), low, high);
    else if (seen[i].z > from) widen(seen[i], low, high);
  }
  for (int i = 0; i < 3 && orthographic == 0; ++i) {
    for (int j = i + 1; j < 4; ++j) {
      if ((seen[i].z > from) == (seen[j].z > from)) continue;
      float share = clamp((from - seen[i].z) / (seen[j].z - seen[i].z), 0.0, 1.0);
      widen(vec3(mix(seen[i].xy, seen[j].xy, share), from), low, high);
    }
  }
  if (low.x > high.x) return vec2(-margin);  // all is behind the eye
  low = clamp(low - margin, vec2(-margin), 2.0 * halfSize + margin);
  high = clamp(high + margin, vec2(-margin), 2.0 * halfSize + margin);
  return vec2(corner == 1 || corner == 2 ? high.x : low.x, corner < 2 ? low.y : high.y);
}

void main() {
  int tet = gl_VertexID >> 2;
  int corner = gl_VertexID & 3;
  ivec4 vertices = texelFetch(tets, tet);
  uint outline = texelFetch(outlines, tet).r;
  int sides = int(outline >> 8);
  float front = 3e38;
  float farAside = 0.0;  // in halves of the picture
  for (int i = 0; i < 4; ++i) {
    seen[i] = toView * texelFetch(places, vertices[i]).xyz;
    field[i] = texelFetch(fields, vertices[i]);
    vec3 pixel = toImage * (orthographic != 0 ? vec3(seen[i].xy, 1.0) : seen[i]);
    pixels[i] = pixel.xy / pixel.z;
    front = min(front, seen[i].z);
    vec2 aside = abs(pixels[i] / halfSize - 1.0);
    farAside = max(farAside, max(aside.x, aside.y));
  }
  for (int i = 0; i < 4; ++i) {
    uint which = outline >> 2 * i & 3u;
    ordered[i] = which < 2u ? (which == 0u ? pixels[0] : pixels[1]) : which == 2u ? pixels[2] : pixels[3];
  }
  vec2 place = vec2(0.0);
  if (sides == 0 || !(farAside < 8.0) || (orthographic == 0 && front < nearest)) place = boxCorner(corner);
  else if (!sharpCorner(sides, corner, place)) place = rectangleCorner(corner);
  float depth = orthographic != 0 ? 0.5 - 0.25 * front / farthest : front > nearest ? nearest / front : 1.0;
  gl_Position = vec4(place / halfSize - 1.0, depth, 1.0);
}
