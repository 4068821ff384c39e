// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
// Emission and absorption over one stretch of a ray on which every medium is smooth. MARCH says what is known of them:
//   MARCH_CONSTANT      extinction and emission do not change: closed form
//   MARCH_PROPORTIONAL  emission is marchColor times the extinction: closed form with the optical depth
//   MARCH_THIN          nothing absorbs: the emission's integral
//   MARCH_GENERAL       Gauss' rule, with the depth up to each of its points from the polynomial through all of them
// mediaAt(s, k, e) gives the extinction [1/m] and the emission of all media together.

const float DARK = 13.9;  // e^-13.9 < 1e-6 of the light passes

#if MARCH == MARCH_CONSTANT

void march(float from, float to) {
  float k = 0.0;
  vec3 e = vec3(0.0);
  mediaAt(0.5 * (from + to), k, e);
  float h = to - from;
  float t = k * h;
  float share = abs(t) < 1e-2 ? 1.0 - t * (0.5 - t * (1.0 / 6.0 - t / 24.0)) : (1.0 - exp(-t)) / t;
  light += exp(-depth) * share * h * e;
  depth += t;
}

#else

void evaluate(float from, float h, out float k[POINTS], out vec3 e[POINTS]) {
  for (int i = 0; i < POINTS; ++i) {
    k[i] = 0.0;
    e[i] = vec3(0.0);
    mediaAt(from + gaussNodes[i] * h, k[i], e[i]);
  }
}

float opticalDepth(float k[POINTS], float h) {
  float t = 0.0;
  for (int i = 0; i < POINTS; ++i) t += gaussWeights[i] * k[i] * h;
  return t;
}

#if MARCH == MARCH_GENERAL

// The media are evaluated in one place: where they were in two, a device might run both.
void march(float from, float to) {
  const float MOST = 1.5;  // of one rule: its error is then below 1e-6 of the brightest
  float h = to - from;
  float k[POINTS];
  vec3 e[POINTS];
  int parts = 0;  // not known yet
  for (int part = 0; part < max(parts, 1);) {
    evaluate(from + float(part) * h, h, k, e);
    float t = opticalDepth(k, h);
    if (parts == 0) {
      parts = t > MOST ? int(min(ceil(t / MOST), 4096.0)) : 1;
      h /= float(parts);
      if (parts > 1) continue;
    }
    vec3 sum = vec3(0.0);
    for (int i = 0; i < POINTS; ++i) {
      float before = 0.0;
      for (int j = 0; j < POINTS; ++j) before += gaussBefore[i * POINTS + j] * k[j];
      sum += gaussWeights[i] * exp(-before * h) * e[i];
    }
    light += exp(-depth) * h * sum;
    depth += t;
#if !MEASURE
    if (depth > DARK) break;
#endif
    ++part;
  }
}

#else

void march(float from, float to) {
  float h = to - from;
  float k[POINTS];
  vec3 e[POINTS];
  evaluate(from, h, k, e);
#if MARCH == MARCH_PROPORTIONAL
  float t = opticalDepth(k, h);
  light += exp(-depth) * (t < 1e-3 ? t * (1.0 - 0.5 * t) : 1.0 - exp(-t)) * marchColor;
  depth += t;
#else
  for (int i = 0; i < POINTS; ++i) light += gaussWeights[i] * h * e[i];
#endif
}

#endif
#endif
