/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The Volute authors
 *
 * What a walker of a C program sees and takes in: `engine CASE SIGNS`; tests/install_test.py builds and runs it. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include <volute/volute.h>

#define CHECK(truth) \
  if (!(truth)) {    \
    fprintf(stderr, "%d: not %s; %s\n", __LINE__, #truth, volute_error()); \
    return 1;        \
  }

enum { kAgents = 2, kCriteria = 16 };

int main(int count, char** arguments) {
  CHECK(count == 3);
  volute_engine* engine = NULL;
  CHECK(volute_engine_open("no.smv", arguments[2], &engine) == VOLUTE_NOT_FOUND && !engine);
  CHECK(volute_engine_open(arguments[1], arguments[2], &engine) == VOLUTE_OK);
  CHECK(volute_engine_sign_count(engine) == 1 && strcmp(volute_engine_sign_name(engine, 0), "exit") == 0);
  CHECK(!volute_engine_sign_name(engine, 1));
  const size_t criteria = volute_engine_criterion_count(engine);
  CHECK(criteria > 2 && criteria <= kCriteria);
  size_t heat = criteria;
  for (size_t c = 0; c < criteria; ++c) {
    if (strcmp(volute_engine_criterion_name(engine, c), "fed-heat") == 0)
      heat = c;
  }
  CHECK(heat < criteria && volute_engine_criterion_limit(engine, heat) == 0.3);

  /* One by the fire, and one far away. */
  const int64_t ids[kAgents] = {4, 7};
  const double eyes[3 * kAgents] = {22, 6, 2, 2, 6, 2};
  unsigned char seen[kAgents];
  CHECK(volute_engine_sees(engine, 0, eyes, kAgents, seen) == VOLUTE_OK && seen[1] == VOLUTE_SEEN);
  CHECK(volute_engine_sees(engine, -1, eyes, kAgents, seen) == VOLUTE_OK && seen[1] == VOLUTE_CANNOT_TELL);
  double dose[kAgents * kCriteria], again[kAgents * kCriteria], worst[kAgents * kCriteria];
  for (int t = 0; t <= 35; ++t) {
    CHECK(volute_engine_dose(engine, t, ids, eyes, kAgents, dose) == VOLUTE_OK);
    CHECK(volute_engine_dose_at_worst(engine, t, ids, eyes, kAgents, again, worst) == VOLUTE_OK);
  }
  int above = 0;
  for (size_t i = 0; i < kAgents * criteria; ++i) {
    CHECK(dose[i] == again[i] || (isnan(dose[i]) && isnan(again[i])));
    CHECK(!(worst[i] < dose[i]) || i / kAgents != heat);
    above += worst[i] > dose[i];
  }
  CHECK(above > 0);
  CHECK(dose[heat * kAgents] > dose[heat * kAgents + 1]);
  CHECK(volute_engine_dose_at_worst(engine, 36, ids, eyes, kAgents, dose, NULL) == VOLUTE_INVALID_ARGUMENT);
  CHECK(volute_engine_dose_at_worst(engine, NAN, ids, eyes, kAgents, dose, worst) == VOLUTE_INVALID_ARGUMENT);
  volute_engine_close(engine);
  puts("doses, and the most that they may be");
  return 0;
}
