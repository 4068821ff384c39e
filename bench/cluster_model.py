#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""How long `mpirun -n N volute compress` takes on machines that are not here: a simulation of its ranks.

    mpirun -n 1 volute compress sample.npy -o x.volute --rms 0.003 --threads 1 --stats one.json
    bench/cluster_model.py one.json                                   plan 1024^3 x 1000 on 16 .. 4096 ranks
    bench/cluster_model.py one.json --check two.json four.json        CPU time that it foretells, against that of runs

A rank takes a unit from the counter on rank 0, reads it, computes, and takes the next one; after each way through all units the
ranks meet and share what they found; in the end rank 0 gets all bytes and writes them. CPU time for a byte of each stage and its
spread over units come from the measured run; bandwidths and latencies are stated on the command line. Of the measured sequence the
sample must be like the one that is planned: empty blocks cost little.
"""
import argparse
import heapq
import json
import math
import pathlib
import random
import sys

SIDE = 16  # frames and voxels of a block
BLOCKS_A_UNIT = 64  # at least, where several ranks share (codec/compress.cpp: kBatch)
INDEX_BYTES_A_BLOCK = 3 * 8  # sizes and checksums that rank 0 gets, before they are packed


class Sequence:
    def __init__(self, size, frames):
        x, y, z = size
        rows, layers = -(-frames // SIDE), -(-z // SIDE)
        blocks_a_layer = -(-x // SIDE) * -(-y // SIDE)
        layers_a_unit = min(layers, -(-BLOCKS_A_UNIT // blocks_a_layer))
        self.raw = 4 * x * y * z * frames
        self.blocks = rows * layers * blocks_a_layer
        self.units_a_row = -(-layers // layers_a_unit)
        self.rows = rows
        self.unit_raw = 4 * x * y * min(z, SIDE * layers_a_unit) * min(SIDE, frames)


class Measured:
    """Costs of a run: CPU seconds for a raw byte of each stage, and of a rank beside its units."""

    def __init__(self, path):
        stats = json.loads(pathlib.Path(path).read_text())
        self.ranks = stats["ranks"]
        self.raw, self.packed = stats["raw_bytes"], stats["bytes"]
        self.sequence = Sequence(stats["size"], stats["frames"])
        self.cpu = sum(rank["cpu_seconds"] for rank in self.ranks)
        self.stages = {}
        for rank in self.ranks:
            for name, stage in rank["stages"].items():
                self.stages[name] = self.stages.get(name, 0) + stage["cpu_seconds"]
        self.beside = (self.cpu - sum(self.stages.values())) / len(self.ranks)

    def share(self, name):
        """Of the sequence that a stage goes through: learning takes four rows at most."""
        return min(1, 4 / self.sequence.rows) if name == "learning" else 1


class Server:
    """Serves requests in turn."""

    def __init__(self, rate):
        self.rate, self.free = rate, 0.0

    def serve(self, now, amount):
        self.free = max(self.free, now) + amount / self.rate
        return self.free


def simulate(measured, sequence, ranks, options):
    """(seconds, where they went): of computing, reading, waiting for the last unit, and rank 0's own."""
    draw = random.Random(1)
    disk, counter = Server(options.disk * 1e9), Server(1e6 / options.take)
    link = options.link * 1e9
    now = 0.0
    spent = {"computing": 0.0, "reading": 0.0, "counter": 0.0, "uneven": 0.0, "meeting": 0.0, "rank 0": 0.0}
    sigma = math.sqrt(math.log(1 + options.spread ** 2))
    for name, cpu in measured.stages.items():
        rows = min(sequence.rows, 4) if name == "learning" else sequence.rows
        units = rows * sequence.units_a_row
        cost = cpu / (measured.raw * measured.share(name)) * sequence.unit_raw / options.threads
        ready = [now] * ranks
        heapq.heapify(ready)
        ends = []
        for _ in range(units):
            begin = heapq.heappop(ready)
            taken = max(counter.serve(begin, 1), begin + 2e-6 * options.latency)
            read = max(disk.serve(taken, sequence.unit_raw), taken + sequence.unit_raw / link)
            work = cost * draw.lognormvariate(-sigma * sigma / 2, sigma)
            spent["counter"] += (taken - begin) / ranks
            spent["reading"] += (read - taken) / ranks
            spent["computing"] += work / ranks
            heapq.heappush(ready, read + work)
            ends.append(read + work)
        last = max(ends)
        spent["uneven"] += sum(last - end for end in ready) / ranks
        # Sums of 140 KB go down and up a tree; sizes and modes of blocks go to rank 0.
        meeting = 2 * math.log2(max(ranks, 2)) * (1e-6 * options.latency + 140e3 / link)
        if name not in ("analysing", "learning") and ranks > 1:
            meeting += sequence.blocks * INDEX_BYTES_A_BLOCK / link
        spent["meeting"] += meeting
        now = last + meeting
    packed = measured.packed / measured.raw * sequence.raw
    index = sequence.blocks * options.index * 1e-9
    final = packed / (link if ranks > 1 else math.inf) + packed / (options.write * 1e9) + index
    spent["rank 0"] += final
    return now + final, spent


def number_of(text):
    return [int(part) for part in text.replace("x", ",").split(",")]


def plan(measured, options):
    sequence = Sequence(options.size, options.frames)
    units = sequence.rows * sequence.units_a_row
    print(f"{'x'.join(map(str, options.size))} x {options.frames}: {sequence.raw / 1e12:.3g} TB, {units} units of "
          f"{sequence.unit_raw / 1e6:.0f} MB, {len(measured.stages)} ways through them; {options.threads} threads a rank, "
          f"{options.disk} GB/s from the disks, {options.link} GB/s a link")
    print(f"{'ranks':>6} {'hours':>8} {'of ideal':>9}  where the time goes [% of it]")
    single = None
    ranks = options.first
    while ranks <= options.last:
        seconds, spent = simulate(measured, sequence, ranks, options)
        single = single or spent["computing"] * ranks
        parts = ", ".join(f"{name} {100 * part / seconds:.0f}" for name, part in spent.items() if part >= 0.005 * seconds)
        print(f"{ranks:6} {seconds / 3600:8.3f} {100 * single / ranks / seconds:8.0f} %  {parts}")
        ranks *= options.step


def check(measured, paths):
    """Whether the costs of one run foretell the CPU time of others; exit 1 beyond 25 %."""
    worst = 0.0
    print(f"{'ranks':>6} {'foretold':>9} {'measured':>9}")
    for path in paths:
        run = Measured(path)
        units = sum(cpu / (measured.raw * measured.share(name)) * run.raw * run.share(name) for name, cpu in measured.stages.items()
                    if name in run.stages)
        foretold = units + measured.beside * len(run.ranks)
        error = foretold / run.cpu - 1
        worst = max(worst, abs(error))
        print(f"{len(run.ranks):6} {foretold:8.1f}s {run.cpu:8.1f}s  {100 * error:+.0f} %")
    return worst <= 0.25


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stats", help="what compress --stats wrote, of one rank")
    parser.add_argument("--check", nargs="+", metavar="STATS", help="of other runs, on sequences of the same kind")
    parser.add_argument("--size", type=number_of, default=[1024, 1024, 1024], metavar="XxYxZ")
    parser.add_argument("--frames", type=int, default=1000)
    parser.add_argument("--first", type=int, default=16, help="number of ranks to begin with")
    parser.add_argument("--last", type=int, default=4096)
    parser.add_argument("--step", type=int, default=4, help="factor from one number of ranks to the next")
    parser.add_argument("--threads", type=int, default=1, help="of a rank")
    parser.add_argument("--disk", type=float, default=50, help="GB/s that all ranks together read")
    parser.add_argument("--write", type=float, default=1, help="GB/s that one rank writes")
    parser.add_argument("--link", type=float, default=10, help="GB/s of a machine's link")
    parser.add_argument("--latency", type=float, default=5, help="microseconds of a message")
    parser.add_argument("--take", type=float, default=2, help="microseconds that the counter needs for a unit")
    parser.add_argument("--spread", type=float, default=0.5, help="of the units' cost, standard deviation / mean")
    parser.add_argument("--index", type=float, default=300, help="nanoseconds that rank 0 needs for a block's entry in the index")
    options = parser.parse_args()
    measured = Measured(options.stats)
    if options.check:
        return 0 if check(measured, options.check) else 1
    plan(measured, options)
    return 0


if __name__ == "__main__":
    sys.exit(main())
