# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""The Python package, as its users see it."""
import ast
import concurrent.futures
import contextlib
import datetime
import decimal
import fractions
import gc
import importlib.util
import inspect
import io
import json
import logging
import os
import pathlib
import pickle
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import types
import unittest
import weakref

import numpy as np

import volute

SOURCE = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(SOURCE / "tools"))
import fds_case  # noqa: E402

COMMAND = os.environ["VOLUTE_COMMAND"]


def puff(frames=20, z=24, y=20, x=18):
    """A ball of smoke that moves along x, zero elsewhere."""
    t, z, y, x = np.meshgrid(*map(np.arange, (frames, z, y, x)), indexing="ij")
    values = np.exp(-((x - 6 - t / 4) ** 2 + (y - 9) ** 2 + (z - 12) ** 2) / 20.0)
    return np.where(values < 1e-2, 0, values).astype(np.float32)


class Package(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.path = pathlib.Path(cls.folder.name)
        cls.values = puff()
        cls.report = volute.compress(cls.values, cls.path / "puff.volute", rms=1e-3, bounds=((0, 0, 0), (1.8, 2, 2.4)), unit="1/m",
                                     times=np.arange(20) * 0.5)
        colour = np.stack([cls.values[:3], 0.5 * cls.values[:3], 0 * cls.values[:3]], axis=-1)
        volute.compress(colour, cls.path / "colour.volute", max_error=0.01)
        cls.file = str(cls.path / "puff.volute")
        cls.decoded = np.asarray(volute.open(cls.file))

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_bricks_of_a_box_beyond_all_memory(self):
        """Two bricks in a box of 100,000^3 voxels."""
        values = np.zeros((1, 8, 8, 24), np.float32)
        values[..., :8] = 1 + np.arange(8)
        values[..., 16:] = 2
        volute.compress(values, self.path / "near.volute", max_error=1e-3, bounds=((0, 0, 0), (24, 8, 8)))
        near, far = str(self.path / "near_%04d.vdb"), self.path / "far.volute"
        subprocess.run([COMMAND, "extract", self.path / "near.volute", "-o", near], check=True, capture_output=True)
        subprocess.run([COMMAND, "compress", near, "--bounds=-50000,-50000,-50000,50000,50000,50000", "-o", far, "--max-error", "1e-3"],
                       check=True, capture_output=True)
        v = volute.open(far)
        self.assertEqual(v.shape, (1, 100000, 100000, 100000))
        held = v.bricks(0)
        order = np.argsort(held.positions[:, 2])
        self.assertEqual(held.positions[order].tolist(), [[50000, 50000, 50000], [50000, 50000, 50016]])
        self.assertEqual(held.values.shape, (2, 8, 8, 8))
        self.assertTrue(held.active.all())
        np.testing.assert_allclose(held.values[order[0]], values[0, ..., :8], atol=2e-3)
        np.testing.assert_allclose(held.values[order[1]], values[0, ..., 16:], atol=2e-3)
        self.assertEqual(float(held.background), 0)
        np.testing.assert_allclose(v[0, 50000:50008, 50000:50008, 50000:50024], values[0], atol=2e-3)
        with self.assertRaisesRegex(volute.TooLarge, "v.bricks"):
            np.asarray(v)

    def test_what_a_file_says(self):
        v = volute.open(self.file)
        self.assertEqual(v.shape, (20, 24, 20, 18))
        self.assertEqual((v.ndim, v.size, v.dtype, len(v)), (4, 20 * 24 * 20 * 18, np.float32, 20))
        self.assertEqual(v.chunks, (16, 16, 16, 16))
        self.assertEqual(v.bounds, ((0, 0, 0), (1.8, 2, 2.4)))
        np.testing.assert_allclose(v.voxel_size, (0.1, 0.1, 0.1))
        np.testing.assert_array_equal(v.times, np.arange(20) * 0.5)
        self.assertEqual((v.unit, v.basis, v.target), ("1/m", "box", ("support-rms", 1e-3)))
        self.assertEqual(self.report.file_bytes, v.file_bytes)
        self.assertLessEqual(v.rms, 1e-3)
        self.assertLessEqual(abs(self.decoded - self.values).max(), v.max_error)
        self.assertEqual(volute.open(self.path / "colour.volute").shape, (3, 24, 20, 18, 3))

    def test_pictures_where_no_grid_is_the_usual_one(self):
        file = self.path / "burns.vdb"
        cache = pathlib.Path(__file__).parents[2] / "tests" / "data" / "cache.volute"
        subprocess.run([COMMAND, "extract", cache, "-o", file, "--field", "flame,temperature", "--frames", "101:102"], check=True,
                       capture_output=True)
        file.write_bytes(file.read_bytes().replace(b"flame", b"fire1").replace(b"temperature", b"temp.second"))
        scene = volute.Scene(file)
        self.assertEqual(scene.picture(size=(16, 12)).shape, (12, 16, 3))
        with self.assertRaisesRegex(volute.InvalidArgument, "which grid"):
            scene.render(size=(16, 12))
        said = scene.json
        said["media"][0]["field"] = "temp.second"
        scene.change(said)
        self.assertGreater(scene.render(size=(16, 12)).max(), 0)

    def test_grids_of_a_cache(self):
        cache = pathlib.Path(__file__).parents[2] / "tests" / "data" / "cache.volute"
        v = volute.open(cache)
        self.assertEqual(sorted(v.grids), ["density", "flame", "fuel", "solid", "temperature", "velocity"])
        self.assertEqual((v.name, v.shape[0], v.grids["density"]["half"]), ("density", 3, True))
        self.assertTrue(v.grids["fuel"]["empty"])
        self.assertEqual(v.grids["velocity"]["grid_class"], "staggered")
        velocity = v.grid("velocity")
        self.assertEqual(velocity.shape, v.grids["velocity"]["shape"])
        self.assertEqual(velocity.shape[4], 3)
        self.assertLessEqual(np.asarray(velocity).max(), velocity.value_range[1])
        np.testing.assert_array_equal(np.asarray(volute.open(cache, grid="flame")), np.asarray(v.grid("flame")))
        self.assertEqual(pickle.loads(pickle.dumps(velocity)).name, "velocity")
        with self.assertRaisesRegex(volute.NotFound, "no grid 'smoke'.*'density'"):
            v.grid("smoke")
        with self.assertRaisesRegex(volute.InvalidData, "empty"):
            v.grid("fuel")

    def test_a_grid_of_a_cache_is_taken_alone(self):
        cache = pathlib.Path(__file__).parents[2] / "tests" / "data" / "cache.volute"
        for name in ("density", "velocity", "temperature"):
            v = volute.open(cache, grid=name)
            again = volute.compress(v, self.path / "grid.volute", max_error=1e-3, provenance="cache.volute").open()
            subprocess.run([COMMAND, "compress", cache, "--field", name, "-o", self.path / "cli.volute", "--max-error", "1e-3", "--quiet"], check=True,
                           capture_output=True)
            self.assertEqual((self.path / "grid.volute").read_bytes(), (self.path / "cli.volute").read_bytes(), name)
            self.assertEqual([again.grids[name][key] for key in ("half", "grid_class")], [v.grids[name][key] for key in ("half", "grid_class")])
            np.testing.assert_array_equal(again.bricks(1).background, v.bricks(1).background)
            self.assertGreaterEqual(again.max_error, v.max_error)
        volute.resample(volute.open(cache, grid="temperature"), self.path / "grid.volute", voxel_size=0.5)
        self.assertEqual(list(volute.open(self.path / "grid.volute").grids), ["temperature"])
        volute.resample(volute.open(cache, grid="temperature"), self.path / "grid.npy", voxel_size=0.5)
        with self.assertRaisesRegex(volute.InvalidArgument, "choose one with grids") as raised:
            volute.resample(cache, self.path / "grid.npy", voxel_size=0.5, grids="density,temperature")
        self.assertIn("grids", raised.exception.hint)
        with self.assertRaisesRegex(volute.InvalidArgument, "unknown format"):
            volute.resample(cache, self.path / "grid.xyz", voxel_size=0.5)
        v = volute.open(cache, grid="temperature")
        self.assertRegex(repr(v), r"; [\d.]+ (bytes|KB) of [\d.]+ (bytes|KB), 1/")
        cut = self.path / "cut.volute"
        cut.write_bytes(pathlib.Path(self.file).read_bytes()[:-2000])
        volute.resample(volute.open(cut, partial=True), self.path / "coarse.volute", voxel_size=0.3)

    def test_turned_voxels_say_where_they_are(self):
        """A grid that is mirrored and turned: its box is that of the command, each voxel is where its matrix says, and no array pretends otherwise."""
        folder = self.path
        values = np.zeros((1, 5, 6, 7), np.float32)
        values[0, 1, 2, 3] = 1
        volute.compress(values, folder / "plain.volute", bounds=((0, 0, 0), (7, 6, 5)))
        matrix = np.array([[0, -2, 0, 10], [1, 0, 0, 20], [0, 0, -1, 30]], float)
        volute.resample(folder / "plain.volute", folder / "turned.volute", matrix=matrix)
        v = volute.open(folder / "turned.volute")
        self.assertEqual(v.matrices.shape, (1, 3, 4))
        np.testing.assert_allclose(v.voxel_size, (1, 2, 1))
        z, y, x = np.unravel_index(np.argmax(v[0]), v.shape[1:])
        np.testing.assert_allclose(v.matrices[0] @ [x, y, z, 1], (3.5, 2.5, 1.5), atol=1)
        said = json.loads(subprocess.run([sys.executable, "-m", "volute", "info", folder / "turned.volute", "--json"], capture_output=True, check=True).stdout)
        np.testing.assert_allclose(np.ravel(v.bounds), np.ravel(said["bounds"]))
        again = volute.compress(v, folder / "again.volute").open()
        np.testing.assert_array_equal(again.matrices, v.matrices)
        np.testing.assert_allclose(np.asarray(again), np.asarray(v), atol=1e-2)
        self.assertIsNone(volute.compress(v, folder / "along.volute", bounds=((0, 0, 0), (1, 1, 1))).open().matrices)
        self.assertIsNone(volute.open(folder / "plain.volute").matrices)

    def test_files_without_values(self):
        data = pathlib.Path(__file__).parents[2] / "tests" / "data"
        empty, kept = volute.open(data / "codec3_empty.volute"), volute.open(data / "codec3_kept.volute")
        self.assertEqual([(name, one["empty"]) for name, one in empty.grids.items()], [("density", True), ("velocity", True), ("surface", True)])
        self.assertEqual(kept.grids, {})
        for v in (empty, kept):
            self.assertEqual((v.shape, np.asarray(v).shape, v[0].shape), ((2, 0, 0, 0), (2, 0, 0, 0), (0, 0, 0)))
            self.assertEqual((list(v.times), list(v.frame_numbers)), ([0.5, 1], [3, 4]))
            self.assertEqual(len(v.bricks(1).positions), 0)
            v.verify()
            with self.assertRaisesRegex(volute.Unsupported, "no grid has values"):
                volute.picture(v.path, size=(16, 12))

    def test_slices_are_those_of_numpy(self):
        v = volute.open(self.file)
        for key in [0, -1, (3, 4, 5, 6), (slice(None), 4), slice(10, 20), (slice(2, 18), slice(None, None, 2), slice(3, 17)), Ellipsis,
                    (..., 5), (slice(None, None, -3), ..., slice(15, 2, -4)), (slice(5, 5), 1), [4, 1, 19], (slice(None), slice(None), [0, 19]),
                    np.arange(20) % 7 == 0, (slice(0, 3), slice(None, None, -1)), (np.int32(7), slice(16, 17))]:
            np.testing.assert_array_equal(v[key], self.decoded[key], err_msg=repr(key))
        self.assertIsInstance(v[1, 2, 3, 4], np.float32)
        c = volute.open(self.path / "colour.volute")
        all_of_it = np.asarray(c)
        for key in [1, (..., 0), (1, 5, 6, 7), (1, 5, 6, 7, 2), (slice(None), 3, ..., slice(1, 3))]:
            np.testing.assert_array_equal(c[key], all_of_it[key], err_msg=repr(key))
        # The axis of a list stays where it is, also beside numbers; NumPy would move it to the front.
        np.testing.assert_array_equal(c[2, ..., [0, 2]], all_of_it[2][..., [0, 2]])

    def test_what_is_no_index(self):
        v = volute.open(self.file)
        for key, said in [(20, "index 20 is out of bounds for axis 0 ('t') with size 20"), ((0, -25), "axis 1 ('z')"), (1.5, "whole number"),
                          ("a", "whole number"), ((0,) * 5, "too many indices"), (([0, 1], [0, 1]), "one axis alone"), ((..., ...), "ellipsis"),
                          (None, "whole number")]:
            with self.assertRaises(IndexError) as raised:
                v[key]
            self.assertIn(said, str(raised.exception))

    def test_only_blocks_that_are_touched_are_decoded(self):
        v = volute.open(self.file)  # 2 x 2 x 2 x 2 blocks
        v[3:9, :16, 17:, :10]
        self.assertEqual(v.blocks_decoded, 1)
        v[3, ::16, 0, 0]
        self.assertEqual(v.blocks_decoded, 3)
        v[[1, 17], 5, 5, 5]
        self.assertEqual(v.blocks_decoded, 5)

    def test_frames_in_order_are_decoded_together(self):
        for read in [lambda v: list(v), lambda v: [v[i] for i in range(len(v))]]:
            v = volute.open(self.file)
            for frame, expected in zip(read(v), self.decoded):
                np.testing.assert_array_equal(frame, expected)
            self.assertLessEqual(v.blocks_decoded, 32)
        without = volute.open(self.file, cache=0)
        np.testing.assert_array_equal(np.stack(list(without)), self.decoded)
        # What is given is the caller's.
        v = volute.open(self.file)
        for i in range(4):
            v[i][:] = 7
        np.testing.assert_array_equal(v[3], self.decoded[3])

    def test_at_times(self):
        v = volute.open(self.file)
        self.assertEqual([v.frame_at(t) for t in (-1, 0, 0.49, 0.5, 99)], [0, 0, 0, 1, 19])
        np.testing.assert_array_equal(v.at(1.2), self.decoded[2])

    def test_decoded_arrays_are_shared_without_copies(self):
        v = volute.open(self.file)
        frame = v[3]
        self.assertEqual(memoryview(frame).shape, frame.shape)
        np.testing.assert_array_equal(np.from_dlpack(v), self.decoded)
        self.assertTrue(np.shares_memory(np.from_dlpack(frame), frame))
        self.assertEqual(np.asarray(v, np.float64).dtype, np.float64)

    def test_dask(self):
        try:
            import dask.array  # noqa: F401
        except ImportError:
            self.skipTest("there is no python3-dask")
        array = volute.open(self.file).to_dask()
        self.assertEqual(float(array.sum()), float(array.compute().sum()))
        np.testing.assert_array_equal(array[3:17, 5].compute(), self.decoded[3:17, 5])

    def test_threads_and_processes_may_share_one(self):
        v = volute.open(self.file)
        wrong = []

        def work(seed):
            rng = np.random.default_rng(seed)
            for _ in range(40):
                t, z = int(rng.integers(20)), int(rng.integers(24))
                if not (np.array_equal(v[t], self.decoded[t]) and np.array_equal(v[t:, z], self.decoded[t:, z])):
                    wrong.append((t, z))
        threads = [threading.Thread(target=work, args=(seed,)) for seed in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(wrong, [])
        np.testing.assert_array_equal(pickle.loads(pickle.dumps(v))[5], self.decoded[5])

    def test_a_full_disk_under_frames_that_come_once(self):
        target = self.path / "full.volute"
        code = ("import resource, sys, numpy as np, volute\n"
                "resource.setrlimit(resource.RLIMIT_FSIZE, (100000, 100000))\n"
                f"try: volute.compress((np.ones((32, 32, 32), np.float32) for _ in range(4)), {str(target)!r}, max_error=.1)\n"
                "except volute.IoError as error: print(error, error.path, error.code, sep='|')\n")
        done = subprocess.run([sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}, capture_output=True, text=True)
        self.assertEqual(done.stdout, f"{self.path}: cannot write a temporary file: File too large|{self.path}|io\n", done.stderr)
        self.assertFalse(target.exists())

    def test_the_same_bytes_as_the_command(self):
        for name, values in [("f32.npy", self.values), ("f16.npy", self.values[:5].astype(np.float16)), ("one.npy", self.values[7])]:
            np.save(self.path / name, values)
            subprocess.run([COMMAND, "compress", self.path / name, "-o", self.path / "cli.volute", "--psnr", "50", "--quiet"], check=True,
                           stdout=subprocess.DEVNULL)
            for given in [values, list(values) if values.ndim == 4 else np.asfortranarray(values), np.load(self.path / name, mmap_mode="r")]:
                frames = iter(given) if isinstance(given, list) else given
                volute.compress(frames, self.path / "py.volute", psnr=50, provenance=name)
                self.assertEqual((self.path / "py.volute").read_bytes(), (self.path / "cli.volute").read_bytes(), name)

    def test_access_says_what_is_read_most(self):
        for access, frames in (("frame", 4), ("film", 16)):
            v = volute.compress(self.values, self.path / "access.volute", rms=1e-3, access=access).open()
            self.assertEqual(v.chunks[0], frames)
            whole = np.asarray(v)
            np.testing.assert_array_equal(np.stack(list(v)), whole)
            for key in (13, slice(3, 19, 5), [17, 2, 9]):
                np.testing.assert_array_equal(v[key], whole[key])
        with self.assertRaisesRegex(ValueError, "access='seldom'"):
            volute.compress(self.values, self.path / "access.volute", access="seldom")

    def test_every_type_and_layout_gives_the_same_file(self):
        whole = np.round(100 * self.values[:3])
        volute.compress(whole, self.path / "expected.volute", rms=1e-3)
        expected = (self.path / "expected.volute").read_bytes()
        gaps = np.zeros((3, 24, 40, 18), np.int16)
        gaps[:, :, ::2] = whole
        unaligned = np.frombuffer(b"x" + whole.astype("<f8").tobytes(), np.uint8)[1:].view("<f8").reshape(whole.shape)
        self.assertFalse(unaligned.flags.aligned)
        layouts = [np.asfortranarray(whole), whole[:, ::-1].copy()[:, ::-1], np.moveaxis(np.moveaxis(whole, 0, 2).copy(), 2, 0), gaps[:, :, ::2], unaligned,
                   np.ma.masked_array(whole), memoryview(np.ascontiguousarray(whole)), whole.astype(np.longdouble), list(whole)]
        for given in [whole.astype(code) for code in ("u1", "i1", ">i2", "<u4", ">i8", "u8", "f2", ">f4", "<f8", ">f8")] + layouts:
            volute.compress(given, self.path / "other.volute", rms=1e-3)
            self.assertEqual((self.path / "other.volute").read_bytes(), expected, getattr(given, "dtype", type(given)))
        flags = whole > 50
        volute.compress(flags, self.path / "flags.volute", max_error=0.1)
        np.testing.assert_allclose(np.asarray(volute.open(self.path / "flags.volute")), flags, atol=0.1)

    def test_numpys_files_are_the_same_for_the_command(self):
        whole = np.round(100 * self.values[:3])
        for code in ("|u1", ">i2", "<i8", ">f4", "<f8"):
            for order in "CF":
                array = np.array(whole, code, order=order)
                np.save(self.path / "a.npy", array)
                np.savez(self.path / "b.npz", array)
                np.savez_compressed(self.path / "c.npz", times=np.arange(3.0), heat=array)
                volute.compress(array, self.path / "py.volute", rms=1e-3, provenance="a")
                for name in ("a.npy", "b.npz", "c.npz"):
                    subprocess.run([COMMAND, "compress", self.path / name, "-o", self.path / "cli.volute", "--rms", "1e-3", "--quiet"], check=True,
                                   stdout=subprocess.DEVNULL)
                    mine, its = volute.open(self.path / "py.volute"), volute.open(self.path / "cli.volute")
                    np.testing.assert_array_equal(np.asarray(mine), np.asarray(its))
                    self.assertEqual((its.max_error, its.name), (mine.max_error, "heat" if name == "c.npz" else "density"))

    def test_the_stated_error_holds_for_doubles_or_they_are_refused(self):
        rng = np.random.default_rng(1)
        for scale in (1.0, 1e3, 1e5, 1e6, 1e9):
            doubles = scale + rng.random((2, 12, 12, 12))
            np.save(self.path / "doubles.npy", doubles)
            for target, value in (("max_error", 1e-3), ("rms", 3e-3), ("ratio", 3)):
                file = self.path / "doubles.volute"
                command = subprocess.run([COMMAND, "compress", self.path / "doubles.npy", "-o", self.path / "cli.volute", f"--{target.replace('_', '-')}",
                                          str(value), "--quiet"], capture_output=True, text=True)
                try:
                    report = volute.compress(doubles, file, provenance="doubles.npy", **{target: value})
                except volute.Unsupported as error:
                    self.assertGreater(scale, 1e6)
                    self.assertRegex(str(error), "up to .* from the nearest float32|rounding of float32")
                    self.assertEqual(command.returncode, 1)
                    continue
                self.assertEqual(command.returncode, 0, command.stderr)
                for made in (file, self.path / "cli.volute"):
                    v = volute.open(made)
                    error = abs(np.asarray(v, np.float64) - doubles)
                    self.assertEqual(v.dtype, np.float64 if scale > 8 else np.float32)
                    self.assertLessEqual(error.max(), v.max_error + np.spacing(scale))  # near 1e9 the sum rounds as double
                    if v.value_range[0] < v.value_range[1]:  # else it is of the greatest value
                        self.assertLessEqual(np.sqrt((error ** 2).mean()), v.rms * np.ptp(v.value_range) * (1 + 1e-5))
                    self.assertEqual((v.max_error, v.rms), (report.max_error, report.rms))
                    if target == "max_error":
                        self.assertLessEqual(v.max_error, value)
        # What is extracted has the source's type, and what is made of that, or of frames that come once, the same bound.
        subprocess.run([COMMAND, "extract", self.path / "cli.volute", "-o", self.path / "back.npy"], check=True, stdout=subprocess.DEVNULL)
        self.assertEqual(np.load(self.path / "back.npy").dtype, np.float64)
        million = 1e6 + rng.random((2, 12, 12, 12))
        first = volute.compress(million, self.path / "first.volute", max_error=1e-3).open()
        self.assertEqual(first.bricks(0).values.dtype, np.float64)
        for given in (first, (frame for frame in million)):
            again = volute.compress(given, self.path / "again.volute", max_error=1e-3).open()
            self.assertLessEqual(abs(np.asarray(again) - (np.asarray(first) if given is first else million)).max(), 1e-3)
        # The largest error that is possible is named, and can be asked for: of values without a middle that helps.
        million[0, :6] *= -1
        with self.assertRaises(volute.Unsupported) as raised:
            volute.compress(million, self.path / "doubles.volute", max_error=1e-3)
        possible = float(re.search(r"ask for max-error = ([0-9.e-]+)", str(raised.exception))[1])
        self.assertLessEqual(volute.compress(million, self.path / "doubles.volute", max_error=possible).max_error, possible)
        with self.assertRaisesRegex(volute.InvalidData, "1e.300 is beyond float32"):
            volute.compress(np.full((1, 2, 2, 2), 1e300), self.path / "doubles.volute")

    def test_opengl_draws_what_the_command_draws(self):
        camera = {"eye": [3, -2, 1.5], "target": [0.5, 0.5, 0.5], "fov": 35}
        try:
            scene = volute.Scene(self.file)
            drawn = scene.picture(0.4, camera=camera, size=(64, 48), renderer="gl")
        except volute.Unsupported as missing:
            self.skipTest(str(missing))
        words = ["--eye", "3,-2,1.5", "--target", "0.5,0.5,0.5", "--fov", "35", "--size", "64x48", "--time", "0.4", "--renderer", "gl", "--quiet"]
        subprocess.run([COMMAND, "render", self.file, "-o", self.path / "gl.png", *words], check=True)
        np.testing.assert_array_equal(volute.to_srgb(volute.read_image(self.path / "gl.png")).reshape(drawn.shape), drawn)
        self.assertLess(abs(scene.picture(0.4, camera=camera, size=(64, 48)).astype(int) - drawn).max(), 8)
        self.assertLess(abs(scene.render(0.4, camera=camera, size=(64, 48), renderer="gl") - scene.render(0.4, camera=camera, size=(64, 48))).max(), 1e-3)
        scene.film(self.path / "gl_%04d.png", frames=(10, 11), camera=camera, size=(64, 48), renderer="gl")
        subprocess.run([COMMAND, "render", self.file, "-o", self.path / "cli_%04d.png", "--frames", "10:11", *words[:8], *words[10:]], check=True)
        self.assertEqual((self.path / "gl_0010.png").read_bytes(), (self.path / "cli_0010.png").read_bytes())

    def test_meshes_from_arrays_are_those_of_files(self):
        line = np.linspace(0, 2, 4)
        points = np.stack(np.meshgrid(line, line, line, indexing="ij"), -1).reshape(-1, 3)
        at = np.arange(64).reshape(4, 4, 4)
        corners = [at[i:3 + i, j:3 + j, k:3 + k].ravel() for i, j, k in ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))]
        cubes = np.stack(corners, -1)
        tets = np.concatenate([cubes[:, list(t)] for t in ((0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6))])
        smoke = 1 + points @ [0.5, 0.25, 1.0]  # linear: its integrals are exact
        said = {"quantity": "extinction", "field": "smoke"}
        try:
            sight = volute.Sight(volute.Mesh(points, tets, {"smoke": smoke}), **said)
        except volute.Unsupported as missing:
            self.skipTest(str(missing))
        eye, target = np.array([0.3, -1, 0.4]), np.array([1.1, 3.0, 1.3])
        inside = np.array([eye + (target - eye) * s for s in (0.25, 0.75)])  # where y is 0 and 2
        expected = (1 + inside.mean(0) @ [0.5, 0.25, 1.0]) * np.linalg.norm(inside[1] - inside[0])
        # The mesh is not known where the line begins and ends.
        seen = sight.look(eye, target)[0]
        self.assertTrue(np.isnan(seen["depth"]) and np.isinf(seen["high"]) and not seen["covered"])
        self.assertAlmostEqual(seen["low"], expected, 4)
        self.assertAlmostEqual(sight.look(eye + (target - eye) * 0.25001, eye + (target - eye) * 0.74999)["depth"][0], expected, 3)
        view = dict(camera={"eye": [5, -4, 3], "target": [1, 1, 1], "fov": 40}, size=(48, 36), samples=1)
        for cells in (cubes, {"hexahedron": cubes[:13], "tetra": tets[(np.arange(len(tets)) % 27) >= 13]}):
            mesh = volute.Mesh(points, cells, {"smoke": smoke.astype(np.float32)})
            picture = volute.picture(mesh, **view, **said)
            self.write_vtu(points, cells if isinstance(cells, dict) else {"hexahedron": cells}, smoke)
            self.assertGreater(np.ptp(picture), 20)
            camera = ("--eye", "5,-4,3", "--target", "1,1,1", "--fov", "40", "--size", "48x36", "--samples", "1")
            subprocess.run([COMMAND, "render", self.path / "mesh.vtu", "-o", self.path / "mesh.png", *camera, "--quantity", "extinction", "--field", "smoke", "--quiet"],
                           check=True)
            np.testing.assert_array_equal(volute.to_srgb(volute.read_image(self.path / "mesh.png")).reshape(picture.shape), picture)
        # Two times, values of cells, and a scene with a volume beside it.
        mesh = volute.Mesh(points, cubes, cell_fields={"smoke": np.stack([np.ones(27), 2 * np.ones(27)])}, times=[1.0, 2.5])
        scene = volute.Scene({"format": "volute-scene-1", "camera": view["camera"], "media": [{"case": mesh, **said}, {"file": self.values[:2]}]})
        np.testing.assert_array_equal(scene.times[:2], [0, 0.04])
        looked = [volute.Sight(mesh, **said).look([1, -1, 1], [1, 3, 1], time)["low"][0] for time in (0, 1)]
        np.testing.assert_allclose(looked, [2, 4], rtol=1e-5)
        np.testing.assert_array_equal(pickle.loads(pickle.dumps(scene)).picture(2.5, size=(48, 36)), scene.picture(2.5, size=(48, 36)))
        # Temperature serves doses, as that of a file does.
        mesh = volute.Mesh(points, tets, {"smoke": smoke, "T": 300 + points[:, 0]})
        engine = volute.Engine(mesh, [{"name": "exit", "position": [1.9, 1, 1], "normal": [-1, 0, 0]}],
                               criteria=[{"kind": "temperature", "limit": 60}], **said)
        np.testing.assert_allclose(engine.dose([1], [[1.25, 1, 1]], 0)["temperature"], 301.25 - 273.15, rtol=1e-4)
        for what, arguments in (("points: shape", (points[:, :2], tets, {"a": smoke})), ("finite", (points * np.nan, tets, {"a": smoke})),
                                ("a corner is 64; there are 64 points", (points, tets + 1, {"a": smoke})), ("whole numbers", (points, tets * 1.0, {"a": smoke})),
                                ("are masked", (np.ma.masked_less(points, 0.1), tets, {"a": smoke})), ("shape \\(3,\\)", (points, tets, {"a": smoke[:3]})),
                                ("no fields", (points, tets)), ("'line'", (points, {"line": tets[:, :2]}, {"a": smoke}))):
            with self.assertRaisesRegex(ValueError, what):
                volute.Mesh(*arguments)

    def write_vtu(self, points, cells, smoke):
        def data(kind, name, values, more=""):
            return f'<DataArray type="{kind}" Name="{name}" format="ascii"{more}>{" ".join(map(str, np.ravel(values).tolist()))}</DataArray>'
        counts = np.concatenate([np.full(len(of_kind), of_kind.shape[1]) for of_kind in cells.values()])
        types = np.concatenate([np.full(len(of_kind), {"tetra": 10, "hexahedron": 12}[kind]) for kind, of_kind in cells.items()])
        (self.path / "mesh.vtu").write_text(
            f'<VTKFile type="UnstructuredGrid" version="1.0"><UnstructuredGrid><Piece NumberOfPoints="{len(points)}" NumberOfCells="{len(types)}">'
            f'<PointData>{data("Float64", "smoke", smoke)}</PointData><Points>{data("Float64", "Points", points, " NumberOfComponents=" + chr(34) + "3" + chr(34))}'
            f'</Points><Cells>{data("Int64", "connectivity", np.concatenate([np.ravel(of_kind) for of_kind in cells.values()]))}'
            f'{data("Int64", "offsets", np.cumsum(counts))}{data("UInt8", "types", types)}</Cells></Piece></UnstructuredGrid></VTKFile>')

    def test_axes_have_the_same_names_in_files_and_arrays(self):
        plugin = SOURCE / "src/volute/io/gdal_plugin.cpp"
        named = re.findall(r'\{"(\w+)", (\d)\}', plugin.read_text())
        self.assertEqual({(name, "tzyxc"[int(axis)]) for name, axis in named},
                         {(name, axis) for axis, names in volute._arrays._AXES.items() for name in names})

    def test_masked_values_never_become_data(self):
        mask = self.values[:3] > 0.5
        masked = np.ma.masked_array(np.where(mask, 1e20, self.values[:3]).astype(np.float32), mask=mask)

        class Wrapper:  # as netCDF libraries give arrays
            shape = masked.shape

            def __getitem__(self, key):
                return masked[key]
        for given in (masked, masked[1], iter(masked), Wrapper(), masked.astype(np.float64), [masked[0], self.values[1], masked[2]]):
            v = volute.compress(given, self.path / "masked.volute", max_error=1e-3).open()
            for index in range(len(v)):
                expected = masked[1 if given.__class__ is type(masked) and given.ndim == 3 else index]
                if isinstance(given, list) and index == 1:
                    expected = np.ma.masked_array(self.values[1])
                back = v.masked(index)
                np.testing.assert_array_equal(np.ma.getmaskarray(back), np.ma.getmaskarray(expected))
                self.assertLess(abs(v[index] - expected.filled(0)).max(), 1.1e-3)
                self.assertLess(abs(back - expected).max(), 1.1e-3)
        counts = np.ma.masked_array(np.where(mask, -32768, np.round(100 * self.values[:3])).astype(np.int16), mask=mask)
        back = volute.compress(counts, self.path / "counts.volute", max_error=0.4).open().masked(2)
        np.testing.assert_array_equal(np.rint(back), counts[2])
        self.assertEqual(np.ma.count_masked(back), mask[2].sum())
        million = np.ma.masked_array(np.where(mask, 1e20, 1e6 + self.values[:3].astype(np.float64)), mask=mask)
        v = volute.compress(million, self.path / "million.volute", max_error=1e-3).open()
        self.assertLess(abs(v.masked(1) - million[1]).max(), 1e-3)
        # NaN for masked values, as xarray has them: only where that is said.
        holes = masked.filled(np.nan)
        with self.assertRaisesRegex(volute.InvalidData, "not a number.*not_finite"):
            volute.compress(holes, self.path / "holes.volute")
        np.testing.assert_array_equal(volute.compress(holes, self.path / "holes.volute", not_finite="inactive").open().masked(1).mask, mask[1])
        np.save(self.path / "holes.npy", holes)
        subprocess.run([COMMAND, "compress", self.path / "holes.npy", "-o", self.path / "cli.volute", "--not-finite", "inactive", "--quiet"], check=True)
        np.testing.assert_array_equal(volute.open(self.path / "cli.volute").masked(1).mask, mask[1])
        other = masked.copy()
        other.data[2, 0, 0, 0] = np.inf
        other.mask[2, 0, 0, 0] = False
        for given in (other, iter(other)):
            with self.assertRaisesRegex(ValueError, "frame 2 has values that are not finite and not masked.*masked_invalid"):
                volute.compress(given, self.path / "infinite.volute")
        self.assertFalse((self.path / "infinite.volute").exists())
        for target in ({"max_error": 1e-3}, {"psnr": 60}):
            plain = volute.compress(masked.filled(0), self.path / "plain.volute", **target).open().masked(1)
            np.testing.assert_array_equal(np.ma.getmaskarray(plain), masked[1].filled(0) == 0 if "max_error" in target else False)
        # A voxel is there, or is not.
        colours, parts = np.ones((2, 4, 4, 4, 3), np.float32), np.zeros((2, 4, 4, 4, 3), bool)
        parts[1, :2, ..., 0] = True
        red = np.ma.masked_array(colours, mask=parts)
        for call in (lambda: volute.compress(red, self.path / "red.volute"), lambda: volute.compress(iter(red), self.path / "red.volute"),
                     lambda: volute.picture(red, size=(8, 8))):
            with self.assertRaisesRegex(ValueError, "(the array|frame 1): 32 voxels are masked in some of their channels alone"):
                call()
        parts[...] = parts.any(axis=-1, keepdims=True)
        self.assertEqual(np.ma.count_masked(volute.compress(np.ma.masked_array(colours, mask=parts), self.path / "red.volute").open().masked(1)), 96)
        # What is not there is not seen.
        np.testing.assert_array_equal(volute.picture(masked, size=(40, 30)), volute.picture(masked.filled(0), size=(40, 30)))
        scene = {"format": "volute-scene-1", "media": [{"kind": "volume", "file": masked}]}
        np.testing.assert_array_equal(volute.Scene(scene).render(0.0, size=(40, 30)), volute.Scene(masked).render(0.0, size=(40, 30)))
        for call in (lambda: volute.write_image("a.png", masked[1, 12]),
                     lambda: volute.Sight(self.file).look(np.ma.masked_array([[1, 1, 1.0]], [[0, 0, 1]]), [2, 1, 1])):
            with self.assertRaisesRegex(ValueError, "masked"):
                call()

    def test_what_is_not_finite_can_be_left_out(self):
        values = self.values[:1].copy()
        values[0, 3, 3, 3], values[0, 4, 4, 4] = np.nan, -np.inf
        filled = np.where(np.isfinite(values), values, 0)
        options = {"size": (24, 18), "extinction": 1.0}
        expected = volute.picture(filled, **options)
        for given in (values, values.astype(np.float64), np.asfortranarray(values), [frame for frame in values]):
            with self.assertRaisesRegex(volute.InvalidData, "not a number|infinite"):
                volute.picture(given, **options)
            for way in ("inactive", "background"):
                np.testing.assert_array_equal(volute.picture(given, not_finite=way, **options), expected)
        volute.compress(values, self.path / "background.volute", not_finite="background", max_error=1e-3)
        np.testing.assert_allclose(volute.open(self.path / "background.volute"), filled, atol=1.1e-3)
        for call in (lambda **how: volute.picture(values, **how), lambda **how: volute.compress(values, self.path / "no.volute", **how)):
            with self.assertRaisesRegex(ValueError, "'refuse', 'inactive' or 'background'"):
                call(not_finite="leave")
        with self.assertRaisesRegex(volute.InvalidArgument, "size: 1099511627776 x 2 pixels"):
            volute.picture(filled, size=(1 << 40, 2))
        with self.assertRaisesRegex(volute.TooLarge, "beyond what a volume can hold"):
            volute.picture(volute.Function(lambda x, y, z, t: x, (1 << 33, 1, 1), bounds=((0, 0, 0), (1, 1, 1))))

    def test_labels_of_an_array(self):
        class Coordinate:
            def __init__(self, values, units=""):
                self.values, self.attrs = np.asarray(values), {"units": units}

        class Labelled:  # what of an xarray.DataArray is used
            def __init__(self, data, dims, coords, name=None, units=None):
                self.data, self.dims, self.coords, self.name = data, dims, coords, name
                self.attrs = {"units": units} if units else {}

            def transpose(self, *dims):
                return Labelled(self.data.transpose([self.dims.index(one) for one in dims]), dims, self.coords)
        values = self.values[:3]
        x, y, z = (np.arange(18) + 0.5) * 0.1, (np.arange(20) + 0.5) * 0.1, (np.arange(24) + 0.5) * 0.1 + 5
        coords = {"x": Coordinate(x), "y": Coordinate(y), "z": Coordinate(z), "time": Coordinate([1.0, 2.0, 4.0], "s")}
        plain = volute.compress(values, self.path / "plain.volute", bounds=((0, 0, 5), (1.8, 2, 7.4)), times=[1, 2, 4], name="soot", unit="g/m3")
        backwards = {**coords, "z": Coordinate(z[::-1] * 100, "cm"),
                     "time": Coordinate(np.datetime64("2026-01-01") + np.array([1, 2, 4]) * np.timedelta64(1, "s"))}
        for array in (Labelled(values.transpose(3, 0, 2, 1), ("x", "time", "y", "z"), coords, "soot", "g/m3"),
                      Labelled(values[:, ::-1], ("time", "z", "y", "x"), backwards, "soot", "g/m3")):
            labelled = volute.compress(array, self.path / "labelled.volute").open()
            np.testing.assert_array_equal(np.asarray(labelled), np.asarray(plain.open()))
            np.testing.assert_allclose(labelled.bounds, plain.open().bounds)
            self.assertEqual((labelled.name, labelled.unit), ("soot", "g/m3"))
            np.testing.assert_allclose(np.diff(labelled.times), [1, 2])
        one = volute.compress(Labelled(values[1], ("z", "y", "x"), {**coords, "time": Coordinate(2.0)}), self.path / "labelled.volute").open()
        self.assertEqual(list(one.times), [2])
        for dims, more, said in [(("time", "lev", "y", "x"), {}, "rename them"), (("time", "y", "z", "x"), {"z": Coordinate(z[:20] ** 2)}, "not evenly spaced"),
                                 (("time", "z", "y", "x"), {"x": Coordinate(x, "degrees_east")}, "expected metres, or give bounds"),
                                 (("time", "z", "y", "x"), {"time": Coordinate([1, 2, 3], "weeks")}, "expected seconds, or give times")]:
            with self.assertRaisesRegex(ValueError, said):
                volute.compress(Labelled(values, dims, {**coords, **more}), self.path / "labelled.volute")
        given = volute.compress(Labelled(values, ("time", "z", "y", "x"), {"x": Coordinate(x, "degrees_east")}), self.path / "labelled.volute",
                                bounds=((0, 0, 0), (1, 1, 1))).open()
        self.assertEqual(given.bounds, ((0, 0, 0), (1, 1, 1)))

    def test_lazy_arrays_are_computed_once(self):
        values = self.values

        class Lazy:
            def __init__(self, chunks=None):
                self.shape, self.asked = values.shape, []
                if chunks:
                    self.chunks = chunks

            def __getitem__(self, key):
                self.asked += list(range(20))[key] if isinstance(key, slice) else [key]
                return values[key]
        volute.compress(values, self.path / "expected.volute", rms=1e-3)
        for lazy in (Lazy(), Lazy(chunks=((7, 7, 6), (24,), (20,), (18,))), Lazy(chunks=(8, 24, 20, 18))):
            with self.assertLogs("volute", "INFO") as log:
                volute.compress(lazy, self.path / "lazy.volute", rms=1e-3)
            self.assertEqual(lazy.asked, list(range(20)))
            self.assertIn("frames are kept in a file without a name", log.output[0])
            self.assertEqual((self.path / "lazy.volute").read_bytes(), (self.path / "expected.volute").read_bytes())

    def test_what_is_no_number_or_array(self):
        for options, said in [({"size": "500K"}, "size='500K': expected a number of bytes"), ({"rms": None, "psnr": [1]}, "psnr=.*expected a number"),
                              ({"max_memory": "4G"}, "max_memory='4G': expected a number")]:
            with self.assertRaisesRegex(TypeError, said):
                volute.compress(self.values, self.path / "refused.volute", **options)
        for values, said in [(5, "5: expected an array"), (self.values.astype(complex), "magnitude"), (self.values.astype(object), "astype"),
                             (self.values.astype("M8[s]"), "real numbers")]:
            with self.assertRaisesRegex(TypeError, said):
                volute.compress(values, self.path / "refused.volute")
        with self.assertRaisesRegex(ValueError, "bounds=.*expected"):
            volute.compress(self.values, self.path / "refused.volute", bounds=(1, 2))
        with self.assertRaisesRegex(ValueError, "none of them empty"):
            volute.compress(np.zeros((2, 0, 3, 4)), self.path / "refused.volute")
        report = volute.compress(self.values, self.path / "numbers.volute", size=np.float32(30000), max_memory=np.int64(1 << 30))
        self.assertLessEqual(report.file_bytes, 30000)

    def test_files_can_be_closed_and_sent(self):
        with volute.open(self.file) as v:
            first = v[0]
        np.testing.assert_array_equal(first, self.decoded[0])
        with self.assertRaisesRegex(ValueError, "puff.volute is closed"):
            v[1]
        v.close()
        cut = self.path / "cut_to_two_thirds.volute"
        data = pathlib.Path(self.file).read_bytes()
        cut.write_bytes(data[:2 * len(data) // 3])
        partial = volute.open(cut, partial=True, max_memory=1 << 28, cache=0)
        copy = pickle.loads(pickle.dumps(partial))
        np.testing.assert_array_equal(copy[3], partial[3])
        self.assertEqual(copy._options, {"partial": True, "max_memory": 1 << 28, "cache": 0})
        with volute.Scene(self.file, emission=1.0) as scene:
            scene.render(size=(8, 6))
        for call in (scene.render, scene.picture, lambda: scene.times):
            with self.assertRaisesRegex(ValueError, "closed"):
                call()

    def test_threads_can_be_limited(self):
        all_of_them = volute.set_threads(1)
        self.assertEqual(volute.set_threads(), 1)
        self.assertEqual(volute.set_threads(0), all_of_them)
        with self.assertRaisesRegex(ValueError, "0 or more"):
            volute.set_threads(-1)

    def test_the_interpreter_ends_while_threads_work(self):
        program = """
import threading, time, sys
import numpy as np, volute
values = np.random.default_rng(1).random((32, 48, 48, 48), np.float32)
volute.set_threads(1)
def work(i):
    while True:
        volute.compress(values, f"{sys.argv[1]}/end{i}.volute", rms=1e-4)
for i in range(2):
    threading.Thread(target=work, args=(i,), daemon=True).start()
time.sleep(float(sys.argv[2]))
"""
        for wait in ("0", "0.1", "0.3", "0.6", "0.9"):
            ended = subprocess.run([sys.executable, "-c", program, self.path, wait], capture_output=True, text=True, timeout=60)
            self.assertEqual((ended.returncode, ended.stderr), (0, ""))
        self.assertEqual([name for name in os.listdir(self.path) if name.startswith("end")], [])

    def test_compressing_a_file_again_keeps_what_it_says(self):
        again = volute.compress(volute.open(self.file), self.path / "again.volute", ratio=200).open()
        first = volute.open(self.file)
        self.assertEqual((again.bounds, again.unit, list(again.times)), (first.bounds, first.unit, list(first.times)))

    def test_what_cannot_be_compressed(self):
        nan = self.values[:2].copy()
        nan[1, 2, 3, 4] = np.nan
        target = self.path / "refused.volute"
        for values, options, type_, said in [
                (nan, {}, volute.InvalidData, "frame 1, voxel (4, 3, 2)"), (self.values[0, 0], {}, ValueError, "expected (z, y, x)"),
                (self.values, {"rms": 1, "psnr": 3}, ValueError, "exclude each other"), (self.values, {"rms": -1}, ValueError, "above 0"),
                (self.values, {"times": [1, 2]}, ValueError, "2 of them for 20 frames"),
                (self.values[:2], {"times": [2, 1]}, volute.InvalidData, "time"),
                (self.values[:2], {"bounds": ((0, 0, 0), (0, 1, 1))}, volute.Error, "bounds"),
                (np.array([["a"]]), {}, ValueError, "shape"), (iter([]), {}, ValueError, "no frames"),
                (iter([self.values[0], self.values[0, 1:]]), {}, ValueError, "frame 1 has shape"),
                (np.full((1, 2, 2, 2), "a"), {}, TypeError, "numbers"), (self.values, {"wavelet": "db4"}, ValueError, "cdf97")]:
            with self.assertRaises(type_) as raised:
                volute.compress(values, target, **options)
            self.assertIn(said, str(raised.exception))
            self.assertFalse(target.exists())
        with self.assertRaisesRegex(ValueError, "does not end in .volute"):
            volute.compress(self.values, "a.npy")

    def test_modules_for_other_packages_are_there_without_an_import(self):
        code = """
import volute
for name in ("xarray", "numcodecs", "hdf5", "vtk"):
    try:
        print(getattr(volute, name).__name__)
    except ImportError:
        print("volute." + name)
print(hasattr(volute, "nothing"))"""
        said = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
        self.assertEqual(said, ["volute.xarray", "volute.numcodecs", "volute.hdf5", "volute.vtk", "False"])

    def test_errors_are_the_librarys_sentences(self):
        with self.assertRaisesRegex(FileNotFoundError, "nothing.volute: cannot open") as raised:
            volute.open("nothing.volute")
        self.assertIsInstance(raised.exception, volute.NotFound)
        data = pathlib.Path(self.file).read_bytes()
        cut = self.path / "cut.volute"
        cut.write_bytes(data[:-40])
        with self.assertRaisesRegex(volute.Truncated, "is truncated"):
            volute.open(cut)
        self.assertEqual(volute.open(cut, partial=True).shape, (20, 24, 20, 18))
        flipped = bytearray(data)
        flipped[-30] ^= 1
        cut.write_bytes(flipped)
        with self.assertRaisesRegex(volute.InvalidData, "checksum"):
            np.asarray(volute.open(cut))
        with self.assertRaisesRegex(volute.InvalidData, "checksum"):
            volute.open(cut).verify()
        volute.open(self.file).verify()

    def test_progress_and_what_it_raises(self):
        reports = []
        volute.compress(self.values[:4], self.path / "small.volute", progress=lambda *said: reports.append(said))
        self.assertTrue(any(done == total for _, done, total in reports))
        self.assertTrue(all(isinstance(stage, str) for stage, _, _ in reports))

        def stop(stage, done, total):
            raise RuntimeError("that will do")
        with self.assertRaisesRegex(RuntimeError, "that will do"):
            volute.compress(self.values, self.path / "stopped.volute", progress=stop)
        self.assertEqual([name for name in os.listdir(self.path) if "stopped" in name], [])
        with self.assertRaises(TypeError):
            volute.compress(self.values, self.path / "stopped.volute", progress=3)

    def test_a_bar_by_tqdm_or_lines_in_the_log(self):
        class Bar:
            made = []

            def __init__(self, total, desc, leave):
                self.total, self.stage, self.n, self.open = total, desc, 0, True
                Bar.made.append(self)

            def update(self, more):
                self.n += more

            def close(self):
                self.open = False
        kept = {name: sys.modules.get(name) for name in ("tqdm", "tqdm.auto")}
        try:
            sys.modules["tqdm"] = types.ModuleType("tqdm")
            sys.modules["tqdm.auto"] = types.ModuleType("tqdm.auto")
            sys.modules["tqdm.auto"].tqdm = Bar
            volute.compress(self.values[:4], self.path / "small.volute", progress=True)
            self.assertGreater(len(Bar.made), 1)
            self.assertEqual([bar.stage for bar in Bar.made if bar.open or bar.n != bar.total], [])
            sys.modules["tqdm"] = sys.modules["tqdm.auto"] = None  # not installed
            with self.assertLogs("volute", "WARNING") as log:
                volute.compress(self.values[:4], self.path / "small.volute", progress=True)
            self.assertIn("compressing", log.output[-1])
        finally:
            for name, module in kept.items():
                if module is None:
                    sys.modules.pop(name, None)
                else:
                    sys.modules[name] = module

    def test_ctrl_c_stops_every_long_call(self):
        capture = self.capture()
        scene = volute.Scene(self.file, extinction=1.0, emission=0.5)
        for name, call in [("render", lambda: scene.render(3.0, size=(6000, 6000), renderer="reference")),
                           ("reconstruct", lambda: volute.reconstruct(capture, resolution=(160, 160, 160), iterations=500)),
                           ("look", lambda: volute.Sight(self.file, extinction=1.0).look(np.random.default_rng(1).random((4_000_000, 3)), [2, 2, 2])),
                           ("read", lambda: [np.asarray(volute.open(self.file, cache=0)) for _ in range(100000)])]:
            timer = threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT))
            began = time.monotonic()
            timer.start()
            with self.assertRaises(KeyboardInterrupt, msg=name):
                call()
            self.assertLess(time.monotonic() - began, 10, name)

    def test_ctrl_c_stops_and_other_threads_go_on(self):
        values = np.random.default_rng(1).random((64, 64, 64, 64), np.float32)
        counted = [0]
        stop = threading.Event()

        def count():
            while not stop.wait(0.01):
                counted[0] += 1
        thread = threading.Thread(target=count)
        thread.start()
        threading.Timer(0.7, os.kill, (os.getpid(), signal.SIGINT)).start()
        began = time.monotonic()
        with self.assertRaises(KeyboardInterrupt):
            volute.compress(values, self.path / "long.volute", rms=1e-4)
        stop.set()
        thread.join()
        self.assertLess(time.monotonic() - began, 20)
        self.assertGreater(counted[0], 5)
        self.assertEqual([name for name in os.listdir(self.path) if "long" in name], [])

    def test_what_notebooks_show(self):
        v = volute.open(self.file)
        said = repr(v)
        for part in ["puff.volute", "density [1/m]", "20 frames of 18 x 20 x 24 voxels", "0 to 9.5 s", "(0, 0, 0) to (1.8, 2, 2.4) m"]:
            self.assertIn(part, said)
        page = v._repr_html_()
        self.assertIn("data:image/png;base64,", page)
        self.assertIn("(20, 24, 20, 18)", page)
        self.assertIn("relative RMS", page)
        self.assertIn("1/", repr(self.report))

    def test_pictures(self):
        scene = volute.Scene(self.file, extinction=1.0, emission=0.5)
        self.assertEqual(scene.media[0][2], "18 x 20 x 24 voxels, 20 frames")
        self.assertEqual(scene.bounds, ((0, 0, 0), (1.8, 2, 2.4)))
        np.testing.assert_allclose(scene.times, np.arange(20) * 0.5)
        camera = {"eye": [-3, 1, 1.2], "target": [1, 1, 1.2], "ortho": 2.4}
        reports = []
        picture = scene.render(3.0, camera=camera, size=(60, 48), progress=lambda *said: reports.append(said))
        self.assertEqual((picture.shape, picture.dtype), ((48, 60, 3), np.float32))
        self.assertGreater(picture.max(), 0.05)
        np.testing.assert_array_equal(picture, volute.render(scene, 3.0, camera=camera, size=(60, 48)))
        # Sums along x are optical depths.
        depth = scene.render(3.0, camera=camera, size=(40, 48), aov="optical-depth")
        self.assertEqual(depth.shape, (48, 40))
        along = 0.1 * self.decoded[6].sum(axis=2)
        np.testing.assert_allclose(depth[1::2, 1::2][::-1, ::-1], along, atol=1e-4)
        reference = scene.render(3.0, camera=camera, size=(60, 48), renderer="reference")
        np.testing.assert_allclose(picture, reference, atol=1e-4)
        self.assertIn("data:image/png", scene._repr_html_())
        self.assertIn("puff.volute", repr(scene))

    def test_a_picture_is_that_of_the_command(self):
        volute.write_image(self.path / "py.exr", volute.render(self.file, 2.0, size=(80, 60)))
        subprocess.run([COMMAND, "render", self.file, "-o", self.path / "cli.exr", "--time", "2", "--size", "80x60", "--renderer", "cpu", "--measured", "--quiet"],
                       check=True, stdout=subprocess.DEVNULL)
        np.testing.assert_array_equal(volute.read_image(self.path / "py.exr"), volute.read_image(self.path / "cli.exr"))
        white = np.ones((2, 3, 3), np.float32)
        volute.write_image(self.path / "white.png", white)
        np.testing.assert_array_equal(volute.read_image(self.path / "white.png"), white)
        self.assertEqual(volute.to_srgb([0.0, 0.5, 9.0]).tolist(), [0, 188, 255])

    def test_a_shutter_blurs_what_moves(self):
        said = {"size": (40, 30), "exposure": 1.0, "emission": 1.0, "interpolate": "linear"}
        blurred = volute.picture(self.file, 1.0, shutter=0.5, **said)
        self.command("render", self.file, "-o", self.path / "blurred.png", "--time", 1, "--size", "40x30", "--exposure", 1, "--emission", 1,
                     "--interpolate", "linear", "--shutter", 0.5, "--renderer", "cpu")
        self.assert_pixels(blurred, self.path / "blurred.png")
        self.assertTrue((blurred != volute.picture(self.file, 1.0, **said)).any())
        with self.assertRaisesRegex(ValueError, "shutter=2.0: expected 0 to 1"):
            volute.picture(self.file, shutter=2)

    def test_other_voxels(self):
        volute.resample(self.file, self.path / "coarse.npy", voxel_size=0.2, frames=(0, 2), grids=["density"])
        self.command("resample", self.file, "-o", self.path / "coarse_cli.npy", "--voxel-size", 0.2, "--frames", "0:2")
        coarse = np.load(self.path / "coarse.npy")
        np.testing.assert_array_equal(coarse, np.load(self.path / "coarse_cli.npy"))
        self.assertEqual(coarse.shape[0], 2)
        volute.resample(volute.open(self.file), self.path / "box.volute", bounds=((0, 0, 0), (0.9, 1, 1.2)), rms=1e-2)
        self.assertEqual(volute.open(self.path / "box.volute").shape, (20, 12, 10, 9))
        for wrong in ({"voxel_size": 0}, {"bounds": [0, 1]}, {"like": self.file, "bounds": ((0, 0, 0), (1, 1, 1))}, {"rms": 2}, {"basis": "round"}):
            with self.assertRaises(ValueError):
                volute.resample(self.file, self.path / "no.npy", **wrong)

        def stop(stage, done, total):
            raise KeyboardInterrupt
        with self.assertRaises(KeyboardInterrupt):
            volute.resample(self.file, self.path / "no.npy", voxel_size=0.05, progress=stop)
        self.assertFalse((self.path / "no.npy").exists())

    def command(self, *arguments):
        subprocess.run([COMMAND, *map(str, arguments), "--quiet"], check=True, stdout=subprocess.DEVNULL)

    def assert_pixels(self, picture, file):
        """Whether a picture has the bytes of a .png."""
        (self.path / "mine.png").write_bytes(volute._volume._png(picture))
        np.testing.assert_array_equal(volute.read_image(self.path / "mine.png"), volute.read_image(file))

    def test_a_picture_of_values_is_that_of_the_command(self):
        np.save(self.path / "values.npy", self.values)
        view = ["--size", "60x48", "--renderer", "cpu"]
        self.command("render", self.path / "values.npy", "-o", self.path / "values.png", *view)
        self.command("render", self.path / "values.npy", "-o", self.path / "values.exr", *view, "--time", "0.2")
        self.command("render", self.path / "values.npy", "-o", self.path / "shown.png", *view, "--emission", "0.4", "--exposure", "2", "--tone", "agx",
                     "--samples", "4", "--bloom", "0.1", "--time", "0.2", "--background", "0.1,0.2,0.3")
        for source in (self.values, self.path / "values.npy", self.values.astype(np.float64), np.asfortranarray(self.values), list(self.values)):
            picture = volute.picture(source, size=(60, 48))
            self.assertEqual((picture.shape, picture.dtype), ((48, 60, 3), np.uint8))
            self.assert_pixels(picture, self.path / "values.png")
            np.testing.assert_array_equal(volute.render(source, 0.2, size=(60, 48), measured=False), volute.read_image(self.path / "values.exr"))
            shown = volute.picture(source, 0.2, size=(60, 48), exposure=2, tone="agx", samples=4, bloom=0.1, background=np.array([0.1, 0.2, 0.3]),
                                   emission=np.float64(0.4))
            self.assert_pixels(shown, self.path / "shown.png")
        self.command("render", self.file, "-o", self.path / "puff.png", *view, "--colormap", "inferno", "--preset", "none")
        for source in (self.file, volute.open(self.file)):
            self.assert_pixels(volute.picture(source, size=(60, 48), colormap="inferno", preset="none"), self.path / "puff.png")

    def test_depths_are_those_of_the_command(self):
        """They were 0 where nothing said an extinction."""
        np.save(self.path / "depth.npy", self.decoded[6])
        for aov in ("optical-depth", "transmittance"):
            self.command("render", self.path / "depth.npy", "-o", self.path / "depth.exr", "--aov", aov, "--measured", "--size", "24x18")
            expected = volute.read_image(self.path / "depth.exr")
            self.assertGreater(np.ptp(expected), 0.1)
            for source in (self.path / "depth.npy", self.decoded[6]):
                np.testing.assert_allclose(volute.render(source, aov=aov, size=(24, 18)), expected, rtol=1e-5, atol=1e-6)
        scene = volute.Scene(self.decoded[6], extinction=2.0)
        np.testing.assert_allclose(scene.render(aov="optical-depth", size=(24, 18)), 2 * volute.render(self.decoded[6], aov="optical-depth", size=(24, 18)), rtol=1e-5)

    def test_values_are_a_medium(self):
        bounds = ((0, 0, 0), (1.8, 2, 2.4))
        times = np.arange(20) * 0.5
        camera = {"eye": np.array([-3, 1, 1.2]), "target": np.float32([1, 1, 1.2]), "ortho": np.float64(2.4)}
        np.save(self.path / "decoded.npy", self.decoded)
        scene = volute.Scene(self.decoded, bounds=bounds, times=times, extinction=np.float32(1))
        self.assertEqual(scene.bounds, bounds)
        np.testing.assert_array_equal(scene.times, times)
        depth = scene.render(3.0, camera=camera, size=(40, 48), aov="optical-depth")
        np.testing.assert_allclose(depth[1::2, 1::2][::-1, ::-1], 0.1 * self.decoded[6].sum(axis=2), atol=1e-4)
        sight = volute.Sight(self.decoded, bounds=bounds, times=times, extinction=1.0)
        np.testing.assert_array_equal(sight.look([-1, 1, 1.2], [3, 1, 1.2], time=6), volute.Sight(self.file, extinction=1.0).look([-1, 1, 1.2], [3, 1, 1.2], time=6))
        # Beside a file, in one scene; what is given again is read again.
        values = self.decoded.copy()
        said = {"format": "volute-scene-1", "camera": camera, "media": [
            {"kind": "volume", "file": values, "bounds": bounds, "times": times, "extinction": 1.0},
            {"kind": "volume", "file": self.file, "extinction": 1.0}]}
        both = volute.Scene(said)
        np.testing.assert_allclose(both.render(3.0, size=(40, 48), aov="optical-depth"), 2 * depth, rtol=1e-4, atol=1e-4)
        values *= 3
        both.change(said)
        np.testing.assert_allclose(both.render(3.0, size=(40, 48), aov="optical-depth"), 4 * depth, rtol=1e-4, atol=1e-4)
        with self.assertRaisesRegex(ValueError, "expected \\(z, y, x\\)"):
            volute.Scene(np.zeros((3, 4)))
        with self.assertRaisesRegex(ValueError, "not finite"):
            volute.Scene(self.decoded, extinction=np.nan)
        for one in (2, np.float16(2), np.longdouble(2), np.array(2, "g"), np.uint8(2)):
            wide = volute.Scene(self.decoded, bounds=bounds, times=times, extinction=one)
            np.testing.assert_allclose(wide.render(3.0, camera=camera, size=(40, 48), aov="optical-depth"), 2 * depth, rtol=1e-5, atol=1e-6)
        shades = [0.1, 0.2, 0.3]
        np.testing.assert_array_equal(*(volute.Scene(self.decoded, extinction=1, albedo=albedo).render(size=(8, 8)) for albedo in (shades, np.array(shades, "g"))))
        for one in (np.complex64(1), np.clongdouble(1), np.ones(3, "G"), np.datetime64("2020")):
            with self.assertRaisesRegex(TypeError, "scenes have numbers, texts, lists and dicts"):
                volute.Scene(self.decoded, extinction=one)
        with self.assertRaisesRegex(TypeError, "Ellipsis"):
            volute.Scene(self.decoded, extinction=...)
        self.assertIn(b"PNG", scene._repr_png_()[:8])

    def test_comparisons_tell_of_another_basis(self):
        for basis in ("box", "cubic"):
            volute.compress(self.decoded, self.path / f"{basis}.volute", max_error=1e-3, basis=basis)
        said = subprocess.run([COMMAND, "compare", self.path / "box.volute", self.path / "cubic.volute"], check=True, capture_output=True, text=True).stderr
        self.assertIn("one is over the box basis and the other over the cubic one", said)

    def test_values_hide_by_what_they_say(self):
        """No line of sight goes through smoke as through clear air because nobody said what it is."""
        ones = np.ones((1, 8, 8, 8), np.float32)
        bounds, line = ((0, 0, 0), (1, 1, 1)), ([-1, 0.5, 0.5], [2, 0.5, 0.5])
        for unit, depth in (("1/m", 1), ("1/cm", 100), ("m-1", 1)):
            volute.compress(ones, self.path / "own.volute", max_error=1e-4, bounds=bounds, unit=unit)
            for sight in (volute.Sight(ones, bounds=bounds, unit=unit), volute.Sight(self.path / "own.volute")):
                self.assertAlmostEqual(sight.look(*line)["depth"][0], depth, delta=1e-3 * depth)
                self.assertIn("is taken as the extinction", sight.remarks[0])
            camera = {"eye": [-1, 0.5, 0.5], "target": [2, 0.5, 0.5], "ortho": 0.1}
            entry = {"kind": "volume", "file": ones, "bounds": bounds, "unit": unit}
            for shown in (volute.Scene(ones, bounds=bounds, unit=unit), volute.Scene(self.path / "own.volute"),
                          volute.Scene({"format": "volute-scene-2", "media": [entry]}),
                          volute.Scene({"format": "volute-scene-2", "media": [entry | {"preset": "smoke"}]})):
                found = shown.render(camera=camera, size=(2, 2), aov="optical-depth")
                np.testing.assert_allclose(found, depth, rtol=1e-3)
                np.testing.assert_allclose(shown.render(camera=camera, size=(2, 2), aov="transmittance"), np.exp(-found), atol=1e-6)
        for unit in ("", "kg/m3", "radiance/m"):
            with self.assertRaisesRegex(volute.InvalidArgument, "it would hide nothing; give extinction") as raised:
                volute.Sight(ones, bounds=bounds, unit=unit)
            self.assertEqual(raised.exception.member, "extinction")
            if unit:
                with self.assertRaisesRegex(volute.InvalidArgument, "it would hide nothing; give extinction"):
                    volute.render(ones, bounds=bounds, unit=unit, aov="optical-depth")
        self.assertEqual(volute.Sight(ones, bounds=bounds, emission=1.0).look(*line)["depth"][0], 0)
        half = ones.copy()
        half[..., 4:] = -1
        with self.assertRaisesRegex(volute.InvalidData, "frame 0: values go from -1 to 1"):
            volute.Sight(half, bounds=bounds, extinction=1.0).look(*line)
        half[..., 4:] = -0.01  # as solvers and compression leave it
        self.assertEqual(volute.Sight(half, bounds=bounds, extinction=1.0).look(*line)["depth"][0], 0.5)
        scene = {"format": "volute-scene-2", "media": [{"kind": "volume", "file": ones, "bounds": bounds, "extinction": 1.0},
                                                       {"kind": "volume", "file": half, "bounds": bounds}]}
        with volute.Sight(scene) as sight:
            self.assertEqual(sight.look(*line)["depth"][0], 1)
            self.assertRegex(sight.remarks[0], "/media/1 takes no light away")
            copy = pickle.loads(pickle.dumps(sight))
        with self.assertRaisesRegex(ValueError, "closed"):
            sight.look(*line)
        self.assertEqual(copy.look(*line)["depth"][0], 1)
        exit_sign = [{"name": "exit", "position": [2, 0.5, 0.5], "normal": [-1, 0, 0], "emitting": True}]
        with volute.Engine(scene, exit_sign) as engine:
            self.assertEqual(engine.sees([-1, 0.5, 0.5], 0)["exit"], engine.SEEN)

    def test_lines_are_values(self):
        bounds = ((0, 0, 0), (1, 1, 1))
        smoke = np.zeros((1, 8, 8, 8), np.float32)
        smoke[0, 2:6, 2:6, 2:6] = 2
        places = np.random.default_rng(1).random((400, 3)) * 2 - 0.5
        begin, end = np.tile(places, (3, 1)), np.tile(places[::-1], (3, 1))
        for axis in range(3):
            begin[400 * axis:400 * (axis + 1), axis], end[400 * axis:400 * (axis + 1), axis] = -1, 2
        depth = volute.Sight(smoke, bounds=bounds, unit="1/m").look(begin, end)["depth"]
        meets = depth > 0
        lines = volute.Lines(begin[meets], end[meets], depth[meets])
        found = volute.reconstruct(lines, bounds=bounds, resolution=8)
        self.assertLess(abs(found.values - smoke).mean(), 0.02)
        self.assertEqual((found.name, found.unit, found.bounds), ("extinction", "1/m", bounds))
        again = volute.Sight(found).look(begin[meets], end[meets])["depth"]
        self.assertLess(abs(again - depth[meets]).max(), 0.02)
        written = volute.reconstruct(lines, self.path / "lines.volute", bounds=bounds, resolution=8, rms=1e-4)
        np.testing.assert_allclose(np.asarray(written.values), found.values, atol=0.02)
        np.testing.assert_array_equal(volute.picture(found, size=(16, 12)),
                                      volute.picture(found.values, bounds=bounds, name="extinction", unit="1/m", size=(16, 12)))
        with open(self.path / "lines.csv", "w") as file:
            file.write("x0,y0,z0,x1,y1,z1,optical_depth\n")
            np.savetxt(file, np.column_stack([begin, end, depth])[meets], "%.17g", delimiter=",")
        np.testing.assert_allclose(volute.reconstruct(self.path / "lines.csv", bounds=bounds, resolution=8).values, found.values, atol=1e-6)
        twice = volute.Lines(begin[meets], end[meets], depth[meets], time=0.5 * (np.arange(meets.sum()) % 2))
        np.testing.assert_array_equal(volute.reconstruct(twice, bounds=bounds, resolution=4).times, [0, 0.5])
        for wrong in ({"depth": [1, np.nan]}, {"end": [[0, 0, 0], [0, 0, 1]]}, {"sigma": [1, 0]}, {"begin": np.zeros((3, 3))}, {"depth": []}):
            with self.assertRaises(ValueError):
                volute.Lines(**{"begin": np.zeros((2, 3)), "end": np.ones((2, 3)), "depth": [1, 1], **wrong})
        with self.assertRaisesRegex(TypeError, "no option 'solver'"):
            volute.reconstruct(lines, solver="sirt")

    @unittest.skipUnless(importlib.util.find_spec("vtkmodules"), "without python3-vtk9")
    def test_images_and_grids_of_vtk_are_values(self):
        from vtkmodules.util.numpy_support import numpy_to_vtk
        from vtkmodules.vtkCommonCore import vtkPoints
        from vtkmodules.vtkCommonDataModel import vtkImageData, vtkUnstructuredGrid
        values = self.decoded[6]
        bounds = ((1, 0, 0), (2.8, 2, 2.4))
        options = {"size": (24, 18), "extinction": 1.0}
        expected = volute.picture(values, bounds=bounds, name="soot", **options)
        for cells in (0, 1):
            image = vtkImageData()
            image.SetDimensions(*(side + cells for side in values.shape[::-1]))
            image.SetSpacing(0.1, 0.1, 0.1)
            image.SetOrigin(1 + 0.05 * (1 - cells), 0.05 * (1 - cells), 0.05 * (1 - cells))
            array = numpy_to_vtk(values.ravel())
            array.SetName("soot")
            (image.GetCellData() if cells else image.GetPointData()).AddArray(array)
            np.testing.assert_allclose(volute.Scene(image).bounds, bounds)
            np.testing.assert_array_equal(volute.picture(image, **options), expected)
        other = numpy_to_vtk(2 * values.ravel())
        other.SetName("heat")
        image.GetCellData().AddArray(other)
        with self.assertRaisesRegex(ValueError, "'soot', 'heat'; say name="):
            volute.Scene(image)
        self.assertEqual(volute.compress(image, self.path / "vtk.volute", name="heat", max_error=1e-3).open().name, "heat")
        grid, points = vtkUnstructuredGrid(), vtkPoints()
        corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1.0]])
        points.SetData(numpy_to_vtk(corners))
        grid.SetPoints(points)
        for cell in ([0, 1, 2, 3], [1, 2, 3, 4]):
            grid.InsertNextCell(10, 4, cell)
        at_points, of_cells = numpy_to_vtk(np.arange(5.0)), numpy_to_vtk(np.array([1.0, 3.0]))
        at_points.SetName("soot"), of_cells.SetName("thick")
        grid.GetPointData().AddArray(at_points), grid.GetCellData().AddArray(of_cells)
        own = volute.Mesh(corners, [[0, 1, 2, 3], [1, 2, 3, 4]], {"soot": np.arange(5.0)}, cell_fields={"thick": [1.0, 3.0]})
        copy = pickle.dumps(own)
        line = [0.1, 0.1, -1], [0.6, 0.6, 2]
        for field in ("soot", "thick"):
            looked = [volute.Sight(mesh, quantity="extinction", field=field).look(*line)["low"][0] for mesh in (own, grid, pickle.loads(copy))]
            self.assertGreater(looked[0], 0)
            self.assertEqual(looked, 3 * looked[:1])

    @unittest.skipUnless(importlib.util.find_spec("vtkmodules"), "without python3-vtk9")
    def test_grids_of_vtk_are_read_as_their_files(self):
        from vtkmodules.util.numpy_support import numpy_to_vtk
        from vtkmodules.vtkCommonCore import vtkIdList, vtkPoints
        from vtkmodules.vtkCommonDataModel import vtkUnstructuredGrid
        corners = np.array([[x, y, z] for z in (0, 1.0) for y in (0, 1.0) for x in (0, 1.0, 2, 3)])
        voxel = np.array([0, 1, 4, 5, 8, 9, 12, 13])
        faces = [[0, 4, 5, 1], [8, 9, 13, 12], [0, 1, 9, 8], [4, 12, 13, 5], [0, 8, 12, 4], [1, 5, 13, 9]]

        def made(kind, ghost=None):
            grid, points = vtkUnstructuredGrid(), vtkPoints()
            points.SetData(numpy_to_vtk(np.concatenate([corners, [[9, 9, 9]]]), deep=1))  # and one that no cell has
            grid.SetPoints(points)
            for x in range(3):
                if kind == 42:
                    ids = vtkIdList()
                    for number in [6, *(n for face in faces for n in [4, *(v + x for v in face)])]:
                        ids.InsertNextId(number)
                    grid.InsertNextCell(42, ids)
                else:
                    grid.InsertNextCell(11, 8, list(voxel + x))
            grid.InsertNextCell(9, 4, [0, 1, 5, 4])
            of_cells = numpy_to_vtk(np.array([1.0, 1, 1, 7]), deep=1)
            of_cells.SetName("thick")
            grid.GetCellData().AddArray(of_cells)
            if ghost:
                marks = numpy_to_vtk(np.array([0, ghost, 0, 0], np.uint8), deep=1)
                marks.SetName("vtkGhostType")
                grid.GetCellData().AddArray(marks)
            return volute.Mesh(grid)
        line = [0.1, 0.4, 0.3], [2.9, 0.4, 0.3]
        for kind in (11, 42):
            seen = volute.Sight(made(kind), quantity="extinction").look(*line)
            self.assertAlmostEqual(seen["depth"][0], 2.8, 5)
            self.assertFalse(seen["blocked"][0])
        for ghost in (1, 32):
            self.assertTrue(volute.Sight(made(11, ghost), quantity="extinction").look(*line)["blocked"][0])

    def test_scenes_are_sent_to_processes(self):
        scene = volute.Scene({"format": "volute-scene-2", "media": [{"kind": "volume", "file": self.decoded, "extinction": 1.0},
                                                                    {"kind": "volume", "file": volute.open(self.file), "emission": 1.0}]})
        expected = scene.picture(2.0, size=(24, 18))
        np.testing.assert_array_equal(pickle.loads(pickle.dumps(scene)).picture(2.0, size=(24, 18)), expected)
        alone = volute.Scene(self.file, emission=2.0)
        np.testing.assert_array_equal(pickle.loads(pickle.dumps(alone)).picture(2.0, size=(24, 18)), alone.picture(2.0, size=(24, 18)))
        scene.close()
        with self.assertRaisesRegex(ValueError, "closed"):
            pickle.dumps(scene)

    def test_a_function_cannot_use_what_waits_for_it(self):
        """These waited for each other for ever."""
        program = """
import numpy as np, volute
bounds = ((0, 0, 0), (1, 1, 1))
for use in (lambda: scene.picture(size=(8, 6)), lambda: scene.render(0, size=(8, 6))):
    scene = None
    def value(x, y, z, t):
        if scene:
            use()
        return x
    scene = volute.Scene(volute.Function(value, (8, 8, 8), bounds=bounds, times=[0, 1]), extinction=1.0)
    try:
        scene.picture(1.0, size=(8, 6))
        print("drawn")
    except volute.InvalidArgument as error:
        print(error)
still = volute.Scene(np.ones((8, 8, 8)))
try:
    still.picture(size=(8, 6), progress=lambda *said: still.picture(size=(8, 6)))
except volute.InvalidArgument as error:
    print(error)
volute.picture(volute.Function(lambda x, y, z, t: x + still.picture(size=(8, 6)).mean(), (8, 8, 8), bounds=bounds), size=(8, 6))
"""
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stdout.splitlines(), 3 * ["the scene is in use by a call that waits for this function; use another one in it"])

    def test_arrays_are_not_copied_for_a_picture(self):
        program = """
import resource, sys
import numpy as np, volute
values = np.zeros((40, 64, 64, 64), np.float32)
values[:, 20:40, 20:40, 20:40] = 1
volute.picture(values[:1], size=(40, 30), emission=1.0)
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
scene = volute.Scene(values, emission=1.0)
for time in range(3):
    scene.picture(time / 25, size=(40, 30))
print(1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before), values.nbytes)
"""
        more, own = map(int, subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout.split())
        self.assertLess(more, 0.5 * own)

    def test_light_of_values_takes_a_few_times_their_memory(self):
        """Of a volume that is full, the values' bricks, corners with light and shares of a lamp; it was 14 times."""
        program = """
import re, numpy as np, volute
def kept(key):
    return 1024 * int(re.search(key + r":\\s*(\\d+)", open("/proc/self/status").read())[1])
x = np.arange(160, dtype=np.float32)
values = 1.01 + np.sin(x / 9) * np.cos(x[:, None] / 7) * np.sin(x[:, None, None] / 11)
volute.picture(values[:8, :8, :8].copy(), size=(40, 30), preset="smoke")
open("/proc/self/clear_refs", "w").write("5")
before = kept("VmRSS")
volute.picture(values, size=(40, 30), preset="smoke")
print(kept("VmHWM") - before, values.nbytes)
"""
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
        if "PermissionError" in done.stderr or "FileNotFoundError" in done.stderr:
            self.skipTest("the peak of a process's memory cannot be set back here")
        more, own = map(int, done.stdout.split())
        self.assertLess(more, 9 * own)

    def test_scenes_in_threads_after_fork_and_at_the_end(self):
        program = """
import os, sys, threading
import numpy as np, volute

def value(x, y, z, t):
    return np.exp(-(x * x + y * y + z * z))

bounds = ((-2, -2, -2), (2, 2, 2))
for source in (value(*np.meshgrid(*[np.linspace(-2, 2, 16)] * 3), 0).astype("f4"), volute.Function(value, (16, 16, 16), bounds=bounds)):
    said = {} if isinstance(source, volute.Function) else {"bounds": bounds}
    scene = volute.Scene(source, extinction=1.0, **said)
    first = scene.picture(size=(32, 24))
    found = []
    threads = [threading.Thread(target=lambda: found.append((scene.picture(size=(32, 24)) == first).all())) for _ in range(4)]
    [thread.start() for thread in threads], [thread.join() for thread in threads]
    assert found == [True] * 4, found
    child = os.fork()
    if child == 0:
        os._exit(0 if (scene.picture(size=(32, 24)) == first).all() else 3)
    assert os.waitpid(child, 0)[1] == 0

def draw():
    try:
        while True:
            scene.picture(size=(64, 48))
    except ValueError:
        pass  # closed

threads = [threading.Thread(target=draw) for _ in range(2)]
[thread.start() for thread in threads]
scene.close()
[thread.join() for thread in threads]
scene = volute.Scene(volute.Function(value, (64, 64, 64), bounds=bounds), extinction=1.0)
threading.Thread(target=lambda: [scene.picture(size=(320, 240)) for _ in range(1000)], daemon=True).start()
print("done", flush=True)
"""
        for _ in range(3):
            done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120)
            self.assertEqual((done.returncode, done.stdout), (0, "done\n"), done.stderr)

    def test_a_changed_array_is_read_again(self):
        array = puff(2, 12, 12, 12)
        options = {"bounds": ((0, 0, 0), (1, 1, 1)), "extinction": 3.0}
        scene = volute.Scene(array, **options)
        before = scene.picture(size=(16, 12))
        array *= 0.25
        scene.touch()
        after = scene.picture(size=(16, 12))
        np.testing.assert_array_equal(after, volute.picture(array, size=(16, 12), **options))
        self.assertTrue((after != before).any())
        scene.close()
        with self.assertRaisesRegex(ValueError, "closed"):
            scene.touch()
        # Masks, and values that are left out, may change with the others: they are no copies that stay.
        for masked in (np.ma.masked_array(array), np.ma.masked_array(array, mask=np.zeros(array.shape, bool)), np.ma.masked_less(array, 1e-3)):
            scene = volute.Scene(masked, **options)
            masked[:, :6] = np.ma.masked
            masked.data[:, 8:] *= 2
            self.assertTrue((scene.picture(size=(16, 12)) != volute.picture(masked, size=(16, 12), **options)).any())
            scene.touch()
            np.testing.assert_array_equal(scene.picture(size=(16, 12)), volute.picture(masked, size=(16, 12), **options))
        wild = array.copy()
        for number in (1.0, np.nan):
            wild[0, 6, 6, 6] = number
            scene = volute.Scene({"format": "volute-scene-2", "media": [{"kind": "volume", "file": wild, "not_finite": "background", "name": "a", **options}]})
            wild[0, 4, 4, 4], wild[:, 6:] = np.nan, 0.5
            scene.touch("a")
            np.testing.assert_array_equal(scene.render(size=(16, 12)), volute.Scene(wild, not_finite="background", **options).render(size=(16, 12)))
        # Of several, the one that is named alone.
        asked = []

        def value(x, y, z, t):
            asked.append(t)
            return x

        other = volute.Function(value, (8, 8, 8), bounds=options["bounds"], name="other")
        said = {"format": "volute-scene-2", "media": [{"kind": "volume", "file": array, "name": "mine", **options},
                                                      {"kind": "volume", "file": other, "emission": 0.1}]}
        scene = volute.Scene(said)
        before = scene.picture(size=(16, 12))
        array *= 4
        asked.clear()
        scene.touch("mine")
        after = scene.picture(size=(16, 12))
        self.assertEqual(asked, [])
        self.assertTrue((after != before).any())
        np.testing.assert_array_equal(after, volute.picture(said, size=(16, 12)))
        with self.assertRaisesRegex(ValueError, "name='nobody': expected 'memory:1' or 'memory:2' or 'mine' or 'other'"):
            scene.touch("nobody")
        former = scene.json
        scene.touch("mine")
        with self.assertRaisesRegex(FileNotFoundError, "/media/0/file: the scene has no array 'memory:.*'.*give the array itself") as raised:
            scene.change(former)
        self.assertIsNone(raised.exception.filename)
        scene.change(scene.json)

    def test_films_of_functions_end_with_what_they_raise(self):
        def value(x, y, z, t):
            if t > 0.05:
                raise KeyError("the third frame")
            return np.exp(-x * x)

        function = volute.Function(value, (12, 12, 12), bounds=((0, 0, 0), (1, 1, 1)), times=np.arange(4) / 25)
        with self.assertRaisesRegex(KeyError, "third"):
            volute.film(function, self.path / "stop_%04d.png", size=(16, 12), extinction=1.0)

    def test_functions_are_volumes(self):
        batches = []

        def value(x, y, z, t):
            batches.append(len(x))
            return np.exp(-((x - t) ** 2 + y ** 2 + z ** 2))

        bounds = ((-1, -1, -1), (2, 1, 1))
        function = volute.Function(value, (12, 14, 40), bounds=bounds, times=(0, 0.5), name="heat")
        x, y, z = (low + (np.arange(n) + 0.5) * (high - low) / n for low, high, n in ((-1, 2, 40), (-1, 1, 14), (-1, 1, 12)))
        array = np.stack([value(*np.meshgrid(z, y, x, indexing="ij")[::-1], t) for t in (0, 0.5)]).astype(np.float32)
        np.testing.assert_allclose(function[1], array[1], rtol=1e-6)
        batches.clear()
        options = {"size": (40, 30), "extinction": 1.0}
        of_function = volute.picture(function, 0.5, **options)
        np.testing.assert_array_equal(of_function, volute.picture(array, 0.5, bounds=bounds, times=(0, 0.5), name="heat", **options))
        self.assertEqual(set(batches), {12 * 14 * 40})
        self.assertGreater(volute.Sight(function, extinction=1.0).look([[-2, 0, 0]], [[3, 0, 0]])["depth"][0], 1)
        self.assertEqual(volute.compress(function, self.path / "f.volute", max_error=1e-3).open().shape, (2, 12, 14, 40))
        np.testing.assert_allclose(volute.open(self.path / "f.volute")[1], array[1], atol=1.1e-3)
        colour = volute.Function(lambda x, y, z, t: np.stack([x, y, z], axis=1) ** 2, (8, 8, 8), bounds=bounds, channels=3)
        self.assertEqual(volute.picture(colour, size=(8, 6)).shape, (6, 8, 3))

    def test_what_functions_do_wrong_ends_the_call(self):
        class Stop(Exception):
            pass

        def stop(x, y, z, t):
            raise Stop("enough")

        bounds = ((0, 0, 0), (1, 1, 1))
        with self.assertRaisesRegex(Stop, "enough"):
            volute.picture(volute.Function(stop, (8, 8, 8), bounds=bounds))
        with self.assertRaisesRegex(Stop, "enough"):
            volute.compress(volute.Function(stop, (8, 8, 8), bounds=bounds), self.path / "stop.volute")
        self.assertFalse((self.path / "stop.volute").exists())
        for wrong, sentence in ((lambda x, y, z, t: 1.0, r"returned shape \(\); expected \(512,\)"), (lambda x, y, z, t: x[:-1], "returned shape"),
                                (lambda x, y, z, t: np.where(x > 0.5, np.nan, y), r"is nan at \(0.5625, 0.0625, 0.0625\) m, 0 s"),
                                (lambda x, y, z, t: 1 / np.zeros_like(x), "is inf at")):
            with self.assertRaisesRegex(ValueError, sentence), np.errstate(all="ignore"):
                volute.picture(volute.Function(wrong, (8, 8, 8), bounds=bounds))
        with self.assertRaisesRegex(TypeError, "complex"):
            volute.picture(volute.Function(lambda x, y, z, t: x + 1j, (8, 8, 8), bounds=bounds))
        masked = volute.Function(lambda x, y, z, t: np.ma.masked_less(np.where(x < 0.5, -999, x), -900), (8, 8, 8), bounds=bounds)
        for call in (lambda: masked[0], lambda: volute.picture(masked), lambda: volute.compress(masked, self.path / "masked.volute")):
            with self.assertRaisesRegex(ValueError, "the function's values: 256 of 512 values are masked"):
                call()
        with self.assertRaisesRegex(TypeError, "expected a function"):
            volute.Function(3, (8, 8, 8), bounds=bounds)
        with self.assertRaisesRegex(ValueError, "expected \\(z, y, x\\)"):
            volute.Function(stop, 8, bounds=bounds)

    def test_kinds_of_media(self):
        class Slab:
            def __init__(self, top, colour):
                self.top, self.colour = top, colour

            def bounds(self):
                return (-1, -1, 0), (1, 1, self.top)

            def pieces(self, segments, time):
                with np.errstate(all="ignore"):
                    faces = (np.array([[-1, -1, 0], [1, 1, self.top]])[:, np.newaxis] - segments["origin"]) / segments["direction"]
                begin = np.maximum(np.fmin(*faces).max(axis=1), segments["begin"])
                end = np.minimum(np.fmax(*faces).min(axis=1), segments["end"])
                met = np.flatnonzero(begin < end)
                return volute.pieces(met, begin[met], end[met], 0.5, np.tile(self.colour, (len(met), 1)))

        members = {"top": volute.Member(1.0, "m", minimum=0.1), "colour": volute.Member((1, 0.5, 0.25), minimum=0)}
        volute.medium("slab", "a slab", members=members)(Slab)
        scene = {"format": "volute-scene-2", "media": [{"kind": "slab", "top": 2}]}
        camera = {"eye": [0.1, 0.05, 5], "target": [0.1, 0.05, 0], "up": [0, 1, 0], "ortho": 0.1}
        light = volute.render(scene, camera=camera, size=(8, 8))
        np.testing.assert_allclose(light, np.broadcast_to((1 - np.exp(-1)) / 0.5 * np.array([1, 0.5, 0.25]), (8, 8, 3)), rtol=1e-5)
        depth = volute.render(scene, camera=camera, size=(8, 8), aov="optical-depth")
        np.testing.assert_allclose(depth, 1.0, rtol=1e-5)
        with self.assertRaisesRegex(volute.InvalidData, "/media/0/top"):
            volute.Scene({"format": "volute-scene-2", "media": [{"kind": "slab", "top": 0}]})
        # Registered anew, it is replaced; and what goes wrong ends the call as itself.
        for wrong, error, sentence in ((lambda self, s, t: 1 / 0, ZeroDivisionError, "division"), (lambda self, s, t: s, TypeError, "volute.PIECE"),
                                       (lambda self, s, t: volute.pieces([0], 1, -1), volute.InvalidData, "is empty"),
                                       (lambda self, s, t: volute.pieces([len(s)], 0, 1), volute.InvalidData, "of segment")):
            volute.medium("slab", members=members)(type("Wrong", (Slab,), {"pieces": wrong}))
            with self.assertRaisesRegex(error, sentence):
                volute.picture(scene, size=(40, 30))
        def everywhere(extinction):
            return lambda self, s, t: volute.pieces(np.arange(len(s)), s["begin"], s["end"], extinction)
        volute.medium("slab", members=members)(type("Below", (Slab,), {"pieces": everywhere(-0.1)}))
        with self.assertRaisesRegex(volute.InvalidData, "extinction of -0.1/m; expected at least 0"):
            volute.render(scene, size=(8, 6))
        volute.medium("slab", members=members)(type("Rounded", (Slab,), {"pieces": everywhere(-1e-18)}))
        self.assertEqual(abs(volute.render(scene, size=(8, 6), aov="optical-depth")).max(), 0)
        volute.medium("slab", members=members)(type("Half", (Slab,), {"values": lambda self, p, t: np.full(len(p), 0.25)}))
        self.assertTrue(volute.check_medium({"kind": "slab"}))
        with self.assertRaisesRegex(TypeError, "no method bounds"):
            volute.medium("slab")(dict)
        with self.assertRaisesRegex(volute.InvalidArgument, "Volute has a kind 'fog' itself"):
            volute.medium("fog")(Slab)

    def test_bytes_are_files(self):
        array = puff(5, 12, 11, 10)
        data = volute.to_bytes(array, max_error=1e-3, unit="1/m")
        volute.compress(array, self.path / "same.volute", max_error=1e-3, unit="1/m")
        self.assertEqual(data, (self.path / "same.volute").read_bytes())
        for given in (data, bytearray(data), memoryview(data), io.BytesIO(data)):
            with volute.open(given) as v:
                self.assertEqual((v.shape, v.unit), (array.shape, "1/m"))
                np.testing.assert_allclose(v[...], array, atol=1.001e-3)
                again = pickle.loads(pickle.dumps(v))
            np.testing.assert_array_equal(again[2], volute.open(data)[2])
        self.assertEqual(volute.Scene(volute.open(data)).picture(size=(8, 6)).shape[:2], (6, 8))
        with self.assertRaises(volute.Error):
            volute.open(data[:100])

    def test_xarray(self):
        try:
            import volute.xarray
            import xarray
        except ImportError:
            self.skipTest("no xarray")
        array = puff(5, 12, 11, 10)
        volute.compress(array, self.path / "x.volute", max_error=1e-3, bounds=((0, 0, 0), (10, 11, 12)), unit="1/m", name="soot")
        data = xarray.open_dataset(self.path / "x.volute", engine=volute.xarray.Backend)
        self.assertEqual((dict(data.sizes), data["soot"].attrs["units"]), ({"t": 5, "z": 12, "y": 11, "x": 10}, "1/m"))
        np.testing.assert_allclose(data["soot"].sel(t=0.08, x=3.5), array[2, :, :, 3], atol=1.001e-3)
        self.assertEqual(data["soot"][1:3, [2, 5], 4, [1, 2]].shape, (2, 2, 2))
        again = volute.compress(data["soot"], self.path / "again.volute", max_error=1e-3).open()
        self.assertEqual((again.bounds, again.unit, list(again.times)), (((0, 0, 0), (10, 11, 12)), "1/m", list(volute.open(self.path / "x.volute").times)))
        self.assertGreater(again.max_error, volute.open(self.path / "x.volute").max_error)
        data.close()
        cache = pathlib.Path(__file__).parents[2] / "tests" / "data" / "cache.volute"
        data = xarray.open_dataset(cache, engine=volute.xarray.Backend)
        for name in ("temperature", "velocity"):
            v = volute.open(cache, grid=name)
            again = volute.compress(data[name], self.path / "again.volute", max_error=1e-3).open()
            self.assertEqual((again.shape, again.up, again.frame_numbers.tolist()), (v.shape, v.up, v.frame_numbers.tolist()))
            np.testing.assert_allclose(again.bounds, v.bounds)
            np.testing.assert_array_equal(again.times, v.times)
        if importlib.util.find_spec("netCDF4"):
            data.to_netcdf(self.path / "cache.nc")
            self.command("compress", self.path / "cache.nc", "--field", "velocity", "-o", self.path / "of_nc.volute", "--max-error", 1e-3)
            of_nc = volute.open(self.path / "of_nc.volute")
            self.assertEqual((of_nc.shape, of_nc.bounds, list(of_nc.times)), (v.shape, v.bounds, list(v.times)))
        dimension = data["velocity"].dims[0]
        part = volute.compress(data["velocity"].isel({dimension: [0, 2]}), self.path / "again.volute", max_error=1e-3).open()
        self.assertEqual(part.frame_numbers.tolist(), v.frame_numbers[[0, 2]].tolist())
        with self.assertRaisesRegex(volute.InvalidArgument, "would be replaced"):
            shutil.copy(cache, self.path / "lazy.volute")
            volute.compress(xarray.open_dataset(self.path / "lazy.volute", engine=volute.xarray.Backend)["density"], self.path / "lazy.volute")
        data.close()
        given = xarray.DataArray(array[:2], dims=("time", "level", "lat", "lon"))
        with self.assertRaisesRegex(ValueError, "rename them$"):
            volute.compress(given, self.path / "again.volute")
        with self.assertRaisesRegex(ValueError, r"array.rename\(y_m='y'\)"):
            volute.compress(given.rename(lat="y_m"), self.path / "again.volute")
        stated = given.assign_coords({name: (name, np.arange(n) + 0.5, {"axis": axis}) for name, n, axis in
                                      (("level", 12, "Z"), ("lat", 11, "Y"), ("lon", 10, "X"))})
        self.assertEqual(volute.compress(stated, self.path / "again.volute").open().bounds, ((0, 0, 0), (10, 11, 12)))

    def test_numcodecs(self):
        try:
            import volute.numcodecs
        except ImportError:
            self.skipTest("no numcodecs")
        codec = volute.numcodecs.Volute(max_error=1e-2)
        for kind in ("f2", "f4", "f8", "i2", "u1", ">f4"):
            for shape in ((16, 20, 20, 20), (20, 20, 20), (50,), (2, 3, 8, 8, 8)):
                for order in "CF":
                    array = np.asarray(np.random.default_rng(0).random(shape) * 100, kind, order)
                    back = codec.decode(codec.encode(array))
                    self.assertEqual((back.dtype, back.shape, back.flags.f_contiguous), (array.dtype, shape, array.flags.f_contiguous))
                    self.assertLessEqual(np.abs(back.astype(float) - array.astype(float)).max(), 1e-2)
        with self.assertRaises(ValueError):
            codec.encode(np.array([1, np.nan]))

    @unittest.skipUnless(importlib.util.find_spec("h5py"), "without python3-h5py")
    def test_hdf5(self):
        try:
            import volute.hdf5
            volute.hdf5.Volute()
        except ImportError as error:
            self.skipTest(str(error))
        import h5py
        name = self.path / "chunks.h5"
        arrays = {"f4": self.values, "f8": 1e6 + self.values.astype("f8"), ">f4": self.values.astype(">f4"), "i2": np.round(100 * self.values).astype("i2"),
                  ">u4": np.round(1000 * self.values).astype(">u4"), "plane": self.values[0, 12], "five": np.stack([self.values[:4]] * 2)}
        with h5py.File(name, "w") as file:
            for key, array in arrays.items():
                chunks = (4, 12, 20, 18)[-array.ndim:] if array.ndim < 5 else (1, 4, 12, 20, 18)
                file.create_dataset(key, data=array, chunks=chunks, **volute.hdf5.Volute(max_error=1e-3))
            file.create_dataset("look", data=self.values, chunks=(20, 24, 20, 18), **volute.hdf5.Volute())
            far = np.stack([np.full((4, 4, 4), np.nan), 1e12 + np.random.default_rng(1).random((4, 4, 4))])
            file.create_dataset("far", data=far, chunks=(1, 4, 4, 4), **volute.hdf5.Volute(max_error=1e-9))
            for kind in ("c8", "S3", "i8"):
                with self.assertRaises((OSError, ValueError)):
                    file.create_dataset("kind", shape=(4, 4, 4), dtype=kind, chunks=(4, 4, 4), **volute.hdf5.Volute(max_error=1e-3))
        program = "import h5py, numpy, sys; file = h5py.File(sys.argv[1]); numpy.savez(sys.argv[2], **{key: file[key][...] for key in file})"
        subprocess.run([sys.executable, "-c", program, name, self.path / "chunks.npz"], check=True, env=os.environ | {"HDF5_PLUGIN_PATH": volute.hdf5.FOLDER})
        read = np.load(self.path / "chunks.npz")
        for key, array in arrays.items():
            self.assertEqual(read[key].dtype, array.dtype)
            self.assertLessEqual(abs(read[key].astype("f8") - array).max(), 0 if array.dtype.kind in "iu" else 1e-3, key)
        self.assertLess(abs(read["look"] - self.values).max(), 0.05)
        np.testing.assert_array_equal(read["far"], far)  # chunks that it cannot take are kept as they are
        # The command has the filter, too, and others where HDF5 looks for them.
        subprocess.run([COMMAND, "compress", name, "--field", "look", "--max-error", "1e-4", "-o", self.path / "look.volute"], check=True, capture_output=True)
        np.testing.assert_allclose(volute.open(self.path / "look.volute")[...], read["look"], atol=1.001e-4)
        self.assertLess(name.stat().st_size, 0.5 * sum(array.nbytes for array in arrays.values()))
        with self.assertRaisesRegex(ValueError, "max_error=-1"):
            volute.hdf5.Volute(max_error=-1)

    def test_endless_strides_are_refused(self):
        one = np.ones((1, 8, 8, 8), np.float32)
        for shape, strides in (((10**9, 8, 8, 8), (0, 256, 32, 4)), ((1, 10**4, 10**4, 10**4), (0, 0, 0, 0))):
            array = np.lib.stride_tricks.as_strided(one, shape, strides)
            for call in (lambda: volute.picture(array), lambda: volute.compress(array, self.path / "x.volute")):
                with self.assertRaises(volute.TooLarge):
                    call()

    def test_films(self):
        try:
            volute.film(self.file, self.path / "puff.mp4", size=(64, 48), frames=(0, 4), emission=1.0)
        except volute.Unsupported as error:
            self.skipTest(str(error))
        self.assertIn(b"ftyp", (self.path / "puff.mp4").read_bytes()[:12])
        volute.film(self.values, self.path / "puff_%04d.png", size=(60, 48), frames=(2, 4), emission=1.0)
        np.save(self.path / "values.npy", self.values)
        self.command("render", self.path / "values.npy", "-o", self.path / "cli_%04d.png", "--size", "60x48", "--renderer", "cpu", "--frames", "2:4", "--emission", "1")
        for number in ("0002", "0003"):
            np.testing.assert_array_equal(volute.read_image(self.path / f"puff_{number}.png"), volute.read_image(self.path / f"cli_{number}.png"))

        def stop(stage, done, total):
            raise RuntimeError("that will do")
        with self.assertRaisesRegex(RuntimeError, "that will do"):
            volute.film(self.file, self.path / "stopped.mp4", size=(64, 48), emission=1.0, progress=stop)
        self.assertFalse((self.path / "stopped.mp4").exists())

    def test_scenes_from_dicts(self):
        said = {"format": "volute-scene-1", "camera": {"eye": [-3, 1, 1.2], "target": [1, 1, 1.2], "fov": 40},
                "background": [0.25, 0.25, 0.25], "media": [{"kind": "volume", "file": "puff.volute", "extinction": 3.0}]}
        scene = volute.Scene(said, folder=self.path)
        self.assertEqual(scene.json, said)
        self.assertAlmostEqual(float(scene.render(size=(8, 6))[0, 0, 0]), 0.25)
        said["background"] = [0.5, 0.5, 0.5]
        scene.change(said)
        self.assertAlmostEqual(float(scene.render(size=(8, 6))[0, 0, 0]), 0.5)
        with self.assertRaisesRegex(volute.InvalidData, "extinktion.*extinction"):
            scene.change({**said, "media": [{**said["media"][0], "extinktion": 1}]})
        self.assertEqual(scene.json, said)
        with self.assertRaisesRegex(ValueError, "'cpu' or 'gl' or 'reference'"):
            scene.render(renderer="opengl")
        with self.assertRaises(TypeError):
            volute.Scene(said, emission=1)

    def smoke_room(self, name="room", more=()):
        folder = self.path / name
        folder.mkdir(exist_ok=True)
        mesh = fds_case.Mesh("room", (0, 8, 0, 3, 0, 2.4), (16, 6, 5))
        return fds_case.FdsCase([mesh], (0.0, 10.0, 20.0), lambda time, x, y, z: 0.1 * time, more=more).write(folder)

    def test_fds(self):
        case = volute.fds.open(self.smoke_room())
        self.assertEqual(case.bounds, ((0, 0, 0), (8, 3, 2.4)))
        self.assertEqual(list(case.times), [0, 10, 20])
        self.assertEqual(case.shape[1:], (5, 6, 16))
        np.testing.assert_allclose(case[2, 1:3, 2], 2, rtol=1e-5)
        np.testing.assert_allclose([frame.mean() for frame in case], [0, 1, 2], rtol=1e-5)
        self.assertIn(case.source, case.sources)
        small = volute.compress(case, self.path / "room.volute", max_error=0.01).open()
        self.assertEqual((small.bounds, small.unit), (case.bounds, case.unit))
        self.assertLess(abs(small[1] - 1).max(), 0.0101)
        with self.assertRaises(volute.NotFound):
            volute.fds.open(self.path / "none.smv")

    def test_lines_of_sight(self):
        sight = volute.Sight(self.smoke_room())
        seen = sight.look([[1, 1, 1], [2, 1, 1]], [6, 1, 1], time=2)
        np.testing.assert_allclose(seen["depth"], [10, 8], rtol=1e-5)
        self.assertTrue(seen["covered"].all() and not seen["blocked"].any())
        np.testing.assert_allclose(sight.look([1, 1, 1], [6, 1, 1], time=1)["depth"], [5], rtol=1e-5)  # back in time
        with self.assertRaisesRegex(volute.InvalidArgument, "no stored time 3"):
            sight.look([1, 1, 1], [6, 1, 1], time=3)
        with self.assertRaisesRegex(ValueError, "finite"):
            sight.look([np.nan, 1, 1], [6, 1, 1])

    def test_visibility(self):
        signs = [{"name": "exit", "position": [7.9, 1.5, 2], "normal": [-1, 0, 0], "emitting": True},
                 {"name": "back", "position": [0.1, 1.5, 2], "normal": [1, 0, 0], "C": 3}]
        eyes = [[1, 1.5, 1.6], [4, 1.5, 1.6], [6, 1.5, 1.6]]
        survey = volute.visibility(self.smoke_room(), signs, eyes)
        self.assertEqual(survey.sightings.shape, (3, 2, 3))
        self.assertEqual(survey.signs, ["exit", "back"])
        # Light emitting: C = 8, so 8 m at 1/m and 4 m at 2/m; C = 3: 3 m and 1.5 m.
        np.testing.assert_array_equal(survey.lost(), [[20, np.inf, np.inf], [np.inf, 10, 10]])
        np.testing.assert_allclose(survey.sightings["visibility"][1], [[8] * 3, [3] * 3], rtol=1e-5)
        with self.assertRaisesRegex(volute.Error, "normal"):
            volute.visibility(self.smoke_room(), [{"name": "a", "position": [1, 1, 1]}], eyes)

    def test_engine_for_programs_that_move_people(self):
        signs = [{"name": "exit", "position": [7.9, 1.5, 2], "normal": [-1, 0, 0], "emitting": True},
                 {"name": "back", "position": [0.1, 1.5, 2], "normal": [1, 0, 0], "C": 3}]
        criteria = [{"kind": "extinction", "limit": 1.0}, {"kind": "temperature", "limit": 60}]
        engine = volute.Engine(self.smoke_room(), signs, criteria=criteria)
        self.assertEqual(engine.signs, ["exit", "back"])
        self.assertEqual(list(engine.times), [0, 10, 20])
        self.assertEqual(list(engine.missing), ["temperature"])
        self.assertEqual(list(engine.criteria), ["extinction"])
        hot = [("TEMPERATURE", "C", lambda time, x, y, z: 20 + time * x)]
        warm = volute.Engine(self.smoke_room("warm", hot), signs, criteria=criteria)
        self.assertEqual((list(warm.criteria), list(warm.missing)), (["extinction", "temperature"], []))
        np.testing.assert_allclose(warm.dose([1, 2], [[1.25, 1.25, 1.2], [4.25, 1.25, 1.2]], 15)["temperature"],
                                   [20 + 15 * 1.25, 20 + 15 * 4.25], rtol=1e-4)
        np.testing.assert_allclose(engine.sign_places, [[7.9, 1.5, 2], [0.1, 1.5, 2]])
        eyes = np.array([[1, 1.5, 1.6], [4, 1.5, 1.6], [6, 1.5, 1.6]])
        # K = t / 10: an optical depth of 8 over 6.9, 3.9 and 1.9 m, of 3 over .9, 3.9 and 5.9 m.
        for time, exits, backs in ((5, [1, 1, 1], [1, 1, 1]), (9, [1, 1, 1], [1, 0, 0]), (15, [0, 1, 1], [1, 0, 0])):
            seen = engine.sees(eyes, time)
            self.assertEqual(seen.shape, (3,))
            np.testing.assert_array_equal(seen["exit"], exits, str(time))
            np.testing.assert_array_equal(seen["back"], backs, str(time))
        np.testing.assert_allclose(engine.extinction(eyes, 15), 1.5, rtol=1e-5)
        # 3 / 1.5 = 2 m of sight: a metre less than 3.
        np.testing.assert_allclose(engine.walking_speed(eyes, 15, clear=[1.2, 1, 0.6]), [0.86, 0.66, 0.26], rtol=1e-5)
        np.testing.assert_allclose(engine.walking_speed(eyes, 15, law="frantzich-nilsson:0.706,-0.057,0.1"),
                                   1.2 * (1 - 0.057 * 1.5 / 0.706), rtol=1e-5)
        self.assertTrue(np.isnan(engine.walking_speed([[50, 1.5, 1.6]], 15)[0]))
        with self.assertRaisesRegex(ValueError, "fridolf or frantzich"):
            engine.walking_speed(eyes, 15, law="fast")
        walkers = engine.sees(eyes, 9, facing=[[1, 0], [-1, 0], [1, 0]])
        self.assertEqual((list(walkers["exit"]), list(walkers["back"])), ([1, 0, 1], [0, 0, 0]))
        np.testing.assert_allclose(engine.dose([7, 8, 9], eyes, 15)["extinction"], 1.5, rtol=1e-5)
        np.testing.assert_allclose(engine.dose([7, 8, 9], eyes, 15, worst=True)["extinction"], 1.5, rtol=1e-5)
        with self.assertRaisesRegex(ValueError, "ids"):
            engine.dose([7, 8], eyes, 16)
        with self.assertRaisesRegex(ValueError, "finite"):
            engine.sees(eyes, np.nan)
        walks = self.path / "walks.txt"
        walks.write_text("# framerate: 1\n3 0 1 1.5 0\n3 10 6 1.5 0\n5 4 2 1.5 0\n5 5 3 1.5 0\n")
        people = volute.Trajectories(walks, eye_height=1.6)
        self.assertRegex(people.remarks[0], "z is the floor there: eyes are 1.6 m above it")
        self.assertEqual(volute.Trajectories(walks, height=2).at(0)[1][0][2], 2)
        self.assertEqual((people.begin, people.end, list(people.ids)), (0, 10, [3, 5]))
        ids, places = people.at(4.5)
        self.assertEqual(list(ids), [3, 5])
        np.testing.assert_allclose(places, [[3.25, 1.5, 1.6], [2.5, 1.5, 1.6]])
        self.assertEqual(len(engine.dose(ids, places, 17)), 2)

    def test_evacuation_example(self):
        signs = self.path / "signs.json"
        signs.write_text(json.dumps({"signs": [{"name": "exit", "position": [7.9, 1.5, 2], "normal": [-1, 0, 0], "emitting": True}]}))
        example = SOURCE / "examples/python/evacuation_loop.py"
        done = subprocess.run([sys.executable, "-B", example, self.smoke_room(), signs], check=True, capture_output=True, text=True)
        self.assertIn("5.0 s: ", done.stdout)
        self.assertRegex(done.stdout, r"\n\d+ people are left")

    def capture(self, frames=(5,)):
        """Six cameras around the puff, and what they saw of it."""
        cameras = []
        for i in range(6):
            angle = i * np.pi / 6 + 0.1
            forward = -np.array([np.cos(angle), np.sin(angle), 0])
            right, down = np.cross(forward, [0, 0, 1]), np.array([0, 0, -1.0])
            rotation = np.stack([right, down, forward])
            eye = np.array([0.9, 1, 1.2]) - 8 * forward
            cameras.append({"name": f"c{i}", "image": f"c{i}_%04d.exr", "width": 32, "height": 32, "R": rotation.tolist(),
                            "K": [[70, 0, 16], [0, 70, 16], [0, 0, 1]], "t": (-rotation @ eye).tolist()})
        said = {"format": "volute-capture-1", "color": "linear", "pixel_centre": 0.5, "frames": list(frames), "cameras": cameras,
                "volume": {"min": [0, 0, 0], "max": [1.8, 2, 2.4], "resolution": [9, 10, 12]}}
        folder = pathlib.Path(tempfile.mkdtemp(dir=self.path))  # pictures of one that is there are not replaced
        capture = folder / "capture.json"
        capture.write_text(json.dumps(said))
        subprocess.run([COMMAND, "project", self.file, capture, "-o", folder / "{camera}_%04d.exr", "--quiet"], check=True,
                       stdout=subprocess.DEVNULL)
        return capture

    def test_reconstruction(self):
        capture = self.capture()
        result = volute.reconstruct(capture, iterations=20, regularization="none")
        self.assertEqual(result.values.shape[:4], (1, 12, 10, 9))
        self.assertEqual((result.bounds, list(result.frame_numbers)), (((0, 0, 0), (1.8, 2, 2.4)), [5]))
        truth = self.decoded[5].reshape(12, 2, 10, 2, 9, 2).mean(axis=(1, 3, 5))
        found = result.values[0].mean(axis=-1)
        self.assertLess(np.linalg.norm(found - truth), 0.25 * np.linalg.norm(truth))
        self.assertLess(result.report["residual"], 0.2)
        written = volute.reconstruct(capture, self.path / "fire.volute", iterations=20, regularization="none", rms=1e-4)
        self.assertEqual(written.values.shape[1:4], result.values.shape[1:4])
        np.testing.assert_allclose(written.values[0], result.values[0], atol=written.values.max_error * 1.01)
        with self.assertRaisesRegex(TypeError, "resolutoin"):
            volute.reconstruct(capture, resolutoin=3)

    def test_reconstruction_tells_what_the_command_tells(self):
        capture = self.capture()
        said = json.loads(capture.read_text())
        said["typo"] = 1
        said["cameras"][1]["distorsion"] = [0, 0, 0, 0]
        capture.write_text(json.dumps(said))
        with self.assertLogs("volute", "WARNING") as told:
            report = volute.reconstruct(capture, iterations=2, regularization="none").report
        for key in ("typo", "cameras[1].distorsion"):
            self.assertTrue(any(f"{key} is not known and ignored" in line for line in told.output), told.output)
            self.assertIn({"code": "left-out", "sentence": f"{key} is not known and ignored"}, report["capture_remarks"])
        for options in ({"lambda_": 0.5, "regularization": "none"}, {"sparsity": 0.5, "solver": "mlem"}):
            with self.assertRaisesRegex(volute.InvalidArgument, "has no effect with the"):
                volute.reconstruct(capture, **options)

    def test_reconstruction_is_written_as_the_command_writes_it(self):
        capture = self.capture((5, 6))
        said = {"iterations": 20, "regularization": "none"}
        mine = volute.reconstruct(capture, self.path / "mine.volute", **said)
        self.command("reconstruct", capture, "-o", self.path / "its.volute", "--iterations", 20, "--regularization", "none",
                     "--stats", self.path / "its.json")
        its = volute.open(self.path / "its.volute")
        np.testing.assert_array_equal(np.asarray(mine.values), np.asarray(its))
        self.assertEqual(mine.values.rms, its.rms)
        self.assertEqual(mine.report["file_residual"], json.loads((self.path / "its.json").read_text())["file_residual"])
        self.assertNotIn("file_residual", volute.reconstruct(capture, **said).report)

    def test_reconstruction_pulls_frames_together_and_writes_the_calibration(self):
        capture = self.capture((5, 6, 7))
        said = {"iterations": 20, "regularization": "tv"}
        mine = volute.reconstruct(capture, self.path / "mine.volute", temporal=0.01, refined=self.path / "mine.json", **said)
        self.command("reconstruct", capture, "-o", self.path / "its.volute", "--iterations", 20, "--regularization", "tv", "--temporal", 0.01,
                     "--refined", self.path / "its.json")
        np.testing.assert_array_equal(np.asarray(mine.values), np.asarray(volute.open(self.path / "its.volute")))
        alone = volute.reconstruct(capture, self.path / "alone.volute", **said)
        self.assertFalse(np.array_equal(np.asarray(mine.values), np.asarray(alone.values)))
        self.assertEqual((self.path / "mine.json").read_text(), (self.path / "its.json").read_text())
        for wrong in (-1, float("nan"), float("inf")):
            with self.assertRaisesRegex(ValueError, "temporal=.*: expected 0 or more"):
                volute.reconstruct(capture, temporal=wrong)
        with self.assertRaisesRegex(volute.InvalidArgument, "would be replaced"):
            volute.reconstruct(capture, iterations=2, refined=capture)

    def test_reconstruction_with_velocities(self):
        capture = self.capture((5, 6, 7))
        said = {"iterations": 20, "regularization": "none", "velocity": True}
        before = sorted(os.listdir())
        found = volute.reconstruct(capture, **said)
        self.assertEqual(sorted(os.listdir()), before)
        self.assertEqual(found.velocity.shape, (3, 12, 10, 9, 3))
        self.assertGreater(found.report["velocity"]["mean_speed"], 0)
        written = volute.reconstruct(capture, self.path / "moves.volute", error_bars=True, **said)
        self.command("reconstruct", capture, "-o", self.path / "its.volute", "--iterations", 20, "--regularization", "none",
                     "--velocity", "--error-bars")
        for grid, mine in (("velocity", written.velocity), ("emission_sigma", written.sigma)):
            np.testing.assert_array_equal(np.asarray(mine), np.asarray(volute.open(self.path / "its.volute", grid=grid)))
        self.assertLess(np.linalg.norm(np.asarray(written.velocity) - found.velocity), 0.05 * np.linalg.norm(found.velocity))
        self.assertIsNone(volute.reconstruct(capture, iterations=2, regularization="none").velocity)
        with self.assertRaisesRegex(volute.InvalidArgument, "velocity: needs two frames or more"):
            volute.reconstruct(self.capture(), velocity=True)

    def test_frames_are_a_range(self):
        capture = self.capture(range(4, 10))

        def reconstructed(frames):
            return volute.reconstruct(capture, frames=frames, iterations=2, regularization="none").frame_numbers.tolist()

        def resampled(frames):
            volute.resample(self.file, self.path / "some.volute", voxel_size=0.3, frames=frames)
            return volute.open(self.path / "some.volute").frame_numbers.tolist()

        def filmed(frames):
            folder = pathlib.Path(tempfile.mkdtemp(dir=self.path))
            volute.film(self.file, folder / "%04d.png", size=(8, 6), frames=frames, emission=1.0)
            return sorted(int(file.stem) for file in folder.iterdir())
        count = len(self.decoded)
        for frames, chosen in (((5, 8), [5, 6, 7]), (np.array([5, 7]), [5, 6]), (range(4, 9), [4, 5, 6, 7, 8]), (range(4, 10, 2), [4, 6, 8]),
                               (slice(5, 9, 3), [5, 8]), (slice(None, 6), list(range(6))), ((count - 2, None), [count - 2, count - 1])):
            for call, there in ((reconstructed, range(4, 10)), (resampled, range(count)), (filmed, range(count))):
                expected = [number for number in chosen if number in there]
                if expected:
                    self.assertEqual(call(frames), expected, (call, frames))
        for wrong in ([5, 6, 8], [5], (), 5, (4, 9, 2), (6, 6), (8, 5), range(8, 4, -1), range(5, 5), slice(-3, None), slice(4, 8, 0), "5:8",
                      [(5, 6), (7, 8)], [5, (6, 7)], (5, 7.5), (True, 7)):
            for call in (reconstructed, resampled, filmed):
                with self.assertRaisesRegex(ValueError, r"expected numbers of frames as \(first, end\) with first < end, or range\(first, end, step\)"):
                    call(wrong)
        for resolution in ((9, 10), (9, 10, 12, 1)):
            with self.assertRaisesRegex(ValueError, r"expected \(x, y, z\), or one number"):
                volute.reconstruct(capture, resolution=resolution)

    def test_reconstruction_with_error_bars(self):
        capture = self.capture()
        found = volute.reconstruct(capture, iterations=20, regularization="none", error_bars=True)
        self.assertEqual(found.sigma.shape, found.values.shape)
        self.assertGreater(found.sigma.max(), 0)
        self.assertAlmostEqual(np.linalg.norm(found.sigma) / np.linalg.norm(found.values), found.report["uncertainty"]["expected_error"],
                               places=3)
        written = volute.reconstruct(capture, self.path / "bars.volute", iterations=20, regularization="none", error_bars=True)
        self.assertEqual((written.values.shape, written.sigma.shape), (found.values.shape[:4], found.sigma.shape[:4])
                         if found.values.shape[-1] == 1 else (found.values.shape, found.sigma.shape))
        self.assertIsNone(volute.reconstruct(capture, iterations=2, regularization="none").sigma)

    def test_paraview(self):
        if not shutil.which("pvpython"):
            self.skipTest("there is no ParaView")
        script = self.path / "plugin.py"
        script.write_text(f"""
import volute.vtk
from paraview.simple import LoadPlugin, OpenDataFile
LoadPlugin(volute.vtk.__file__, ns=globals())
reader = OpenDataFile({self.file!r})
reader.UpdatePipeline(reader.TimestepValues[-1])
print(len(reader.TimestepValues), *reader.GetDataInformation().GetExtent(), reader.CellData[0].GetRange()[1])
""")
        done = subprocess.run(["pvpython", script], capture_output=True, text=True, timeout=120)
        self.assertEqual(done.returncode, 0, done.stderr)
        *numbers, greatest = done.stdout.split()[-8:]
        self.assertEqual(numbers, ["20", "0", "18", "0", "20", "0", "24"])
        self.assertAlmostEqual(float(greatest), float(self.decoded[-1].max()), places=6)

    def test_vtk(self):
        try:
            import volute.vtk
            from vtkmodules.util.numpy_support import vtk_to_numpy
        except ImportError:
            self.skipTest("there is no python3-vtk9")
        reader = volute.vtk.Reader()
        reader.SetFileName(self.file)
        self.assertEqual(reader.GetTimestepValues(), [0.5 * i for i in range(20)])
        reader.UpdateTimeStep(3.1)
        image = reader.GetOutputDataObject(0)
        self.assertEqual(image.GetExtent(), (0, 18, 0, 20, 0, 24))
        np.testing.assert_allclose(image.GetBounds(), (0, 1.8, 0, 2, 0, 2.4))
        values = vtk_to_numpy(image.GetCellData().GetArray("density"))
        np.testing.assert_array_equal(values.reshape(24, 20, 18), self.decoded[6])
        reader.SetRegion(3, 9, 0, 16, 16, 24)
        reader.UpdateTimeStep(9.5)
        image = reader.GetOutputDataObject(0)
        np.testing.assert_allclose(image.GetBounds(), (0.3, 0.9, 0, 1.6, 1.6, 2.4))
        np.testing.assert_array_equal(vtk_to_numpy(image.GetCellData().GetScalars()).reshape(8, 16, 6), self.decoded[19, 16:, :16, 3:9])
        colour = volute.vtk.Reader()
        colour.SetFileName(str(self.path / "colour.volute"))
        colour.Update()
        self.assertEqual(colour.GetOutputDataObject(0).GetCellData().GetScalars().GetNumberOfComponents(), 3)

    # ---- what a caller gives is taken as it is meant, or refused

    def test_functions_of_doubles_state_their_rounding(self):
        bounds = ((0, 0, 0), (8, 8, 8))
        function = volute.Function(lambda x, y, z, t: 2e6 + 0.01 * x, (8, 8, 8), bounds=bounds)
        self.assertEqual((function[0].dtype, len(function)), (np.float64, 1))
        self.assertIn("1 frame of 8 x 8 x 8 voxels", repr(function))
        v = volute.compress(function, self.path / "far.volute", max_error=1e-3).open()
        truth = np.broadcast_to(2e6 + 0.01 * (np.arange(8) + 0.5), (8, 8, 8))
        self.assertLessEqual(abs(v[0] - truth).max(), v.max_error)
        self.assertLessEqual(v.max_error, 1e-3)
        with self.assertRaisesRegex(ValueError, "the first below the second"):
            volute.Function(lambda x, y, z, t: x, (2, 2, 2), bounds=bounds[::-1])
        # Parts of a frame may be of different types.
        mixed = volute.Function(lambda x, y, z, t: np.zeros(len(x), np.uint8) if z[0] < 4 else z, (64, 32, 32), bounds=bounds)[0]
        self.assertEqual((mixed.dtype, mixed[0, 0, 0], mixed[63, 0, 0]), (np.float64, 0, 8 * 63.5 / 64))

    def test_times_are_seconds(self):
        array, bounds = np.ones((3, 4, 4, 4)), ((0, 0, 0), (1, 1, 1))
        file = self.path / "times.volute"
        for unit in ("ns", "us", "ms", "s"):
            times = np.array([0, 1500, 2500], "m8[ms]").astype(f"m8[{unit}]") if unit != "s" else np.array([0, 1, 2], "m8[s]")
            expected = [0, 1.5, 2.5] if unit != "s" else [0, 1, 2]
            self.assertEqual(volute.compress(array, file, times=times).open().times.tolist(), expected)
            self.assertEqual(volute.Scene(array, bounds=bounds, times=times).times.tolist(), expected)
            self.assertEqual(volute.Lines(np.zeros((3, 3)), np.ones((3, 3)), np.ones(3), time=times).times.tolist(), expected)
        self.assertEqual(volute.compress(array, file, times=[datetime.timedelta(seconds=i) for i in range(3)]).open().times.tolist(), [0, 1, 2])
        for times, said in ((np.array(["2024-01-01", "2024-01-02", "2024-01-03"], "M8[s]"), "differences of dates: times - times"),
                            (np.arange(3) + 1j, "complex128"), (["0", "1", "2"], "seconds"), (np.arange(3)[:, np.newaxis], "shape"),
                            (np.array([0, 1, 2], "m8"), "seconds"), (np.array([False, True, True]), "bool")):
            for call in (lambda t: volute.compress(array, file, times=t), lambda t: volute.Scene(array, bounds=bounds, times=t),
                         lambda t: volute.Lines(np.zeros((3, 3)), np.ones((3, 3)), np.ones(3), time=t)):
                with self.assertRaises(TypeError) as raised:
                    call(times)
                self.assertRegex(str(raised.exception).replace("time:", "times:").replace("time - time", "times - times"), said)
        with self.assertRaisesRegex(ValueError, "NaT"):
            volute.compress(array, file, times=np.array([0, 1, "NaT"], "m8[s]"))
        for time in (np.timedelta64(1, "s"), np.array(1000, "m8[ms]"), np.array(True), np.array("1"), [1.0], np.array(True, object)):
            with self.assertRaisesRegex(TypeError, "expected a number"):
                volute.render(array, time, bounds=bounds)
        for time in (np.array(0.04), np.float32(0.04), np.array(0, object), decimal.Decimal("0.04"), fractions.Fraction(1, 25)):
            self.assertEqual(volute.render(array, time, bounds=bounds, extinction=1.0, size=(4, 3)).shape, (3, 4, 3))
        self.assertEqual(volute.compress(array, file, times=np.array([0, 1, 2.5], object)).open().times.tolist(), [0, 1, 2.5])

    def test_frame_numbers(self):
        array = np.ones((2, 4, 4, 4))
        for numbers, error in (([1 / 3, 2 / 3], ValueError), ([1, np.nan], TypeError), ([False, True], TypeError), (["1", "2"], TypeError), ([1, 2 ** 33], ValueError)):
            with self.assertRaises(error):
                volute.compress(array, self.path / "numbers.volute", frame_numbers=numbers)
        names = [self.path / f"part_{number}.npy" for number in ("1.25", "1.50")]
        for name in names:
            np.save(name, array[0])
        made = subprocess.run([COMMAND, "compress", self.path / "part_%d.npy", "-o", self.path / "parts.volute"], capture_output=True)
        self.assertEqual(made.returncode, 0, made.stderr)
        np.testing.assert_array_equal(volute.open(self.path / "parts.volute").frame_numbers, [1.25, 1.5])
        again = volute.compress(volute.open(self.path / "parts.volute"), self.path / "again.volute").open()
        np.testing.assert_array_equal(again.frame_numbers, [1.25, 1.5])
        for numbers in ([1.7, 2.2], again.frame_numbers):
            given = volute.compress(array, self.path / "numbers.volute", frame_numbers=numbers).open()
            np.testing.assert_array_equal(given.frame_numbers, numbers)
        for numbers in ([3.0, 7.0], np.array([3, 7], object), np.array([3, 7], np.uint64)):
            self.assertEqual(volute.compress(array, self.path / "numbers.volute", frame_numbers=numbers).open().frame_numbers.tolist(), [3, 7])

    def test_what_is_read_is_not_replaced(self):
        file, link = str(self.path / "kept.volute"), str(self.path / "kept_link.volute")
        shutil.copy(self.file, file)
        os.symlink("kept.volute", link)
        np.save(self.path / "kept.npy", self.values)
        before = {name: pathlib.Path(name).read_bytes() for name in (file, self.path / "kept.npy")}
        v = volute.open(link)
        calls = [lambda: volute.resample(file, file, voxel_size=0.3), lambda: volute.resample(v, file, voxel_size=0.3),
                 lambda: volute.resample(self.path / "kept.npy", self.path / "kept.npy", voxel_size=0.3),
                 lambda: volute.resample(self.path / "kept.npy", file, like=link), lambda: volute.compress(v, file), lambda: volute.compress(v, link),
                 lambda: volute.compress((2 * frame for frame in v), file),
                 lambda: volute.compress(volute.Function(lambda x, y, z, t: x + v[3, 1, 1, 1], (4, 4, 4), bounds=((0, 0, 0), (1, 1, 1))), file)]
        for call in calls:
            with self.assertRaisesRegex(volute.InvalidArgument, "is read and would be replaced; give another name"):
                call()
        self.assertEqual({name: pathlib.Path(name).read_bytes() for name in before}, before)
        class Elsewhere:
            """As dask's arrays, computed by another thread."""
            shape, dtype, ndim = v.shape, v.dtype, v.ndim

            def __dask_graph__(self):
                return {}

            def __len__(self):
                return len(v)

            def __getitem__(self, index):
                with concurrent.futures.ThreadPoolExecutor() as pool:
                    return pool.submit(lambda: v[index]).result()
        arrays = [Elsewhere()]
        if importlib.util.find_spec("dask"):
            arrays.append(2 * v.to_dask())
        for array in arrays:
            with self.assertRaisesRegex(volute.InvalidArgument, "is read and would be replaced; give another name"):
                volute.compress(array, file)
            volute.compress(array, self.path / "other.volute")
        self.assertEqual(pathlib.Path(file).read_bytes(), before[file])
        volute.compress(2 * v[...], file)  # that was read before

    def test_arrays_are_of_no_other_kind(self):
        with self.assertRaisesRegex(volute.InvalidArgument, 'is "fog", and this is a volume of voxels, of kind "volume"; leave it out'):
            volute.Scene(self.values, kind="fog")
        with self.assertRaisesRegex(ValueError, "/media/0/kind: 'fog' with an array as its file; arrays are of kind 'volume'"):
            volute.Scene({"format": "volute-scene-2", "media": [{"kind": "fog", "file": self.values}]})
        volute.Scene(self.values, kind="volume")

    def test_a_volume_is_compressed_with_all_that_its_file_says(self):
        array = np.ma.masked_less(self.values, 0.05)
        volute.compress(array, self.path / "first.volute", max_error=1e-2, bounds=((0, 0, 0), (1.8, 2, 2.4)))
        first = volute.open(self.path / "first.volute")
        with self.assertLogs("volute", "INFO") as log:
            report = volute.compress(first, self.path / "second.volute", max_error=1e-3, provenance="first.volute")
        self.assertIn("is compressed itself", log.output[0])
        second = report.open()
        np.testing.assert_array_equal(second.masked(2).mask, array[2].mask)
        self.assertEqual(report.max_error, second.max_error)
        self.assertLessEqual(first.max_error, second.max_error)
        self.assertLessEqual(second.max_error, first.max_error + 1e-3)
        self.assertLessEqual(np.abs(np.asarray(second) - array.filled(0)).max(), second.max_error)
        subprocess.run([COMMAND, "compress", first.path, "-o", self.path / "cli.volute", "--max-error", "1e-3", "--quiet"], check=True,
                       capture_output=True)
        self.assertEqual((self.path / "second.volute").read_bytes(), (self.path / "cli.volute").read_bytes())
        said = {"name": "soot", "unit": "1/m", "times": np.arange(20) * 2.0, "frame_numbers": np.arange(20) + 0.5, "basis": "box",
                "bounds": ((1, 1, 1), (2, 2, 2))}
        third = volute.compress(first, self.path / "third.volute", max_error=1e-3, **said).open()
        for key, value in said.items():
            np.testing.assert_array_equal(getattr(third, key), value)
        np.testing.assert_array_equal(third.masked(2).mask, array[2].mask)
        for wrong in ({"times": [1]}, {"times": np.arange(20)[::-1]}, {"not_finite": "no"}):
            with self.assertRaises(ValueError):
                volute.compress(first, self.path / "no.volute", **wrong)

    def test_what_is_no_array(self):
        for name in ("file", "case"):
            for call in (volute.Scene, volute.Sight, volute.picture):
                with self.assertRaisesRegex(TypeError, f"{name}=.*: what is shown is the first argument"):
                    call(self.values, bounds=((0, 0, 0), (1, 1, 1)), **{name: "x.npy"})
        for path in ("ember", self.path):
            with self.assertRaisesRegex(TypeError, "is a path, and no array"):
                volute.compress(path, self.path / "no.volute")
        with self.assertRaisesRegex(TypeError, "has arrays by name; give one of 'a', 'b'"):
            volute.compress({"a": self.values, "b": self.values}, self.path / "no.volute")
        scalar = type("Scalar", (), {"shape": (), "__getitem__": lambda self, key: 1.0})()
        with self.assertRaisesRegex(ValueError, r"has shape \(\)"):
            volute.compress(scalar, self.path / "no.volute")

    def test_bounds_are_two_corners(self):
        array = np.ones((3, 4, 5))
        for bounds in ([(0, 10), (0, 10), (12, 15)], [0, 0, 0, 1, 1, 1], [["0"] * 3, ["1"] * 3], [[False] * 3, [True] * 3], [[0, 0, 0], [1, 1, 1j]]):
            for call in (lambda: volute.compress(array, self.path / "b.volute", bounds=bounds), lambda: volute.Sight(array, bounds=bounds, extinction=1.0),
                         lambda: volute.resample(self.file, self.path / "b.volute", bounds=bounds)):
                with self.assertRaisesRegex(ValueError, "expected numbers in the order"):
                    call()
        for bounds in (((0, 0, 1), (1, 1, 0)), ((0, 0, 0), (1, 1, np.inf)), ((0, 0, 0), (1, 1, 0))):
            with self.assertRaisesRegex(volute.InvalidArgument, "the first below the second"):
                volute.compress(array, self.path / "b.volute", bounds=bounds)
        whole = np.array([[0, 0, 0], [5, 4, 3]], object)
        self.assertEqual(volute.compress(array, self.path / "b.volute", bounds=whole).open().bounds, ((0, 0, 0), (5, 4, 3)))

    def test_memory_is_a_number_of_bytes(self):
        for memory in (float("inf"), float("nan"), 2 ** 70, -1):
            with self.assertRaisesRegex(ValueError, "expected 0 to 18446744073709551615 bytes"):
                volute.open(self.file, max_memory=memory)
        for memory in (1.5, True, np.array(True), "4", None, [4]):
            with self.assertRaisesRegex(TypeError, "expected a number of bytes"):
                volute.open(self.file, max_memory=memory)
        for memory in (1e9, np.uint64(2 ** 63), np.array(1 << 30), np.longdouble(1 << 30)):
            volute.open(self.file, max_memory=memory)

    def test_members_are_for_what_is_made(self):
        sign = [{"name": "e", "position": [9, 5, 5], "normal": [-1, 0, 0]}]
        bounds = ((0, 0, 0), (10, 10, 10))
        sight = volute.Sight(np.ones((3, 4, 4, 4)), bounds=bounds, extinction=1.0)
        for members in ({"extinction": 5.0}, {"nonsense": 3}, {"field": "a"}, {"max_memory": 1 << 20}):
            with self.assertRaisesRegex(TypeError, f"{next(iter(members))}: a Sight is made with them"):
                volute.visibility(sight, sign, [[1, 5, 5]], **members)
        self.assertEqual(volute.visibility(sight, sign, [[1, 5, 5]], times=[0, 2]).times.tolist(), [0, 0.08])
        for times in ([0.04, 0.08], np.array([False, True, True]), ["0"], 1.0):
            with self.assertRaisesRegex(TypeError, "expected indices of stored times, whole numbers from 0 to 2; Sight.times"):
                volute.visibility(sight, sign, [[1, 5, 5]], times=times)
        for time in (-1, 3):
            with self.assertRaisesRegex(volute.InvalidArgument, f"there is no stored time {time}; there are 3"):
                sight.look([1, 5, 5], [9, 5, 5], time)
        for time in (0.5, True, [0]):
            with self.assertRaisesRegex(TypeError, "stored time"):
                sight.look([1, 5, 5], [9, 5, 5], time)
        with self.assertRaisesRegex(ValueError, "at most 1e.12 m"):
            sight.look([-1e300, 5, 5], [1e300, 5, 5])

    def test_pictures_of_one_scene_say_a_remark_once(self):
        scene = volute.Scene(np.ones((2, 2, 2)), bounds=((0, 0, 0), (1, 1, 1)), extinction=1.0)
        camera = {"eye": [-5, 0.5, 0.5], "target": [0, 0.5, 0.5], "fov": 1}
        with self.assertLogs("volute", "WARNING") as log:
            for _ in range(3):
                scene.render(camera=camera, size=(2, 2))
                scene.picture(camera=camera, size=(2, 2))
        self.assertEqual(sum("is it in radians?" in line for line in log.output), 1, log.output)
        with self.assertLogs("volute", "WARNING") as log:
            scene.render(camera=camera | {"fov": 1.5}, size=(2, 2))
        self.assertIn("fov 1.5 degrees", log.output[0])

    def test_remarks_on_units_are_told(self):
        points, cells = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4.0]]), [[0, 1, 2, 3]]
        mesh = volute.Mesh(points, cells, {"soot": np.full((2, 4), 13.0) * [[0], [1]]}, times=[0, 60])
        said = {"field": "soot", "quantity": "soot-density"}
        sign = [{"name": "e", "position": [2, 0.5, 0.5], "normal": [-1, 0, 0]}]
        sight = volute.Sight(mesh, **said)
        with self.assertLogs("volute", "INFO") as log:
            volute.visibility(sight, sign, [[0.5, 0.5, 0.5]])
        doubts = [one for one in log.records if one.levelname == "WARNING"]
        self.assertEqual(len(doubts), 1)
        self.assertIn("much for soot", doubts[0].getMessage())
        self.assertEqual((doubts[0].code, doubts[0].hints), ("doubtful", []))
        self.assertTrue(any("much for soot" in one for one in sight.remarks))
        with self.assertNoLogs("volute", "INFO") if hasattr(self, "assertNoLogs") else contextlib.nullcontext():
            for time in (0, 1, 0):  # back in time, and told already
                sight.look([0.5, 0.5, 0.5], [1, 1, 1], time)
        self.assertTrue(any("much for soot" in one for one in sight.remarks))
        engine = volute.Engine(mesh, sign, **said)
        with self.assertLogs("volute", "WARNING") as log:
            engine.sees([[0.5, 0.5, 0.5]], 60.0)
            engine.sees([[0.5, 0.5, 0.5]], 30.0)
        self.assertEqual(len(log.records), 1)
        self.assertTrue(any("much for soot" in one for one in engine.remarks))
        # What takes light and is below 0 adds it.
        values = np.ones((4, 4, 4))
        values[0] = -3
        camera = {"eye": [-1, 5, 5], "target": [5, 5, 5], "ortho": 0.1}
        with self.assertLogs("volute", "WARNING") as log:
            volute.render(values, bounds=((0, 0, 0), (10, 10, 10)), extinction=1.0, camera=camera, size=(1, 1))
        self.assertIn("16 values are below 0, the smallest -3", log.output[0])
        values = np.zeros((4, 4, 4))
        values[0, 0, 0] = -1e-30  # rounding, in clear air
        with self.assertNoLogs("volute", "WARNING") if hasattr(self, "assertNoLogs") else contextlib.nullcontext():
            volute.render(values, bounds=((0, 0, 0), (10, 10, 10)), extinction=1.0, camera=camera, size=(1, 1))
        self.assertEqual(volute.Sight(values, extinction=1.0).look([-1, 0.5, 0.5], [2, 0.5, 0.5])["blocked"].tolist(), [False])

    def test_little_smoke_is_doubted_when_all_times_were_read(self):
        points, cells = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4.0]]), [[0, 1, 2, 3]]
        said = {"field": "soot", "quantity": "soot-density"}
        sign = [{"name": "e", "position": [2, 0.5, 0.5], "normal": [-1, 0, 0]}]
        line = [0.5, 0.5, 0.5], [1, 1, 1]

        def doubts(call):
            with self.assertLogs("volute", "INFO") as log:
                logging.getLogger("volute").info("")
                call()
            return [one.getMessage() for one in log.records if one.levelname == "WARNING"]

        def mesh(*soot):
            return volute.Mesh(points, cells, {"soot": np.ones((len(soot), 4)) * np.reshape(soot, (-1, 1))}, times=30.0 * np.arange(len(soot)))
        growing = volute.Sight(mesh(0, 1e-9, 1e-4), **said)
        engine = volute.Engine(mesh(0, 1e-9, 1e-4), sign, **said)
        for index in (1, 0, 2, 1, 0):
            self.assertEqual(doubts(lambda: growing.look(*line, index)), [])
            self.assertEqual(doubts(lambda: engine.sees([line[0]], 30.0 * index)), [])
        self.assertFalse(any("clear air" in one for one in growing.remarks))
        thin = volute.Sight(mesh(0, 1e-9), **said)
        self.assertEqual(doubts(lambda: thin.look(*line, 1)), [])
        self.assertRegex("".join(doubts(lambda: thin.look(*line, 0))), "clear air")
        self.assertEqual(doubts(lambda: thin.look(*line, 1)), [])
        engine = volute.Engine(mesh(0, 1e-9), sign, **said)
        self.assertRegex("".join(doubts(lambda: engine.sees([line[0]], 15.0))), "clear air")
        # From too little to too much: another doubt, and no more of them.
        wrong = volute.Sight(mesh(1e-9, 13), **said)
        self.assertEqual(doubts(lambda: wrong.look(*line, 0)), [])
        self.assertRegex("".join(doubts(lambda: wrong.look(*line, 1))), "much for soot")
        self.assertEqual(doubts(lambda: wrong.look(*line, 0)), [])

    def test_whoever_is_told_may_ask(self):
        """For what was told, in another thread: one that never ends would hold up the test."""
        points, cells = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [0, 0, 4.0]]), [[0, 1, 2, 3]]
        said = {"field": "soot", "quantity": "soot-density"}
        mesh, line = volute.Mesh(points, cells, {"soot": np.full(4, 13.0)}), ([0.5, 0.5, 0.5], [1, 1, 1])
        sight = volute.Sight(mesh, **said)
        engine = volute.Engine(mesh, [{"name": "e", "position": [2, 0.5, 0.5], "normal": [-1, 0, 0]}], **said)
        for asked, call in ((sight, lambda: sight.look(*line)), (engine, lambda: engine.sees([line[0]], 0.0))):
            heard = []

            class Asks(logging.Handler):
                def emit(self, record):
                    heard.append(len(asked.remarks))
            handler = Asks()
            logging.getLogger("volute").addHandler(handler)
            try:
                thread = threading.Thread(target=call, daemon=True)
                thread.start()
                thread.join(30)
            finally:
                logging.getLogger("volute").removeHandler(handler)
            self.assertFalse(thread.is_alive())
            self.assertGreater(min(heard), 0)

    def test_names_of_files_need_not_be_utf8(self):
        values = np.ones((1, 4, 4, 4), np.float32)
        values[:, 0] = -3
        name = os.path.join(os.fsencode(self.path), b"\xff.npy")
        np.save(os.fsdecode(name), values)
        for given in (name, os.fsdecode(name)):
            with self.assertLogs("volute", "WARNING") as log:
                volute.render(given, size=(4, 3), extinction=1.0)
            self.assertEqual(log.records[0].file, os.fsdecode(name))
        scene = volute.Scene(name, extinction=1.0)
        self.assertEqual((scene.path, scene.media[0][1]), (os.fsdecode(name),) * 2)
        self.assertEqual(scene.json["media"][0]["kind"], "volume")
        scene.film(os.path.join(os.fsencode(self.path), b"\xfe_%02d.png"), size=(16, 16))
        self.assertTrue(os.path.exists(os.path.join(os.fsencode(self.path), b"\xfe_00.png")))
        np.save(os.fsdecode(name), abs(values))
        sight = volute.Sight(name, extinction=1.0)
        self.assertIsInstance(sight.remarks, list)
        self.assertIn("\udcff", sight.path)
        with self.assertRaises(FileNotFoundError) as raised:
            volute.Sight(name + b".npy", extinction=1.0)
        self.assertEqual(raised.exception.filename, os.fsdecode(name) + ".npy")
        with self.assertRaisesRegex(ValueError, "expected a text that UTF-8 can hold"):
            volute.Scene({"format": "volute-scene-2", "media": [{"kind": "volume", "file": os.fsdecode(name)}]})

    def test_a_reconstruction_keeps_its_basis(self):
        found = volute.reconstruct(self.capture(), iterations=3)
        self.assertEqual(found.basis, "trilinear")
        small = volute.compress(found, self.path / "found.volute", rms=1e-5).open()
        self.assertEqual(small.basis, "trilinear")
        view = {"size": (32, 24), "camera": {"eye": [3, -3, 2], "target": [0.9, 1, 1.2], "fov": 40}}
        time = float(found.times[0])
        ours, of_file = volute.render(found, time, **view), volute.render(small, time, **view)
        np.testing.assert_allclose(ours, of_file, atol=1e-3 * of_file.max())
        lines = volute.Lines([[0, 0.5, 0.5], [0.5, 0, 0.5]], [[1, 0.5, 0.5], [0.5, 1, 0.5]], [1.0, 1.0])
        self.assertEqual(volute.reconstruct(lines, bounds=((0, 0, 0), (1, 1, 1)), resolution=4, basis="trilinear").basis, "trilinear")

    def test_an_open_case_is_shown_as_it_was_opened(self):
        path = self.smoke_room()
        source = next(iter(volute.fds.open(path).sources))
        with volute.fds.open(path, source=source, mass_extinction=4350) as case:
            line = [1, 1, 1], [6, 1, 1], 2
            self.assertEqual(volute.Sight(case).look(*line), volute.Sight(path, field=source, mass_extinction=4350).look(*line))
            scene = {"format": "volute-scene-2", "media": [{"case": case}]}
            self.assertEqual(volute.Sight(scene).look(*line), volute.Sight(case).look(*line))
        with self.assertRaisesRegex(ValueError, "closed"):
            case[0]
        with self.assertRaisesRegex(ValueError, "closed"):
            iter(case)
        infinite = volute.fds.open(path, bounds=((-np.inf, -np.inf, 0), (np.inf, np.inf, 1)))
        self.assertEqual(infinite.shape[2:], volute.fds.open(path).shape[2:])
        self.assertLess(infinite.shape[1], volute.fds.open(path).shape[1])
        self.assertGreater(volute.fds.open(path, bounds=((0, 0, 1), (8, 3, 1))).size, 0)
        for bounds in (((0, 0, 2), (8, 3, 1)), ((0, 0, np.nan), (8, 3, 1))):
            with self.assertRaisesRegex(volute.InvalidArgument, "at or below the second"):
                volute.fds.open(path, bounds=bounds)
        for options in ({"mesh": 0}, {"bounds": ((0, 0, 0), (2, 2, 2))}, {"bounds": np.array(((0, 0, 0), (2, 2, 2)))}):
            for kind in (volute.Scene, volute.Sight):
                with self.assertRaisesRegex(ValueError, f"opened with {next(iter(options))}; compress it first"):
                    kind(volute.fds.open(path, **options))

    def test_what_is_not_known_of_a_line(self):
        seen = volute.Sight(self.smoke_room()).look([1, 1, 1], [20, 1, 1], 2)[0]
        self.assertFalse(seen["covered"])
        self.assertTrue(np.isnan(seen["depth"]) and np.isinf(seen["high"]))
        self.assertAlmostEqual(seen["low"], 14, 3)

    def test_a_damaged_file_states_no_error(self):
        data = pathlib.Path(self.file).read_bytes()
        with self.assertLogs("volute", "WARNING") as log:
            v = volute.open(data[:2 * len(data) // 3], partial=True)
        self.assertTrue(np.isnan([v.rms, v.max_error, v.grids["density"]["rms"]]).all())
        self.assertRegex(v.damage, r"\d+ of \d+ parts of 'density' are intact")
        self.assertEqual((log.records[0].code, log.records[0].getMessage()), ("damaged", v.damage))
        self.assertIn("errors not known", repr(v))
        with self.assertNoLogs("volute", "WARNING") if hasattr(self, "assertNoLogs") else contextlib.nullcontext():
            for again in (v.grid("density"), pickle.loads(pickle.dumps(v)), volute.open(data[:2 * len(data) // 3], partial=True)):
                self.assertEqual(again.damage.partition(": ")[2], v.damage.partition(": ")[2])
        whole = volute.open(self.file, partial=True)
        self.assertIsNone(whole.damage)
        self.assertLess(whole.rms, 1)
        whole.close()
        self.assertIn("closed", repr(whole))
        with self.assertRaisesRegex(ValueError, "closed"):
            iter(whole)

    def test_damage_is_that_of_a_grid(self):
        file = self.path / "grids.volute"
        volute.reconstruct(self.capture(), file, iterations=3, error_bars=True)
        data = bytearray(file.read_bytes())
        found = set()
        with self.assertLogs("volute", "WARNING"):
            for at in range(len(data) // 2, len(data) - 300, len(data) // 60):
                data[at] ^= 0xff
                for grid in ("emission", "emission_sigma"):
                    try:
                        v = volute.open(bytes(data), partial=True, grid=grid)
                    except volute.Error:
                        continue
                    unknown = {name for name, one in v.grids.items() if np.isnan(one["rms"])}
                    self.assertEqual(grid in unknown, v.damage is not None)
                    found.add((grid, *sorted(unknown)))
                data[at] ^= 0xff
        self.assertTrue({("emission", "emission_sigma"), ("emission_sigma", "emission")} & found, found)

    def test_pictures_are_srgb_as_bytes(self):
        steps = np.arange(256, dtype=np.uint8).reshape(16, 16)
        for values in (steps, np.stack([steps, steps[::-1], steps.T], axis=-1)):
            volute.write_image(self.path / "steps.png", values)
            np.testing.assert_array_equal(volute.to_srgb(volute.read_image(self.path / "steps.png")), values)
        for call in (volute.to_srgb, lambda image: volute.write_image(self.path / "steps.png", image)):
            for image in (steps.astype(int), steps.astype(complex), steps > 3):
                with self.assertRaisesRegex(TypeError, "linear light as floats"):
                    call(image)
            with self.assertRaisesRegex(ValueError, "1 values that are no numbers"):
                call(np.array([[0.5, np.nan]]))
        volute.write_image(self.path / "holes.exr", np.array([[0.5, np.nan]]))
        np.testing.assert_array_equal(volute.read_image(self.path / "holes.exr"), [[0.5, np.nan]])
        with self.assertRaisesRegex(TypeError, "uint8 is sRGB"):
            volute.to_srgb(steps)

    def test_agents_are_whole_numbers_each_once(self):
        engine = volute.Engine(self.smoke_room(), [{"name": "exit", "position": [7.9, 1.5, 2], "normal": [-1, 0, 0]}])
        eyes = [[1, 1.5, 1.6], [4, 1.5, 1.6]]
        with self.assertRaisesRegex(TypeError, "whole numbers"):
            engine.dose([1.2, 2.7], eyes, 5)
        for ids in ([True, False], ["1", "2"], np.array([1, None], object)):
            with self.assertRaisesRegex(TypeError, "whole numbers"):
                engine.dose(ids, eyes, 5)
        with self.assertRaisesRegex(ValueError, "beyond 64 bits"):
            engine.dose(np.array([1, 2 ** 63], np.uint64), eyes, 5)
        for ids in ([1.0, 2.0], np.array([1, 2], object), np.array([1, 2], np.uint64)):
            self.assertEqual(len(engine.dose(ids, eyes, 5)), 2)
        with self.assertRaisesRegex(volute.InvalidArgument, "agent 7 is among the ids twice"):
            engine.dose([7, 7], eyes, 5)

    def test_times_that_nothing_has(self):
        v = volute.open(self.file)  # 0 to 9.5 s, every 0.5 s
        np.testing.assert_array_equal(v.at(9.9), self.decoded[19])
        for time, said in ((-99, "-99 s is before the begin"), (99, "99 s is past the end")):
            with self.assertRaisesRegex(ValueError, said):
                v.at(time)
            with self.assertRaisesRegex(ValueError, said):
                volute.render(v, time, size=(8, 6), emission=1.0)

    def test_errors_say_what_they_are_of(self):
        with self.assertRaises(FileNotFoundError) as raised:
            volute.open("nothing.volute")
        error = raised.exception
        self.assertEqual((error.code, error.filename, error.errno), ("not-found", "nothing.volute", 2))
        self.assertIn("nothing.volute: cannot open", str(error))
        self.assertEqual(pickle.loads(pickle.dumps(error)).filename, "nothing.volute")
        with self.assertRaises(FileNotFoundError) as raised:
            volute.open(self.file, grid="nothing")  # the file is there
        self.assertEqual((raised.exception.path, raised.exception.filename, raised.exception.errno), (str(self.file), None, None))
        with self.assertRaises(OSError) as raised:
            volute.compress(self.values[:1], self.path / "none" / "a.volute")
        self.assertTrue(raised.exception.filename, str(raised.exception))
        with self.assertRaises(volute.IoError) as raised:
            volute.open(self.path)
        self.assertEqual((raised.exception.filename, raised.exception.errno), (str(self.path), None))
        with self.assertRaises(volute.Truncated) as raised:
            cut = self.path / "hint.volute"
            cut.write_bytes(pathlib.Path(self.file).read_bytes()[:-40])
            volute.open(cut)
        self.assertEqual((raised.exception.code, raised.exception.path), ("truncated", str(cut)))
        self.assertIn("partial", raised.exception.hint)
        array, bounds = np.ones((2, 4, 4, 4)), ((0, 0, 0), (1, 1, 1))
        for error, said, call in [(ValueError, "UTF-8", lambda: volute.compress(array, self.path / "e.volute", name="\udcff")),
                                  (ValueError, "expected \\(r, g, b\\)", lambda: volute.render(array, bounds=bounds, background=(1, 1))),
                                  (ValueError, "expected \\(width, height\\)", lambda: volute.render(array, bounds=bounds, size=(1, 1, 1))),
                                  (ValueError, "max_memory=-1", lambda: volute.open(self.file, max_memory=-1)),
                                  (ValueError, "max_memory=-1", lambda: volute.Scene(array, bounds=bounds, max_memory=-1)),
                                  (TypeError, "grid=1: expected a name", lambda: volute.open(self.file, grid=1)),
                                  (ValueError, "NUL", lambda: volute.open("a\0b.volute")), (ValueError, "NUL", lambda: volute.Scene("a\0b.json")),
                                  (ValueError, "NUL", lambda: volute.write_image("a\0b.png", np.ones((2, 2)))),
                                  (FileNotFoundError, "nothing", lambda: volute.read_image(b"nothing.png")),
                                  (FileNotFoundError, "nothing", lambda: volute.Scene(b"nothing.json"))]:
            with self.assertRaisesRegex(error, said):
                call()
        self.assertEqual(volute.compress(array, os.fsencode(self.path / "bytes.volute")).open().shape, array.shape)

    def test_arrays_are_let_go_of(self):
        bounds = ((0, 0, 0), (1, 1, 1))
        for kind in (volute.Scene, volute.Sight):
            array = np.ones((1, 8, 8, 8), np.float32)
            kept = weakref.ref(array)
            opened = kind(array, bounds=bounds, extinction=1.0)
            del array
            opened.close()
            gc.collect()
            self.assertIsNone(kept(), kind.__name__)
        scene = volute.Scene({"format": "volute-scene-2", "media": [{"kind": "volume", "file": np.ones((1, 8, 8, 8)), "bounds": bounds}]})
        kept = []
        for _ in range(5):
            array = np.ones((1, 8, 8, 8), np.float32)
            kept.append(weakref.ref(array))
            scene.change({"format": "volute-scene-2", "media": [{"kind": "volume", "file": array, "bounds": bounds}]})
        del array
        gc.collect()
        self.assertEqual([one() is None for one in kept], [True] * 4 + [False])
        self.assertEqual(scene.render(size=(8, 6)).shape, (6, 8, 3))

    def test_code_on_the_page(self):
        pages = {path.name: re.findall(r"^```python\n(.*?)^```", path.read_text(), re.S | re.M) for path in (SOURCE / "docs").rglob("*.md")}
        self.assertEqual({name: len(blocks) for name, blocks in pages.items() if blocks}, {"python.md": 7, "own-media.md": 2})
        folder = self.path / "own"
        folder.mkdir()
        said = subprocess.run([sys.executable, "-c", "\n".join(pages["own-media.md"])], cwd=folder, capture_output=True, text=True)
        self.assertEqual((said.returncode, said.stderr), (0, ""))
        blocks = pages["python.md"]
        folder = self.path / "page"
        folder.mkdir()
        np.save(folder / "frames.npy", puff(24, 20, 20, 20))
        said = subprocess.run([sys.executable, "-c", "\n".join(blocks)], cwd=folder, capture_output=True, text=True)
        self.assertEqual(said.returncode, 0, said.stderr)
        self.assertIn("(24, 20, 20, 20)", said.stdout)
        self.assertIn("(24, 1, 2)", said.stdout)
        self.assertTrue((folder / "smoke.exr").exists())

    def test_the_module_is_the_command(self):
        said = subprocess.run([sys.executable, "-m", "volute", "--version"], capture_output=True, text=True, check=True)
        self.assertEqual((said.stdout, said.stderr), (f"volute {volute.__version__}\n", ""))
        wrong = subprocess.run([sys.executable, "-m", "volute", "--version"], capture_output=True, text=True,
                               env=os.environ | {"VOLUTE_COMMAND": "/nothing/volute"})
        self.assertEqual(wrong.returncode, 1)
        self.assertIn("cannot run /nothing/volute", wrong.stderr)

    def test_everything_is_documented_and_has_types(self):
        folder = pathlib.Path(volute.__file__).parent
        stub = {node.name: node for node in ast.parse((folder / "__init__.pyi").read_text()).body if hasattr(node, "name")}
        for name in volute.__all__:
            thing = getattr(volute, name)
            self.assertTrue(inspect.getdoc(thing), name)
            if inspect.ismodule(thing):
                continue
            self.assertIn(name, stub)
            if inspect.isclass(thing) and not issubclass(thing, Exception):
                declared = {node.name if hasattr(node, "name") else node.target.id for node in stub[name].body
                            if isinstance(node, (ast.FunctionDef, ast.AnnAssign))}
                real = {member for member in vars(thing) if not member.startswith("_")}
                self.assertEqual(real - declared, set(), name)
            elif inspect.isfunction(thing):
                self.assertEqual([argument.arg for argument in stub[name].args.args + stub[name].args.kwonlyargs],
                                 [n for n, p in inspect.signature(thing).parameters.items() if p.kind != p.VAR_KEYWORD], name)


if __name__ == "__main__":
    unittest.main(verbosity=2)
