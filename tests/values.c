/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The Volute authors
 *
 * Values of a C program in lines of sight, and volumes from lines; tests/install_test.py builds and runs it. */
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <volute/volute.h>

#define CHECK(truth) \
  if (!(truth)) {    \
    fprintf(stderr, "%d: not %s; %s\n", __LINE__, #truth, volute_error()); \
    return 1;        \
  }

enum { kSide = 8, kLines = 3 * kSide * kSide };

static volute_drawing* drawing;
static int asks;
static volute_status inner = VOLUTE_OK;

/* 1 everywhere; draws what waits for it. */
static int value(void* user, double time, const double* x, const double* y, const double* z, size_t count, float* values) {
  (void)user, (void)time, (void)x, (void)y, (void)z;
  for (size_t i = 0; i < count; ++i) values[i] = 1;
  if (drawing && asks++ == 0) {
    unsigned char pixels[12];
    volute_view view = {.size = sizeof view, .width = 2, .height = 2};
    inner = volute_drawing_draw(drawing, &view, pixels, sizeof pixels);
  }
  return 0;
}

static int stop(void* user, const char* stage, double done, double total) {
  (void)user, (void)stage, (void)done, (void)total;
  return 1;
}

static int exists(const char* path) {
  FILE* file = fopen(path, "rb");
  return file ? fclose(file) == 0 : 0;
}

/* Of one line through the middle. */
static double depth(volute_scene* scene, double y) {
  const double line[6] = {-1, y, 0.5, 2, y, 0.5};
  volute_sight sight;
  const volute_status status = volute_scene_look(scene, 0, line, 1, &sight);
  volute_scene_close(scene);
  if (status == VOLUTE_OK && !sight.covered && !(isnan(sight.depth) && isinf(sight.high))) return -99;
  return status != VOLUTE_OK ? -status : sight.covered ? sight.depth : sight.low; /* of a mesh, its part of the line */
}

int main(int argc, char** argv) {
  float values[kSide * kSide * kSide];
  for (size_t i = 0; i < sizeof values / sizeof *values; ++i) values[i] = 1;
  const volute_info info = {.size = sizeof info, .frames = 1, .z = kSide, .y = kSide, .x = kSide, .channels = 1, .bounds_max = {1, 1, 1}};
  const volute_array array = {.size = sizeof array, .data = values};
  volute_scene* scene = NULL;

  CHECK(volute_scene_open_array(&info, NULL, &array, NULL, &scene) == VOLUTE_INVALID_ARGUMENT);
  CHECK(!scene && strstr(volute_error(), "would hide nothing"));
  CHECK(volute_scene_open_array(&info, NULL, &array, "{\"unit\": \"1/m\"}", &scene) == VOLUTE_OK);
  CHECK(depth(scene, 0.5) == 1);
  CHECK(volute_scene_open_array(&info, NULL, &array, "{\"extinction\": 3, \"name\": \"soot\"}", &scene) == VOLUTE_OK);
  CHECK(depth(scene, 0.5) == 3);
  const char* moved = "{\"extinction\": 3, \"transform\": [1,0,0,0, 0,1,0,10, 0,0,1,0, 0,0,0,1]}";
  CHECK(volute_scene_open_array(&info, NULL, &array, moved, &scene) == VOLUTE_OK);
  CHECK(depth(scene, 10.5) == 3);
  CHECK(volute_scene_open_function(&info, NULL, value, NULL, "{\"extinction\": 2}", &scene) == VOLUTE_OK);
  CHECK(depth(scene, 0.5) == 2);

  /* A cube as one hexahedron, and as tetrahedra at two times. */
  const double points[24] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1};
  const int64_t hexahedron[8] = {0, 1, 2, 3, 4, 5, 6, 7};
  const int64_t tets[20] = {0, 1, 3, 4, 1, 2, 3, 6, 1, 4, 5, 6, 3, 4, 6, 7, 1, 3, 4, 6};
  const float thick[16] = {3, 3, 3, 3, 3, 3, 3, 3, 6, 6, 6, 6, 6, 6, 6, 6};
  const double times[2] = {0, 5};
  volute_mesh mesh = {.size = sizeof mesh, .points = points, .point_count = 8, .cells = hexahedron, .cell_count = 1, .cell_points = 8,
                      .of_cells = 1, .field = "soot", .values = thick};
  CHECK(volute_scene_open_mesh(&mesh, "{\"quantity\": \"extinction\"}", &scene) == VOLUTE_OK);
  CHECK(fabs(depth(scene, 0.5) - 3) < 1e-6);
  mesh.cells = tets, mesh.cell_count = 5, mesh.cell_points = 4, mesh.of_cells = 0, mesh.times = times, mesh.time_count = 2;
  CHECK(volute_scene_open_mesh(&mesh, "{\"quantity\": \"extinction\"}", &scene) == VOLUTE_OK);
  CHECK(volute_scene_time_count(scene) == 2 && fabs(depth(scene, 0.4) - 3) < 1e-6);
  CHECK(volute_drawing_open_mesh(&mesh, "{\"quantity\": \"extinction\"}", &drawing) == VOLUTE_OK);
  unsigned char cube[3 * 16 * 12];
  const volute_view last = {.size = sizeof last, .width = 16, .height = 12, .time = times + 1};
  CHECK(volute_drawing_draw(drawing, &last, cube, sizeof cube) == VOLUTE_OK);
  CHECK(memcmp(cube, cube + 3 * (6 * 16 + 8), 3) != 0);
  const volute_film both = {.size = sizeof both, .end = 2}, none = {.size = sizeof none, .first = 5, .end = 9};
  volute_view small = {.size = sizeof small, .width = 16, .height = 12, .tone = VOLUTE_TONE_SHOULDER, .progress = stop};
  CHECK(volute_drawing_film(drawing, &last, &both, "cube_%02d.png") == VOLUTE_INVALID_ARGUMENT && strstr(volute_error(), "leave `time` out"));
  CHECK(volute_drawing_film(drawing, &small, &both, "cube_%02d.png") == VOLUTE_CANCELLED && !exists("cube_00.png"));
  small.progress = NULL;
  CHECK(volute_drawing_film(drawing, &small, &none, "cube_%02d.png") == VOLUTE_INVALID_ARGUMENT && strstr(volute_error(), "frames"));
  CHECK(volute_drawing_film(drawing, &small, &both, "cube.png") == VOLUTE_INVALID_ARGUMENT);
  CHECK(volute_drawing_film(drawing, &small, &both, "cube_%02d.png") == VOLUTE_OK);
  CHECK(exists("cube_00.png") && exists("cube_01.png") && !exists("cube_02.png"));
  CHECK(volute_drawing_film(drawing, &small, NULL, "all_%02d.png") == VOLUTE_OK && exists("all_01.png") && !exists("all_02.png"));
  volute_drawing_close(drawing), drawing = NULL;
  mesh.cell_points = 7;
  CHECK(volute_scene_open_mesh(&mesh, NULL, &scene) == VOLUTE_INVALID_ARGUMENT && strstr(volute_error(), "4, 5, 6 or 8"));
  mesh.cell_points = 4, mesh.point_count = 6;
  CHECK(volute_scene_open_mesh(&mesh, "{\"quantity\": \"extinction\"}", &scene) != VOLUTE_OK && strstr(volute_error(), "has vertex 6"));

  /* Doubles far from 0 keep their error; places of voxels. */
  double far[kSide * kSide * kSide], back[kSide * kSide * kSide], matrix[12];
  for (size_t i = 0; i < sizeof far / sizeof *far; ++i) far[i] = 2e6 + 0.01 * (double)i;
  const volute_array doubles = {.size = sizeof doubles, .data = far, .type = "<f8"};
  CHECK(volute_compress_array("far.volute", &info, NULL, &doubles, VOLUTE_MAX_ERROR, 1e-3) == VOLUTE_OK);
  volute_file* file = NULL;
  CHECK(volute_file_open_grid("far.volute", "", &file) == VOLUTE_OK);
  CHECK(volute_file_read_double(file, 0, NULL, NULL, back, sizeof back / sizeof *back) == VOLUTE_OK);
  for (size_t i = 0; i < sizeof far / sizeof *far; ++i) CHECK(fabs(back[i] - far[i]) <= 1e-3);
  int32_t along_axes = 0;
  CHECK(volute_file_matrix(file, 0, matrix, &along_axes) == VOLUTE_OK && along_axes == 1);
  CHECK(fabs(matrix[0] - 1.0 / kSide) < 1e-12 && fabs(matrix[3] - 0.5 / kSide) < 1e-12 && matrix[1] == 0);
  CHECK(volute_file_matrix(file, 1, matrix, NULL) == VOLUTE_INVALID_ARGUMENT && strstr(volute_error(), "no frame 1"));
  volute_file_close(file);

  /* What is no array, and no place. */
  const double beyond[6] = {-1e300, 0.5, 0.5, 1e300, 0.5, 0.5};
  volute_sight sight;
  CHECK(volute_scene_open_array(&info, NULL, &array, "{\"extinction\": 2}", &scene) == VOLUTE_OK);
  CHECK(volute_scene_look(scene, 0, beyond, SIZE_MAX / 3, &sight) == VOLUTE_INVALID_ARGUMENT && strstr(volute_error(), "a count of"));
  CHECK(volute_scene_look(scene, 0, beyond, 1, &sight) == VOLUTE_INVALID_ARGUMENT && strstr(volute_error(), "beyond 1e12 m"));
  volute_scene_close(scene);

  CHECK(volute_compress_array("ones.volute", &info, NULL, &array, VOLUTE_MAX_ERROR, 1e-6) == VOLUTE_OK);
  CHECK(volute_scene_open("ones.volute", &scene) == VOLUTE_INVALID_ARGUMENT);
  CHECK(volute_scene_open_file("ones.volute", "{\"extinction\": 2}", &scene) == VOLUTE_OK);
  CHECK(fabs(depth(scene, 0.5) - 2) < 1e-5);
  CHECK(volute_scene_open_array(&info, NULL, &array, "{\"name\": 3}", &scene) == VOLUTE_INVALID_ARGUMENT);
  for (size_t i = 0; i < sizeof values / sizeof *values; ++i) values[i] = -1;
  CHECK(volute_scene_open_array(&info, NULL, &array, "{\"unit\": \"1/m\"}", &scene) == VOLUTE_OK);
  CHECK(depth(scene, 0.5) == -VOLUTE_INVALID_DATA);

  CHECK(volute_drawing_open_function(&info, NULL, value, NULL, NULL, &drawing) == VOLUTE_OK);
  unsigned char pixels[3 * 16 * 12];
  const volute_view view = {.size = sizeof view, .width = 16, .height = 12};
  CHECK(volute_drawing_draw(drawing, &view, pixels, sizeof pixels) == VOLUTE_OK);
  CHECK(asks > 0 && inner == VOLUTE_INVALID_ARGUMENT);
  /* By OpenGL, and as a display of ACES, where this machine has them. */
  unsigned char other[sizeof pixels];
  volute_view how = view;
  how.renderer = "gl";
  const volute_status by_gl = volute_drawing_draw(drawing, &how, other, sizeof other);
  CHECK(by_gl == VOLUTE_OK || by_gl == VOLUTE_UNSUPPORTED);
  for (size_t i = 0; by_gl == VOLUTE_OK && i < sizeof pixels; ++i) CHECK(abs(pixels[i] - other[i]) <= 3);
  how.size = offsetof(volute_view, renderer), how.renderer = "of a program that had none";
  CHECK(volute_drawing_draw(drawing, &how, other, sizeof other) == VOLUTE_OK);
  how.size = sizeof how, how.renderer = "rays";
  CHECK(volute_drawing_draw(drawing, &how, other, sizeof other) == VOLUTE_INVALID_ARGUMENT && strstr(volute_error(), "expected cpu or gl"));
  how.renderer = "cpu", how.display = "aces";
  const volute_status aces = volute_drawing_draw(drawing, &how, other, sizeof other);
  CHECK(aces == VOLUTE_UNSUPPORTED || (aces == VOLUTE_OK && memcmp(pixels, other, sizeof pixels) != 0));
  how.display = "acid";
  CHECK(volute_drawing_draw(drawing, &how, other, sizeof other) == VOLUTE_INVALID_ARGUMENT);
  volute_drawing_close(drawing);

  /* A cube of 2 1/m in the middle, by a line through the centres of each row of voxels. */
  double ends[6 * kLines] = {0}, depths[kLines];
  for (int axis = 0, k = 0; axis < 3; ++axis)
    for (int i = 0; i < kSide; ++i)
      for (int j = 0; j < kSide; ++j, ++k) {
        double* begin = ends + 6 * k;
        begin[axis] = -1, begin[3 + axis] = 2;
        begin[(axis + 1) % 3] = begin[3 + (axis + 1) % 3] = (i + 0.5) / kSide;
        begin[(axis + 2) % 3] = begin[3 + (axis + 2) % 3] = (j + 0.5) / kSide;
        depths[k] = i >= 2 && i < 6 && j >= 2 && j < 6 ? 1 : 0;
      }
  volute_lines lines = {.size = sizeof lines, .count = kLines, .ends = ends, .depths = depths};
  CHECK(volute_lines_solve(&lines, &info, values, kSide * kSide * kSide) == VOLUTE_OK);
  CHECK(fabs(values[(4 * kSide + 4) * kSide + 4] - 2) < 0.05 && values[0] < 0.05);
  CHECK(volute_lines_solve(&lines, &info, values, 3) == VOLUTE_INVALID_ARGUMENT);
  lines.progress = stop;
  CHECK(volute_lines_solve(&lines, &info, values, kSide * kSide * kSide) == VOLUTE_CANCELLED);
  depths[3] = NAN;
  CHECK(volute_lines_solve(&lines, &info, values, kSide * kSide * kSide) == VOLUTE_INVALID_ARGUMENT);

  /* Advice has the words of C. */
  const volute_resampling resampling = {.size = sizeof resampling, .voxel_size = {0.5, 0.5, 0.5}};
  CHECK(argc == 2 && volute_resample(argv[1], "grids.npy", &resampling) == VOLUTE_INVALID_ARGUMENT);
  CHECK(strstr(volute_error(), "choose one with grids") && !exists("grids.npy"));
  CHECK(volute_resample(argv[1], "grids.xyz", &resampling) == VOLUTE_INVALID_ARGUMENT);
  CHECK(strstr(volute_error(), "unknown format"));

  /* What is read is not replaced; what is wrong is an argument, and no file. */
  const volute_resampling coarse = {.size = sizeof coarse, .voxel_size = {0.5, 0.5, 0.5}};
  CHECK(volute_resample("ones.volute", "ones.volute", &coarse) == VOLUTE_INVALID_ARGUMENT && strstr(volute_error(), "would be replaced"));
  CHECK(volute_resample("ones.volute", "coarse.volute", &coarse) == VOLUTE_OK);
  CHECK(volute_compress_array("b.vdb", &info, NULL, &array, VOLUTE_RMS, 1e-3) == VOLUTE_INVALID_ARGUMENT && !exists("b.vdb"));
  volute_info wrong = info;
  wrong.channels = 2;
  CHECK(volute_compress_array("b.volute", &wrong, NULL, &array, VOLUTE_RMS, 1e-3) == VOLUTE_INVALID_ARGUMENT);
  wrong = info, wrong.bounds_max[0] = -1;
  CHECK(volute_compress_array("b.volute", &wrong, NULL, &array, VOLUTE_RMS, 1e-3) == VOLUTE_INVALID_ARGUMENT);
  const double descending[2] = {1, 0};
  wrong = info, wrong.frames = 2;
  CHECK(volute_scene_open_array(&wrong, descending, &array, NULL, &scene) == VOLUTE_INVALID_ARGUMENT && strstr(volute_error(), "ascend"));
  CHECK(volute_scene_open_array(&info, NULL, &array, "{\"file\": \"x.npy\"}", &scene) == VOLUTE_INVALID_ARGUMENT &&
        strstr(volute_error(), "\"file\" is what is opened"));
  const int32_t threads = volute_set_threads(1);
  CHECK(volute_set_threads(-5) == -1 && strstr(volute_error(), "0 or more") && volute_set_threads(threads) == 1);
  puts("values are seen through");
  return 0;
}
