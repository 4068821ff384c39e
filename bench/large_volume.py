#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Compresses a sequence that is larger than memory, and says how much memory each rank took.

    bench/large_volume.py build/release/bin/volute --side 512 --frames 32 --ranks 2 --max-memory 1500M

The sequence is a raw file with holes: a moving plume fills 5 % of the voxels, and what it leaves empty takes no room on the disk
(512^3 x 32 frames: 17 GB long, 0.9 GB on disk). It is made row by row.
"""
import argparse
import array
import math
import os
import pathlib
import sys
import tempfile

from ranks import stats_of

SHARE = 0.05  # of the voxels that the plume fills


def write_plume(path, side, frames):
    """side^3 x frames float32 values, a file with holes; bytes written."""
    width = round(side * SHARE ** (1 / 3))
    profiles = []
    for i in range(256):
        ease = [math.sin(math.pi * (x + 0.5) / width) for x in range(width)]
        profiles.append(array.array("f", [(0.2 + i / 255) * e * (1 + 0.3 * math.sin(0.11 * x + 0.05 * i)) for x, e in enumerate(ease)]).tobytes())
    written = 0
    file = os.open(path, os.O_CREAT | os.O_TRUNC | os.O_WRONLY, 0o666)
    try:
        os.ftruncate(file, 4 * side ** 3 * frames)
        for t in range(frames):
            corner = [round((side - width) * (0.5 + 0.4 * math.sin(rate * t + axis))) for axis, rate in enumerate((0.05, 0.06, 0.07))]
            for z in range(width):
                for y in range(width):
                    ease = math.sin(math.pi * (y + 0.5) / width) * math.sin(math.pi * (z + 0.5) / width)
                    row = profiles[int(255 * ease * (0.6 + 0.4 * math.sin(0.07 * y + 0.05 * z + 0.3 * t)))]
                    place = ((t * side + corner[0] + z) * side + corner[1] + y) * side + corner[2]
                    written += os.pwrite(file, row, 4 * place)
    finally:
        os.close(file)
    return written


def compress_on_ranks(program, path, side, ranks, options):
    """What --stats says of a run."""
    command = [program, "compress", path, "-o", path.with_suffix(".volute"), "--raw-size", f"{side},{side},{side}", *options]
    return stats_of(ranks, command, path.with_suffix(".json"))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path, help="the volute command")
    parser.add_argument("--side", type=int, default=512, help="voxels along each axis")
    parser.add_argument("--frames", type=int, default=32)
    parser.add_argument("--ranks", type=int, default=2)
    parser.add_argument("--max-memory", default="1500M", help="of a rank")
    parser.add_argument("--rms", default="0.003")
    parser.add_argument("--folder", type=pathlib.Path, help="for the sequence and what comes of it")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=options.folder) as folder:
        path = pathlib.Path(folder) / "plume.raw"
        written = write_plume(path, options.side, options.frames)
        print(f"{options.side}^3 x {options.frames}: {path.stat().st_size / 1e9:.1f} GB long, {written / 1e9:.2f} GB written")
        stats = compress_on_ranks(options.program.resolve(), path, options.side, options.ranks,
                         ("--rms", options.rms, "--threads", "1", "--fast", "--max-memory", options.max_memory))
        for rank in stats["ranks"]:
            units = {name: len(each) for name, each in rank["units"].items()}
            print(f"rank {rank['rank']}: {rank['peak_memory_bytes'] / 1e6:.0f} MB at most, {rank['cpu_seconds']:.1f} s CPU, units {units}")
        print(f"{stats['bytes'] / 1e3:.0f} kB, relative rms {stats['relative_rms']:.3g}, {stats['seconds']:.1f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
