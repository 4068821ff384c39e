/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The Volute authors
 *
 * A kind of medium as a plug-in: an even ball of smoke that grows. Build it, and have it found:
 *     cc -shared -fPIC -O2 ball.c -o volute_medium_ball.so -lm
 *     VOLUTE_PLUGIN_FOLDER=$PWD volute render ball.json
 * with {"format": "volute-scene-2", "media": [{"kind": "ball", "radius": 2}]} in ball.json. */
#include <math.h>
#include <stdlib.h>
#include <volute/medium.h>

typedef struct {
  double radius, extinction, growth;
} ball;

static const double kOne = 1;
static const volute_medium_member kMembers[] = {
    {"radius", "at 0 s", "m", 1, &kOne, 1e-3, 1e3},
    {"extinction", "everywhere in it", "1/m", 1, &kOne, 0, 1e3},
    {"growth", "of the radius", "m/s", 1, NULL, 0, 10}};

static const char* open_ball(void* user, const double* values, const char* file, void** medium) {
  (void)user, (void)file;
  if (!(*medium = malloc(sizeof(ball))))
    return "there is not enough memory";
  *(ball*)*medium = (ball){values[0], values[1], values[2]};
  return NULL;
}

static const char* bounds(void* medium, double box[6]) {
  const ball* b = medium;
  for (int i = 0; i < 6; ++i) box[i] = (i < 3 ? -1 : 1) * (b->radius + 2 * b->growth);
  return NULL;
}

static size_t times(void* medium, double* at, size_t room) {
  (void)medium; /* it grows for two seconds */
  for (size_t i = 0; i < room && i < 2; ++i) at[i] = 2 * (double)i;
  return 2;
}

static const char* pieces(void* medium, double time, const volute_segment* segments, size_t count,
                          volute_pieces_function give, void* to) {
  const ball* b = medium;
  const double radius = b->radius + b->growth * time;
  for (size_t i = 0; i < count; ++i) {
    const double *o = segments[i].origin, *d = segments[i].direction;
    const double middle = -(o[0] * d[0] + o[1] * d[1] + o[2] * d[2]);
    double apart2 = 0; /* from the centre, squared, where the ray is nearest to it */
    for (int k = 0; k < 3; ++k) apart2 += (o[k] + middle * d[k]) * (o[k] + middle * d[k]);
    if (apart2 >= radius * radius)
      continue;
    const double half = sqrt(radius * radius - apart2);
    volute_piece piece = {i,
                          fmax(middle - half, segments[i].begin),
                          fmin(middle + half, segments[i].end),
                          {b->extinction},
                          {{0}},
                          0};
    if (piece.begin < piece.end)
      give(to, &piece, 1);
  }
  return NULL;
}

static const char* values(void* medium, double time, const double* points, size_t count,
                          double* extinction, double* emission) {
  (void)emission; /* holds zeros */
  const ball* b = medium;
  for (size_t i = 0; i < count; ++i) {
    const double *p = points + 3 * i, r = b->radius + b->growth * time;
    extinction[i] = p[0] * p[0] + p[1] * p[1] + p[2] * p[2] <= r * r ? b->extinction : 0;
  }
  return NULL;
}

const volute_medium_kind* volute_medium(void) {
  static volute_medium_kind kind;
  kind.size = sizeof kind, kind.name = "ball", kind.sentence = "an even ball of smoke";
  kind.members = kMembers, kind.member_count = 3;
  kind.open = open_ball, kind.close = free;
  kind.bounds = bounds, kind.times = times;
  kind.pieces = pieces, kind.values = values;
  return &kind;
}
