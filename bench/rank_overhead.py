#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""CPU time of each command by two ranks of one thread, against one process of two threads.

    bench/rank_overhead.py build/release/bin/volute --scale 6 --times 2

The two run in turn, since other programs on the machine slow down both; mpirun's own time counts. Of each command it says the CPU and wall
seconds of both, the ratio of CPU seconds, the units of each rank and how long they waited for each other.
"""
import argparse
import array
import json
import os
import pathlib
import random
import resource
import shutil
import struct
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "tests" / "cli"))
os.environ.setdefault("VOLUTE", "volute")
import ring
import sight_cases
from ranks import ENVIRONMENT, by_ranks


def used_by(command):
    """CPU and wall seconds of a command and all that it started."""
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    subprocess.run([str(word) for word in command], check=True, env=ENVIRONMENT, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, time.monotonic() - begin


class Jobs:
    """Command lines, without threads, whose inputs are made in a folder; each takes about ten CPU seconds at scale 1."""

    def __init__(self, program, folder, scale):
        self.program, self.folder, self.scale = program, folder, scale

    def run(self, *words):
        subprocess.run([str(word) for word in (self.program, *words)], check=True, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL)

    def fire(self, frames):
        self.run("synthesize", "fire", "-o", self.folder / "fire.npy", "--size", 48, "--frames", frames)
        return self.folder / "fire.npy"

    def noise(self, frames):
        """Frames of which every bit costs time: the decoder of smooth ones waits for the disk."""
        side, again = 48, 16
        draw = random.Random(1)
        chunk = array.array("f", (draw.random() for _ in range(again * side ** 3))).tobytes()
        header = repr({"descr": "<f4", "fortran_order": False, "shape": (frames, side, side, side)}).ljust(117) + "\n"
        with open(self.folder / "noise.npy", "wb") as file:
            file.write(b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode())
            for _ in range(frames // again):
                file.write(chunk)
        return self.folder / "noise.npy"

    def compress(self):
        return "compress", self.fire(48 * self.scale), "-o", self.folder / "out.volute"

    def extract(self):
        self.run("compress", self.noise(96 * self.scale), "-o", self.folder / "noise.volute", "--rms", "1e-5", "--fast")
        return "extract", self.folder / "noise.volute", "-o", self.folder / "out.npy"

    def render(self):
        self.run("compress", self.fire(24 * self.scale), "-o", self.folder / "fire.volute", "--fast")
        return "render", self.folder / "fire.volute", "-o", self.folder / "out_%05d.png", "--size", "1600x1200", "--renderer", "cpu"

    def reconstruct(self):
        frames = 24 * self.scale
        capture = self.folder / "capture.json"
        capture.write_text(json.dumps(ring.capture() | {"frames": list(range(frames))}))
        self.run("synthesize", "fire", "-o", self.folder / "truth.npy", "--size", 16, "--frames", frames)
        self.run("project", self.folder / "truth.npy", capture, "-o", self.folder / "{camera}_%04d.exr")
        return "reconstruct", capture, "-o", self.folder / "out_r.volute", "--resolution", 24, "--iterations", 20, "--force"

    def hall(self, times):
        mesh = sight_cases.Mesh("hall", (0, 14, 0, 6, 0, 2.4), (28, 12, 8), [])
        signs = [{"name": "east", "position": [14, 3, 1.6], "normal": [-1, 0, 0]}, {"name": "west", "position": [0, 3, 1.6], "normal": [1, 0, 0]}]
        (self.folder / "signs.json").write_text(json.dumps({"signs": signs}))
        return sight_cases.FdsCase([mesh], [0.5 * i for i in range(times)],
                                   lambda time, x, y, z: 0.02 * (1 + time) * (1 + 0.1 * x)).write(self.folder)

    def visibility(self):
        return ("visibility", self.hall(40 * self.scale), "--signs", self.folder / "signs.json", "-o", self.folder / "out_v", "--height", "1.2",
                "--step", "0.05")

    def sweep(self):
        variants = [{"name": f"v{i}", "options": {"extinction-limit": 0.002 * i}} for i in range(1, 10 * self.scale + 1)]
        (self.folder / "study.json").write_text(json.dumps({"cases": [str(self.hall(20))], "variants": variants,
                                                            "options": {"signs": "signs.json", "height": 1.2, "step": 0.3}}))
        return "sweep", self.folder / "study.json", "-o"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path, help="the volute command")
    parser.add_argument("--scale", type=int, default=1, help="how long jobs are; 1: about ten CPU seconds each")
    parser.add_argument("--times", type=int, default=2, help="that each is run")
    parser.add_argument("--only", action="append", help="one command; may be given again")
    options = parser.parse_args()
    program = options.program.resolve()
    for verb in options.only or ("compress", "extract", "render", "reconstruct", "visibility", "sweep"):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            words = getattr(Jobs(program, folder, options.scale), verb)()
            one, many = [], []
            for i in range(options.times):
                targets = [[folder / f"study_{i}_{which}"] if verb == "sweep" else [] for which in (0, 1)]
                # Replacing results takes longer than writing them where there are none.
                shutil.rmtree(folder / "out_v", ignore_errors=True)
                one.append(used_by((program, *words, *targets[0], "--threads", 2)))
                shutil.rmtree(folder / "out_v", ignore_errors=True)
                stats = folder / "stats.json"
                many.append(used_by(by_ranks(2, (program, *words, *targets[1], "--threads", 1, "--stats", stats))))
            (cpu, wall), (cpus, walls) = ([sum(run[which] for run in runs) / options.times for which in (0, 1)] for runs in (one, many))
            ranks = json.loads(stats.read_text())["ranks"]
            units = [sum(len(each) for each in rank["units"].values()) for rank in ranks]
            waited = max(rank["waited_seconds"] for rank in ranks)
            print(f"{verb:12} one process {cpu:6.1f} s CPU {wall:6.1f} s wall, two ranks {cpus:6.1f} s CPU {walls:6.1f} s wall: {cpus / cpu:.3f}; "
                  f"units {units}, waited {waited:.1f} s at most, {100 * waited / walls:.1f} % of the time", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
