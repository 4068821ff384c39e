// SPDX-License-Identifier: Apache-2.0
// SPDX-FileCopyrightText: The Volute authors
#include "bench/benchmark.hpp"

namespace volute::bench {

std::span<const Benchmark> benchmarks() {
  static const std::vector<Benchmark> table = {
      {"codec",
       "files at equal relative RMS: sizes against Volute's; speeds of one thread, per second of "
       "CPU time, against zfp 4D's (of all threads, per second, against one)",
       benchCodec},
      {"fog", "painted fog over a valley: exact walk, polar table, details, one thread", benchFog},
      {"light",
       "every kind of light on every kind of medium: largest differences from brute force in "
       "double, of the brightest pixel",
       benchLight},
      {"tomography", "reconstruction of a made-up fire from 8 views: quality of the methods",
       benchTomography},
      {"smoke",
       "smoke on tetrahedra, steady and new, eye fixed and turning or moving, with an exit sign "
       "and without; least of several frames; ratios to VTK's projected tetrahedra",
       benchSmoke},
      {"sparse",
       "a cache of puffs that fill 1 % of their box, as .vdb files of halves: files, CPU time and "
       "memory of Volute, OpenVDB and NanoVDB at equal error over what is in use, without reading "
       "of .vdb files; ratios to OpenVDB's size",
       benchSparse},
#ifdef VOLUTE_WITH_GL
      {"gl",
       "the papers' tables of frame rates by OpenGL on the device there is; ratios to the "
       "CPU",
       benchGl},
#endif
      {"visibility",
       "maps of where three signs are seen, on all threads; ratio to a loop over rays in NumPy",
       benchVisibility},
  };
  return table;
}

}  // namespace volute::bench
