// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// From the light that reaches the eye to what a display shows: exposure, tone curve, sRGB and dithering, as
// image/picture_style.hpp has them; or a map of colours.

in vec2 place;
out vec4 shown;

uniform sampler2D picture;  // light, optical depth
uniform sampler2D surfaces;  // light of opaque things, the power of their transmittance or 0
uniform int opaque;          // whether there are any
uniform sampler2D colors;   // of the map, as display values, dark to light
uniform vec3 background;
uniform float exposure;
uniform int mapped;  // 1: by colours; 2: the difference from `other`, by colours
uniform sampler2D other, otherSurfaces;  // likewise, of another picture
uniform int otherOpaque;
uniform float span;  // of the colours of a difference
uniform int tone;  // ToneCurve, or 4: as `view` has it
uniform sampler3D view;  // code values of a display, by light on a logarithmic scale
uniform vec3 viewScale;  // 1 / the light up to which the scale is linear, 1 / the scale's length
uniform float viewSide;

vec3 encoded(vec3 linear) {
  vec3 v = clamp(linear, 0.0, 1.0);
  return mix(12.92 * v, 1.055 * pow(v, vec3(1.0 / 2.4)) - 0.055, greaterThan(v, vec3(0.0031308)));
}

vec3 filmic(vec3 v) {
  vec3 x = vec3(dot(v, vec3(0.59719, 0.35458, 0.04823)), dot(v, vec3(0.07600, 0.90834, 0.01566)),
                dot(v, vec3(0.02840, 0.13383, 0.83777)));
  vec3 y = (x * (x + 0.0245786) - 0.000090537) / (x * (0.983729 * x + 0.4329510) + 0.238081);
  return vec3(dot(y, vec3(1.60475, -0.53108, -0.07367)), dot(y, vec3(-0.10208, 1.10813, -0.00605)),
              dot(y, vec3(-0.00327, -0.07276, 1.07602)));
}

// The brightest channel ends at 1, and the others keep their share of it.
vec3 shoulder(vec3 v) {
  float most = max(v.r, max(v.g, v.b)), least = min(v.r, min(v.g, v.b));
  float knee = 1.0 - 0.3 * (1.0 - least / max(most, 1e-6));
  return most > knee ? v * ((knee + (1.0 - knee) * (most - knee) / (1.0 - 2.0 * knee + most)) / most) : v;
}

vec3 viewed(vec3 v) {
  vec3 place = min(log2(v * viewScale.x + 1.0) * viewScale.y, 1.0);
  return texture(view, (place * (viewSide - 1.0) + 0.5) / viewSide).rgb;
}

// Each channel becomes one of the two levels around it, by a fixed pattern.
vec3 dithered(vec3 v) {
  vec3 level = 255.0 * v;
  vec3 whole = floor(level + 1e-4);
  vec3 rest = level - whole;
  vec2 at = floor(gl_FragCoord.xy);
  vec3 threshold = fract(vec3(0.7548776662466927 * at.x + 0.5698402909980532 * at.y) + vec3(0.0, 1.0, 2.0) / 3.0);
  return (whole + vec3(greaterThan(rest, max(threshold, vec3(1e-4))))) / 255.0;
}

vec3 seenIn(sampler2D lightOf, sampler2D surfacesOf, int withSurfaces) {
  vec4 light = texture(lightOf, place);
  vec4 surface = withSurfaces == 0 ? vec4(0.0) : texture(surfacesOf, place);
  return light.rgb + (surface.a > 0.0 ? exp(-surface.a * light.a) * surface.rgb : exp(-light.a) * background);
}

void main() {
  vec3 seen = exposure * seenIn(picture, surfaces, opaque);
  if (mapped == 0) {
    vec3 light = min(max(seen, 0.0), 1e4);
    shown = vec4(dithered(tone == 4 ? viewed(light)
                                    : encoded(tone == 0 ? seen : tone == 3 ? shoulder(light) : filmic(light))), 1.0);
    return;
  }
  float value = seen.r;
  if (mapped == 2) {
    vec3 apart = abs(seen - exposure * seenIn(other, otherSurfaces, otherOpaque));
    value = max(apart.r, max(apart.g, apart.b)) / span;
  }
  shown = vec4(texture(colors, vec2((clamp(value, 0.0, 1.0) * 255.0 + 0.5) / 256.0, 0.5)).rgb, 1.0);
}
