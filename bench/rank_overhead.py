#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""CPU time of each command by two ranks of one thread, against one process of two threads.

    bench/rank_overhead.py build/release/bin/volute --scale 3 --times 3

The two run in turn, since other programs on the machine slow down both; mpirun's own time counts. Of each command it says the CPU
seconds of both, their ratio, the ranks' greatest share of the units and how long they waited for each other.
"""
import argparse
import json
import os
import pathlib
import resource
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "tests" / "cli"))
os.environ.setdefault("VOLUTE", "volute")
import ring
import sight_cases


def cpu_of(command):
    """CPU seconds of a command and all that it started."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    allowed = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    subprocess.run([str(word) for word in command], check=True, env=os.environ | allowed, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def commands_of(program, folder, scale):
    """Command lines, without threads: name -> words. Their inputs are made here."""
    def run(*words):
        subprocess.run([str(word) for word in (program, *words)], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    run("synthesize", "fire", "-o", folder / "fire.npy", "--size", 48, "--frames", 48 * scale)
    run("compress", folder / "fire.npy", "-o", folder / "fire.volute", "--fast")
    capture = folder / "capture.json"
    capture.write_text(json.dumps(ring.capture() | {"frames": list(range(24 * scale))}))
    run("synthesize", "fire", "-o", folder / "truth.npy", "--size", 16, "--frames", 24 * scale)
    run("project", folder / "truth.npy", capture, "-o", folder / "{camera}_%04d.exr")
    mesh = sight_cases.Mesh("hall", (0, 14, 0, 6, 0, 2.4), (28, 12, 8), [])
    times = [0.5 * i for i in range(20 * scale)]
    case = sight_cases.FdsCase([mesh], times, lambda time, x, y, z: 0.02 * (1 + time) * (1 + 0.1 * x)).write(folder)
    (folder / "signs.json").write_text(json.dumps({"signs": [{"name": "east", "position": [14, 3, 1.6], "normal": [-1, 0, 0]},
                                                             {"name": "west", "position": [0, 3, 1.6], "normal": [1, 0, 0]}]}))
    variants = [{"name": f"v{i}", "options": {"extinction-limit": 0.05 * i}} for i in range(1, 9)]
    (folder / "study.json").write_text(json.dumps({"cases": [str(case)], "variants": variants,
                                                   "options": {"signs": "signs.json", "height": 1.2, "step": 0.3}}))
    return {"compress": ("compress", folder / "fire.npy", "-o", folder / "out.volute"),
            "extract": ("extract", folder / "fire.volute", "-o", folder / "out.npy"),
            "render": ("render", folder / "fire.volute", "-o", folder / "out_%04d.png", "--size", "400x300", "--renderer", "cpu"),
            "reconstruct": ("reconstruct", capture, "-o", folder / "out_r.volute", "--resolution", 24, "--iterations", 20, "--force"),
            "visibility": ("visibility", case, "--signs", folder / "signs.json", "-o", folder / "out_v", "--height", "1.2", "--step", "0.1"),
            "sweep": ("sweep", folder / "study.json", "-o")}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path, help="the volute command")
    parser.add_argument("--scale", type=int, default=1, help="how long sequences are; 1: some seconds a command")
    parser.add_argument("--times", type=int, default=2, help="that each is run")
    parser.add_argument("--only", help="one command")
    options = parser.parse_args()
    program = options.program.resolve()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for verb, words in commands_of(program, folder, options.scale).items():
            if options.only not in (None, verb):
                continue
            one = many = 0
            for i in range(options.times):
                targets = [[folder / f"study_{i}_{which}"] if verb == "sweep" else [] for which in (0, 1)]
                one += cpu_of((program, *words, *targets[0], "--threads", 2)) / options.times
                stats = folder / "stats.json"
                many += cpu_of(("mpirun", "--oversubscribe", "-n", 2, program, *words, *targets[1], "--threads", 1, "--stats", stats)) / options.times
            ranks = json.loads(stats.read_text())["ranks"]
            units = [sum(len(each) for each in rank["units"].values()) for rank in ranks]
            waited = max(rank["waited_seconds"] for rank in ranks)
            print(f"{verb:12} one process {one:6.1f} s, two ranks {many:6.1f} s: {many / one:.3f}; units {units}, waited {waited:.1f} s at most",
                  flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
