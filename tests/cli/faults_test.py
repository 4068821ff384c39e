# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Full disks, failing writes, kill -9, too little memory and clocks that jump, by tests/faults.cpp: each command ends with a
sentence and leaves its target whole or not at all. A few places of each; VOLUTE_FAULT_PLACES=100 tries so many, 0 all."""
import os
import shutil
import subprocess
import unittest

import support

LIBRARY = os.environ.get("VOLUTE_FAULTS", "")
PLACES = int(os.environ.get("VOLUTE_FAULT_PLACES", "4"))


def places(count, wanted=None):
    """So many of 1..count, the first and the last among them."""
    wanted = PLACES if wanted is None else wanted
    if wanted == 0 or count <= wanted:
        return range(1, count + 1)
    return sorted({1 + round(i * (count - 1) / (wanted - 1)) for i in range(wanted)})


@unittest.skipUnless(os.path.exists(LIBRARY), "VOLUTE_FAULTS names no library")
class Faults(support.TestCase):
    def setUp(self):
        super().setUp()
        self.inputs = self.path("in")
        self.inputs.mkdir()
        support.write_npy(self.inputs / "a.npy", *support.plume(3, 12))
        self.works("compress", self.inputs / "a.npy", "-o", self.inputs / "a.volute", "--rms", "0.002")
        for name, frames in (("first", "0:1"), ("rest", "1:3")):
            self.works("compress", self.inputs / "a.npy", "-o", self.inputs / f"{name}.volute", "--rms", "0.002", "--frames", frames)
        self.out = self.path("out")

    def commands(self):
        npy, volute = self.inputs / "a.npy", self.inputs / "a.volute"
        yield ["compress", npy, "-o", self.out / "x.volute", "--rms", "0.01"]
        yield ["extract", volute, "-o", self.out / "x.npy"]
        yield ["extract", volute, "-o", self.out / "x_%04d.vdb"]
        yield ["extract", volute, "-o", self.out / "x_%04d.vti"]
        yield ["join", self.inputs / "first.volute", self.inputs / "rest.volute", "-o", self.out / "x.volute"]
        yield ["synthesize", "flame", "-o", self.out / "x.npy", "--size", "16", "--frames", "2"]
        yield ["synthesize", "ball", "-o", self.out / "x.vtu", "--cell", "2"]
        yield ["render", npy, "-o", self.out / "x.png", "--size", "16x12", "--time", "0"]
        yield ["render", npy, "-o", self.out / "x.exr", "--size", "16x12", "--time", "0", "--measured"]
        yield ["render", npy, "-o", self.out / "x_%02d.png", "--size", "16x12"]
        yield ["render", npy, "-o", self.out / "x.mp4", "--size", "16x12"]

    def run_with(self, fault, command, count=False):
        """(exit code, message, (writes, allocations))"""
        shutil.rmtree(self.out, ignore_errors=True)
        self.out.mkdir()
        read, write = os.pipe()
        preloaded = f"{os.environ.get('LD_PRELOAD', '')} {LIBRARY}".strip()
        # A program that runs out of memory within a library may wait for ever: that is a hang.
        environment = os.environ | {"LD_PRELOAD": preloaded, "VOLUTE_FAULT": fault, "VOLUTE_FAULT_FOLDER": str(self.out),
                                    "VOLUTE_FAULT_COUNT": str(write)}
        try:
            done = subprocess.run([support.PROGRAM, *map(str, command)], env=environment, pass_fds=[write], stdout=subprocess.PIPE,
                                  stderr=subprocess.PIPE, stdin=subprocess.DEVNULL, timeout=60)
        finally:
            os.close(write)
        with os.fdopen(read) as file:
            text = file.read().split()
        return done.returncode, done.stderr.decode(errors="replace"), tuple(map(int, text[:2])) if text else (0, 0)

    def written(self):
        return {entry.name: entry.read_bytes() for entry in self.out.iterdir() if entry.is_file()}

    def known(self):
        """Commands that this build has, what each writes, and how often it writes and allocates."""
        for command in self.commands():
            code, message, counts = self.run_with("none", command)
            if "this build has no" in message:
                continue
            self.assertEqual(code, 0, message)
            yield command, self.written(), counts

    def check_files(self, whole, what, numbered, parts=False):
        """What is there has all its bytes. Finished pictures of a sequence may stay."""
        for name, data in self.written().items():
            if parts and name.startswith(".") and ".part" in name:
                continue
            self.assertIn(name, whole, what)
            self.assertEqual(len(data), len(whole[name]), f"{what}: {name}")
            if not numbered:
                self.assertEqual(set(self.written()) - {name}, set(), what)

    def test_full_disks_and_failing_writes(self):
        for command, whole, (writes, _) in self.known():
            self.assertGreater(writes, 1, command)
            numbered = "%" in str(command[command.index("-o") + 1])
            for fault in ("full", "once"):
                for number in places(writes):
                    what = f"{fault}:{number} of {writes}: {' '.join(map(str, command))}"
                    with self.subTest(what):
                        code, message, _ = self.run_with(f"{fault}:{number}", command)
                        if code == 0:  # what failed was not of the output (its folder's sync, a remark)
                            self.assertEqual(set(self.written()), set(whole), what)
                        else:
                            self.assertEqual(code, 1, f"{what}: {message}")
                            self.assertRegex(message, r"No space left|Input/output error|cannot|could not", what)
                            self.assertTrue(message.startswith("volute "), what)
                        self.check_files(whole, what, numbered)

    def test_kill_at_any_write(self):
        for command, whole, (writes, _) in self.known():
            numbered = "%" in str(command[command.index("-o") + 1])
            for number in places(writes):
                what = f"kill:{number} of {writes}: {' '.join(map(str, command))}"
                with self.subTest(what):
                    self.assertEqual(self.run_with(f"kill:{number}", command)[0], -9, what)
                    self.check_files(whole, what, numbered, parts=True)
            again = support.volute(*command)
            self.assertEqual(again.code, 0, again.message)
            self.assertEqual(set(whole) - set(self.written()), set(), "the same command again")

    def test_too_little_memory(self):
        """Our own readers: those of VTK and OpenVDB are in processes of their own."""
        npy, volute = self.inputs / "a.npy", self.inputs / "a.volute"
        for command in (["info", npy, "--values"], ["info", volute],
                        ["compress", npy, "-o", self.out / "x.volute", "--rms", "0.01"],
                        ["extract", volute, "-o", self.out / "x.npy"],
                        ["render", npy, "-o", self.out / "x.png", "--size", "16x12", "--time", "0"]):
            code, message, (_, allocations) = self.run_with("none", command)
            self.assertEqual(code, 0, message)
            self.assertGreater(allocations, 2000, command)
            whole = self.written()
            # The first ones are made before main(), where libraries' own tables are filled.
            for number in (1000 + place for place in places(allocations - 1000, PLACES and 2 * PLACES)):
                what = f"memory:{number} of {allocations}: {' '.join(map(str, command))}"
                with self.subTest(what):
                    code, message, _ = self.run_with(f"memory:{number}", command)
                    self.assertIn(code, (0, 1), f"{what}: {message}")
                    if code == 1:
                        self.assertTrue(message.startswith("volute"), f"{what}: {message}")
                    self.check_files(whole, what, False)

    def test_clocks_that_jump(self):
        for command, whole, _ in self.known():
            code, message, _ = self.run_with("clock:86400", command)
            self.assertEqual(code, 0, message)
            self.assertEqual(set(self.written()), set(whole), command)

    def test_two_runs_on_one_target(self):
        for command, whole, _ in self.known():
            shutil.rmtree(self.out)
            self.out.mkdir()
            runs = [subprocess.Popen([support.PROGRAM, *map(str, command)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
                    for _ in range(2)]
            for run in runs:
                message = run.communicate(timeout=120)[1].decode()
                self.assertEqual(run.returncode, 0, message)
            self.assertEqual(set(self.written()), set(whole), command)
            self.check_files(whole, f"two runs: {command}", True)


if __name__ == "__main__":
    support.main()
