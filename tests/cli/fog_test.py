# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Fog in scenes and over frames of other renderers, against closed forms; what is refused."""
import json
import math
import struct
import zlib

import support
from pictures import Part, read_exr, write_parts, write_planes, write_rows
from support import write_npy

INFINITY = float("inf")


class FogCase(support.TestCase):
    def value(self, name):
        """The one value that all pixels and channels have."""
        info = self.works("info", self.path(name), "--json").json
        self.assertAlmostEqual(info["minimum"], info["maximum"], delta=1e-6)
        return info["maximum"]

    def difference(self, a, b):
        return self.works("compare", self.path(a), self.path(b), "--json").json["max_error"]

    def white(self, name="map.png", size=16):
        write_rows(self.path(name), [[255] * size] * size)

    def waves(self, name="waves.png", size=24):
        write_rows(self.path(name), [[int(127 + 120 * math.sin(0.7 * x + 0.05 * y * y)) for x in range(size)]
                                    for y in range(size)])


class Scenes(FogCase):
    def setUp(self):
        super().setUp()
        self.white()
        self.fog = {"kind": "fog", "map": "map.png", "cell": 1, "sigma_max": 0.1, "color": [1, 1, 1],
                    "profile": {"kind": "slab", "bottom": 0, "top": 10}}
        self.scene = {"format": "volute-scene-1", "media": [self.fog],
                      "camera": {"eye": [8, 8, 30], "target": [8, 8, 0], "up": [0, 1, 0], "ortho": 1, "size": [8, 6]}}

    def write(self):
        self.path("scene.json").write_text(json.dumps(self.scene))
        return self.path("scene.json")

    def render(self, name="x.exr", *more):
        self.works("render", self.write(), "-o", self.path(name), *more)
        return name

    def test_straight_down_through_a_slab_of_every_degree(self):
        for degree in range(4):
            self.fog["degree"] = degree
            self.assertAlmostEqual(self.value(self.render()), 1 - math.exp(-1), delta=2e-6)

    def test_profiles(self):
        for profile, depth in (({"kind": "slab", "bottom": -2, "top": 3}, 5),
                               ({"kind": "linear", "knots": [[0, 1], [10, 0.5], [30, 0]]}, 7.5 + 5),
                               ({"kind": "layers", "layers": [[0, 4, 0.5], [2, 6, 0.25]]}, 3)):
            self.fog["profile"] = profile
            self.assertAlmostEqual(self.value(self.render()), 1 - math.exp(-0.1 * depth), delta=2e-6)
        self.fog["profile"] = {"kind": "exponential", "bottom": 0, "height": 5}
        self.scene["camera"] |= {"eye": [8, 8, 0], "target": [8, 8, 9], "fov": 0.01}
        del self.scene["camera"]["ortho"]
        self.assertAlmostEqual(self.value(self.render()), 1 - math.exp(-0.5), delta=2e-6)

    def test_the_eye_inside_and_below(self):
        del self.scene["camera"]["ortho"]
        for eye, target, depth in ((4, 30, 6), (4, -9, 4), (-5, 30, 10), (30, -5, 10)):
            self.scene["camera"] |= {"eye": [8, 8, eye], "target": [8, 8, target], "fov": 0.01}
            self.assertAlmostEqual(self.value(self.render()), 1 - math.exp(-0.1 * depth), delta=2e-6)

    def overlapping(self):
        self.waves()
        write_npy(self.path("block.npy"), (8, 8, 8), [0.1 * (i % 7) for i in range(512)])
        self.fog |= {"map": "waves.png", "levels": 2, "mu": 0.6, "degree": 2,
                     "profile": {"kind": "exponential", "bottom": 1, "height": 3}}
        self.scene["media"] += [
            {"kind": "volume", "file": "block.npy", "emission": 0.5, "extinction": 0.7,
             "transform": [8, 0, 0, 8, 0, 8, 0, 8, 0, 0, 8, 0, 0, 0, 0, 1]},
            self.fog | {"degree": 1, "origin": [3, -2, 1], "mu": 1, "color": [0.2, 0.5, 0.9]}]
        self.scene["camera"] = {"eye": [-4, -6, 5], "target": [12, 12, 2], "fov": 60, "size": [48, 36]}

    def test_half_of_the_light_is_lost_where_fog_has_no_end(self):
        del self.fog["profile"]
        self.scene["camera"] = {"eye": [8, 1, 20], "target": [8, 12, 20], "fov": 1, "size": [4, 4]}
        for more in ({}, {"profile": {"kind": "exponential", "bottom": 100, "height": 5}}, {"wind": [0, 0, 1], "profile": {
                "kind": "slab", "bottom": -100, "top": 100}}):
            self.path("z.json").write_text(json.dumps(self.scene | {"media": [self.fog | {"sigma_max": 1} | more]}))
            self.works("render", self.path("z.json"), "-o", self.path("z.exr"), "--aov", "z", "--time", "50", measured=False)
            for value in read_exr(self.path("z.exr")).values:
                self.assertAlmostEqual(value, math.log(2), delta=2e-3)

    def test_what_light_and_time_leave_without_effect_is_told(self):
        self.scene["lights"] = [{"kind": "ambient", "radiance": [5, 5, 5]}]
        self.scene["scattering"] = "multiple"
        self.fog |= {"albedo": [0.5, 0.5, 0.5], "asymmetry": 0.3}
        said = self.works("render", self.write(), "-o", self.path("x.png")).message
        for place in ("/lights", "/scattering", "/media/0/albedo", "/media/0/asymmetry"):
            self.assertIn(f"{place} has no effect", said)
        self.scene["lights"] = [{"kind": "sun", "direction": [0, 0, -1]}]
        self.assertNotIn("no effect", self.works("render", self.write(), "-o", self.path("x.png")).message)
        self.scene["lights"] = [{"kind": "spot", "position": [8, 8, 20], "target": [8, 8, 0], "angle": 0}]
        self.assertIn("/lights/0/angle", self.fails(1, "render", self.write(), "-o", self.path("x.exr")))
        self.scene["lights"] = []
        self.fog |= {"map": ["map.png", "map.png"], "times": [1, 2], "wind": [1, 0, 0]}
        self.scene["format"] = "volute-scene-2"
        for time, text in (("0", "before the first map, at 1 s"), ("3", "after the last map, at 2 s")):
            self.assertIn(text, self.works("render", self.write(), "-o", self.path("x.png"), "--time", time).message)
        said = self.works("render", self.write(), "-o", self.path("x.png"), "--time", "1").message
        self.assertNotIn("which stays", said)
        self.assertIn("comes in on its other side", said)

    def test_speed_is_that_of_the_wind(self):
        self.fog["wind"] = [1, 0, 0]
        said = self.works("render", self.write(), "-o", self.path("w.mp4"), "--frames", "0:11", "--speed", "5").message
        self.assertIn("11 pictures from 0 to 2 s, 25 a second", said)
        said = self.works("render", self.write(), "-o", self.path("x.exr"), "--time", "3", "--shutter", "1", "--fps", "1").message
        self.assertNotIn("nothing moves", said)

    def test_a_sign_is_not_where_its_picture_is_transparent(self):
        row = [value for i in range(8) for value in (255, 0, 0, 255 if 2 <= i < 6 else 0)]
        write_rows(self.path("sign.png"), [row] * 4, channels=4)
        self.path("sign.json").write_text(json.dumps({
            "format": "volute-scene-2", "camera": {"eye": [0, -3, 0], "target": [0, 0, 0], "ortho": 0.5, "size": [8, 4]},
            "signs": [{"position": [0, 0, 0], "normal": [0, -1, 0], "picture": "sign.png", "size": [1, 0.5]}]}))
        self.works("render", self.path("sign.json"), "-o", self.path("x.exr"), "--measured")
        row = read_exr(self.path("x.exr")).values[:24:3]
        self.assertEqual([value > 0.5 for value in row], [2 <= i < 6 for i in range(8)])

    def test_both_renderers_agree_where_media_overlap(self):
        self.overlapping()
        self.render("cpu.exr", "--renderer", "cpu")
        self.render("reference.exr", "--renderer", "reference")
        self.assertLess(self.difference("cpu.exr", "reference.exr"), 1e-5)
        self.scene["media"] = self.scene["media"][:1]
        self.render("cpu.exr", "--renderer", "cpu")
        self.render("reference.exr", "--renderer", "reference")
        self.assertLess(self.difference("cpu.exr", "reference.exr"), 1e-5)

    def test_overlapping_media_do_not_depend_on_their_order(self):
        self.overlapping()
        self.render("a.exr")
        self.scene["media"].reverse()
        self.render("b.exr")
        self.assertLess(self.difference("a.exr", "b.exr"), 1e-5)

    def test_a_sun_lights_the_fog(self):
        # Seen from above, thin fog under a sun at the zenith: isotropic, one scattering.
        self.fog |= {"sigma_max": 1e-4, "color": [0, 0, 0]}
        self.scene["lights"] = [{"kind": "sun", "direction": [0, 0, -1], "radiance": [2, 2, 2]}]
        self.assertAlmostEqual(self.value(self.render()), 2 * 1e-3 / (4 * math.pi), delta=1e-6)
        self.waves()
        self.fog |= {"map": "waves.png", "sigma_max": 0.1, "asymmetry": 0.5}
        self.scene["lights"][0]["direction"] = [1, 0.5, -1]
        self.render("cpu.exr", "--renderer", "cpu")
        self.render("reference.exr", "--renderer", "reference")
        self.assertLess(self.difference("cpu.exr", "reference.exr"), 2e-3)

    def test_wind_moves_the_map(self):
        self.waves()
        self.fog |= {"map": "waves.png", "wind": [1.5, -0.5]}
        self.scene["camera"] = {"eye": [-4, -6, 15], "target": [12, 12, 2], "fov": 40, "size": [16, 12]}
        self.render("blown.exr", "--time", "2")
        self.fog |= {"origin": [3, -1, 0], "wind": [0, 0]}
        self.render("moved.exr")
        self.assertLess(self.difference("blown.exr", "moved.exr"), 2e-6)

    def centre(self, **more):
        """Where the fog of one white pixel is [m], seen from above: its centre of mass in x and y."""
        write_rows(self.path("map.png"), [[255 if x == 4 and y == 4 else 0 for x in range(9)] for y in range(9)])
        self.scene |= {"camera": {"eye": [45, 45, 30], "target": [45, 45, 0], "up": [0, 1, 0], "ortho": 160, "size": [160, 160]}}
        self.scene["media"] = [self.fog | {"cell": 10, "sigma_max": 1e-3} | more]
        picture = read_exr(self.path(self.render("x.exr", "--aov", "optical-depth")))
        total = sum(picture.values)
        return [sum((i % 160 - 34.5) * v for i, v in enumerate(picture.values)) / total,
                sum((124.5 - i // 160) * v for i, v in enumerate(picture.values)) / total]

    def assertNear(self, point, expected):
        for a, b in zip(point, expected):
            self.assertAlmostEqual(a, b, delta=0.05)

    def test_a_pixel_is_where_it_is_painted_for_every_degree(self):
        self.scene["format"] = "volute-scene-2"
        for degree in range(4):
            self.assertNear(self.centre(degree=degree), (45, 45))
            self.assertNear(self.centre(degree=degree, registration="coefficient"), (45 + 5 * degree,) * 2)
            self.assertNear(self.centre(degree=degree, origin=[7, -3, 0], wind=[1, 0], border="zero"), (52, 42))

    def test_older_scenes_keep_their_pictures(self):
        for degree in range(4):
            self.assertNear(self.centre(degree=degree), (45 + 5 * degree,) * 2)
        self.assertNear(self.centre(degree=1, registration="pixel"), (45, 45))
        self.white(size=4)
        self.scene["media"] = [self.fog | {"wind": [1, 0], "sigma_max": 1}]
        self.render("x.exr", "--time", "1000")
        self.assertEqual(self.works("info", self.path("x.exr"), "--json").json["maximum"], 0)  # blown away

    def test_fog_of_older_scenes_is_told_where_it_is_not_on_its_pixels(self):
        white = {"map": "map.png", "cell": 4}
        for more, shifts in (({"degree": 2, "cell": 10}, "the fog lies 10 m"), ({"degree": 0, "top": white}, "its top lies 2 m"),
                             ({"degree": 3, "top": white}, "the fog lies 1.5 m, its top lies 2 m")):
            self.scene["format"], self.scene["media"] = "volute-scene-1", [self.fog | more]
            words = ("render", self.write(), "--aov", "optical-depth", "-o", self.path("x.exr"))
            self.assertIn(f'/media/0: {shifts} off the pixels in x and y, as a volute-scene-1 means it; "registration": "pixel", or volute-scene-2, '
                          "puts it on them", self.works(*words).message)
            self.works(*words, "--strict")
            for other in ({"format": "volute-scene-2"}, {"media": [self.fog | more | {"registration": "pixel"}]}):
                self.path("other.json").write_text(json.dumps(self.scene | other))
                self.assertNotIn("pixels", self.works("render", self.path("other.json"), "--aov", "optical-depth", "-o", self.path("x.exr")).message)
        self.scene["format"], self.scene["media"] = "volute-scene-1", [self.fog | {"degree": 0}]
        self.assertNotIn("pixels", self.works("render", self.write(), "--aov", "optical-depth", "-o", self.path("x.exr")).message)

    def test_what_changes_nothing_is_told(self):
        self.fog |= {"time": {"rate": 2}}
        self.assertIn("/media/0: time has no effect: there is one map",
                      self.works("render", self.write(), "-o", self.path("x.exr")).message)

    def test_a_film_of_one_picture_is_told(self):
        self.waves()
        self.fog |= {"map": "waves.png"}
        self.assertIn("a film of one picture", self.works("render", self.write(), "-o", self.path("x.mp4"), measured=False).message)
        self.fog |= {"wind": [1, 0]}
        words = ("render", self.write(), "-o", self.path("x.mp4"))
        self.assertIn("a film of one picture: --frames 0:250 makes ten seconds, in which the wind moves the fog",
                      self.works(*words, measured=False).message)
        self.assertNotIn("one picture", self.works(*words, "--frames", "0:3", measured=False).message)

    def test_a_top_is_where_it_is_painted(self):
        self.scene["format"] = "volute-scene-2"
        write_rows(self.path("dot.png"), [[255 if x == 4 and y == 4 else 0 for x in range(9)] for y in range(9)])
        self.white("white.png", 30)
        top = {"map": "dot.png", "cell": 10, "height": 5, "origin": [0, 0, 0]}
        for degree in (0, 1, 2):
            self.assertNear(self.centre(map="white.png", degree=degree, top=top, origin=[-90, -90, 0]), (45, 45))
        self.assertIn("there is no fog beyond", self.works("render", self.write(), "-o", self.path("x.png")).message)
        self.scene["media"][0]["top"] |= {"map": "white.png", "origin": [-90, -90, 0]}
        self.assertNotIn("beyond", self.works("render", self.write(), "-o", self.path("x.png")).message)
        self.scene["media"][0]["profile"] |= {"height": 3}
        self.assertIn("/media/0: profile/height has no effect", self.works("render", self.write(), "-o", self.path("x.png")).message)

    def test_wind_keeps_the_map_s_rectangle_filled(self):
        self.scene["format"] = "volute-scene-2"
        self.scene["camera"] = {"eye": [8, 8, 30], "target": [8, 8, 0], "up": [0, 1, 0], "ortho": 16, "size": [32, 32]}
        # Stripes that repeat after 8 cells, twice in the map: an endless map of them is moved.
        write_rows(self.path("map.png"), [[(37 * (x % 8)) % 256 for x in range(16)]] * 16)
        for degree in range(4):
            self.fog |= {"degree": degree, "wind": [1, 0]}
            begun = self.render("begun.exr")
            self.assertLess(self.difference(begun, self.render("later.exr", "--time", "8")), 2e-6)
            self.assertLess(self.difference(begun, self.render("later.exr", "--time", "800")), 2e-6)
            half = self.render("half.exr", "--time", "2.5")
            self.assertLess(self.difference(half, self.render("later.exr", "--time", "10.5")), 2e-6)
            self.assertGreater(self.difference(begun, half), 0.01)
        self.scene["camera"]["ortho"] = 11  # within the pixels at its border
        self.fog["border"] = "clamp"
        write_rows(self.path("map.png"), [[51] + [255] * 15] * 16)
        self.assertAlmostEqual(self.value(self.render("x.exr", "--time", "99")), 1 - math.exp(-0.2), delta=2e-6)
        self.fog["border"] = "zero"
        self.assertEqual(self.value(self.render("x.exr", "--time", "99")), 0)
        self.fog |= {"border": "repeat", "top": {"map": "map.png"}}
        self.assertIn("/media/0/border", self.fails(1, "render", self.write(), "-o", self.path("x.png")))

    def test_wind_leaves_the_map_s_rectangle_where_it_is(self):
        self.scene["format"] = "volute-scene-2"
        self.scene["camera"] = {"eye": [16, 16, 100], "target": [16, 16, 0], "up": [0, 1, 0], "ortho": 48, "size": [96, 96]}
        self.white(size=8)
        self.fog |= {"cell": 4, "profile": {"kind": "slab", "bottom": 0, "top": 1}}
        for degree in range(4):
            self.fog |= {"degree": degree, "wind": [0, 0]}
            calm = read_exr(self.path(self.render("calm.exr", "--aov", "optical-depth"))).values
            self.fog["wind"] = [3, -2]
            before = calm
            for time in (0, 0.3, 0.66, 1, 1.3, 1.34, 1.99, 2.01):
                blown = read_exr(self.path(self.render("x.exr", "--aov", "optical-depth", "--time", str(time)))).values
                self.assertAlmostEqual(sum(blown), sum(calm), delta=0.01 * sum(calm))
                self.assertEqual([i for i, value in enumerate(calm) if value > 0.99 * max(calm) and blown[i] == 0], [])
                if time in (0, 1.34, 2.01):  # 0, .12 and .06 m after 0, 1.3 and 1.99 s
                    self.assertLess(max(abs(a - b) for a, b in zip(blown, before)), 0.1 if degree else 1, (degree, time))
                before = blown

    def test_sequences_of_maps_mix(self):
        write_rows(self.path("fog_0000.png"), [[0] * 16] * 16)
        write_rows(self.path("fog_0001.png"), [[255] * 16] * 16)
        write_npy(self.path("fog.npy"), (2, 1, 16, 16), [0] * 256 + [1] * 256)
        for name in ("fog_%04d.png", ["fog_0000.png", "fog_0001.png"], "fog.npy"):
            self.fog["map"] = name
            self.assertEqual(self.value(self.render()), 0)
            self.assertAlmostEqual(self.value(self.render("x.exr", "--time", "0.02")), 1 - math.exp(-0.5), delta=2e-6)
        self.works("compress", self.path("fog.npy"), "-o", self.path("fog.volute"), "--max-error", "1e-6")
        self.fog["map"] = "fog.volute"
        self.assertAlmostEqual(self.value(self.render("x.exr", "--time", "9")), 1 - math.exp(-1), delta=1e-5)
        self.fog |= {"map": "fog_%04d.png", "times": [10, 20]}
        self.assertAlmostEqual(self.value(self.render("x.exr", "--time", "15")), 1 - math.exp(-0.5), delta=2e-6)
        self.fog["time"] = {"offset": 5, "rate": 2}
        self.assertAlmostEqual(self.value(self.render("x.exr", "--time", "5")), 1 - math.exp(-0.5), delta=2e-6)

    def test_a_top_map_cuts_the_fog(self):
        self.white("top.png", 40)
        self.fog["top"] = {"map": "top.png", "origin": [-8, -8, 0], "cell": 1, "height": 3}
        self.assertAlmostEqual(self.value(self.render()), 1 - math.exp(-0.3), delta=2e-6)

    def test_the_row_at_the_bottom_has_the_smallest_y(self):
        write_rows(self.path("map.png"), [[0] * 16] * 8 + [[255] * 16] * 8)
        self.fog["degree"] = 0
        self.scene["camera"] |= {"eye": [8, 4, 30], "target": [8, 4, 0]}
        self.assertAlmostEqual(self.value(self.render()), 1 - math.exp(-1), delta=2e-6)
        self.scene["camera"] |= {"eye": [8, 12, 30], "target": [8, 12, 0]}
        self.assertEqual(self.value(self.render()), 0)

    def test_small_and_deep_maps(self):
        self.fog["degree"] = 0
        for rows, bits, eye, share in (([[255]], 8, [0.5, 0.5], 1), ([[51] * 9], 8, [4, 0.5], 0.2),
                                       ([[51]] * 9, 8, [0.5, 4], 0.2), ([[13107] * 4] * 4, 16, [2, 2], 0.2)):
            write_rows(self.path("map.png"), rows, bits)
            self.scene["camera"] |= {"eye": [*eye, 30], "target": [*eye, 0], "ortho": 0.5}
            self.assertAlmostEqual(self.value(self.render()), 1 - math.exp(-share), delta=2e-6)

    def test_colour_only_on_request(self):
        write_rows(self.path("map.png"), [[255, 0, 0] * 16] * 16, channels=3)
        message = self.fails(1, "render", self.write(), "-o", self.path("x.png"))
        self.assertIn("map.png: ", message)
        self.assertIn("3 channels", message)
        self.fog["convert"] = "luma"
        self.assertAlmostEqual(self.value(self.render()), 1 - math.exp(-0.2126), delta=2e-6)

    def test_optical_depth_of_all_media(self):
        self.render("x.exr", "--aov", "optical-depth")
        self.assertAlmostEqual(self.value("x.exr"), 1, delta=1e-6)

    def test_errors_name_the_path(self):
        for where, change in (
                ("/media/0/map", {"map": 3}), ("/media/0/map", {"map": []}),
                ("/media/0/cell", {"cell": 0}), ("/media/0/sigma_max", {"sigma_max": -0.1}),
                ("/media/0/degree", {"degree": 4}), ("/media/0/degree", {"degree": 1.5}),
                ("/media/0/levels", {"levels": -1}), ("/media/0/mu", {"mu": 1.5}),
                ("/media/0/color", {"color": [1, -1, 1]}), ("/media/0/color", {"color": [1, 1]}),
                ("/media/0/wind", {"wind": [1]}), ("/media/0/origin", {"origin": "x"}),
                ("/media/0/albedo", {"albedo": [2, 1, 1]}), ("/media/0/asymmetry", {"asymmetry": 1}),
                ("/media/0/convert", {"convert": "red"}), ("/media/0/sigma-max: this name", {"sigma-max": 1}),
                ("/media/0/times", {"times": [1, 2]}), ("/media/0/time/rate", {"time": {"rate": 0}}),
                ("/media/0/top/map", {"top": {}}), ("/media/0/top/height", {"top": {"map": "map.png", "height": -1}}),
                ("/media/0/profile/kind", {"profile": {"kind": "round"}}),
                ("/media/0/profile:", {"profile": {"kind": "slab", "bottom": 3, "top": 2}}),
                ("/media/0/profile:", {"profile": {"kind": "linear", "knots": [[0, 1]]}}),
                ("/media/0/profile/knots[1]", {"profile": {"kind": "linear", "knots": [[0, 1], [2]]}}),
                ("/media/0/profile/layers", {"profile": {"kind": "layers"}})):
            self.scene["media"] = [self.fog | change]
            self.assertIn("scene.json: " + where, self.fails(1, "render", self.write(), "-o", self.path("x.png")))
        self.scene["media"] = [self.fog]
        for where, lights in (("/lights", {}), ("/lights/0/kind", [{"kind": "moon"}]),
                              ("/lights/0/direction", [{"kind": "sun", "direction": [0, 0, 1]}]),
                              ("/lights/0/radiance", [{"kind": "sun", "direction": [0, 0, -1], "radiance": [-1, 0, 0]}]),
                              ("/lights/0", [{"kind": "spot"}])):
            self.scene["lights"] = lights
            self.assertIn("scene.json: " + where, self.fails(1, "render", self.write(), "-o", self.path("x.png")))

    def test_maps_that_are_not_there_or_damaged(self):
        self.fog["map"] = "none.png"
        self.assertIn("none.png", self.fails(1, "render", self.write(), "-o", self.path("x.png")))
        data = self.path("map.png").read_bytes()
        self.path("half.png").write_bytes(data[:len(data) // 2])
        self.fog["map"] = "half.png"
        self.assertIn("half.png", self.fails(1, "render", self.write(), "-o", self.path("x.png")))
        write_npy(self.path("deep.npy"), (3, 4, 4), [0] * 48)
        self.fog["map"] = "deep.npy"
        self.assertIn("deep.npy", self.fails(1, "render", self.write(), "-o", self.path("x.png")))


class Frames(FogCase):
    """volute fog: out = T color + (1 - T) fog-color."""

    def setUp(self):
        super().setUp()
        self.white(size=40)
        self.camera({"eye": [20, -5, 5], "target": [20, 15, 5], "fov": 60})
        self.color(0.5)
        self.depth([10] * 48)

    def camera(self, camera):
        self.path("camera.json").write_text(json.dumps(camera))

    def color(self, value):
        write_planes(self.path("color.exr"), 8, 6, {name: [value] * 48 for name in "RGB"})

    def depth(self, values, width=8, height=6):
        write_planes(self.path("depth.exr"), width, height, {"Y": values})

    def words(self, *more, out="x.exr", sigma=0.1):
        return ("fog", self.path("map.png"), "--color", self.path("color.exr"), "--depth", self.path("depth.exr"),
                "--camera", self.path("camera.json"), "-o", self.path(out), f"--sigma-max={sigma}", *more)

    def expected(self, name, optical):
        """The picture of these optical depths."""
        values = [0.5 * math.exp(-t) + 0.25 * (1 - math.exp(-t)) for t in optical]
        write_planes(self.path(name), 8, 6, {c: values for c in "RGB"})
        return name

    def per_pixel(self, along):
        """along(stretch) with stretch = |ray| / its part along the axis, which is +y here."""
        pixel = 2 * math.tan(math.radians(30)) / 6
        return [along(math.hypot(1, (x + 0.5 - 4) * pixel, (y + 0.5 - 3) * pixel)) for y in range(6) for x in range(8)]

    def test_depth_along_the_axis_and_along_the_ray(self):
        more = ("--fog-color", "0.25,0.25,0.25", "--degree", "0")
        self.works(*self.words(*more))
        self.expected("z.exr", self.per_pixel(lambda stretch: 0.1 * 5 * stretch))  # the map begins at y = 0
        self.assertLess(self.difference("z.exr", "x.exr"), 2e-6)
        self.works(*self.words(*more, "--depth-kind", "ray"))
        self.expected("ray.exr", self.per_pixel(lambda stretch: 0.1 * (10 - 5 * stretch)))
        self.assertLess(self.difference("ray.exr", "x.exr"), 2e-6)

    def test_maps_go_with_the_frames_of_their_numbers(self):
        for first in (0, 1, 1001):
            for i in range(3):
                write_rows(self.path(f"map{first}_{first + i:04d}.png"), [[80 * (i + 1)] * 40] * 40)
                for name in ("color", "depth"):
                    self.path(f"{name}{first}_{first + i:04d}.exr").write_bytes(self.path(f"{name}.exr").read_bytes())
            for rate in ("25", "30"):
                words = [self.path(f"map{first}_%04d.png"), "--color", self.path(f"color{first}_%04d.exr"),
                         "--depth", self.path(f"depth{first}_%04d.exr"), "--camera", self.path("camera.json"), "--fps", rate]
                message = self.works("fog", *words, "-o", self.path("x_%04d.exr")).message
                self.assertNotIn("map,", message)
                for i in range(3):
                    self.works("fog", self.path(f"map{first}_{first + i:04d}.png"), *self.words(out="y.exr", sigma=0.05)[2:])
                    self.assertLess(self.difference(f"x_{first + i:04d}.exr", "y.exr"), 1e-6, (first, rate, i))
        still = [self.path("map1001_%04d.png"), "--color", self.path("color.exr"), "--depth", self.path("depth.exr"),
                 "--camera", self.path("camera.json"), "-o", self.path("s_%04d.exr"), "--frames", "1001:1004"]
        self.assertNotIn("last map", self.works("fog", *still).message)
        self.works("fog", self.path("map1001_1002.png"), *self.words(out="y.exr", sigma=0.05)[2:])
        self.assertLess(self.difference("s_1002.exr", "y.exr"), 1e-6)
        for name in ("color", "depth"):  # a frame more than there are maps
            self.path(f"{name}1_0004.exr").write_bytes(self.path(f"{name}.exr").read_bytes())
        words = [self.path("map1_%04d.png"), "--color", self.path("color1_%04d.exr"), "--depth", self.path("depth1_%04d.exr"),
                 "--camera", self.path("camera.json"), "-o", self.path("x_%04d.exr")]
        self.assertIn("after the last map", self.works("fog", *words).message)
        self.path("map1_0002.png").unlink()
        write_rows(self.path("map1_0004.png"), [[9] * 40] * 40)
        self.path("map1_0001.png").rename(self.path("map1_0000.png"))
        write_rows(self.path("map1_0001.png"), [[9] * 40] * 40)
        self.assertIn("1 of the frames 0 to 4 is missing: 2", self.works("fog", *words).message)

    def test_what_a_map_holds_is_used_or_told(self):
        def said(name, *more):
            return self.works("fog", self.path(name), *self.words(*more)[2:]).message
        plain = said("map.png")
        # Alpha: what is transparent is not painted. Opaque pictures say nothing.
        write_rows(self.path("clear.png"), [[255, 0] * 40] * 40, channels=2)
        self.assertIn("multiplied by its alpha", said("clear.png"))
        self.assertEqual(self.difference("x.exr", "color.exr"), 0)
        write_rows(self.path("opaque.png"), [[255, 255] * 40] * 40, channels=2)
        self.assertEqual(said("opaque.png").replace("opaque", "map"), plain)
        # Volumes: values as they are, places only by the map's own cell and origin.
        write_npy(self.path("large.npy"), (1, 40, 40), [200] * 1600)
        self.assertIn("values up to 200 count as they are", said("large.npy"))
        write_npy(self.path("small.npy"), (1, 40, 40), [0.5] * 1600)
        self.assertNotIn("small.npy", said("small.npy"))
        self.path("small.vti").write_text(
            '<VTKFile type="ImageData" version="0.1" byte_order="LittleEndian"><ImageData WholeExtent="0 40 0 40 0 1" Origin="5 6 0" '
            'Spacing="3 3 1"><Piece Extent="0 40 0 40 0 1"><CellData Scalars="density"><DataArray type="Float32" Name="density" '
            f'format="ascii">{"0.5 " * 1600}</DataArray></CellData></Piece></ImageData></VTKFile>')
        self.assertIn("cells are 3 x 3 m from x = 5, y = 6 m; this is not used", said("small.vti"))
        self.assertNotIn("not used", said("small.vti", "--cell", "1"))
        self.path("map.jpg").write_bytes(b"\xff\xd8\xff\xe0")
        self.assertIn("expected .png (8 or 16 bits) or .exr", self.fails(1, "fog", self.path("map.jpg"), *self.words(out="none.exr")[2:]))
        write_planes(self.path("bright.exr"), 40, 40, {"Y": [200] * 1600, "density": [1] * 1600})
        self.assertIn("values up to 200 count as they are", said("bright.exr"))
        self.assertIn("the map is Y; left out: density", said("bright.exr"))
        write_parts(self.path("wide.exr"), [Part(40, 40, {"Y": [0.5] * 1600}, aspect=2.0)])
        self.assertIn("2 times as wide as high; the map's cells are square", said("wide.exr"))
        write_planes(self.path("even.exr"), 40, 40, {"Y": [0.5] * 1600})
        self.assertNotIn("even.exr", said("even.exr"))
        # Chunks of a .png before its pixels: three pictures, and pixels twice as wide as high.
        data = self.path("map.png").read_bytes()
        chunks = b"".join(struct.pack(">I", len(body) - 4) + body + struct.pack(">I", zlib.crc32(body))
                          for body in (b"acTL" + struct.pack(">II", 3, 0), b"pHYs" + struct.pack(">IIB", 1000, 2000, 1)))
        self.path("animated.png").write_bytes(data[:33] + chunks + data[33:])
        self.assertIn("holds 3 pictures; the first is read", said("animated.png"))
        self.assertIn("2 times as wide as high; the map's cells", said("animated.png"))
        # Parts of a .exr: nobody says which one is the map.
        part = {"Y": [0.5] * 1600}
        write_parts(self.path("parts.exr"), [Part(40, 40, part, "low"), Part(40, 40, part, "fog")])
        self.assertIn("2 parts", self.fails(1, "fog", self.path("parts.exr"), *self.words(out="none.exr")[2:]))

    def test_options_without_effect_are_told(self):
        for more, text in ((("--mu", "0.5"), "mu has no effect"), (("--cell-angle", "0.1"), "cell_angle has no effect"),
                           (("--border", "clamp"), "border has no effect"), (("--fps", "30"), "--fps has no effect")):
            self.assertIn(text, self.works(*self.words(*more)).message)
            self.assertIn(text, self.fails(1, *self.words(*more, "--strict", out="none.exr")))
            self.assertFalse(self.path("none.exr").exists())
        self.assertNotIn("no effect", self.works(*self.words("--mu", "0.5", "--levels", "2")).message)
        self.assertIn("levels has no effect: the finest one", self.works(*self.words("--levels", "2")).message)
        both = self.works(*self.words("--levels", "2", "--cell-angle", ".1", "--mu", ".5"))
        self.assertIn("mu has no effect: cell_angle says", both.message)
        self.assertIn("wind has no effect: it is vertical", self.works(*self.words("--wind", "0,0,5")).message)
        self.works("fog", self.path("map.png"), "--export-glsl", self.path("shaders"))
        self.assertIn("--sky-depth has no effect: --export-glsl alone",
                      self.fails(2, "fog", self.path("map.png"), "--export-glsl", self.path("shaders"), "--sky-depth", "5"))
        self.assertIn("--path has no effect", self.fails(2, *self.words("--path", "polar", "--renderer", "reference")))
        write_rows(self.path("color.png"), [[10, 120, 250] * 8] * 6, channels=3)
        words = [self.path("color.png") if str(word).endswith("color.exr") else word for word in self.words("--color-layer", "foo")]
        self.assertIn("--color-layer is for a .exr", self.fails(2, *words))
        blown = ("--fps", "30", "--wind", "1,0,0", "--border", "zero", "--frames", "0:2")
        self.assertNotIn("no effect", self.works(*self.words(*blown, out="x_%d.exr")).message)

    def test_what_is_not_kept_of_a_frame_is_told(self):
        planes = {name: [0.5] * 48 for name in ("R", "G", "B", "diffuse.R", "N.X")}
        write_planes(self.path("color.exr"), 8, 6, planes)
        self.assertIn("2 other channels of the frame are left out: N.X, diffuse.R", self.works(*self.words()).message)
        self.assertNotIn("left out", self.works(*self.words(out="x.png")).message)
        both = {"R": [0.5] * 48, "G": [0.5] * 48, "B": [0.5] * 48, "Z": [20.0] * 48}
        write_planes(self.path("all.exr"), 8, 6, both)
        words = [self.path("all.exr") if str(word).endswith(("color.exr", "depth.exr")) else word for word in self.words()]
        self.assertNotIn("left out", self.works(*words).message)
        planes["R"][0] = float("nan")
        write_planes(self.path("color.exr"), 8, 6, planes)
        self.assertIn("values that are infinite or no numbers (1)", self.works(*self.words(out="x.png")).message)
        planes["G"][2 * 8 + 5] = float("inf")
        write_planes(self.path("color.exr"), 8, 6, planes)
        self.assertIn("color.exr: pixel 0, 0 is nan, and 1 more are no finite light; it stays so", self.works(*self.words()).message)
        # Of several frames each kind of loss once, whichever frame has it.
        light = {name: [0.5] * 48 for name in "RGB"}
        for i, more in enumerate(({}, {"id": [1.0] * 48}, {}, {"id": [1.0] * 48})):
            write_parts(self.path(f"color_{i}.exr"), [Part(8, 6, light | more, aspect=2.0 if i == 2 else 1.0)])
            self.path(f"depth_{i}.exr").write_bytes(self.path("depth.exr").read_bytes())
        words = [str(word).replace("color.exr", "color_%d.exr").replace("depth.exr", "depth_%d.exr") for word in self.words()]
        said = self.works(*[word.replace("x.exr", "x_%d.exr") for word in words]).message
        self.assertEqual(said.count("1 other channel of frame 1 is left out: id"), 1)
        self.assertEqual(said.count("left out"), 1)
        self.assertIn("does not keep that pixels are 2 times as wide as high of frame 2",
                      self.works(*[word.replace("x.exr", "x_%d.png") for word in words]).message)

    def test_a_camera_with_keys_is_refused(self):
        self.camera({"eye": [20, -5, 5], "target": [20, 15, 5], "fov": 60, "keys": [[0, 20, -5, 5, 20, 15, 5], [1, 20, 5, 5, 20, 15, 5]]})
        self.assertIn("camera.json: a camera that moves", self.fails(1, *self.words()))

    def test_the_sky_is_behind_all_fog(self):
        self.camera({"eye": [20, 20, 30], "target": [20, 20, 0], "up": [0, 1, 0], "ortho": 6})
        self.depth([INFINITY] * 48)
        profile = ("--profile", "slab:0,20", "--fog-color", "0.25,0.25,0.25")
        self.works(*self.words(*profile))
        self.assertAlmostEqual(self.value("x.exr"), 0.5 * math.exp(-2) + 0.25 * (1 - math.exp(-2)), delta=2e-6)
        self.depth([20] * 48)
        self.works(*self.words(*profile, "--sky-depth", "15"))
        self.assertAlmostEqual(self.value("x.exr"), 0.5 * math.exp(-2) + 0.25 * (1 - math.exp(-2)), delta=2e-6)
        self.works(*self.words(*profile))
        self.assertAlmostEqual(self.value("x.exr"), 0.5 * math.exp(-1) + 0.25 * (1 - math.exp(-1)), delta=2e-6)

    def test_nothing_in_the_air_changes_nothing(self):
        self.works(*self.words(sigma=0))
        self.assertEqual(self.difference("color.exr", "x.exr"), 0)

    def test_display_pictures_in_and_out(self):
        write_rows(self.path("color.png"), [[10, 120, 250] * 8] * 6, channels=3)
        words = [self.path("color.png") if str(word).endswith("color.exr") else word for word in self.words(out="x.png", sigma=0)]
        self.works(*words)
        self.assertEqual(self.difference("color.png", "x.png"), 0)

    def test_frames_of_16_bits_stay_so(self):
        for channels in (3, 4):
            rows = [[65535 if channels == 4 and i % 4 == 3 else 257 * i + 40 * y + 1 for i in range(8 * channels)] for y in range(6)]
            write_rows(self.path("color.png"), rows, 16, channels)
            words = [self.path("color.png") if str(word).endswith("color.exr") else word for word in self.words(out="x.png", sigma=0)]
            self.works(*words)
            self.assertEqual(self.path("x.png").read_bytes()[24], 16, channels)
            self.assertLess(self.difference("color.png", "x.png"), 2e-7)

    def test_both_renderers_and_a_scene_agree(self):
        self.waves("map.png", 40)
        more = ("--degree", "3", "--levels", "2", "--mu", "0.5", "--profile", "exponential:0,8")
        self.works(*self.words(*more))
        self.works(*self.words(*more, "--renderer", "reference", out="reference.exr"))
        self.assertLess(self.difference("x.exr", "reference.exr"), 1e-5)
        self.depth([INFINITY] * 48)
        self.works(*self.words(*more))
        scene = {"format": "volute-scene-2", "background": [0.5] * 3,
                 "camera": json.loads(self.path("camera.json").read_text()) | {"size": [8, 6]},
                 "media": [{"kind": "fog", "map": "map.png", "sigma_max": 0.1, "degree": 3, "levels": 2, "mu": 0.5,
                            "color": [0.8, 0.85, 0.9], "profile": {"kind": "exponential", "bottom": 0, "height": 8}}]}
        self.path("scene.json").write_text(json.dumps(scene))
        self.works("render", self.path("scene.json"), "-o", self.path("scene.exr"))
        self.assertLess(self.difference("x.exr", "scene.exr"), 1e-6)

    def test_the_polar_path_is_within_its_bound_and_walks_where_it_does_not_serve(self):
        self.waves("map.png", 40)
        self.depth([8] * 48)
        more = ("--profile", "slab:0,8", "--fog-color", "0,0,0")
        self.works(*self.words(*more))
        self.assertNotIn("no effect", self.works(*self.words(*more, "--path", "polar", out="polar.exr")).message)
        difference = self.difference("x.exr", "polar.exr")
        self.assertGreater(difference, 0)
        self.assertLess(difference, 0.5 / 512)
        for unserved in (("--degree", "0"), ("--sun", "0,1,-1"), ("--levels", "2", "--mu", "0.5"),
                         ("--profile", "exponential:0,8")):
            words = self.words(*more, *unserved) if unserved[0] != "--profile" else self.words(*unserved)
            self.works(*words)
            said = self.works(*[self.path("polar.exr") if word == self.path("x.exr") else word for word in words],
                              "--path", "polar").message
            self.assertIn("path has no effect: fog", said)
            self.assertEqual(self.difference("x.exr", "polar.exr"), 0, unserved)

    def test_a_table_is_within_its_bound_however_far_the_eye(self):
        rows = [[round(32000 * (1 + math.sin(0.15 * x) * math.cos(0.11 * y))) for x in range(128)] for y in range(128)]
        write_planes(self.path("map.exr"), 128, 128, {"Y": [value / 65535 for row in rows for value in row]})
        for away in (300, 3000, 10000):
            scene = {"format": "volute-scene-2", "background": [1, 1, 1],
                     "camera": {"eye": [64, -away, 0.03 * away], "target": [64, 64, 0],
                                "fov": math.degrees(2 * math.atan(70 / away)), "size": [320, 240]},
                     "media": [{"kind": "fog", "map": "map.exr", "sigma_max": 0.05, "color": [0, 0, 0],
                                "profile": {"kind": "slab", "bottom": 0, "top": 10}}]}
            for path in ("auto", "polar", "walk"):
                scene["media"][0]["path"] = path
                self.path("scene.json").write_text(json.dumps(scene))
                self.works("render", self.path("scene.json"), "-o", self.path(f"{path}.exr"), "--renderer", "cpu",
                           measured=False)
            self.assertLess(self.difference("walk.exr", "auto.exr"), 1e-4, away)
            self.assertLess(self.difference("walk.exr", "polar.exr"), 1e-4, away)

    def test_fine_maps_are_looked_up_in_pictures_and_walked_in_measurements(self):
        for size, looked_up in ((160, True), (64, False)):
            self.waves("map.png", size)
            scene = {"format": "volute-scene-2", "background": [0.5] * 3,
                     "camera": {"eye": [5, 5, 3], "target": [60, 50, 3], "fov": 30, "size": [320, 240]},
                     "media": [{"kind": "fog", "map": "map.png", "sigma_max": 0.05, "cell": 64 / size, "profile": {"kind": "slab", "bottom": 0, "top": 8}}]}
            self.path("scene.json").write_text(json.dumps(scene))
            self.works("render", self.path("scene.json"), "-o", self.path("auto.exr"), measured=False)
            self.works("render", self.path("scene.json"), "-o", self.path("measured.exr"), "--measured")
            scene["media"][0]["path"] = "walk"
            self.path("scene.json").write_text(json.dumps(scene))
            self.works("render", self.path("scene.json"), "-o", self.path("walk.exr"), measured=False)
            self.assertEqual(self.difference("walk.exr", "measured.exr"), 0)
            difference = self.difference("walk.exr", "auto.exr")
            self.assertLess(difference, 1e-4)
            (self.assertGreater if looked_up else self.assertEqual)(difference, 0)

    def test_options_of_a_sun_need_one(self):
        for words in (("--albedo", "0.5,0.5,0.5"), ("--asymmetry", "0.5"), ("--sun-radiance", "1,1,1"), ("--geometry", "a.obj")):
            self.assertIn(f"{words[0]} has no effect without --sun", self.fails(2, *self.words(*words)))

    def test_details_by_the_angle_of_a_cell(self):
        self.waves("map.png", 40)
        self.works(*self.words("--levels", "3"))
        self.works(*self.words("--levels", "3", "--cell-angle", "1e-4", out="fine.exr"))
        self.works(*self.words("--levels", "3", "--cell-angle", "1", out="coarse.exr"))
        self.assertEqual(self.difference("x.exr", "fine.exr"), 0)
        self.assertGreater(self.difference("x.exr", "coarse.exr"), 1e-4)
        self.assertIn("cell-angle", self.fails(2, *self.words("--cell-angle", "-1")))

    def test_several_frames(self):
        for number in (3, 4):
            for name in ("color", "depth"):
                self.path(f"{name}_{number}.exr").write_bytes(self.path(f"{name}.exr").read_bytes())
        words = ["fog", self.path("map.png"), "--color", self.path("color_%d.exr"), "--depth", self.path("depth_%d.exr"),
                 "--camera", self.path("camera.json"), "--wind", "100,0,0", "--border", "zero"]
        self.works(*words, "-o", self.path("out_%d.exr"))
        self.assertGreater(self.difference("out_3.exr", "out_4.exr"), 1e-4)
        self.works(*words, "-o", self.path("out.mp4"), "--frames", "3:5")
        self.assertIn("%04d", self.fails(2, *words, "-o", self.path("out.exr")))
        self.fails(2, *words, "-o", self.path("out.exr"), "--frames", "7:9")
        self.assertIn("the pattern says how long", self.fails(2, *words, "-o", self.path("out.mp4"), "--duration", "1"))

    def test_a_film_of_one_still(self):
        words = self.words("--wind", "100,0,0", "--border", "zero", out="out.mp4")
        self.assertIn("a film of one picture: --duration", self.works(*words).message)
        self.assertEqual(self.works(*words, "--duration", "0.2", "--json").json["pictures"], 5)
        self.assertEqual(self.works(*words, "--frames", "10:14", "--json").json["pictures"], 4)
        self.works(*self.words("--wind", "100,0,0", "--border", "zero", "--frames", "3:5", out="out_%d.exr"))
        self.assertGreater(self.difference("out_3.exr", "out_4.exr"), 1e-4)

    def test_depths_that_are_none(self):
        values = [10.0] * 48
        values[2 * 8 + 5] = float("nan")
        self.depth(values)
        message = self.fails(1, *self.words())
        self.assertIn("depth.exr: pixel 5, 2 is nan", message)
        values[2 * 8 + 5] = -1
        self.depth(values)
        self.assertIn("pixel 5, 2 is -1", self.fails(1, *self.words()))
        write_planes(self.path("depth.exr"), 8, 6, {name: [i + 1] * 48 for i, name in enumerate("RGB")})
        self.assertIn("R, G and B are not the same", self.fails(1, *self.words()))

    def test_sizes_must_agree(self):
        self.depth([1] * 40, 8, 5)
        self.assertIn("8 x 5", self.fails(1, *self.words()))
        self.depth([1] * 48)
        self.camera({"eye": [0, 0, 0], "target": [1, 0, 0], "fov": 60, "size": [80, 60]})
        self.assertIn("80 x 60", self.fails(1, *self.words()))

    def test_shaders(self):
        self.waves()
        folder = self.path("shaders")
        self.works("fog", self.path("waves.png"), "--export-glsl", folder, "--degree", "2", "--levels", "1",
                   "--origin", "1,2,3", "--profile", "slab:0,5")
        uniforms = json.loads((folder / "fog.json").read_text())
        size = uniforms["fogMap"]["width"] * uniforms["fogMap"]["height"]
        texels = (folder / "fog_map.f32").read_bytes()
        self.assertEqual(len(texels), 4 * size)
        for name in ("fog.glsl", "fog_polar.glsl"):
            text = (folder / name).read_text()
            self.assertTrue(text.startswith("// SPDX-License-Identifier: Apache-2.0"))
        self.assertIn("fogOpticalDepth", (folder / "fog.glsl").read_text())
        self.assertIn(f"{uniforms['fogMap']['width']} x", (folder / "README.md").read_text())
        self.assertLess(uniforms["fogCorner"][0], 1)  # the padding for levels
        self.works("fog", self.path("waves.png"), "--export-glsl", self.path("more"), "--profile", "exponential:0,5")
        self.assertFalse((self.path("more") / "fog_polar.glsl").exists())
        self.fails(1, "fog", self.path("waves.png"), "--export-glsl", self.path("waves.png"))
        for more, text in ((("--sun", "1,0,-1"), "neither the sun"), (("--wind", "3,0,0"), "the wind does not move it")):
            self.assertIn(text, self.works("fog", self.path("waves.png"), "--export-glsl", self.path("more"), *more).message)
        write_rows(self.path("long.png"), [[9] * 20000])
        self.assertIn("at most 16384", self.works("fog", self.path("long.png"), "--export-glsl", self.path("more")).message)

    def test_wrong_usage(self):
        for more in (("--degree", "4"), ("--cell", "0"), ("--mu", "2"), ("--profile", "round:1"),
                     ("--profile", "slab:3,1"), ("--profile", "slab:3,x"), ("--sun", "0,0,1"), ("--levels", "99"),
                     ("--fog-color=-1,0,0",), ("--frames", "2:1"), ("--depth-kind", "w"), ("--depth-scale", "0"), ("--geometry-up", "y")):
            self.fails(2, *self.words(*more))
        self.assertIn("at least 0", self.fails(2, *self.words(sigma=-1)))
        self.fails(2, "fog", self.path("map.png"))
        self.assertIn("--depth", self.fails(2, "fog", self.path("map.png"), "--color", self.path("color.exr")))
        self.fails(2, *self.words(out="x.jpg"))


class Valley(FogCase):
    def test_frames_for_fog(self):
        folder = self.path("valley")
        self.works("synthesize", "valley", "-o", folder, "--pixels", "48x27", "--size", "32", "--seed", "3")
        self.assertEqual(sorted(path.name for path in folder.iterdir()), ["camera.json", "color.exr", "depth.exr", "fogmap.png"])
        self.works("fog", folder / "fogmap.png", "--color", folder / "color.exr", "--depth", folder / "depth.exr",
                   "--camera", folder / "camera.json", "-o", self.path("x.exr"), "--cell", "16")
        self.assertGreater(self.works("compare", folder / "color.exr", self.path("x.exr"), "--json").json["max_error"], 0.05)

    def test_a_flight(self):
        folder = self.path("flight")
        self.works("synthesize", "valley", "-o", folder, "--pixels", "16x10", "--frames", "2")
        self.assertIn("color_0001.png", [path.name for path in folder.iterdir()])
        self.works("fog", folder / "fogmap.png", "--color", folder / "color_%04d.png", "--depth", folder / "depth_%04d.exr",
                   "--camera", folder / "camera_%04d.json", "-o", self.path("x.mp4"), "--cell", "8")


if __name__ == "__main__":
    support.main()
