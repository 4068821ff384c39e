# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Random commands on random small files, some of them damaged and some commands stopped by a signal, for VOLUTE_SOAK_SECONDS
(20), from the seed VOLUTE_SOAK_SEED (1): each ends by itself with 0, 1 or 2 and a sentence, leaves what it was told to write
and nothing else, and holds no more memory than it may, nor more at the end than at the beginning."""
import collections
import contextlib
import json
import os
import pathlib
import random
import shutil
import signal
import statistics
import subprocess
import threading
import time
import unittest

import ring
import support

ALLOWED = 200 << 20  # --max-memory [bytes]
OWN = 120 << 20  # the program, its libraries and what it does not count
MAPPED = 8 << 20  # by which the share of libraries that is in memory may differ [bytes]
LONGEST = 60  # [s] for one command, on a machine with other work


def stop(process, number):
    """Unless it has just ended."""
    with contextlib.suppress(ProcessLookupError):
        os.kill(process, number)


def values(chance, count):
    """What volumes are made of: nothing, one value, noise, noise among zeros, all sizes, and now and then no number."""
    kind = chance.choice(["zero", "one", "noise", "sparse", "sizes", "bad"] if chance.random() < 0.3 else ["noise", "sparse"])
    if kind == "zero":
        return [0.0] * count
    if kind == "one":
        return [chance.uniform(-5, 5)] * count
    if kind == "sizes":
        return [chance.choice((-1, 1)) * 10 ** chance.uniform(-40, 38) for _ in range(count)]
    made = [chance.random() if kind == "noise" or chance.random() < 0.1 else 0.0 for _ in range(count)]
    if kind == "bad":
        made[chance.randrange(count)] = chance.choice((float("nan"), float("inf")))
    return made


class Soak:
    """Files that commands may read, and one command at a time."""

    def __init__(self, folder, seed):
        self.chance = random.Random(seed)
        self.inputs, self.work, self.temporary = folder / "inputs", folder / "work", folder / "tmp"
        for made in (self.inputs, self.work, self.temporary):
            made.mkdir()
        self.environment = os.environ | {"TMPDIR": str(self.temporary)}
        self.volumes, self.packed, self.parts, self.cases = [], [], [], []
        self.peaks = collections.defaultdict(list)
        self.codes = collections.Counter()
        self.stopped = 0
        self.verbs = [self.info, self.compress, self.extract, self.compare, self.join, self.synthesize, self.render, self.project,
                      self.reconstruct, self.visibility, self.fog, self.words]
        self.prepare()

    def prepare(self):
        for name in ring.made().iterdir():
            shutil.copy(name, self.inputs / name.name)
        must = lambda *a: subprocess.run([support.PROGRAM, *map(str, a), "--quiet"], check=True, stdout=subprocess.DEVNULL)
        must("synthesize", "hall", "-o", self.inputs / "hall.pvd", "--cell", "1.5", "--frames", "2")
        must("synthesize", "valley", "-o", self.inputs / "valley", "--pixels", "40x30", "--size", "16")
        (self.inputs / "signs.json").write_text(json.dumps({"signs": [{"name": "e", "position": [14, 1, 2], "normal": [0, 1, 0]}]}))
        (self.inputs / "eyes.csv").write_text("x,y,z\n14,6,2\n3,3,1.7\n")
        self.cases = sorted(self.inputs.glob("hall*"))
        for _ in range(6):
            self.new_volume()

    def new_volume(self):
        chance = self.chance
        shape = [chance.randint(1, 20)] + [chance.randint(1, 14) for _ in range(3)] + ([3] if chance.random() < 0.2 else [])
        count = 1
        for side in shape:
            count *= side
        path = self.inputs / f"v{len(self.volumes):02d}.npy" if len(self.volumes) < 12 else chance.choice(self.volumes)
        support.write_npy(path, shape, values(chance, count))
        if path not in self.volumes:
            self.volumes.append(path)
        packed = path.with_suffix(".volute")
        done = support.volute("compress", path, "-o", packed, "--rms", "0.01", "--quiet")
        if done.code == 0 and packed not in self.packed:
            self.packed.append(packed)
        if done.code == 0 and shape[0] > 1 and len(self.parts) < 6:
            cut = chance.randint(1, shape[0] - 1)
            parts = [path.with_name(f"{path.stem}_{name}.volute") for name in "ab"]
            for part, frames in zip(parts, (f"0:{cut}", f"{cut}:{shape[0]}")):
                support.volute("compress", path, "-o", part, "--frames", frames, "--quiet")
            self.parts.append([part for part in parts if part.exists()])

    def damaged(self, path):
        """The file, or one time in ten a copy of it that is cut off or has changed bytes."""
        if self.chance.random() > 0.1 or not path.is_file():
            return path
        data = bytearray(path.read_bytes())
        if self.chance.random() < 0.5:
            del data[self.chance.randrange(len(data)):]
        else:
            for _ in range(self.chance.randint(1, 4)):
                data[self.chance.randrange(len(data))] = self.chance.randrange(256)
        copy = self.work / f"damaged{path.suffix}"
        copy.write_bytes(data)
        return copy

    def volume(self):
        return self.damaged(self.chance.choice(self.volumes + self.packed))

    def some(self, *options):
        """Each of the options, or not."""
        return [word for option in options if self.chance.random() < 0.4 for word in option]

    # Each verb: its arguments, and what of the folder may be there afterwards.
    def info(self):
        file = self.chance.choice([self.volume, lambda: self.damaged(self.chance.choice(self.cases))])()
        return ["info", file, *self.some(["--json"], ["--values"])], []

    def compress(self):
        goal = self.chance.choice([["--rms", "0.003"], ["--ratio", "20"], ["--psnr", "45"], ["--max-error", "0.01"], ["--size", "2K"], []])
        return ["compress", self.volume(), "-o", self.work / "c.volute", *goal, *self.some(["--fast"], ["--frames", "0:3"])], ["c.volute"]

    def extract(self):
        output = self.chance.choice(["e.npy", "e_%04d.vti", "e_%04d.npy", "e_%04d.vdb"])
        return (["extract", self.damaged(self.chance.choice(self.packed)), "-o", self.work / output,
                 *self.some(["--frames", "1:4"], ["--level", "1"], ["--region", "0:3,0:2,1:4"])], ["e*"])

    def compare(self):
        first = self.volume()
        second = self.chance.choice([first.with_suffix(s) for s in (".npy", ".volute")] + self.volumes)
        return ["compare", first, second, *self.some(["--json"])], []

    def join(self):
        parts = self.chance.choice(self.parts + [self.chance.sample(self.packed, 2)])
        return ["join", *map(self.damaged, parts), "-o", self.work / "j.volute"], ["j.volute"]

    def synthesize(self):
        kind = self.chance.choice(["fire", "flame", "smoke"])
        output = self.chance.choice(["s.npy", "s.volute", "s_%04d.vdb"])
        return (["synthesize", kind, "-o", self.work / output, "--size", self.chance.choice((7, 16, 16, 24)), "--frames", self.chance.randint(1, 4),
                 "--seed", self.chance.randint(0, 99)], ["s*"])

    def render(self):
        output = self.chance.choice(["r.png", "r.exr", "r_%04d.png"])
        frames = ["--frames", "0:3"] if "%" in output else []
        renderer = self.chance.choice(["cpu", "reference"])
        return (["render", self.volume(), "-o", self.work / output, "--size", f"{self.chance.randint(1, 40)}x{self.chance.randint(1, 40)}",
                 "--renderer", renderer, *frames, *self.some(["--colormap", "viridis"], ["--aov", "optical-depth"])], ["r*"])

    def project(self):
        return (["project", self.chance.choice([self.inputs / "truth.npy", self.volume()]), self.damaged(self.inputs / "capture.json"),
                 "-o", self.work / "{camera}_%04d.exr"], [f"{name}_*.exr" for name in ring.NAMES])

    def reconstruct(self):
        return (["reconstruct", self.inputs / "capture.json", "-o", self.work / "o.volute", "--iterations", self.chance.randint(1, 4),
                 "--regularization", "none", "--frames", "10:12"], ["o.volute", "o.volute.work"])

    def visibility(self):
        case = self.chance.choice([self.inputs / "hall.pvd", self.damaged(self.inputs / "hall.pvd")])
        return (["visibility", case, "--quantity", "soot-density", "--unit", "g/m3", "--signs", self.damaged(self.inputs / "signs.json"),
                 "--eyes", self.damaged(self.inputs / "eyes.csv"), "-o", self.work / "sight"], ["sight"])

    def fog(self):
        valley = self.inputs / "valley"
        return (["fog", self.damaged(valley / "fogmap.png"), "--color", self.damaged(valley / "color.exr"), "--depth",
                 self.damaged(valley / "depth.exr"), "--camera", valley / "camera.json", "-o", self.work / "f.png"], ["f.png"])

    def words(self):
        words = ["render", "--frames", "-o", "x", "--size", "-1", "9999999999", "--json", "help", "", "--rms", "nan", "/", str(self.inputs)]
        return self.chance.choices(words, k=self.chance.randint(0, 5)), []

    def step(self):
        """Runs a command; returns what is wrong with how it ended, or None."""
        if self.chance.random() < 0.05:
            self.new_volume()
        for left in self.work.iterdir():
            shutil.rmtree(left) if left.is_dir() else left.unlink()
        before = {path: path.stat().st_mtime_ns for path in self.inputs.rglob("*")}
        arguments, may = self.chance.choice(self.verbs)()
        arguments = [str(argument) for argument in arguments]
        given = {path.name for path in self.work.iterdir()}
        stops_after = self.chance.uniform(0.01, 0.4) if self.chance.random() < 0.1 else None
        ended = self.run(arguments, stops_after)
        wrong = self.fault(ended, arguments, given, may, stops_after)
        if {path: path.stat().st_mtime_ns for path in self.inputs.rglob("*")} != before:
            wrong = wrong or "changed its inputs"
        return wrong and f"volute {' '.join(arguments)}: {wrong}\n{ended[1]}"

    def run(self, arguments, stops_after):
        """Exit code, message, most memory, and whether it took too long."""
        limits = [] if not arguments or arguments[0] not in {verb.__name__ for verb in self.verbs} else ["--max-memory", str(ALLOWED)]
        process = subprocess.Popen([support.PROGRAM, *arguments, *limits], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.PIPE, env=self.environment, cwd=self.work)
        late = []
        # Not by the process's own methods: they wait for it, and its memory would be lost.
        timers = [threading.Timer(LONGEST, lambda: (late.append(True), stop(process.pid, signal.SIGKILL)))]
        if stops_after is not None:
            self.stopped += 1
            timers.append(threading.Timer(stops_after, stop, [process.pid, signal.SIGINT]))
        for timer in timers:
            timer.start()
        message = process.stderr.read().decode(errors="replace")
        process.stderr.close()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        for timer in timers:
            timer.cancel()
            timer.join()
        if stops_after is None and arguments:
            self.peaks[arguments[0]].append(usage.ru_maxrss << 10)
        self.codes[process.returncode] += 1
        return process.returncode, message, usage.ru_maxrss << 10, bool(late)

    def fault(self, ended, arguments, given, may, stops_after):
        code, message, peak, late = ended
        left = {path.name for path in self.work.iterdir()} - given
        spare = {name for name in left if not any(pathlib.PurePath(name).match(pattern) for pattern in may)}
        stopped = stops_after is not None and code == -signal.SIGINT
        if late:
            return f"took more than {LONGEST} s"
        if code not in (0, 1, 2) and not stopped:
            return f"ended with {code}"
        if code in (1, 2) and "volute" not in message:
            return "said nothing"
        if spare or list(self.temporary.iterdir()):
            return f"left {sorted(spare)} and {[path.name for path in self.temporary.iterdir()]}"
        if "VOLUTE_TESTS_SANITIZED" not in os.environ and peak > ALLOWED + OWN:
            return f"held {peak >> 20} MiB"
        return None

    def growth(self):
        """Of each verb the median of the last third's memory over that of the first third, less what the machine decides: how
        much of the libraries is in its memory when they are mapped."""
        found = {}
        for verb, peaks in self.peaks.items():
            third = len(peaks) // 3
            if third >= 30:
                first, last = statistics.median(peaks[:third]), statistics.median(peaks[-third:])
                found[verb] = max(last - MAPPED, min(last, first)) / first
        return found


class RandomCommands(support.TestCase):
    def test_nothing_is_left_and_memory_stays(self):
        seconds = float(os.environ.get("VOLUTE_SOAK_SECONDS", "20"))
        soak = Soak(self.folder, int(os.environ.get("VOLUTE_SOAK_SEED", "1")))
        self.addCleanup(ring.clean_up)
        end = time.monotonic() + seconds
        faults = []
        while time.monotonic() < end and len(faults) < 10:
            wrong = soak.step()
            if wrong:
                faults.append(wrong)
        growth = soak.growth()
        print(f"{sum(soak.codes.values())} commands, {soak.stopped} stopped, exit codes {dict(soak.codes)}; "
              f"peak {max(max(p) for p in soak.peaks.values()) / 2**20:.0f} MiB; last third over first "
              + ", ".join(f"{verb} {ratio:.3f}" for verb, ratio in sorted(growth.items())))
        self.assertEqual(faults, [], "\n\n".join(faults))
        for verb, ratio in growth.items():
            self.assertLess(ratio, 1.15, verb)


if __name__ == "__main__":
    unittest.main(verbosity=1)
