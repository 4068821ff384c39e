# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Caches of several grids through the program and back: tests/data/cache.volute has six of three frames, one of them empty and one not there at first."""
import json
import math
import os
import pathlib
import shutil
import struct
import subprocess
import unittest
import zlib

import support
from pictures import read_exr
from support import read_npy, volute, write_npy

CACHE = pathlib.Path(__file__).parents[1] / "data" / "cache.volute"
NAMES = ["density", "flame", "fuel", "solid", "temperature", "velocity"]


def counted(text):
    """A string as OpenVDB stores it."""
    return struct.pack("<I", len(text)) + text


class VdbFile:
    """A .vdb file cut into its grids; another one made of these, under other names."""

    def __init__(self, path):
        self.data, self.at = path.read_bytes(), 8 + 4 + 8 + 1 + 36  # magic, versions, a flag, an identifier
        for _ in range(self.number("<I")):  # metadata: name, type, value
            self.string(), self.string(), self.string()
        self.head = self.data[:self.at]
        self.grids = {}
        for _ in range(self.number("<I")):
            name, kind = self.string(), self.string()
            self.string()  # whose instance it is
            begin, buffers, end = (self.number("<q") for _ in range(3))
            self.grids[name] = (kind, buffers - begin, self.data[begin:end])
            self.at = end

    def number(self, kind):
        (value,) = struct.unpack_from(kind, self.data, self.at)
        self.at += struct.calcsize(kind)
        return value

    def string(self):
        length = self.number("<I")
        self.at += length
        return self.data[self.at - length:self.at]

    def write(self, path, names):
        """`names`: pairs of a grid's new name and its name here."""
        out = bytearray(self.head + struct.pack("<I", len(names)))
        for new, old in names:
            kind, buffers, data = self.grids[old]
            assert data.count(counted(old)) == 1
            data = data.replace(counted(old), counted(new))
            out += counted(new) + counted(kind) + counted(b"")
            begin = len(out) + 24
            out += struct.pack("<qqq", begin, begin + buffers + len(new) - len(old), begin + len(data)) + data
        path.write_bytes(out)


@unittest.skipUnless("VDB_MAKER" in os.environ, "this build has no OpenVDB")
class EveryType(support.TestCase):
    """Caches with every type, class, transform and metadata of OpenVDB, made and compared by OpenVDB itself."""
    UNCODED = {"id", "big id", "burnt", "mask", "cell", "particles", "flags", "foreign", "late", "frustum"}

    def make(self):
        folder = self.path("all")
        folder.mkdir()
        subprocess.run([os.environ["VDB_MAKER"], "make", str(folder)], check=True)
        return folder

    def same(self, a, b, tolerance):
        done = subprocess.run([os.environ["VDB_MAKER"], "compare", str(a), str(b), str(tolerance)], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def test_there_and_back(self):
        folder = self.make()
        said = self.works("compress", folder, "-o", self.path("x.volute"), "--keep", "holes", "--max-error", "1e-3", "--json")
        self.assertIn("kept as they are, without loss", said.message)
        self.assertIn("volute resample makes a volume of a frustum", said.message)
        listed = {one["name"]: one for one in self.works("info", folder / "all_0001.vdb", "--json").json["grids"]}
        self.assertEqual((listed["burnt"]["minimum"], listed["burnt"]["maximum"]), (0, 1))
        self.assertEqual(listed["id"]["maximum"], 3 * listed["big id"]["maximum"] / 2**40)
        self.assertNotIn(" nan ", self.works("info", folder / "all_0001.vdb").text)
        # In parts, where a grid is larger than what is allowed.
        parts = self.works("info", folder / "all_0001.vdb", "--max-memory", "4K", "--json").json["grids"]
        self.assertEqual({one["name"]: one for one in parts}, listed)
        self.assertLessEqual(self.UNCODED | {"holes"}, {one["name"] for one in said.json["kept"]})
        listed = self.works("info", self.path("x.volute"), "--json").json
        self.assertEqual(listed["kept"], said.json["kept"])
        self.assertTrue(listed["complete"])
        back = self.path("back")
        back.mkdir()
        self.works("extract", self.path("x.volute"), "-o", back / "all_%04d.vdb")
        for frame in (1, 2, 3):
            text = self.same(folder / f"all_000{frame}.vdb", back / f"all_000{frame}.vdb", 1e-3)
            self.assertEqual("late" in text, frame == 2)
        compared = self.works("compare", folder, self.path("x.volute"), "--json").json
        self.assertTrue(all(one["identical"] for one in compared["kept"]), compared["kept"])
        # Again, and joined from parts: these state the errors of both steps, and what is encoded again gets as much.
        self.works("compress", self.path("x.volute"), "-o", self.path("a.volute"), "--frames", "1:2", "--max-error", "1e-3")
        self.works("compress", self.path("x.volute"), "-o", self.path("b.volute"), "--frames", "2:4", "--max-error", "1e-3")
        self.works("join", self.path("a.volute"), self.path("b.volute"), "-o", self.path("c.volute"))
        self.works("extract", self.path("c.volute"), "-o", self.path("joined_%04d.vdb"))
        for frame in (1, 2, 3):
            self.same(folder / f"all_000{frame}.vdb", self.path(f"joined_000{frame}.vdb"), 6e-3)

    def test_a_level_set_is_drawn_by_both_renderers(self):
        if volute("info", "--gl").code != 0:
            self.skipTest("no OpenGL here")
        drawn, folder = {}, self.make()
        for renderer in ("cpu", "gl"):
            self.works("render", folder / "all_0001.vdb", "--field", "surface", "-o", self.path("x.exr"), "--size", "160x120",
                       "--renderer", renderer, "--exposure", "1")
            drawn[renderer] = read_exr(self.path("x.exr")).values
        limit = 0.02 * max(drawn["cpu"])
        off = [abs(a - b) > limit for a, b in zip(drawn["cpu"], drawn["gl"], strict=True)]
        self.assertGreater(sum(value > 0 for value in drawn["cpu"]), 0.05 * len(off))
        self.assertLess(sum(off), 0.005 * len(off))  # at its outline

    def test_some_grids_and_none(self):
        folder = self.make()
        self.works("compress", folder, "-o", self.path("x.volute"), "--field", "density[0],id,surface", "--fast")
        said = self.works("extract", self.path("x.volute"), "-o", self.path("id_%04d.vdb"), "--field", "id", "--json").json
        self.assertEqual(said["grids"], [{"name": "id", "kept": True}])
        self.assertIn("'id' holds no volume", self.fails(2, "extract", self.path("x.volute"), "-o", self.path("x.npy"), "--field", "id"))
        said = self.works("extract", self.path("x.volute"), "-o", self.path("{grid}.npy"))
        self.assertIn("left out, as only whole .vdb files hold them: 'id'", said.message)
        dropped = self.works("compress", folder, "-o", self.path("y.volute"), "--field", "density[0],id", "--uncoded", "drop", "--json")
        self.assertIn("left out, as they hold no volume: 'id' (of type int32)", dropped.message)
        self.assertNotIn("kept", dropped.json)
        self.assertIn("no grid can be compressed", self.fails(1, "compress", folder, "-o", self.path("z.volute"), "--field", "id,mask", "--uncoded", "drop"))
        text = self.fails(1, "compress", folder, "-o", self.path("z.volute"), "--fast")
        self.assertIn("all_0001.vdb: grid 'holes', frame 1: the value at index (0, 5, 8), which is (0, 5, 8) m, is not a number", text)
        self.assertIn("--not-finite inactive makes their voxels inactive, too, or --keep holes keeps the grid as it is", text)
        self.assertIn("all_0001.vdb: grid 'holes', frame 1: the value at index (0, 5, 8)",
                      self.fails(1, "render", folder / "all_0001.vdb", "-o", self.path("x.png"), "--field", "holes"))
        said = self.works("compress", folder, "-o", self.path("z.volute"), "--field", "holes", "--not-finite", "background", "--json").json
        self.assertGreater(said["bytes"], 0)

    def test_what_is_kept_is_left_out_of_new_voxels(self):
        folder = self.make()
        for fields, others in (("half,id,vd", ["half", "vd"]), ("half,id", ["half"])):
            self.works("compress", folder, "-o", self.path("x.volute"), "--field", fields, "--fast")
            said = self.works("resample", self.path("x.volute"), "-o", self.path("y.volute"), "--voxel-size", "0.5", "--json")
            self.assertEqual([grid["name"] for grid in said.json["grids"]], others)
            self.assertIn("'id' is left out: it is of type int32", said.message)
            for words in (("info", self.path("x.volute")), ("resample", self.path("x.volute"), "-o", self.path("y.volute"))):
                self.assertIn("grid 'id' is of type int32, kept as its bytes; expected a volume; the file holds 'half'",
                              self.fails(1, *words, "--field", "id"))
        self.assertIn("there is no grid 'ids'", self.fails(1, "info", self.path("x.volute"), "--field", "ids"))

    def test_nanovdb_takes_double_vectors(self):
        self.works("compress", self.make(), "-o", self.path("x.volute"), "--field", "half,vd", "--fast")
        for end in (".vdb", ".nvdb"):
            self.works("extract", self.path("x.volute"), "-o", self.path("x_%04d" + end))
        self.assertEqual(self.works("compare", self.path("x_%04d.vdb"), self.path("x_%04d.nvdb"), "--field", "vd", "--json").json["max_error"], 0)
        self.works("resample", self.path("x.volute"), "-o", self.path("y_%04d.nvdb"), "--field", "vd", "--voxel-size", "2")
        for name in ("x_0000.nvdb", "y_0000.nvdb"):
            grids = {one["name"]: one["type"] for one in self.works("info", next(self.path(".").glob(name[:2] + "*.nvdb")), "--json").json["grids"]}
            self.assertEqual(grids["vd"], "vec3d")

    def test_what_is_kept_and_too_large_is_refused_first(self):
        source = self.make() / "all_0001.vdb"
        data = source.read_bytes()
        end = struct.pack("<q", len(data))
        self.assertEqual(data.count(end), 1)  # of the last grid, the frustum
        source.write_bytes(data.replace(end, struct.pack("<q", 100 << 30)))
        os.truncate(source, 100 << 30)
        text = self.fails(1, "compress", source, "-o", self.path("x.volute"), "--field", "density[0],frustum")
        self.assertIn("all_0001.vdb: grid 'frustum' is kept as it is (with a frustum) and takes 102399 MiB, more than the", text)
        self.assertIn("--uncoded drop", text)

    def test_damage_of_what_is_kept(self):
        folder = self.make()
        self.works("compress", folder, "-o", self.path("x.volute"), "--field", "density[0],id", "--fast")
        data = bytearray(self.path("x.volute").read_bytes())
        data[-3] ^= 1  # kept grids are stored last
        self.path("x.volute").write_bytes(data)
        self.assertIn("a kept grid is damaged", volute("info", self.path("x.volute")).text)
        self.assertIn("a kept grid is damaged", self.fails(1, "extract", self.path("x.volute"), "-o", self.path("x_%04d.vdb")))
        said = self.works("extract", self.path("x.volute"), "-o", self.path("x_%04d.vdb"), "--partial")
        self.assertIn("'id' is left out of frame 3", said.message)


@unittest.skipUnless("VDB_MAKER" in os.environ, "this build has no OpenVDB")
class Hollow(support.TestCase):
    """Caches in which no grid has values: all are empty, or kept as their bytes."""
    same = EveryType.same

    def setUp(self):
        super().setUp()
        self.folder = self.path("hollow")
        self.folder.mkdir()
        subprocess.run([os.environ["VDB_MAKER"], "hollow", str(self.folder)], check=True)

    def test_there_and_back(self):
        for name, grids, kept in (("empty", ["density", "velocity", "surface"], []), ("kept", [], ["id"]), ("one", ["density"], [])):
            with self.subTest(name=name):
                source, packed, back = str(self.folder / f"{name}_%04d.vdb"), self.path(f"{name}.volute"), str(self.path(f"back_{name}_%04d.vdb"))
                said = self.works("compress", source, "-o", packed, "--json").json
                self.assertEqual(([one["name"] for one in said["grids"]], said["frames"]), (grids, 2))
                info = self.works("info", packed, "--json").json
                self.assertEqual([one["name"] for one in info["grids"] if one["empty"]], grids)
                self.assertEqual([one["name"] for one in info.get("kept", [])], kept)
                self.assertEqual((info["frame_numbers"], info["times"], info["complete"]), ([3, 4], [0.5, 1], True))
                self.works("info", packed, "--blocks")
                self.works("extract", packed, "-o", back)
                for frame in (3, 4):
                    self.same(source % frame, back % frame, 0)
                compared = self.works("compare", source, packed, "--json").json
                self.assertEqual(compared["max_error"], 0)
                self.assertEqual(compared.get("kept", []), [{"name": one, "identical": True} for one in kept])
                text = self.fails(1, "render", packed, "-o", self.path("x.png"))
                self.assertIn(f"{packed}: no grid has values: ", text)
                self.assertIn("'id' (int32)" if kept else "empty in all frames are 'density'", text)
                if grids:
                    self.assertIn("is empty", self.fails(1, "extract", packed, "-o", self.path("x.npy"), "--field", grids[0]))

    def test_size_and_again_and_joined(self):
        source = str(self.folder / "kept_%04d.vdb")
        self.works("compress", source, "-o", self.path("x.volute"), "--ratio", "100")
        self.works("compress", self.path("x.volute"), "-o", self.path("a.volute"), "--frames", "3:4", "--fps", "50")
        self.works("compress", self.path("x.volute"), "-o", self.path("b.volute"), "--frames", "4:5")
        self.works("compress", str(self.folder / "empty_%04d.vdb"), "-o", self.path("c.volute"), "--size", "2k", "--frames", "4:5")
        self.works("join", self.path("a.volute"), self.path("b.volute"), "-o", self.path("ab.volute"))
        self.works("extract", self.path("ab.volute"), "-o", self.path("ab_%04d.vdb"))
        for frame in (3, 4):
            self.same(source % frame, self.path(f"ab_000{frame}.vdb"), 0)
        # With one that has other grids, and with one that has values.
        self.works("join", self.path("a.volute"), self.path("c.volute"), "-o", self.path("ac.volute"))
        info = self.works("info", self.path("ac.volute"), "--json").json
        self.assertEqual(([one["name"] for one in info["grids"]], info["kept"][0]["name"]), (["density", "velocity", "surface"], "id"))

    def test_every_byte_is_checked(self):
        packed, damaged = self.path("x.volute"), self.path("y.volute")
        self.works("compress", str(self.folder / "kept_%04d.vdb"), "-o", packed)
        whole = packed.read_bytes()
        for place in range(0, len(whole), 7):
            data = bytearray(whole)
            data[place] ^= 16
            damaged.write_bytes(data)
            self.fails(1, "extract", damaged, "-o", self.path("z_%04d.vdb"))


@unittest.skipUnless("VDB_MAKER" in os.environ, "this build has no OpenVDB")
class Extremes(support.TestCase):
    """What the format allows and hardly anybody expects."""

    def setUp(self):
        super().setUp()
        self.made = self.path("extremes")
        self.made.mkdir()
        subprocess.run([os.environ["VDB_MAKER"], "extremes", str(self.made)], check=True)

    def within(self, megabytes, *arguments):
        code, message, peak = self.peak(*arguments)
        self.assertLess(peak, megabytes << 20, message)
        return code, message

    def test_tiles_of_a_million_million_voxels_stay_tiles(self):
        file, packed = self.made / "tiles.vdb", self.path("x.volute")
        for arguments in (("info", file), ("compress", file, "-o", packed), ("info", packed), ("compare", file, packed),
                          ("extract", packed, "-o", self.path("x_%04d.vdb"))):
            code, message = self.within(160, *arguments)
            self.assertEqual(code, 0, message)
        self.assertEqual(self.works("compare", file, packed, "--json").json["max_error"], 0)
        done = subprocess.run([os.environ["VDB_MAKER"], "compare", str(file), str(self.path("x_0000.vdb")), "0"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout)
        for source, advice in ((file, "give --bounds, or raise --max-memory"), (packed, "raise --max-memory")):
            code, message = self.within(160, "render", source, "-o", self.path("x.png"))
            self.assertEqual(code, 1)
            self.assertRegex(message, rf"the tiles of 'density' need \d+ MiB of memory, more than the 4096 MiB allowed; {advice}")
        near = "--bounds=-2.125,-0.125,-0.125,7.875,7.875,7.875"
        code, message = self.within(160, "render", file, near, "-o", self.path("x.png"))
        self.assertEqual(code, 0, message)

    def test_corners_beyond_32_bits(self):
        file = self.made / "corners.vdb"
        for arguments in (("info", file), ("compress", file, "-o", self.path("x.volute")), ("render", file, "-o", self.path("x.png"))):
            code, message = self.within(160, *arguments)
            self.assertEqual(code, 1)
            self.assertIn("indices from (-2147483648, -2147483648, -2147483648) to (2147483647, 2147483647, 2147483647)", message)
        near = "--bounds=-1.125,-1.125,-1.125,1.125,1.125,1.125"
        self.works("compress", file, near, "-o", self.path("x.volute"))

    def test_backgrounds_that_differ_between_frames(self):
        text = self.fails(1, "compress", self.made / "background_%04d.vdb", "-o", self.path("x.volute"))
        self.assertIn("grid 'density', frame 2: its background is 0.5, but 0 in the frames before", text)
        self.assertFalse(self.path("x.volute").exists())

    def test_what_lies_beyond_is_the_background(self):
        """8^3 voxels of 1 to 1.006, around which there is 0.5: means of a level, and what a smaller file is compared with."""
        file, packed = self.made / "background_0002.vdb", self.path("x.volute")
        self.works("compress", file, "-o", packed, "--quality", "measure")
        part, level = self.path("part.vdb"), self.path("level.npy")
        self.works("extract", packed, "-o", part, "--region", "0:3,0:8,0:8")
        said = self.works("compare", file, part, "--json")
        self.assertAlmostEqual(said.json["max_error"], 0.506, delta=1e-3)
        self.assertNotIn("background", said.message)
        self.works("extract", packed, "-o", level, "--region", "0:3,0:8,0:8", "--level", "1")
        values = read_npy(level.read_bytes())[1]
        self.assertAlmostEqual(min(values), 0.75, delta=0.02)
        self.assertAlmostEqual(max(values), 1, delta=0.02)

    def test_bounds_that_cut_are_told(self):
        file, packed = self.made / "background_0001.vdb", self.path("x.volute")  # of 2 m
        for verb, target in (("compress", packed), ("resample", self.path("r.vdb"))):
            cut = (verb, file, "-o", target, "--bounds=-0.125,-0.125,-0.125,0.875,0.875,0.875", "--strict")
            self.assertIn("cut to the bounds" if verb == "compress" else "left out in 1 of 1 frames", self.works(*cut).message)
        self.assertIn("nothing of it lies within the bounds",
                      self.fails(1, "compress", file, "-o", packed, "--bounds=4.875,4.875,4.875,5.875,5.875,5.875", "--strict"))
        self.assertIn("left out", self.fails(1, "resample", file, "-o", self.path("r.vdb"), "--bounds=5,5,5,6,6,6", "--strict"))

    def test_frames_of_different_kinds(self):
        packed = self.path("x.volute")
        self.works("compress", self.made / "kinds_%04d.vdb", "-o", packed, "--max-error", "1e-4", "--fps", "24")
        self.works("extract", packed, "-o", self.path("x_%04d.vdb"))
        for frame in (1, 2, 3):
            done = subprocess.run([os.environ["VDB_MAKER"], "compare", str(self.made / f"kinds_000{frame}.vdb"), str(self.path(f"x_000{frame}.vdb")), "1e-3"],
                                  capture_output=True, text=True)
            self.assertEqual(done.stdout.splitlines()[:-1], ["density new metadata volute:time "], done.stdout)
        # A rate that was given, though the first frame is at 0 s anyway.
        said = self.works("info", self.path("x_%04d.vdb"), "--json")
        self.assertEqual((said.json["times"], said.message), ([0, 2 / 24], ""))

    def test_inactive_voxels_that_are_no_numbers(self):
        file, packed = self.made / "hidden.vdb", self.path("x.volute")
        self.assertEqual(self.works("info", file, "--json").json["grids"][0]["active_voxels"], 513)
        self.assertIn("are no numbers (4 of them)", self.works("compress", file, "-o", packed).message)
        self.assertIn("--keep density", self.fails(1, "compress", file, "-o", self.path("y.volute"), "--strict"))
        self.works("compress", self.made / "background_0001.vdb", "-o", self.path("y.volute"), "--strict")
        self.works("extract", packed, "-o", self.path("x_%04d.vdb"))
        self.assertEqual(self.works("compare", file, self.path("x_0000.vdb"), "--json").json["outside_error"], 0)
        self.assertIn("what inactive voxels hold is not kept", self.works("resample", file, "-o", self.path("r.vdb")).message)
        # A background that is no number counts as 0.
        self.assertIn("the background of 'density' is nan and is taken as 0",
                      self.fails(1, "compress", self.made / "unset.vdb", "-o", packed, "--strict"))
        self.works("compress", self.made / "unset.vdb", "-o", packed)
        self.works("render", packed, "-o", self.path("x.png"), "--size", "16x16")


@unittest.skipUnless("VDB_MAKER" in os.environ, "this build has no OpenVDB")
class Places(support.TestCase):
    """A block of 10^3 voxels of 1 whose grid is turned, sheared, mirrored, or moves: nothing of it is resampled."""

    def setUp(self):
        super().setUp()
        self.blocks = self.path("blocks")
        self.blocks.mkdir()
        subprocess.run([os.environ["VDB_MAKER"], "place", str(self.blocks)], check=True)

    def depth(self, file, x, y, *more):
        """Along z through the world's (x, y)."""
        self.works("render", file, "-o", self.path("d.exr"), "--aov", "optical-depth", "--eye", f"{x},{y},9", "--target", f"{x},{y},0",
                   "--up", "0,1,0", "--ortho", "0.001", "--size", "3x3", "--renderer", "cpu", *more)
        return read_exr(self.path("d.exr")).at(1, 1)

    def place(self, i, j, shear):
        """Of an index of the turned blocks, in the world."""
        x, y, cos, sin = 0.1 * i + shear * j, 0.2 * j, math.cos(math.pi / 6), math.sin(math.pi / 6)
        return 3 + x * cos - y * sin, 2 + x * sin + y * cos

    def test_depth_is_where_the_matrix_says(self):
        at = self.place
        for name, shear in (("turned", 0), ("skewed", 0.04)):
            file = self.blocks / f"{name}.vdb"
            self.works("compress", file, "-o", self.path("x.volute"), "--max-error", "1e-6")
            for source in (file, self.path("x.volute")):
                for i, j, inside in ((5, 5, True), (0, 0, True), (9, 9, True), (9.6, 5, False), (5, -0.6, False), (-0.6, 9, False)):
                    depth = self.depth(source, *at(i, j, shear))
                    self.assertAlmostEqual(depth, 1 if inside else 0, delta=1e-6, msg=(name, source, i, j))
        self.assertAlmostEqual(self.depth(self.blocks / "mirrored.vdb", 0.5, 0.5), 1, delta=1e-6)
        self.assertEqual(self.depth(self.blocks / "mirrored.vdb", 1.1, 0.5), 0)

    def test_what_moves_between_frames(self):
        pattern = self.blocks / "moving_%04d.vdb"
        self.works("compress", pattern, "-o", self.path("x.volute"), "--max-error", "1e-6")
        for source in (pattern, self.path("x.volute")):
            for frame, (low, high), deep in ((0, (-0.03, 0.97), 1), (1, (-0.01, 0.99), 1), (2, (-0.04, 1.96), 2)):
                time = ("--time", str(frame / 25))
                self.assertAlmostEqual(self.depth(source, low + 0.002, 0.5, *time), deep, delta=1e-6, msg=(source, frame))
                self.assertAlmostEqual(self.depth(source, high - 0.002, 0.5, *time), deep, delta=1e-6)
                self.assertEqual(self.depth(source, low - 0.002, 0.5, *time), 0)
                self.assertEqual(self.depth(source, high + 0.002, 0.5, *time), 0)

    def test_a_film_keeps_its_time_where_frames_are_missing(self):
        (self.blocks / "moving_0002.vdb").rename(self.blocks / "moving_0004.vdb")
        said = self.works("render", self.blocks / "moving_%04d.vdb", "-o", self.path("x.mp4"), "--fps", "25", "--size", "32x32", "--json")
        self.assertEqual(said.json["pictures"], 4)
        self.assertIn("25 a second", said.message)
        self.assertIn("until the next one the frame before is shown", said.message)

    def test_images_whose_voxels_grow(self):
        for frame, spacing in enumerate((0.1, 0.2)):
            self.path(f"grows_{frame}.vti").write_text(
                f"""<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian"><ImageData WholeExtent="0 10 0 10 0 10" Origin="0 0 0"
                Spacing="{spacing} {spacing} {spacing}"><Piece Extent="0 10 0 10 0 10"><CellData><DataArray type="Float32" Name="density" format="ascii">
                {"1 " * 1000}</DataArray></CellData></Piece></ImageData></VTKFile>""")
        self.works("compress", self.path("grows_%d.vti"), "-o", self.path("x.volute"), "--max-error", "1e-6")
        for source in (self.path("grows_%d.vti"), self.path("x.volute")):
            for frame, deep in ((0, 1), (1, 2)):
                self.assertAlmostEqual(self.depth(source, 0.99, 0.5, "--time", str(frame / 25)), deep, delta=1e-6, msg=(source, frame))
        self.assertEqual(self.depth(self.path("x.volute"), 1.5, 0.5, "--time", "0"), 0)

    def test_there_and_back(self):
        for name in ("turned", "skewed", "mirrored", "moving_0001", "moving_0003"):
            pattern = self.blocks / ("moving_%04d.vdb" if name.startswith("moving") else f"{name}.vdb")
            self.works("compress", pattern, "-o", self.path("x.volute"), "--max-error", "1e-4")
            self.works("compress", self.path("x.volute"), "-o", self.path("y.volute"), "--max-error", "1e-4", "--field", "density")
            back = self.path("back")
            back.mkdir(exist_ok=True)
            self.works("extract", self.path("y.volute"), "-o", back / ("moving_%04d.vdb" if name.startswith("moving") else f"{name}.vdb"))
            done = subprocess.run([os.environ["VDB_MAKER"], "compare", str(self.blocks / f"{name}.vdb"), str(back / f"{name}.vdb"), "1e-3"],
                                  capture_output=True, text=True)
            self.assertEqual(done.returncode, 0, done.stdout)
            self.works("compare", pattern, self.path("x.volute"))
            nano = self.path("x_%04d.nvdb" if name.startswith("moving") else "x.nvdb")
            self.works("extract", self.path("x.volute"), "-o", nano)
            self.works("compare", pattern, nano)
        self.assertIn("cannot say", self.fails(1, "extract", self.path("x.volute"), "-o", self.path("x_%04d.vti")))
        self.assertIn("cannot say", self.fails(1, "extract", self.path("x.volute"), "-o", self.path("x_%04d.vdb"), "--level", "1"))

    def test_matrices_that_cannot_be_undone(self):
        whole = (self.blocks / "turned.vdb").read_bytes()
        place = whole.index(b"AffineMap") + len(b"AffineMap")
        matrix = struct.unpack_from("<16d", whole, place)
        for what, row, value in (("singular", 4, matrix[:3]), ("zero", 0, (0, 0, 0)), ("nan", 0, (math.nan, 0, 0)), ("inf", 12, (math.inf, 0, 0))):
            changed = matrix[:row] + tuple(value) + matrix[row + 3:]
            bad = self.path(f"{what}_0002.vdb")
            bad.write_bytes(whole[:place] + struct.pack("<16d", *changed) + whole[place + 128:])
            shutil.copy(self.blocks / "turned.vdb", self.path(f"{what}_0001.vdb"))
            for verb in (("compress", "-o", self.path("x.volute")), ("render", "-o", self.path("x.png"))):
                for source in (bad, str(self.path(f"{what}_%04d.vdb"))):
                    text = self.fails(1, verb[0], source, *verb[1:])
                    self.assertIn(f"{bad}, grid 'density': the grid's matrix is not finite, or makes it flat", text)
                    self.assertEqual("(frame 2)" in text, source != bad)

    def test_who_wrote_it_and_what_it_is(self):
        def drawn(name, *more):
            return self.works("render", self.blocks / f"{name}.vdb", "-o", self.path("x.png"), "--size", "16x16", *more).message
        self.assertIn("its y axis points upwards, as in EmberGen, which wrote it; --up z turns z upwards", drawn("ember"))
        self.assertIn("its y axis points upwards, as in Bifrost, which wrote it", drawn("bifrost"))
        self.assertIn("shown as smoke from 'voxel_field'", drawn("bifrost"))
        self.assertNotIn("upwards", drawn("mantaflow"))
        self.works("compress", self.blocks / "bifrost.vdb", "-o", self.path("b.volute"))
        self.assertEqual(self.works("info", self.path("b.volute"), "--json").json["up"], "y")
        self.assertIn("'voxel_field'", self.works("render", self.path("b.volute"), "-o", self.path("x.png"), "--size", "16x16").message)
        self.assertIn("not shown: 'density[1]', 'density[2]'; choose one with --field", drawn("thrice"))
        self.assertIn("the grid '[0]' is read; it also has [1]; choose one with --field", drawn("unnamed"))
        self.assertIn("shown as smoke from '[0]'", drawn("unnamed"))
        self.assertIn("shown as smoke from '[1]'", drawn("unnamed", "--field", "[1]"))
        self.assertIn("'amount' is shown as light: neither its name nor its class says that it is smoke or fire; --preset smoke", drawn("amount"))
        self.assertIn("shown as smoke from 'amount'", drawn("amount", "--preset", "smoke"))

    def test_words(self):
        said = self.works("info", self.blocks / "turned.vdb", "--json").json
        self.assertEqual(len(said["matrix"]), 12)
        self.assertAlmostEqual(said["matrix"][0], math.cos(math.pi / 6))
        self.assertIn("otherwise in other frames", self.works("info", self.blocks / "moving_%04d.vdb").text)
        self.assertIn("makes it flat", self.works("info", self.blocks / "flat.vdb", "--json").json["grids"][0]["problem"])
        for verb in (("compress", "-o", self.path("x.volute")), ("render", "-o", self.path("x.png"))):
            text = self.fails(1, verb[0], self.blocks / "flat.vdb", *verb[1:])
            self.assertIn("flat.vdb, grid 'density': the grid's matrix is not finite, or makes it flat", text)
        # An axis that is stated is that of what is extracted, whoever wrote the original.
        self.works("compress", self.blocks / "upright_0001.vdb", "-o", self.path("up.volute"), "--up", "z")
        self.works("extract", self.path("up.volute"), "-o", self.path("up.vdb"), "--strict")
        self.assertEqual(self.works("info", self.path("up.vdb"), "--json").json["up"], "z")
        self.assertIn("does not say that y points upwards",
                      self.works("resample", self.blocks / "upright_0001.vdb", "-o", self.path("up.npy")).message)
        moving = str(self.blocks / "moving_%04d.vdb")
        self.works("compress", moving, "-o", self.path("m.volute"), "--fps", "24")
        self.works("extract", self.path("m.volute"), "-o", self.path("m_%04d.vdb"), "--frames", "2:4")
        for frames in ("2:4", "2:3"):
            said = self.works("compare", self.path("m_%04d.vdb"), moving, "--frames", frames, "--json")
            self.assertLess(said.json["max_error"], 1e-2)
            self.assertNotIn("elsewhere", said.message)
        self.assertIn("lay it elsewhere", self.fails(1, "compare", self.blocks / "moving_0001.vdb", moving, "--frames", "1:3"))
        upright = self.blocks / "upright_%04d.vdb"
        said = self.works("info", upright, "--fps", "24", "--json")
        self.assertIn("expected one up axis in all frames", said.message)
        self.assertEqual((said.json["frame_numbers"], said.json["times"]), ([1, 2], [0, 1 / 24]))
        for verb in (("compress", "-o", self.path("x.volute")), ("render", "-o", self.path("x.png"), "--size", "16x16")):
            text = self.fails(1, verb[0], upright, *verb[1:])
            self.assertIn("upright_0002.vdb: grid 'density', frame 2: the file does not say which axis points upwards, but", text)
            self.assertIn("upright_0001.vdb was written by Houdini, where y points upwards; expected one up axis in all frames; --up y takes that for all of them", text)
            self.works(verb[0], upright, *verb[1:], "--file-up", "y")
        alone = ("render", self.blocks / "upright_0002.vdb", "-o", self.path("x.png"), "--size", "16x16")
        self.assertIn("does not say which axis points upwards; z is taken for it; --up y", self.works(*alone).message)
        self.assertNotIn("upwards", self.works(*alone, "--up", "z").message)
        self.assertIn("so that no voxel of one is one of the other", self.fails(1, "compare", self.blocks / "turned.vdb", self.blocks / "skewed.vdb"))
        for name in ("turned", "skewed"):
            lit = ("render", self.blocks / f"{name}.vdb", "--preset", "smoke", "--size", "48x48")
            self.works(*lit, "-o", self.path("cpu.exr"), "--renderer", "cpu")
            cpu = read_exr(self.path("cpu.exr")).values
            self.assertGreater(max(cpu), 0.01)
            if volute("info", "--gl").code == 0:
                self.works(*lit, "-o", self.path("gl.exr"), "--renderer", "gl")
                off = max(abs(a - b) for a, b in zip(read_exr(self.path("gl.exr")).values, cpu))
                self.assertLess(off, 3e-3 * max(cpu), name)
        said = self.works("info", self.blocks / "frustum.vdb", "--json").json["grids"][0]
        self.assertTrue(said["frustum"])
        self.assertFalse(said["usable"])
        for verb in (("compress", "-o", self.path("x.volute")), ("render", "-o", self.path("x.png"))):
            text = self.fails(1, verb[0], self.blocks / "frustum.vdb", *verb[1:])
            self.assertIn("frustum", text)
            self.assertIn("volute resample makes", text)
        self.assertIn("bounds along the axes do not crop it", self.fails(2, "compress", self.blocks / "turned.vdb", "-o", self.path("x.volute"),
                                                                         "--bounds=0,0,0,1,1,1"))


@unittest.skipUnless("VDB_MAKER" in os.environ, "this build has no OpenVDB")
class Resampled(Places):
    """The same blocks on other voxels."""
    test_depth_is_where_the_matrix_says = test_what_moves_between_frames = test_images_whose_voxels_grow = None
    test_a_film_keeps_its_time_where_frames_are_missing = None
    test_there_and_back = test_words = None

    def mass(self, file, *more):
        """Of a volume in all frames, the sum of its values times the size of its voxels."""
        said = self.works("resample", file, "-o", self.path("m.npy"), *more, "--json").json
        shape, values = read_npy(self.path("m.npy").read_bytes())
        voxel = math.prod(said["grids"][0]["voxel_size"])
        return [voxel * sum(values[i * len(values) // shape[0]:(i + 1) * len(values) // shape[0]]) for i in range(shape[0])]

    def test_what_is_turned_comes_to_lie_along_the_axes(self):
        for name, shear, mass in (("turned", 0, 2), ("skewed", 0.04, 2)):
            for target in ("straight.vdb", "straight.volute", "straight.nvdb", "straight.vti"):
                self.works("resample", self.blocks / f"{name}.vdb", "-o", self.path(target), "--voxel-size", "0.04")
                self.assertNotIn("matrix", {key for key, value in self.works("info", self.path(target), "--json").json.items() if value})
                for i, j, inside in ((5, 5, True), (1, 1, True), (8, 8, True), (10.6, 5, False), (5, -1.6, False), (-1.6, 9, False)):
                    depth = self.depth(self.path(target), *self.place(i, j, shear))
                    self.assertAlmostEqual(depth, 1 if inside else 0, delta=2e-3, msg=(name, target, i, j))
            self.assertAlmostEqual(self.mass(self.blocks / f"{name}.vdb", "--voxel-size", "0.04")[0], mass, delta=2e-3 * mass)
            self.assertAlmostEqual(self.mass(self.blocks / f"{name}.vdb", "--voxel-size", "0.23")[0], mass, delta=2e-2 * mass)
        self.assertAlmostEqual(self.mass(self.blocks / "mirrored.vdb")[0], 1, delta=1e-5)
        for one, expected in zip(self.mass(self.blocks / "moving_%04d.vdb", "--voxel-size", "0.05"), (1, 1, 8)):
            self.assertAlmostEqual(one, expected, delta=2e-3 * expected)

    def test_what_new_voxels_leave_out_is_told(self):
        moving = self.blocks / "moving_%04d.vdb"
        like = ("--like", self.blocks / "moving_0001.vdb")
        said = self.works("resample", moving, "-o", self.path("l_%04d.vdb"), *like)
        self.assertIn("what lies outside of the new voxels is left out in 1 of 3 frames, most in 3: 875 of 1000 voxels", said.message)
        self.assertNotIn("left out", self.works("resample", like[1], "-o", self.path("l.vdb"), *like).message)

    def test_a_frustum_is_sampled(self):
        source = self.blocks / "frustum.vdb"
        for target in ("box.vdb", "box.volute", "box.npy"):
            self.works("resample", source, "-o", self.path(target), "--voxel-size", "0.005")
        # Along the axis and where only its far end reaches; the lattice states no place for .npy.
        for target in ("box.vdb", "box.volute"):
            bounds = self.works("info", self.path(target), "--json").json["bounds"]
            middle = (bounds[0] + bounds[3]) / 2
            self.assertAlmostEqual(self.depth(self.path(target), middle, middle), 0.5, delta=2e-3)
            self.assertAlmostEqual(self.depth(self.path(target), middle + 0.075, middle), 0.25, delta=0.03)
            self.assertEqual(self.depth(self.path(target), middle + 0.12, middle), 0)
        coarse = self.works("resample", source, "-o", self.path("own.vdb"), "--json").json["grids"][0]
        self.assertGreater(min(coarse["voxel_size"]), 0.01)

    def test_lattices(self):
        turned = self.blocks / "turned.vdb"
        # Its own voxels, stated: values and topology are those of the file.
        info = self.works("info", turned, "--json").json
        self.works("resample", turned, "-o", self.path("same.vdb"), "--like", turned)
        said = self.works("compare", turned, self.path("same.vdb"), "--json").json
        self.assertEqual(said["max_error"], 0)
        for numbers in ("0.2,0,0,5, 0,0.2,0,6, 0,0,0.2,7".replace(" ", ""), "0.1,0.02,0,0,0,0.1,0,0,0,0,0.1,0,0,0,0,1"):
            self.works("resample", turned, "-o", self.path("m.vdb"), "--matrix", numbers)
            back = self.works("info", self.path("m.vdb"), "--json").json
            self.assertEqual(bool(back.get("matrix")), numbers.startswith("0.1"))
        self.assertTrue(info["matrix"])
        said = self.works("resample", turned, "-o", self.path("b.npy"), "--bounds=3,2,1,3.55,2.5,2", "--voxel-size", "0.1", "--json").json
        self.assertEqual(said["grids"][0]["size"], [6, 5, 10])
        self.assertIn("cannot say", self.fails(2, "resample", turned, "-o", self.path("x.npy"), "--like", turned))
        self.assertIn("flat", self.fails(2, "resample", turned, "-o", self.path("x.vdb"), "--matrix", "1,0,0,0,1,0,0,0,0,0,1,0"))
        self.assertIn("three rows of four", self.fails(2, "resample", turned, "-o", self.path("x.vdb"), "--matrix", "1,2,3"))
        self.assertIn("above 0", self.fails(2, "resample", turned, "-o", self.path("x.vdb"), "--voxel-size", "0"))
        text = self.fails(1, "resample", turned, "-o", self.path("x.vdb"), "--voxel-size", "1e-12")
        self.assertIn("--voxel-size", text)
        text = self.fails(1, "resample", turned, "-o", self.path("x.vdb"), "--voxel-size", "1e-3", "--max-memory", "64M")
        self.assertIn("raise --voxel-size", text)

    def test_other_files(self):
        values = [float(1 + i % 7) for i in range(8 * 8 * 8)]
        write_npy(self.path("a.npy"), (8, 8, 8), values)
        said = self.works("resample", self.path("a.npy"), "-o", self.path("b.npy"), "--voxel-size", "0.25", "--basis", "box", "--json").json
        self.assertEqual(said["grids"][0]["size"], [4, 4, 4])
        _, half = read_npy(self.path("b.npy").read_bytes())
        self.assertAlmostEqual(sum(half) * 8, sum(values), delta=1e-3)
        self.works("resample", CACHE, "-o", self.path("c_%04d.vdb"))
        grids = {one["name"]: one for one in self.works("info", self.path("c_0101.vdb"), "--json").json["grids"]}
        self.assertEqual(grids["velocity"]["class"], "staggered")
        self.assertTrue(grids["density"]["half"])
        self.assertNotIn("flame", [one["name"] for one in self.works("info", self.path("c_0100.vdb"), "--json").json["grids"]])
        self.works("resample", CACHE, "-o", self.path("c.volute"), "--frames", "101:102", "--field", "density,solid", "--voxel-size", "0.2")
        self.assertEqual([one["name"] for one in self.works("info", self.path("c.volute"), "--json").json["grids"]], ["density", "solid"])

    def test_nanovdb_takes_any_class_of_vectors(self):
        """NanoVDB knows no vectors of a fog volume, and its own check takes them for damage; OpenVDB, whose arrays are such, has them."""
        shape, values = support.plume(1, 9, channels=3)
        support.write_npy(self.path("rgb.npy"), shape, values)
        self.works("compress", self.path("rgb.npy"), "-o", self.path("rgb.volute"), "--max-error", "1e-3")
        self.works("extract", self.path("rgb.volute"), "-o", self.path("rgb.nvdb"))
        self.works("extract", self.path("rgb.volute"), "-o", self.path("rgb.vdb"))
        same = lambda name: self.works("compare", self.path("rgb.vdb"), self.path(name), "--json").json["max_error"]
        self.assertEqual(same("rgb.nvdb"), 0)
        self.works("resample", self.path("rgb.vdb"), "-o", self.path("moved.nvdb"), "--voxel-size", "0.7")
        self.assertEqual(self.works("info", self.path("moved.nvdb"), "--json").json["grids"][0]["type"], "vec3s")
        data = bytearray(self.path("rgb.nvdb").read_bytes())
        header, facts = 16, 176
        begin = header + facts + struct.unpack_from("<I", data, header + 136)[0]
        self.assertEqual(data[begin:begin + 8], b"NanoVDB0")
        checksum, grid_class, fog_volume = begin + 8, begin + 632, 2
        data[grid_class:grid_class + 4] = struct.pack("<I", fog_volume)
        self.path("wrong.nvdb").write_bytes(data)
        self.assertIn("a grid is damaged", self.fails(1, "info", self.path("wrong.nvdb")))
        # The first checksum is of all up to the end of the root's table, which has a tile where the first node of the tree begins.
        tree = begin + 672
        root = tree + struct.unpack_from("<q", data, tree + 24)[0]
        upper = tree + struct.unpack_from("<q", data, tree + 16)[0]
        self.assertLess(root, upper)
        data[checksum:checksum + 4] = struct.pack("<I", zlib.crc32(data[begin + 16:upper]))
        self.path("fog.nvdb").write_bytes(data)
        self.assertEqual(same("fog.nvdb"), 0)
        data[-40] ^= 1
        self.path("broken.nvdb").write_bytes(data)
        self.assertIn("a grid is damaged", self.fails(1, "info", self.path("broken.nvdb")))

    def test_nanovdb(self):
        self.works("extract", CACHE, "-o", self.path("n_%04d.nvdb"))
        self.works("extract", CACHE, "-o", self.path("v_%04d.vdb"))
        said = self.works("compare", self.path("v_%04d.vdb"), self.path("n_%04d.nvdb"), "--json").json
        self.assertEqual(sorted(one["name"] for one in said["grids"]), NAMES)
        for one in said["grids"]:
            self.assertLessEqual(one["relative_rms"], 1e-3, one)  # halves are floats there
            if one["name"] in ("temperature", "velocity", "solid") and not one["empty"]:
                self.assertLessEqual(one["max_error"], 0 if one["name"] == "temperature" else 1e-2, one)
        self.works("compress", self.path("n_%04d.nvdb"), "-o", self.path("n.volute"), "--fps", "50")
        self.assertIn("does not say when the frames are shown", self.works("extract", self.path("n.volute"), "-o", self.path("f_%04d.nvdb")).message)
        self.works("render", self.path("n_0101.nvdb"), "-o", self.path("n.png"), "--size", "32x32")
        data = bytearray(self.path("n_0101.nvdb").read_bytes())
        # Compressed by zlib, as NanoVDB's own tools write it.
        self.works("resample", CACHE, "-o", self.path("one.nvdb"), "--field", "density", "--frames", "101:102")
        one = self.path("one.nvdb").read_bytes()
        header, facts = 16, 176
        size, names = struct.unpack_from("<Q", one, header)[0], struct.unpack_from("<I", one, header + 136)[0]
        begin = header + facts + names
        self.assertEqual(len(one), begin + size)
        packed = zlib.compress(one[begin:])
        zipped = bytearray(one[:begin]) + struct.pack("<Q", len(packed)) + packed
        zipped[14:16] = zipped[header + 168:header + 170] = struct.pack("<H", 1)
        zipped[header + 8:header + 16] = struct.pack("<Q", len(packed) + 8)
        self.path("zipped.nvdb").write_bytes(zipped)
        self.assertEqual(self.works("compare", self.path("one.nvdb"), self.path("zipped.nvdb"), "--json").json["max_error"], 0)
        self.path("zipped.nvdb").write_bytes(zipped[:-9])
        self.assertIn("zipped.nvdb", self.fails(1, "render", self.path("zipped.nvdb"), "-o", self.path("x.png")))
        for what, expected in (((7, b"2"), "of a newer kind"), ((8, struct.pack("<I", 33 << 21)), "version 33.0.0"),
                               ((len(data) // 2, bytes([data[len(data) // 2] ^ 1])), "damaged")):
            broken = bytearray(data)
            broken[what[0]:what[0] + len(what[1])] = what[1]
            self.path("broken.nvdb").write_bytes(broken)
            self.assertIn(expected, self.fails(1, "compress", self.path("broken.nvdb"), "-o", self.path("x.volute")))
        self.path("broken.nvdb").write_bytes(data[:len(data) // 2])
        self.assertIn("broken.nvdb", self.fails(1, "render", self.path("broken.nvdb"), "-o", self.path("x.png")))


class Grids(support.TestCase):
    def unpack(self):
        """The cache as .vdb files, in a folder of their own."""
        folder = self.path("cache")
        folder.mkdir()
        result = volute("extract", CACHE, "-o", folder / "c_%04d.vdb")
        if "this build has no" in result.message:
            self.skipTest(result.message)
        self.assertEqual(result.code, 0, result.message)
        return folder

    def test_info_lists_all_grids(self):
        said = self.works("info", CACHE, "--json").json
        grids = {one["name"]: one for one in said["grids"]}
        self.assertEqual(sorted(grids), NAMES)
        self.assertTrue(said["complete"])
        self.assertTrue(grids["fuel"]["empty"])
        self.assertTrue(grids["density"]["half"])
        self.assertFalse(grids["temperature"]["half"])
        self.assertEqual((grids["velocity"]["type"], grids["velocity"]["class"]), ("vec3s", "staggered"))
        self.assertEqual(grids["solid"]["class"], "level set")
        for name in set(NAMES) - {"fuel"}:
            self.assertGreater(grids[name]["active_voxels"], 0)
            self.assertGreater(grids[name]["bytes"], 0)
            self.assertLess(grids[name]["minimum"], grids[name]["maximum"])
        text = self.works("info", CACHE).text
        self.assertIn("vec3s (half), staggered", text)
        self.assertIn("empty", text)
        one = self.works("info", CACHE, "--field", "velocity", "--json").json
        self.assertEqual((one["grid"], one["channels"]), ("velocity", 3))
        drawn = self.works("render", CACHE, "--field", "velocity", "-o", self.path("v.png"), "--size", "16x16")
        self.assertIn("'velocity' is shown as light, its values as red, green and blue, none where they are below 0", drawn.message)

    def test_grids_that_play_no_part_are_named(self):
        drawn = lambda *words: self.works("render", CACHE, "-o", self.path("x.exr"), "--size", "8x8", *words, measured=False).message
        self.assertIn("not shown: 'velocity', 'solid'; choose one with --field", drawn())
        self.assertNotIn("not shown", drawn("--field", "density"))
        depth = ("--aov", "optical-depth", "--extinction", "1", "--field")
        self.assertIn("'velocity' has three channels, whose mean is taken as the extinction", drawn(*depth, "velocity"))
        self.assertIn("'solid' is a level set: it counts as 1 inside", drawn(*depth, "solid"))
        self.assertIn("c_0100.vdb, whose grids are listed, lacks 'flame'", self.works("info", self.unpack()).message)

    def test_there_and_back(self):
        folder = self.unpack()
        self.assertEqual(len(list(folder.iterdir())), 3)
        packed = self.path("again.volute")
        result = self.works("compress", folder, "-o", packed, "--json", "--rms", "1e-3", "--rms-of", "velocity=2e-2")
        self.assertEqual(result.message.count("c_0100.vdb: no grid named 'flame': it is taken as empty in 1 of 3 frames: 100"), 1, result.message)
        said = result.json
        grids = {one["name"]: one for one in said["grids"]}
        self.assertEqual(sorted(grids), NAMES)
        self.assertEqual(said["input_bytes"], sum(file.stat().st_size for file in folder.iterdir()))
        self.assertEqual(said["bytes"], packed.stat().st_size)
        self.assertEqual(said["raw_bytes"], sum(one["raw_bytes"] for one in grids.values()))
        for name, bound in [("density", 1e-3), ("temperature", 1e-3), ("solid", 1e-3), ("velocity", 2e-2)]:
            self.assertLessEqual(grids[name]["relative_rms"], bound)
        self.assertGreater(grids["velocity"]["relative_rms"], 1e-3)
        # What comes out of it is within those bounds too, halves included, and says the same of itself.
        back = self.path("back")
        back.mkdir()
        self.works("extract", packed, "-o", back / "c_%04d.vdb")
        result = self.works("compare", folder, back, "--json", "--difference", self.path("d.png"))
        self.assertEqual(result.message.count("taken as empty in 1 of 3 frames: 100"), 2, result.message)  # of both caches
        compared = result.json
        for one in compared["grids"]:
            self.assertLessEqual(one["relative_rms"], 2e-2 if one["name"] == "velocity" else 1e-3, one)
            self.assertEqual(len(one["by_frame"]), 0 if one["empty"] else 3)
        self.assertEqual(compared["worst_grid"], "velocity")
        self.assertGreater(self.works("info", self.path("d.png"), "--json").json["size"][0], 20)
        for name in ("c_0100.vdb", "c_0102.vdb"):
            listed = [{one["name"]: (one["type"], one["class"], one["half"], one["voxel_size"])
                       for one in self.works("info", place / name, "--json").json["grids"]} for place in (folder, back)]
            self.assertEqual(listed[0], listed[1])
        # A flame that begins to burn in the second frame.
        self.assertNotIn("flame", [one["name"] for one in self.works("info", back / "c_0100.vdb", "--json").json["grids"]])

    def test_a_region_keeps_what_describes_a_grid(self):
        """Type, class, half floats, metadata and the indices of its voxels, through extract --region and compress --bounds alike."""
        folder = self.unpack()
        says = lambda file, name: [(one["type"], one["class"], one["half"], one["voxel_size"])
                                   for one in self.works("info", file, "--json").json["grids"] if one["name"] == name]
        whole = folder / "c_0101.vdb"
        for name in ("velocity", "density"):
            told = self.works("info", CACHE, "--field", name, "--json").json
            size = told["size"]
            low, high = told["bounds"][:3], told["bounds"][3:]
            region = f"1:{size[0]},0:{size[1]},1:{size[2]}"
            self.works("extract", CACHE, "-o", self.path("part_%04d.vdb"), "--field", name, "--region", region, "--frames", "101:102", "--strict")
            part = self.path("part_0101.vdb")
            self.assertEqual(says(part, name), says(whole, name))
            low = [low[axis] + (high[axis] - low[axis]) / size[axis] * (axis != 1) for axis in range(3)]
            bounds = "--bounds=" + ",".join(f"{v:.9g}" for v in low + high)
            self.works("compress", folder / "c_%04d.vdb", "-o", self.path("cut.volute"), "--field", name, bounds, "--rms", "1e-6")
            self.works("extract", self.path("cut.volute"), "-o", self.path("cut_%04d.vdb"))
            cut = self.path("cut_0101.vdb")
            self.assertEqual(says(cut, name), says(whole, name))
            compared = self.works("compare", part, cut, "--field", name, "--strict", "--json").json
            self.assertLessEqual(compared["relative_rms"], 1e-3)

    def test_what_lies_elsewhere_is_told(self):
        values = struct.pack("<8f", *range(8))
        write_npy(self.path("a.npy"), (1, 2, 2, 2), values)
        for name, bounds in (("a", "0,0,0,2,2,2"), ("moved", "1,0,0,3,2,2"), ("large", "0,0,0,200,200,200")):
            self.works("compress", self.path("a.npy"), "-o", self.path(f"{name}.volute"), "--bounds", bounds, "--rms", "1e-6")
        self.works("compare", self.path("a.volute"), self.path("a.volute"), "--strict")
        for name in ("moved", "large"):
            self.assertIn("lie elsewhere", self.fails(1, "compare", self.path("a.volute"), self.path(f"{name}.volute"), "--strict"))

    def test_the_stated_grid_is_the_one_that_is_shown(self):
        for name, says in (("temperature", "fire from 'temperature'"), ("flame", "fire from 'flame'"), ("density", "smoke from 'density'")):
            shown = volute("render", CACHE, "-o", self.path("x.png"), "--size", "16x16", "--field", name)
            self.assertEqual(shown.code, 0, shown.message)
            self.assertIn(says, shown.message)
            self.assertEqual("smoke from" in shown.message, name == "density", shown.message)

    def test_a_sequence_with_a_frame_that_is_cut_is_not_whole(self):
        folder = self.unpack()
        frame = folder / "c_0101.vdb"
        frame.write_bytes(frame.read_bytes()[:-200])
        self.assertIn("c_0101.vdb", self.fails(1, "info", folder))

    def test_a_level_set_stands_as_its_smoke_does(self):
        """As geometry and as a volume, where a program with y upwards wrote it."""
        source = VdbFile(self.unpack() / "c_0101.vdb")
        entries = 8 + 4 + 8 + 1 + 36
        (count,) = struct.unpack_from("<I", source.head, entries)
        source.head = source.head[:entries] + struct.pack("<I", count + 1) + b"".join(map(counted, (b"creator", b"string", b"Houdini"))) + source.head[entries + 4:]
        source.write(self.path("solid.vdb"), [(b"solid", b"solid")])
        scene = {"format": "volute-scene-2", "background": [1, 0, 0], "media": [], "geometry": [{"file": "solid.vdb"}]}
        def says(up):
            scene["geometry"][0]["up"] = up
            self.path("scene.json").write_text(json.dumps(scene))
            return self.works("render", self.path("scene.json"), "-o", self.path(f"{up}.exr"), "--size", "24x24", "--eye", "9,0,0", "--target", "0,0,0", "--fov", "60").message
        self.assertIn("its y is turned upwards", says("format"))
        self.assertNotIn("its y is turned", says("z") + says("y"))
        for up, same in (("y", True), ("z", False)):
            self.assertEqual(self.works("compare", self.path("format.exr"), self.path(f"{up}.exr"), "--json").json["rms"] == 0, same)

    def test_components_on_faces_are_told_where_they_do_not_stay_there(self):
        level = ("extract", CACHE, "-o", self.path("l_%04d.vdb"), "--level", "1", "--field")
        self.assertNotIn("staggered", self.works(*level, "density").message)
        self.assertIn("'velocity' is staggered", self.works(*level, "velocity").message)
        turned = ("resample", CACHE, "-o", self.path("t_%04d.vdb"), "--field", "velocity", "--matrix", "0,-.1,0,0,.1,0,0,0,0,0,.1,0")
        self.assertIn("'velocity' is staggered", self.works(*turned).message)
        for file, kind in ((self.path("t_0101.vdb"), ""), (self.path("l_0101.vdb"), "staggered")):
            (grid,) = self.works("info", file, "--json").json["grids"]
            self.assertEqual(grid["class"], kind)

    def test_a_time_of_six_digits_is_that_of_its_frame(self):
        """Frame 101 begins at 0.04 s."""
        for name, time in (("before", "0.0399"), ("nearly", "0.039999"), ("then", "0.04")):
            self.works("render", CACHE, "-o", self.path(f"{name}.exr"), "--size", "24x24", "--time", time)
        same = lambda name: self.works("compare", self.path(f"{name}.exr"), self.path("then.exr"), "--json").json["rms"]
        self.assertEqual(same("nearly"), 0)
        self.assertGreater(same("before"), 0)

    def test_originals_that_are_replaced_are_told(self):
        """Files of other programs have random identifiers, of 36 characters from byte 21 on; those of an earlier run are replaced as ever."""
        folder = self.unpack()
        self.works("extract", CACHE, "-o", folder / "c_%04d.vdb", "--strict")
        for file in folder.glob("c_*.vdb"):
            data = file.read_bytes()
            file.write_bytes(data[:21] + b"0f5b3c52-7a1e-4d6b-9c33-5d2a7e90b1c4" + data[57:])
        before = (folder / "c_0101.vdb").read_bytes()
        self.assertIn("not written by Volute", self.fails(1, "extract", CACHE, "-o", folder / "c_%04d.vdb", "--strict"))
        self.assertEqual((folder / "c_0101.vdb").read_bytes(), before)
        self.works("extract", CACHE, "-o", folder / "d_%04d.vdb", "--strict")
        self.works("extract", CACHE, "-o", folder / "c_%04d.nvdb", "--field", "density")
        self.assertNotIn("not written", self.works("extract", CACHE, "-o", folder / "c_%04d.nvdb", "--field", "density").message)
        self.assertIn("c_0102.vdb was not", self.works("extract", CACHE, "-o", folder / "c_%04d.vdb", "--frames", "102:103").message)
        self.assertIn("1 more were not", self.works("extract", CACHE, "-o", folder / "c_%04d.vdb").message)
        self.works("extract", CACHE, "-o", folder / "c_%04d.vdb", "--strict")

    def test_parts_of_a_cache_are_joined(self):
        """One frame and two of them: volumes grow from one to the other, and the flame is in the second alone."""
        folder = self.unpack()
        self.works("compress", folder, "-o", self.path("a.volute"), "--frames", "100:101", "--rms", "1e-3")
        self.works("compress", folder, "-o", self.path("b.volute"), "--frames", "101:103", "--rms", "1e-3")
        said = self.works("join", self.path("b.volute"), self.path("a.volute"), "-o", self.path("all.volute"), "--json").json
        self.assertEqual((said["frames"], said["exact"]), (3, False))
        back = self.path("back")
        back.mkdir()
        self.works("extract", self.path("all.volute"), "-o", back / "c_%04d.vdb")
        compared = self.works("compare", folder, back, "--json").json
        self.assertEqual(sorted(one["name"] for one in compared["grids"]), NAMES)
        for one in compared["grids"]:
            self.assertLessEqual(one["relative_rms"], 5e-3, one)
        for name in ("c_0100.vdb", "c_0101.vdb", "c_0102.vdb"):
            listed = [{one["name"]: (one["type"], one["class"], one["half"], one["voxel_size"])
                       for one in self.works("info", place / name, "--json").json["grids"]} for place in (folder, back)]
            self.assertEqual(listed[0], listed[1])

    def test_the_cache_against_its_volute(self):
        folder = self.unpack()
        self.works("compress", folder, "-o", self.path("x.volute"), "--max-error", "0.002", "--field", "density,solid")
        for one in self.works("compare", folder, self.path("x.volute"), "--field", "density,solid", "--json").json["grids"]:
            self.assertLessEqual(one["max_error"], 0.002)
        self.assertIn("no grid named 'temperature'", self.fails(1, "compare", folder, self.path("x.volute")))

    def test_a_size_and_a_ratio_are_of_the_whole_file(self):
        folder = self.unpack()
        said = self.works("compress", folder, "-o", self.path("x.volute"), "--size", "9500", "--json").json
        self.assertLessEqual(self.path("x.volute").stat().st_size, 9500)
        self.assertGreater(self.path("x.volute").stat().st_size, 6500)
        self.assertEqual(len(said["grids"]), 6)
        said = self.works("compress", CACHE, "-o", self.path("y.volute"), "--ratio", "30", "--json").json
        self.assertGreaterEqual(said["ratio"], 30)
        for size in ("2000", "100"):
            self.assertIn("cannot be made as small", self.fails(1, "compress", folder, "-o", self.path("z.volute"), "--size", size))
        said = self.works("compress", folder, "-o", self.path("y.volute"), "--size", "10000000", "--json").json
        self.assertTrue(any("less than half of the 10000000 that" in remark["sentence"] for remark in said["remarks"]))
        self.assertFalse(self.path("z.volute").exists())

    def test_an_error_that_is_stated_is_kept_within_a_size(self):
        said = self.works("compress", CACHE, "-o", self.path("x.volute"), "--size", "12000", "--rms-of", "temperature=0.0005", "--json").json
        self.assertLessEqual({one["name"]: one for one in said["grids"]}["temperature"]["support_rms"], 0.0005)
        self.assertLessEqual(self.path("x.volute").stat().st_size, 12000)
        self.assertIn("names 'solid' twice", self.fails(2, "compress", CACHE, "-o", self.path("y.volute"), "--rms-of", "solid=0.1,solid=0.2"))
        self.assertIn("grid 'solid' is to be kept, and is not one of the grids to be compressed",
                      self.fails(2, "compress", self.unpack(), "-o", self.path("y.volute"), "--field", "density", "--keep", "solid"))

    def test_a_grid_against_the_array_that_was_taken_out_of_it(self):
        self.works("extract", CACHE, "-o", self.path("{grid}.npy"))
        a, b = self.path("temperature.npy"), self.path("velocity.npy")
        for pair in ((a, CACHE), (CACHE, a)):
            self.assertEqual(self.works("compare", *pair, "--field", "temperature", "--json").json["max_error"], 0)
        self.assertIn("no named grids", self.fails(2, "compare", a, b, "--field", "temperature"))

    def test_frames_beside_each_other_are_decoded_once(self):
        decoded = lambda *words: self.works("extract", CACHE, "-o", self.path("x_%04d.vdb"), "--field", "density,temperature", *words, "--json").json["blocks_decoded"]
        self.assertLessEqual(decoded("--frames", "102:104"), decoded())

    def test_an_unknown_format_is_told_before_its_grids(self):
        for command in ("resample", "extract"):
            self.assertIn("'x.xyz' has an unknown format", self.fails(2, command, CACHE, "-o", "x.xyz"))

    def test_options_for_other_files_of_voxels(self):
        self.assertIn("--values is for volumes of voxels of other formats, smoke on meshes and FDS cases; ", self.fails(2, "info", CACHE, "--values"))

    def test_one_grid_of_several(self):
        for verb in ("extract", "resample"):
            text = self.fails(2, verb, CACHE, "-o", self.path("x.npy"), *(["--voxel-size", "0.2"] if verb == "resample" else []))
            for word in [*[name for name in NAMES if verb == "extract" or name != "fuel"], "--field", "{grid}"]:
                self.assertIn(word, text)
            self.assertFalse(self.path("x.npy").exists())
        self.assertIn("'x_{foo}.npy' has {foo}", self.fails(2, "extract", CACHE, "-o", "x_{foo}.npy"))
        self.assertIn("distances to a surface",
                      self.works("extract", CACHE, "-o", self.path("x.npy"), "--field", "solid").message)
        self.path("x.npy").unlink()
        self.works("extract", CACHE, "-o", self.path("x.npy"), "--field", "velocity")
        shape, values = read_npy(self.path("x.npy").read_bytes())
        self.assertEqual((shape[0], shape[4]), (3, 3))
        listed = self.works("extract", CACHE, "-o", self.path("all_{grid}.npy"), "--json").json["outputs"]
        self.assertEqual(sorted(one["output"] for one in listed),
                         sorted(str(self.path(f"all_{name}.npy")) for name in NAMES if name != "fuel"))
        self.assertEqual(sorted(self.files()), sorted(["x.npy"] + [f"all_{name}.npy" for name in NAMES if name != "fuel"]))
        self.assertEqual(self.path("all_velocity.npy").read_bytes(), self.path("x.npy").read_bytes())
        self.assertIn("did you mean 'flame'", self.fails(1, "extract", CACHE, "-o", self.path("y.npy"), "--field", "flam"))
        self.assertIn("is empty", self.fails(1, "extract", CACHE, "-o", self.path("y.npy"), "--field", "fuel"))
        self.works("compress", CACHE, "-o", self.path("one.volute"), "--field", "density")
        self.assertEqual([one["name"] for one in self.works("info", self.path("one.volute"), "--json").json["grids"]], ["density"])

    def test_presets_find_their_grids(self):
        shown = volute("render", CACHE, "-o", self.path("x.png"), "--size", "48x48")
        self.assertEqual(shown.code, 0, shown.message)
        self.assertIn("smoke from 'density'", shown.message)
        self.assertIn("fire from 'flame'", shown.message)
        self.assertIn("'velocity'", self.fails(2, "render", CACHE, "-o", self.path("x.png"), "--field", "velocity", "--preset", "fire"))

    def test_a_cache_of_several_grids_is_not_shown_by_the_name_of_its_file(self):
        shutil.copy(CACHE, self.path("fire.volute"))
        shown = volute("render", self.path("fire.volute"), "-o", self.path("x.png"), "--size", "16x16")
        self.assertIn("smoke from 'density'", shown.message)
        self.assertIn("fire from 'flame'", shown.message)

    def test_a_grid_without_a_name_is_shown_by_the_name_of_its_file(self):
        source = VdbFile(self.unpack() / "c_0101.vdb")
        for name, says in (("thick_smoke.vdb", "smoke from '[0]'"), ("campfire.vdb", "fire from '[0]'")):
            source.write(self.path(name), [(b"\x1e0", b"density")])  # as OpenVDB writes an empty name
            self.assertIn(says, self.works("render", self.path(name), "-o", self.path("x.png"), "--size", "16x16").message)

    def test_damage_is_told_with_the_grid(self):
        broken = self.path("broken.volute")
        data = bytearray(CACHE.read_bytes())
        data[-3] ^= 1
        broken.write_bytes(data)
        result = volute("info", broken)
        self.assertEqual(result.code, 1)
        self.assertIn("grid 'flame'", result.text)
        self.assertEqual(volute("extract", broken, "-o", self.path("d.npy"), "--field", "velocity").code, 0)
        self.assertEqual(volute("extract", broken, "-o", self.path("v.npy"), "--field", "flame").code, 1)
        self.works("extract", broken, "-o", self.path("v.npy"), "--field", "flame", "--partial")
        broken.write_bytes(data[:len(data) // 2])
        self.assertEqual(volute("extract", broken, "-o", self.path("e.npy"), "--field", "density").code, 1)

    def test_joining_a_file_with_itself_is_refused(self):
        self.assertIn("parts that do not overlap", self.fails(1, "join", CACHE, CACHE, "-o", self.path("x.volute")))

    def thirty_grids(self, name, names):
        """Three frames of 30 grids, copies of the cache's, in a folder."""
        self.assertEqual(len({new for new, _ in names}), 30)
        self.path(name).mkdir()
        for file in sorted(self.path("cache").iterdir()):
            VdbFile(file).write(self.path(name) / file.name, names)
        return self.path(name)

    def test_thirty_grids_of_which_one_is_empty_play(self):
        self.unpack()
        copies = [(b"copy%02d" % i, b"density") for i in range(28)]
        one = self.thirty_grids("one", [(b"fuel", b"fuel"), (b"density", b"density"), *copies])
        grids = self.works("info", one / "c_0100.vdb", "--json").json["grids"]
        self.assertEqual(len(grids), 30)
        self.assertEqual([grid["name"] for grid in grids if not grid["active_voxels"]], ["fuel"])
        self.plays(one, "smoke from 'density'")
        packed = self.path("one.volute")
        self.works("compress", one, "-o", packed)
        self.assertEqual(len(self.works("info", packed, "--json").json["grids"]), 30)
        self.plays(packed, "smoke from 'density'")

    def test_thirty_grids_play_whose_usual_one_is_empty(self):
        self.unpack()
        copies = [(b"copy%02d" % i, b"density") for i in range(29)]
        folder = self.thirty_grids("usual", [(b"density", b"fuel"), *copies])
        self.plays(folder, "the grid 'density' is empty, so 'copy00' is read instead")
        self.assertIn("grid 'density' is empty", self.fails(1, "render", folder, "-o", self.path("x.png"), "--field", "density"))

    def plays(self, cache, says):
        """A picture of each frame, none of them black, and the viewer's."""
        result = volute("render", cache, "-o", self.path("p_%04d.exr"), "--size", "32x24")
        self.assertEqual(result.code, 0, result.message)
        self.assertIn(says, result.message)
        pictures = sorted(self.folder.glob("p_*.exr"))
        self.assertEqual(len(pictures), 3)
        for picture in pictures:
            self.assertGreater(self.works("info", picture, "--json").json["maximum"], 0)
            picture.unlink()
        if "view" in volute("help").text and volute("info", "--gl").code == 0:
            self.works("view", cache, "--screenshot", self.path("s.png"), "--size", "320x200", "--no-panels", "--time", "0.08")
            self.path("s.png").unlink()

    def test_numbered_npy_files_are_a_sequence(self):
        shape, values = support.plume(3, 8)
        for i in range(3):
            write_npy(self.path(f"f_{4 + 2 * i:04}.npy"), shape[1:], values[512 * i:512 * (i + 1)])
        said = self.works("info", self.folder, "--json").json
        self.assertEqual((said["frames"], said["frame_numbers"]), (3, [4, 8]))
        for source in (self.folder, self.path("f_%04d.npy")):
            self.works("compress", source, "-o", self.path("x.volute"))
            self.works("compare", source, self.path("x.volute"))
        write_npy(self.path("g_0001.npy"), shape[1:], values[:512])
        self.assertIn("2 sequences, f_####.npy (3 files) and g_####.npy (1 file)", self.fails(2, "info", self.folder))
        self.path("g_0001.npy").unlink()
        self.path("f_0006.npy").unlink()
        write_npy(self.path("f_0010.npy"), shape[1:], values[:512])
        write_npy(self.path("f_0012.npy"), shape[1:], values[:512])
        self.assertIn("1 of the frames 4 to 12 is missing: 6", volute("compress", self.path("f_%04d.npy"), "-o", self.path("y.volute")).message)


if __name__ == "__main__":
    support.main()
