/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The Volute authors
 *
 * Writes a .volute from frames filled by a callback, reads a region, and looks through it. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <volute/volute.h>

#define SIDE 32

/* The extinction [1/m] of smoke in the lower half of a cube that gets thicker: frame 0, 1, 2 .. */
static float smoke(int frame, int z) { return z < SIDE / 2 ? 0.5f * (float)(frame + 1) : 0.0f; }

static int fill(void* user, int32_t frame, float* values, size_t count) {
  size_t i;
  (void)user;
  for (i = 0; i < count; ++i) values[i] = smoke(frame, (int)(i / (SIDE * SIDE)));
  return 0;
}

/* Frame by frame from a file that is open. */
static int copy(void* user, int32_t frame, float* values, size_t count) {
  return volute_file_read((const volute_file*)user, frame, NULL, NULL, values, count) != VOLUTE_OK;
}

static int stop(void* user, int32_t frame, float* values, size_t count) {
  (void)user, (void)frame, (void)values, (void)count;
  return 1;
}

static void check(volute_status status) {
  if (status != VOLUTE_OK) {
    fprintf(stderr, "%s\n", volute_error());
    exit(1);
  }
}

static void expect(int holds, const char* what) {
  if (!holds) {
    fprintf(stderr, "this does not hold: %s\n", what);
    exit(1);
  }
}

int main(void) {
  const double times[3] = {0, 10, 20};
  const int32_t begin[3] = {12, 0, 0}, end[3] = {20, 4, 4};
  const double lines[12] = {-1, 1, 0.5, 5, 1, 0.5,   /* along x through the smoke, 4 m of it */
                            -1, 1, 1.5, 5, 1, 1.5};  /* and above it */
  volute_info info = {sizeof(volute_info), 3, SIDE, SIDE, SIDE, 1, 0, {0, 0, 0}, {4, 4, 2}, 0};
  volute_info found = {sizeof(volute_info), 0, 0, 0, 0, 0, 0, {0, 0, 0}, {0, 0, 0}, 0};
  volute_file* file;
  volute_scene* scene;
  volute_sight sights[2];
  float part[8 * 4 * 4];
  double stored[3];
  size_t i, time;
  FILE* text;

  printf("volute %s\n", volute_version());
  check(volute_compress("smoke.volute", &info, times, fill, NULL, VOLUTE_MAX_ERROR, 1e-3));
  expect(volute_compress("stopped.volute", &info, times, stop, NULL, VOLUTE_RMS, 1e-3) ==
             VOLUTE_CANCELLED, "the function can stop");

  check(volute_file_open("smoke.volute", &file));
  check(volute_file_info(file, &found));
  expect(found.frames == 3 && found.z == SIDE && found.bounds_max[2] == 2, "the file says what it is");
  check(volute_file_times(file, stored, 3));
  expect(stored[2] == 20, "the last frame is at 20 s");
  check(volute_file_read(file, 1, begin, end, part, sizeof part / sizeof *part));
  for (i = 0; i < sizeof part / sizeof *part; ++i)
    expect(fabs(part[i] - smoke(1, 12 + (int)(i / 16))) <= found.max_error, "values are within the error");
  expect(volute_file_read(file, 3, NULL, NULL, part, 1) == VOLUTE_INVALID_ARGUMENT, "there is no frame 3");
  printf("%s\n", volute_error());
  expect(volute_file_read(file, 0, begin, end, part, 5) == VOLUTE_INVALID_ARGUMENT, "5 values are too few");
  printf("%s\n", volute_error());
  check(volute_compress("copy.volute", &info, times, copy, file, VOLUTE_MAX_ERROR, 1e-3));
  expect(volute_compress("smoke.volute", &info, times, copy, file, VOLUTE_MAX_ERROR, 1e-3) ==
             VOLUTE_INVALID_ARGUMENT, "what is read is not replaced");
  printf("%s\n", volute_error());
  volute_file_close(file);
  expect(volute_file_open("nothing.volute", &file) == VOLUTE_NOT_FOUND && !file, "the file is not there");
  expect(volute_file_open(NULL, &file) == VOLUTE_INVALID_ARGUMENT, "a path is wanted");

  text = fopen("smoke.json", "w");
  expect(text != NULL, "smoke.json can be written");
  fputs("{\"format\": \"volute-scene-1\", \"camera\": {\"eye\": [-5, 2, 1], \"target\": [2, 2, 1], \"fov\": 40},\n"
        " \"media\": [{\"kind\": \"volume\", \"file\": \"smoke.volute\", \"extinction\": 1}]}\n", text);
  fclose(text);
  check(volute_scene_open("smoke.json", &scene));
  expect(volute_scene_time_count(scene) == 3, "three times are stored");
  for (time = 0; time < 3; ++time) {
    check(volute_scene_look(scene, time, lines, 2, sights));
    printf("%g s: optical depth %.2f in the smoke, %.2f above it\n", times[time], sights[0].depth, sights[1].depth);
    expect(fabs(sights[0].depth - 2.0 * (double)(time + 1)) < 0.01, "4 m of the smoke");
    expect(fabs(sights[1].depth) < 0.01, "clear air");
  }
  expect(volute_scene_look(scene, 0, lines, 2, sights) == VOLUTE_INVALID_ARGUMENT, "times only go on");
  volute_scene_close(scene);
  volute_scene_close(NULL);
  return 0;
}
