# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""OpenGL without a display: what the device is, and pictures that are those of the CPU."""
import json
import os
import pathlib

import fds_test
import smoke_files
import support
from geometry_test import floor, glb, obj
from pictures import Picture, read_exr, write_png
from support import volute, write_npy

CACHE = str(pathlib.Path(__file__).resolve().parent.parent / "data/cache.volute")  # density, flame and others
# The CPU may not draw.
ONLY_GL = os.environ | {"VOLUTE_CPU_RENDERER": "off"}


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
            self.assertNotIn("VOLUTE_TESTS_NEED_GL", os.environ, reason)
            self.skipTest(reason.strip())

    def volume(self):
        values = [(x + 2 * y + z) % 5 * (x > 1) for t in range(2) for z in range(6) for y in range(7) for x in range(9)]
        write_npy(self.path("v.npy"), (2, 6, 7, 9), values)
        return self.path("v.npy")

    def test_the_device_has_a_name_and_limits(self):
        device = self.works("info", "--gl", "--json").json
        self.assertTrue(device["device"])
        self.assertGreaterEqual(device["max_texture_size"], 16384)

    def test_an_old_driver_and_a_missing_one_are_told_apart(self):
        if self.works("info", "--gl", "--json").json["hardware"]:
            self.skipTest("only Mesa can be asked to be older or to be without drivers")
        old = volute("info", "--gl", env=os.environ | {"MESA_GL_VERSION_OVERRIDE": "3.3"})
        self.assertEqual(old.code, 1)
        for part in ("OpenGL 4.5 is needed", "llvmpipe", "has 3.3", "update"):
            self.assertIn(part, old.message)
        none = volute("info", "--gl", env=os.environ | {"LIBGL_DRIVERS_PATH": "/nonexistent"})
        self.assertEqual(none.code, 1)
        self.assertIn("install", none.message)
        for result in (old, none):
            self.assertEqual(len(result.message.strip().splitlines()), 1, result.message)

    def test_info_wants_a_file_or_the_device(self):
        self.fails(2, "info")
        self.works("info", "--gl", self.volume())

    def test_pictures_are_those_of_the_cpu(self):
        for basis in ("box", "trilinear"):
            common = ["render", self.volume(), "--size", "24x20", "--basis", basis, "--extinction", "2", "--time", "0"]
            for renderer in ("gl", "reference"):
                self.works(*common, "--renderer", renderer, "-o", self.path(renderer + ".exr"))
            found = self.works("compare", self.path("reference.exr"), self.path("gl.exr"), "--json").json
            self.assertLess(found["max_error"], 1e-4, basis)

    def test_the_cubic_basis_of_pictures_is_drawn(self):
        for words in (("--preset", "none"), ("--preset", "none", "--extinction", "2"), ("--preset", "smoke"), ("--preset", "fire")):
            common = ["render", self.volume(), "--size", "48x40", "--basis", "cubic", "--samples", "1", "--time", "0", *words]
            for renderer in ("gl", "cpu"):
                self.works(*common, "--renderer", renderer, "-o", self.path(renderer + ".exr"), "--stats", self.path("s.json"), measured=False)
                self.assertEqual(json.loads(self.path("s.json").read_text())["renderer"], renderer)
            most = self.works("info", self.path("cpu.exr"), "--json").json["maximum"]
            found = self.works("compare", self.path("cpu.exr"), self.path("gl.exr"), "--json").json
            self.assertLess(found["max_error"], 1e-4 * most, words)
        refused = self.fails(1, "render", self.volume(), "-o", self.path("x.exr"), "--size", "8x8", "--basis", "cubic", "--measured", "--renderer", "gl")
        self.assertIn("measured over the cubic basis", refused)

    def test_statistics_list_the_passes(self):
        self.works("render", self.volume(), "-o", self.path("%04d.png"), "--size", "8x8", "--renderer", "gl",
                   "--measured", "--exposure", "1", "--stats", self.path("s.json"))
        stats = json.loads(self.path("s.json").read_text())
        self.assertEqual(stats["renderer"], "gl")
        passes = {p["name"]: p for p in stats["gl"]["passes"]}
        self.assertEqual(passes["march"]["times"], 2)
        self.assertGreater(passes["march"]["milliseconds"], 0)
        self.assertIn("upload", passes)

    def scene(self, **parts):
        """A hall: a floor, a pillar, a spot, a sign, and media by name."""
        self.path("hall.obj").write_text(obj(floor(-1, 9), [(2, 2, -1), (3, 2, -1), (3, 2, 2), (2, 2, 2)]))
        write_png(self.path("map.png"), Picture(20, 20, 1, [0.2 + 0.8 * (i * 7 % 11) / 10 for i in range(400)]))
        mesh = smoke_files.box((-3, -1, -1), (3, 3, 2), (4, 3, 3))
        smoke_files.write_vtu(self.path("slab.vtu"), mesh, {"smoke": [0.1 + 0.02 * x for x, y, z in mesh[0]]})
        media = {
            "volume": {"kind": "volume", "file": str(self.volume()), "extinction": 0.05, "emission": 0.02},
            "fog": {"kind": "fog", "map": "map.png", "origin": [-10, -10, -1], "cell": 1, "sigma_max": 0.1, "degree": 2,
                    "profile": {"kind": "slab", "bottom": 0, "top": 2}, "color": [0.3, 0.3, 0.4]},
            "smoke": {"kind": "smoke", "case": "slab.vtu", "quantity": "extinction"}}
        wanted = parts.pop("media", list(media))
        self.path("scene.json").write_text(json.dumps({
            "format": "volute-scene-1", "background": [0.2, 0.3, 0.5], "media": [media[name] for name in wanted],
            "camera": {"eye": [-1, -9, 3], "target": [0, 1, 0.5], "fov": 50, "size": [40, 32]}} | parts))
        return self.path("scene.json")

    HALL = {"geometry": [{"file": "hall.obj"}],
            "lights": [{"kind": "spot", "position": [0, -1, 4], "target": [1, 2, 0], "angle": 80, "intensity": [20, 16, 12]},
                       {"kind": "ambient", "radiance": [0.1, 0.1, 0.1]}],
            "signs": [{"name": "exit", "position": [0, 2.9, 1], "normal": [0, -1, 0], "size": [1.5, 0.8], "emitting": True}]}

    def difference(self, scene, *more, ways=()):
        """Of gl, with the CPU renderer off, from the reference, as a share of the brightest; and the statistics.
        `ways`: what is said to gl alone."""
        self.works("render", scene, "--renderer", "reference", "-o", self.path("reference.exr"), "--cache", "none", *more)
        self.works("render", scene, "--renderer", "gl", "-o", self.path("gl.exr"), "--stats", self.path("s.json"),
                   "--cache", "none", *more, *ways, env=ONLY_GL)
        found = self.works("compare", self.path("reference.exr"), self.path("gl.exr"), "--json").json
        brightest = max(read_exr(self.path("reference.exr")).values)
        return found["max_error"] / brightest, json.loads(self.path("s.json").read_text())

    def test_each_medium_and_all_without_the_cpu(self):
        for media in (["volume"], ["fog"], ["smoke"], ["volume", "fog", "smoke"]):
            error, stats = self.difference(self.scene(media=media))
            self.assertLess(error, 2e-3, media)
            drawn = {medium for p in stats["gl"]["passes"] for medium in p["media"].split(" + ")}
            self.assertTrue(drawn >= set(media), (media, drawn))

    def test_fire_in_fog_in_smoke_with_a_wall_through_all_three(self):
        self.path("wall.glb").write_bytes(glb([(-2, 0.5, -0.7), (2, 0.5, -0.7), (0.3, 0.5, 1.8)]))  # glows
        scene = json.loads(self.scene(**self.HALL).read_text())
        scene["geometry"].append({"file": "wall.glb"})
        scene["media"][0] |= {"extinction": 1.5, "emission": 1, "transform": [2, 0, 0, -1, 0, 2, 0, -0.3, 0, 0, 2, -0.5, 0, 0, 0, 1]}
        outside = ([-1, -9, 3], [8, 5, 1], [0.3, 9, 4], [-7, -4, -0.5])
        inside = ([0.2, -0.2, 0.3], [0, 0.9, 0.2], [-2.5, 0.3, 0.7], [1.2, 2.5, 1.5])
        for eye in outside + inside:
            scene["camera"] = {"eye": eye, "target": [0.1, 0.6, 0.4], "fov": 60, "size": [36, 28]}
            self.path("scene.json").write_text(json.dumps(scene))
            error, stats = self.difference(self.path("scene.json"))
            self.assertLess(error, 2e-3, eye)
            drawn = {medium for p in stats["gl"]["passes"] for medium in p["media"].split(" + ")}
            self.assertTrue(drawn >= {"volume", "fog", "smoke", "geometry"}, drawn)

    def test_what_stands_in_scenes_is_drawn_too(self):
        for mode in ("photometric", "threshold"):
            scene = json.loads(self.scene(**self.HALL).read_text())
            scene["media"][2]["mode"] = mode
            self.path("scene.json").write_text(json.dumps(scene))
            error, stats = self.difference(self.path("scene.json"))
            self.assertLess(error, 2e-3, mode)
            names = {p["name"] for p in stats["gl"]["passes"]}
            self.assertTrue(names >= {"surfaces", "shadows", "light", "signs", "signs deferred", "march"}, names)

    def test_walls_of_smoke_with_the_shadows_of_lamps(self):
        scene = json.loads(self.scene(media=["smoke"], **self.HALL).read_text())
        scene["media"][0]["walls"] = [0.7, 0.6, 0.5]
        scene["lights"].append({"kind": "sun", "direction": [0.3, 0.5, -0.6], "radiance": [1, 1, 2]})
        for eye in ([-2.5, -0.5, 1.5], [-1, -9, 3]):  # inside and outside
            scene["camera"]["eye"] = eye
            self.path("scene.json").write_text(json.dumps(scene))
            error, stats = self.difference(self.path("scene.json"))
            self.assertLess(error, 2e-3, eye)
            drawn = {(p["name"], p["media"]) for p in stats["gl"]["passes"]}
            self.assertTrue(drawn >= {("surfaces", "walls"), ("shadows", "walls"), ("light", "walls"), ("march", "smoke")}, drawn)

    def test_fds_cases_with_fire_among_other_media(self):
        case = fds_test.write_case(self.path)
        fds_test.add_slice(self.path, case, 2, (0, 4) * 3, 500.0, ("HRRPUV", "hrrpuv", "kW/m3"))
        error, stats = self.difference(case, "--size", "40x30", "--time", "3")
        self.assertLess(error, 2e-3)
        lamp = {"kind": "spot", "position": [1, -1, 2], "target": [1, 0.5, 0.3], "angle": 70, "intensity": [20, 16, 12]}
        self.path("scene.json").write_text(json.dumps({
            "format": "volute-scene-1", "background": [0.2, 0.3, 0.5], "lights": [lamp],
            "camera": {"eye": [-0.6, -2, 1.6], "target": [1, 0.5, 0.4], "fov": 50, "size": [40, 32]},
            "media": [{"kind": "smoke", "case": "case.smv", "albedo": [0.8, 0.8, 0.8], "mode": "threshold"},
                      {"kind": "volume", "file": str(self.volume()), "extinction": 0.5, "emission": 0.2}]}))
        error, stats = self.difference(self.path("scene.json"), "--time", "2")
        self.assertLess(error, 2e-3)
        drawn = {medium for p in stats["gl"]["passes"] for medium in p["media"].split(" + ")}
        self.assertTrue(drawn >= {"FDS smoke", "fire", "volume", "geometry"}, drawn)

    def test_ways_to_draw_smoke(self):
        scene = self.scene(media=["smoke"])
        for method, drawn in (("march", "march"), ("projected", "draw tetrahedra")):
            error, stats = self.difference(scene, ways=("--smoke-method", method))
            self.assertLess(error, 2e-3, method)
            self.assertIn(drawn, {p["name"] for p in stats["gl"]["passes"]})
        self.assertIn("--renderer gl", self.fails(2, "render", scene, "-o", self.path("x.png"), "--renderer", "cpu",
                                                  "--smoke-method", "projected"))

    def test_the_tree_is_walked_in_place(self):
        packed = self.path("packed.volute")
        self.works("compress", self.volume(), "-o", packed, "--rms", "0.01")
        turned = [0.8, -0.6, 0, 0.5, 0.6, 0.8, 0, 0, 0, 0, 1, 0.2, 0, 0, 0, 1]
        scaled = [3, 0, 0, -4, 0, 2, 0, -2, 0, 0, 3, -1, 0, 0, 0, 1]
        for more in ({}, {"transform": turned}, {"transform": scaled}):
            scene = self.scene(media=[])
            value = json.loads(scene.read_text())
            value["media"] = [{"kind": "volume", "file": str(packed), "emission": 0.3, "extinction": 0.5, **more}]
            scene.write_text(json.dumps(value))
            error, stats = self.difference(scene, ways=("--volume-method", "tree"))
            self.assertLess(error, 2e-3)
            self.assertIn(("upload", "tree"), {(p["name"], p["media"]) for p in stats["gl"]["passes"]})
            self.assertEqual(stats["nodes_visited"], 0, "no instant was extracted")
        self.works("render", packed, "-o", self.path("x.png"), "--renderer", "cpu", "--volume-method", "tree",
                   "--stats", self.path("stats.json"))
        self.assertGreater(json.loads(self.path("stats.json").read_text())["nodes_visited"], 0, "the CPU draws from it, too")
        said = self.fails(2, "render", self.volume(), "-o", self.path("x.png"), "--renderer", "gl", "--volume-method", "tree")
        self.assertIn("volute compress", said)

    def test_billboards_and_suns(self):
        board = {"volume": str(self.volume()), "position": [0, 1, 1], "size": [3, 3], "emission": 0.05}
        error, stats = self.difference(self.scene(media=["fog"], billboards=[board],
                                                  lights=[{"kind": "sun", "direction": [0.2, 0.4, -1], "radiance": [2, 2, 1]}]))
        self.assertLess(error, 2e-3)
        self.assertIn("billboard", {p["name"] for p in stats["gl"]["passes"]})

    def test_what_is_lit_or_burns(self):
        scene = {"format": "volute-scene-1", "background": [0.1, 0.1, 0.2],
                 "lights": [{"kind": "sun", "direction": [0.6, 0.3, -0.5], "radiance": [2, 1.8, 1.5]},
                            {"kind": "ambient", "radiance": [0.1, 0.12, 0.15]}],
                 "media": [{"kind": "volume", "file": CACHE, "preset": "fire-and-smoke", "asymmetry": 0.4}]}
        for more in ({}, {"signs": self.HALL["signs"]}):
            self.path("lit.json").write_text(json.dumps(scene | more))
            words = ("render", self.path("lit.json"), "--size", "48x40", "--samples", "1", "--cache", "none")
            said = self.works(*words, "--renderer", "cpu", "-o", self.path("cpu.exr")).message
            self.assertIn("flame", said)
            self.works(*words, "--renderer", "gl", "-o", self.path("gl.exr"), env=ONLY_GL)
            found = self.works("compare", self.path("cpu.exr"), self.path("gl.exr"), "--json").json
            brightest = max(read_exr(self.path("cpu.exr")).values)
            self.assertGreater(brightest, 0.2, "more than the background")
            self.assertLess(found["max_error"], 2e-3 * brightest)

    def test_the_cpu_can_be_switched_off(self):
        result = volute("render", self.scene(media=["fog"]), "-o", self.path("x.png"), "--renderer", "cpu", env=ONLY_GL)
        self.assertEqual(result.code, 1)
        self.assertIn("VOLUTE_CPU_RENDERER", result.message)


if __name__ == "__main__":
    support.main()
