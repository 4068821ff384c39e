# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""FDS cases through the program, written here as FDS writes them."""
import csv
import json
import math
import re
import struct

import support
from sight_cases import FdsCase, Mesh
from support import read_npy


def record(data):
    return struct.pack("<i", len(data)) + data + struct.pack("<i", len(data))


def slice_file(indices, frames, labels=("SOOT EXTINCTION COEFFICIENT", "ext", "1/m")):
    out = b"".join(record(text.ljust(30).encode()) for text in labels)
    out += record(struct.pack("<6i", *indices))
    for time, values in frames:
        out += record(struct.pack("<f", time)) + record(struct.pack(f"<{len(values)}f", *values))
    return out


def planes(axis, values):
    return f"TRN{axis}\n 0\n" + "".join(f" {i} {value:.5f}\n" for i, value in enumerate(values))


def write_case(path):
    """Two meshes side by side, cells of 0.5 and 0.25 m; extinction 1 and 2, doubled at 10 s; a wall in the first."""
    text = "FDSVERSION\nFDS6.9.1\n\nNMESHES\n 2\n\n"
    files = ""
    for mesh, (begin, cell, count) in enumerate(((0, 0.5, 2), (1, 0.25, 4)), start=1):
        text += f"GRID  mesh{mesh}\n {count} {count} {count} 0\n\n"
        text += planes("X", [begin + cell * i for i in range(count + 1)])
        for axis in "YZ":
            text += planes(axis, [cell * i for i in range(count + 1)])
        wall = "OBST\n 1\n 0 0 0 0 0 0 1 0 0 0 0 0 0\n 0 1 0 1 0 2 -1 -1\n"
        text += (wall if mesh == 1 else "OBST\n 0\n") + "\nVENT\n 0 0\n\n"
        indices = (0, count, 0, count, 0, count)
        values = [float(mesh)] * (count + 1) ** 3
        path(f"case_{mesh}.sf").write_bytes(
            slice_file(indices, [(0, values), (10, [2 * value for value in values])]))
        files += f"SLCC {mesh} # STRUCTURED & {' '.join(map(str, indices))}\n case_{mesh}.sf\n"
        files += " SOOT EXTINCTION COEFFICIENT\n ext\n 1/m\n"
    path("case.smv").write_text(text + files + "HIDE_OBST 1\n 1 5.0\n")
    return path("case.smv")


def add_slice(path, case, mesh, indices, value, labels, keyword="SLCC"):
    i1, i2, j1, j2, k1, k2 = indices
    count = (i2 - i1 + 1) * (j2 - j1 + 1) * (k2 - k1 + 1)
    name = f"{labels[1]}_{mesh}.sf"
    path(name).write_bytes(slice_file(indices, [(t, [value] * count) for t in (0, 10)], labels))
    with case.open("a") as file:
        file.write(f"{keyword} {mesh} # STRUCTURED & {' '.join(map(str, indices))}\n {name}\n"
                   + "".join(f" {label}\n" for label in labels))


def add_stored(path, case):
    """Isosurfaces of 60 C at x = 0.5 in the first mesh, at 10 s alone, and two classes of particles, of which drops have a
    temperature."""
    def ints(*values):
        return record(struct.pack(f"<{len(values)}i", *values))

    def floats(*values):
        return record(struct.pack(f"<{len(values)}f", *values))

    def label(text):
        return record(text.encode().ljust(30))

    path("case_1.iso").write_bytes(
        ints(1) + ints(1) + ints(1) + floats(60) + ints(0) + ints(0, 0) + floats(0, 0) + ints(0, 0) + floats(10, 0) + ints(4, 2)
        + floats(0.5, 0, 0, 0.5, 1, 0, 0.5, 1, 1, 0.5, 0, 1) + ints(1, 2, 3, 1, 3, 4) + ints(1, 1))
    empty = ints(0) + record(b"") + record(b"")
    path("case_2.prt5").write_bytes(
        ints(1) + ints(600) + ints(2) + ints(0, 0) + ints(1, 0) + label("PARTICLE TEMPERATURE") + label("C")
        + floats(0) + empty + empty + record(b"")
        + floats(10) + ints(1) + floats(1.5, 0.0, 0.5) + ints(1) + ints(2) + floats(1.25, 1.75, 0.0, 0.0, 0.5, 0.5) + ints(2, 3)
        + floats(20, 80))
    text = case.read_text()
    classes = ("CLASS_OF_PARTICLES\n tracer\n 1.0 0.0 0.0\n 0\n\nCLASS_OF_PARTICLES\n drops % more\n 0.0 0.0 1.0\n 1\n"
               " PARTICLE TEMPERATURE\n temp\n C\n\n")
    case.write_text(text.replace("NMESHES", classes + "NMESHES", 1) + "ISOG 1 1 -1.0\n case_1.iso\n TEMPERATURE\n temp\n C\n"
                    "PRT5 2\n case_2.prt5\n 2\n 1\n 2\n")


class Fds(support.TestCase):
    """Of write_case()."""

    def setUp(self):
        super().setUp()
        self.case = write_case(self.path)

    def test_info_says_what_is_read(self):
        said = self.works("info", self.case, "--values", "--json").json
        self.assertEqual(said["kind"], "fds")
        self.assertEqual([mesh["cells"] for mesh in said["meshes"]], [[2, 2, 2], [4, 4, 4]])
        self.assertEqual(said["source"], "slice3d-extinction-cells")
        self.assertEqual((said["frames"], said["times"]), (2, [0, 10]))
        self.assertEqual(said["obstruction_events"], [5])
        self.assertEqual((said["remarks"], said["ended"]), ([], False))
        self.assertEqual(said["most_extinction"], 4)
        self.assertIn("slice3d-extinction-cells: 3D slices of extinction, values of cells",
                      self.works("info", self.case).text)

    def test_a_running_case_is_read_as_far_as_it_goes(self):
        whole = self.path("case_2.sf").read_bytes()
        self.path("case_2.sf").write_bytes(whole[:-1])
        said = self.works("info", self.case, "--json").json
        self.assertEqual(said["frames"], 1)
        self.assertIn("within frame 1", said["remarks"][0]["sentence"])

    def test_a_mesh_cut_between_frames_is_told_by_every_command(self):
        path = self.path("case_1.sf")
        path.write_bytes(path.read_bytes()[:274])  # behind the first of two frames
        said = self.works("info", self.case, "--json").json
        self.assertEqual([(one["file"], one["mesh"], one["state"], one["frames"]) for one in said["data_files"]],
                         [("case_1.sf", 1, "short", 1), ("case_2.sf", 2, "whole", 2)])
        self.assertIn("1 of 2 stored times are left out (10 to 10 s)", said["remarks"][0]["sentence"])
        self.assertIn("case_1.sf: has fewer frames (1, the last at 0 s) than case_2.sf (mesh 2: 2, the last at 10 s)",
                      self.works("info", self.case).text)
        eye = ("--eye", "1.5,-1,0.5", "--target", "1.5,0,0.5", "--ortho", "1", "--size", "4x4")
        self.path("signs.json").write_text(json.dumps(
            {"signs": [{"name": "exit", "position": [1.9, 0.5, 0.5], "normal": [-1, 0, 0], "size": [0.3, 0.2]}]}))
        survey = ("visibility", self.case, "--signs", self.path("signs.json"), "--height", "0.5", "-o", self.path("out"))
        self.assertIn("is stored from 0 to 10 s, but not known after 0 s in mesh 1 (case_1.sf)", self.works(*survey).message)
        for command in (("render", self.case, "-o", self.path("x.png"), *eye),
                        ("compress", self.case, "-o", self.path("x.volute"), "--rms", "1e-3")):
            self.assertIn("1 of 2 stored times are left out", self.works(*command).message, command)

    def sees(self, case, *options):
        """The optical depths of an eye, and what was said."""
        self.path("signs.json").write_text(json.dumps({"signs": [{"name": "s", "position": [1.9, 0.5, 0.15], "normal": [-1, 0, 0]}]}))
        self.path("eyes.csv").write_text("x,y,z\n0.1,0.5,0.15\n")
        done = self.works("visibility", case, "--signs", self.path("signs.json"), "--eyes", self.path("eyes.csv"), "--criteria", "none",
                          "-o", self.path("out"), *options)
        with open(self.path("out") / "sight.csv", newline="") as file:
            return [float(row["optical_depth"]) for row in csv.DictReader(file)], done.message

    def test_meshes_are_connected_as_fds_does_it(self):
        """By the cube root of the smallest cell's volume: a twentieth of 29 mm is more than 1 mm, of 14 mm less."""
        for gap, cells, said in ((0.0008, 20, False), (0.0012, 20, True), (0.0008, 60, True)):
            meshes = [Mesh("a", (0, 1, 0, 1, 0, 0.3), (100, cells, cells * 3 // 10)),
                      Mesh("b", (1 + gap, 2, 0, 1, 0, 0.3), (10, cells, cells * 3 // 10))]
            case = FdsCase(meshes, [0.0, 10.0], lambda t, *_: 0.1 * t).write(self.folder)
            depths, message = self.sees(case)
            self.assertEqual("apart by more than FDS connects" in message, said, (gap, cells))
            if not said:
                self.assertAlmostEqual(depths[-1], 1.8, delta=0.01)

    def test_a_factor_of_visibility_is_that_of_other_slices(self):
        """C = 8, which no input file says: the extinction is stored until 10 s alone."""
        hall = Mesh("hall", (0, 2, 0, 1, 0, 0.3), (20, 10, 3))
        smoke = lambda t, x, *_: 0.03 * (t + 10) * (1 + x)
        seen = lambda t, x, *_: min(30.0, 8 / smoke(t, x))
        case = FdsCase([hall], [0.0, 10.0, 20.0], seen, more=[("SOOT EXTINCTION COEFFICIENT", "1/m", smoke)])
        index = case.write(self.folder)
        text = index.read_text()  # the first of the two is the visibility
        index.write_text(text.replace("SOOT EXTINCTION COEFFICIENT\n short\n 1/m", "SOOT VISIBILITY\n short\n m", 1))
        case.write_slice(self.path("case_1_1.sf"), hall, ("SOOT VISIBILITY", "short", "m"), seen)
        case.times = [0.0, 10.0]
        case.write_slice(self.path("case_1_2.sf"), hall, ("SOOT EXTINCTION COEFFICIENT", "short", "1/m"), smoke)
        for options in ((), ("--field", "slice3d-visibility-cells")):
            depths, message = self.sees(index, *options)
            self.assertIn("C = 8 (by slice3d-extinction-cells, at the same times; FDS's default is 3)", message)
            for time, depth in zip((0, 10, 20), depths):
                self.assertAlmostEqual(depth, 1.8 * 0.03 * (time + 10) * 2, delta=0.01)
        index.write_text(index.read_text() + "INPF\n case.fds\n")
        self.path("case.fds").write_text("&HEAD CHID='case' /\n&MISC VISIBILITY_FACTOR=4 /\n")
        said = self.sees(index)[1]
        self.assertIn("visibility by C = 4 (VISIBILITY_FACTOR of case.fds) contradicts slice3d-extinction-cells, by which it is 8 to 8 at", said)
        self.path("case.fds").write_text("&HEAD CHID='case' /\n&MISC VISIBILITY_FACTOR=8 /\n")
        self.assertNotIn("contradicts", self.sees(index)[1])

    def test_missing_files_are_listed_and_refused(self):
        self.path("case_2.sf").unlink()
        said = self.works("info", self.case, "--json").json
        self.assertEqual([one["state"] for one in said["data_files"]], ["whole", "missing"])
        self.assertIsNone(said["source"])
        self.assertIn("mesh 2: missing", self.works("info", self.case).text)
        self.assertIn("case.smv names it for mesh 2", self.fails(1, "compress", self.case, "-o", self.path("x.volute"), "--rms", "1e-3"))

    def test_a_flipped_marker_is_refused_with_its_byte(self):
        data = bytearray(self.path("case_1.sf").read_bytes())
        data[146] ^= 4
        self.path("case_1.sf").write_bytes(data)
        self.assertIn("case_1.sf: byte 146: the record marker", self.fails(1, "info", self.case))

    def test_extract_gives_voxels_of_the_finest_cells(self):
        self.works("extract", self.case, "-o", self.path("out.npy"))
        self.assertIn("volute compress", self.fails(2, "extract", self.case, "-o", self.path("out.volute")))
        shape, values = read_npy(self.path("out.npy").read_bytes())
        self.assertEqual(shape, (2, 4, 4, 8))
        row = lambda t, z, y: list(values[((t * 4 + z) * 4 + y) * 8:][:8])
        self.assertEqual(row(0, 0, 0), [0, 0, 1, 1, 2, 2, 2, 2])  # through the wall
        self.assertEqual(row(0, 3, 3), [1, 1, 1, 1, 2, 2, 2, 2])
        self.assertEqual(row(1, 0, 0), [2, 2, 2, 2, 4, 4, 4, 4])  # which is gone
        self.works("extract", self.case, "-o", self.path("{mesh}.npy"), "--frames", "1:2")
        self.assertEqual(read_npy(self.path("0001.npy").read_bytes())[0], (1, 4, 4, 4))
        self.assertEqual(set(read_npy(self.path("0002.npy").read_bytes())[1]), {4})

    def test_a_case_is_a_volume(self):
        self.works("compress", self.case, "-o", self.path("x.volute"), "--max-error", "0.01")
        said = self.works("info", self.path("x.volute"), "--json").json
        self.assertEqual((said["grid"], said["unit"], said["size"], said["times"]),
                         ("extinction", "1/m", [8, 4, 4], [0, 10]))

    def seen(self, x, time, *more, grey=True):
        """What a parallel camera sees along +y at this x, before white."""
        self.works("render", self.case, "-o", self.path("x.exr"), "--ortho", "0.1", "--eye", f"{x},-1,0.5",
                   "--target", f"{x},0,0.5", "--size", "4x4", "--background", "1,1,1", "--time", str(time),
                   "--albedo", "0,0,0", *more)
        info = self.works("info", self.path("x.exr"), "--json").json
        if grey:
            self.assertAlmostEqual(info["minimum"], info["maximum"], delta=1e-6)
        return info["maximum"]

    def test_a_case_is_rendered_as_smoke_with_its_building(self):
        self.assertAlmostEqual(self.seen(1.5, 0), math.exp(-2), delta=1e-6)
        self.assertAlmostEqual(self.seen(1.5, 10), math.exp(-4), delta=1e-6)
        self.assertAlmostEqual(self.seen(1.5, 10, "--scale", "0.5"), math.exp(-2), delta=1e-6)
        wall = self.seen(0.25, 4.9, "--aov", "optical-depth")
        self.assertEqual(wall, 0)
        # The wall is gone; where it stood, smoke is known from 10 s alone.
        self.assertAlmostEqual(self.seen(0.25, 5), math.exp(-0.5 * 2 - 0.5 * 1.5), delta=1e-6)
        self.assertAlmostEqual(self.seen(0.25, 4.9, "--aov", "transmittance"), 1, delta=1e-6)
        self.assertIn("--quantity", self.fails(2, "render", self.case, "-o", self.path("x.png"),
                                               "--quantity", "extinction"))

    def test_a_case_is_a_medium_of_a_scene(self):
        scene = {"format": "volute-scene-1", "background": [1, 1, 1], "lights": [{"kind": "ambient", "radiance": [1, 1, 1]}],
                 "camera": {"eye": [1.5, -1, 0.5], "target": [1.5, 0, 0.5], "ortho": 0.1, "size": [4, 4]},
                 "media": [{"kind": "smoke", "case": "case.smv", "albedo": [0.5, 0.5, 0.5]}]}
        self.path("scene.json").write_text(json.dumps(scene))
        self.works("render", self.path("scene.json"), "-o", self.path("x.exr"))
        info = self.works("info", self.path("x.exr"), "--json").json
        self.assertAlmostEqual(info["maximum"], math.exp(-2) + 0.5 * (1 - math.exp(-2)), delta=1e-6)

    def test_a_clock_of_a_scene_is_for_pictures(self):
        self.path("signs.json").write_text(json.dumps({"signs": [{"name": "exit", "position": [2, 0.5, 0.5], "normal": [-1, 0, 0]}]}))
        self.path("eyes.csv").write_text("x,y,z\n1.2,0.5,0.5\n")
        for time in ({"offset": 5}, {"rate": 2}, {"loop": True}):
            self.path("scene.json").write_text(json.dumps({"format": "volute-scene-2", "media": [{"kind": "smoke", "case": "case.smv", "time": time}]}))
            self.assertIn("/media/0/time: is for pictures", self.fails(2, "visibility", self.path("scene.json"), "--signs", self.path("signs.json"),
                                                                       "--eyes", self.path("eyes.csv"), "-o", self.path("out")))

    def add_slice(self, *more, **named):
        add_slice(self.path, self.case, *more, **named)

    def test_fire_shines_through_the_smoke(self):
        self.add_slice(2, (0, 4) * 3, 500.0, ("HRRPUV", "hrrpuv", "kW/m3"))
        clear = self.seen(1.5, 0, "--scale", "1e-9", "--fire", "8", grey=False) - 1
        self.assertGreater(clear, 4)  # 8/m per MW/m3 in 1 m of 0.5 MW/m3, more of it in red
        self.assertAlmostEqual(self.seen(1.5, 0, "--scale", "1e-9", "--fire", "4", grey=False) - 1, clear / 2, delta=1e-6)
        self.assertAlmostEqual(self.seen(1.5, 0, "--fire", "8", grey=False) - math.exp(-2), clear * (1 - math.exp(-2)) / 2,
                               delta=1e-5)
        for without in (("--fire", "0"), ("--fire-cutoff", "501")):
            self.assertAlmostEqual(self.seen(1.5, 0, *without), math.exp(-2), delta=1e-6)
        # It hides nothing.
        self.assertAlmostEqual(self.seen(1.5, 0, "--aov", "optical-depth"), 2, delta=1e-6)
        with self.case.open("a") as file:
            file.write("HRRPUVCUT\n 1\n 600.0\n")
        self.assertAlmostEqual(self.seen(1.5, 0), math.exp(-2), delta=1e-6)
        self.works("render", self.case, "-o", self.path("x.png"), "--size", "40x40")
        self.assertIn(b"fire: black body 1500 K, 20/m per MW/m3, above 600 kW/m3", self.path("x.png").read_bytes())

    def test_a_surface_of_a_quantity_is_a_translucent_sheet(self):
        for mesh, count, value in ((1, 2, 20.0), (2, 4, 100.0)):
            self.add_slice(mesh, (0, count) * 3, value, ("TEMPERATURE", "temp", "C"))

        def along_x(*more):
            self.works("render", self.case, "-o", self.path("x.exr"), "--ortho", "0.1", "--eye", "-1,0.75,0.5", "--target",
                       "2,0.75,0.5", "--size", "4x4", "--time", "0", "--aov", "optical-depth", *more)
            return self.works("info", self.path("x.exr"), "--json").json["maximum"]

        self.assertAlmostEqual(along_x(), 3, delta=1e-5)
        sheet = -math.log(0.6)
        self.assertAlmostEqual(along_x("--fds-iso", "TEMPERATURE 60"), 3 + sheet, delta=1e-5)
        self.assertAlmostEqual(along_x("--fds-iso", "TEMPERATURE 40,60,300"), 3 + 2 * sheet, delta=1e-5)
        self.works("render", self.case, "-o", self.path("x.png"), "--size", "40x40", "--fds-iso", "TEMPERATURE 60")
        self.assertIn(b"surface: TEMPERATURE = 60 C", self.path("x.png").read_bytes())
        for text, says in (("TEMPERATURE", "is no isosurface"), ("TEMPERATURE 1,x", "is no isosurface"),
                           ("TEMPERATURE nan", "is no isosurface"), ("HEAT 3", "no file of the case has 'HEAT'")):
            said = self.fails(1 if text == "HEAT 3" else 2, "render", self.case, "-o", self.path("x.png"), "--fds-iso", text)
            self.assertIn(says, said)
        self.assertIn("isosurfaces of an FDS case", self.fails(1, "render", self.case, "-o", self.path("x.png"), "--fds-iso",
                                                               "TEMPERATURE 60", "--renderer", "gl"))

    def test_a_layer_gives_way_where_signs_are_outside_of_it(self):
        """A slice at z = 0.5 m would go first: it is of nodes and of both meshes; a sign at 0.95 m needs 3D slices."""
        for mesh, count in ((1, 2), (2, 4)):
            self.add_slice(mesh, (0, count, 0, count, count // 2, count // 2), 1.0,
                           ("SOOT EXTINCTION COEFFICIENT", "ext_2d", "1/m"), "SLCF")
        text = self.case.read_text()
        self.case.write_text(re.sub(r"SLCC \d # STRUCTURED & 0 (\d) 0 \1 0 \1\n case_\d.sf\n.*\n.*\n.*\n", "", text)
                             + "".join(f"SMOKF3D {mesh} 8700.0\n none_{mesh}.s3d\n SOOT DENSITY\n rho\n kg/m3\n" for mesh in (1, 2)))
        for mesh, count in ((1, 2), (2, 4)):
            nodes = (count + 1) ** 3
            self.path(f"none_{mesh}.s3d").write_bytes(
                record(struct.pack("<8i", 1, 0, 0, count, 0, count, 0, count))
                + b"".join(record(struct.pack("<f", t)) + record(struct.pack("<2i", nodes, nodes)) + record(bytes(nodes)) for t in (0, 10)))
        signs = self.path("signs.json")
        for z, read in ((0.5, "ext"), (0.95, "s3d")):
            signs.write_text(json.dumps({"signs": [{"name": "exit", "position": [1.95, 0.8, z], "normal": [-1, 0, 0]}]}))
            ran = self.works("visibility", self.case, "--signs", signs, "--height", "0.5", "--step", "0.25", "--maps", "aset",
                             "--criteria", "none", "-o", self.path("seen"))
            said = json.loads((self.path("seen") / "visibility.json").read_text())
            self.assertEqual("s3d" in said["smoke"], read == "s3d", said["smoke"])
            self.assertEqual(b"extinction is read from s3d alone" in ran.err, read == "s3d", ran.err)
        # A scene shows what it says, and nothing else is claimed.
        scene = self.path("scene.json")
        scene.write_text(json.dumps({"format": "volute-scene-1", "media": [{"kind": "smoke", "case": self.case.name}]}))
        said = self.fails(2, "visibility", scene, "--signs", signs, "--height", "0.5", "--step", "0.25", "-o", self.path("seen"))
        self.assertNotIn("s3d alone", said)
        self.assertIn("outside", said)

    def test_stored_isosurfaces_are_shown(self):
        add_stored(self.path, self.case)

        def depth(time, *more):
            self.works("render", self.case, "-o", self.path("x.exr"), "--ortho", "0.1", "--eye", "-1,0.75,0.75", "--target",
                       "2,0.75,0.75", "--size", "4x4", "--time", time, "--aov", "optical-depth", "--scale", "1e-9", *more)
            return self.works("info", self.path("x.exr"), "--json").json["maximum"]

        sheet = -math.log(0.6)
        for text in ("TEMPERATURE", "TEMPERATURE 60"):
            self.assertAlmostEqual(depth(10, "--fds-iso", text), sheet, delta=1e-5)
            self.assertAlmostEqual(depth(4, "--fds-iso", text), 0, delta=1e-5)
        self.works("render", self.case, "-o", self.path("x.png"), "--size", "40x40", "--fds-iso", "TEMPERATURE", "--time", 10)
        self.assertIn(b"surface: TEMPERATURE = 60 C, the nearest of 2 stored times", self.path("x.png").read_bytes())
        out = ("render", self.case, "-o", self.path("x.png"), "--fds-iso")
        self.assertIn("the case has isosurface files of TEMPERATURE", self.fails(1, *out, "TEMPERATURE 61"))
        self.assertIn("the case has isosurface files of TEMPERATURE", self.fails(2, *out, "HEAT"))
        whole = self.path("case_1.iso").read_bytes()
        self.path("case_1.iso").write_bytes(whole[:-4])
        self.assertIn(b"ends at byte", self.works(*out, "TEMPERATURE", "--size", "8x8").err)
        self.assertEqual([(one["kind"], one["state"], one["frames"]) for one in self.works("info", self.case, "--json").json[
            "data_files"] if "iso" in one["kind"]], [("isosurfaces of TEMPERATURE", "truncated", 1)])
        self.path("case_1.iso").write_bytes(whole.replace(struct.pack("<3i", 1, 2, 3), struct.pack("<3i", 1, 2, 9)))
        self.assertIn("a triangle of vertex 9", self.fails(1, *out, "TEMPERATURE", "--time", 10))
        self.path("case_1.iso").unlink()
        self.assertIn("case_1.iso", self.fails(1, *out, "TEMPERATURE"))

    def test_particles_are_marks_in_the_picture(self):
        add_stored(self.path, self.case)

        def most(x, *more, time=10):
            self.works("render", self.case, "-o", self.path("x.exr"), "--ortho", "0.001", "--eye", f"{x},-1,0.5", "--target",
                       f"{x},0,0.5", "--size", "2x2", "--time", time, "--scale", "1e-9", "--albedo", "0,0,0", "--background",
                       "0,0,0", *more)
            return self.works("info", self.path("x.exr"), "--json").json["maximum"]

        self.assertEqual(most(1.5), 0)
        self.assertAlmostEqual(most(1.5, "--fds-particles", "all"), 1, delta=1e-6)
        self.assertAlmostEqual(most(1.25, "--fds-particles", "drops"), 1, delta=1e-6)
        self.assertEqual(most(1.5, "--fds-particles", "drops"), 0)
        self.assertEqual(most(1.5, "--fds-particles", "all", time=4), 0)
        self.works("render", self.case, "-o", self.path("x.png"), "--size", "40x40", "--fds-particles", "PARTICLE TEMPERATURE")
        self.assertIn(b"particles: drops, PARTICLE TEMPERATURE 20 .. 80 C, the nearest of 2 stored times",
                      self.path("x.png").read_bytes())
        said = self.fails(1, "render", self.case, "-o", self.path("x.png"), "--fds-particles", "rain")
        self.assertIn("no particles of 'rain'; the case has all, or those of drops, tracer, coloured by PARTICLE TEMPERATURE", said)

    def test_devices_are_listed_and_marked(self):
        with self.case.open("a") as file:
            file.write("DEVICE\n exit % VISIBILITY\n 1.5 0.0 0.5 0 0 -1 0 0\nDEVICE_ACT 1\n 1 4.0 1\n")
        said = self.works("info", self.case, "--json").json["devices"]
        self.assertEqual(said, [{"label": "exit", "quantity": "VISIBILITY", "position": [1.5, 0, 0.5], "active": False,
                                 "events": [{"time": 4, "active": True}]}])
        self.assertIn("exit (VISIBILITY) at 1.5, 0, 0.5 m, idle, active at 4 s", self.works("info", self.case).text)
        self.assertAlmostEqual(self.seen(1.5, 0), math.exp(-2), delta=1e-6)

        def blue(time):
            """Of the mark's middle, which lies before the smoke."""
            self.works("render", self.case, "-o", self.path("x.exr"), "--ortho", "0.01", "--eye", "1.5,-1,0.5",
                       "--target", "1.5,0,0.5", "--size", "2x2", "--time", str(time), "--devices", "--albedo", "0,0,0")
            return self.works("info", self.path("x.exr"), "--json").json["maximum"]
        self.assertAlmostEqual(blue(0), 0.8, delta=0.01)
        self.assertAlmostEqual(blue(4), 0.9, delta=0.01)

    def test_slices_are_sheets_in_the_picture(self):
        self.add_slice(2, (0, 4, 0, 4, 2, 2), 60.0, ("TEMPERATURE", "temp", "C"), "SLCF")
        said = self.works("info", self.case, "--json").json
        self.assertEqual(said["slices"], {"TEMPERATURE at z = 0.5 m": 1})

        def from_above(*more):
            self.works("render", self.case, "-o", self.path("x.exr"), "--ortho", "0.1", "--eye", "1.5,0.55,3",
                       "--target", "1.5,0.55,0", "--up", "0,1,0", "--size", "4x4", "--albedo", "0,0,0", *more)
            return self.works("info", self.path("x.exr"), "--json").json["maximum"]
        self.assertAlmostEqual(from_above(), math.exp(-2), delta=1e-6)
        # Viridis ends in yellow, 0.99 of red as sRGB; half of the smoke is above the sheet.
        self.assertAlmostEqual(from_above("--fds-slice", "TEMPERATURE", "--fds-slice-range", "20,50"), 0.98 * math.exp(-1),
                               delta=0.02)
        dark = from_above("--fds-slice", "TEMPERATURE", "--fds-slice-range", "60,100")
        self.assertLess(dark, 0.12 * math.exp(-1))
        self.assertIn("no 2D slice of 'HEAT'; the case has slices of SOOT EXTINCTION COEFFICIENT, TEMPERATURE",
                      self.fails(1, "render", self.case, "-o", self.path("x.png"), "--fds-slice", "HEAT"))
        self.fails(2, "render", self.case, "-o", self.path("x.png"), "--fds-slice", "TEMPERATURE", "--fds-slice-range", "5,2")
        # At its plane, within half a cell, or not at all.
        there = from_above("--fds-slice", "TEMPERATURE z=0.6", "--fds-slice-range", "20,50")
        self.assertAlmostEqual(there, 0.98 * math.exp(-1), delta=0.02)
        self.assertIn("no slice of 'TEMPERATURE z=0.9'",
                      self.fails(1, "render", self.case, "-o", self.path("x.png"), "--fds-slice", "TEMPERATURE z=0.9"))
        self.assertIn("expected a quantity, as TEMPERATURE, or one and a plane",
                      self.fails(2, "render", self.case, "-o", self.path("x.png"), "--fds-slice", "TEMPERATURE w=1"))

    def test_a_plane_cuts_3d_slices(self):
        self.add_slice(2, (0, 4, 0, 4, 0, 4), 60.0, ("TEMPERATURE", "temp", "C"), "SLCF")

        def from_above(*more):
            self.works("render", self.case, "-o", self.path("x.exr"), "--ortho", "0.1", "--eye", "1.5,0.55,3",
                       "--target", "1.5,0.55,0", "--up", "0,1,0", "--size", "4x4", "--albedo", "0,0,0", *more)
            return self.works("info", self.path("x.exr"), "--json").json["maximum"]
        # Three quarters of the smoke are above the sheet.
        self.assertAlmostEqual(from_above("--fds-slice", "TEMPERATURE z=0.25", "--fds-slice-range", "20,50"),
                               0.98 * math.exp(-1.5), delta=0.02)
        self.assertIn("TEMPERATURE z=7 is outside of the case; expected 0 to 1 m",
                      self.fails(2, "render", self.case, "-o", self.path("x.png"), "--fds-slice", "TEMPERATURE z=7"))
        self.assertIn("a plane, as z=1.5 behind the name, cuts 3D ones",
                      self.fails(1, "render", self.case, "-o", self.path("x.png"), "--fds-slice", "TEMPERATURE"))

    def test_a_ruler_is_named_where_it_is_seen(self):
        """The caption says its divisions, and numbers stand along it, from outside alone."""
        def said(*more):
            self.works("render", self.case, "-o", self.path("x.png"), "--size", "400x300", *more)
            return self.path("x.png").read_bytes()
        self.assertTrue(b"ruler: " in said())
        # Where the wall was until 5 s, which is all of the building.
        within = said("--eye", "0.25,0.25,0.5", "--target", "3,0.25,0.5", "--fov", "60", "--time", "8")
        self.assertFalse(b"ruler" in within)

    def test_a_tall_case_has_a_ruler_upwards(self):
        for height, upwards in ((60, b"ruler: 2 m each, 5 m upwards"), (9, b"ruler: 2 m each")):
            mesh = Mesh("tower", (0, 20, 0, 15, 0, height), (10, 10, 30))
            case = FdsCase([mesh], [0.0], lambda *_: 0.1).write(self.folder, f"tower{height}")
            self.works("render", case, "-o", self.path("x.png"), "--size", "300x400")
            said = self.path("x.png").read_bytes()
            self.assertIn(upwards, said)
            self.assertEqual(b"upwards" in said, height > 12)

    def test_options_that_would_change_nothing_are_refused_by_all_commands(self):
        self.path("signs.json").write_text('{"signs": [{"name": "a", "position": [1, 0.5, 0.5], "normal": [0, 0, 1]}]}')
        survey = ("visibility", self.case, "--signs", self.path("signs.json"), "-o", self.path("out"))
        for words in (("--fds-slice", "NO_SUCH", "--fds-slice-range", "5,1"), ("--albedo", "0,0,0"), ("--mode", "threshold"),
                      ("--fds-particles", "all"), ("--devices",)):
            self.assertIn(f"unknown option {words[0]}", self.fails(2, *survey, *words))
        picture = ("render", self.case, "-o", self.path("x.png"))
        for words in (("--quantity", "extinction"), ("--scale", "2"), ("--clamp",), ("--density-field", "rho")):
            self.assertIn(f"{words[0]} is for smoke on meshes; {self.case} is an FDS case", self.fails(2, *survey, *words))
            if words[0] != "--scale":
                self.assertIn(f"{words[0]} is for smoke on meshes; {self.case} is an FDS case", self.fails(2, *picture, *words))
        for words, said in ((("--emission", "2"), "--emission is for volumes of voxels"),
                            (("--bounds=0,0,0,1,1,1",), "--bounds is for volumes of voxels"),
                            (("--smoke-method", "march"), "--smoke-method is for smoke on meshes and scenes"),
                            (("--fds-slice-range", "1,2"), "--fds-slice-range has no effect without --fds-slice")):
            self.assertIn(said, self.fails(2, *picture, *words))
        self.assertIn("--blocks is for .volute files", self.fails(2, "info", self.case, "--blocks"))
        self.assertIn("--region is for .volute files", self.fails(2, "extract", self.case, "-o", self.path("x.npy"),
                                                                  "--region", "0:1,0:1,0:1"))

    def test_a_source_has_one_name_and_its_former_ones(self):
        for name in ("--field", "--grid", "--source"):
            self.works("render", self.case, "-o", self.path("x.png"), "--size", "4x4", name, "slice3d-extinction-cells")
        self.assertIn("--field, also called --source, also called --grid is given 2 times",
                      self.fails(2, "render", self.case, "-o", self.path("y.png"), "--field", "x", "--grid", "x"))

    def test_members_of_meshes_are_refused(self):
        scene = {"format": "volute-scene-1", "camera": {"eye": [1, 0.5, 3], "target": [1, 0.5, 0], "ortho": 1},
                 "media": [{"kind": "smoke", "case": "case.smv", "negatives": "clamp"}]}
        self.path("scene.json").write_text(json.dumps(scene))
        self.assertIn("scene.json: /media/0/negatives: is for smoke on meshes, and this is an FDS case",
                      self.fails(1, "render", self.path("scene.json"), "-o", self.path("x.png")))

    def test_a_case_with_a_roof_is_seen_from_inside(self):
        text = self.case.read_text()
        roof = "OBST\n 1\n 1 2 0 1 0.75 1 1 0 0 0 0 0 0\n 0 4 0 4 3 4 -1 -1\n"
        self.assertIn("OBST\n 0\n", text)
        self.case.write_text(text.replace("OBST\n 0\n", roof, 1))  # over the second mesh
        self.works("render", self.case, "-o", self.path("a.exr"), "--size", "16x12", "--building", "inside")
        # 0.75 m high: eyes at 0.7 of that, a tenth of the length from the end.
        self.works("render", self.case, "-o", self.path("b.exr"), "--size", "16x12", "--eye", "1.1,0.5,0.525",
                   "--target", "1.5,0.5,0.525", "--fov", "60", "--building", "inside")
        self.assertEqual(self.path("a.exr").read_bytes(), self.path("b.exr").read_bytes())

    def test_a_case_alone_is_a_doll_s_house_with_a_caption(self):
        text = self.case.read_text()
        # The second mesh has a wall before it and a roof.
        house = ("OBST\n 2\n 1 2 0 1 0.75 1 1 0 0 0 0 0 0\n 1 2 0 0.25 0 0.75 2 0 0 0 0 0 0\n"
                 " 0 4 0 4 3 4 -1 -1\n 0 4 0 1 0 3 -1 -1\n")
        self.assertIn("OBST\n 0\n", text)
        self.case.write_text(text.replace("OBST\n 0\n", house, 1))
        done = self.works("render", self.case, "-o", self.path("a.png"), "--size", "160x120", "--scale", "1e-9")
        said = re.search(r"seen from outside; .* \(--eye (\S+) --target (\S+) --fov (\S+)\)", done.message)
        self.assertTrue(said, done.message)
        self.assertIn("showing 0 s: of 2 stored times", done.message)
        self.assertIn(b"case.smv", self.path("a.png").read_bytes())

        def looked(*more):
            self.works("render", self.case, "-o", self.path("b.exr"), "--size", "4x4", "--ortho", "0.1", "--eye", "1.5,-1,0.5",
                       "--target", "1.5,0,0.5", "--background", "9,9,9", "--scale", "1e-9", *more)
            return self.works("info", self.path("b.exr"), "--json").json["maximum"]
        self.assertAlmostEqual(looked(), 9, delta=1e-6)  # the wall before the room is left out
        self.assertLess(looked("--building", "whole"), 1)
        self.assertAlmostEqual(looked("--building", "whole", "--cut", "z=0.4"), 9, delta=1e-6)
        self.assertLess(looked("--building", "whole", "--cut", "y=-0.5"), 1)  # nothing is before that
        self.assertIn("'w=1' is not a plane", self.fails(2, "render", self.case, "-o", self.path("x.png"), "--cut", "w=1"))
        self.works("render", self.case, "-o", self.path("c.png"), "--size", "160x120", "--time", "0", "--no-legend")
        self.fails(2, "render", self.case, "-o", self.path("d.png"), "--legend", "--no-legend")

    def test_lines_of_a_building_are_as_bright_as_its_light(self):
        brightest = []
        for power in (0.01, 0.02):
            scene = {"format": "volute-scene-2", "camera": {"eye": [3, -3, 2], "target": [1, 0.5, 0.4], "fov": 40, "size": [64, 48]},
                     "lights": [{"kind": "spot", "position": [0.5, 0.5, 0.7], "target": [0.5, 0.5, 0], "angle": 360, "intensity": 3 * [power]}],
                     "media": [{"kind": "smoke", "case": "case.smv", "building": "open"}]}
            self.path("scene.json").write_text(json.dumps(scene))
            self.works("render", self.path("scene.json"), "-o", self.path("x.exr"))
            brightest.append(self.works("info", self.path("x.exr"), "--json").json["maximum"])
        self.assertAlmostEqual(brightest[1] / brightest[0], 2, delta=1e-3)

    def test_closed_walls_of_the_meshes_keep_light_from_smoke_as_they_are_drawn(self):
        def brightest(building, eye, target):
            scene = {"format": "volute-scene-2", "camera": {"eye": eye, "target": target, "fov": 30, "size": [32, 24]},
                     "lights": [{"kind": "sun", "direction": [0.1, 0.1, -1]}],
                     "media": [{"kind": "smoke", "case": "case.smv", "building": building}]}
            self.path("scene.json").write_text(json.dumps(scene))
            self.works("render", self.path("scene.json"), "-o", self.path("x.exr"), "--time", "0")
            return self.works("info", self.path("x.exr"), "--json").json["maximum"]
        inside = ([1.1, 0.5, 0.5], [1.9, 0.6, 0.5])
        above = ([1.2, 0.4, 3], [1.5, 0.5, 0])
        self.assertGreater(brightest("whole", *inside), 1e-3)
        roofs = iter(("0 1 0 1 1 1 1 0\n 0 2 0 2 2 2 0 0", "1 2 0 1 1 1 1 0\n 0 4 0 4 4 4 0 0"))
        self.case.write_text(re.sub(r"VENT\n 0 0", lambda _: f"VENT\n 1 1\n {next(roofs)}", self.case.read_text()))
        self.assertEqual(brightest("whole", *inside), 0)
        self.assertGreater(brightest("open", *above), 1e-3)  # the roof is left out

    def test_what_is_not_there_is_said(self):
        self.assertIn("no source 's3d'; the case has slice3d-extinction-cells",
                      self.fails(1, "info", self.case, "--grid", "s3d"))
        self.case.write_text(self.case.read_text().split("SLCC")[0])
        self.assertIsNone(self.works("info", self.case, "--json").json["source"])
        self.assertIn("nothing in the case says how thick the smoke is",
                      self.fails(1, "extract", self.case, "-o", self.path("out.npy")))

    def test_a_case_without_smoke_shows_what_it_has(self):
        self.case.write_text(self.case.read_text().split("SLCC")[0])
        for z, degrees in ((1, 20.0), (2, 300.0)):
            add_slice(self.path, self.case, 2, (0, 4, 0, 4, z, z), degrees, ("TEMPERATURE", f"temp{z}", "C"), "SLCF")
        result = self.works("render", self.case, "-o", self.path("out.png"), "--size", "64x48")
        self.assertIn("stores no smoke; shown: the building, the slice TEMPERATURE z=0.5. The case has slices of TEMPERATURE",
                      result.message)
        self.assertIn("the last one", result.message)
        other = self.works("render", self.case, "-o", self.path("other.png"), "--size", "64x48", "--fds-slice", "TEMPERATURE z=0.25")
        self.assertIn("the slice TEMPERATURE z=0.25", other.message)
        self.assertNotEqual(self.path("out.png").read_bytes(), self.path("other.png").read_bytes())
        signs = self.path("signs.json")
        signs.write_text('{"signs": [{"name": "s", "position": [1.9, 0.5, 0.5], "normal": [-1, 0, 0]}]}')
        self.assertIn("nothing in the case says how thick the smoke is",
                      self.fails(1, "visibility", self.case, "--signs", signs, "-o", self.path("seen")))
        add_slice(self.path, self.case, 2, (0, 4, 0, 4, 2, 2), 1.0, ("SOOT DENSITY", "soot", "oz/gal"), "SLCF")
        self.assertIn("SOOT DENSITY in oz/gal is no such", self.fails(1, "visibility", self.case, "--signs", signs, "-o", self.path("seen")))


if __name__ == "__main__":
    support.main()
