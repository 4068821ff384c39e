# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Pictures: sizes, formats, cameras, exposures, statistics."""
import json
import math
import struct
import zlib

import support
from support import volute, write_npy


def read_png(data):
    """(width, height, rows of bytes) of an 8-bit RGB, RGBA or grey file without interlacing."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    width, height, depth, kind = struct.unpack_from(">IIBB", data, 16)
    assert depth == 8 and kind in (0, 2, 6)
    packed, place = b"", 8
    while place < len(data):
        (length,) = struct.unpack_from(">I", data, place)
        if data[place + 4:place + 8] == b"IDAT":
            packed += data[place + 8:place + 8 + length]
        place += 12 + length
    raw, step = zlib.decompress(packed), {0: 1, 2: 3, 6: 4}[kind]
    rows, above = [], bytes(width * step)
    for y in range(height):
        line = bytearray(raw[y * (width * step + 1) + 1:(y + 1) * (width * step + 1)])
        method = raw[y * (width * step + 1)]
        for i in range(len(line)):
            left = line[i - step] if i >= step else 0
            corner = above[i - step] if i >= step else 0
            guess = left + above[i] - corner
            paeth = min((left, above[i], corner), key=lambda v: abs(guess - v))
            line[i] = (line[i] + (0, left, above[i], (left + above[i]) // 2, paeth)[method]) & 255
        above = bytes(line)
        rows.append(above)
    return width, height, rows


def srgb8(linear):
    encoded = 12.92 * linear if linear <= 0.0031308 else 1.055 * linear ** (1 / 2.4) - 0.055
    return round(255 * min(max(encoded, 0), 1))


class Render(support.TestCase):
    def block(self):
        """A cube of 1 m with the value 0.5 everywhere."""
        write_npy(self.path("block.npy"), (3, 4, 4, 4), [0.5] * 192)
        return self.path("block.npy")

    AHEAD = ["--eye", "0.5,-3,0.5", "--target", "0.5,0.5,0.5", "--ortho", "0.5", "--size", "6x6"]

    def test_a_block_has_the_radiance_it_must(self):
        self.works("render", self.block(), "-o", self.path("x.png"), *self.AHEAD, "--exposure", "1", "--measured")
        width, height, rows = read_png(self.path("x.png").read_bytes())
        self.assertEqual((width, height), (6, 6))
        self.assertEqual({value for row in rows for value in row}, {srgb8(0.5)})

    def test_a_picture_of_a_sequence_shows_a_frame_with_something_to_see(self):
        write_npy(self.path("late.npy"), (8, 4, 4, 4), [0.0] * 192 + [0.01] * 64 + [0.5] * 256)
        result = self.works("render", self.path("late.npy"), "-o", self.path("x.png"), *self.AHEAD,
                            "--exposure", "1", "--measured")
        self.assertIn("showing frame 4: of 8 times looked at", result.message)
        self.assertEqual({value for row in read_png(self.path("x.png").read_bytes())[2] for value in row}, {srgb8(0.5)})
        self.assertIn("showing the first of 3 frames",
                      self.works("render", self.block(), "-o", self.path("y.png"), "--size", "8x8").message)

    def test_a_film_needs_less_memory_than_the_volume(self):
        """No dense copy of all frames is ever in memory, whether rows of frames are decoded or a tree is read."""
        self.measures_memory()
        size, frames = 64, 160
        _, values = support.plume(1, size)
        write_npy(self.path("long.npy"), (frames, size, size, size), values, frames)
        self.works("compress", self.path("long.npy"), "-o", self.path("long.volute"), "--rms", "0.003", "--fast")
        for method in ("bricks", "tree"):
            self.works("render", self.path("long.volute"), "-o", self.path(f"{method}_%04d.png"), "--frames", "0:160:20",
                       "--size", "64x64", "--renderer", "cpu", "--volume-method", method, "--stats", self.path("stats.json"))
            stats = json.loads(self.path("stats.json").read_text())
            self.assertLess(stats["peak_memory_bytes"], 4 * frames * size**3 / 2)
            self.assertEqual(stats["nodes_visited"] > 0, method == "tree")
            self.assertLess(stats["tree_bytes"], 4 * frames * size**3 / 10)

    def test_a_volute_is_shown_as_it_is_extracted(self):
        write_npy(self.path("short.npy"), *support.plume(3, 24))
        self.works("compress", self.path("short.npy"), "-o", self.path("short.volute"), "--rms", "0.02")
        self.works("extract", self.path("short.volute"), "-o", self.path("back_%04d.vti"))
        for frame, options in (("0", ["--aov", "optical-depth"]), ("2", ["--renderer", "reference"])):
            pictures = []
            for source in ("short.volute", "back_%04d.vti"):
                self.works("render", self.path(source), "-o", self.path("x.exr"), "--size", "64x48", "--frames", frame, *options)
                pictures.append(self.path("x.exr").read_bytes())
            self.assertEqual(*pictures, "to the last bit")

    def test_absorption_and_background(self):
        self.works("render", self.block(), "-o", self.path("x.png"), *self.AHEAD, "--exposure", "1", "--emission", "0",
                   "--extinction", "2", "--background", "1,0.5,0", "--measured")
        row = read_png(self.path("x.png").read_bytes())[2][3]
        through = math.exp(-1)
        self.assertEqual(tuple(row[:3]), (srgb8(through), srgb8(0.5 * through), 0))

    def test_optical_depth_needs_no_more_options(self):
        self.works("render", self.block(), "-o", self.path("x.exr"), *self.AHEAD, "--aov", "optical-depth")
        info = self.works("info", self.path("x.exr"), "--json").json
        self.assertEqual(info["channels"], 1)
        self.assertAlmostEqual(info["minimum"], 0.5, places=5)
        self.assertAlmostEqual(info["maximum"], 0.5, places=5)

    def test_renderers_agree(self):
        packed = self.make_volute(channels=3)
        for renderer in ("cpu", "reference"):
            self.works("render", packed, "-o", self.path(f"{renderer}.exr"), "--size", "24x18", "--renderer", renderer)
        said = self.works("compare", self.path("reference.exr"), self.path("cpu.exr"), "--json").json
        self.assertLess(said["max_error"], 1e-4)

    def test_stills_are_named_by_frame(self):
        self.works("render", self.block(), "-o", self.path("s_%03d.png"), "--size", "4x4", "--frames", "1:3")
        self.assertEqual(self.files(), ["block.npy", "s_001.png", "s_002.png"])
        self.assertIn("%04d", self.fails(2, "render", self.block(), "-o", self.path("s.png"), "--frames", "0:3"))

    def test_times_choose_the_frame_that_is_held(self):
        write_npy(self.path("t.npy"), (2, 1, 1, 1), [0.1, 0.9])
        for time, value in (("0.039", 0.1), ("0.041", 0.9), ("0", 0.1), ("0.079", 0.9)):
            self.works("render", self.path("t.npy"), "-o", self.path("x.exr"), "--time", time, *self.AHEAD)
            self.assertAlmostEqual(self.works("info", self.path("x.exr"), "--json").json["maximum"], value, places=6)
        self.assertIn("-5 s is before the begin", self.fails(2, "render", self.path("t.npy"), "-o", self.path("x.exr"), "--time", "-5", *self.AHEAD))

    def test_partial_that_changes_nothing_is_refused(self):
        words = ["--partial", "--size", "8x8"]
        for more in [["--frames", "0:2", "-o", self.path("s%d.png")], ["-o", self.path("d.exr"), "--aov", "optical-depth"],
                     ["-o", self.path("a.exr"), "--aov", "beauty,alpha"]]:
            self.assertIn("--partial changes nothing here", self.fails(2, "render", self.block(), *words, *more))
        self.works("render", self.block(), *words, "-o", self.path("x.png"))
        self.works("render", self.make_volute(frames=2), *words, "-o", self.path("v%d.png"), "--frames", "0:2")

    def test_times_past_the_end_are_refused(self):
        write_npy(self.path("t.npy"), (2, 1, 1, 1), [0.1, 0.9])
        words = ("render", self.path("t.npy"), "-o", self.path("x.exr"), *self.AHEAD, "--time")
        self.assertIn("--time: 99 s is past the end", self.fails(2, *words, "99"))
        self.assertIn("t.npy has 2 frames from 0 to 0.04 s", self.fails(2, *words, "0.09"))
        write_npy(self.path("t.npy"), (1, 1, 1, 1), [0.1])  # a lone frame holds for ever
        self.works(*words, "99")

    def test_films_say_how_much_is_to_come(self):
        result = self.works("render", self.block(), "-o", self.path("s_%03d.png"), "--size", "4x4")
        self.assertIn("s_%03d.png: 3 pictures from 0 to 0.08 s", result.message)
        result = volute("render", self.block(), "-o", self.path("x.mp4"), "--size", "32x32")
        if "this build has no" not in result.message:
            self.assertIn("3 pictures from 0 to 0.08 s, 25 a second: a film of 0.12 s", result.message)
            self.assertNotIn("even numbers", result.message)
            odd = self.works("render", self.block(), "-o", self.path("x.mp4"), "--size", "33x32")
            self.assertIn("x.mp4: is 34 x 32 pixels, for films have even numbers of them", odd.message)

    def test_camera_files(self):
        camera = {"eye": [0.5, -3, 0.5], "target": [0.5, 0.5, 0.5], "up": [0, 0, 1], "ortho": 0.5, "size": [6, 6]}
        self.path("camera.json").write_text(json.dumps(camera))
        self.works("render", self.block(), "-o", self.path("a.exr"), "--camera", self.path("camera.json"))
        self.works("render", self.block(), "-o", self.path("b.exr"), *self.AHEAD)
        self.assertEqual(self.path("a.exr").read_bytes(), self.path("b.exr").read_bytes())
        self.path("camera.json").write_text(json.dumps(camera | {"eye": [0, "x", 0]}))
        self.assertIn("/eye[1]", self.fails(1, "render", self.block(), "-o", self.path("c.png"), "--camera",
                                            self.path("camera.json")))
        self.path("camera.json").write_text(json.dumps(camera | {"sizE": [9, 9]}))
        self.assertIn("sizE: this name is unknown; did you mean 'size'?",
                      self.fails(1, "render", self.block(), "-o", self.path("c.png"), "--camera", self.path("camera.json")))
        self.path("camera.json").write_text('{"eye": [0,\n 0')
        self.assertIn("line 2", self.fails(1, "render", self.block(), "-o", self.path("c.png"), "--camera",
                                           self.path("camera.json")))

    def test_films(self):
        for extension in ("mp4", "webm"):
            made = volute("render", self.block(), "-o", self.path(f"x.{extension}"), "--size", "32x32")
            if "this build has no" in made.message:
                continue
            self.assertEqual(made.code, 0, made.message)
            self.assertGreater(self.path(f"x.{extension}").stat().st_size, 100)

    def test_stages_run_at_once_and_give_the_same(self):
        """Reading, drawing and encoding of several pictures: the same bytes on one thread, and each stage's share."""
        volume = self.make_volute(frames=6)
        targets = [("%04d.png", sorted)]
        if "this build has no" not in volute("render", self.block(), "-o", self.path("a.mp4"), "--size", "32x32").message:
            targets.append(("x.mp4", list))
        for name, _ in targets:
            found = []
            for threads in (1, 3):
                folder = self.path(f"{threads}")
                folder.mkdir(exist_ok=True)
                self.works("render", volume, "-o", folder / name, "--size", "48x32", "--frames", "0:6", "--threads", threads, "--preset", "smoke",
                           "--stats", self.path("s.json"))
                found.append({file.name: file.read_bytes() for file in folder.iterdir()})
                stats = json.loads(self.path("s.json").read_text())
                self.assertEqual(stats["pictures"], 6)
                self.assertAlmostEqual(sum(stats["stages"][key] for key in ("read", "draw", "convert", "encode")), 1, places=6)
                self.assertEqual(stats["cores"]["threads"], threads)
                self.assertGreater(stats["cores"]["busy"], 0)
            self.assertEqual(found[0], found[1])
        # A stage that fails ends all of them.
        self.path("taken").mkdir()
        self.path("taken/0003.png").mkdir()
        self.fails(1, "render", volume, "-o", self.path("taken") / "%04d.png", "--size", "48x32", "--frames", "0:6", "--threads", 3)

    def test_statistics(self):
        self.works("render", self.make_volute(), "-o", self.path("x.png"), "--size", "8x8", "--stats", self.path("s.json"),
                   "--measured")
        stats = json.loads(self.path("s.json").read_text())
        self.assertEqual(stats["rays"], 64)
        for key in ("voxels_visited", "bricks_visited", "peak_memory_bytes", "bytes_read"):
            self.assertGreater(stats[key], 0, key)

    def test_colour_maps_are_for_one_channel(self):
        done = self.works("render", self.block(), "-o", self.path("x.png"), "--size", "4x4", "--colormap", "viridis")
        self.assertRegex(done.message, "the colours are of 0 to ")
        self.assertIn("RGB", self.fails(2, "render", self.make_volute(channels=3), "-o", self.path("y.png"), "--colormap",
                                        "inferno"))
        said = self.fails(2, "render", self.path("block.npy"), "-o", self.path("y.png"), "--preset", "smoke", "--colormap", "inferno")
        self.assertIn("light on it", said)
        self.assertIn("--preset none", said)
        for words in (("--bloom", "0.9"), ("--tone", "agx"), ("--background", "1,0,0")):
            self.assertIn(words[0], self.fails(2, "render", self.path("block.npy"), "-o", self.path("y.png"), "--size", "4x4",
                                               "--preset", "none", "--colormap", "viridis", *words))
        # Layers of a preset are of its extinction.
        depths = [self.works("render", self.path("block.npy"), "-o", self.path("d.exr"), "--size", "4x4", "--preset", "smoke", "--aov",
                             "optical-depth", *more, measured=False) and
                  self.works("info", self.path("d.exr"), "--json").json["maximum"] for more in ((), ("--extinction", "1"))]
        self.assertGreater(depths[0], 2 * depths[1])

    def test_what_has_no_effect_is_refused_or_told(self):
        light = ("render", self.block(), "-o", self.path("x.exr"), "--size", "4x4")
        for words, said in ((("--exposure", "5"), "--exposure has no effect: a .exr"), (("--tone", "agx"), "--tone has no effect"),
                            (("--background=-1,0,0",), "--background: radiance is 0 or more")):
            self.assertIn(said, self.fails(2, *light, *words))
        self.assertIn("--by-pieces has no effect: there is one process", self.works(*light, "--by-pieces").message)
        scene = {"format": "volute-scene-2", "camera": {"eye": [0.5, -3, 0.5], "target": [0.5, 0.5, 0.5], "fov": 30, "size": [4, 4]},
                 "media": [{"kind": "volume", "file": "block.npy"}]}
        self.path("s.json").write_text(json.dumps(scene))
        stills = ("render", self.path("s.json"), "-o", self.path("s_%d.png"))
        self.assertIn("--speed has no effect", self.fails(2, *stills, "--speed", "5"))
        self.assertIn('"fps" of a volume', self.fails(2, *stills, "--fps", "50"))
        self.works("render", self.path("block.npy"), "-o", self.path("s_%d.png"), "--size", "4x4", "--fps", "50")

    def test_frames_that_a_film_leaves_out_are_told(self):
        """The longest sequence leads, whatever the order; uneven times are told."""
        write_npy(self.path("long.npy"), (6, 4, 4, 4), [0.5] * 384)
        media = [{"kind": "volume", "file": "block.npy", "time": {"offset": 0.01}}, {"kind": "volume", "file": "long.npy"},
                 {"kind": "volume", "file": "one.npy"}]
        self.block()
        write_npy(self.path("one.npy"), (4, 4, 4), [0.5] * 64)
        for i in range(3):
            self.path("s.json").write_text(json.dumps({"format": "volute-scene-2", "media": media[i:] + media[:i]}))
            said = self.works("render", self.path("s.json"), "-o", self.path("x.mp4"), "--size", "4x4").message
            self.assertIn("6 pictures from 0 to 0.2 s", said)
            self.assertIn("3 of the 3 frames of", said)
        said = self.works("render", self.path("long.npy"), "-o", self.path("x.mp4"), "--size", "4x4", "--frames", "0:50").message
        self.assertIn("frames 0:50 are asked for; it has 0 to 5", said)
        for number in (1, 2, 100):
            write_npy(self.path(f"u_{number:04d}.npy"), (4, 4, 4), [0.5] * 64)
        said = self.works("render", self.path("u_%04d.npy"), "-o", self.path("x.mp4"), "--size", "4x4").message
        self.assertIn("its frames are 0.04 to 3.92 s apart; the film shows each of them for 1.98 s", said)

    def test_a_gltf_s_camera_has_a_shape(self):
        gltf = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"camera": 0, "translation": [0.5, 0.5, 4]}],
                "cameras": [{"type": "perspective", "perspective": {"yfov": 0.6, "znear": 0.1, "aspectRatio": 2}}]}
        self.path("c.gltf").write_text(json.dumps(gltf))
        words = ("render", self.block(), "-o", self.path("x.exr"), "--camera", self.path("c.gltf"))
        self.assertNotIn("as wide as high", self.works(*words).message)
        self.assertEqual(self.works("info", self.path("x.exr"), "--json").json["size"], [800, 400])
        self.assertIn("2 times as wide as high, this one is 1 times", self.works(*words, "--size", "8x8").message)

    def test_layers_say_what_they_are(self):
        self.works("render", self.block(), "-o", self.path("x.exr"), "--size", "4x4", "--aov", "z,transmittance", measured=False)
        self.assertIn(b"z, transmittance", self.path("x.exr").read_bytes())

    def test_values_that_are_not_finite_are_refused(self):
        write_npy(self.path("bad.npy"), (1, 1, 1, 2), [0, math.nan])
        self.assertIn("voxel", self.fails(1, "render", self.path("bad.npy"), "-o", self.path("x.png"), "--size", "4x4"))


if __name__ == "__main__":
    support.main()
