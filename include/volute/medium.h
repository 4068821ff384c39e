/* SPDX-License-Identifier: Apache-2.0
 * SPDX-FileCopyrightText: The Volute authors
 *
 * A kind of medium of your own, in C or any language that calls it. Volute's command, viewer and
 * libraries show it, light it and look through it as they do their own kinds. docs/own-media.md is
 * the manual.
 *
 * A plug-in is a shared library volute_medium_NAME.so in lib/volute, or in the folder that the
 * environment's VOLUTE_PLUGIN_FOLDER names, which exports
 *
 *     const volute_medium_kind* volute_medium(void);
 *
 * It needs no library of Volute's. A program registers a kind by volute_medium_register() of
 * volute.h. From 0.3 on this header only grows. */
#ifndef VOLUTE_MEDIUM_H
#define VOLUTE_MEDIUM_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The points origin + s direction, begin <= s <= end [m]; direction has the length 1, begin may be
 * -infinity and end infinity. */
typedef struct volute_segment {
  double origin[3], direction[3];
  double begin, end;
} volute_segment;

/* A stretch of a segment where the medium has a closed form. With u = s - begin:
 *   extinction(u) = (extinction[0] + extinction[1] u + .. + extinction[3] u^3) exp(-decay u)  [1/m]
 *   emission(u)   = likewise, linear red, green and blue                             [radiance/m]
 * An extinction is not below 0, but for a hundredth of its largest value, by which a fit may miss.
 */
typedef struct volute_piece {
  size_t segment;    /* number of the segment, from 0 */
  double begin, end; /* part of the segment [m]; end is infinite only with decay > 0 or constants */
  double extinction[4];
  double emission[3][4];
  double decay; /* [1/m]; 0 without exponentials */
} volute_piece;

/* Takes pieces of the segments of a call, those of each segment from front to back and without
 * overlap; gaps are empty. */
typedef void (*volute_pieces_function)(void* to, const volute_piece* pieces, size_t count);

/* A member of the kind's entries in scenes: one or several numbers. */
typedef struct volute_medium_member {
  const char* name;        /* "radius": lower case letters, digits and _ */
  const char* help;        /* "at 0 s" */
  const char* unit;        /* "m"; "" if there is none */
  int32_t count;           /* numbers, 1 to 16 */
  const double* usual;     /* their defaults, `count` of them; NULL: zeros */
  double minimum, maximum; /* of each number; both 0: any */
} volute_medium_member;

/* A kind of medium. Functions that return a text return NULL, or a sentence that says why they
 * could not, valid until the thread calls again; the call of Volute's that needed them then fails
 * with it. All but open and close are called from many threads at once. What is pointed to must
 * stay until the program ends. */
typedef struct volute_medium_kind {
  size_t size;          /* sizeof(volute_medium_kind) */
  const char* name;     /* the value of "kind" in scenes: "ball" */
  const char* sentence; /* "an even ball of smoke" */
  const volute_medium_member* members;
  size_t member_count;
  const char* ending; /* ".ball": files that are shown alone and that "file" of an entry names;
                         NULL: the kind has no files */
  void* user;         /* for open */

  /* Opens an entry. `values`: the numbers of all members, one after the other. `file`: the path of
   * its file, or NULL. *medium is handed to all that follows. */
  const char* (*open)(void* user, const double* values, const char* file, void** medium);
  void (*close)(void* medium); /* NULL: nothing is to be done */

  /* Bounds over all times: x0 y0 z0 x1 y1 z1 [m]; may be infinite. */
  const char* (*bounds)(void* medium, double bounds[6]);

  /* Times [s], ascending, between which the medium changes: fills times[0 .. room - 1] and returns
   * how many there are. NULL: it does not change. */
  size_t (*times)(void* medium, double* times, size_t room);

  /* Gives the pieces of all segments at a time to give(to, pieces, count), in one call or more. */
  const char* (*pieces)(void* medium, double time, const volute_segment* segments, size_t count,
                        volute_pieces_function give, void* to);

  /* Integrals of the extinction along segments, at least 0. NULL: those of the pieces are taken. */
  const char* (*optical_depth)(void* medium, double time, const volute_segment* segments,
                               size_t count, double* depths);

  /* Extinction [1/m], and emission (three numbers each), at points x y z, for probes and for
   * checks of the pieces. Both hold zeros. NULL: those of the pieces are taken. */
  const char* (*values)(void* medium, double time, const double* points, size_t count,
                        double* extinction, double* emission);
} volute_medium_kind;

#ifdef __cplusplus
}
#endif

#endif
