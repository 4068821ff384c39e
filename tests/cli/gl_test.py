# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""OpenGL without a display: what the device is, and pictures that are those of the processor."""
import json

import support
from support import volute, write_npy


def missing():
    """Why there is no OpenGL 4.5 here, or None."""
    result = volute("info", "--gl")
    return None if result.code == 0 else result.message


class Gl(support.TestCase):
    def setUp(self):
        super().setUp()
        reason = missing()
        if reason:
            self.assertEqual(len(reason.strip().splitlines()), 1)
            self.skipTest(reason.strip())

    def volume(self):
        values = [(x + 2 * y + z) % 5 * (x > 1) for t in range(2) for z in range(6) for y in range(7) for x in range(9)]
        write_npy(self.path("v.npy"), (2, 6, 7, 9), values)
        return self.path("v.npy")

    def test_the_device_has_a_name_and_limits(self):
        device = self.works("info", "--gl", "--json").json
        self.assertTrue(device["device"])
        self.assertGreaterEqual(device["max_texture_size"], 16384)

    def test_info_wants_a_file_or_the_device(self):
        self.fails(2, "info")
        self.works("info", "--gl", self.volume())

    def test_pictures_are_those_of_the_processor(self):
        for basis in ("box", "trilinear"):
            common = ["render", self.volume(), "--size", "24x20", "--basis", basis, "--extinction", "2", "--time", "0"]
            for renderer in ("gl", "reference"):
                self.works(*common, "--renderer", renderer, "-o", self.path(renderer + ".exr"))
            found = self.works("compare", self.path("reference.exr"), self.path("gl.exr"), "--json").json
            self.assertLess(found["max_error"], 1e-4, basis)

    def test_statistics_list_the_passes(self):
        self.works("render", self.volume(), "-o", self.path("%04d.png"), "--size", "8x8", "--renderer", "gl",
                   "--stats", self.path("s.json"))
        stats = json.loads(self.path("s.json").read_text())
        self.assertEqual(stats["renderer"], "gl")
        passes = {p["name"]: p for p in stats["gl"]["passes"]}
        self.assertEqual(passes["march"]["times"], 2)
        self.assertGreater(passes["march"]["milliseconds"], 0)
        self.assertIn("upload", passes)


if __name__ == "__main__":
    support.main()
