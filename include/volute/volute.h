/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The Volute authors
 *
 * Volute for C, and for languages that call C: files of volumes, pictures, and lines of sight
 * through scenes.
 *
 * Functions that can fail return a volute_status; volute_error() then returns a message. Handles
 * are created by functions that end in _open and released by functions that end in _close, which
 * accept NULL. Functions that take a const handle may be called from several threads at once. Paths
 * and texts are UTF-8. NULL where this header does not allow it is VOLUTE_INVALID_ARGUMENT. No
 * function ends the process or throws. A function of the caller's must not use the handle whose
 * call waits for it (VOLUTE_INVALID_ARGUMENT). A handle must not be used after its _close.
 *
 * From 0.3 on programs that were compiled against this header run with all later 0.x and 1.x
 * libraries (libvolute_c.so.0): functions, constants and the meaning of arguments stay; structures
 * grow at their ends alone, and are read by their `size`. */
#ifndef VOLUTE_VOLUTE_H
#define VOLUTE_VOLUTE_H

#include <stddef.h>
#include <stdint.h>

#include "volute/medium.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef int volute_status;
#define VOLUTE_OK 0
#define VOLUTE_INVALID_ARGUMENT 1 /* an argument is invalid */
#define VOLUTE_NOT_FOUND 2        /* a file or a name does not exist */
#define VOLUTE_INVALID_DATA 3     /* a file is inconsistent or fails its checksum */
#define VOLUTE_TRUNCATED 4        /* a file ends before its data do */
#define VOLUTE_UNSUPPORTED 5      /* valid, but unknown to this build */
#define VOLUTE_TOO_LARGE 6        /* does not fit in memory */
#define VOLUTE_IO 7               /* the system refused to read or write */
#define VOLUTE_CANCELLED 8        /* a callback asked to stop */
#define VOLUTE_INTERNAL 9         /* a bug in Volute */

/* "0.2.0" */
const char* volute_version(void);

/* Message of the last failed call in this thread; "" if none. Valid until the next failure. */
const char* volute_error(void);

/* Limits the threads of all calls from now on; 0: as many as the machine has. Returns how many
 * there were; -1 where `count` is below 0, which changes nothing. */
int32_t volute_set_threads(int32_t count);

/* ---- files ---- */

/* Properties of a sequence of volumes, without its values. */
typedef struct volute_info {
  size_t size; /* set it to sizeof(volute_info): later versions may add members */
  int32_t frames;
  int32_t z, y, x;   /* voxels; 0 of a file in which no grid has values */
  int32_t channels;  /* 1, or 3 for linear RGB */
  int32_t trilinear; /* 0: values are constant in voxels; 1: interpolated between voxel centres; 2:
                        coefficients of cubic B-splines there, which do not run through them (the
                        member "basis": "cubic" of a scene's entry interpolates values instead) */
  double bounds_min[3],
      bounds_max[3]; /* x y z of the outer voxel faces [m]; of a file whose voxels
                        do not lie along the axes a box around them in all frames */
  double max_error;  /* bound of the absolute error to the original */
} volute_info;

/* A .volute file that is open for reading. */
typedef struct volute_file volute_file;

volute_status volute_file_open(const char* path, volute_file** file);
void volute_file_close(volute_file* file);

/* The same for one of several grids ("velocity"); "" opens "density", else the first non-empty
 * grid, as volute_file_open does. */
volute_status volute_file_open_grid(const char* path, const char* grid, volute_file** file);

/* Number of grids in the file, including empty ones; 0 for NULL. */
size_t volute_file_grids(const volute_file* file);

/* Name of grid number `grid`, from 0; valid as long as `file`. NULL if there is none. */
const char* volute_file_grid_name(const volute_file* file, size_t grid);

/* 1: the grid has no values in any frame, and cannot be opened. */
int32_t volute_file_grid_is_empty(const volute_file* file, size_t grid);

volute_status volute_file_info(const volute_file* file, volute_info* info);

/* Where voxels lie in a frame: three rows of four numbers, from (x, y, z), counted in voxels, to
 * the centre of a voxel [m]. `along_axes`, unless NULL, is 0 where voxels are turned, sheared or
 * mirrored, or move by parts of a voxel: volute_info has no more than a box around them then. */
volute_status volute_file_matrix(const volute_file* file, int32_t frame, double matrix[12],
                                 int32_t* along_axes);

/* Name of the values ("density") and their unit ("1/m"; "" if unknown); valid as long as `file`.
 * "" for NULL. */
const char* volute_file_name(const volute_file* file);
const char* volute_file_unit(const volute_file* file);

/* Fills times[0 .. frames - 1] [s]. */
volute_status volute_file_times(const volute_file* file, double* times, size_t frames);

/* Fills `values` with voxels [begin, end) of a frame, counted from 0, in the order z, y, x with x
 * varying fastest and interleaved channels. `count` must be the product of the region's sides and
 * the channels. Only blocks that intersect the region are decoded. `begin` and `end` may both be
 * NULL for the whole frame. */
volute_status volute_file_read(const volute_file* file, int32_t frame, const int32_t begin[3],
                               const int32_t end[3], float* values, size_t count);

/* The same as doubles: values far from zero are as exact as the file has them, where a float is
 * not. */
volute_status volute_file_read_double(const volute_file* file, int32_t frame,
                                      const int32_t begin[3], const int32_t end[3], double* values,
                                      size_t count);

/* Fills `values` with frame `frame`, ordered as by volute_file_read(). Returns 0, or else to stop.
 * Called from one thread at a time, more than once per frame, and in any order. */
typedef int (*volute_frame_function)(void* user, int32_t frame, float* values, size_t count);

#define VOLUTE_RMS 0          /* RMS error of voxels that are not 0, of their range, at most this */
#define VOLUTE_PSNR 1         /* [dB] over all voxels, at least this */
#define VOLUTE_RATIO 2        /* raw float32 bytes / file bytes, at least this */
#define VOLUTE_SIZE 3         /* [bytes], at most this */
#define VOLUTE_MAX_ERROR 4    /* absolute error of every value, at most this */
#define VOLUTE_RMS_OVER_ALL 5 /* RMS error of all voxels, of (max - min), at most this */

/* Writes a .volute file, which appears only when complete. `info` describes the data (max_error is
 * ignored; if all bounds are 0, voxels are cubic, with 1 m for the longest side). `times` [s],
 * ascending, or NULL for 25 frames per second. VOLUTE_CANCELLED if `fill` stopped. A file that `fill`
 * reads by volute_file_read() is not replaced: VOLUTE_INVALID_ARGUMENT. */
volute_status volute_compress(const char* path, const volute_info* info, const double* times,
                              volute_frame_function fill, void* user, int target, double value);

/* Numbers in memory, of axes t, z, y, x, c in any order. */
typedef struct volute_array {
  size_t size;        /* set it to sizeof(volute_array) */
  const void* data;   /* the number (0, 0, 0, 0, 0) */
  const char* type;   /* as NumPy has it: "<f4", "<f8", ">i2", "|u1", "|b1", ..; NULL: float */
  int64_t strides[5]; /* from one to the next along t, z, y, x, c [bytes]; all 0: in this order,
                         dense, with c the fastest */
} volute_array;

/* As volute_compress(), from an array. Values become float, those far from zero differences from a
 * number in their middle: the rounding of doubles and of large integers counts in max_error, and a
 * target that it alone misses is VOLUTE_UNSUPPORTED. */
volute_status volute_compress_array(const char* path, const volute_info* info, const double* times,
                                    const volute_array* array, int target, double value);

/* Called now and then, from one thread at a time. Returns 0, or else to stop. */
typedef int (*volute_progress_function)(void* user, const char* stage, double done, double total);

/* The voxels that a volume is written on. Zeros stand for its own. */
typedef struct volute_resampling {
  size_t size;                         /* set it to sizeof(volute_resampling) */
  double voxel_size[3];                /* along x y z [m] */
  double bounds_min[3], bounds_max[3]; /* x y z of the outer voxel faces [m] */
  const char* like;                    /* a volume whose first frame's voxels they are, or NULL */
  const char* grids;                   /* of a file with several: "density,flame"; NULL: all */
  double rms;                          /* relative, of a .volute; 0: 0.001 */
  volute_progress_function progress;   /* or NULL */
  void* user;                          /* for it */
} volute_resampling;

/* Writes a volume on other voxels, as `volute resample`: those that are turned, sheared, moving or
 * in a frustum come to lie along the axes. `target`: .volute, .npy, or a pattern %04d.vdb or
 * %04d.vti. VOLUTE_CANCELLED if `progress` stopped. */
volute_status volute_resample(const char* path, const char* target, const volute_resampling* how);

/* ---- pictures ---- */

/* A scene that is drawn: from a scene file, from any other file that Volute shows, or from an
 * array, as `volute render` shows it. Calls with one drawing wait for each other. */
typedef struct volute_drawing volute_drawing;

/* `members`: those of a scene's entry for a file alone, as a JSON object ("{\"emission\": 2}"), or
 * NULL. Of an array and a function they also are the "name" and the "unit" of the values; the
 * "transform" of a scene's entry turns and moves them. */
volute_status volute_drawing_open(const char* path, const char* members, volute_drawing** drawing);

/* The array is not copied: it must stay as it is until the drawing is closed. */
volute_status volute_drawing_open_array(const volute_info* info, const double* times,
                                        const volute_array* array, const char* members,
                                        volute_drawing** drawing);

/* Values at points (x[i], y[i], z[i]) [m] and a time [s]: fills values[0 .. count * channels - 1],
 * those of each point's channels together, with finite numbers. Returns 0, or else to stop. May be
 * asked for the same points again, from one thread at a time. */
typedef int (*volute_value_function)(void* user, double time, const double* x, const double* y,
                                     const double* z, size_t count, float* values);

/* A function, by its values at the centres of info's voxels at `times`. It is called while the
 * drawing is open. */
volute_status volute_drawing_open_function(const volute_info* info, const double* times,
                                           volute_value_function value, void* user,
                                           const char* members, volute_drawing** drawing);

/* A mesh in memory: `points` x y z [m] after each other; `cells` the numbers of each cell's points,
 * all of one kind, in VTK's order: tetrahedra of 4, pyramids of 5, wedges of 6, hexahedra of 8;
 * `values` one for each point, or for each cell, at each time. Copied. */
typedef struct volute_mesh {
  size_t size; /* set it to sizeof(volute_mesh) */
  const double* points;
  size_t point_count;
  const int64_t* cells;
  size_t cell_count;
  int32_t cell_points; /* 4, 5, 6 or 8 */
  int32_t of_cells;    /* 1: values of cells; 0: of points */
  const char* field;   /* what the values are called; NULL: "density" */
  const float* values; /* those of the first time, then of the next */
  const double* times; /* [s], ascending; NULL: one, 0 */
  size_t time_count;   /* 0: 1 */
} volute_mesh;

/* `members`: those of smoke in a scene, of which "quantity" has to be there, which says what the
 * values are: "{\"quantity\": \"extinction\"}" [1/m], "soot-density" [kg/m3], .. */
volute_status volute_drawing_open_mesh(const volute_mesh* mesh, const char* members,
                                       volute_drawing** drawing);
void volute_drawing_close(volute_drawing* drawing);

/* Number of stored times, and times[0 .. count - 1] [s]. */
size_t volute_drawing_time_count(const volute_drawing* drawing);
volute_status volute_drawing_times(const volute_drawing* drawing, double* times, size_t count);

enum {
  VOLUTE_TONE_AUTO = 0,
  VOLUTE_TONE_NONE = 1,
  VOLUTE_TONE_FILMIC = 2,
  VOLUTE_TONE_AGX = 3,
  VOLUTE_TONE_SHOULDER = 4
};

/* What a picture shows, and how. Zeros stand for what `volute render` does without its options. */
typedef struct volute_view {
  size_t size;        /* set it to sizeof(volute_view): later versions may add members */
  const double* time; /* [s]; NULL: one that has something to see */
  const char* camera; /* as a scene's, a JSON object: "{\"eye\": [0, -4, 1], \"target\": [0, 0, 1],
                         \"fov\": 40}"; NULL: the scene's, else one that frames it */
  int32_t width, height;             /* pixels; 0: as the camera says, else 800 x 600 */
  double exposure;                   /* a factor of light; 0: brightest parts near white */
  int32_t tone;                      /* VOLUTE_TONE_AUTO .. */
  int32_t samples;                   /* rays per pixel at edges; 0: 8 */
  volute_progress_function progress; /* or NULL */
  void* user;                        /* for it */
  double shutter;       /* averages light over this share of the time to the next frame: 0.5 is 180
                           degrees. Volumes move then where members have "interpolate": "auto" */
  const char* renderer; /* "cpu", or "gl": OpenGL 4.5; NULL: cpu */
  const char* display;  /* instead of a tone: "aces", or "ocio", "ocio:VIEW" and "ocio:DISPLAY/VIEW"
                           of the configuration that the environment's OCIO names; NULL: none */
} volute_view;

/* Draws a picture for a display, the pixels of the .png of `volute render`: sRGB, row 0 at the top,
 * 3 bytes a pixel. `bytes` must be 3 width height. VOLUTE_CANCELLED if `progress` stopped. */
volute_status volute_drawing_draw(volute_drawing* drawing, const volute_view* view,
                                  unsigned char* rgb, size_t bytes);

/* The same before exposure and tone, those of the .exr: linear light. `count` must be 3 width
 * height. */
volute_status volute_drawing_light(volute_drawing* drawing, const volute_view* view, float* rgb,
                                   size_t count);

/* Which pictures a film has. Zeros stand for all frames, at their own pace, from where one looks.
 */
typedef struct volute_film {
  size_t size;        /* set it to sizeof(volute_film) */
  int32_t first, end; /* numbers of frames, first <= frame < end; both 0: all */
  double speed;       /* seconds of the scene in a second of film; 0: 1 */
  double orbit;       /* turns the camera around its target over the film [degrees] */
} volute_film;

/* Writes a film (.mp4, .webm) or numbered pictures ("fire_%04d.png") as `volute render` does, with
 * one exposure for all. `view` as above, whose time must be NULL; `film` may be NULL. A film that
 * is stopped leaves no file, numbered pictures leave those that were whole. */
volute_status volute_drawing_film(volute_drawing* drawing, const volute_view* view,
                                  const volute_film* film, const char* path);

/* ---- kinds of media ---- */

/* Adds a kind of medium to those that scenes can have, before scenes with it are opened. It and all
 * that it points to must stay until the program ends. One of the same name that was added so is
 * replaced for scenes that are opened from then on. */
volute_status volute_medium_register(const volute_medium_kind* kind);

/* ---- lines of sight ---- */

/* The result for a straight line from an eye to a target. */
typedef struct volute_sight {
  double depth;     /* integral of the extinction, natural logarithm; NaN if not covered */
  double low, high; /* bounds of it, given the rounding of the data; if not covered that of the
                       known part, and infinity */
  int32_t covered;  /* 1: the medium is known along the whole line */
  int32_t blocked;  /* 1: an obstruction is in the way */
} volute_sight;

/* A scene, or any file that Volute shows: an FDS case, a mesh, a volume. */
typedef struct volute_scene volute_scene;

volute_status volute_scene_open(const char* path, volute_scene** scene);

/* The same of a file or of values in memory, with members of its entry, as volute_drawing_open()
 * and those that follow it take them. What has no unit of an extinction needs one:
 * "{\"extinction\": 1}" [1/m] of a unit of the values. */
volute_status volute_scene_open_file(const char* path, const char* members, volute_scene** scene);
volute_status volute_scene_open_array(const volute_info* info, const double* times,
                                      const volute_array* array, const char* members,
                                      volute_scene** scene);
volute_status volute_scene_open_function(const volute_info* info, const double* times,
                                         volute_value_function value, void* user,
                                         const char* members, volute_scene** scene);
volute_status volute_scene_open_mesh(const volute_mesh* mesh, const char* members,
                                     volute_scene** scene);
void volute_scene_close(volute_scene* scene);

/* Number of stored times, and times[0 .. count - 1] [s]. */
size_t volute_scene_time_count(const volute_scene* scene);
volute_status volute_scene_times(const volute_scene* scene, double* times, size_t count);

/* Looks along lines at a stored time, in parallel. `lines`: eye x y z, target x y z of each [m].
 * Times must be requested in ascending order: an earlier one than the last is
 * VOLUTE_INVALID_ARGUMENT; open the scene again to go back. */
volute_status volute_scene_look(volute_scene* scene, size_t time, const double* lines, size_t count,
                                volute_sight* sights);

/* Optical depths that were measured along straight lines at one time. */
typedef struct volute_lines {
  size_t size;          /* set it to sizeof(volute_lines) */
  size_t count;         /* of lines */
  const double* ends;   /* x y z of one end and of the other of each [m] */
  const double* depths; /* natural logarithm */
  const double* sigmas; /* standard deviations of the depths; NULL: all lines weigh alike */
  volute_progress_function progress; /* or NULL */
  void* user;                        /* for it */
} volute_lines;

/* Fills `values` with the extinction [1/m] that explains lines best, in order z, y, x: in the
 * voxels of `info`, which has bounds, one frame and one channel. It is not below 0; what no line
 * meets follows from its neighbours. VOLUTE_CANCELLED if `progress` stopped. */
volute_status volute_lines_solve(const volute_lines* lines, const volute_info* info, float* values,
                                 size_t count);

/* ---- visibility of signs, and doses ---- */

/* A case and its signs, for evacuation programs, which query it as time proceeds. Call the
 * functions of an engine from one thread at a time; they use all threads. */
typedef struct volute_engine volute_engine;

/* `signs` is a file of signs as for `volute visibility --signs`. The criteria of tenability are the
 * default ones for which the case has data. `path` is an FDS case or a scene; smoke on a mesh needs a
 * scene, which says what the values are. */
volute_status volute_engine_open(const char* path, const char* signs, volute_engine** engine);
void volute_engine_close(volute_engine* engine);

/* Names are valid as long as the engine; NULL beyond the last. */
size_t volute_engine_sign_count(const volute_engine* engine);
const char* volute_engine_sign_name(const volute_engine* engine, size_t sign);
size_t volute_engine_criterion_count(const volute_engine* engine);
const char* volute_engine_criterion_name(const volute_engine* engine, size_t criterion);
double volute_engine_criterion_limit(const volute_engine* engine, size_t criterion);

enum { VOLUTE_NOT_SEEN = 0, VOLUTE_SEEN = 1, VOLUTE_CANNOT_TELL = 2 };

/* At a time [s], from eyes x y z of each agent [m]: seen[sign * agents + agent]. */
volute_status volute_engine_sees(volute_engine* engine, double time, const double* eyes,
                                 size_t agents, unsigned char* seen);

/* Doses of agents until `time`, accumulated over the previous calls with their ids, or levels:
 * values[criterion * agents + agent]; NaN without data. Steps of a second or less are small enough
 * for walking people. */
volute_status volute_engine_dose(volute_engine* engine, double time, const int64_t* ids,
                                 const double* eyes, size_t agents, double* values);

/* The same, and by the worst that rounding, caps and means at nodes of the files allow, which a
 * verdict goes by: `worst` is as `values`. */
volute_status volute_engine_dose_at_worst(volute_engine* engine, double time, const int64_t* ids,
                                          const double* eyes, size_t agents, double* values,
                                          double* worst);

#ifdef __cplusplus
}
#endif

#endif
