#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""What --max-memory promises, by the peak of the program's resident memory. Meshes are in mesh_test.py, captures in
reconstruct_test.py, folders of mounted frames in mount_test.py."""
import array
import json
import math
import os
import pathlib
import resource
import shutil
import struct
import subprocess
import time
import unittest

import pictures
import ring
import sight_cases
import support

SIDE, FRAMES = 56, 96  # 67 MB of floats


def write_sequence(path, first=0):
    """A puff that moves a voxel a frame; every value a little different, so that blocks are full."""
    line = [math.exp(-((i - SIDE / 2) / 9) ** 2) for i in range(SIDE)]
    puff = array.array("f", (a * b * c + 0.01 * math.sin(7 * i) for a in line for b in line for i, c in enumerate(line)))
    header = f"{{'descr': '<f4', 'fortran_order': False, 'shape': ({FRAMES}, {SIDE}, {SIDE}, {SIDE}), }}".ljust(117) + "\n"
    with open(path, "wb") as file:
        file.write(b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header.encode())
        data = puff.tobytes()
        for frame in range(first, first + FRAMES):
            at = 4 * SIDE * (frame % SIDE)
            file.write(data[at:] + data[:at])


class Memory(support.TestCase):
    OWN = 80 << 20  # the program and its libraries

    def expect_held(self, verb, arguments, limits, sequence):
        """With the first limit it is refused, with the last it works, and a sequence longer than the limit fits."""
        codes = []
        for allowed in limits:
            code, message, peak = self.peak(verb, *arguments, "--max-memory", f"{allowed}K")
            codes.append(code)
            with self.subTest(verb=verb, allowed=allowed):
                self.assertIn(code, (0, 1), message)
                self.assertLess(peak, (allowed << 10) + self.OWN, message)
                if code:
                    self.assertIn("memory", message)
        self.assertEqual((codes[0], codes[-1]), (1, 0), (verb, codes))
        self.assertLess(limits[-1] << 10, sequence, verb)

    def test_of_sequences_larger_than_it(self):
        sequence = 4 * FRAMES * SIDE ** 3
        write_sequence(self.path("in.npy"))
        self.works("compress", self.path("in.npy"), "-o", self.path("a.volute"), "--rms", "0.001")
        packed = self.path("a.volute")
        view = ("--size", "48x36", "--eye", "3,3,2", "--target", "0.5,0.5,0.5", "--fov", 30)
        limits = (100, 20 << 10, 56 << 10)
        for verb, arguments in (
                ("compress", (self.path("in.npy"), "-o", self.path("b.volute"), "--rms", "0.001")),
                ("extract", (packed, "-o", self.path("x.npy"))),
                ("compare", (packed, self.path("in.npy"))),
                ("render", (packed, "-o", self.path("x.png"), "--time", 0, *view)),
                ("render", (packed, "-o", self.path("x_%02d.png"), "--frames", "0:40:8", *view))):
            self.expect_held(verb, arguments, limits, sequence)

    def test_of_many_eyes_and_routes(self):
        """A place of each is refused before it does not fit."""
        case = sight_cases.FdsCase([sight_cases.Mesh("hall", (0, 6, 0, 4, 0, 3), (6, 4, 3))], [0.0, 10.0, 20.0, 30.0],
                                   lambda t, *_: 0.01 * t).write(self.folder)
        self.path("signs.json").write_text(json.dumps({"signs": [{"name": "exit", "position": [5.9, 2, 2], "normal": [-1, 0, 0]}]}))
        self.path("eyes.csv").write_text("x,y,z\n" + "1,1,1.5\n" * 60_000)
        self.path("routes.csv").write_text("route,x,y,z\n" + "".join(f"r{r},1,1,1.5\nr{r},2,1,1.5\n" for r in range(8000)))
        for eyes in (("--eyes", self.path("eyes.csv")), ("--route", self.path("routes.csv"), "--speed", "1")):
            self.expect_held("visibility", (case, "--signs", self.path("signs.json"), *eyes, "--sight", "none", "--criteria", "none",
                                            "-o", self.path("out")), (24 << 10, 48 << 10, 96 << 10, 384 << 10), 1 << 40)

    def test_of_what_is_in_a_box_and_not_of_the_box(self):
        """Two bricks in a box of 100,000^3 voxels."""
        line = [math.sin(i / 3) ** 2 if i < 8 or i >= 16 else 0 for i in range(24)]
        support.write_npy(self.path("in.npy"), (1, 8, 8, 24), [v * (0.5 + y / 20) for z in range(8) for y in range(8) for v in line])
        self.works("compress", self.path("in.npy"), "-o", self.path("near.volute"), "--bounds", "0,0,0,24,8,8")
        self.works("extract", self.path("near.volute"), "-o", self.path("near_%04d.vdb"))
        near, far = self.path("near_0000.vdb"), self.path("far.volute")
        shutil.copy(near, self.path("near_0001.vdb"))
        wide = "--bounds=-50000,-50000,-50000,50000,50000,50000"
        view = ("--size", "64x48", "--eye", "12,-40,4", "--target", "12,4,4", "--fov", 40)
        for verb, *arguments in (
                ("info", near), ("compress", near, wide, "-o", far), ("info", far),
                ("compare", near, far, wide), ("compare", far, far),
                ("render", near, wide, "-o", self.path("a.png")), ("render", near, wide, "-o", self.path("b.png"), *view),
                ("render", far, "-o", self.path("c.png")), ("render", far, "-o", self.path("d.png"), *view),
                ("render", far, "-o", self.path("e.exr"), *view, "--measured"),
                ("render", far, "-o", self.path("f.exr"), *view, "--measured", "--renderer", "reference"),
                ("render", far, "-o", self.path("g.exr"), *view, "--measured", "--basis", "cubic"),
                ("render", far, "-o", self.path("h.exr"), *view, "--measured", "--renderer", "gl"),
                ("compress", self.path("near_0001.vdb"), wide, "-o", self.path("far1.volute")),
                ("join", far, self.path("far1.volute"), "-o", self.path("both.volute")),
                ("extract", far, "-o", self.path("back_%04d.vdb"))):
            with self.subTest(verb=verb, arguments=arguments):
                code, message, peak = self.peak(verb, *arguments)
                self.assertEqual(code, 0, message)
                self.assertLess(peak, (320 if "gl" in arguments else 160) << 20)  # a software OpenGL compiles
        same = self.works("compare", self.path("e.exr"), self.path("f.exr"), "--json").json
        self.assertLess(same["relative_rms"], 1e-5)
        self.assertLess(self.works("compare", self.path("e.exr"), self.path("h.exr"), "--json").json["relative_rms"], 1e-3)
        code, message, peak = self.peak("render", far, "-o", self.path("i.exr"), *view, "--measured", "--volume-method", "tree")
        self.assertEqual(code, 1)
        self.assertIn("draw its bricks", message)
        self.assertLess(peak, 160 << 20)
        refused = self.fails(1, "extract", far, "-o", self.path("x.npy"))
        self.assertIn("the region 50000:50032,50000:50016,50000:50016 fits", refused)
        self.assertIn("--region", refused)
        self.works("extract", far, "-o", self.path("x.npy"), "--region", "50000:50024,50000:50008,50000:50008")

    def test_beside_it_nothing_grows_with_the_sequence(self):
        write_sequence(self.path("in.npy"))
        peaks = {}
        for name, frames in (("short", "0:16"), ("long", f"0:{FRAMES}")):
            code, message, peaks[name] = self.peak("compress", self.path("in.npy"), "-o", self.path(f"{name}.volute"), "--frames", frames,
                                                   "--rms", "0.001", "--threads", 1, "--max-memory", "48M")
            self.assertEqual(code, 0, message)
        self.assertLess(peaks["long"], peaks["short"] + (16 << 20))

    @unittest.skipIf("VOLUTE_TESTS_SANITIZED" in os.environ, "a sanitizer has an allocator of its own")
    def test_pictures_of_a_film_stay_in_the_memory_of_those_before(self):
        self.works("synthesize", "hall", "-o", self.path("hall.pvd"), "--cell", "1.5", "--frames", 2, "--interval", 5)
        smoke = {"kind": "smoke", "case": "hall.pvd", "field": "soot", "quantity": "soot-density", "unit": "g/m3", "walls": [0.7, 0.7, 0.7]}
        camera = {"eye": [2.3, 6.8, 1.7], "target": [20, 6, 2.5], "fov": 58}
        self.path("s.json").write_text(json.dumps({"format": "volute-scene-2", "camera": camera, "media": [smoke]}))

        def pages(speed):
            """That were cleared for a film of 5 s."""
            before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_minflt
            result = support.volute("render", self.path("s.json"), "-o", self.path("x.mp4"), "--speed", speed, "--fps", 1, "--size",
                                    "1920x1080", "--exposure", 1)
            if "this build has no" in result.message:
                self.skipTest("films are not built")
            self.assertEqual(result.code, 0, result.message)
            return resource.getrusage(resource.RUSAGE_CHILDREN).ru_minflt - before

        # Of six pictures, and of two. A picture and its samples have 26,000 pages; up to four pictures of 6,000 wait to be written.
        more = pages(1) - pages(5)
        self.assertLess(more, 4 * 13000)


class Held(support.TestCase):
    """The program and the processes that read for it, together: proportional set sizes (PSS), asked for every few milliseconds."""
    OWN = 128 << 20

    def held(self, *arguments, cwd=None):
        """(exit code, message, the most that all hold)."""
        self.measures_memory()
        process = subprocess.Popen([support.PROGRAM, *map(str, arguments)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                   start_new_session=True, cwd=cwd)
        most = 0
        while process.poll() is None:
            total = 0
            for folder in pathlib.Path("/proc").iterdir():
                try:
                    if folder.name.isdigit() and os.getsid(int(folder.name)) == process.pid:
                        total += sum(int(line.split()[1]) for line in (folder / "smaps_rollup").read_text().splitlines()
                                     if line.startswith("Pss:")) << 10
                except (OSError, ProcessLookupError):
                    continue
            most = max(most, total)
            time.sleep(0.005)
        message = process.stderr.read().decode()
        process.stderr.close()
        return process.returncode, message, most

    def within(self, megabytes, *arguments, done):
        code, message, most = self.held(*arguments, "--max-memory", f"{megabytes}M", "--quiet")
        self.assertEqual(code, 0 if done else 1, message)
        self.assertLess(most, (megabytes << 20) + self.OWN, f"{arguments[0]}: {message}")
        if not done:
            self.assertRegex(message, "[MG]i?B", message)


class AllProcesses(Held):
    def test_visibility_and_sweep(self):
        hall = sight_cases.Mesh("hall", (0, 12, 0, 8, 0, 3), (12, 8, 3))
        sight_cases.FdsCase([hall], [0.0, 10.0], lambda t, *_: 0.02 * t).write(self.folder, "hall")
        self.path("signs.json").write_text(json.dumps({"signs": [{"name": "exit", "position": [11.9, 4, 2], "normal": [-1, 0, 0]}]}))
        plan = ("visibility", self.path("hall.smv"), "--signs", self.path("signs.json"), "--maps", "aset", "--height", 1.5)
        self.within(200, *plan, "-o", self.path("a"), "--step", 0.05, done=True)   # 38,400 places
        self.within(200, *plan, "-o", self.path("b"), "--step", 0.008, done=False)  # 1,500,000
        self.path("eyes.csv").write_text("x,y,z\n" + "".join(f"{1 + i % 900 / 100},2,1.5\n" for i in range(500_000)))
        self.within(100, "visibility", self.path("hall.smv"), "--signs", self.path("signs.json"), "--eyes", self.path("eyes.csv"), "-o",
                    self.path("c"), "--sight", "none", done=False)
        self.path("study.json").write_text(json.dumps({"cases": ["hall.smv"], "options": {
            "signs": "signs.json", "height": 1.5, "step": 0.05, "maps": "aset"}}))
        self.within(200, "sweep", self.path("study.json"), "-o", self.path("d"), done=True)

    def test_meshes_with_other_fields(self):
        """A second field is read beside the smoke; both readings together stay within the limit."""
        sight_cases.write_vtu(self.path("room.vtu"), (4, 4, 3), (36, 36, 36), lambda x, y, z: 0.1 + 0.01 * x,
                              more=[("temperature", lambda x, y, z: 20 + z)])
        self.path("signs.json").write_text(json.dumps({"signs": [{"name": "exit", "position": [3.9, 2, 2], "normal": [-1, 0, 0]}]}))
        self.path("eyes.csv").write_text("x,y,z\n1,2,1.5\n")
        code, message, _ = self.held("info", self.path("room.vtu"))
        if code:
            self.skipTest(message)
        arguments = ("visibility", self.path("room.vtu"), "--signs", self.path("signs.json"), "--eyes", self.path("eyes.csv"), "--field", "smoke",
                     "--quantity", "extinction")
        self.within(160, *arguments, "-o", self.path("a"), done=True)
        self.within(16, *arguments, "-o", self.path("b"), done=False)
        self.within(400, "render", self.path("room.vtu"), "--field", "smoke", "--quantity", "extinction", "-o", self.path("x.png"), "--size",
                    "24x18", done=True)

    def test_pictures(self):
        pictures.write_rows(self.path("a.png"), [[x % 251 for x in range(9000)]] * 3000, channels=3)  # 108 MB of floats
        self.within(40, "compare", self.path("a.png"), self.path("a.png"), done=False)
        self.within(40, "info", self.path("a.png"), done=False)
        self.within(220, "compare", self.path("a.png"), self.path("a.png"), done=True)

    def test_reconstruct_and_compress(self):
        try:
            capture = ring.made()
        except unittest.SkipTest as missing:
            self.skipTest(str(missing))
        self.addCleanup(ring.made.__defaults__[0].clear)
        self.addCleanup(ring.clean_up)
        fit = ("reconstruct", capture / "capture.json", "--iterations", 2, "--regularization", "none", "--refine", "never", "--frames", "10:11")
        self.within(150, *fit, "--resolution", 48, "-o", self.path("a.npy"), done=True)
        self.within(40, *fit, "--resolution", 400, "-o", self.path("b.npy"), done=False)
        write_sequence(self.path("in.npy"))
        self.within(48, "compress", self.path("in.npy"), "-o", self.path("a.volute"), "--rms", "0.001", done=True)


if __name__ == "__main__":
    support.main()
