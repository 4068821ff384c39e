# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Fog over frames as other renderers write them: names, units and infinities of depth, layers, parts, windows, alpha, soft edges."""
import json
import math
import struct
from random import Random

import support
from pictures import Part, exr_attribute, read_exr, write_parts, write_planes, write_png, write_rows, Picture

WIDTH, HEIGHT = 16, 12
INFINITY = float("inf")


def string(name, text):
    return exr_attribute(name, "string", text.encode())


class Frames(support.TestCase):
    """A white map under a camera inside it: T = exp(-sigma distance)."""

    def setUp(self):
        super().setUp()
        write_rows(self.path("map.png"), [[255] * 40] * 40)
        self.path("camera.json").write_text(json.dumps({"eye": [-100, 0, 5], "target": [0, 0, 5], "fov": 40}))
        self.depths = [5 + 3 * (i % WIDTH) + i // WIDTH for i in range(WIDTH * HEIGHT)]
        self.depths[7] = self.depths[40] = INFINITY
        self.color = {name: [0.1 * (c + 1) + 0.002 * i for i in range(WIDTH * HEIGHT)] for c, name in enumerate("RGB")}
        write_planes(self.path("color.exr"), WIDTH, HEIGHT, self.color)

    def words(self, *more, color="color.exr", depth="depth.exr", out="x.exr"):
        more += () if "--fog-color" in more else ("--fog-color", "0.5,0.6,0.7")
        return ("fog", self.path("map.png"), "--color", self.path(color), "--depth", self.path(depth), "--camera",
                self.path("camera.json"), "--origin=-200,-200,0", "--cell", "10", "--sigma-max", "0.02", "-o", self.path(out), *more)

    def plain(self, *more):
        """The picture with the same depth as one float channel, whose kind is said."""
        write_planes(self.path("plain.exr"), WIDTH, HEIGHT, {"Z": self.depths})
        self.works(*self.words("--depth-kind", "z", *more, depth="plain.exr", out="plain_out.exr"))

    def difference(self, a="x.exr", b="plain_out.exr"):
        return self.works("compare", self.path(a), self.path(b), "--json").json["max_error"]

    def assertAsPlain(self, *more, within=1e-6, **files):
        done = self.works(*self.words(*more, **files))
        self.assertLess(self.difference(), within)
        return done.message

    def sky(self, value):
        return [value if math.isinf(depth) else depth for depth in self.depths]

    def depth(self, planes, **more):
        write_parts(self.path("depth.exr"), [Part(WIDTH, HEIGHT, planes, **more)])

    def test_names_that_renderers_give_depth(self):
        self.plain()
        zero = [0.5] * (WIDTH * HEIGHT)
        rgb = {name: zero for name in "RGB"}
        vector = {f"ViewLayer.Normal.{axis}": zero for axis in "XYZ"}
        blender = {f"ViewLayer.Combined.{c}": zero for c in "RGBA"}
        for planes, more in (
                ({"Z": self.depths}, {}),
                ({"V": self.depths}, {}),
                ({"Depth.V": self.sky(1e10)}, {}),
                ({name: self.sky(1e10) for name in "RGB"}, {"more": string("Software", "Blender 4.2")}),
                (blender | vector | {"ViewLayer.Depth.Z": self.sky(1e10), "ViewLayer.Mist.Z": zero, "ViewLayer.Denoising Depth.Z": zero},
                 {"more": string("BlenderMultiChannel", "Blender V2.55.1 and newer")}),
                (rgb | {"A": zero, "Z": self.sky(1e30)}, {}),  # Arnold, V-Ray, RenderMan
                (rgb | {"A": zero, "depth.Z": self.sky(0)}, {}),  # Nuke
                (rgb | {"C.R": zero, "C.G": zero, "C.B": zero, "Pz": self.sky(0), "P.X": zero, "P.Y": zero, "P.Z": zero}, {}),  # Karma
                (rgb | {f"CryptoObject00.{c}": zero for c in "RGBA"} | {"Depth.Z": self.sky(3.4e38)}, {})):
            with self.subTest(sorted(planes)):
                self.depth(planes, **more)
                message = self.assertAsPlain()
                self.assertIn("5 to 61 m along the view axis", message)
                self.assertIn("1.04 % sky", message)

    def test_other_spellings_and_whole_pictures(self):
        self.plain()
        zero = [0.5] * (WIDTH * HEIGHT)
        for planes in ({f"Z-Depth.{c}": self.depths for c in "RGB"}, {f"VRayZDepth.{c}": self.depths for c in "RGB"},
                       {f"left.{c}": zero for c in "RGB"} | {"left.Z": self.depths}):
            with self.subTest(sorted(planes)):
                self.depth(planes)
                self.assertAsPlain()
        views = {f"{view}.{c}": self.color[c] for view in ("left", "right") for c in "RGB"}
        self.depth(views | {"left.Z": zero, "right.Z": self.depths})
        self.assertAsPlain("--color-layer", "right", color="depth.exr")
        self.depth({"SceneDepthWorldUnits.R": [100 * depth for depth in self.depths]})
        self.assertIn("centimetres, 0.01", self.fails(1, *self.words()))

    def test_inverse_depth(self):
        self.plain()
        self.depth({"depth.Z": [1 / depth if depth < 1e9 else 0 for depth in self.depths]})
        self.assertIn("inverse", self.works(*self.words()).message)
        self.assertIn("5 to 61 m along the view axis, by 1 / z, 1.04 % sky", self.assertAsPlain("--depth-kind", "inverse", within=1e-5))

    def test_what_no_frame_before_had_is_told(self):
        write_planes(self.path("d_0001.exr"), WIDTH, HEIGHT, {"Z": self.depths})
        write_planes(self.path("d_0002.exr"), WIDTH, HEIGHT, {"Z": self.depths})
        write_planes(self.path("d_0005.exr"), WIDTH, HEIGHT, {"Z": [0.0] * (WIDTH * HEIGHT)})
        for number in (1, 2, 5):
            write_planes(self.path(f"c_{number:04d}.exr"), WIDTH, HEIGHT, self.color)
        message = self.works(*self.words(color="c_%04d.exr", depth="d_%04d.exr", out="x_%04d.png")).message
        self.assertIn("2 of the frames 1 to 5 are missing: 3 to 4", message)
        self.assertIn("d_0005.exr: depth by channel 'Z': nothing but sky", message)
        self.assertNotIn("d_0002.exr", message)

    def test_a_depth_in_another_unit_is_told_where_it_begins(self):
        for number, factor in ((1, 1), (2, 100), (3, 1), (4, 2), (5, 100)):
            write_planes(self.path(f"d_{number:04d}.exr"), WIDTH, HEIGHT, {"Z": [factor * depth for depth in self.depths]})
            write_planes(self.path(f"c_{number:04d}.exr"), WIDTH, HEIGHT, self.color)
        words = self.words("--depth-kind", "z", color="c_%04d.exr", depth="d_%04d.exr", out="x_%04d.exr")
        message = self.works(*words).message
        self.assertIn("d_0002.exr: depth by channel 'Z': 500 to 6100 m along the view axis, 1.04 % sky; before it was 5 to 61 m", message)
        self.assertEqual(message.count("depth by channel"), 2)
        self.fails(1, *words, "--strict")
        self.works(*words, "--strict", "--frames", "3:5")

    def test_a_frame_without_colour_is_told(self):
        for number in (1, 2, 3):
            write_planes(self.path(f"d_{number:04d}.exr"), WIDTH, HEIGHT, {"Z": self.depths})
            if number != 2:
                write_planes(self.path(f"c_{number:04d}.exr"), WIDTH, HEIGHT, self.color)
        words = lambda *more: self.words(*more, color="c_%04d.exr", depth="d_%04d.exr", out="x_%04d.exr")
        text = "1 of the frames with a depth is missing, the first 2"
        self.assertIn(text, self.works(*words()).message)
        self.assertIn(text, self.works(*words("--frames", "1:4")).message)
        self.path("d_0002.exr").unlink()
        self.assertNotIn("missing", self.works(*words()).message)

    def test_each_eye_of_blender_has_its_depth(self):
        """Multilayer pictures of several views: the view's name stands before the channel's."""
        self.plain()
        zero = [0.5] * (WIDTH * HEIGHT)
        planes = {"ViewLayer.Mist.left.Z": zero, "ViewLayer.Mist.right.Z": zero}
        for view, color, depth in (("left", self.color, self.depths), ("right", dict.fromkeys("RGB", zero), zero)):
            planes |= {f"ViewLayer.Combined.{view}.{c}": color[c] for c in "RGB"}
            planes |= {f"ViewLayer.Depth.{view}.Z": depth} | {f"ViewLayer.Normal.{view}.{axis}": zero for axis in "XYZ"}
        self.depth(planes)
        message = self.assertAsPlain("--color-layer", "ViewLayer.Combined.left", color="depth.exr")
        self.assertIn("depth by channel 'ViewLayer.Depth.left.Z': 5 to 61 m along the view axis", message)
        self.assertNotIn("z is assumed", message)
        self.assertIn("'ViewLayer.Depth.right.Z'", self.works(*self.words("--color-layer", "ViewLayer.Combined.right", color="depth.exr")).message)
        self.assertIn("ViewLayer.Depth.left.Z, ViewLayer.Depth.right.Z; expected one", self.fails(1, *self.words()))

    def test_comparisons_see_alpha_and_other_channels(self):
        half, more = [0.5] * (WIDTH * HEIGHT), [0.9] * (WIDTH * HEIGHT)
        further = [depth + 1 for depth in self.depths]
        for name, planes in (("a", {"A": half}), ("b", {"A": more}), ("z", {"Z": self.depths}), ("y", {"Z": further}), ("l", {"Z": further, "L.V": half})):
            write_planes(self.path(f"{name}.exr"), WIDTH, HEIGHT, self.color | planes)
        said = lambda a, b, *options: self.works("compare", self.path(f"{a}.exr"), self.path(f"{b}.exr"), "--json", *options)
        for name in "abzyl":
            said(name, name, "--strict")
        self.assertIn("alpha differs by up to 0.4", said("a", "b").message)
        done = said("z", "y")
        self.assertEqual((done.json["rms"], done.json["channels_max_error"]), (0, {"Z": 1}))
        self.assertIn("channels differ: Z (by up to 1)", done.message)
        self.assertIn("l.exr alone has L.V", said("y", "l").message)
        for pair in ("ab", "zy", "yl"):
            self.fails(1, "compare", *(self.path(f"{name}.exr") for name in pair), "--strict")

    def test_a_fog_that_changes_nothing_is_told(self):
        self.depth({"Z": self.depths})
        self.assertIn("the fog changes no pixel", self.works(*self.words("--profile", "slab:1000,1010")).message)
        self.assertNotIn("the fog changes no pixel", self.works(*self.words()).message)
        self.assertIn("2 pictures that are the same", self.works(*self.words("--frames", "0:2", out="x_%04d.png")).message)
        self.assertNotIn("the same", self.works(*self.words("--frames", "0:2", "--wind", "1,0,0", out="x_%04d.png")).message)

    def test_overscan_that_depth_has_in_part(self):
        wide, high = WIDTH + 8, HEIGHT + 8
        display = (0, 0, WIDTH - 1, HEIGHT - 1)
        write_parts(self.path("color.exr"), [Part(wide, high, {name: [0.2] * (wide * high) for name in "RGB"}, data=(-4, -4, WIDTH + 3, HEIGHT + 3), display=display)])
        size = (WIDTH + 3) * (HEIGHT + 2)
        write_parts(self.path("depth.exr"), [Part(WIDTH + 3, HEIGHT + 2, {"Z": [20.0] * size}, data=(-2, 0, WIDTH, HEIGHT + 1), display=display)])
        message = self.works(*self.words()).message
        self.assertIn("cut off", message)
        self.assertNotIn("sky", message)
        self.assertEqual(struct.unpack("<4i", self.header("x.exr")["dataWindow"]), (-2, 0, WIDTH, HEIGHT + 1))

    def test_a_camera_of_other_pictures_is_told(self):
        """As Blender exports it for a frame of which it then renders a region."""
        gltf = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
                "nodes": [{"camera": 0, "translation": [-100, 5, 0], "rotation": [0, -0.5 ** 0.5, 0, 0.5 ** 0.5]}],
                "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1, "aspectRatio": WIDTH / HEIGHT}}]}
        self.depth({"Depth.V": self.sky(1e10)})
        words = [self.path("camera.gltf") if word == self.path("camera.json") else word for word in self.words()]
        self.path("camera.gltf").write_text(json.dumps(gltf))
        self.assertNotIn("as wide as high", self.works(*words).message)
        gltf["cameras"][0]["perspective"]["aspectRatio"] = 2 * WIDTH / HEIGHT
        self.path("camera.gltf").write_text(json.dumps(gltf))
        self.assertIn("its pictures are 2.67 times as wide as high", self.works(*words).message)

    def test_a_depth_that_is_no_picture_of_it(self):
        self.path("depth.jpg").write_bytes(b"\xff\xd8\xff")
        self.assertIn("expected the depth as .exr or .png", self.fails(1, *self.words("--depth-scale", "1", depth="depth.jpg")))

    def test_what_cannot_be_known_is_asked_for(self):
        zero = [1.0] * (WIDTH * HEIGHT)
        self.depth({"Z": self.depths})
        self.assertIn("does not say whether depths are along the view axis (z) or from the eye (ray); z is assumed; choose one with --depth-kind",
                      self.works(*self.words()).message)
        self.assertNotIn("does not say", self.works(*self.words("--depth-kind", "ray")).message)
        self.depth({"A.Depth.Z": self.depths, "B.Depth.Z": zero})
        self.assertIn("A.Depth.Z, B.Depth.Z; expected one; choose one with --depth-channel", self.fails(1, *self.words()))
        self.plain()
        self.assertAsPlain("--depth-channel", "A.Depth.Z")
        self.assertIn("has no channel 'C'", self.fails(1, *self.words("--depth-channel", "C")))
        self.depth({"N.X": zero, "N.Y": zero, "N.Z": zero})
        self.assertIn("N.X, N.Y, N.Z", self.fails(1, *self.words()))
        for name in ("ViewLayer.Mist.Z", "Mist.V", "mist"):
            self.depth({name: [min(depth, 100) / 100 for depth in self.depths]})
            self.assertIn(f"{name}, which is 0 to 1 between two distances; expected a depth", self.fails(1, *self.words()))
        self.depth({"R": self.depths, "G": zero, "B": self.depths})
        self.assertIn("R, G and B are not the same", self.fails(1, *self.words()))

    def test_units(self):
        self.plain()
        centimetres = [100 * depth for depth in self.depths]
        self.depth({"FinalImageMovieRenderQueue_WorldDepth.R": centimetres})
        self.assertIn("centimetres, 0.01; give --depth-scale", self.fails(1, *self.words()))
        self.assertAsPlain("--depth-scale", "0.01")
        self.depth({"Z": [depth / 1000 for depth in self.depths]})
        self.assertIn("within 0.061 m of the eye; depths may be normalised, in another unit, or 1 / z; --depth-scale says how many "
                      "metres a unit is, or --depth-kind inverse takes them for 1 / z", self.works(*self.words()).message)
        self.assertAsPlain("--depth-scale", "1000", within=1e-5)

    def test_half_floats_within_their_rounding(self):
        self.plain()
        for sky in (INFINITY, 65504.0):
            self.depth({"Z": self.sky(sky)}, half=("Z",))
            self.assertAsPlain(within=0.02 * 61 * 2 ** -11)

    def test_distances_from_the_eye(self):
        pixel = 2 * math.tan(math.radians(20)) / HEIGHT
        along = [depth * math.hypot(1, (i % WIDTH + 0.5 - WIDTH / 2) * pixel, (i // WIDTH + 0.5 - HEIGHT / 2) * pixel)
                 for i, depth in enumerate(self.depths)]
        self.plain()
        self.depth({"distance.Y": along})
        self.assertAsPlain()
        self.depth({"Z": along})
        self.assertAsPlain("--depth-kind", "ray")

    def test_pictures_of_depth_need_a_scale(self):
        self.plain()
        rows = [[round(10 * self.depths[y * WIDTH + x]) if self.depths[y * WIDTH + x] < 1e9 else 0 for x in range(WIDTH)] for y in range(HEIGHT)]
        write_rows(self.path("depth.png"), rows, 16)
        message = self.fails(1, *self.words(depth="depth.png"))
        self.assertIn("a .png has no metres", message)
        self.assertAsPlain("--depth-scale", "0.1", depth="depth.png")
        write_rows(self.path("depth.png"), [sum(([x, x, 9] for x in row), []) for row in rows], 16, channels=3)
        self.assertIn("in colours", self.fails(1, *self.words("--depth-scale", "1", depth="depth.png")))

    def test_the_largest_half_is_a_depth_in_a_picture(self):
        self.depths = [65.504] * (WIDTH * HEIGHT)
        self.plain()
        write_rows(self.path("depth.png"), [[65504] * WIDTH] * HEIGHT, 16)
        self.assertNotIn("sky", self.assertAsPlain("--depth-scale", "0.001", depth="depth.png", within=1e-5))

    def test_layers_and_parts(self):
        self.plain()
        other = [9.0] * (WIDTH * HEIGHT)
        layers = {f"ViewLayer.Combined.{c}": self.color[c] for c in "RGB"} | {f"ViewLayer.DiffCol.{c}": other for c in "RGB"}
        self.depth(layers | {"ViewLayer.Depth.Z": self.sky(1e10)})
        self.assertAsPlain(color="depth.exr")
        self.depth(layers | {f"Composite.Combined.{c}": other for c in "RGB"} | {"ViewLayer.Depth.Z": self.sky(1e10)})
        self.assertAsPlain("--color-layer", "ViewLayer.Combined", color="depth.exr")
        write_parts(self.path("depth.exr"), [Part(WIDTH, HEIGHT, {"R": other, "G": other, "B": other}, "albedo"),
                                             Part(WIDTH, HEIGHT, self.color, "rgba"),
                                             Part(WIDTH, HEIGHT, {"Z": self.depths}, "depth")])
        self.assertAsPlain(color="depth.exr")
        self.depth({f"{name}.{c}": other for name in ("left", "right") for c in "RGB"})
        self.assertIn("has the layers left, right", self.fails(1, *self.words(color="depth.exr")))
        self.assertIn("no layer 'x'", self.fails(1, *self.words("--color-layer", "x", color="depth.exr")))

    def test_a_picture_of_several_parts_is_refused_where_nobody_chooses_one(self):
        self.plain()
        parts = [Part(WIDTH, HEIGHT, self.color, name) for name in ("left", "right")]
        write_parts(self.path("parts.exr"), parts)
        text = "parts.exr: has 2 parts with the channels left.B, left.G, left.R, right.B, right.G, right.R; expected one part"
        self.assertIn(text, self.fails(1, "info", self.path("parts.exr")))
        self.assertIn(text, self.fails(1, "compare", self.path("color.exr"), self.path("parts.exr")))

    def test_depth_outside_its_data_window_is_sky(self):
        self.depths = [INFINITY if y < 2 or x > 12 else self.depths[y * WIDTH + x] for y in range(HEIGHT) for x in range(WIDTH)]
        self.plain()
        some = [self.depths[y * WIDTH + x] for y in range(2, HEIGHT) for x in range(13)]
        write_parts(self.path("depth.exr"), [Part(13, HEIGHT - 2, {"Z": some}, data=(0, 2, 12, HEIGHT - 1), display=(0, 0, WIDTH - 1, HEIGHT - 1))])
        self.assertIn("% sky", self.assertAsPlain())

    def header(self, name):
        data = self.path(name).read_bytes()
        found, at = {}, 8
        while data[at]:
            key, _, rest = data[at:].partition(b"\0")
            kind, _, rest = rest.partition(b"\0")
            (size,) = struct.unpack_from("<i", rest)
            found[key.decode()] = rest[4:4 + size]
            at += len(key) + len(kind) + 6 + size
        return found

    def test_alpha_windows_aspect_and_attributes_stay(self):
        wide, high = WIDTH + 8, HEIGHT + 8
        window, display = (-4, -4, WIDTH + 3, HEIGHT + 3), (0, 0, WIDTH - 1, HEIGHT - 1)
        planes = {name: [0.2] * (wide * high) for name in "RGB"} | {"A": [0.5] * (wide * high)}
        depth = [20.0] * (wide * high)
        write_parts(self.path("color.exr"), [Part(wide, high, planes, data=window, display=display, aspect=2.0, more=string("owner", "me"))])
        write_parts(self.path("depth.exr"), [Part(wide, high, {"Z": depth}, data=window, display=display, aspect=2.0)])
        self.works(*self.words("--depth-kind", "z"))
        header = self.header("x.exr")
        self.assertEqual(struct.unpack("<4i", header["dataWindow"]), window)
        self.assertEqual(struct.unpack("<4i", header["displayWindow"]), display)
        self.assertEqual(struct.unpack("<f", header["pixelAspectRatio"]), (2.0,))
        self.assertEqual(header["owner"], b"me")
        self.assertIn(b"A\0", header["channels"])
        self.works(*self.words("--depth-kind", "z", "--half", out="h.exr"))
        for full, half in zip(read_exr(self.path("x.exr")).values, read_exr(self.path("h.exr")).values, strict=True):
            self.assertAlmostEqual(full, half, delta=full / 2048)
        # A pixel is 2 wide: the corner's ray, and fog over a half transparent frame.
        pixel = 2 * math.tan(math.radians(20)) / HEIGHT
        stretch = math.hypot(1, 2 * (0.5 - WIDTH / 2) * pixel, (0.5 - HEIGHT / 2) * pixel)
        passed = math.exp(-0.02 * 20 * stretch)
        write_parts(self.path("flat.exr"), [Part(wide, high, {name: planes[name] for name in "RGB"}, data=window, display=display, aspect=2.0)])
        self.works(*self.words("--depth-kind", "z", "--fog-color", "0,0,0", color="flat.exr", out="dark.exr"))
        self.assertAlmostEqual(read_exr(self.path("dark.exr")).at(4, 4), 0.2 * passed, delta=2e-6)
        self.assertIn("does not keep pixels outside the display window", self.works(*self.words(out="x.png")).message)
        self.depth({"Z": [20.0] * (WIDTH * HEIGHT)})
        self.assertIn("cut off", self.works(*self.words()).message)
        self.assertEqual(struct.unpack("<4i", self.header("x.exr")["dataWindow"]), display)

    def test_frames_keep_their_primaries(self):
        aces = (0.7347, 0.2653, 0, 1, 0.0001, -0.077, 0.32168, 0.33767)
        black = {name: [0.0] * (WIDTH * HEIGHT) for name in "RGB"}
        self.depth({"Z": self.depths})
        more = exr_attribute("chromaticities", "chromaticities", struct.pack("<8f", *aces))
        write_parts(self.path("aces.exr"), [Part(WIDTH, HEIGHT, black, more=more)])
        write_planes(self.path("black.exr"), WIDTH, HEIGHT, black)
        for out in ("x.exr", "x.png"):
            self.works(*self.words("--fog-color", "1,0,0", "--depth-kind", "z", color="aces.exr", out=out))
            self.works(*self.words("--fog-color", "1,0,0", "--depth-kind", "z", color="black.exr", out="plain_" + out))
        there, plain = read_exr(self.path("x.exr")), read_exr(self.path("plain_x.exr"))
        light = plain.values[0]
        self.assertGreater(light, 0.01)
        # The red of Rec. 709 in ACES2065-1, by Bradford's adaptation.
        for found, share in zip(there.values, (0.4397, 0.0898, 0.0175)):
            self.assertAlmostEqual(found / light, share, delta=1e-3)
        self.assertEqual(struct.unpack("<8f", self.header("x.exr")["chromaticities"]), struct.unpack("<8f", struct.pack("<8f", *aces)))
        self.assertEqual(self.path("x.png").read_bytes(), self.path("plain_x.png").read_bytes())
        # What spans no colours matters to depths as little as their primaries do.
        more = exr_attribute("chromaticities", "chromaticities", bytes(32))
        write_parts(self.path("depth.exr"), [Part(WIDTH, HEIGHT, {"Z": self.depths}, more=more)])
        self.works(*self.words("--depth-kind", "z", color="black.exr"))
        write_parts(self.path("none.exr"), [Part(WIDTH, HEIGHT, black, more=more)])
        self.assertIn("none.exr", self.fails(1, *self.words("--depth-kind", "z", color="none.exr")))

    def test_the_fog_alone_is_a_layer(self):
        self.depth({"Z": self.depths})
        self.works(*self.words("--edges", "hard"))
        foggy = read_exr(self.path("x.exr"))
        self.works(*self.words("--edges", "hard", "--fog-only", out="layer.png"))
        self.works(*self.words("--edges", "hard", "--fog-color", "1,1,1", "--fog-only"))
        self.assertIn(b"A\0", self.header("x.exr")["channels"])
        write_planes(self.path("color.exr"), WIDTH, HEIGHT, {name: [0.0] * (WIDTH * HEIGHT) for name in "RGB"})
        self.works(*self.words("--edges", "hard", out="dark.exr"))
        dark = read_exr(self.path("dark.exr"))
        for i in range(WIDTH * HEIGHT):
            for c, fog in enumerate((0.5, 0.6, 0.7)):  # the layer's alpha is its light / the colour of thick fog
                alpha = dark.values[3 * i + c] / fog
                self.assertAlmostEqual(self.color["RGB"[c]][i] * (1 - alpha) + dark.values[3 * i + c], foggy.values[3 * i + c], delta=3e-6)

    def test_edges_stay_soft(self):
        """A near dark surface before a far bright one, whose slanted border is antialiased."""
        across, n = 8, 4

        def covered(x, y, side):  # the near surface's share of a pixel
            inside = sum((x + (i + 0.5) / side) + 0.37 * (y + (j + 0.5) / side) < 9.3 for i in range(side) for j in range(side))
            return inside / side ** 2

        self.path("camera.json").write_text(json.dumps({"eye": [-100, 0, 5], "target": [0, 0, 5], "fov": 1}))
        near, far, sigma, fog = 10.0, 80.0, 0.02, 0.6
        shares = [covered(x, y, across) for y in range(HEIGHT) for x in range(WIDTH)]
        shades = [0.1 * share + 0.9 * (1 - share) for share in shares]
        write_planes(self.path("color.exr"), WIDTH, HEIGHT, {name: shades for name in "RGB"})
        self.depth({"Z": [near if covered(x, y, 1) else far for y in range(HEIGHT) for x in range(WIDTH)]})
        fine = [near if (x + 0.5) / n + 0.37 * (y + 0.5) / n < 9.3 else far for y in range(n * HEIGHT) for x in range(n * WIDTH)]
        write_planes(self.path("fine.exr"), n * WIDTH, n * HEIGHT, {"Z": fine})
        seen = lambda light, distance: light * math.exp(-sigma * distance) + fog * (1 - math.exp(-sigma * distance))
        ends = seen(0.1, near), seen(0.9, far)
        truth = [share * ends[0] + (1 - share) * ends[1] for share in shares]

        def off(*more, depth):
            """How far the border is from where it is, in pixels, at most: of a row's sum."""
            self.works(*self.words("--fog-color", f"{fog},{fog},{fog}", *more, depth=depth))
            picture = read_exr(self.path("x.exr"))
            rows = [sum(picture.at(x, y) - truth[y * WIDTH + x] for x in range(WIDTH)) / (ends[0] - ends[1]) for y in range(2, HEIGHT - 2)]
            return max(abs(row) for row in rows)

        self.assertGreater(off("--edges", "hard", depth="depth.exr"), 0.1)
        self.assertLess(off(depth="depth.exr"), 0.05)
        self.assertLess(off(depth="fine.exr"), 0.05)

    def test_edges_stay_soft_over_ground_up_to_the_horizon(self):
        """A post before ground, whose depth grows from row to row, and before the sky: three surfaces around a pixel; and a thin post."""
        side, horizon, sigma, fog = 8, 4, 0.02, (0.6, 0.7, 0.8)
        self.path("camera.json").write_text(json.dumps({"eye": [-100, 0, 5], "target": [0, 0, 5], "fov": 1}))
        looks = {"post": (0.1, 0.1, 0.12), "ground": (0.3, 0.33, 0.2), "sky": (0.2, 0.3, 0.6)}

        def seen(x, y):
            if 4.3 + 0.05 * y < x < 8.4 + 0.05 * y or 12.2 < x < 13.4:
                return "post", 20.0
            return ("sky", 1e10) if y < horizon else ("ground", 200 / (y - horizon + 0.4))

        def through(name, z):
            passed = math.exp(-sigma * min(z, 300))  # where the map ends
            return [passed * light + (1 - passed) * f for light, f in zip(looks[name], fog)]

        inside = [[seen(x + (i + 0.5) / side, y + (j + 0.5) / side) for i in range(side) for j in range(side)] for y in range(HEIGHT) for x in range(WIDTH)]
        mean = lambda values: [sum(value[c] for value in values) / side ** 2 for c in range(3)]
        clear = [mean([looks[name] for name, z in pixel]) for pixel in inside]
        truth = [mean([through(*one) for one in pixel]) for pixel in inside]
        write_planes(self.path("color.exr"), WIDTH, HEIGHT, {name: [pixel[c] for pixel in clear] for c, name in enumerate("RGB")})
        self.depth({"Z": [seen(x + 0.5, y + 0.5)[1] for y in range(HEIGHT) for x in range(WIDTH)]})
        n = 4
        write_planes(self.path("fine.exr"), n * WIDTH, n * HEIGHT,
                     {"Z": [seen((x + 0.5) / n, (y + 0.5) / n)[1] for y in range(n * HEIGHT) for x in range(n * WIDTH)]})

        def off(*more, columns, depth="depth.exr", rows=range(HEIGHT)):
            """The largest error of a pixel."""
            self.works(*self.words("--fog-color", ",".join(map(str, fog)), *more, depth=depth))
            picture = read_exr(self.path("x.exr"))
            return max(abs(picture.at(x, y, c) - truth[y * WIDTH + x][c]) for x in columns for y in rows for c in range(3))

        self.assertGreater(off("--edges", "hard", columns=range(2, 11)), 0.1)
        self.assertLess(off(columns=range(2, 11), rows=[y for y in range(HEIGHT) if y != horizon]), 0.04)
        self.assertLess(off(columns=(1, 2, 10, 11), rows=[horizon]), 0.01)  # ground with another row's fog would be a line
        self.assertLess(off(columns=range(2, 16), depth="fine.exr"), 0.04)

    def test_colours_that_hardly_differ_say_nothing_of_edges(self):
        """A near surface before a far one of nearly its colour: by noise, float32 and 8 bits no pixel may change to the surface that it does not show."""
        self.path("camera.json").write_text(json.dumps({"eye": [-100, 0, 5], "target": [0, 0, 5], "fov": 1}))
        side, sigma, fog = 8, 0.02, 0.9
        at = lambda x, y: 10.0 if x + 0.37 * y < 9.3 else 80.0
        self.depth({"Z": [at(x + 0.5, y + 0.5) for y in range(HEIGHT) for x in range(WIDTH)]})
        seen = [[at(x + (i + 0.5) / side, y + (j + 0.5) / side) for i in range(side) for j in range(side)] for y in range(HEIGHT) for x in range(WIDTH)]
        near = [sum(z == 10.0 for z in pixel) / side ** 2 for pixel in seen]
        passed = [sum(math.exp(-sigma * z) for z in pixel) / side ** 2 for pixel in seen]
        random = Random(7)

        def off(color, *more):
            self.works(*self.words("--fog-color", f"{fog},{fog},{fog}", *more, color=color))
            picture, clear = read_exr(self.path("x.exr")), self.shown
            errors = [picture.at(i % WIDTH, i // WIDTH, 0) - (passed[i] * clear[i] + (1 - passed[i]) * fog) for i in range(WIDTH * HEIGHT)]
            return max(map(abs, errors)), sum(error * error for error in errors)

        for noise in (0, 1e-7, 0.001, 0.01):
            with self.subTest(noise):
                self.shown = [0.3 * (1 + noise * random.gauss(0, 1)) for i in range(WIDTH * HEIGHT)]
                write_planes(self.path("color.exr"), WIDTH, HEIGHT, {name: self.shown for name in "RGB"})
                soft, hard = off("color.exr"), off("color.exr", "--edges", "hard")
                self.assertGreater(hard[0], 0.1)
                self.assertLess(soft[0], 1.1 * hard[0])
                self.assertLess(soft[1], 1.1 * hard[1])
        # A step of an 8-bit picture apart: 148 and 149.
        stored = [148 + (share + random.random() >= 1) for share in near]
        write_rows(self.path("color.png"), [stored[WIDTH * y:WIDTH * (y + 1)] for y in range(HEIGHT)])
        self.shown = [((shade / 255 + 0.055) / 1.055) ** 2.4 for shade in stored]
        soft, hard = off("color.png"), off("color.png", "--edges", "hard")
        self.assertLess(soft[0], 1.1 * hard[0])
        self.assertLess(soft[1], 1.1 * hard[1])
        # What differs clearly is taken apart all the same.
        self.shown = [0.33 * share + 0.3 * (1 - share) for share in near]
        write_planes(self.path("color.exr"), WIDTH, HEIGHT, {name: self.shown for name in "RGB"})
        through = lambda light, z: math.exp(-sigma * z) * light + (1 - math.exp(-sigma * z)) * fog
        self.works(*self.words("--fog-color", f"{fog},{fog},{fog}"))
        picture = read_exr(self.path("x.exr"))
        self.assertLess(max(abs(picture.at(i % WIDTH, i // WIDTH, 0) - near[i] * through(0.33, 10) - (1 - near[i]) * through(0.3, 80))
                            for i in range(WIDTH * HEIGHT) if 2 <= i // WIDTH < HEIGHT - 2), 0.01)

    def test_visible_pictures_are_dithered(self):
        wide = 480
        self.path("camera.json").write_text(json.dumps({"eye": [-100, 0, 5], "target": [0, 0, 5], "ortho": 2}))
        write_planes(self.path("color.exr"), wide, 8, {name: [0.0] * (wide * 8) for name in "RGB"})
        write_planes(self.path("depth.exr"), wide, 8, {"Z": [0.1 + 40 * x / wide for y in range(8) for x in range(wide)]})
        self.works(*self.words("--fog-color", "0.012,0.012,0.012", out="x.png"))
        self.works(*self.words("--fog-color", "0.012,0.012,0.012", out="x.exr"))
        smooth = read_exr(self.path("x.exr"))
        write_png(self.path("rounded.png"), Picture(wide, 8, 3, smooth.values))
        self.assertGreater(self.difference("x.png", "rounded.png"), 0)


if __name__ == "__main__":
    support.main()
