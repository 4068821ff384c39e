/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The Volute authors
 *
 * Draws a function of place and time, then a kind of medium of one's own (../plugin/ball.c). */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volute/volute.h>

const volute_medium_kind* volute_medium(void); /* of ../plugin/ball.c */

static int puff(void* user, double time, const double* x, const double* y, const double* z,
                size_t count, float* values) {
  size_t i;
  for (i = 0; i < count; ++i) {
    const double apart = pow(x[i] - time, 2) + y[i] * y[i] + z[i] * z[i];
    values[i] = (float)exp(-apart * *(const double*)user);
  }
  return 0;
}

static void check(volute_status status) {
  if (status != VOLUTE_OK) {
    fprintf(stderr, "%s\n", volute_error());
    exit(1);
  }
}

static void draw(volute_drawing* drawing, const volute_view* view) {
  static float light[3 * 33 * 25];
  check(volute_drawing_light(drawing, view, light, sizeof light / sizeof *light));
  printf("middle %.4f, corner %.4f\n", light[3 * (12 * 33 + 16)], light[0]);
  volute_drawing_close(drawing);
}

int main(void) {
  volute_info info = {sizeof(volute_info), 2, 24, 24, 24, 1, 1, {-2, -2, -2}, {2, 2, 2}, 0};
  const double times[] = {0, 0.5}, sharpness = 2, late = 2;
  volute_view view;
  volute_drawing* drawing;
  FILE* scene = fopen("ball.json", "w");

  memset(&view, 0, sizeof view);
  view.size = sizeof view, view.width = 33, view.height = 25;
  check(volute_drawing_open_function(&info, times, puff, (void*)&sharpness, "{\"emission\": 1}",
                                     &drawing));
  draw(drawing, &view);

  check(volute_medium_register(volute_medium()));
  if (!scene)
    return 1;
  fprintf(scene, "{\"format\": \"volute-scene-2\", \"background\": [1, 1, 1], \"media\": [");
  fprintf(scene, "{\"kind\": \"ball\", \"radius\": 1, \"extinction\": 0.5, \"growth\": 0.5}]}");
  fclose(scene);
  check(volute_drawing_open("ball.json", NULL, &drawing));
  view.time = &late, view.camera = "{\"eye\": [0,-9,0], \"target\": [0,0,0], \"fov\": 40}";
  draw(drawing, &view);
  return 0;
}
