/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The Volute authors
 *
 * Volute for C, and for languages that call C: files of volumes, and lines of sight through scenes.
 *
 * Functions that can fail return a volute_status, and volute_error() says in a sentence what went
 * wrong. Handles are made by functions that end in _open and given back to those that end in
 * _close, which take NULL. Functions that take a const handle may be called from several threads
 * at once. Paths and texts are UTF-8. NULL where this page does not allow it is
 * VOLUTE_INVALID_ARGUMENT. Nothing here ends the process or throws. */
#ifndef VOLUTE_VOLUTE_H
#define VOLUTE_VOLUTE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef int volute_status;
#define VOLUTE_OK 0
#define VOLUTE_INVALID_ARGUMENT 1 /* a value that the caller gave makes no sense */
#define VOLUTE_NOT_FOUND 2        /* a file or a name is not there */
#define VOLUTE_INVALID_DATA 3     /* a file says something impossible or fails its checksum */
#define VOLUTE_TRUNCATED 4        /* a file ends before its data do */
#define VOLUTE_UNSUPPORTED 5      /* valid, but a part or version that this build does not know */
#define VOLUTE_TOO_LARGE 6        /* does not fit in memory */
#define VOLUTE_IO 7               /* the system refused to read or write */
#define VOLUTE_CANCELLED 8        /* a callback asked to stop */
#define VOLUTE_INTERNAL 9         /* a fault of Volute's */

/* "0.2.0" */
const char* volute_version(void);

/* About the last call in this thread that failed; "" when none did. Valid until the next one. */
const char* volute_error(void);

/* ---- files ---- */

/* What a sequence of volumes is, but for its values. */
typedef struct volute_info {
  size_t size;    /* the caller sets it to sizeof(volute_info): later versions have more members */
  int32_t frames;
  int32_t z, y, x;  /* voxels */
  int32_t channels; /* 1, or 3 for linear RGB */
  int32_t trilinear; /* 0: values are constant in voxels; 1: interpolated between voxel centres; 2: cubic B-splines there */
  double bounds_min[3], bounds_max[3]; /* x y z of the outer voxel faces [m] */
  double max_error; /* no value differs more from the original */
} volute_info;

/* A .volute file that is open for reading. */
typedef struct volute_file volute_file;

volute_status volute_file_open(const char* path, volute_file** file);
void volute_file_close(volute_file* file);

/* The same for one of several grids ("velocity"); "" opens "density", else the first that is not
 * empty, as volute_file_open does. */
volute_status volute_file_open_grid(const char* path, const char* grid, volute_file** file);

/* How many grids the file has, empty ones counted; 0 for NULL. */
size_t volute_file_grids(const volute_file* file);

/* The name of one of them, from 0; lives as long as `file`. NULL where there is none. */
const char* volute_file_grid_name(const volute_file* file, size_t grid);

/* 1: it has no values in any frame, and cannot be opened. */
int32_t volute_file_grid_is_empty(const volute_file* file, size_t grid);

volute_status volute_file_info(const volute_file* file, volute_info* info);

/* What the values are ("density") and their unit ("1/m"; "" when unknown); live as long as `file`.
 * "" for NULL. */
const char* volute_file_name(const volute_file* file);
const char* volute_file_unit(const volute_file* file);

/* Fills times[0 .. frames - 1] [s]. */
volute_status volute_file_times(const volute_file* file, double* times, size_t frames);

/* Fills `values` with voxels [begin, end) of a frame, counted from 0: on the axes z, y, x, in that
 * order; values of a voxel's channels are neighbours, then those of its neighbour on x. `count`
 * must be the product of the region's sides and the channels. Only blocks that the region touches
 * are decoded. `begin` and `end` may both be NULL: the whole frame. */
volute_status volute_file_read(const volute_file* file, int32_t frame, const int32_t begin[3],
                               const int32_t end[3], float* values, size_t count);

/* Fills `values` with frame `frame` as volute_file_read() gives it. Returns 0, or anything else to
 * stop. Called from one thread at a time, for a frame more than once, and not always in order. */
typedef int (*volute_frame_function)(void* user, int32_t frame, float* values, size_t count);

#define VOLUTE_RMS 0       /* relative RMS error, of (max - min), at most this */
#define VOLUTE_PSNR 1      /* [dB], at least this */
#define VOLUTE_RATIO 2     /* raw float32 bytes / file bytes, at least this */
#define VOLUTE_SIZE 3      /* [bytes], at most this */
#define VOLUTE_MAX_ERROR 4 /* absolute error of every value, at most this */

/* Writes a .volute file; the file appears when it is whole. `info` says what comes (max_error is
 * ignored; bounds that are all 0 become cubic voxels, the longest side 1 m). `times` [s], ascending,
 * or NULL: 25 frames a second. VOLUTE_CANCELLED when `fill` stopped. */
volute_status volute_compress(const char* path, const volute_info* info, const double* times,
                              volute_frame_function fill, void* user, int target, double value);

/* ---- lines of sight ---- */

/* What lies on a straight line from an eye to a target. */
typedef struct volute_sight {
  double depth;     /* integral of the extinction, natural logarithm */
  double low, high; /* what it is within, as far as the data are rounded */
  int32_t covered;  /* 1: the medium is known all along the line */
  int32_t blocked;  /* 1: something opaque stands between */
} volute_sight;

/* A scene, or any file that Volute shows: an FDS case, a mesh, a volume. */
typedef struct volute_scene volute_scene;

volute_status volute_scene_open(const char* path, volute_scene** scene);
void volute_scene_close(volute_scene* scene);

/* Stored times: how many there are, and times[0 .. count - 1] [s]. */
size_t volute_scene_time_count(const volute_scene* scene);
volute_status volute_scene_times(const volute_scene* scene, double* times, size_t count);

/* Looks along lines at a stored time, in parallel. `lines`: eye x y z, target x y z of each [m].
 * Times are read in ascending order: one before the last that was asked for is
 * VOLUTE_INVALID_ARGUMENT, and the scene is to be opened again. */
volute_status volute_scene_look(volute_scene* scene, size_t time, const double* lines, size_t count,
                                volute_sight* sights);

/* ---- who sees which sign, and what people take in ---- */

/* A case and its signs, for programs that move people: asked again and again as time goes on. One
 * thread at a time calls functions of an engine; they work on all. */
typedef struct volute_engine volute_engine;

/* `signs` is a file of signs as `volute visibility --signs` takes it. Criteria of tenability are
 * the usual ones that the case stores enough for. */
volute_status volute_engine_open(const char* path, const char* signs, volute_engine** engine);
void volute_engine_close(volute_engine* engine);

/* Names live as long as the engine; NULL beyond the last. */
size_t volute_engine_sign_count(const volute_engine* engine);
const char* volute_engine_sign_name(const volute_engine* engine, size_t sign);
size_t volute_engine_criterion_count(const volute_engine* engine);
const char* volute_engine_criterion_name(const volute_engine* engine, size_t criterion);
double volute_engine_criterion_limit(const volute_engine* engine, size_t criterion);

enum { VOLUTE_NOT_SEEN = 0, VOLUTE_SEEN = 1, VOLUTE_CANNOT_TELL = 2 };

/* At a time [s], from eyes x y z of each agent [m]: seen[sign * agents + agent]. */
volute_status volute_engine_sees(volute_engine* engine, double time, const double* eyes,
                                 size_t agents, unsigned char* seen);

/* What agents have taken in until `time`, since the calls before with their ids: doses so far, or
 * levels, values[criterion * agents + agent]; NaN where nothing is known. Steps of a second or less
 * are small enough for people who walk. */
volute_status volute_engine_dose(volute_engine* engine, double time, const int64_t* ids,
                                 const double* eyes, size_t agents, double* values);

#ifdef __cplusplus
}
#endif

#endif
