# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""A .volute file as a folder of .vdb files."""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import threading
import time
import unittest

import support

# Run inside of Blender: plays the folder given last, and prints the grids of three frames.
BLENDER_PLAYS = """
import bpy, json, os, sys
folder = sys.argv[-1]
bpy.ops.wm.read_factory_settings(use_empty=True)
names = sorted(os.listdir(folder))
bpy.ops.object.volume_import(filepath=os.path.join(folder, names[0]), directory=folder,
                             files=[{"name": name} for name in names], use_sequence_detection=True)
volume = bpy.data.volumes[0]
shown = []
for frame in (1, 2, len(names)):
    bpy.context.scene.frame_set(frame)
    object = bpy.context.scene.objects[0].evaluated_get(bpy.context.evaluated_depsgraph_get())
    grids = object.data.grids
    grids.load()
    shown.append([os.path.basename(grids.frame_filepath), [grid.name for grid in grids], grids.error_message,
                  [round(side, 4) for side in object.dimensions]])
print("PLAYED", json.dumps([volume.is_sequence, volume.frame_duration, shown]))
"""

CAN = os.access("/dev/fuse", os.R_OK | os.W_OK) and shutil.which("fusermount3")


class Refused(support.TestCase):
    def test_what_is_no_file_or_no_folder(self):
        file = self.make_volute()
        empty = self.path("empty")
        empty.mkdir()
        self.assertIn("does not end in .volute", self.fails(2, "mount", self.path("a.vdb"), empty))
        self.assertIn("is no folder", self.fails(2, "mount", file, self.path("nowhere")))
        self.assertIn("is not empty", self.fails(2, "mount", file, self.folder))
        self.assertIn("cannot open", self.fails(1, "mount", self.path("nothing.volute"), empty))
        self.assertIn("raise --max-memory", self.fails(1, "mount", self.make_volute("big.volute", size=40), empty, "--max-memory", "60K"))

    @unittest.skipUnless(os.geteuid() == 0 and shutil.which("unshare"), "another /dev needs root")
    def test_without_fuse(self):
        file = self.make_volute()
        folder = self.path("folder")
        folder.mkdir()
        hidden = f"mount -t tmpfs none /dev && exec {support.PROGRAM} mount {file} {folder}"
        done = subprocess.run(["unshare", "-m", "sh", "-c", hidden], capture_output=True, text=True)
        if "unshare" in done.stderr or "mount:" in done.stderr.split("volute")[0]:
            self.skipTest(done.stderr.strip())
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("/dev/fuse is not there", done.stderr)
        self.assertIn("volute extract", done.stderr)


@unittest.skipUnless(CAN, "there is no FUSE here: /dev/fuse or fusermount3 is missing")
class Mount(support.TestCase):
    def mount(self, file, *options):
        folder = self.path("mounted")
        folder.mkdir(exist_ok=True)
        process = subprocess.Popen([support.PROGRAM, "mount", str(file), str(folder), *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        self.addCleanup(subprocess.run, ["fusermount3", "-u", "-z", str(folder)], stderr=subprocess.DEVNULL)
        end = time.monotonic() + 30
        while not os.path.ismount(folder) and process.poll() is None and time.monotonic() < end:
            time.sleep(0.02)
        self.assertTrue(os.path.ismount(folder), process.poll() is not None and process.communicate()[1])
        return process, folder

    def is_gone(self, folder, seconds=20):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            try:
                if not os.path.ismount(folder) and os.listdir(folder) == []:
                    return True
            except OSError:
                pass  # its process has ended
            time.sleep(0.05)
        return False

    def extracted(self, file, name="extracted"):
        folder = self.path(name)
        folder.mkdir()
        self.works("extract", file, "-o", folder / (pathlib.Path(file).stem + "_%04d.vdb"))
        return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}

    def test_files_are_those_of_extract(self):
        for channels in [1, 3]:
            file = self.make_volute(f"puff{channels}.volute", frames=18, channels=channels)
            process, folder = self.mount(file)
            expected = self.extracted(file, f"extracted{channels}")
            self.assertEqual(os.listdir(folder), list(expected))
            for name, data in expected.items():
                self.assertEqual((folder / name).stat().st_size, len(data))
                self.assertEqual((folder / name).read_bytes(), data, name)
            process.send_signal(signal.SIGINT)
            _, said = process.communicate(timeout=30)
            self.assertEqual(process.returncode, 0, said)
            self.assertTrue(self.is_gone(folder))

    def test_a_rate_that_is_given_is_in_the_files(self):
        file = self.make_volute("puff.volute", frames=5)
        _, folder = self.mount(file, "--fps", "50")
        self.assertEqual(self.works("info", folder / "puff_%04d.vdb", "--json").json["times"], [0, 4 / 50])

    def test_numbers_are_those_of_the_files_it_was_made_of(self):
        self.works("extract", self.make_volute("puff.volute", frames=3), "-o", self.path("s_%d.vdb"))
        self.works("compress", self.path("s_%d.vdb"), "-o", self.path("t.volute"))
        _, folder = self.mount(self.path("t.volute"))
        self.assertEqual(os.listdir(folder), ["t_0.vdb", "t_1.vdb", "t_2.vdb"])

    def test_caches_have_all_their_grids(self):
        file = self.path("cache.volute")
        shutil.copy(pathlib.Path(__file__).parents[1] / "data" / "cache.volute", file)
        _, folder = self.mount(file)
        expected = self.extracted(file)
        self.assertEqual(os.listdir(folder), list(expected))
        for name, data in expected.items():
            self.assertEqual((folder / name).read_bytes(), data, name)

    def test_doubles_far_from_zero_stay_doubles(self):
        shape, values = support.plume(2, 9)
        support.write_npy(self.path("in.npy"), shape, [1e6 + value for value in values], code="d")
        file = self.path("far.volute")
        self.works("compress", self.path("in.npy"), "-o", file, "--max-error", "1e-3")
        _, folder = self.mount(file)
        for name, data in self.extracted(file).items():
            self.assertEqual((folder / name).read_bytes(), data, name)
        self.assertEqual([one["type"] for one in self.works("info", folder / "far_0000.vdb", "--json").json["grids"]], ["double"])

    def test_two_readers_at_once_and_little_memory(self):
        file = self.make_volute(frames=20, size=24)
        expected = self.extracted(file)
        for options in [(), ("--max-memory", "300K")]:
            process, folder = self.mount(file, *options)
            wrong = []

            def read(names):
                wrong.extend(name for name in names if (folder / name).read_bytes() != expected[name])
            readers = [threading.Thread(target=read, args=(list(expected)[::step],)) for step in (1, -1)]
            for reader in readers:
                reader.start()
            for reader in readers:
                reader.join()
            self.assertEqual(wrong, [])
            subprocess.run(["fusermount3", "-u", str(folder)], check=True)
            self.assertEqual(process.wait(timeout=30), 0)
            self.assertTrue(self.is_gone(folder))

    def test_it_is_read_only(self):
        process, folder = self.mount(self.make_volute())
        name = os.listdir(folder)[0]
        for change in [lambda: (folder / "new").touch(), lambda: (folder / name).unlink(), lambda: open(folder / name, "r+b"),
                       lambda: (folder / name).rename(folder / "other")]:
            with self.assertRaises(OSError):
                change()
        with self.assertRaises(FileNotFoundError):
            (folder / "in_9999.vdb").read_bytes()

    def test_what_is_killed(self):
        process, folder = self.mount(self.make_volute())
        name = os.listdir(folder)[0]
        reader = subprocess.Popen(["sh", "-c", f"exec 3<'{folder / name}'; exec sleep 60"])
        time.sleep(0.3)
        reader.kill()
        reader.wait()
        self.assertTrue((folder / name).read_bytes())
        # fusermount3 waits to let the folder go; without it the folder stays, and a person can.
        for entry in pathlib.Path("/proc").glob("[0-9]*/cmdline"):
            try:
                words = entry.read_bytes().split(b"\0")
            except OSError:
                continue
            if b"fusermount3" in words[0] and os.fsencode(folder) in words:
                os.kill(int(entry.parent.name), signal.SIGKILL)
        process.kill()
        process.wait()
        with self.assertRaises(OSError):
            os.listdir(folder)
        self.assertIn("fusermount3 -u", support.volute("mount", self.path("in.volute"), folder).message)
        subprocess.run(["fusermount3", "-u", str(folder)], check=True)
        self.assertTrue(self.is_gone(folder))
        self.mount(self.path("in.volute"))  # and serves again

    @unittest.skipUnless(shutil.which("blender"), "Blender is not installed")
    def test_blender_plays_it(self):
        """As it comes, without a plug-in."""
        _, folder = self.mount(self.make_volute(frames=18))
        script = self.path("play.py")
        script.write_text(BLENDER_PLAYS)
        done = subprocess.run(["blender", "--background", "--python", script, "--", folder], capture_output=True, text=True, timeout=200)
        said = [line for line in done.stdout.splitlines() if line.startswith("PLAYED")]
        self.assertEqual(len(said), 1, done.stdout + done.stderr)
        is_sequence, duration, shown = json.loads(said[0][len("PLAYED"):])
        self.assertEqual((is_sequence, duration), (True, 18))
        names = sorted(os.listdir(folder))
        for name, (file, grids, error, size) in zip((names[0], names[1], names[-1]), shown):
            self.assertEqual((file, grids, error), (name, ["density"], ""))
            self.assertGreater(min(size), 0)

    def test_memory_does_not_grow(self):
        file = self.make_volute(frames=40, size=16)
        process, folder = self.mount(file, "--max-memory", "2M")
        names = os.listdir(folder)

        def open_all(times):
            for _ in range(times):
                for name in names:
                    descriptor = os.open(folder / name, os.O_RDONLY)
                    os.read(descriptor, 100)
                    os.close(descriptor)

        def resident():
            status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
            return int(next(line for line in status.splitlines() if line.startswith("VmRSS")).split()[1]), \
                len(os.listdir(f"/proc/{process.pid}/fd"))
        open_all(5)
        before = resident()
        open_all(25)  # 1,000
        after = resident()
        self.assertLess(after[0] - before[0], 3000, "KiB")
        self.assertLessEqual(after[1], before[1] + 2)

    def test_memory_is_of_what_is_in_a_box(self):
        """Two bricks in a box of 100,000^3 voxels."""
        support.write_npy(self.path("in.npy"), (2, 8, 8, 24), [i % 7 if x % 24 // 8 != 1 else 0 for i, x in enumerate(range(2 * 64 * 24))])
        self.works("compress", self.path("in.npy"), "-o", self.path("near.volute"), "--bounds", "0,0,0,24,8,8")
        self.works("extract", self.path("near.volute"), "-o", self.path("near_%04d.vdb"))
        far = self.path("far.volute")
        self.works("compress", self.path("near_%04d.vdb"), "--bounds=-50000,-50000,-50000,50000,50000,50000", "-o", far)
        process, folder = self.mount(far)
        expected = self.extracted(far)
        self.assertEqual(len(expected), 2)
        for name, data in expected.items():
            self.assertEqual((folder / name).read_bytes(), data, name)
        status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
        peak = int(next(line for line in status.splitlines() if line.startswith("VmHWM")).split()[1])
        self.assertLess(peak, 160 << 10, "KiB")

    def test_a_damaged_block_is_an_error(self):
        file = self.make_volute(frames=18, size=20)
        data = bytearray(file.read_bytes())
        data[-20] ^= 1
        file.write_bytes(data)
        process, folder = self.mount(file)
        failed = 0
        for name in os.listdir(folder):
            try:
                (folder / name).read_bytes()
            except OSError as error:
                self.assertEqual(error.errno, 5)
                failed += 1
        self.assertGreater(failed, 0)
        process.send_signal(signal.SIGTERM)
        self.assertIn(b"checksum", process.communicate(timeout=30)[1])


if __name__ == "__main__":
    support.main()
