# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Files of strangers, and what killed runs leave: nothing of them steers a terminal, reads elsewhere or is taken for ours."""
import csv
import json
import os
import stat
import subprocess

import sight_cases
import smoke_files
import support
from support import volute

EVIL = "\x1b]0;owned\x07\x1b[31mdensity\x9b2J\u202egnp"


class Terminal(support.TestCase):
    def quiet(self, result):
        """No control character but line ends, nothing that turns the direction, on either stream."""
        for text in (result.out.decode(), result.err.decode()):
            for c in text:
                self.assertTrue(c == "\n" or (ord(c) >= 0x20 and not 0x7f <= ord(c) < 0xa0 and c != "\u202e"), repr(text))

    def test_names_of_files(self):
        self.make_npy("in.npy").rename(self.path(EVIL + ".npy"))
        self.quiet(self.works("info", self.path(EVIL + ".npy")))
        self.quiet(self.works("info", self.path(EVIL + ".npy"), "--json"))
        self.quiet(volute("info", self.path(EVIL + "missing.npy")))
        self.quiet(volute(EVIL))
        self.quiet(volute("info", "--" + EVIL))

    def test_names_of_fields(self):
        mesh = smoke_files.box((0, 0, 0), (1, 1, 1), (1, 1, 1))
        name = "a&#x9b;31m&#x7f;"  # what XML lets through
        smoke_files.write_vtu(self.path("a.vtu"), mesh, {name: [1.0] * len(mesh[0]), "soot": [2.0] * len(mesh[0])})
        for options in ([], ["--json"]):
            result = self.works("info", self.path("a.vtu"), *options)
            self.quiet(result)
            self.assertIn("31m", result.text)
        self.quiet(volute("render", self.path("a.vtu"), "-o", self.path("x.png"), "--quantity", "extinction", "--field", EVIL))

    def test_names_in_json(self):
        self.path("scene.json").write_text(json.dumps({"format": "volute-scene-1", EVIL: 1}))
        result = volute("render", self.path("scene.json"), "-o", self.path("x.png"))
        self.assertEqual(result.code, 1)
        self.assertIn("owned", result.message)
        self.quiet(result)

    def test_a_name_is_no_message(self):
        name = "a\nvolute: all is well.npy"
        result = volute("info", self.path(name))
        self.assertIn("\n    volute: all is well", result.message)


class Tables(support.TestCase):
    def test_names_of_signs_are_no_formulas(self):
        names = ["=1+1", "+x", "-x", "@x", "=HYPERLINK(\"http://x\",\"y\")", "exit, north"]
        sight_cases.write_vtu(self.path("a.vtu"), (4, 4, 3), (2, 2, 2), lambda x, y, z: 0.1)
        self.path("signs.json").write_text(json.dumps({"signs": [
            {"name": name, "position": [2, 0.1 + 0.1 * i, 2], "normal": [0, 1, 0]} for i, name in enumerate(names)]}))
        self.path("eyes.csv").write_text("x,y,z\n2,3,2\n")
        self.works("visibility", self.path("a.vtu"), "--quantity", "extinction", "--signs", self.path("signs.json"), "--eyes",
                   self.path("eyes.csv"), "-o", self.path("out"))
        with open(self.path("out") / "sight.csv", newline="") as file:
            read = [row["sign"] for row in csv.DictReader(file)]
        self.assertEqual(read, ["'" + name if name[0] in "=+-@" else name for name in names])


class Untrusted(support.TestCase):
    def scene(self, file):
        self.path("in").mkdir(exist_ok=True)
        scene = {"format": "volute-scene-1", "camera": {"eye": [3, 0, 1], "target": [0, 0, 0], "fov": 40},
                 "media": [{"kind": "volume", "file": str(file)}]}
        self.path("in/scene.json").write_text(json.dumps(scene))
        return self.path("in/scene.json")

    def test_files_outside_of_the_folder(self):
        volume = self.make_volute("a.volute")
        (self.path("in")).mkdir()
        os.symlink(volume, self.path("in/link.volute"))
        for file in (volume, "../a.volute", "link.volute"):
            scene = self.scene(file)
            result = self.works("render", scene, "-o", self.path("x.png"), "--size", "4x4")
            self.assertIn("outside of its folder", result.message)
            self.path("x.png").unlink()
            said = self.fails(1, "render", scene, "-o", self.path("x.png"), "--size", "4x4", "--untrusted")
            self.assertIn("--untrusted refuses that", said)

    def test_files_within(self):
        self.path("in").mkdir()
        self.make_volute("in/a.volute")
        result = self.works("render", self.scene("a.volute"), "-o", self.path("x.png"), "--size", "4x4", "--untrusted")
        self.assertNotIn("outside", result.message)


class Targets(support.TestCase):
    def test_modes_and_links_stay(self):
        volume = self.make_volute()
        self.path("there").mkdir()
        real = self.path("there/x.npy")
        real.write_text("old")
        real.chmod(0o640)
        os.symlink("there/x.npy", self.path("x.npy"))
        self.works("extract", volume, "-o", self.path("x.npy"))
        self.assertTrue(self.path("x.npy").is_symlink())
        self.assertEqual(real.read_bytes()[:6], b"\x93NUMPY")
        self.assertEqual(stat.S_IMODE(real.stat().st_mode), 0o640)

    def test_parts_of_killed_runs_are_named(self):
        volume = self.make_volute()
        dead = subprocess.Popen(["true"])
        dead.wait()
        part = self.path(f".x.{dead.pid}.0.part.npy")
        mine = self.path(f".x.{os.getpid()}.0.part.npy")
        part.write_text("half")
        mine.write_text("half")
        result = self.works("extract", volume, "-o", self.path("x.npy"))
        self.assertIn(f"{part}: left by runs that were killed", result.message)
        self.assertIn("rm -r", result.message)
        self.assertNotIn(mine.name, result.message)
        self.assertTrue(part.exists() and mine.exists())
        part.unlink()
        self.assertEqual(self.works("extract", volume, "-o", self.path("x.npy")).message, "")


if __name__ == "__main__":
    support.main()
