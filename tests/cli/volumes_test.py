# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Volumes through the program and back, measured here with code of our own."""
import array
import itertools
import json
import math
import pathlib
import shutil
import struct
import subprocess

import support
from meaning_formats import netcdf
from pictures import read_exr
from render_test import read_png
from support import read_npy, volute, write_npy


def difference(a, b):
    """(relative RMS, largest error) by the definition."""
    square = math.fsum((x - y) ** 2 for x, y in zip(a, b)) / len(a)
    return math.sqrt(square) / (max(a) - min(a)), max(abs(x - y) for x, y in zip(a, b))


class Volumes(support.TestCase):
    def round_trip(self, *target, **shape):
        source = self.make_npy(**shape)
        packed, back = self.path("x.volute"), self.path("back.npy")
        said = self.works("compress", source, "-o", packed, "--json", *target).json
        self.works("extract", packed, "-o", back)
        shape_in, values = read_npy(source.read_bytes())
        shape_out, decoded = read_npy(back.read_bytes())
        self.assertEqual(shape_in, shape_out)
        rms, worst = difference(values, decoded)
        self.assertAlmostEqual(rms, said["relative_rms"], delta=1e-6 * max(rms, 1e-3))
        self.assertAlmostEqual(worst, said["max_error"], delta=1e-6)
        self.assertEqual(said["bytes"], packed.stat().st_size)
        self.assertEqual(said["raw_bytes"], 4 * len(values))
        self.assertEqual(sorted(self.files()), ["back.npy", "in.npy", "x.volute"])
        return rms, worst, said

    def test_a_preset_says_what_it_decides_and_not_what_the_scene_states(self):
        write_npy(self.path("a.npy"), (4, 4, 4), [float(i % 4 > 0) for i in range(64)])

        def said(**entry):
            self.path("scene.json").write_text(json.dumps({
                "format": "volute-scene-2", "camera": {"eye": [-9, 2, 2], "target": [2, 2, 2], "fov": 40, "size": [8, 8]},
                "media": [{"kind": "volume", "file": "a.npy", "preset": "smoke", **entry}]}))
            return self.works("render", self.path("scene.json"), "-o", self.path("a.png")).message

        self.assertRegex(said(), "smoke from .*, extinction [0-9.]+, albedo 0.9, asymmetry 0.3")
        self.assertRegex(said(extinction=0.25), r"smoke from .*1\), albedo 0.9, asymmetry 0.3")
        self.assertRegex(said(extinction=0.25, albedo=[0.5] * 3), r"smoke from .*1\), asymmetry 0.3")

    def test_optical_depths_are_as_the_unit_says(self):
        """Six voxels of 0.5 m of 0.5, along x, whatever the file, the scene and the preset."""
        look = {"eye": [-9, 1.25, 1], "target": [1, 1.25, 1], "ortho": 0.01, "size": [2, 2]}
        self.path("camera.json").write_text(json.dumps(look))

        def depth(source, *more, aov="optical-depth", code=0):
            options = ("render", self.path(source), "-o", self.path("x.exr"), "--aov", aov, *more)
            if not source.endswith(".json"):
                options += ("--camera", self.path("camera.json"))
            if code:
                return self.fails(code, *options)
            message = self.works(*options).message
            return read_exr(self.path("x.exr")).values[0], message

        def scene(**entry):
            self.path("scene.json").write_text(json.dumps({
                "format": "volute-scene-2", "camera": look, "media": [{"kind": "volume", "file": "a.nc", **entry}]}))
            return "scene.json"

        for unit, factor in (("1/m", 1), ("m-1", 1), ("1/cm", 100), ("1/km", 1e-3), ("", 1)):
            with self.subTest(unit):
                self.path("a.nc").write_bytes(netcdf(units={"s": unit}, change=lambda values: [0.5] * len(values)))
                found, message = depth("a.nc")
                self.assertAlmostEqual(found, 1.5 * factor, delta=1e-5 * factor)
                self.assertEqual("is taken as the extinction" in message, factor != 1)
                passed, _ = depth("a.nc", aov="transmittance")
                self.assertAlmostEqual(passed, math.exp(-1.5 * factor), delta=1e-6)
                self.assertAlmostEqual(depth("a.nc", "--extinction", 2)[0], 3, delta=1e-5)
                self.assertAlmostEqual(depth(scene(extinction=2))[0], 3, delta=1e-5)
                self.assertEqual(depth(scene(extinction=0))[0], 0)
                found, message = depth(scene())
                self.assertAlmostEqual(found, 1.5 * factor if unit else 0, delta=1e-5 * factor)
                self.assertEqual("is taken as the extinction" in message, bool(unit))
                for said in (depth("a.nc", "--preset", "smoke"), depth(scene(preset="smoke"))):
                    if unit:
                        self.assertAlmostEqual(said[0], 1.5 * factor, delta=1e-5 * factor)
                        self.assertIn("smoke from 'soot' (0 to 0.5), albedo", said[1])
                    else:
                        self.assertRegex(said[1], "smoke from 'soot' .*, extinction [0-9.]+, albedo")
        for unit in ("dB/m", "kg/m3", "K"):
            self.path("a.nc").write_bytes(netcdf(units={"s": unit}))
            self.assertIn(f"'soot' is in {unit}, which does not say how much light it takes away: it would hide nothing; give --extinction",
                          depth("a.nc", code=2))
            self.assertGreater(depth("a.nc", "--extinction", 1)[0], 1)

    def test_coordinates_of_arrays_are_heights_and_directions(self):
        def written(*more, **how):
            self.path("a.nc").write_bytes(netcdf(**how))
            message = self.works("compress", self.path("a.nc"), "-o", self.path("a.volute"), "--max-error", 1e-4, *more).message
            self.works("extract", self.path("a.volute"), "-o", self.path("a.npy"))
            return [round(value, 2) for value in read_npy(self.path("a.npy").read_bytes())[1]], message

        up = [0.25 + 0.5 * i for i in range(4)]
        plain, _ = written()
        down, _ = written(places={"z": up[::-1]})
        self.assertNotEqual(down, plain)
        bounds = "--bounds=0,0,0,3,2.5,2"
        bounded, message = written(bounds, places={"z": up[::-1]})
        self.assertEqual(bounded, down)
        self.assertNotIn("evenly", message)
        depth, _ = written(places={"z": up}, attributes={"z": {"positive": ("c", "down")}})
        self.assertEqual(depth, down)
        info = json.loads(self.works("info", self.path("a.nc"), "--json").out)
        self.assertEqual((info["bounds"][2], info["bounds"][5]), (-2, 0))
        self.path("a.nc").write_bytes(netcdf(places={"z": [0.25, 0.5, 1, 2]}))
        refused = self.fails(1, "compress", self.path("a.nc"), "-o", self.path("a.volute"))
        self.assertIn("the coordinate 'z' is not evenly spaced: 0.5 at 1 of 4, where even steps say 0.833333333", refused)
        self.assertNotIn("bounds", refused)
        _, message = written(bounds, places={"z": [0.25, 0.5, 1, 2]})
        self.assertIn("taken as even within the bounds that are given", message)

    def test_arrays_have_times_that_descend_long_units_and_counts_of_64_bits(self):
        def written(**how):
            self.path("a.nc").write_bytes(netcdf(**how))
            self.works("compress", self.path("a.nc"), "-o", self.path("a.volute"), "--max-error", 1e-4)
            self.works("extract", self.path("a.volute"), "-o", self.path("a.npy"))
            said = self.works("info", self.path("a.nc"), "--json").json
            return [round(value, 2) for value in read_npy(self.path("a.npy").read_bytes())[1]], [round(time, 9) for time in said["times"]], [round(b, 6) for b in said["bounds"]]

        plain = written()
        turned = lambda values: values[240:] + values[120:240] + values[:120]
        self.assertEqual(written(places={"t": [4, 2, 0]}, change=turned), plain)
        since = {"t": "s since 2020-01-01"}
        self.assertEqual(written(places={"t": [104, 102, 100]}, units=since, change=turned), plain)
        scaled = lambda factor, axis, count, first, step: [factor * (first + step * i) for i in range(count)]
        for time, factor in (("microseconds", 1e6), ("nanoseconds since 2020-01-01", 1e9), ("Milliseconds", 1e3), ("days", 1 / 86400)):
            places = {"t": scaled(factor, "t", 3, 0, 2), "x": scaled(1000, "x", 6, 0.25, 0.5), "y": scaled(100, "y", 5, 0.25, 0.5)}
            self.assertEqual(written(units={"t": time, "x": "millimeters", "y": "centimetres"}, places=places), plain, time)
        self.assertEqual(written(five=True), plain)
        self.path("a.nc").write_bytes(netcdf(places={"t": [0, 2, 9.969209968386869e36]}))
        self.assertIn("'time' was never written at 2 of 3", self.fails(1, "info", self.path("a.nc")))
        self.path("a.nc").write_bytes(netcdf(places={"t": [4, 0, 2]}))
        self.assertIn("expected times that ascend or descend", self.fails(1, "info", self.path("a.nc")))

    def test_one_voxel_of_an_array_file_keeps_its_size(self):
        source = self.make_npy(frames=1, size=4)
        self.works("compress", source, "-o", self.path("a.volute"), "--bounds=1,2,3,1.4,2.8,4.2", "--max-error", 1e-3)
        for name in ("a.nc", "a.h5"):
            self.works("extract", self.path("a.volute"), "-o", self.path(name), "--region", "1:2,2:3,0:1")
            done = self.works("info", self.path(name), "--json")
            self.assertEqual([round(b, 9) for b in done.json["bounds"]], [1.1, 2.4, 3, 1.2, 2.6, 3.3])
            self.assertEqual(done.message, "")
        self.path("b.nc").write_bytes(netcdf(sizes=(3, 4, 5, 1)))
        self.assertIn("single voxels of a size that is not stated are taken to be 0.5 m along x", self.works("info", self.path("b.nc")).message)

    def test_compare_tells_the_loss_by_frame_and_draws_it(self):
        shape, values = support.plume(3, 8)
        write_npy(self.path("a.npy"), shape, values)
        changed = list(values)
        changed[2 * 512 + 7] += 0.5
        write_npy(self.path("b.npy"), shape, changed)
        said = self.works("compare", self.path("a.npy"), self.path("b.npy"), "--json", "--difference", self.path("d.png")).json
        self.assertEqual([frame["frame"] for frame in said["by_frame"]], [0, 1, 2])
        self.assertEqual([frame["max_error"] for frame in said["by_frame"]], [0, 0, 0.5])
        self.assertEqual(self.works("info", self.path("d.png"), "--json").json["size"], [8, 8])
        self.assertIn("worst in frame 2", self.works("compare", self.path("a.npy"), self.path("b.npy")).text)

    def cache(self, names):
        """Empty-named .vdb frames under these names, which are given back."""
        shape, values = support.plume(len(names), 8)
        write_npy(self.path("c.npy"), shape, values)
        self.works("compress", self.path("c.npy"), "-o", self.path("c.volute"))
        result = volute("extract", self.path("c.volute"), "-o", self.path("out_%04d.vdb"))
        if "this build has no" in result.message:
            self.skipTest(result.message)
        for i, name in enumerate(names):
            self.path(f"out_{i:04}.vdb").rename(self.path(name))
        return names

    def there_and_back(self, pattern, names, packed="p.volute"):
        said = self.works("compress", self.path(pattern), "-o", self.path(packed), "--json").json
        self.assertEqual(said["frames"], len(names))
        back = self.path("back")
        back.mkdir()
        self.works("extract", self.path(packed), "-o", back / pathlib.Path(pattern).name)
        self.assertEqual(sorted(file.name for file in back.iterdir()), sorted(names))
        shutil.rmtree(back)
        return self.works("info", self.path(packed), "--json").json

    def test_negative_frames_are_frames(self):
        names = self.cache(["s_-2.vdb", "s_-1.vdb", "s_0.vdb", "s_1.vdb"])
        for pattern in ("s_%d.vdb", "s_$F.vdb", "s_<frame>.vdb"):
            self.assertEqual(self.there_and_back(pattern, names)["frame_numbers"], [-2, 1])
        self.assertEqual(self.works("info", self.folder, "--json").json["frames"], 4)
        taken = self.works("compress", self.path("s_%d.vdb"), "-o", self.path("t.volute"), "--frames=-2:0", "--json").json
        self.assertEqual(taken["frames"], 2)

    def test_frames_between_whole_ones_are_frames(self):
        names = self.cache(["s.0001.vdb", "s.0001.25.vdb", "s.0001.5.vdb", "s.0002.vdb"])
        said = self.there_and_back("s.%04d.vdb", names)
        self.assertEqual(said["frame_numbers"], [1, 2])
        self.works("compress", self.path("s.%04d.vdb"), "-o", self.path("r.volute"), "--fps", "24")
        self.assertAlmostEqual(self.works("info", self.path("r.volute"), "--json").json["times"][1], 1 / 24)
        taken = self.works("compress", self.path("s.####.vdb"), "-o", self.path("t.volute"), "--frames", "1.25:2", "--json").json
        self.assertEqual(taken["frames"], 2)
        self.works("render", self.path("s.%04d.vdb"), "-o", self.path("x.%04d.png"), "--size", "8x8")
        self.assertTrue({"x.0001.png", "x.0001.25.png", "x.0001.5.png", "x.0002.png"} <= set(self.files()))
        all_decimals = [f"f.{number}.vdb" for number in ("0001.00", "0001.25")]
        for old, new in zip(names, all_decimals):
            self.path(old).rename(self.path(new))
        self.there_and_back("f.%04d.vdb", all_decimals, "q.volute")

    def test_numbers_come_back_as_they_were_written(self):
        # printf counts the sign as a digit; decimals of one length are those that some frames need.
        for pattern, names in (("s_%04d.vdb", ["s_-002.vdb", "s_-001.vdb", "s_0000.vdb"]), ("t.$F3.vdb", ["t.-07.vdb", "t.-06.vdb"]),
                               ("u_<frame>.vdb", ["u_0009.vdb", "u_0010.vdb"]), ("v.####.vdb", ["v.0001.0.vdb", "v.0001.25.vdb", "v.0002.0.vdb"])):
            with self.subTest(pattern):
                folder = self.path(pattern[0])
                folder.mkdir()
                self.cache([f"{pattern[0]}/{name}" for name in names])
                self.there_and_back(f"{pattern[0]}/{pattern}", names)
                self.works("compress", self.path("p.volute"), "-o", self.path("q.volute"), "--effort", "1")
                back = self.path("back")
                back.mkdir()
                self.works("extract", self.path("q.volute"), "-o", back / pattern)
                self.assertEqual(sorted(file.name for file in back.iterdir()), sorted(names))
                shutil.rmtree(back)
        back.mkdir()
        self.works("extract", self.path("q.volute"), "-o", back / "v.%d.vdb")
        self.assertEqual(sorted(file.name for file in back.iterdir()), ["v.1.25.vdb", "v.1.vdb", "v.2.vdb"])

    def test_files_that_are_left_out_are_named(self):
        self.cache(["s_1.vdb", "s_2.vdb", "s_03.vdb"])
        self.path("s_4.VDB").write_bytes(b"")
        said = self.works("compress", self.path("s_%d.vdb"), "-o", self.path("p.volute"))
        self.assertIn("2 files are left out: s_03.vdb, s_4.VDB", said.message)
        shutil.copy(self.path("c.npy"), self.path("s_5.npy"))
        for verb in ("compress", "render"):
            text = self.fails(2, verb, self.folder, "-o", self.path("q.volute" if verb == "compress" else "q.png"))
            self.assertIn("holds numbered .vdb and .npy files; name one sequence with its pattern", text)
        self.path("s_7.vdb").symlink_to("nowhere")
        text = self.fails(1, "compress", self.path("s_%d.vdb"), "-o", self.path("p.volute"))
        self.assertIn("s_7.vdb: has the name of a frame and is a link to what is not there; expected a file", text)

    def test_patterns_of_files_with_all_frames(self):
        packed = self.make_volute()
        self.assertIn("a pattern of .volute files; expected one", self.fails(1, "compress", self.path("in_%d.volute"), "-o", self.path("p.volute")))
        self.assertIn("a pattern of .nc files; expected one", self.fails(1, "compress", self.path("in_%d.nc"), "-o", self.path("p.volute")))
        self.path("empty").mkdir()
        self.assertIn("name files of another kind with a pattern", self.fails(1, "compress", self.path("empty"), "-o", self.path("p.volute")))
        for target in ("x_%04d.npy", "x_%04d.nc"):
            self.assertIn("leave the frame number out of the name", self.fails(2, "extract", packed, "-o", self.path(target)))
        self.assertIn("has {mesh}, which nothing is filled in for", self.fails(2, "extract", packed, "-o", self.path("x_{mesh}.npy")))

    def test_what_a_format_has_no_place_for_is_told(self):
        self.works("compress", self.make_npy(), "-o", self.path("x.volute"), "--bounds", "0,0,0,2,2,2", "--fps", "10")
        text = self.works("extract", self.path("x.volute"), "-o", self.path("x.npy")).message
        self.assertIn("such a file does not say where the voxels lie (0, 0, 0  to  2, 2, 2 m), or when the frames are shown (0 to 0.2 s)", text)
        for verb in (("extract", self.path("x.volute")), ("resample", self.path("x.volute"), "--voxel-size", "0.5")):
            self.assertIn("--fps: ", self.fails(2, *verb, "-o", self.path("y.npy"), "--fps", "3"))
        self.assertIn("--rms: is the error of a .volute", self.fails(2, "resample", self.path("x.volute"), "-o", self.path("y.npy"), "--rms", "0.1"))

    def test_frames_that_are_asked_for_and_not_there(self):
        packed = self.make_volute(frames=4)
        for verb, target in (("compress", "y.volute"), ("extract", "y.npy"), ("resample", "z.npy")):
            text = self.fails(1, verb, packed, "-o", self.path(target), "--frames", "2:99", "--strict")
            self.assertIn("frames 2:99 are asked for; it has 0 to 3", text)
            self.works(verb, packed, "-o", self.path(target), "--frames", "2:4", *(["--strict"] if verb == "compress" else []))

    def test_frames_of_an_earlier_run_are_told(self):
        self.cache(["s_0.vdb", "s_1.vdb", "s_2.vdb"])
        target = self.path("o_%02d.vdb")
        self.works("extract", self.path("c.volute"), "-o", target)
        text = self.works("extract", self.path("c.volute"), "-o", target, "--frames", "0:1").message
        self.assertIn("o_01.vdb, o_02.vdb stay from before and are read as frames of the same sequence", text)
        text = self.works("resample", self.path("c.volute"), "-o", target, "--frames", "1:3").message
        self.assertIn("o_00.vdb stay", text)

    def test_two_files_of_one_number(self):
        self.cache(["s_1.vdb", "s_2.vdb", "s_02.vdb"])
        text = self.fails(2, "compress", self.path("s_<frame>.vdb"), "-o", self.path("p.volute"))
        self.assertIn(f"{self.path('s_02.vdb')} and s_2.vdb are both frame 2; name one series with a pattern such as {self.path('s_%d.vdb')}", text)
        self.works("compress", self.path("s_%d.vdb"), "-o", self.path("p.volute"))
        self.path("s_02.vdb").rename(self.path("s_2.0.vdb"))
        text = self.fails(2, "compress", self.path("s_%d.vdb"), "-o", self.path("p.volute"))
        self.assertIn("s_2.vdb are both frame 2; move one of them elsewhere", text)

    def test_percent_and_hash_signs_in_names_are_characters(self):
        self.works("compress", self.make_npy(), "-o", self.path("take#2.volute"))
        size = ("--size", "8x8", "--time", "0")
        for name in ("out 50%.png", "50%%.png", "take#1.png"):
            before = set(self.files())
            self.works("render", self.path("take#2.volute"), "-o", self.path(name), *size)
            self.assertEqual(set(self.files()) - before, {name})
        folder = self.path("job#12 %20%04d")
        folder.mkdir()
        self.works("extract", self.path("take#2.volute"), "-o", folder / "x.npy", "--frames", "0:1")
        shutil.copy(folder / "x.npy", folder / "x_0001.npy")
        (folder / "x.npy").rename(folder / "x_0000.npy")
        self.assertEqual(self.works("compress", folder / "x_####.npy", "-o", self.path("o.volute"), "--json").json["frames"], 2)
        self.works("render", folder / "x_%04d.npy", "-o", folder / "y_%04d.png", "--size", "8x8")
        self.assertTrue((folder / "y_0001.png").exists())

    def test_what_points_upwards_is_said_and_kept(self):
        column = lambda axis: [float(all(index[a] == 4 for a in range(3) if a != axis))
                               for index in ((x, y, z) for z in range(8) for y in range(8) for x in range(8))]
        for name, axis in (("y.npy", 1), ("z.npy", 2)):
            write_npy(self.path(name), (1, 8, 8, 8), column(axis))
        size = ("--size", "24x24", "--emission", "1")

        def picture(*words):
            self.works("render", *words, "-o", self.path("x.png"), *size)
            return [level for row in read_png(self.path("x.png").read_bytes())[2] for level in row]

        def farthest(a, b):
            return max(abs(x - y) for x, y in zip(a, b, strict=True))

        lying = picture(self.path("y.npy"))
        stands = picture(self.path("y.npy"), "--up", "y")
        self.assertGreater(farthest(lying, stands), 50)
        self.assertEqual(farthest(picture(self.path("y.npy"), "--file-up", "y"), stands), 0)
        self.works("compress", self.path("y.npy"), "-o", self.path("y.volute"), "--up", "y", "--rms", "1e-6")
        self.assertEqual(self.works("info", self.path("y.volute"), "--json").json["up"], "y")
        self.assertLessEqual(farthest(picture(self.path("y.volute")), stands), 2)
        self.assertLessEqual(farthest(picture(self.path("y.volute"), "--up", "z"), lying), 2)
        self.works("extract", self.path("y.volute"), "-o", self.path("back.npy"))
        values = support.read_npy(self.path("back.npy").read_bytes())[1]
        self.assertLess(max(abs(a - b) for a, b in zip(values, column(1))), 1e-4)
        turned = picture(self.path("y.npy"), "--up", "0,1,0")
        self.assertGreater(farthest(turned, lying), 50)
        self.assertIn("up is 0, 0, 0; expected a direction", self.fails(2, "render", self.path("y.npy"), "-o", self.path("u.png"), "--up", "0,0,0"))

    def test_what_a_join_lacks_and_makes_faint_is_told(self):
        source, parts = self.path("in.npy"), [self.path("a.volute"), self.path("b.volute")]
        shape, values = support.plume(24, 6)
        write_npy(source, shape, [value * (1 if i < 16 * 216 else 100) for i, value in enumerate(values)])
        for part, frames in zip(parts, ("0:5", "16:24")):
            self.works("compress", source, "-o", part, "--frames", frames)
        said = self.works("join", *parts, "-o", self.path("all.volute"), "--json").json
        self.assertIn("11 of the frames 0 to 23 are missing: 5 to 15; a part may be missing", said["remarks"][0]["sentence"])
        self.assertEqual((said["frames"], said["faint_frames"][0]["grid"]), (13, "density"))
        self.assertEqual([one["frame"] for one in said["faint_frames"][0]["frames"]], [0, 1, 2, 3, 4])
        shown = self.works("render", self.path("all.volute"), "-o", self.path("x.png"), "--size", "8x8", "--time", "0.5").message
        self.assertIn("missing: 5 to 15; until the next one the frame before is shown", shown)

    def test_a_folder_of_two_sequences_is_refused(self):
        self.cache(["s_1.vdb", "s_2.vdb"])
        self.make_npy("s_0001.npy", frames=1)
        for words in (("info",), ("compress", "-o", self.path("x.volute")), ("render", "-o", self.path("x.png"))):
            self.assertIn("holds numbered .vdb and .npy files", self.fails(2, words[0], self.folder, *words[1:]))

    def test_a_valid_range_is_of_values_or_of_what_is_stored(self):
        packed = {"kind": "h", "change": lambda values: [round(1000 * value) for value in values]}
        scale = ("scale_factor", ("d", [0.001]))

        def largest(*extra):
            self.path("a.nc").write_bytes(netcdf(extra=(scale, *extra), **packed))
            done = self.works("compress", self.path("a.nc"), "-o", self.path("a.volute"), "--not-finite", "background", "--json")
            return done.json["remarks"][0]["sentence"], done.json["replaced_values"], round(self.works("info", self.path("a.volute"), "--json").json["maximum"], 3)

        said, *rest = largest(("valid_min", ("d", [0.0])), ("valid_max", ("d", [1.0])))
        self.assertIn("nothing is there where 'soot' has values below 0 (valid_min), values above 1 (valid_max)", said)
        self.assertEqual(rest, [0, 0.785])
        self.assertEqual(largest(("valid_range", ("f", [0.0, 0.7])))[2], 0.7)
        said, replaced, most = largest(("valid_max", ("h", [600])))
        self.assertIn("stored numbers above 600 (valid_max)", said)
        self.assertEqual((most, replaced > 0), (0.6, True))
        self.path("a.nc").write_bytes(netcdf(extra=(("valid_range", ("f", [0.0, 1.0, 2.0])),)))
        self.assertIn("3 numbers as its valid_range", self.fails(1, "compress", self.path("a.nc"), "-o", self.path("b.volute")))

    def test_values_that_are_replaced_are_counted(self):
        values = [math.nan if i % 5 == 0 else 1 + i % 7 for i in range(3 * 1000)]
        write_npy(self.path("a.npy"), (3, 10, 10, 10), values)
        for how, end in (("background", "replaced by the background"), ("inactive", "left out: their voxels are inactive")):
            done = self.works("compress", self.path("a.npy"), "-o", self.path("a.volute"), "--not-finite", how, "--json")
            self.assertEqual(done.json["replaced_values"], 600)
            self.assertIn(f"'density': 600 values are not finite, and {end}", str(done.json["remarks"]))

    def test_chunks_that_are_missing_are_told(self):
        folder = self.path("a.zarr/soot")
        folder.mkdir(parents=True)
        (folder.parent / ".zgroup").write_text('{"zarr_format": 2}')
        (folder / ".zarray").write_text(json.dumps({"zarr_format": 2, "shape": [3, 4, 4, 4], "chunks": [1, 4, 4, 4], "dtype": "|i1",
                                                    "fill_value": 0, "order": "C", "compressor": None, "filters": None}))
        for frame in (0, 2):
            (folder / f"{frame}.0.0.0").write_bytes(bytes((i + 200) % 256 for i in range(64)))
        done = self.works("compress", self.path("a.zarr"), "-o", self.path("a.volute"), "--max-error", "0.01")
        self.assertIn("'soot': 1 of 3 chunks are not there; their values are the fill value 0", done.message)
        said = self.works("info", self.path("a.volute"), "--json").json
        self.assertEqual((round(said["minimum"]), round(said["maximum"])), (-56, 7))

    def test_a_fill_value_of_zarr_is_a_number_unless_xarray_says_that_it_is_none(self):
        folder = self.path("a.zarr/soot")
        folder.mkdir(parents=True)
        (folder.parent / ".zgroup").write_text('{"zarr_format": 2}')

        def info(fill, attributes=None):
            (folder / ".zarray").write_text(json.dumps({"zarr_format": 2, "shape": [1, 2, 2, 2], "chunks": [1, 2, 2, 2], "dtype": "<f4",
                                                        "fill_value": fill, "order": "C", "compressor": None, "filters": None}))
            (folder / ".zattrs").write_text(json.dumps(attributes or {}))
            (folder / "0.0.0.0").write_bytes(struct.pack("<8f", fill, fill, 1, 2, 3, 4, 5, 6))
            return self.works("info", self.path("a.zarr"), "--values", "--json")

        self.assertEqual(info(300).json["maximum"], 300)
        self.assertNotIn("nothing is there", info(300).message)
        for done in (info(300, {"_ARRAY_DIMENSIONS": ["t", "z", "y", "x"]}), info(300, {"_FillValue": 300}), info(-9999)):
            self.assertEqual((done.json["minimum"], done.json["maximum"], done.json["not_finite"]), (1, 6, 2))
            self.assertIn("nothing is there where 'soot' has its fill value, ", done.message)

    def test_arrays_that_images_have_besides_are_told(self):
        array = lambda name, count: f'<DataArray type="Float32" Name="{name}" NumberOfComponents="{count}" format="ascii">{"1 2 " * 4 * count}</DataArray>'
        times = '<FieldData><DataArray type="Float64" Name="TimeValue" NumberOfTuples="2" format="ascii">3 4</DataArray></FieldData>'

        def write(name, *arrays, field=""):
            self.path(name).write_text(
                f'<VTKFile type="ImageData" version="1.0"><ImageData WholeExtent="0 2 0 2 0 2" Origin="0 0 0" Spacing="1 1 1">{field}'
                f'<Piece Extent="0 2 0 2 0 2"><CellData>{"".join(arrays)}</CellData></Piece></ImageData></VTKFile>')
        write("a.vti", array("density", 1), array("stress", 9))
        write("b.vti", array("density", 1), field=times)
        result = volute("compress", self.path("a.vti"), "-o", self.path("a.volute"))
        if "this build has no" in result.message:
            self.skipTest(result.message)
        self.assertIn("a.vti: not read: 'stress' (vector of 9, of cells)", result.message)
        self.assertIn("b.vti: not read: all but the first of its 2 times", self.works("compress", self.path("b.vti"), "-o", self.path("b.volute")).message)
        self.path("c.pvd").write_text('<VTKFile type="Collection"><Collection><DataSet timestep="0" group="a" file="a.vti"/>'
                                      '<DataSet timestep="1" group="b" file="b.vti"/></Collection></VTKFile>')
        self.assertIn("b.vti is of the group 'b' and those before it of 'a'", self.fails(1, "compress", self.path("c.pvd"), "-o", self.path("c.volute")))

    def test_three_channels_of_one_frame_are_five_axes(self):
        write_npy(self.path("a.npy"), (8, 8, 8, 3), [0.5 + i % 3 for i in range(8 * 8 * 8 * 3)])
        self.assertIn("8 frames, 3 voxels wide: an array of four axes is (t,z,y,x)",
                      self.works("compress", self.path("a.npy"), "-o", self.path("a.volute")).message)

    def test_looks_without_effect_are_told(self):
        write_npy(self.path("a.npy"), (2, 8, 8, 8), [i % 9 / 10 - 0.2 for i in range(1024)])

        def said(*words, source="a.npy"):
            return self.works("render", self.path(source), "-o", self.path("x.png"), "--size", "8x8", "--time", "0", *words).message
        self.assertIn("values are below 0, the smallest -0.2: as an extinction they count as 0", said("--preset", "smoke"))
        for bounds, told in ((), True), (("--bounds", "0,0,0,1,1,1"), False):
            self.assertEqual("no bounds are stated; the longest side is 1 m" in said("--extinction", "1", *bounds), told)
            done = self.works("compress", self.path("a.npy"), "-o", self.path("x.volute"), *bounds).message
            self.assertEqual("a.npy: no bounds are stated" in done, told)
        self.assertIn("add light", said("--extinction", "1"))
        self.assertIn("asymmetry has no effect", said("--asymmetry", "0.5"))
        self.assertIn("velocity_unit has no effect", said("--velocity-unit", "m/frame"))
        self.assertIn("there is one process, which holds all", said("--by-pieces"))
        self.works("compress", self.path("a.npy"), "-o", self.path("smoke.volute"), "--frames", "0:1")
        self.assertIn("its values are shown as light: the tree draws nothing else", said("--volume-method", "tree", source="smoke.volute"))
        depth = ("render", self.path("a.npy"), "-o", self.path("x.exr"), "--extinction", "1", "--aov", "optical-depth")
        for name, value in (("--background", "1,1,1"), ("--emission", "3")):
            self.assertIn(f"{name} has no effect", self.works(*depth, name, value).message)
        self.assertIn("--exposure has no effect", self.fails(2, *depth, "--exposure", "3"))
        self.assertIn("--partial is for", self.fails(2, "compress", self.path("a.npy"), "-o", self.path("y.volute"), "--partial"))
        raw = self.path("a.raw")
        raw.write_bytes(bytes(64))
        self.assertIn("--raw-order: has no effect on values of one byte", self.fails(
            2, "compress", raw, "-o", self.path("y.volute"), "--raw-size", "4,4,4", "--raw-type", "uint8", "--raw-order", "big"))

    def test_a_shutter_averages_light_over_time(self):
        frames = [[float((x - 3 * f - 3) ** 2 + (y - 4) ** 2 + (z - 4) ** 2 < 9) for z in range(8) for y in range(8) for x in range(12)] for f in range(3)]
        write_npy(self.path("s.npy"), (3, 8, 8, 12), sum(frames, []))

        def light(*more):
            self.works("render", self.path("s.npy"), "-o", self.path("s.exr"), "--size", "24x16", "--renderer", "cpu", "--measured", "--fps", "10",
                       "--eye", "0.5,-3,0.3", "--target", "0.5,0.3,0.3", "--fov", "20", "--stats", self.path("s.json"), *more)
            return read_exr(self.path("s.exr")).values

        # What is emitted is linear in time between frames; what is absorbed is not.
        blurred = light("--time", "0", "--shutter", "0.5")
        for a, b in zip(blurred, light("--time", "0.025", "--interpolate", "linear")):
            self.assertAlmostEqual(a, b, delta=1e-5)
        self.assertGreater(max(abs(a - b) for a, b in zip(blurred, light("--time", "0"))), 0.05)
        dense = ("--extinction", "8", "--background", "1,1,1")
        blurred = light("--time", "0.05", "--shutter", "1", *dense)
        said = json.loads(self.path("s.json").read_text())["shutter"]
        self.assertAlmostEqual(said["seconds"], 0.1)
        self.assertLessEqual(said["error"], 1 / 256)
        mean = [0] * len(blurred)
        for i in range(24):
            for k, value in enumerate(light("--time", str(0.05 + (i + 0.5) / 240), "--interpolate", "linear", *dense)):
                mean[k] += value / 24
        self.assertLess(max(abs(a - b) for a, b in zip(blurred, mean)), max(mean) / 256)
        still = self.works("render", self.path("s.npy"), "-o", self.path("s.png"), "--size", "24x16", "--shutter", "0.5", "--interpolate", "none")
        self.assertIn("nothing moves while the shutter is open", still.message)
        self.assertIn("--shutter", self.fails(2, "render", self.path("s.npy"), "-o", self.path("s.exr"), "--shutter", "0.5", "--aov", "optical-depth"))
        self.works("render", self.path("s.npy"), "-o", self.path("s_%04d.png"), "--size", "24x16", "--shutter", "0.5", "--frames", "0:2")

    def test_a_rate_that_is_given_is_kept(self):
        shape, values = support.plume(5, 8)
        write_npy(self.path("a.npy"), shape, values)
        said = self.works("compress", self.path("a.npy"), "-o", self.path("a.volute"))
        self.assertIn("no times are stated; 25 frames a second", said.message)
        self.works("compress", self.path("a.npy"), "-o", self.path("f.volute"), "--fps", "24000/1001")
        self.assertAlmostEqual(self.works("info", self.path("f.volute"), "--json").json["times"][1], 4 * 1001 / 24000, places=12)
        self.assertIn("24000/1001", self.fails(2, "compress", self.path("a.npy"), "-o", self.path("f.volute"), "--fps", "24/0"))
        said = self.works("compress", self.path("a.npy"), "-o", self.path("b.volute"), "--fps", "24")
        self.assertNotIn("25 frames", said.message)
        end = lambda file: self.works("info", file, "--json").json["times"][1]
        self.assertEqual((end(self.path("a.volute")), end(self.path("b.volute"))), (4 / 25, 4 / 24))
        self.works("compress", self.path("b.volute"), "-o", self.path("c.volute"), "--ratio", "2")
        self.assertEqual(end(self.path("c.volute")), 4 / 24)
        self.works("compress", self.path("b.volute"), "-o", self.path("d.volute"), "--fps", "10")
        self.assertEqual(end(self.path("d.volute")), 4 / 10)
        for rate, last in [((), 4 / 24), (("--fps", "50"), 4 / 50)]:
            self.works("extract", self.path("b.volute"), "-o", self.path("e.nc"), *rate)
            self.assertAlmostEqual(end(self.path("e.nc")), last)
        part = self.works("extract", self.path("b.volute"), "-o", self.path("p.pvd"), "--fps", "50", "--frames", "2:4")
        self.assertEqual(self.works("info", self.path("p.pvd"), "--json").json["times"], [2 / 50, 3 / 50])
        for file in ["a.npy", "b.volute"]:
            self.assertEqual(self.works("info", self.path(file), "--fps", "50", "--json").json["times"], [0, 4 / 50])
        self.assertIn("is for volumes", self.fails(2, "info", self.path("none.png"), "--fps", "50"))
        self.assertNotIn("other times", self.works("compare", self.path("a.npy"), self.path("b.volute")).message)
        said = self.works("compare", self.path("a.volute"), self.path("b.volute"))
        self.assertIn("the two have other times: from the first to the last frame pass 0.16 and 0.166667 s; --fps takes one rate for both", said.message)
        said = self.works("compare", self.path("a.volute"), self.path("b.volute"), "--fps", "50", "--json")
        self.assertNotIn("other times", said.message)
        self.assertEqual([frame["time"] for frame in said.json["by_frame"]], [i / 50 for i in range(5)])
        result = volute("extract", self.path("b.volute"), "-o", self.path("v_%04d.vdb"))
        if "this build has no" not in result.message:
            self.assertEqual(end(self.path("v_%04d.vdb")), 4 / 24)

    def test_info_lists_the_grids_of_a_vdb(self):
        packed = self.make_volute()
        result = volute("extract", packed, "-o", self.path("out_%04d.vdb"), "--frames", "0:1")
        if "this build has no" in result.message:
            self.skipTest(result.message)
        said = self.works("info", self.path("out_0000.vdb"), "--json").json
        (grid,) = said["grids"]
        self.assertEqual((grid["name"], grid["type"], grid["class"]), ("density", "float", "fog volume"))
        self.assertGreater(grid["active_voxels"], 0)
        self.assertGreater(grid["maximum"], 0.9)
        self.assertGreater(grid["memory_bytes"], 0)
        shutil.copy(self.path("out_0000.vdb"), self.path("other_0000.vdb"))
        self.assertIn("2 sequences", self.fails(2, "info", self.folder))

    def test_the_ratio_is_told_of_dense_floats_and_of_the_files(self):
        source = self.make_npy("in.npy")
        said = self.works("compress", source, "-o", self.path("x.volute"), "--rms", "0.01", "--json").json
        self.assertEqual(said["input_bytes"], source.stat().st_size)
        self.assertAlmostEqual(said["ratio_to_input"], said["input_bytes"] / said["bytes"], places=3)

    def test_wild_values_take_no_others_with_them(self):
        """Two of 1e6 in a puff: all others come back, and the two as they were."""
        def puff(x, y, z):
            return max(0, 1 - math.dist((x, y, z), (6, 6, 6)) / 6)
        values = [puff(x, y, z) for z in range(13) for y in range(13) for x in range(13)]
        for at in (700, 1100):
            values[at] = 1e6
        support.write_npy(self.path("p.npy"), (1, 13, 13, 13), values)
        said = self.works("compress", self.path("p.npy"), "-o", self.path("p.volute")).message
        self.assertIn("some values are far from all others", said)
        self.assertIn("kept exactly", said)
        self.works("extract", self.path("p.volute"), "-o", self.path("back.npy"))
        back = support.read_npy(self.path("back.npy").read_bytes())[1]
        self.assertEqual([back[700], back[1100]], [1e6, 1e6])
        self.assertLess(max(abs(a - b) for a, b in zip(values, back)), 0.02)
        said = self.works("compress", self.path("p.npy"), "-o", self.path("q.volute"), "--psnr", "50").message
        self.assertRegex(said, "the others are off by .*--rms")
        brightest = []
        for wild in (1e6, 3e38):
            values[700] = wild
            support.write_npy(self.path("p.npy"), (1, 13, 13, 13), values)
            self.works("render", self.path("p.npy"), "-o", self.path("p.exr"), "--preset", "smoke", "--size", "24x18", "--extinction", "9")
            brightest.append(self.works("info", self.path("p.exr"), "--json").json["maximum"])
        self.assertGreater(brightest[1], 0.3 * brightest[0])
        self.assertLess(brightest[1], 3 * brightest[0])

    def test_floats_far_from_zero_keep_what_differs(self):
        """Absolute pressure: a transform of it in float32 rounds by more than the default error."""
        for channels in (1, 3):
            shape, puff = support.plume(3, 10, channels)
            values = array.array("f", (101300 + 8 * value for value in puff))
            span = max(values) - min(values)
            write_npy(self.path("p.npy"), shape, values)
            self.works("resample", self.path("p.npy"), "-o", self.path("p_%04d.vdb"), "--bounds", "0,0,0,1,1,1", "--voxel-size", "0.1")
            goals = [(), ("--max-error", "0.011")]
            goals += [("--quality", "measure"), ("--max-error", "1e-3"), ("--max-error", "0.3")] if channels == 1 else []
            for source, goal in itertools.product(("p.npy", "p_%04d.vdb"), goals):
                said = self.works("compress", self.path(source), "-o", self.path("p.volute"), *goal, "--json").json
                one = said["grids"][0] if "grids" in said else said
                rms = {(): 7e-4, ("--quality", "measure"): 1e-4}.get(goal, 1)
                most = float(goal[1]) if goal and goal[0] == "--max-error" else span
                self.assertLessEqual(one["max_error"], most, (source, goal))
                self.works("extract", self.path("p.volute"), "-o", self.path("back.npy"))
                self.works("extract", self.path("p.volute"), "-o", self.path("q_%04d.vdb"))
                self.works("resample", self.path("q_%04d.vdb"), "-o", self.path("q.npy"), "--bounds", "0,0,0,1,1,1", "--voxel-size", "0.1")
                for name in ("back.npy", "q.npy"):
                    back = support.read_npy(self.path(name).read_bytes())[1]
                    errors = [abs(a - b) for a, b in zip(values, back, strict=True)]
                    self.assertLessEqual(max(errors), one["max_error"], (source, goal, name))
                    self.assertLessEqual(math.sqrt(sum(error ** 2 for error in errors) / len(errors)) / span, rms, (source, goal, name))
                kinds = {grid["type"] for grid in self.works("info", self.path("q_0000.vdb"), "--json").json["grids"]}
                floats, doubles = ("float", "double") if channels == 1 else ("vec3s", "vec3d")
                self.assertEqual(kinds, {floats if source.endswith(".vdb") else doubles})

    def test_parts_of_floats_far_from_zero_are_joined_as_they_are(self):
        shape, puff = support.plume(20, 8)
        values = [300 + value * (1 + 0.02 * (i // 512)) for i, value in enumerate(puff)]
        write_npy(self.path("p.npy"), shape, values)
        for part, frames in (("a", "0:16"), ("b", "16:20")):
            self.works("compress", self.path("p.npy"), "-o", self.path(f"{part}.volute"), "--frames", frames)
        self.assertTrue(self.works("join", self.path("a.volute"), self.path("b.volute"), "-o", self.path("all.volute"), "--json").json["exact"])

    def test_parts_too_far_apart_for_one_file_are_told(self):
        shape, puff = support.plume(20, 6)
        for part, base, frames in (("a", 1e6, "0:16"), ("b", 2e6, "16:20")):
            write_npy(self.path("p.npy"), shape, [base + value for value in puff], code="d")
            self.works("compress", self.path("p.npy"), "-o", self.path(f"{part}.volute"), "--frames", frames, "--max-error", "1e-3")
        words = ("join", self.path("a.volute"), self.path("b.volute"), "-o", self.path("all.volute"))
        self.assertIn("'density' is encoded again, up to", self.works(*words).message)
        self.assertIn("keep the parts", self.fails(1, *words, "--strict"))

    def test_resampled_doubles_stay_doubles(self):
        shape, puff = support.plume(2, 8)
        values = array.array("d", (1e6 + value for value in puff))
        write_npy(self.path("p.npy"), shape, values, code="d")
        self.works("compress", self.path("p.npy"), "-o", self.path("p.volute"), "--max-error", "1e-3")
        words = ("--bounds", "0,0,0,1,1,1", "--voxel-size", "0.125")
        for source, most in (("p.npy", 1e-7), ("p.volute", 1e-3)):
            self.works("resample", self.path(source), "-o", self.path("r.npy"), *words)
            self.works("resample", self.path(source), "-o", self.path("r_%04d.vdb"), *words)
            said = self.works("resample", self.path(source), "-o", self.path("r.volute"), *words, "--rms", "1e-4")
            self.works("extract", self.path("r.volute"), "-o", self.path("q.npy"))
            self.works("resample", self.path("r_%04d.vdb"), "-o", self.path("v.npy"), *words)
            for name, more in (("r.npy", 0), ("v.npy", 0), ("q.npy", 3e-3)):
                back = support.read_npy(self.path(name).read_bytes())[1]
                self.assertEqual(back.typecode, "d", name)
                self.assertLessEqual(max(abs(a - b) for a, b in zip(values, back, strict=True)), most + more, (source, name, said.message))

    def test_a_small_maximum_error_is_met_where_a_smaller_one_is(self):
        """Corrections of floats are rounded themselves: finer ones make up for it."""
        shape, puff = support.plume(2, 9)
        write_npy(self.path("p.npy"), shape, [0.3 + 8.2 * value for value in puff])
        for most in ("3e-5", "2e-5", "1.2e-5", "1e-5", "9e-6", "5e-6", "2e-6"):
            said = self.works("compress", self.path("p.npy"), "-o", self.path("p.volute"), "--max-error", most, "--json").json
            self.assertLessEqual(said["max_error"], float(most))

    def test_what_fills_most_of_a_volume_takes_no_accuracy_from_the_rest(self):
        """A warm ball in air of 300 K, in air of hundredths of a kelvin more or less, and beside what stands for no data."""
        def ball(x, y, z):
            return max(0, 1 - math.dist((x, y, z), (6, 6, 6)) / 5) * (1 + 0.2 * math.sin(2 * x + y))
        places = [(x, y, z) for z in range(40) for y in range(40) for x in range(40)]
        warm = [1000 * ball(*place) for place in places]
        for name, around in (("even", lambda i: 300), ("noise", lambda i: 300 + 0.001 * (i * 7919 % 20)),
                             ("fill", lambda i: -9999 if i % 11 == 0 and not warm[i] else 300)):
            values = [around(i) + value for i, value in enumerate(warm)]
            support.write_npy(self.path("t.npy"), (1, 40, 40, 40), values)
            self.works("compress", self.path("t.npy"), "-o", self.path("t.volute"))
            self.works("extract", self.path("t.volute"), "-o", self.path("back.npy"))
            back = support.read_npy(self.path("back.npy").read_bytes())[1]
            squares = [(a - b) ** 2 for a, b, value in zip(values, back, warm) if value]
            self.assertLess(math.sqrt(sum(squares) / len(squares)), 1.5, name)  # .0007 of the range is .8 K

    def test_targets_are_met(self):
        self.assertLessEqual(self.round_trip("--rms", "0.01")[0], 0.01)
        self.assertLessEqual(self.round_trip("--psnr", "50")[0], 10 ** -2.5)
        self.assertLessEqual(self.round_trip("--max-error", "0.05")[1], 0.05 * (1 + 1e-6))
        self.assertGreaterEqual(self.round_trip("--ratio", "8", frames=16)[2]["ratio"], 8)
        self.assertLessEqual(self.round_trip("--size", "6K", frames=16)[2]["bytes"], 6144)

    def test_a_size_far_above_what_values_need_is_told(self):
        source = self.make_npy("in.npy")
        said = self.works("compress", source, "-o", self.path("x.volute"), "--size", "1000000", "--json").json
        told = lambda said: [remark["sentence"] for remark in said["remarks"] if "less than half" in remark["sentence"]]
        self.assertIn("less than half of the 1000000 that", told(said)[0])
        self.assertLess(self.works("compare", source, self.path("x.volute"), "--json").json["max_error"], 1e-6)
        enough = self.works("compress", source, "-o", self.path("x.volute"), "--size", str(int(1.2 * said["bytes"])), "--json").json
        self.assertEqual(told(enough), [])

    def test_odd_sizes_and_colours(self):
        self.round_trip("--rms", "0.003", frames=1, size=5)
        self.round_trip("--rms", "0.003", frames=17, size=7)
        self.round_trip("--rms", "0.003", frames=2, size=9, channels=3)

    def test_recompression_and_selection(self):
        packed = self.make_volute(frames=6)
        self.works("compress", packed, "-o", self.path("y.volute"), "--rms", "0.01", "--frames", "1:6:2")
        info = self.works("info", self.path("y.volute"), "--json").json
        self.assertEqual((info["frames"], info["frame_numbers"]), (3, [1, 5]))
        self.assertAlmostEqual(info["times"][0], 0.04)

    def test_an_error_adds_to_that_of_the_source(self):
        source = self.make_npy()
        self.works("compress", source, "-o", self.path("coarse.volute"), "--rms", "0.05")
        for verb, more in (("compress", ("--rms", "0.0001")), ("resample", ("--rms", "0.0001", "--bounds=0,0,0,1,1,1"))):
            said = self.works(verb, self.path("coarse.volute"), "-o", self.path("fine.volute"), *more)
            self.assertIn("is compressed itself", said.message)
            stated = self.works("info", self.path("fine.volute"), "--json").json
            self.assertGreaterEqual(stated["max_error"], self.works("compare", source, self.path("fine.volute"), "--json").json["max_error"])
            self.assertGreater(stated["relative_rms"], 0.01)

    def test_same_bytes_for_any_number_of_threads(self):
        source = self.make_npy(frames=18, size=20)
        for threads in (1, 2, 7):
            self.works("compress", source, "-o", self.path(f"{threads}.volute"), "--rms", "0.003", "--threads", threads)
        first = self.path("1.volute").read_bytes()
        self.assertEqual(first, self.path("2.volute").read_bytes())
        self.assertEqual(first, self.path("7.volute").read_bytes())

    def test_extract_takes_what_is_asked_for(self):
        packed = self.make_volute(frames=5, size=20)
        self.works("extract", packed, "-o", self.path("all.npy"))
        (_, _, _, nx), everything = read_npy(self.path("all.npy").read_bytes())
        said = self.works("extract", packed, "-o", self.path("part.npy"), "--frames", "3:5", "--region", "2:9,1:4,17:20",
                          "--json").json
        shape, part = read_npy(self.path("part.npy").read_bytes())
        self.assertEqual(shape, (2, 3, 3, 7))
        expected = [everything[((t * nx + z) * nx + y) * nx + x] for t in (3, 4) for z in range(17, 20)
                    for y in range(1, 4) for x in range(2, 9)]
        self.assertEqual(list(part), expected)
        self.assertEqual(said["blocks_decoded"], 1)
        self.assertLess(said["bytes_read"], packed.stat().st_size)

    def test_extract_to_standard_output(self):
        packed = self.make_volute()
        self.works("extract", packed, "-o", self.path("x.npy"), "--frames", "1:2")
        result = self.works("extract", packed, "-o", "-", "--frames", "1:2")
        self.assertEqual(result.out, self.path("x.npy").read_bytes())
        self.assertIn("blocks decoded", result.message)

    def test_levels_halve_the_resolution(self):
        packed = self.make_volute(frames=1, size=16)
        for level in (1, 2, 4):
            self.works("extract", packed, "-o", self.path("c.npy"), "--level", level)
            shape, values = read_npy(self.path("c.npy").read_bytes())
            self.assertEqual(shape, (1,) + (16 >> level,) * 3)
            self.works("extract", packed, "-o", self.path("f.npy"))
            fine = read_npy(self.path("f.npy").read_bytes())[1]
            self.assertAlmostEqual(math.fsum(values) * 8 ** level, math.fsum(fine), delta=0.02 * math.fsum(fine))

    def test_access_says_what_is_read_most(self):
        source = self.make_npy(frames=18, size=20)
        read = {}
        for access, frames in (("frame", 4), ("film", 16)):
            packed = self.path(f"{access}.volute")
            said = self.works("compress", source, "-o", packed, "--access", access, "--json").json
            info = self.works("info", packed, "--json").json
            self.assertEqual((said["block_frames"], info["block_frames"]), (frames, frames))
            self.works("extract", packed, "-o", self.path("all.npy"))
            one = self.works("extract", packed, "-o", self.path("one.npy"), "--frames", "9:10", "--json").json
            read[access] = one["bytes_read"]
            shape, values = read_npy(self.path("one.npy").read_bytes())
            size = len(values)
            self.assertEqual(list(values), list(read_npy(self.path("all.npy").read_bytes())[1][9 * size:10 * size]))
            mean = self.works("extract", packed, "-o", self.path("c.npy"), "--frames", "9:10", "--level", "4", "--json").json
            self.assertEqual(mean["bytes_read"], 0)
        self.assertLess(read["frame"], 0.5 * read["film"])
        self.fails(2, "compress", source, "-o", self.path("x.volute"), "--access", "seldom")

    def test_compare_measures(self):
        write_npy(self.path("a.npy"), (1, 1, 1, 4), [0, 1, 2, 4])
        write_npy(self.path("b.npy"), (1, 1, 1, 4), [0, 1, 2, 2])
        said = self.works("compare", self.path("a.npy"), self.path("b.npy"), "--json").json
        self.assertEqual((said["rms"], said["relative_rms"], said["max_error"]), (1, 0.25, 2))
        self.assertAlmostEqual(said["psnr"], 20 * math.log10(4))
        self.assertEqual(said["bytes"], [144, 144])
        same = self.works("compare", self.path("a.npy"), self.path("a.npy"), "--json").json
        self.assertEqual((same["rms"], same["psnr"]), (0, None))

    def test_compare_never_calls_equal_what_is_not(self):
        zero, one = self.path("z.npy"), self.path("a.npy")
        write_npy(zero, (1, 1, 1, 4), [0, 0, 0, 0])
        write_npy(one, (1, 1, 1, 4), [0, 1, 2, 4])
        write_npy(self.path("n.npy"), (1, 1, 1, 4), [0, 1, float("nan"), 4])
        for a, b, text in ((zero, one, "the first is 0 everywhere"), (one, self.path("n.npy"), "some values are no numbers, or infinite"),
                           (self.path("n.npy"), one, "some values are no numbers, or infinite")):
            done = self.works("compare", a, b, "--json")
            self.assertEqual(done.json["psnr"], -1000)
            self.assertIn(text, done.message)
            self.fails(1, "compare", a, b, "--strict")
        for same in (zero, one):
            done = self.works("compare", same, same, "--json", "--strict")
            self.assertIsNone(done.json["psnr"])

    def test_compare_tells_of_other_names(self):
        for name in ("soot", "heat"):
            self.path("a.nc").write_bytes(netcdf(names={"s": name}))
            self.works("compress", self.path("a.nc"), "-o", self.path(f"{name}.volute"), "--max-error", "1e-4")
        said = lambda a, b: self.works("compare", self.path(a), self.path(b)).message
        self.assertIn("'soot' of one is compared with 'heat' of the other", said("soot.volute", "heat.volute"))
        self.fails(1, "compare", self.path("soot.volute"), self.path("heat.volute"), "--strict")
        self.works("extract", self.path("heat.volute"), "-o", self.path("heat.npy"))
        self.assertNotIn("is compared with", said("heat.npy", "heat.volute"))

    def test_compare_tells_what_it_does_not_measure(self):
        source = self.make_npy(frames=4)
        for name, more in (("y", ("--up", "y")), ("x", ("--up", "x")), ("late", ("--frames", "1:4")), ("odd", ("--frames", "0:4:3")), ("even", ("--frames", "0:3:2"))):
            self.works("compress", source, "-o", self.path(f"{name}.volute"), *more)
        said = lambda a, b: self.works("compare", self.path(f"{a}.volute"), self.path(f"{b}.volute")).message
        self.assertIn("one says that y points upwards and the other says that x points upwards", said("y", "x"))
        self.assertIn("frame 3 with frame 2", said("odd", "even"))
        self.assertIn("cannot be reached: it is finer than float32",
                      self.fails(1, "compress", source, "-o", self.path("f.volute"), "--max-error", "1e-12"))

    def test_info_of_several_files(self):
        files = self.works("info", self.make_npy(), self.make_volute(), "--json").json["files"]
        self.assertEqual([file["kind"] for file in files], ["volume", "volute"])
        self.assertEqual(files[0]["size"], [12, 12, 12])
        self.assertTrue(files[1]["complete"])
        self.assertEqual(files[1]["asked"], {"kind": "support-rms", "value": 0.002})
        values = self.works("info", self.path("in.volute").with_name("in.npy"), "--values", "--json").json
        self.assertEqual(values["minimum"], 0)

    def test_bounds_are_kept(self):
        self.works("compress", self.make_npy(), "-o", self.path("x.volute"), "--rms", "0.01", "--bounds", "-1,-1,0,1,1,2")
        self.assertEqual(self.works("info", self.path("x.volute"), "--json").json["bounds"], [-1, -1, 0, 1, 1, 2])

    def test_made_up_data_are_the_same_again(self):
        for name in ("a.npy", "b.npy"):
            self.works("synthesize", "flame", "-o", self.path(name), "--size", "16", "--frames", "2", "--seed", "3")
        self.assertEqual(self.path("a.npy").read_bytes(), self.path("b.npy").read_bytes())
        self.assertEqual(read_npy(self.path("a.npy").read_bytes())[0], (2, 16, 16, 16))
        self.works("synthesize", "fire", "-o", self.path("c.volute"), "--size", "16", "--frames", "2")

    def test_other_formats(self):
        for extension in ("vdb", "vti"):
            pattern = self.path(f"s_%04d.{extension}")
            if "this build has no" in volute("extract", self.make_volute(), "-o", pattern).message:
                continue
            self.works("extract", self.make_volute(), "-o", pattern)
            self.assertTrue(self.path(f"s_0002.{extension}").exists())
            self.works("compress", pattern, "-o", self.path("y.volute"), "--rms", "0.01", "--frames", "1:3")
            self.assertEqual(self.works("info", self.path("y.volute"), "--json").json["frame_numbers"], [1, 2])

    def test_bench_prints_one_object(self):
        said = self.works("bench", "codec", "--input", self.make_npy(), "--json").json
        self.assertEqual(said["benchmarks"][0]["name"], "codec")
        rows = said["benchmarks"][0]["rows"]
        sizes = [row for row in rows if row["labels"]["figure"] == "size"]
        errors = [row for row in rows if row["labels"]["figure"] == "relative RMS"]
        self.assertEqual({row["labels"]["target"] for row in sizes}, {"0.01", "0.003", "0.001"})
        self.assertEqual({row["labels"]["codec"] for row in sizes}, {row["labels"]["codec"] for row in errors})
        self.assertGreaterEqual({row["labels"]["codec"] for row in sizes}, {"Volute", "zfp 4D"})
        for row in sizes:
            self.assertGreater(row["value"], 0)
            self.assertGreater(row["ratio"], 0)
            if row["labels"]["codec"] == "Volute":
                self.assertEqual(row["ratio"], 1, row)
        for row in errors:
            self.assertLessEqual(row["value"], float(row["labels"]["target"]), row)
        for figure in ("decoding", "encoding", "one frame", "one region", "memory of encoding", "memory of decoding"):
            found = {row["labels"]["codec"] for row in rows if row["labels"]["figure"] == figure}
            self.assertGreaterEqual(found, {"Volute", "zfp 4D"}, figure)
        for row in rows:
            if row["labels"]["figure"] == "missing":
                self.assertIsNone(row["value"])
                self.assertIn("this build has no", row["note"])

    def test_bench_builds_peers_of_their_sources(self):
        # A peer that needs nothing but the functions that its adapter calls: values as they are.
        peers = self.path("peers")
        (peers / "SPERR" / "include").mkdir(parents=True)
        (peers / "SPERR" / "src").mkdir()
        functions = '''#include <stddef.h>
namespace C_API { extern "C" {
int sperr_comp_3d(const void*, int, size_t, size_t, size_t, size_t, size_t, size_t, int, double, size_t, void**, size_t*);
int sperr_decomp_3d(const void*, size_t, int, size_t, size_t*, size_t*, size_t*, void**);
} }
'''
        (peers / "SPERR" / "include" / "SPERR_C_API.h").write_text(functions)
        (peers / "SPERR" / "src" / "peer.cpp").write_text('''#include "SPERR_C_API.h"
#include <stdlib.h>
#include <string.h>
static int copy(const void* from, size_t size, void** to) { *to = malloc(size); memcpy(*to, from, size); return 0; }
int C_API::sperr_comp_3d(const void* from, int, size_t x, size_t y, size_t z, size_t, size_t, size_t, int, double, size_t, void** to, size_t* size) {
  *size = 4 * x * y * z; return copy(from, *size, to); }
int C_API::sperr_decomp_3d(const void* from, size_t size, int, size_t, size_t*, size_t*, size_t*, void** to) { return copy(from, size, to); }
''')
        said = self.works("bench", "codec", "--input", self.make_npy(), "--peers", peers, "--json").json
        rows = said["benchmarks"][0]["rows"]
        size = [row["value"] for row in rows if row["labels"]["codec"] == "SPERR" and row["labels"]["figure"] == "size"]
        self.assertEqual(size, [1, 1, 1])
        missing = [row["note"] for row in rows if row["labels"]["codec"] == "SZ3"]
        self.assertEqual(len(missing), 1)
        self.assertIn("there is no folder SZ3", missing[0])

    def test_bench_says_which_peer_is_not_there(self):
        # The programs alone: first without that of the benchmarks, then without the plug-ins that lie beside them.
        alone = self.path("bin") / "volute"
        alone.parent.mkdir()
        shutil.copy(support.PROGRAM, alone)
        words = [alone, "bench", "codec", "--input", self.make_npy(frames=1, size=8)]
        done = subprocess.run(words, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=120)
        self.assertEqual((done.returncode, done.stdout), (1, ""))
        self.assertEqual(done.stderr, f"volute bench: {alone}-bench is missing: "
                                      "./dev bench builds and runs it from Volute's sources\n")
        shutil.copy(pathlib.Path(support.PROGRAM).with_name("volute-bench"), alone.parent)
        done = subprocess.run(words, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=120)
        self.assertEqual(done.returncode, 0, done.stderr)
        if "size at 0.01, OpenVDB" in done.stdout:
            self.skipTest("the plug-in is installed")
        self.assertRegex(done.stdout, r"in: OpenVDB half, zip +- +not measured: .*(cannot be loaded|has no OpenVDB)")

    def test_bench_wants_a_volume_that_varies(self):
        write_npy(self.path("flat.npy"), (1, 2, 2, 2), [1.0] * 8)
        self.assertIn("varies", self.fails(1, "bench", "codec", "--input", self.path("flat.npy")))


if __name__ == "__main__":
    support.main()
