# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Scene files: volumes in their places and times, and errors that name the path inside the file."""
import json
import os
import pathlib
import shutil
import subprocess
import unittest

import support
from support import write_npy


SOURCE = pathlib.Path(__file__).resolve().parents[2]


class OwnKind(support.TestCase):
    """docs/own-media.md, with its plug-in."""

    @unittest.skipUnless(shutil.which("cc"), "no compiler of C")
    def setUp(self):
        super().setUp()
        subprocess.run(["cc", "-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-shared", "-fPIC", "-O2", "-I", SOURCE / "include",
                        SOURCE / "examples/plugin/ball.c", "-o", self.path("volute_medium_ball.so"), "-lm"], check=True)
        self.scene = {"format": "volute-scene-2", "background": [1, 1, 1],
                      "camera": {"eye": [0, -10, 0], "target": [0, 0, 0], "fov": 30, "size": [33, 33]},
                      "media": [{"kind": "ball", "radius": 1, "extinction": 0.5, "growth": 0.25}]}
        self.path("ball.json").write_text(json.dumps(self.scene))

    def volute(self, *arguments):
        return support.volute(*arguments, env=os.environ | {"VOLUTE_PLUGIN_FOLDER": str(self.path("."))})

    def test_a_plug_in_is_drawn_and_looked_through(self):
        for renderer in ("cpu", "auto"):
            said = self.volute("render", self.path("ball.json"), "-o", self.path("x.exr"), "--aov", "transmittance", "--time", "2",
                               "--renderer", renderer)
            self.assertEqual(said.code, 0, said.message)
            info = self.volute("info", self.path("x.exr"), "--json").json
            self.assertAlmostEqual(info["minimum"], 2.718281828 ** (-2 * 1.5 * 0.5), places=5)
            self.assertAlmostEqual(info["maximum"], 1)
        self.path("signs.json").write_text(json.dumps({"signs": [{"name": "exit", "position": [0, 1.4, 0], "normal": [0, -1, 0]}]}))
        self.path("eyes.csv").write_text("x,y,z\n0,-3,0\n")
        said = self.volute("visibility", self.path("ball.json"), "--signs", self.path("signs.json"), "--eyes", self.path("eyes.csv"),
                           "-o", self.path("seen"))
        self.assertEqual(said.code, 0, said.message)

    def test_what_is_wrong_is_said(self):
        self.scene["media"][0]["radius"] = -1
        self.path("ball.json").write_text(json.dumps(self.scene))
        said = self.volute("render", self.path("ball.json"), "-o", self.path("x.png"))
        self.assertEqual(said.code, 1)
        self.assertIn("/media/0/radius", said.message)
        self.path("volute_medium_ball.so").write_bytes(self.path("volute_medium_ball.so").read_bytes()[:5000])
        said = self.volute("render", self.path("ball.json"), "-o", self.path("x.png"))
        self.assertEqual(said.code, 1)
        self.assertIn("'ball' is unknown", said.message)
        self.assertIn("volute_medium_ball.so is cut off", said.message)


class SightOfLossyVolumes(support.TestCase):
    def test_what_a_file_is_off_by_is_said(self):
        values = [0.5 + 0.08 * (k * 37 % 101) / 100 for k in range(512)]
        write_npy(self.path("k.npy"), (8, 8, 8), values)
        self.path("signs.json").write_text(json.dumps({"signs": [{"name": "exit", "position": [8, 1, 1], "normal": [-1, 0, 0]}]}))
        self.path("eyes.csv").write_text("x,y,z\n-1,1,1\n")
        for error, said in (("0.09", True), ("0.0001", False)):
            self.works("compress", self.path("k.npy"), "-o", self.path("k.volute"), "--bounds", "0,0,0,7,2,2", "--max-error", error)
            seen = support.volute("visibility", self.path("k.volute"), "--signs", self.path("signs.json"), "--eyes", self.path("eyes.csv"),
                                  "--extinction", "1", "-o", self.path("seen"))
            self.assertEqual(seen.code, 0, seen.message)
            self.assertEqual("compressed with loss and are off by up to" in seen.message, said, seen.message)


class Scene(support.TestCase):
    def setUp(self):
        super().setUp()
        write_npy(self.path("block.npy"), (2, 4, 4, 4), [0.25] * 64 + [0.75] * 64)  # 1 m wide, changes at 0.04 s
        self.scene = {"format": "volute-scene-1", "background": [0, 0, 0],
                      "camera": {"eye": [0.5, -3, 0.5], "target": [0.5, 0.5, 0.5], "ortho": 0.5, "size": [4, 4]},
                      "media": [{"kind": "volume", "file": "block.npy"}]}

    def write(self, name="scene.json"):
        self.path(name).write_text(json.dumps(self.scene))
        return self.path(name)

    def radiance(self, *more):
        """The one value that all pixels have."""
        self.works("render", self.write(), "-o", self.path("x.exr"), *more)
        info = self.works("info", self.path("x.exr"), "--json").json
        self.assertAlmostEqual(info["minimum"], info["maximum"], places=6)
        return info["maximum"]

    def test_a_volume_is_shown_as_it_is_alone(self):
        self.assertAlmostEqual(self.radiance(), 0.25, places=6)
        self.assertAlmostEqual(self.radiance("--time", "0.05"), 0.75, places=6)

    def test_a_field_is_named_by_either_name(self):
        self.works("compress", self.path("block.npy"), "-o", self.path("block.volute"), "--max-error", "1e-6")
        for name in ("field", "grid"):
            self.scene["media"][0] = {"kind": "volume", "file": "block.volute", name: "density"}
            self.assertAlmostEqual(self.radiance(), 0.25, places=4)
            self.scene["media"][0][name] = "heat"
            self.assertIn("there is no grid 'heat'", self.fails(1, "render", self.write(), "-o", self.path("y.png")))
        self.scene["media"][0]["field"] = "density"
        self.wrong("/media/0/field: grid says the same")

    def test_times_between_frames_are_as_the_command_line_says(self):
        self.assertAlmostEqual(self.radiance("--time", "0.02", "--interpolate", "linear"), 0.5, places=6)
        self.scene["media"][0]["interpolate"] = "linear"
        self.assertAlmostEqual(self.radiance("--time", "0.02", "--interpolate", "none"), 0.25, places=6)
        write_npy(self.path("map.npy"), (1, 4, 4), [0.5] * 16)
        self.scene["media"] = [{"kind": "fog", "map": "map.npy", "sigma_max": 0.1}]
        for option in ("--interpolate", "--basis"):
            value = {"--interpolate": "linear", "--basis": "box"}[option]
            self.assertIn(f"{option} has no effect", self.fails(2, "render", self.write(), "-o", self.path("x.png"), option, value))

    def test_parts_of_a_view_change_the_scene_s_camera(self):
        self.assertIn("--fps has no effect on one picture",
                      self.fails(2, "render", self.write(), "-o", self.path("x.png"), "--fps", "10"))
        def drawn(*words):
            self.works("render", self.write(), "-o", self.path("x.exr"), *words)
            return self.path("x.exr").read_bytes()
        camera = self.scene["camera"]
        eye, target = (",".join(map(str, camera[name])) for name in ("eye", "target"))
        whole = ("--eye", eye, "--target", target, "--size", "8x8")
        size = ("--ortho", "0.5") if "ortho" in camera else ("--fov", "20")
        own = ("--ortho", str(camera["ortho"])) if "ortho" in camera else ("--fov", str(camera["fov"]))
        self.assertEqual(drawn("--up", "1,0,0.5", "--size", "8x8"), drawn(*whole, *own, "--up", "1,0,0.5"))
        self.assertEqual(drawn(*size, "--size", "8x8"), drawn(*whole, *size))
        self.assertEqual(drawn("--eye", "0.4,-3,0.6", "--size", "8x8"), drawn("--eye", "0.4,-3,0.6", *whole[2:], *own))

    def test_members_of_a_volume_that_change_nothing_are_told(self):
        write_npy(self.path("one.npy"), (4, 4, 4), [0.25] * 64)
        self.scene["media"][0] |= {"file": "one.npy", "emission": 1, "fps": 50, "time": {"offset": 3}, "velocity_scale": 2,
                                   "color_field": "none"}
        said = self.works("render", self.write(), "-o", self.path("x.exr")).message
        for member, why in (("fps", "the file has one frame"), ("time", "the file has one frame"),
                            ("velocity_scale", "the file has one frame"), ("color_field", "there is no albedo")):
            self.assertIn(f"/media/0/{member} has no effect: {why}", said)
        self.assertNotIn("/media/0/emission", said)
        self.scene["media"][0] = {"kind": "volume", "file": "block.npy", "emission": 1, "fps": 50,
                                  "transfer": {}}
        said = self.works("render", self.write(), "-o", self.path("x.exr")).message
        self.assertIn("/media/0/emission has no effect: transfer says", said)
        self.assertNotIn("fps", said)

    def test_the_basis_is_the_scene_s_unless_the_command_line_says_another(self):
        write_npy(self.path("block.npy"), (4, 4, 4), [x for _ in range(16) for x in range(4)])
        self.scene["camera"] |= {"ortho": 1e-7, "eye": [0.45, -3, 0.5], "target": [0.45, 0.5, 0.5]}
        file, box = self.radiance(), self.radiance("--basis", "box")
        self.scene["media"][0]["basis"] = "trilinear"
        trilinear = self.radiance()
        self.assertEqual(file, box)
        self.assertNotAlmostEqual(trilinear, box, places=2)
        self.assertEqual(self.radiance("--basis", "box"), box)

    def test_volumes_add_up(self):
        self.scene["media"].append({"kind": "volume", "file": "block.npy", "emission": 4})
        self.assertAlmostEqual(self.radiance(), 0.25 + 1, places=6)

    def test_without_a_camera_all_of_it_is_framed(self):
        del self.scene["camera"]
        self.works("render", self.write(), "-o", self.path("scene.exr"), "--size", "24x18")
        self.works("render", self.path("block.npy"), "-o", self.path("alone.exr"), "--size", "24x18")
        self.assertEqual(self.path("scene.exr").read_bytes(), self.path("alone.exr").read_bytes())
        self.scene["media"].append({"kind": "volume", "file": "block.npy",
                                    "transform": [1, 0, 0, 9, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]})
        self.works("render", self.write(), "-o", self.path("two.exr"), "--size", "24x18")
        self.assertGreater(self.works("info", self.path("two.exr"), "--json").json["maximum"], 0.1)
        self.scene = {"format": "volute-scene-1"}
        self.assertIn("nothing", self.fails(1, "render", self.write(), "-o", self.path("x.png")))

    def test_info_lists_what_is_in_it(self):
        self.scene["media"].append({"kind": "volume", "file": "block.npy", "time": {"offset": -1}})
        self.scene["lights"] = [{"kind": "ambient", "radiance": [1, 1, 1]}, {"kind": "sun", "direction": [0, 0, -1]}]
        info = self.works("info", self.write(), "--json").json
        self.assertEqual(info["kind"], "scene")
        self.assertEqual([m["kind"] for m in info["media"]], ["volume", "volume"])
        self.assertEqual(info["media"][1]["times"], [1, 1.04])
        self.assertEqual((info["lights"], info["signs"], info["camera"]), (1, 0, True))
        self.assertIn("block.npy (volume): 4 x 4 x 4 voxels, 2 frames, 1 to 1.04 s", self.works("info", self.write()).text)
        self.assertIn("--values is for volumes of voxels, smoke on meshes and FDS cases; ",
                      self.fails(2, "info", self.write(), "--values"))

    def test_transforms_scale_and_move(self):
        self.scene["media"][0]["transform"] = [1, 0, 0, 0, 0, 3, 0, 5, 0, 0, 1, 0, 0, 0, 0, 1]
        self.assertAlmostEqual(self.radiance(), 0.75, places=6)
        self.scene["media"][0]["transform"][3] = 7
        self.assertEqual(self.radiance(), 0)

    def test_a_compressed_volume_is_where_its_frames_are(self):
        write_npy(self.path("steps.npy"), (1, 4, 5, 6), [x + 2 * y * (z > 1) for z in range(4) for y in range(5) for x in range(6)])
        self.works("compress", self.path("steps.npy"), "-o", self.path("steps.volute"), "--rms", "1e-6")
        self.scene["camera"] |= {"target": [0.5, 0.5, 0.5], "ortho": 6, "size": [24, 20]}
        for name, transform in {
                "moved": [1, 0, 0, 2, 0, 1, 0, 0, 0, 0, 1, -1, 0, 0, 0, 1],
                "scaled": [3, 0, 0, -1, 0, 2, 0, 0, 0, 0, 4, -1, 0, 0, 0, 1],
                "turned, mirrored and scaled": [0, -3, 0, 1, 2, 0, 0, 0, 0, 0, -4, 1, 0, 0, 0, 1]}.items():
            for renderer in ("reference", "cpu"):
                pictures = []
                for file in ("steps.npy", "steps.volute"):
                    self.scene["media"][0] |= {"file": file, "transform": transform}
                    pictures.append(self.path(file + ".exr"))
                    self.works("render", self.write(), "-o", pictures[-1], "--renderer", renderer)
                found = self.works("compare", *pictures, "--json").json
                brightest = self.works("info", pictures[0], "--json").json["maximum"]
                self.assertGreater(brightest, 1)
                self.assertLess(found["max_error"], 1e-3 * brightest, (name, renderer))

    def test_clocks(self):
        self.scene["media"][0]["time"] = {"offset": 0.04}
        self.assertAlmostEqual(self.radiance(), 0.75, places=6)
        self.scene["media"][0]["time"] = {"rate": 0.5}
        self.assertAlmostEqual(self.radiance("--time", "0.05"), 0.25, places=6)
        self.scene["media"][0]["time"] = {"loop": True}
        self.assertAlmostEqual(self.radiance("--time", "0.09"), 0.25, places=6)
        self.assertAlmostEqual(self.radiance("--time", "0.13"), 0.75, places=6)

    def test_background_is_seen_through(self):
        self.scene["background"] = [1, 1, 1]
        self.scene["media"][0] |= {"emission": 0, "extinction": 4}
        self.assertAlmostEqual(self.radiance(), 0.36787944, places=6)

    def test_an_empty_scene_is_its_background(self):
        self.scene |= {"media": [], "background": [0.5, 0.5, 0.5]}
        self.assertAlmostEqual(self.radiance(), 0.5, places=6)

    def wrong(self, where, code=1):
        message = self.fails(code, "render", self.write(), "-o", self.path("x.png"))
        self.assertIn("scene.json: " + where, message)

    def test_errors_name_the_path(self):
        self.write()
        good = json.dumps(self.scene)
        for where, change in (
                ("/format", {"format": "volute-scene-9"}),
                ("/camera/eye", {"camera": {"eye": [1, 2], "target": [0, 0, 0], "fov": 9}}),
                ("/camera", {"camera": {"eye": [1, 2, 3], "target": [0, 0, 0]}}),
                ("/background[1]", {"background": [0, "x", 0]}),
                ("/media", {"media": {}}),
                ("/media/0/kind", {"media": [{"kind": "water"}]}),
                ("/media/0/file", {"media": [{"kind": "volume"}]}),
                ("/media/0/emission", {"media": [{"kind": "volume", "file": "block.npy", "emission": "x"}]}),
                ("/media/0/transform", {"media": [{"kind": "volume", "file": "block.npy", "transform": [1, 2]}]}),
                ("/media/0/time/rate", {"media": [{"kind": "volume", "file": "block.npy", "time": {"rate": 0}}]}),
                ("/media/0", {"media": [{"kind": "fog"}]}),
                ("/lights", {"lights": [{"kind": "sun"}]})):
            self.scene = json.loads(good) | change
            self.wrong(where)


if __name__ == "__main__":
    support.main()
