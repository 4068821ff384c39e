/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The Volute authors
 *
 * Four threads read one handle of a file at once, and ask for frames that are not there: everyone
 * gets what one thread alone gets, and its own errors. threads FILE */
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volute/volute.h>

enum { kThreads = 4, kRounds = 10 };

static const volute_file* file;
static volute_info info;
static size_t count;
static float* expected; /* all frames, read by one thread */

static void* work(void* number) {
  const int32_t self = (int32_t)(size_t)number;
  float* values = malloc(count * sizeof(float));
  const char* fault = NULL;
  for (int32_t i = 0; i < kRounds && !fault; ++i) {
    const int32_t frame = (self + i) % info.frames;
    char sentence[64];
    if (volute_file_read(file, frame, NULL, NULL, values, count) != VOLUTE_OK)
      fault = "cannot read";
    else if (memcmp(values, expected + (size_t)frame * count, count * sizeof(float)) != 0)
      fault = "other values";
    if (volute_file_read(file, 1000 + self, NULL, NULL, values, count) != VOLUTE_INVALID_ARGUMENT)
      fault = "no error";
    snprintf(sentence, sizeof sentence, "there is no frame %d;", 1000 + (int)self);
    if (!strstr(volute_error(), sentence))
      fault = "another thread's error";
  }
  free(values);
  return (void*)fault;
}

int main(int argc, char** argv) {
  pthread_t threads[kThreads];
  volute_file* opened = NULL;
  int faults = 0;
  if (argc != 2 || volute_file_open(argv[1], &opened) != VOLUTE_OK) {
    fprintf(stderr, "%s\n", volute_error());
    return 1;
  }
  file = opened;
  /* A file of one grid names it, and opens by its name alone. */
  volute_file* again = NULL;
  if (volute_file_grids(file) != 1 || strcmp(volute_file_grid_name(file, 0), volute_file_name(file)) != 0 ||
      volute_file_grid_name(file, 1) || volute_file_grid_is_empty(file, 0) ||
      volute_file_open_grid(argv[1], volute_file_name(file), &again) != VOLUTE_OK)
    return 1;
  volute_file_close(again);
  if (volute_file_open_grid(argv[1], "no such grid", &again) != VOLUTE_NOT_FOUND || again)
    return 1;
  info.size = sizeof info;
  if (volute_file_info(file, &info) != VOLUTE_OK)
    return 1;
  count = (size_t)info.z * (size_t)info.y * (size_t)info.x * (size_t)info.channels;
  expected = malloc((size_t)info.frames * count * sizeof(float));
  for (int32_t frame = 0; frame < info.frames; ++frame)
    faults += volute_file_read(file, frame, NULL, NULL, expected + (size_t)frame * count, count) != VOLUTE_OK;
  for (size_t i = 0; i < kThreads; ++i)
    faults += pthread_create(&threads[i], NULL, work, (void*)i) != 0;
  for (size_t i = 0; i < kThreads; ++i) {
    void* fault = NULL;
    pthread_join(threads[i], &fault);
    if (fault) {
      ++faults;
      fprintf(stderr, "thread %d: %s\n", (int)i, (const char*)fault);
    }
  }
  if (faults == 0)
    printf("%d threads read %d frames %d times\n", kThreads, (int)info.frames, kRounds);
  free(expected);
  volute_file_close(opened);
  return faults != 0;
}
