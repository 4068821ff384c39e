# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Full disks, failing reads and writes, flipped bits, kill -9, too little memory and clocks that jump, by tests/faults.cpp: each command
ends with a sentence and leaves its target whole or not at all. A few places of each; VOLUTE_FAULT_PLACES=100 tries so many, 0 all."""
import dataclasses
import json
import os
import pathlib
import resource
import shutil
import subprocess
import tempfile
import unittest

import ring
import sight_cases
import support

LIBRARY = os.environ.get("VOLUTE_FAULTS", "")
PLACES = int(os.environ.get("VOLUTE_FAULT_PLACES", "3"))
CACHE = pathlib.Path(__file__).parents[1] / "data" / "cache.volute"


def places(count, wanted=None):
    """So many of 1..count, the first and the last among them."""
    wanted = PLACES if wanted is None else wanted
    if wanted == 0 or count <= wanted:
        return range(1, count + 1)
    return sorted({1 + round(i * (count - 1) / (wanted - 1)) for i in range(wanted)})


@dataclasses.dataclass
class Command:
    words: list
    several: bool = False  # outputs that are finished one by one, and may stay
    study: str = ""        # they are in this folder, beside tables of all of them, which tell what failed
    work: str = ""         # kept for the next run to go on from

    def __str__(self):
        return " ".join(map(str, self.words))


def contents(path):
    """The names of the files of an output, and their bytes."""
    if path.is_file():
        return {"": path.read_bytes()}
    return {str(file.relative_to(path)): file.read_bytes() for file in path.rglob("*") if file.is_file()}


@unittest.skipUnless(os.path.exists(LIBRARY), "VOLUTE_FAULTS names no library")
class Faults(support.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(temporary.cleanup)
        cls.addClassCleanup(ring.clean_up)
        cls.inputs = pathlib.Path(temporary.name)
        must = lambda *words: subprocess.run([support.PROGRAM, *map(str, words), "--quiet"], check=True, stdout=subprocess.DEVNULL)
        support.write_npy(cls.inputs / "a.npy", *support.plume(3, 12))
        must("compress", cls.inputs / "a.npy", "-o", cls.inputs / "a.volute", "--rms", "0.002")
        for name, frames in (("first", "0:1"), ("rest", "1:3")):
            must("compress", cls.inputs / "a.npy", "-o", cls.inputs / f"{name}.volute", "--rms", "0.002", "--frames", frames)
        # Parts of 16 frames are copied, not encoded again.
        support.write_npy(cls.inputs / "long.npy", (20, 6, 6, 6), [0.1 * (i % 7) for i in range(20 * 6 ** 3)])
        for name, frames in (("sixteen", "0:16"), ("four", "16:20")):
            must("compress", cls.inputs / "long.npy", "-o", cls.inputs / f"{name}.volute", "--rms", "0.01", "--frames", frames)
        (cls.inputs / "cache").mkdir()
        subprocess.run([support.PROGRAM, "extract", CACHE, "-o", cls.inputs / "cache/c_%04d.vdb", "--quiet"],
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        sight_cases.write_vtu(cls.inputs / "room.vtu", (4, 4, 3), (2, 2, 2), lambda x, y, z: 0.1)
        hall = sight_cases.Mesh("hall", (0, 8, 0, 4, 0, 3), (8, 4, 3))
        sight_cases.FdsCase([hall], [0.0, 10.0], lambda t, *_: 0.02 * t).write(cls.inputs, "hall")
        signs = [{"name": "exit", "position": [3.9, 2, 2], "normal": [-1, 0, 0]}, {"name": "back", "position": [0.1, 2, 2], "normal": [1, 0, 0]}]
        (cls.inputs / "signs.json").write_text(json.dumps({"signs": signs}))
        (cls.inputs / "eyes.csv").write_text("x,y,z\n2,3,2\n1,1,1.7\n")
        (cls.inputs / "study.json").write_text(json.dumps(
            {"cases": ["hall.smv"], "options": {"signs": "signs.json", "height": 1.5, "step": 2, "maps": "aset"},
             "variants": [{"name": "down"}, {"name": "up", "options": {"round": "up"}}]}))
        must("synthesize", "valley", "-o", cls.inputs / "valley", "--pixels", "16x12", "--size", "16")

    def setUp(self):
        super().setUp()
        self.out = self.path("out")

    def commands(self):
        at = self.inputs
        npy, volute = at / "a.npy", at / "a.volute"
        small = ("--size", "16x12")
        yield Command(["compress", npy, "-o", self.out / "x.volute", "--rms", "0.01"])
        yield Command(["compress", at / "cache", "-o", self.out / "x.volute", "--rms", "0.01"])
        yield Command(["extract", volute, "-o", self.out / "x.npy"])
        yield Command(["extract", volute, "-o", self.out / "x_%04d.vdb"], several=True)
        yield Command(["extract", CACHE, "-o", self.out / "x_%04d.vdb"], several=True)
        yield Command(["extract", volute, "-o", self.out / "x_%04d.vti"], several=True)
        yield Command(["compare", npy, volute, "--difference", self.out / "x.png"])
        yield Command(["join", at / "first.volute", at / "rest.volute", "-o", self.out / "x.volute"])
        yield Command(["join", at / "sixteen.volute", at / "four.volute", "-o", self.out / "x.volute"])
        yield Command(["synthesize", "flame", "-o", self.out / "x.npy", "--size", "16", "--frames", "2"])
        yield Command(["synthesize", "ball", "-o", self.out / "x.vtu", "--cell", "2"])
        yield Command(["render", npy, "-o", self.out / "x.png", *small, "--time", "0"])
        yield Command(["render", npy, "-o", self.out / "x.exr", *small, "--time", "0", "--measured"])
        yield Command(["render", npy, "-o", self.out / "x_%02d.png", *small], several=True)
        yield Command(["render", npy, "-o", self.out / "x.mp4", *small])
        yield Command(["render", at / "hall.smv", "-o", self.out / "x.png", *small])
        yield Command(["visibility", at / "hall.smv", "--signs", at / "signs.json", "--height", "1.5", "--step", "2", "-o", self.out / "x"])
        yield Command(["visibility", at / "room.vtu", "--quantity", "extinction", "--signs", at / "signs.json", "--eyes", at / "eyes.csv", "-o",
                       self.out / "x"])
        yield Command(["sweep", at / "study.json", "-o", self.out / "x"], several=True, study="x")
        yield Command(["fog", at / "valley/fogmap.png", "--color", at / "valley/color.exr", "--depth", at / "valley/depth.exr", "--camera",
                       at / "valley/camera.json", "-o", self.out / "x.png"])
        try:
            capture = ring.made()
        except unittest.SkipTest:
            return
        yield Command(["project", capture / "truth.npy", capture / "capture.json", "-o", self.out / "{camera}_%04d.exr", "--frames",
                       "10:11"], several=True)
        yield Command(["reconstruct", capture / "capture.json", "-o", self.out / "x.volute", "--iterations", "2", "--regularization", "none",
                       "--refine", "never", "--frames", "10:12"], work="x.volute.work")

    def run_with(self, fault, command, count=False):
        """(exit code, message, (writes, allocations, reads of inputs))"""
        shutil.rmtree(self.out, ignore_errors=True)
        self.out.mkdir()
        read, write = os.pipe()
        preloaded = f"{os.environ.get('LD_PRELOAD', '')} {LIBRARY}".strip()
        # A program that runs out of memory within a library may wait for ever: that is a hang.
        environment = os.environ | {"LD_PRELOAD": preloaded, "VOLUTE_FAULT": fault, "VOLUTE_FAULT_FOLDER": str(self.out), "VOLUTE_FAULT_INPUTS": str(self.inputs),
                                    "VOLUTE_FAULT_COUNT": str(write)}
        try:
            done = subprocess.run([support.PROGRAM, *map(str, command.words)], env=environment, pass_fds=[write], stdout=subprocess.PIPE,
                                  stderr=subprocess.PIPE, stdin=subprocess.DEVNULL, timeout=60)
        finally:
            os.close(write)
        with os.fdopen(read) as file:
            text = file.read().split()
        return done.returncode, done.stderr.decode(errors="replace"), tuple(map(int, text[:3])) if text else (0, 0, 0)

    def written(self, command):
        """Each output, a file or a folder, and the bytes of its files."""
        folder = self.out / command.study
        if not folder.exists():
            return {}
        found = {entry.name: contents(entry) for entry in folder.iterdir() if entry.name != command.work}
        if command.study:  # of runs that are done
            found = {name: files for name, files in found.items() if name.startswith((".", "hall_"))}
        return found

    def known(self):
        """Commands that this build has, what each writes, and how often it writes and allocates."""
        for command in self.commands():
            code, message, counts = self.run_with("none", command)
            if "this build has no" in message:
                continue
            self.assertEqual(code, 0, message)
            yield command, self.written(command), counts

    def check_files(self, whole, what, command, parts=False):
        """What is there has all its bytes."""
        there = {name: files for name, files in self.written(command).items()
                 if not (parts and name.startswith(".") and ".part" in name)}
        for name, files in there.items():
            self.assertIn(name, whole, what)
            self.assertEqual({file: len(data) for file, data in files.items()},
                             {file: len(data) for file, data in whole[name].items()}, f"{what}: {name}")
            if not command.several:
                self.assertEqual(set(there) - {name}, set(), what)

    def test_full_disks_and_failing_writes(self):
        for command, whole, (writes, *_) in self.known():
            self.assertGreater(writes, 1, command)
            for fault in ("full", "once"):
                for number in places(writes):
                    what = f"{fault}:{number} of {writes}: {command}"
                    with self.subTest(what):
                        code, message, _ = self.run_with(f"{fault}:{number}", command)
                        if code == 0 and not command.study:  # what failed was not of the output (its folder's sync, a remark)
                            self.assertEqual(set(self.written(command)), set(whole), what)
                        elif code != 0:
                            self.assertEqual(code, 1, f"{what}: {message}")
                            self.assertRegex(message, r"No space left|Input/output error|cannot|could not", what)
                            self.assertTrue(message.startswith("volute "), what)
                        self.check_files(whole, what, command)

    def test_failing_reads(self):
        """Of the program itself: readers of VTK and OpenVDB are processes of their own."""
        tried = 0
        for command, whole, (_, _, reads) in self.known():
            for number in places(reads):
                what = f"read:{number} of {reads}: {command}"
                with self.subTest(what):
                    tried += 1
                    code, message, _ = self.run_with(f"read:{number}", command)
                    if code == 0:  # what was not read is not needed, or the run of a study that failed is named
                        lost = set(whole) - set(self.written(command))
                        self.assertTrue(not lost or command.study and all(name in message for name in lost), f"{what}: {lost}: {message}")
                    else:
                        self.assertEqual(code, 1, f"{what}: {message}")
                        self.assertTrue(message.startswith("volute "), f"{what}: {message}")
                    self.check_files(whole, what, command)
        self.assertGreater(tried, 20)

    def test_kill_at_any_write(self):
        for command, whole, (writes, *_) in self.known():
            for number in places(writes):
                what = f"kill:{number} of {writes}: {command}"
                with self.subTest(what):
                    self.assertEqual(self.run_with(f"kill:{number}", command)[0], -9, what)
                    self.check_files(whole, what, command, parts=True)
            again = support.volute(*command.words)
            self.assertEqual(again.code, 0, again.message)
            self.assertEqual(set(whole) - set(self.written(command)), set(), "the same command again")

    def test_flipped_bits_get_no_name(self):
        """A .volute file that differs from what was encoded is found before it gets its name."""
        tried = 0
        for command, whole, (writes, *_) in self.known():
            if not str(command.words[-1]).endswith(".volute") and "x.volute" not in str(command):
                continue
            tried += 1
            found = 0
            for number in places(writes, PLACES and 4 * PLACES):
                what = f"flip:{number} of {writes}: {command}"
                with self.subTest(what):
                    code, message, _ = self.run_with(f"flip:{number}", command)
                    if code == 0:  # nothing was flipped, or what an earlier step of the search had made
                        self.assertEqual(self.written(command), whole, what)
                        continue
                    found += 1
                    self.assertEqual(code, 1, f"{what}: {message}")
                    self.assertRegex(message, "differs from what|cannot be read back|damaged|checksum", what)
                    self.assertEqual(self.written(command), {}, what)
            self.assertGreater(found, 1, command)
        self.assertGreater(tried, 2)

    def test_too_little_memory(self):
        """Our own readers: those of VTK and OpenVDB are in processes of their own."""
        at = self.inputs
        npy, volute = at / "a.npy", at / "a.volute"
        small = ("--size", "16x12")
        scene = {"format": "volute-scene-1", "camera": {"eye": [2, -3, 1], "target": [2, 2, 1], "fov": 40},
                 "media": [{"kind": "volume", "file": "a.npy"}], "geometry": [{"file": "wall.obj"}]}
        (at / "scene.json").write_text(json.dumps(scene))
        (at / "wall.obj").write_text("mtllib wall.mtl\nv 0 4 0\nv 4 4 0\nv 4 4 3\nusemtl red\nf 1 2 3\n")
        (at / "wall.mtl").write_text("newmtl red\nKd 1 0 0\n")
        commands = [["info", npy, "--values"], ["info", volute], ["info", at / "hall.smv", "--values"],
                    ["compress", npy, "-o", self.out / "x.volute", "--rms", "0.01"], ["extract", volute, "-o", self.out / "x.npy"],
                    ["render", npy, "-o", self.out / "x.png", *small, "--time", "0"],
                    ["render", at / "scene.json", "-o", self.out / "x.png", *small, "--time", "0"],
                    ["visibility", at / "hall.smv", "--signs", at / "signs.json", "--eyes", at / "eyes.csv", "-o", self.out / "x"],
                    ["fog", at / "valley/fogmap.png", "--color", at / "valley/color.exr", "--depth", at / "valley/depth.exr", "--camera",
                     at / "valley/camera.json", "-o", self.out / "x.png"]]
        try:
            commands.append(["info", ring.made() / "capture.json"])
        except unittest.SkipTest:
            pass
        for command in map(Command, commands):
            code, message, (_, allocations, _) = self.run_with("none", command)
            self.assertEqual(code, 0, message)
            self.assertGreater(allocations, 2000, command)
            whole = self.written(command)
            # The first ones are made before main(), where libraries' own tables are filled.
            tried = {1000 + place for place in places(allocations - 1000, PLACES and 2 * PLACES)}
            if command.words[0] == "visibility":  # every one where its files are made
                tried |= set(range(allocations - 100, allocations + 1))
            for number in sorted(tried):
                what = f"memory:{number} of {allocations}: {command}"
                with self.subTest(what):
                    code, message, _ = self.run_with(f"memory:{number}", command)
                    self.assertIn(code, (0, 1), f"{what}: {message}")
                    if code == 1:
                        self.assertTrue(message.startswith("volute"), f"{what}: {message}")
                    self.check_files(whole, what, command)

    def run_limited(self, command, prepare):
        shutil.rmtree(self.out, ignore_errors=True)
        self.out.mkdir()
        done = subprocess.run([support.PROGRAM, *map(str, command.words)], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              stdin=subprocess.DEVNULL, timeout=60, preexec_fn=prepare)
        return done.returncode, done.stderr.decode(errors="replace")

    def test_address_space(self):
        """`ulimit -v`, from what does not start the program to what is enough."""
        started = 0
        for command, whole, _ in self.known():
            size = 60 << 20
            code = None
            while code != 0:
                what = f"ulimit -v {size >> 10}: {command}"
                self.assertLess(size, 16 << 30, what)
                with self.subTest(what):
                    code, message = self.run_limited(command, lambda: resource.setrlimit(resource.RLIMIT_AS, (size, size)))
                    if "loading shared libraries" in message or code == 127:
                        self.assertEqual(self.written(command), {}, what)
                    else:
                        started += code == 1
                        self.assertIn(code, (0, 1), f"{what}: {message}")
                        self.assertTrue(code == 0 or message.startswith("volute"), f"{what}: {message}")
                        self.assertNotRegex(message, r"^volute[^:]*: Resource temporarily unavailable", what)
                        self.check_files(whole, what, command)
                size = size * 5 // 4
        self.assertGreater(started, 10, "commands that ended for want of memory")

    def test_a_group_of_little_memory(self):
        """Linux ends a process of a control group that is full: the program by a signal, or a reader's, and then with a sentence."""
        first = pathlib.Path("/sys/fs/cgroup/memory")
        group = (first if first.is_dir() else pathlib.Path("/sys/fs/cgroup")) / f"volute-{os.getpid()}"
        try:
            group.mkdir()
            self.addCleanup(group.rmdir)
            limit = group / ("memory.limit_in_bytes" if first.is_dir() else "memory.max")
            limit.write_text(str(64 << 20))
        except OSError as error:
            self.skipTest(f"no group may be made: {error}")
        members = group / "cgroup.procs"
        ended = 0
        for command, whole, _ in self.known():
            for size in (6 << 20, 16 << 20, 40 << 20):
                what = f"a group of {size >> 20} MB: {command}"
                with self.subTest(what):
                    limit.write_text(str(size))
                    code, message = self.run_limited(command, lambda: members.write_text(str(os.getpid())))
                    ended += code != 0
                    self.assertIn(code, (0, 1, -9), f"{what}: {message}")
                    self.assertTrue(code != 1 or message.startswith("volute"), f"{what}: {message}")
                    self.check_files(whole, what, command, parts=code == -9)
        self.assertGreater(ended, 0, "commands that were ended")

    def test_clocks_that_jump(self):
        for command, whole, _ in self.known():
            code, message, _ = self.run_with("clock:86400", command)
            self.assertEqual(code, 0, message)
            self.assertEqual(set(self.written(command)), set(whole), str(command))

    def test_two_runs_on_one_target(self):
        for command, whole, _ in self.known():
            shutil.rmtree(self.out)
            self.out.mkdir()
            runs = [subprocess.Popen([support.PROGRAM, *map(str, command.words)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
                    for _ in range(2)]
            for run in runs:
                message = run.communicate(timeout=120)[1].decode()
                self.assertEqual(run.returncode, 0, message)
            self.assertEqual(set(self.written(command)), set(whole), str(command))
            self.check_files(whole, f"two runs: {command}", command)


if __name__ == "__main__":
    support.main()
