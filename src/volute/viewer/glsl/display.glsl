// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// From the light that reaches the eye to what a display shows: exposure, then sRGB or a map of colours.

in vec2 place;
out vec4 shown;

uniform sampler2D picture;  // light, optical depth
uniform sampler2D surfaces;  // light of opaque things, the power of their transmittance or 0
uniform int opaque;          // whether there are any
uniform sampler2D colors;   // of the map, as display values, dark to light
uniform vec3 background;
uniform float exposure;
uniform int mapped;

vec3 encoded(vec3 linear) {
  vec3 v = clamp(linear, 0.0, 1.0);
  return mix(12.92 * v, 1.055 * pow(v, vec3(1.0 / 2.4)) - 0.055, greaterThan(v, vec3(0.0031308)));
}

void main() {
  vec4 light = texture(picture, place);
  vec3 seen = light.rgb;
  vec4 surface = opaque == 0 ? vec4(0.0) : texture(surfaces, place);
  seen += surface.a > 0.0 ? exp(-surface.a * light.a) * surface.rgb : exp(-light.a) * background;
  seen *= exposure;
  if (mapped == 0) {
    shown = vec4(encoded(seen), 1.0);
  } else {
    float t = clamp(seen.r, 0.0, 1.0);
    shown = vec4(texture(colors, vec2((t * 255.0 + 0.5) / 256.0, 0.5)).rgb, 1.0);
  }
}
