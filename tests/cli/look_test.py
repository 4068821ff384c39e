# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""How volumes look: presets, light, tone curves, layers, cameras that move."""
import json
import math
import statistics

import meaning_formats
import pictures
import support
from render_test import read_png
from support import write_npy


def ball(size, radius=0.35):
    """(z, y, x) values of a soft ball in the middle of 1 m."""
    values = []
    for z in range(size):
        for y in range(size):
            for x in range(size):
                far = math.dist(((x + 0.5) / size, (y + 0.5) / size, (z + 0.5) / size), (0.5, 0.5, 0.5))
                values.append(max(0.0, 1 - far / radius))
    return values


def srgb(level):
    """Linear light of a level of 255."""
    value = level / 255
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4


class Look(support.TestCase):
    def npy(self, name, size=16, frames=1):
        write_npy(self.path(name), (frames, size, size, size), frames * ball(size))
        return self.path(name)

    def scene(self, **volume):
        self.npy("v.npy")
        lights = volume.pop("lights", [])
        camera = volume.pop("camera", {"eye": [0.5, -2, 0.5], "target": [0.5, 0.5, 0.5], "fov": 30, "size": [24, 24]})
        self.path("scene.json").write_text(json.dumps({
            "format": "volute-scene-1", "camera": camera, "lights": lights,
            "media": [{"kind": "volume", "file": "v.npy", "emission": 0} | volume]}))
        return self.path("scene.json")

    def brightest(self, picture):
        return self.works("info", picture, "--json").json["maximum"]

    def test_temperatures_in_degrees_glow_as_those_in_kelvins(self):
        kelvins = [300 + 1300 * value for value in ball(16)]
        scaled = {"K": lambda k: k, "degC": lambda k: k - 273.15, "degF": lambda k: 1.8 * k - 459.67}
        places = {axis: [0.05 + 0.1 * i for i in range(16)] for axis in "zyx"} | {"t": [0]}
        camera = {"eye": [0.8, -2, 0.8], "target": [0.8, 0.8, 0.8], "fov": 30, "size": [24, 24]}
        for own in (False, True):
            seen = {}
            for unit, change in scaled.items():
                name = self.path(f"{unit}.nc")
                name.write_bytes(meaning_formats.netcdf(sizes=(1, 16, 16, 16), names={"s": "temperature"}, units={"s": unit}, places=places,
                                                        change=lambda values: [change(k) for k in kelvins]))
                volume = {"kind": "volume", "file": name.name} | ({"emission": 0, "flames": {"temperature": "temperature", "hottest": 1500}} if own else {})
                self.path("s.json").write_text(json.dumps({"format": "volute-scene-2", "camera": camera, "media": [volume]}))
                self.works("render", self.path("s.json"), "-o", self.path("x.exr"), measured=False)
                seen[unit] = self.brightest(self.path("x.exr"))
                said = self.works("render", name, "-o", self.path("x.png"), "--size", "8x8").message
                self.assertEqual(" K) as black bodies as hot as" in said, unit != "K", said)
            for unit in ("degC", "degF"):
                self.assertAlmostEqual(seen[unit] / seen["K"], 1, delta=0.03, msg=f"{own} {unit}")

    def test_dense_clouds_are_brighter_where_light_is_scattered_more_than_once(self):
        scene = self.scene(extinction=60, albedo=[0.95, 0.95, 0.95],
                           lights=[{"kind": "sun", "direction": [0.3, 1, -0.3], "radiance": [1, 1, 1]}])
        self.works("render", scene, "-o", self.path("once.exr"), measured=False)
        self.works("render", scene, "-o", self.path("again.exr"), "--scattering", "multiple", measured=False)
        self.assertGreater(self.brightest(self.path("again.exr")), 1.5 * self.brightest(self.path("once.exr")))
        said = self.fails(2, "render", scene, "-o", self.path("m.exr"), "--scattering", "multiple", "--measured")
        self.assertIn("--scattering changes light; --measured shows it as it is", said)
        document = json.loads(scene.read_text()) | {"scattering": "multiple"}
        scene.write_text(json.dumps(document))
        self.works("render", scene, "-o", self.path("scene.exr"), measured=False)
        self.assertEqual(self.path("scene.exr").read_bytes(), self.path("again.exr").read_bytes())
        said = self.works("render", scene, "-o", self.path("m.exr"), "--measured").message
        self.assertIn("/scattering: light scattered more than once is approximate", said)

    def test_a_file_is_shown_as_its_name_says(self):
        small = ("--size", "24x24")
        said = self.works("render", self.npy("smoke.npy"), "-o", self.path("s.png"), *small).message
        self.assertIn("smoke.npy: shown as smoke", said)
        said = self.works("render", self.npy("fire.npy"), "-o", self.path("f.png"), *small).message
        self.assertIn("fire.npy: shown as fire", said)
        self.assertIn("1100 to 2000 K", said)
        rows = read_png(self.path("f.png").read_bytes())[2]
        pixels = [row[i:i + 3] for row in rows for i in range(0, len(row), 3)]
        self.assertTrue(any(r > g > b for r, g, b in pixels), "flames are red before they are green or blue")
        bright = max(pixels, key=sum)
        self.assertGreater(min(bright), 60, "bright light loses its colour, it is not clipped")
        said = self.works("render", self.npy("thing.npy"), "-o", self.path("t.png"), *small, "--strict").message
        self.assertIn("thing.npy: shown as light", said)

    def test_close_views_have_no_creases(self):
        """Cubic where a voxel covers more than 3 pixels, for all pictures of a film, and never where something is measured or stated."""
        volume = self.npy("thing.npy", size=32, frames=2)

        def same(one, other, bound):
            found = self.works("compare", self.path(one), self.path(other), "--json").json
            (self.assertEqual(found["max_error"], 0) if bound == 0 else self.assertLess(found["max_error"], bound))
            return found["max_error"]

        def draw(name, *options, source=volume):
            words = [*options, *(() if "--measured" in options else ("--samples", "1"))]
            self.works("render", source, "-o", self.path(name), "--time", "0", *words, measured=False)

        for preset, bound in (("none", 1e-3), ("smoke", 1e-2), ("fire", 7e-3)):
            for extinction in ((), ("--extinction", "2")) if preset == "none" else ((),):
                wide = ("--preset", preset, "--size", "240x180", *extinction)
                draw("auto.exr", *wide)
                draw("cubic.exr", *wide, "--basis", "cubic")
                draw("trilinear.exr", *wide, "--basis", "trilinear")
                same("auto.exr", "cubic.exr", 0)
                most = self.brightest(self.path("cubic.exr"))
                self.assertGreater(same("auto.exr", "trilinear.exr", 1e9), 0.8 * bound * most)
                # Refined, it is the spline that a measurement integrates.
                draw("exact.exr", *wide, "--basis", "cubic", "--measured")
                same("auto.exr", "exact.exr", bound * most)
                small = ("--preset", preset, "--size", "32x24", *extinction)
                draw("small.exr", *small)
                draw("small3.exr", *small, "--basis", "trilinear")
                same("small.exr", "small3.exr", 0)
        draw("measured.exr", "--size", "240x180", "--measured")
        draw("box.exr", "--size", "240x180", "--measured", "--basis", "box")
        same("measured.exr", "box.exr", 0)
        # One look for a film: its closest view decides.
        scene = {"format": "volute-scene-2", "background": [0, 0, 0], "media": [{"kind": "volume", "file": "thing.npy"}],
                 "camera": {"eye": [0.5, -9, 0.5], "target": [0.5, 0.5, 0.5], "fov": 30, "size": [240, 180], "keys": [[0, 0.5, -9, 0.5, 0.5, 0.5, 0.5], [0.04, 0.5, -1.5, 0.5, 0.5, 0.5, 0.5]]}}
        self.path("film.json").write_text(json.dumps(scene))
        film = ("render", self.path("film.json"), "--samples", "1")
        self.works(*film, "-o", self.path("f_%04d.exr"), "--frames", "0:2", measured=False)
        self.works(*film, "-o", self.path("g_%04d.exr"), "--frames", "0:2", "--basis", "cubic", measured=False)
        self.works(*film, "-o", self.path("far.exr"), "--time", "0", measured=False)
        self.works(*film, "-o", self.path("trilinear.exr"), "--time", "0", "--basis", "trilinear", measured=False)
        first = sorted(self.path(".").glob("f_*.exr"))[0].name
        same(first, first.replace("f_", "g_"), 0)
        same("far.exr", "trilinear.exr", 0)
        self.assertGreater(same("far.exr", first, 1e9), 0)
        # A part of it is drawn as the whole.
        self.works(*film, "-o", self.path("h_%04d.exr"), "--frames", "0:1", measured=False)
        same(first, first.replace("f_", "h_"), 0)

    def test_splines_are_nearly_as_sharp_as_their_voxels(self):
        """Layers of 1, 1.5, 2 and 1.5, from their side: the brightest pixel."""
        write_npy(self.path("layers.npy"), (1, 16, 16, 16), [(1, 1.5, 2, 1.5)[z % 4] for z in range(16) for _ in range(256)])

        def most(basis):
            self.works("render", self.path("layers.npy"), "-o", self.path("x.exr"), "--size", "96x96", "--basis", basis, "--measured")
            return self.brightest(self.path("x.exr"))

        self.assertGreater(most("cubic"), 0.97 * most("trilinear"))

    def test_solid_smoke_is_lit_on_its_surface(self):
        """As bright as thick smoke, however dense it is."""
        self.npy("solid.npy", size=24)
        scene = {"format": "volute-scene-2", "background": [0, 0, 0],
                 "lights": [{"kind": "sun", "direction": [0.3, 1, -0.3], "radiance": [1, 1, 1]}],
                 "camera": {"eye": [0.5, -2, 0.5], "target": [0.5, 0.5, 0.5], "fov": 30, "size": [160, 160]},
                 "media": [{"kind": "volume", "file": "solid.npy", "emission": 0, "albedo": [0.9, 0.9, 0.9]}]}

        def most(extinction):
            scene["media"][0]["extinction"] = extinction
            self.path("solid.json").write_text(json.dumps(scene))
            self.works("render", self.path("solid.json"), "-o", self.path("x.exr"), "--samples", "1", measured=False)
            return self.brightest(self.path("x.exr"))

        thick = most(20)
        for extinction in (2e3, 2e5, 2e7):
            self.assertGreater(most(extinction), 0.7 * thick)

    def test_contours_are_those_of_the_spline(self):
        """Where each row crosses some levels, against the exact spline [pixels, RMS]."""
        volume = self.npy("thing.npy", size=12)

        def crossings(*options):
            self.works("render", volume, "-o", self.path("x.exr"), "--time", "0", "--size", "144x144", *options, measured=False)
            picture = pictures.read_exr(self.path("x.exr"))
            rows = [[picture.values[3 * (144 * y + x)] for x in range(144)] for y in range(144)]
            most = 0.05
            found = {}
            for level in (0.1, 0.2, 0.35, 0.5):
                for y, row in enumerate(rows):
                    for x in range(143):
                        a, b = row[x] - level * most, row[x + 1] - level * most
                        if a < 0 <= b:
                            found[level, y] = x + a / (a - b)
                            break
            return found

        exact = crossings("--basis", "cubic", "--measured")

        def off(found):
            both = exact.keys() & found.keys()
            self.assertGreater(len(both), 100)
            return math.sqrt(statistics.fmean((found[at] - exact[at]) ** 2 for at in both))

        self.assertLess(off(crossings()), 0.05)
        self.assertGreater(off(crossings("--basis", "trilinear")), 0.3)

    def test_a_preset_is_chosen_by_name(self):
        said = self.works("render", self.npy("thing.npy"), "-o", self.path("t.png"), "--size", "8x8", "--preset", "smoke").message
        self.assertIn("shown as smoke", said)
        said = self.works("render", self.npy("smoke.npy"), "-o", self.path("t.png"), "--size", "8x8", "--preset", "none").message
        self.assertNotIn("shown as", said)
        # Colours of smoke: light by default, as it says.
        write_npy(self.path("smoke3.npy"), (1, 16, 16, 16, 3), [value for value in ball(16) for _ in range(3)])
        said = self.works("render", self.path("smoke3.npy"), "-o", self.path("t.png"), "--size", "8x8").message
        self.assertIn("is shown as light", said)
        self.assertIn("--preset smoke shows it as smoke", said)
        said = self.works("render", self.path("smoke3.npy"), "-o", self.path("t.exr"), "--size", "8x8", "--preset", "smoke").message
        self.assertIn("the mean of the three channels of", said)
        self.works("render", self.npy("one_smoke.npy"), "-o", self.path("one.exr"), "--size", "8x8", "--preset", "smoke")
        self.assertLess(self.works("compare", self.path("t.exr"), self.path("one.exr"), "--json").json["max_error"], 1e-3)
        said = self.fails(2, "render", self.path("smoke3.npy"), "-o", self.path("u.png"), "--preset", "fire")
        self.assertIn("has three, which are shown as light without it", said)
        said = self.fails(2, "render", self.npy("thing.npy"), "-o", self.path("u.png"), "--preset", "fire-and-smoke")
        self.assertIn("needs a grid of flames", said)

    def test_what_is_measured_takes_nothing_that_changes_light(self):
        for words in (("--tone", "filmic"), ("--bloom", "0.2"), ("--samples", "4")):
            said = self.fails(2, "render", self.npy("v.npy"), "-o", self.path("x.png"), "--measured", *words)
            self.assertIn(words[0], said)
            self.assertIn("--measured", said)
        plain = self.works("render", self.npy("smoke.npy"), "-o", self.path("a.exr"), "--size", "16x16", "--measured")
        self.assertNotIn("shown as", plain.message)

    def test_smoke_is_lit_from_the_side_of_the_sun(self):
        scene = self.scene(extinction=20, albedo=[0.9, 0.9, 0.9],
                           lights=[{"kind": "sun", "direction": [1, 0, -0.01], "radiance": [3, 3, 3]}])
        self.works("render", scene, "-o", self.path("x.png"), "--exposure", "3")
        rows = read_png(self.path("x.png").read_bytes())[2]
        left = sum(sum(row[:36]) for row in rows)
        right = sum(sum(row[36:]) for row in rows)
        self.assertGreater(left, 1.3 * right)

    def test_a_sun_on_what_scatters_nothing_says_so(self):
        sun = [{"kind": "sun", "direction": [1, 0, -1], "radiance": [3, 3, 3]}]
        said = self.works("render", self.scene(extinction=5, lights=sun), "-o", self.path("x.png")).message
        self.assertIn("/media/0: it scatters no light of the sun; say its albedo", said)

    def test_a_medium_looks_in_a_scene_as_its_file_does_alone(self):
        size = ("--size", "24x24", "--renderer", "cpu")
        self.works("render", self.npy("fire.npy"), "-o", self.path("alone.png"), *size)
        self.works("render", self.path("fire.npy"), "-o", self.path("plain.png"), *size, "--preset", "none")

        def picture(version, **members):
            scene = {"format": f"volute-scene-{version}", "media": [{"kind": "volume", "file": "fire.npy"} | members]}
            self.path("look.json").write_text(json.dumps(scene))
            self.works("render", self.path("look.json"), "-o", self.path("x.png"), *size)
            return read_png(self.path("x.png").read_bytes())[2]

        alone, plain = (read_png(self.path(name).read_bytes())[2] for name in ("alone.png", "plain.png"))
        self.assertNotEqual(alone, plain)
        self.assertEqual(picture(2), alone)
        # Advice names what can be written there.
        said = self.works("render", self.path("look.json"), "-o", self.path("x.png"), *size).message
        self.assertIn('; "preset": "none" in /media/0 shows plain values as light', said)
        self.assertNotIn("--preset", said)
        self.assertEqual(picture(2, preset="none"), plain)
        self.assertEqual(picture(1), plain)
        self.assertEqual(picture(1, preset="auto"), alone)

    def test_a_scene_of_one_file_shows_the_frame_that_the_file_shows(self):
        shape, values = support.plume(4, 8)
        write_npy(self.path("late.npy"), shape, [0.01 * value for value in values[:512]] + values[512:])
        self.works("compress", self.path("late.npy"), "-o", self.path("late.volute"), "--rms", "1e-4")
        size = ("--size", "24x24", "--renderer", "cpu")
        self.works("render", self.path("late.volute"), "-o", self.path("alone.png"), *size)

        def picture(version=2, **members):
            scene = {"format": f"volute-scene-{version}", "media": [{"kind": "volume", "file": "late.volute"}]} | members
            self.path("late.json").write_text(json.dumps(scene))
            said = self.works("render", self.path("late.json"), "-o", self.path("x.png"), *size)
            return said.message, self.path("x.png").read_bytes()

        said, same = picture()
        self.assertIn("showing frame 1: the first of 4", said)
        self.assertEqual(same, self.path("alone.png").read_bytes())
        for members in ({"version": 1}, {"camera": {"eye": [0.5, -2, 0.5], "target": [0.5, 0.5, 0.5], "fov": 30}},
                        {"media": 2 * [{"kind": "volume", "file": "late.volute"}]}):
            self.assertNotIn("showing", picture(**members)[0])

    def test_scenes_of_the_first_format_keep_their_pictures(self):
        """Light of pixels as volutes of before drew it: values as emission, and a preset's own light."""
        self.npy("fire.npy")
        frozen = {"none": [0.2250299, 0.2250299, 0.2250299, 0.2522477, 0.2522477, 0.2522477],
                  "fire": [9.9235954, 1.5163696, 0.0013069, 10.8460083, 1.7818799, 0.0063749],
                  "smoke": [0.2554736, 0.2531321, 0.2515896, 0.1707234, 0.1735635, 0.1801187]}
        for preset, expected in frozen.items():
            members = {} if preset == "none" else {"preset": preset}
            camera = {"eye": [0.5, -2, 0.5], "target": [0.5, 0.5, 0.5], "fov": 30, "size": [8, 8]}
            scene = {"format": "volute-scene-1", "camera": camera, "media": [{"kind": "volume", "file": "fire.npy"} | members]}
            self.path("first.json").write_text(json.dumps(scene))
            said = self.works("render", self.path("first.json"), "-o", self.path("x.exr"), "--renderer", "cpu", measured=False).message
            other = "/media/0: its values are shown as light, as a volute-scene-1 means it"
            (self.assertIn if preset == "none" else self.assertNotIn)(other, said)
            values = pictures.read_exr(self.path("x.exr")).values
            middle = values[3 * (3 * 8 + 3):3 * (3 * 8 + 5)]
            for value, before in zip(middle, expected, strict=True):
                # Between the rays of a fan of light there are cubics.
                self.assertAlmostEqual(value, before, delta=(1e-3 if preset == "smoke" else 1e-4) * max(1, before))

    def test_contradictions_are_refused(self):
        said = self.fails(1, "render", self.scene(albedo=[0.5, 0.5, 0.5]), "-o", self.path("x.png"))
        self.assertIn("scene.json: /media/0/albedo", said)
        self.works("render", self.scene(albedo=[0.5, 0.5, 0.5], extinction=0), "-o", self.path("faded.png"))
        said = self.fails(1, "render", self.scene(albedo=[0.5, 0.5, 0.5], extinction=3, basis="box"), "-o", self.path("x.png"))
        self.assertIn("scene.json: /media/0/basis", said)

    def test_edges_of_signs_have_no_stairs(self):
        pictures.write_png(self.path("white.png"), pictures.Picture(2, 2, 3, [1.0] * 12))
        self.path("sign.json").write_text(json.dumps({
            "format": "volute-scene-1", "media": [],
            "camera": {"eye": [0, -3, 0], "target": [0, 0, 0], "up": [0.13, 0, 1], "fov": 30, "size": [64, 64]},
            "signs": [{"name": "white", "position": [0, 0, 0], "normal": [0, -1, 0], "size": [0.9, 0.6], "picture": "white.png"}]}))

        def edge(*options):
            """What 24 columns of the upper edge show beside black and white, and how far the edge is off a straight line [pixels]."""
            self.works("render", self.path("sign.json"), "-o", self.path("x.png"), "--exposure", "1", "--tone", "none", *options)
            rows = read_png(self.path("x.png").read_bytes())[2]
            light = [[srgb(row[3 * x]) for row in rows[:32]] for x in range(20, 44)]
            between = {round(255 * value) for column in light for value in column} - {0, 255}
            heights = [sum(column) for column in light]
            line = statistics.linear_regression(range(24), heights)
            return between, max(abs(h - line.intercept - line.slope * x) for x, h in enumerate(heights))

        levels, off = edge("--samples", "1")
        self.assertFalse(levels, "one ray sees the sign or does not")
        self.assertGreater(off, 0.4, "stairs of a pixel")
        levels, off = edge()
        self.assertGreaterEqual(len(levels), 5, "eight rays")
        self.assertLess(off, 0.2, "the edge is as straight as the sign's")

    def test_layers_go_into_one_file(self):
        words = ("render", self.npy("v.npy"), "--size", "16x16", "--extinction", "9", "--eye", "0.5,-2,0.5",
                 "--target", "0.5,0.5,0.5", "--fov", "20")
        self.works(*words, "-o", self.path("x.exr"), "--aov", "beauty,alpha,z,transmittance,optical-depth", measured=False)
        data = self.path("x.exr").read_bytes()
        for channel in (b"A\0", b"B\0", b"G\0", b"R\0", b"Z\0", b"optical-depth.Y\0", b"transmittance.Y\0"):
            self.assertIn(channel, data)
        self.assertIn(".exr", self.fails(2, *words, "-o", self.path("y.png"), "--aov", "alpha,z"))
        self.assertIn("'depth' is none of", self.fails(2, *words, "-o", self.path("y.exr"), "--aov", "depth"))

    def test_alpha_is_straight_in_a_png_and_multiplied_in_an_exr(self):
        """Over black both are the picture without alpha; flames, which hide nothing, too."""
        def linear(value):
            return value / 255 / 12.92 if value <= 10 else ((value / 255 + 0.055) / 1.055) ** 2.4

        camera = ("--size", "24x24", "--eye", "0.5,-2,0.5", "--target", "0.5,0.5,0.5", "--fov", "40", "--exposure", "1")
        for name, look in (("smoke", ("--extinction", "4", "--emission", "1")), ("flame", ("--extinction", "0", "--emission", "4"))):
            with self.subTest(name):
                words = ("render", self.npy(name + ".npy"), *camera, *look, "--preset", "none")
                self.works(*words, "-o", self.path("x.png"))
                self.works(*words, "-o", self.path("a.png"), "--alpha")
                over, alphas = read_png(self.path("x.png").read_bytes())[2], set()
                data = self.path("a.png").read_bytes()
                self.assertIn(b"volute.alpha\0straight", data)
                for black, row in zip(over, read_png(data)[2], strict=True):
                    for x in range(24):
                        alpha = row[4 * x + 3] / 255
                        alphas.add(row[4 * x + 3])
                        for c in range(3):
                            self.assertAlmostEqual(linear(row[4 * x + c]) * alpha, linear(black[3 * x + c]), delta=0.012)
                self.assertIn(0, alphas, "the corners are empty")
                self.assertGreater(max(alphas), 150)
                self.works(*words, "-o", self.path("x.exr"))
                self.works(*words, "-o", self.path("a.exr"), "--alpha")
                plain, layered = (pictures.read_exr(self.path(file)) for file in ("x.exr", "a.exr"))
                self.assertEqual(layered.channels, 4)
                for p in range(24 * 24):
                    self.assertEqual(layered.values[4 * p:4 * p + 3], plain.values[3 * p:3 * p + 3])
                    self.assertTrue(0 <= layered.values[4 * p + 3] <= 1)
        self.assertIn("--alpha is for .png and .exr", self.fails(2, *words, "-o", self.path("x.mp4"), "--alpha"))
        self.fails(2, *words, "-o", self.path("x.png"), "--alpha", "--background", "1,1,1")

    def test_alpha_of_edges_is_their_coverage(self):
        pictures.write_png(self.path("white.png"), pictures.Picture(2, 2, 3, [1.0] * 12))
        self.path("sign.json").write_text(json.dumps({
            "format": "volute-scene-1", "media": [], "background": [0.2, 0.3, 0.4],
            "camera": {"eye": [0, -3, 0], "target": [0, 0, 0], "up": [0.13, 0, 1], "fov": 30, "size": [64, 64]},
            "signs": [{"name": "white", "position": [0, 0, 0], "normal": [0, -1, 0], "size": [0.9, 0.6], "picture": "white.png"}]}))
        self.works("render", self.path("sign.json"), "-o", self.path("x.png"), "--alpha", "--exposure", "1", "--tone", "none")
        pixels = [row[4 * x:4 * x + 4] for row in read_png(self.path("x.png").read_bytes())[2] for x in range(64)]
        self.assertGreaterEqual(len({pixel[3] for pixel in pixels}), 7, "eight rays")
        for pixel in pixels:
            self.assertGreaterEqual(min(pixel[:3]), 250 if pixel[3] else 0, "the sign is white wherever it is")

    def test_half_floats_are_within_their_rounding(self):
        words = ("render", self.npy("v.npy", 24), "--size", "64x64", "--emission", "7", "--extinction", "2")
        for more in ((), ("--alpha",)):
            self.works(*words, "-o", self.path("x.exr"), *more)
            self.works(*words, "-o", self.path("h.exr"), "--half", *more)
            full, half = (pictures.read_exr(self.path(file)).values for file in ("x.exr", "h.exr"))
            self.assertNotEqual(full, half)
            for value, rounded in zip(full, half, strict=True):
                self.assertAlmostEqual(value, rounded, delta=max(abs(value) / 2048, 6e-8))
            self.assertLess(self.path("h.exr").stat().st_size, 0.6 * self.path("x.exr").stat().st_size)
        self.works(*words, "-o", self.path("z.exr"), "--half", "--aov", "alpha,z", measured=False)
        listed = pictures.attributes(self.path("z.exr").read_bytes())[0]["channels"]
        self.assertEqual([entry[-16] for entry in pictures.split_channels(listed)], [1, 2], "depths stay floats")
        self.assertIn("--half is for .exr", self.fails(2, *words, "-o", self.path("x.png"), "--half"))
        for aov in ("optical-depth", "transmittance,z"):
            self.assertIn("measured and stays float32",
                          self.fails(2, *words, "-o", self.path("y.exr"), "--half", "--aov", aov))

    def test_what_half_floats_do_not_hold_is_told(self):
        words = ("render", self.npy("v.npy"), "-o", self.path("h.exr"), "--size", "16x16", "--preset", "none")
        for emission, said in (("1e6", "values are beyond 65504"), ("1e-9", "of them became 0")):
            self.assertIn(said, self.works(*words, "--emission", emission, "--half").message)
            self.assertNotIn("half float", self.works(*words, "--emission", emission).message)
        self.assertNotIn("half float", self.works(*words, "--half").message)

    def test_depths_of_what_is_lit_are_those_of_what_is_not(self):
        sun = [{"kind": "sun", "direction": [1, 0, -1], "radiance": [3, 3, 3]}]
        depths = []
        for more in ({}, {"albedo": [0.8, 0.8, 0.8], "lights": sun}):
            scene = self.scene(extinction=5, basis="trilinear", **more)
            self.works("render", scene, "-o", self.path("x.exr"), "--aov", "optical-depth", measured=False)
            depths.append(pictures.read_exr(self.path("x.exr")).values)
        self.assertGreater(max(depths[0]), 0.5)
        for plain, lit in zip(*depths):
            self.assertAlmostEqual(plain, lit, delta=1e-5)

    def test_a_frame_turns(self):
        self.works("render", self.npy("smoke.npy"), "-o", self.path("t_%03d.png"), "--size", "12x12", "--orbit", "36")
        self.assertEqual(len([name for name in self.files() if name.startswith("t_")]), 25)
        self.assertIn("--orbit", self.fails(2, "render", self.path("smoke.npy"), "-o", self.path("t.png"), "--orbit", "90"))

    def test_a_camera_goes_its_way(self):
        camera = {"eye": [0.5, -2, 0.5], "target": [0.5, 0.5, 0.5], "fov": 30, "size": [16, 16],
                  "keys": [[0, 0.5, -2, 0.5, 0.5, 0.5, 0.5], [0.4, 3, 0.5, 0.5, 0.5, 0.5, 0.5]]}
        scene = self.scene(emission=1, camera=camera)
        self.works("render", scene, "-o", self.path("k_%02d.png"))
        self.assertEqual(len([name for name in self.files() if name.startswith("k_")]), 11)
        # The same path in a file of its own, also with an orbit; and beside frames that end before.
        self.path("camera.json").write_text(json.dumps(camera))
        for more in ((), ("--orbit", "90")):
            said = self.works("render", self.path("v.npy"), "-o", self.path("c_%02d.png"), "--camera", self.path("camera.json"), *more)
            self.assertIn("11 pictures from 0 to 0.4 s", said.message)
        write_npy(self.path("two.npy"), (2, 4, 4, 4), [0.5] * 128)
        said = self.works("render", self.path("two.npy"), "-o", self.path("t_%02d.png"), "--camera", self.path("camera.json"))
        self.assertIn("the camera's path goes on until 0.4 s", said.message)
        camera["keys"].reverse()
        self.assertIn("/camera/keys", self.fails(1, "render", self.scene(camera=camera), "-o", self.path("x.png")))

    def test_one_exposure_for_a_sequence(self):
        values = ball(16)
        write_npy(self.path("grows.npy"), (3, 16, 16, 16), [0.01 * v for v in values] + values + [0.1 * v for v in values])
        said = self.works("render", self.path("grows.npy"), "-o", self.path("g_%d.png"), "--size", "16x16").message
        self.assertEqual(said.count("exposure"), 1)
        self.assertIn("from 3 of 3 pictures", said)
        light = [max(max(row) for row in read_png(self.path(f"g_{i}.png").read_bytes())[2]) for i in range(3)]
        self.assertGreater(light[1], light[2])
        self.assertGreater(light[2], light[0])

    def test_a_black_picture_is_told(self):
        write_npy(self.path("cold.npy"), (2, 8, 8, 8), [-v for v in 2 * ball(8)])
        said = self.works("render", self.path("cold.npy"), "-o", self.path("c_%d.png"), "--size", "8x8", "--preset", "none").message
        self.assertIn("all pictures that were tried are black", said)
        self.assertIn("sign of the values", said)


if __name__ == "__main__":
    support.main()
