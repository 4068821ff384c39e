/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The Volute authors
 *
 * Draws numbers in memory, or a file of any kind, into a buffer, and stops a picture that takes long. */
#include <stdio.h>
#include <stdlib.h>
#include <volute/volute.h>

#define WIDTH 320
#define HEIGHT 240
#define SIDE 32

static int reports = 0;

static int listen(void* user, const char* stage, double done, double total) {
  (void)stage, (void)done, (void)total;
  ++reports;
  return *(const int*)user; /* other than 0: stop */
}

static void check(volute_status status) {
  if (status != VOLUTE_OK) {
    fprintf(stderr, "%s\n", volute_error());
    exit(1);
  }
}

int main(int count, char** arguments) {
  static double ball[SIDE][SIDE][SIDE]; /* z, y, x */
  static unsigned char picture[3 * WIDTH * HEIGHT], huge[3 * 4000 * 3000];
  volute_info info = {sizeof(volute_info), 1, SIDE, SIDE, SIDE, 1, 1, {0, 0, 0}, {2, 2, 2}, 0};
  volute_array array = {sizeof(volute_array), ball, "<f8", {0, 0, 0, 0, 0}};
  volute_view view = {.size = sizeof view, .width = WIDTH, .height = HEIGHT, .progress = listen};
  volute_drawing* drawing;
  int z, y, x, stop = 0;
  FILE* file;

  for (z = 0; z < SIDE; ++z)
    for (y = 0; y < SIDE; ++y)
      for (x = 0; x < SIDE; ++x)
        ball[z][y][x] = (z - 16) * (z - 16) + (y - 16) * (y - 16) + (x - 16) * (x - 16) < 100;
  check(count > 1 ? volute_drawing_open(arguments[1], NULL, &drawing)
                  : volute_drawing_open_array(&info, NULL, &array, "{\"emission\": 1}", &drawing));
  view.user = &stop;
  check(volute_drawing_draw(drawing, &view, picture, sizeof picture));
  file = fopen("picture.ppm", "wb");
  if (!file) return 1;
  fprintf(file, "P6 %d %d 255\n", WIDTH, HEIGHT);
  fwrite(picture, 1, sizeof picture, file);
  fclose(file);

  stop = 1, view.width = 4000, view.height = 3000;
  if (volute_drawing_draw(drawing, &view, huge, sizeof huge) != VOLUTE_CANCELLED) return 1;
  printf("%d reports; then: %s\n", reports, volute_error());
  volute_drawing_close(drawing);
  return 0;
}
