#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Kills one rank of `mpirun -n N volute compress --work` at random times, and goes on with another number of ranks.

    bench/killed_ranks.py build/release/bin/volute --kills 20

Each time the others must end within ten seconds and leave no target, and the run that goes on must give the bytes of one process.
"""
import argparse
import os
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import time

import large_volume
from ranks import ENVIRONMENT, by_ranks

SECONDS_TO_END = 10


def start(ranks, command):
    return subprocess.Popen(by_ranks(ranks, command), env=ENVIRONMENT, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def ranks_of(launcher):
    children = subprocess.run(["ps", "-o", "pid=,stat=,comm=", "--ppid", str(launcher)], stdout=subprocess.PIPE).stdout.decode()
    words = [line.split() for line in children.splitlines()]
    return [int(pid) for pid, state, name, *_ in words if name == "volute" and not state.startswith("Z")]


def kill_one(process, wait, draw):
    """Seconds from the kill to the end of all; none where the run was done before."""
    begin = time.monotonic()
    while time.monotonic() - begin < wait and process.poll() is None:
        time.sleep(0.01)
    there = ranks_of(process.pid)
    if process.poll() is not None or not there:
        return None
    try:
        os.kill(draw.choice(there), signal.SIGKILL)
    except ProcessLookupError:  # it has just ended
        return None
    killed = time.monotonic()
    process.communicate(timeout=120)
    return time.monotonic() - killed


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path, help="the volute command")
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--side", type=int, default=64)
    parser.add_argument("--frames", type=int, default=64)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    draw = random.Random(options.seed)
    program, side = options.program.resolve(), options.side
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        large_volume.write_plume(folder / "in.raw", side, options.frames)
        command = [program, "compress", folder / "in.raw", "--raw-size", f"{side},{side},{side}", "--rms", "0.001", "--threads", "1"]
        subprocess.run([*map(str, command), "-o", folder / "alone.volute"], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        expected = (folder / "alone.volute").read_bytes()
        target, work = folder / "out.volute", folder / "work"
        command += ["-o", target, "--work", work]
        begin = time.monotonic()
        start(3, command).communicate()
        whole = time.monotonic() - begin
        target.unlink()
        ends, units, done_before = [], [], 0
        for _ in range(options.kills):
            process = start(draw.choice((2, 3, 4)), command)
            end = kill_one(process, draw.uniform(0, whole), draw)
            process.communicate(timeout=120)
            if end is not None:
                ends.append(end)
            done_before += target.exists()
            if target.exists():
                target.unlink()
            units.append(sum(1 for path in work.rglob("*") if path.is_file()) if work.exists() else 0)
            ranks = draw.choice((1, 2, 3, 5))
            code = start(ranks, command).wait(timeout=300)
            if code != 0 or target.read_bytes() != expected or work.exists():
                print(f"kill {len(units)}: the run that went on with {ranks} ranks ended with {code}, other bytes or files left")
                return 1
            target.unlink()
    print(f"{options.kills} times within {whole:.1f} s: {len(ends)} killed, {done_before} done before; the others ended after {min(ends):.2f} to "
          f"{max(ends):.2f} s; {min(units)} to {max(units)} files of finished units were there; all went on to the same bytes")
    return 0 if max(ends) < SECONDS_TO_END else 1


if __name__ == "__main__":
    sys.exit(main())
