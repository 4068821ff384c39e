# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Ctrl-C: the command stops, says so, and leaves nothing half-written."""
import json
import os
import pathlib
import random
import signal
import struct
import subprocess
import time

import ring
import sight_cases
import support


class Interrupt(support.TestCase):
    def start(self, *arguments):
        before = set(self.files())
        process = subprocess.Popen([support.PROGRAM, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        end = time.monotonic() + 30
        while set(self.files()) == before and process.poll() is None and time.monotonic() < end:
            time.sleep(0.005)
        self.assertIsNone(process.poll(), "ended before it could be stopped")
        return process

    def stopped(self, process, signals):
        for number in signals:
            process.send_signal(number)
        _, message = process.communicate(timeout=60)
        self.assertEqual(process.returncode, -signals[0], message)
        return message.decode()

    def noise(self):
        """Large enough that compressing it takes seconds; noise is the slowest."""
        frame = os.urandom(64 ** 3) * 4
        header = b"{'descr': '<f4', 'fortran_order': False, 'shape': (96, 64, 64, 64)}".ljust(117) + b"\n"
        # With 0x3f and 0x80 in the high bytes, random numbers between 1 and 2.
        values = bytearray(frame)
        values[2::4] = bytes(byte | 0x80 for byte in values[2::4])
        values[3::4] = b"\x3f" * (len(values) // 4)
        with open(self.path("noise.npy"), "wb") as file:
            file.write(b"\x93NUMPY\x01\x00\x76\x00" + header)
            for frame in range(96):
                file.write(values[1024 * frame:] + values[:1024 * frame])  # no two are alike
        return self.path("noise.npy")

    def test_compress_leaves_no_target(self):
        noise = self.noise()
        for number in (signal.SIGINT, signal.SIGTERM):
            process = subprocess.Popen([support.PROGRAM, "compress", noise, "-o", self.path("x.volute"), "--rms", "0.0001"],
                                       stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            support.listening(process)
            time.sleep(0.4)
            self.assertIn("volute compress: stopped", self.stopped(process, [number]))
            self.assertEqual(self.files(), ["noise.npy"])

    def test_synthesize_and_a_second_signal(self):
        process = self.start("synthesize", "fire", "-o", self.path("x.npy"), "--size", "64", "--frames", "10000")
        process.send_signal(signal.SIGINT)
        time.sleep(0.02)
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)
        self.assertEqual(process.returncode, -signal.SIGINT)
        self.assertEqual(self.files(), [])

    def test_a_shells_loop_ends(self):
        """As a terminal sends it: to the shell and its child. bash asks whether the child died of it."""
        noise = self.noise()
        command = f"'{support.PROGRAM}' compress '{noise}' -o '{self.path('x.volute')}' --rms 0.0001"
        loop = subprocess.Popen(["bash", "-c", f"for i in 1 2 3; do {command}; echo $i: $?; done"], stdout=subprocess.PIPE,
                                stderr=subprocess.PIPE, start_new_session=True)
        support.listening(loop)
        time.sleep(0.6)
        os.killpg(loop.pid, signal.SIGINT)
        said, message = loop.communicate(timeout=60)
        self.assertEqual((loop.returncode, said), (-signal.SIGINT, b""), message)
        self.assertIn(b"stopped", message)
        self.assertEqual(self.files(), ["noise.npy"])

    def test_what_was_ignored_stays_ignored(self):
        packed = self.make_volute()
        process = subprocess.Popen(["bash", "-c", f"trap '' INT; exec '{support.PROGRAM}' render '{packed}' -o '{self.path('x.png')}' "
                                    "--size 900x900 --renderer reference"], stderr=subprocess.PIPE)
        support.listening(process)
        time.sleep(0.3)
        process.send_signal(signal.SIGINT)
        message = process.communicate(timeout=120)[1]
        self.assertEqual(process.returncode, 0, message)
        self.assertEqual(self.files(), ["in.volute", "x.png"])

    def test_render_stops(self):
        packed = self.make_volute()
        process = subprocess.Popen([support.PROGRAM, "render", packed, "-o", self.path("x.png"), "--size", "4000x4000", "--renderer", "reference"],
                                   stderr=subprocess.PIPE)
        support.listening(process)
        time.sleep(0.5)
        self.assertIn("stopped", self.stopped(process, [signal.SIGINT]))
        self.assertEqual(self.files(), ["in.volute"])

    def test_a_partial_still_is_written(self):
        packed = self.make_volute(frames=2, size=40)
        process = subprocess.Popen([support.PROGRAM, "render", packed, "-o", self.path("x.png"), "--size", "7000x7000", "--renderer", "reference",
                                    "--exposure", "1", "--partial"], stderr=subprocess.PIPE)
        said = b""
        while b"rendering" not in said:  # one tile is there
            more = process.stderr.read(1)
            self.assertTrue(more, said)
            said += more
        self.assertIn("of the picture, the rest coarsely", self.stopped(process, [signal.SIGINT]))
        self.assertEqual(self.files(), ["in.volute", "x.png"])
        self.assertEqual(self.works("info", self.path("x.png"), "--json").json["size"], [7000, 7000])

    def test_a_second_is_enough(self):
        """What computes without asking ends too: the hall's 12 million tets are made in one step."""
        def took():
            begun = subprocess.Popen([support.PROGRAM, "synthesize", "hall", "-o", self.path("hall.pvd"), "--cell", "0.1"],
                                     stderr=subprocess.PIPE)
            support.listening(begun)
            time.sleep(0.4)
            at = time.monotonic()
            self.assertIn("stopped", self.stopped(begun, [signal.SIGINT]))
            self.assertEqual(self.files(), [])
            return time.monotonic() - at

        self.assertTrue(soon(took))


def soon(took):
    """Whether one of three runs ends as soon as it has to, on a machine with other work: a second, and half of one to be gone."""
    return any(took() < 1.5 * support.slower() for _ in range(3))


def sparse_npy(path, shape):
    """Zeros, of any size, that take no place on the disk."""
    header = repr({"descr": "<f4", "fortran_order": False, "shape": shape}).encode()
    header += b" " * (-(len(header) + 11) % 64) + b"\n"
    count = 4
    for side in shape:
        count *= side
    with open(path, "wb") as file:
        file.write(b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header)
        file.truncate(file.tell() + count)


class EveryVerb(support.TestCase):
    """SIGINT while it works: it ends within a second or so and leaves what was there, and `may`: what the next run goes on
    from."""

    def stops(self, *arguments, after=0.3, may=(), **options):
        def took():
            before = set(self.files())
            process = subprocess.Popen([support.PROGRAM, *map(str, arguments)], stderr=subprocess.PIPE, **options)
            support.listening(process)
            time.sleep(after)
            self.assertIsNone(process.poll(), "ended before it could be stopped")
            at = time.monotonic()
            process.send_signal(signal.SIGINT)
            process.wait(timeout=60)
            gone = time.monotonic()
            message = process.stderr.read().decode()
            process.stderr.close()
            self.assertEqual(process.returncode, -signal.SIGINT, message)
            self.assertIn("stopped", message.lower())
            self.assertEqual(set(self.files()) - set(may), before - set(may))
            return gone - at

        self.assertTrue(soon(took))

    def reader_gone(self, file):
        """No process has the file open, soon."""
        end = time.monotonic() + 10
        while self.holders(file) and time.monotonic() < end:
            time.sleep(0.02)
        self.assertEqual(self.holders(file), [])

    def holders(self, file):
        found = []
        for entry in pathlib.Path("/proc").glob("[0-9]*/fd/*"):
            try:
                if os.readlink(entry) == str(file):
                    found.append(entry)
            except OSError:
                pass
        return found

    def test_info_and_compare(self):
        for name in ("a.npy", "b.npy"):
            sparse_npy(self.path(name), (20000, 64, 64, 64))
        self.stops("info", self.path("a.npy"), "--values", "--threads", 1)
        self.stops("compare", self.path("a.npy"), self.path("b.npy"), "--threads", 1)

    def test_into_a_pipe_that_nobody_reads(self):
        self.make_volute("fire.volute", frames=20, size=16)
        for command in (["extract", self.path("fire.volute")], ["synthesize", "fire"]):
            end, begin = os.pipe()
            self.stops(*command, "-o", "-", stdout=begin)
            os.close(begin)
            os.close(end)

    def test_join(self):
        values = random.Random(1)
        support.write_npy(self.path("noise.npy"), (49, 32, 32, 32), [values.random() for _ in range(32 ** 3)], times=49)
        for name, frames in (("a", "0:17"), ("b", "17:49")):
            self.works("compress", self.path("noise.npy"), "-o", self.path(f"{name}.volute"), "--frames", frames, "--rms", "0.003",
                       "--fast")
        self.stops("join", self.path("a.volute"), self.path("b.volute"), "-o", self.path("c.volute"), "--threads", 1, after=0.2)

    def test_fog(self):
        self.works("synthesize", "valley", "-o", self.path("valley"), "--pixels", "320x200", "--size", "32")
        valley = self.path("valley")
        for i in range(400):
            for name, kind in (("color", "exr"), ("depth", "exr"), ("camera", "json")):
                os.link(valley / f"{name}.{kind}", valley / f"{name}_{i:04d}.{kind}")
        self.stops("fog", valley / "fogmap.png", "--color", valley / "color_%04d.exr", "--depth", valley / "depth_%04d.exr",
                   "--camera", valley / "camera_%04d.json", "-o", self.path("foggy.mp4"), "--threads", 1)

    def test_sweep(self):
        hall = sight_cases.Mesh("hall", (0, 40, 0, 20, 0, 3), (80, 40, 6))
        sight_cases.FdsCase([hall], [10.0 * i for i in range(40)], lambda t, *_: 0.001 * t).write(self.folder, "hall")
        self.path("signs.json").write_text(json.dumps({"signs": [
            {"name": str(i), "position": [2 * i + 1, 0, 2], "normal": [0, 1, 0]} for i in range(18)]}))
        self.path("study.json").write_text(json.dumps(
            {"cases": ["hall.smv"], "options": {"signs": "signs.json", "height": 1.5, "step": 0.1}, "variants": [{"name": "a"}]}))
        self.path("out").mkdir()
        self.stops("sweep", self.path("study.json"), "-o", self.path("out"), "--threads", 1)
        self.assertEqual([name.name for name in self.path("out").iterdir() if name.name not in ("keys", "compared")], [])

    def test_bench(self):
        if not pathlib.Path(support.PROGRAM).with_name("volute-bench").exists():
            self.skipTest("there is no volute-bench")
        self.stops("bench", "codec", after=1)

    def test_visibility(self):
        sight_cases.write_vtu(self.path("a.vtu"), (20, 20, 3), (24, 24, 6), lambda x, y, z: 0.1)
        self.path("signs.json").write_text(json.dumps({"signs": [
            {"name": str(i), "position": [0.1 * i, 0, 2], "normal": [0, 1, 0]} for i in range(20)]}))
        self.stops("visibility", self.path("a.vtu"), "--quantity", "extinction", "--signs", self.path("signs.json"), "-o",
                   self.path("out"), "--step", "0.04", "--threads", 1, after=0.8)
        self.reader_gone(self.path("a.vtu"))


class OfCaptures(ring.TestCase):
    stops = EveryVerb.stops

    def test_project(self):
        for camera in self.json["cameras"]:
            camera["width"], camera["height"] = 4000, 3200
            camera["K"] = [[4200, 0, 2000], [0, 4200, 1600], [0, 0, 1]]
        self.write_capture()
        self.stops("project", self.path("truth.npy"), self.path("capture.json"), "-o", self.path("{camera}_new_%04d.exr"),
                   "--threads", 1)

    def test_reconstruct(self):
        self.stops("reconstruct", self.path("capture.json"), "-o", self.path("out.npy"), "--resolution", 160, "--threads", 1,
                   may=["out.npy.work"])


if __name__ == "__main__":
    support.main()
