# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""FDS cases through the program, written here as FDS writes them."""
import json
import math
import struct

import support
from support import read_npy


def record(data):
    return struct.pack("<i", len(data)) + data + struct.pack("<i", len(data))


def slice_file(indices, frames):
    out = b"".join(record(text.ljust(30).encode()) for text in ("SOOT EXTINCTION COEFFICIENT", "ext", "1/m"))
    out += record(struct.pack("<6i", *indices))
    for time, values in frames:
        out += record(struct.pack("<f", time)) + record(struct.pack(f"<{len(values)}f", *values))
    return out


def planes(axis, values):
    return f"TRN{axis}\n 0\n" + "".join(f" {i} {value:.5f}\n" for i, value in enumerate(values))


class Fds(support.TestCase):
    """Two meshes side by side, cells of 0.5 and 0.25 m; extinction 1 and 2, doubled at 10 s; a wall in the first."""

    def setUp(self):
        super().setUp()
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
            self.path(f"case_{mesh}.sf").write_bytes(
                slice_file(indices, [(0, values), (10, [2 * value for value in values])]))
            files += f"SLCC {mesh} # STRUCTURED & {' '.join(map(str, indices))}\n case_{mesh}.sf\n"
            files += " SOOT EXTINCTION COEFFICIENT\n ext\n 1/m\n"
        self.case = self.path("case.smv")
        self.case.write_text(text + files + "HIDE_OBST 1\n 1 5.0\n")

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
        self.assertIn("within frame 1", said["remarks"][0])

    def test_a_flipped_marker_is_refused_with_its_byte(self):
        data = bytearray(self.path("case_1.sf").read_bytes())
        data[146] ^= 4
        self.path("case_1.sf").write_bytes(data)
        self.assertIn("case_1.sf: byte 146: the record marker", self.fails(1, "info", self.case))

    def test_extract_gives_voxels_of_the_finest_cells(self):
        self.works("extract", self.case, "-o", self.path("out.npy"))
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

    def seen(self, x, time, *more):
        """What a parallel camera sees along +y at this x, before white."""
        self.works("render", self.case, "-o", self.path("x.exr"), "--ortho", "0.1", "--eye", f"{x},-1,0.5",
                   "--target", f"{x},0,0.5", "--size", "4x4", "--background", "1,1,1", "--time", str(time),
                   "--albedo", "0,0,0", *more)
        info = self.works("info", self.path("x.exr"), "--json").json
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

    def test_what_is_not_there_is_said(self):
        self.assertIn("no source 's3d'; the case has slice3d-extinction-cells",
                      self.fails(1, "info", self.case, "--grid", "s3d"))
        self.case.write_text(self.case.read_text().split("SLCC")[0])
        self.assertIsNone(self.works("info", self.case, "--json").json["source"])
        self.assertIn("nothing in the case says how thick the smoke is",
                      self.fails(1, "extract", self.case, "-o", self.path("out.npy")))


if __name__ == "__main__":
    support.main()
