# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Captures: calibrations in four formats, and every fault that must be refused or reported, injected and named."""
import json
import math
import pathlib

import ring
import support
from pictures import Part, Picture, read_exr, write_exr, write_parts, write_png


def transposed(rows):
    return [list(column) for column in zip(*rows)]


def eye_of(camera):
    return [-sum(camera["R"][k][i] * camera["t"][k] for k in range(3)) for i in range(3)]


def quaternion(R):
    """(w, x, y, z) of a rotation whose trace is not near -1, else by the largest diagonal."""
    trace = R[0][0] + R[1][1] + R[2][2]
    if trace > 0:
        s = 2 * math.sqrt(1 + trace)
        return s / 4, (R[2][1] - R[1][2]) / s, (R[0][2] - R[2][0]) / s, (R[1][0] - R[0][1]) / s
    i = max(range(3), key=lambda k: R[k][k])
    j, k = (i + 1) % 3, (i + 2) % 3
    s = 2 * math.sqrt(1 + R[i][i] - R[j][j] - R[k][k])
    q = [(R[k][j] - R[j][k]) / s, 0, 0, 0]
    q[1 + i], q[1 + j], q[1 + k] = s / 4, (R[j][i] + R[i][j]) / s, (R[k][i] + R[i][k]) / s
    return tuple(q)


class Formats(ring.TestCase):
    def setUp(self):
        super().setUp()
        self.options = ["--images", self.path("{camera}_%04d.exr"), "--bounds=-1,-1,-1,1,1,1", "--resolution", "16"]
        self.reconstruct("--frames", "10")
        self.ours = self.path("out.npy").read_bytes()

    def same(self, calibration, convention):
        result = self.works("reconstruct", self.path(calibration), "-o", self.path("other.npy"), "--iterations", 25,
                            "--regularization", "none", "--frames", "10:11", *self.options)
        self.assertIn(convention, result.message)
        shape, other = support.read_npy(self.path("other.npy").read_bytes())
        shape_ours, ours = support.read_npy(self.ours)
        self.assertEqual(shape, shape_ours)
        worst = max(abs(a - b) for a, b in zip(ours, other))
        self.assertLess(worst, 1e-5 * max(ours), calibration)

    def test_info_lists_cameras_and_missing_pictures(self):
        info = self.works("info", self.path("capture.json"), "--json").json
        self.assertEqual((info["kind"], info["frames"], info["size"]), ("capture", ring.FRAMES, [ring.SIDE] * 3))
        self.assertEqual([c["name"] for c in info["cameras"]], ring.NAMES)
        self.assertEqual(info["cameras"][0]["pictures"], "north_%04d.exr")
        self.path("c2_0011.exr").unlink()
        done = support.volute("info", self.path("capture.json"))
        self.assertEqual(done.code, 1)
        self.assertRegex(done.text, rf"c2: .*: 1 of {ring.FRAMES} pictures are MISSING")

    def test_info_tells_masks_and_backgrounds(self):
        self.json.update(kind="absorption", color="linear")
        self.camera("c1").update(background="empty.exr", mask="north_0010.exr", gain=1.5)
        self.write_capture()
        done = support.volute("info", self.path("capture.json"))
        self.assertEqual(done.code, 1)
        self.assertRegex(done.text, "measures +absorption")
        self.assertIn("background empty.exr is MISSING, mask north_0010.exr, linear, gain 1.5", done.text)

    def test_strict_minds_doubts_and_no_conventions(self):
        words = ("reconstruct", self.path("capture.json"), "-o", self.path("o.npy"), "--frames", "10", "--iterations", 2,
                 "--regularization", "none", "--refine", "never", "--strict")
        self.assertIn("pixel centres at 0.5", self.works(*words, "--report", self.path("r.json")).message)
        self.json["typo"] = 1
        self.write_capture()
        self.assertIn("typo is not known and ignored", self.fails(1, *words))
        self.works(*words[:-1], "--report", self.path("r.json"))
        report = json.loads(self.path("r.json").read_text())
        self.assertIn({"code": "left-out", "sentence": "typo is not known and ignored"}, report["capture_remarks"])

    def test_pictures_of_several_parts_are_refused(self):
        picture = read_exr(self.path("c2_0010.exr"))
        planes = {"Y": picture.values[::picture.channels]}
        self.path("c2_0010.exr").unlink()  # which other tests see
        write_parts(self.path("c2_0010.exr"), [Part(picture.width, picture.height, planes, name) for name in ("left", "right")])
        self.assertIn("c2_0010.exr: has 2 parts", self.fails(1, "reconstruct", self.path("capture.json"), "-o", self.path("o.npy"),
                                                             "--frames", "10"))

    def test_nerf_transforms(self):
        frames = []
        for camera in self.json["cameras"]:
            axes = transposed([[r * s for r in row] for row, s in zip(camera["R"], (1, -1, -1))])
            eye = eye_of(camera)
            K = camera["K"]
            frames.append({"file_path": f"{camera['name']}_####.exr", "fl_x": K[0][0], "fl_y": K[1][1], "cx": K[0][2],
                           "cy": K[1][2], "w": camera["width"], "h": camera["height"],
                           "transform_matrix": [axes[i] + [eye[i]] for i in range(3)] + [[0, 0, 0, 1]]})
        self.path("transforms.json").write_text(json.dumps({"frames": frames, "aabb_scale": 4}))
        self.same("transforms.json", "pixel centres at 0.5, OpenGL's camera axes")
        # A volume and pictures that are given later are no damage; pictures that are gone are.
        self.assertRegex(self.works("info", self.path("transforms.json")).text, "missing +.*does not say where the volume is")
        for frame in frames:
            frame["file_path"] = frame["file_path"].replace("####", "0010")
            del frame["w"], frame["h"]
        self.path("transforms.json").write_text(json.dumps({"frames": frames}))
        info = self.works("info", self.path("transforms.json"), "--json").json
        self.assertEqual([camera["size"] for camera in info["cameras"]], [[40, 32]] * 5)
        self.assertEqual([camera["pictures_there"] for camera in info["cameras"]], [1] * 5)

    def test_colmap(self):
        folder = self.path("model")
        folder.mkdir()
        cameras, images = "# cameras\n", "# images\n"
        for i, camera in enumerate(self.json["cameras"], 1):
            K = camera["K"]
            cameras += f"{i} PINHOLE {camera['width']} {camera['height']} {K[0][0]} {K[1][1]} {K[0][2]} {K[1][2]}\n"
            numbers = " ".join(repr(x) for x in (*quaternion(camera["R"]), *camera["t"]))
            images += f"{i} {numbers} {i} {camera['name']}_0010.exr\n\n"
        (folder / "cameras.txt").write_text(cameras)
        (folder / "images.txt").write_text(images)
        self.same("model", "COLMAP: 5 cameras, pixel centres at 0.5")

    def test_opencv(self):
        def matrix(name, rows):
            data = ", ".join(repr(float(x)) for row in rows for x in row)
            return f"{name}: !!opencv-matrix\n   rows: {len(rows)}\n   cols: {len(rows[0])}\n   dt: d\n   data: [ {data} ]\n"

        text = "%YAML:1.0\n---\n"
        for camera in self.json["cameras"]:
            K = [row[:] for row in camera["K"]]
            K[0][2] -= 0.5
            K[1][2] -= 0.5
            name = camera["name"]
            text += matrix("K_" + name, K) + matrix("D_" + name, [[0] * 5]) + matrix("R_" + name, camera["R"])
            text += matrix("T_" + name, [[x] for x in camera["t"]])
        self.path("cameras.yml").write_text(text)
        self.same("cameras.yml", "OpenCV: 5 cameras, pixel centres at 0")
        self.path("cameras.yml").write_text(text.replace(matrix("D_c1", [[0] * 5]), matrix("D_c1", [[0, 0, 0]])))
        self.assertIn("D_c1 has 3 coefficients; expected k1, k2, p1, p2",
                      self.fails(1, "reconstruct", self.path("cameras.yml"), "-o", self.path("o.npy"), *self.options))

    def test_half_a_pixel_raises_the_residual(self):
        self.write_capture()
        right = self.works("reconstruct", self.path("capture.json"), "-o", self.path("a.npy"), "--frames", "10", "--json",
                           "--iterations", 25, "--regularization", "none").json["residual"]
        self.json["pixel_centre"] = 0
        self.write_capture()
        wrong = self.works("reconstruct", self.path("capture.json"), "-o", self.path("b.npy"), "--frames", "10", "--json",
                           "--iterations", 25, "--regularization", "none").json["residual"]
        self.assertGreater(wrong, 1.02 * right)


class Project(ring.TestCase):
    def test_the_example_of_the_manual(self):
        page = (pathlib.Path(__file__).parents[2] / "docs" / "capture.md").read_text()
        self.path("manual.json").write_text(page.split("```json\n")[1].split("```")[0])
        result = self.works("project", self.make_npy(size=8, frames=1), self.path("manual.json"), "-o", self.path("m.exr"),
                            "--rays-per-pixel", 1)
        self.assertNotIn("not known", result.message)
        self.assertGreater(self.works("info", self.path("m.exr"), "--json").json["maximum"], 0)

    def test_is_linear_and_names_its_pictures(self):
        self.works("project", self.path("truth.npy"), self.path("capture.json"), "-o", self.path("p_{camera}_%03d.exr"),
                   "--frames", "12:13", "--basis", "box")
        again = read_exr(self.path("p_c2_012.exr"))
        self.assertEqual(again.values, read_exr(self.path("c2_0012.exr")).values)
        self.assertEqual(again.channels, 3)

    def test_grey_volumes_have_equal_channels(self):
        self.make_npy("grey.npy", frames=1, size=8)
        self.works("project", self.path("grey.npy"), self.path("capture.json"), "-o", self.path("g_{camera}.exr"))
        picture = read_exr(self.path("g_c1.exr"))
        self.assertEqual(picture.values[0::3], picture.values[1::3])
        self.assertGreater(max(picture.values), 0)

    def test_a_uniform_cube_is_as_bright_as_it_is_deep(self):
        support.write_npy(self.path("one.npy"), (1, 4, 4, 4), [2.0] * 64)
        self.json["cameras"] = self.json["cameras"][:1]
        R, t = ring.pose([5, 0, 0])
        self.json["cameras"][0].update({"R": R, "t": t, "K": [[40, 0, 20], [0, 40, 16], [0, 0, 1]]})
        self.write_capture()
        self.works("project", self.path("one.npy"), self.path("capture.json"), "-o", self.path("one.exr"), "--basis", "box",
                   "--rays-per-pixel", 1)
        # The middle ray passes 2 m of a value of 2, a hair obliquely.
        slope = math.hypot(0.5 / 40, 0.5 / 40)
        self.assertAlmostEqual(read_exr(self.path("one.exr")).at(20, 16), 4 * math.sqrt(1 + slope * slope), places=5)

    def write_vti(self, **arrays):
        data = "".join(f'<DataArray type="Float32" Name="{name}" format="ascii">{f"{value} " * 64}</DataArray>'
                       for name, value in arrays.items())
        self.path("two.vti").write_text(
            '<VTKFile type="ImageData" version="0.1" byte_order="LittleEndian">'
            '<ImageData WholeExtent="0 3 0 3 0 3" Origin="-0.75 -0.75 -0.75" Spacing="0.5 0.5 0.5">'
            f'<Piece Extent="0 3 0 3 0 3"><PointData>{data}</PointData></Piece></ImageData></VTKFile>\n')
        return [self.path("two.vti"), self.path("capture.json"), "-o", self.path("v_{camera}.exr")]

    def test_projects_emission_of_several_grids_and_says_so(self):
        command = ["project", *self.write_vti(density=5, emission=1)]
        result = support.volute(*command, "--json")
        if "this build has no VTK" in result.message:
            self.skipTest(result.message)
        self.assertEqual(result.json["grid"], "emission")
        brightest = max(read_exr(self.path("v_c2.exr")).values)
        self.assertEqual(self.works(*command, "--field", "density", "--json").json["grid"], "density")
        self.assertAlmostEqual(max(read_exr(self.path("v_c2.exr")).values), 5 * brightest, places=4)
        message = self.fails(2, "project", *self.write_vti(density=5, temperature=300))
        self.assertRegex(message, r"which grid\? It has density .*, temperature .*; choose one with --field")

    def test_refuses_names_that_would_collide(self):
        source = [self.path("truth.npy"), self.path("capture.json"), "-o"]
        self.assertIn("{camera}", self.fails(2, "project", *source, self.path("p_%04d.exr")))
        self.assertIn("%04d", self.fails(2, "project", *source, self.path("p_{camera}.exr")))
        self.assertIn(".exr", self.fails(2, "project", *source, self.path("{camera}_%04d.png")))

    def test_a_capture_is_not_replaced_by_what_is_made_of_it(self):
        source = ["project", self.path("truth.npy"), self.path("capture.json"), "-o"]
        kept = {name: self.path(name).read_bytes() for name in ("capture.json", "c1_0010.exr", "truth.npy")}
        self.assertRegex(self.fails(2, *source, self.path("{camera}_%04d.exr")),
                         r"north_0010.exr is a picture of the capture \(camera north\) and would be replaced")
        self.assertIn("is read and would be replaced", self.fails(2, "reconstruct", self.path("capture.json"), "-o",
                                                                  self.path("out.npy"), "--report", self.path("./capture.json")))
        self.path("same.npy").symlink_to(self.path("truth.npy"))
        self.assertIn("is read and would be replaced", self.fails(2, "extract", self.path("truth.npy"), "-o", self.path("same.npy")))
        for name, content in kept.items():
            self.assertEqual(self.path(name).read_bytes(), content, name)


class Geometry(ring.TestCase):
    def test_mirrored_rotation(self):
        self.camera("c2")["R"][0] = [-x for x in self.camera("c2")["R"][0]]
        self.assertRegex(self.refused(), r"cameras\[2\] \(c2\): R is mirrored \(determinant -1\)")

    def test_scaled_rotation(self):
        self.camera("c3")["R"] = [[1.05 * x for x in row] for row in self.camera("c3")["R"]]
        self.assertRegex(self.refused(), r"cameras\[3\] \(c3\): R is no rotation: R R' is off the identity by 0.10")

    def test_bounds_in_centimetres(self):
        self.json["volume"].update({"min": [-100] * 3, "max": [100] * 3})
        self.assertRegex(self.refused(), r"camera north: the camera stands inside the volume")

    def test_volume_outside_the_image(self):
        self.camera("c1")["t"][0] += 6
        self.assertRegex(self.refused(), r"camera c1: the volume lies outside the image: it would appear at x \d+ to")

    def test_focal_lengths_beyond_any_lens(self):
        self.camera("c1")["K"][0][0] = 1e30
        self.assertRegex(self.refused(), r"\(c1\): the focal lengths are 1e\+30 and 43 pixels for pictures of 40 x 32")

    def test_names_that_are_no_part_of_a_file_name(self):
        for name, said in (("../c2", "has a slash at place 3"), ("c\u00002", "has the control character 0x00 at place 2"),
                           ("", r"cameras\[2\].*name")):
            self.json = ring.capture()
            self.camera("c2")["name"] = name
            self.assertRegex(self.refused(), said)

    def test_too_few_views(self):
        self.json["cameras"] = self.json["cameras"][:2]
        self.assertRegex(self.refused(), r"2 views are too few.*expected at least 3.*--force")
        self.works("reconstruct", self.path("capture.json"), "-o", self.path("out.npy"), "--iterations", 5, "--force",
                   "--regularization", "none", "--frames", "10")
        self.json = ring.capture()
        self.assertIn("too few", self.refused("--hold-out", "c1", "--hold-out", "c2", "--hold-out", "c3"))

    def test_opposite_cameras_are_advised_on(self):
        R, t = ring.pose([-x for x in eye_of(self.camera("north"))])
        self.camera("south").update({"R": R, "t": t})
        self.write_capture()
        self.works("project", self.path("truth.npy"), self.path("capture.json"), "-o", self.path("new_{camera}_%04d.exr"))
        result = self.reconstruct("--frames", "10", "--images", self.path("new_{camera}_%04d.exr"))
        self.assertRegex(result.message, r"degrees between lines of sight.*: north-south 0, ")
        self.assertRegex(result.message, r"north and south \(0\) degrees modulo 180; an odd number")


class Pictures(ring.TestCase):
    def test_missing_pictures(self):
        self.path("c2_0011.exr").unlink()
        result = self.reconstruct("--report", self.path("report.json"))
        self.assertIn("warning: camera c2: 1 of 4 pictures is missing, of frame 11; there it does not count", result.message)
        frames = json.loads(self.path("report.json").read_text())["frames"]
        missing = [frame["cameras"][2]["residual"] is None for frame in frames]
        self.assertEqual(missing, [False, True, False, False])
        self.assertLess(frames[1]["cameras"][1]["residual"], 1.2 * frames[0]["cameras"][1]["residual"] + 0.02)
        self.path("c2_0012.exr").unlink()
        self.path("c2_0013.exr").unlink()
        message = self.refused()
        self.assertRegex(message, r"camera c2, frame 11: there is no picture .*c2_0011.exr; 3 of 20 pictures are missing")
        self.assertIn("camera c2: 3 of 4 pictures are missing", self.reconstruct("--force").message)

    def test_values_that_are_not_finite(self):
        self.change("c1", 12, lambda picture: picture.set(7, 9, math.nan))
        self.assertRegex(self.refused(), r"camera c1, frame 12: the value at pixel \(7, 9\) is not finite")

    def test_hot_pixels(self):
        self.change("c1", 12, lambda picture: picture.set(3, 4, 50))
        self.change("c1", 12, lambda picture: picture.set(35, 4, 20))
        result = self.reconstruct("--frames", "12")
        self.assertRegex(result.message, r"warning: camera c1, frame 12: pixel \(3, 4\) reads 50 and those around it at most "
                                         r"\S+, and 1 more stand out like that: hot pixels")
        self.change("c1", 12, lambda picture: picture.set(3, 4, 1e30))
        message = self.refused("--frames", "12")
        self.assertRegex(message, r"(?s)c1, frame 12: pixel \(3, 4\) reads 1e\+30.*the visual hull is empty")

    def test_a_pixel_amid_saturated_ones_is_not_hot(self):
        peak = max(max(read_exr(self.path(f"{name}_0010.exr")).values) for name in ring.NAMES)
        picture = read_exr(self.path("c1_0010.exr"))
        full = [(x, y) for y in range(1, picture.height - 1) for x in range(1, picture.width - 1)
                if all(picture.at(x + u, y + v) > peak / 3 for u in (-1, 0, 1) for v in (-1, 0, 1))]
        self.assertTrue(full)
        picture.set(*full[0], 0.99 * peak / 4)
        write_exr(self.path("c1_0010.exr"), picture)
        self.as_png(4 / peak)
        self.json["white"] = peak / 4
        self.write_capture()
        self.assertNotIn("hot pixels", self.png().message)

    def test_all_black(self):
        self.change("c2", 11, lambda picture: Picture(40, 32, 3))
        self.assertRegex(self.refused(), r"camera c2, frame 11: the picture is all black, while camera \w+ has \d+ lit pixels")

    def test_dark_frames_are_zero(self):
        for name in ring.NAMES:
            self.change(name, 11, lambda picture: Picture(40, 32, 3))
        self.change("c1", 11, lambda picture: picture.set(20, 20, 1))  # a hot pixel
        result = self.reconstruct("--frames", "10:13")
        self.assertIn("frame 11: no camera sees any light", result.message)
        shape, values = support.read_npy(self.path("out.npy").read_bytes())
        size = len(values) // shape[0]
        self.assertEqual(max(values[size:2 * size]), 0)
        self.assertGreater(max(values[2 * size:]), 0)

    def test_transparent_pictures(self):
        for name in ring.NAMES:
            picture = read_exr(self.path(f"{name}_0010.exr"))
            write_exr(self.path(f"a_{name}_0010.exr"), picture, alpha=0.5 if name == "c1" else 1)
        result = self.reconstruct("--frames", "10", "--images", self.path("a_{camera}_%04d.exr"))
        self.assertRegex(result.message, r"warning: camera c1, frame 10: 100\.0 % of the pixels are transparent")
        self.assertEqual(result.message.count("warning"), 1)

    def as_png(self, scale, bits=8, **options):
        for name in ring.NAMES:
            picture = read_exr(self.path(f"{name}_0010.exr"))
            picture.values = [scale * value for value in picture.values]
            write_png(self.path(f"{name}_0010.png"), picture, bits, **options)

    def png(self, *options):
        return self.reconstruct("--frames", "10", "--images", self.path("{camera}_%04d.png"), "--json", *options)

    def test_png_in_every_curve(self):
        peak = max(max(read_exr(self.path(f"{name}_0010.exr")).values) for name in ring.NAMES)
        self.json["white"] = 1.05 * peak
        self.write_capture()
        linear = self.reconstruct("--frames", "10", "--json", "--color", "linear")
        for curve, encode in (("srgb", None), ("gamma:2.2", lambda v: max(v, 0) ** (1 / 2.2)), ("linear", lambda v: max(v, 0))):
            self.as_png(1 / (1.05 * peak), 16, **({"encode": encode} if encode else {}))
            result = self.png("--color", curve)
            self.assertAlmostEqual(result.json["residual"], linear.json["residual"], delta=2e-3, msg=curve)
            self.assertNotIn("warning", result.message)

    def test_light_that_is_not_the_volumes_is_told_once(self):
        def glow(picture):
            picture.values = [value + 0.3 for value in picture.values]

        self.json["volume"] |= {"min": [-2.2] * 3, "max": [2.2] * 3}  # no pixel sees past it
        self.write_capture()
        for name in ring.NAMES:
            self.change(name, 10, glow)
        message = self.reconstruct("--frames", "10").message
        self.assertEqual(message.count("all along the border"), 1)
        self.assertIn(f"cameras {', '.join(ring.NAMES)}, frame 10: light all along the border", message)
        self.assertIn('"black"', message)

    def test_twelve_bits_in_files_of_sixteen(self):
        peak = max(max(read_exr(self.path(f"{name}_0010.exr")).values) for name in ring.NAMES)
        self.json["white"] = peak
        self.write_capture()
        self.as_png(0.9 * 4095 / 65535 / peak, 16, encode=lambda v: max(v, 0))
        result = self.png("--color", "linear")
        self.assertRegex(result.message, r'frame 10: no picture reads more than 4095 of 65535: are these 12 bits\? Then state "bits": 12')
        self.json["bits"] = 12
        self.write_capture()
        stated = self.png("--color", "linear")
        self.assertNotIn("bits", stated.message)
        self.assertAlmostEqual(stated.json["residual"], result.json["residual"], delta=5e-3)

    def test_saturated_pixels_are_told(self):
        peak = max(max(read_exr(self.path(f"{name}_0010.exr")).values) for name in ring.NAMES)
        self.as_png(4 / peak)
        self.json["white"] = peak / 4
        self.write_capture()
        result = self.png()
        self.assertRegex(result.message, r"camera \w+, frame 10: \d\d\.\d % of the lit pixels are saturated: all that is known is how bright they are at least")
        message = self.fails(1, "reconstruct", self.path("capture.json"), "-o", self.path("x.npy"), "--frames", "10",
                             "--images", self.path("{camera}_%04d.png"), "--max-saturated", "0.05")
        self.assertRegex(message, r"camera \w+, frame 10: .* more than the 5\.0 % allowed")

    def test_backgrounds(self):
        def glow(picture):
            picture.values = [value + 0.25 + 0.01 * (i % 7) for i, value in enumerate(picture.values)]

        for name in ring.NAMES:
            empty = Picture(40, 32, 3)
            glow(empty)
            write_exr(self.path(f"back_{name}.exr"), empty)
            self.camera(name)["background"] = f"back_{name}.exr"
            for frame in range(10, 14):
                self.change(name, frame, glow)
        self.write_capture()
        result = self.reconstruct("--json")
        self.assertNotIn("warning", result.message)
        self.assertLess(result.json["residual"], 0.3)
        darker = Picture(40, 32, 3)
        glow(darker)
        darker.values = [0.9 * value for value in darker.values]
        write_exr(self.path("back_c3.exr"), darker)
        message = self.reconstruct("--frames", "10").message
        self.assertRegex(message, r"camera c3, frame 10: its background is 11\.1 % brighter than the one that was given")
        self.assertNotIn("all along the border", message)
        moved = Picture(40, 32, 3, [0.25 + 0.01 * (i % 7) + (0.3 if i % 120 < 30 else 0) for i in range(40 * 32 * 3)])
        write_exr(self.path("back_c3.exr"), moved)
        self.assertRegex(self.refused(), r"camera c3, frame 10: \d+\.\d % of the pixels are darker than the background by more "
                                         r"than .*: the background moved")

    def test_lit_backgrounds(self):
        """Pictures through smoke, of a wall that gets darker by the frame."""
        def lit(frame):
            return [(1 - 0.03 * (frame - 10)) * (0.6 + 0.004 * (i % 120)) for i in range(40 * 32 * 3)]

        self.json["kind"] = "absorption"
        for name in ring.NAMES:
            for frame in range(10, 14):
                self.change(name, frame, lambda p, wall=lit(frame): Picture(
                    40, 32, 3, [w * math.exp(-0.2 * v) for w, v in zip(wall, p.values)]))
        self.assertIn("camera north: its background is missing; pictures of a lit background through the medium", self.refused())
        for name in ring.NAMES:
            write_exr(self.path(f"back_{name}.exr"), Picture(40, 32, 3, lit(10)))
            self.camera(name)["background"] = f"back_{name}.exr"
        self.write_capture()
        result = self.reconstruct("--json", output="out.volute")
        self.assertRegex(result.message, r"its background is \d\.\d % darker than the one that was given")
        self.assertLess(result.json["residual"], 0.3)
        info = self.works("info", self.path("out.volute"), "--json").json
        self.assertEqual((info["grid"], info["unit"]), ("extinction", "1/m"))
        # The noise of light says what is dark, stated in either place; that of depths is estimated.
        self.reconstruct("--frames", "10")
        bare = self.path("out.npy").read_bytes()
        option = self.reconstruct("--frames", "10", "--noise-sigma", "0.12")
        self.assertNotIn("brighter than the background", option.message)
        before = self.path("out.npy").read_bytes()
        self.assertNotEqual(before, bare)
        self.json["noise_sigma"] = 0.12
        self.write_capture()
        self.reconstruct("--frames", "10")
        self.assertEqual(self.path("out.npy").read_bytes(), before)

    def test_an_evenly_lit_background_is_not_taken_as_saturated(self):
        self.json.update(kind="absorption", color="linear")
        for name in ring.NAMES:
            write_png(self.path(f"back_{name}.png"), Picture(40, 32, 3, [231 / 255] * (40 * 32 * 3)), encode=lambda v: v)
            self.camera(name)["background"] = f"back_{name}.png"
            self.change(name, 10, lambda p: Picture(40, 32, 3, [231 / 255 * math.exp(-0.2 * v) for v in p.values]))
        self.as_png(1, encode=lambda v: v)
        self.write_capture()
        told = self.png()
        self.assertRegex(told.message, 'many pixels read 231 of 255, the most in the picture, and are taken as an evenly lit '
                                       'background: state "saturation": 1, or 0.90588 if they are saturated')
        self.json["saturation"] = 1
        self.write_capture()
        stated = self.png()
        self.assertNotIn("many pixels", stated.message)
        self.assertEqual(stated.json["residual"], told.json["residual"])
        self.json["saturation"] = 231 / 255
        self.assertIn("expose less", self.refused("--frames", "10", "--images", self.path("{camera}_%04d.png")))

    def test_backgrounds_from_empty_frames(self):
        for name in ring.NAMES:
            for frame in range(3):
                empty = Picture(40, 32, 3, [0.5] * (40 * 32 * 3))
                empty.set(frame, 5, 9)
                write_exr(self.path(f"{name}_{frame:04d}.exr"), empty)
            for frame in range(10, 14):
                self.change(name, frame, lambda p: Picture(40, 32, 3, [v + 0.5 for v in p.values]))
        self.json["empty_frames"] = [0, 2]
        self.write_capture()
        result = self.reconstruct("--json")
        self.assertNotIn("warning", result.message)
        self.assertLess(result.json["residual"], 0.3)

    def test_masks(self):
        def obstructed(picture):
            for y in range(8, 20):
                for x in range(14, 20):
                    picture.set(x, y, 5)

        for frame in range(10, 14):
            self.change("c2", frame, obstructed)
        mask = Picture(40, 32, 1, [1.0] * (40 * 32))
        for y in range(8, 20):
            for x in range(14, 20):
                mask.set(x, y, 0)
        write_png(self.path("mask.png"), mask)
        bare = self.reconstruct("--json", "--frames", "10").json["residual"]
        self.camera("c2")["mask"] = "mask.png"
        self.write_capture()
        masked = self.reconstruct("--json", "--frames", "10").json["residual"]
        self.assertLess(masked, 0.7 * bare)

    def test_light_outside_the_volume_and_silhouettes_at_the_border(self):
        def stray(picture):
            for y in range(6):
                for x in range(10):
                    picture.set(x, y, 2)

        self.change("c1", 10, stray)
        message = self.reconstruct("--frames", "10").message
        self.assertRegex(message, r"camera c1, frame 10: \d+\.\d % of the light lies outside the volume's bounds")
        self.assertRegex(message, r"camera c1, frame 10: the silhouette touches the left border of the picture in 6 of 32 pixels")
        self.assertRegex(message, r"camera c1, frame 10: the silhouette touches the upper border of the picture in 10 of 40")

    def test_empty_hull_names_the_camera(self):
        def elsewhere(picture):
            flipped = Picture(40, 32, 3)
            for y in range(3):
                for x in range(3):
                    flipped.set(1 + x, 1 + y, 1)
            return flipped

        self.change("c3", 10, elsewhere)
        self.assertRegex(self.refused(), r"frame 10: the visual hull is empty.*; without camera c3 it would hold \d+\.\d+ %")

    def test_a_hull_that_fills_the_volume(self):
        for name in ring.NAMES:
            self.change(name, 10, lambda p: Picture(40, 32, 3, [value + 0.3 + 0.03 * (i // 3 % 40) for i, value in enumerate(p.values)]))
        self.assertRegex(self.reconstruct("--frames", "10").message, r"frame 10: the visual hull fills \d+ % of the volume")

    def test_an_even_black_level_is_undone_and_told_once(self):
        clean = self.reconstruct("--frames", "10", "--json").json["residual"]
        for name in ring.NAMES:
            self.change(name, 10, lambda p: Picture(40, 32, 3, [value + 0.5 for value in p.values]))
        result = self.reconstruct("--frames", "10", "--json")
        self.assertAlmostEqual(result.json["residual"], clean, delta=5e-3)
        self.assertRegex(result.message, r"warning: cameras north, c1, c2, c3, south, frame 10: all pixels beside the volume show about 0\.5")
        self.assertEqual(result.message.count("warning"), 1)

    def test_clean_captures_warn_of_nothing(self):
        self.assertNotIn("warning", self.reconstruct().message)
        for options in (["--resolution", "10"], ["--resolution", "32"]):
            self.assertNotIn("warning", self.reconstruct("--frames", "10", *options).message, options)


class Step(ring.TestCase):
    def test_a_camera_one_frame_late_is_told_with_the_evidence(self):
        pictures = {frame: self.path(f"c2_{frame:04d}.exr").read_bytes() for frame in range(10, 14)}
        for frame in range(11, 14):
            self.path(f"c2_{frame:04d}.exr").unlink()
            self.path(f"c2_{frame:04d}.exr").write_bytes(pictures[frame - 1])
        message = self.reconstruct("--frames", "12", "--resolution", "32").message
        self.assertRegex(message, r"camera c2, frame 12: its picture of frame 13 fits .*: it seems to run 1 frame late")

    def warnings(self, resolution, iterations):
        self.write_capture()
        message = self.works("reconstruct", self.path("capture.json"), "-o", self.path("out.npy"), "--frames", "12",
                             "--regularization", "none", "--resolution", resolution, "--iterations", iterations).message
        return [line.split("warning: ")[1] for line in message.splitlines() if "warning: " in line]

    def test_a_camera_that_is_too_bright_is_told_by_its_gain(self):
        self.camera("c2")["gain"] = 1.1
        (said,) = self.warnings(32, 100)
        self.assertRegex(said, r"camera c2, frame 12: (9|1[01]) % too bright: its radiance times 0\.\d+ fits")

    def test_a_camera_with_another_principal_point_is_named(self):
        self.camera("c2")["K"][0][2] += 1
        (said,) = self.warnings(16, 25)
        self.assertRegex(said, r"camera c2: its calibration does not fit the others and was refined: .* (0\.[5-9]|1\.\d) pixels")

    def test_refinement_can_be_left_out(self):
        self.camera("c2")["K"][0][2] += 1
        self.write_capture()
        message = self.works("reconstruct", self.path("capture.json"), "-o", self.path("out.npy"), "--frames", "12", "--refine",
                             "never", "--regularization", "none", "--resolution", 16, "--iterations", 18).message
        self.assertIn("camera c2, frame 12: does not fit the others", message)
        self.assertNotIn("refined", message)

    def test_the_refined_calibration_is_written_and_fits(self):
        self.camera("c2")["K"][0][2] += 1
        self.write_capture()
        self.works("reconstruct", self.path("capture.json"), "-o", self.path("out.npy"), "--frames", "11:13", "--resolution", 16,
                   "--refined", self.path("refined.json"))
        given = next(camera for camera in self.json["cameras"] if camera["name"] == "c2")["K"][0][2]
        refined = next(camera for camera in json.loads(self.path("refined.json").read_text())["cameras"]
                       if camera["name"] == "c2")
        self.assertNotEqual(refined["K"][0][2], given)
        message = self.works("reconstruct", self.path("refined.json"), "-o", self.path("again.npy"), "--frames", "11:13").message
        self.assertNotIn("calibration refined", message)

    def test_a_camera_with_another_lens_is_named(self):
        self.camera("c3")["distortion"] = [8, 0, 0, 0, 0]
        lens, *_ = self.warnings(24, 25)
        self.assertIn("camera c3: a lens that its calibration does not have: with k1 -", lens)

    def test_a_wrong_convention_of_pixel_centres_is_told_by_its_name(self):
        self.json["pixel_centre"] = 0
        for resolution in (12, 16):
            (said,) = self.warnings(resolution, 25)
            self.assertRegex(said, r"(frame 12: one volume fits all pictures better|all cameras: one volume fits the pictures) where "
                                   r"principal points are half a pixel further to the left and up\b.*, least at -0\.\d+ pixels.*: "
                                   r"is the centre of the first pixel at 0\.5, not at 0\?")

    def test_exchanged_pictures_are_told_of_all(self):
        first, second = self.camera("north"), self.camera("c2")
        first["image"], second["image"] = second["image"], first["image"]
        (said,) = self.warnings(32, 25)
        self.assertRegex(said, r"cameras (north and c2|c2 and north): exchanged: each fits as the other")

    def test_a_mirrored_camera_is_named(self):
        self.change("c3", 12, lambda p: Picture(40, 32, 3, [p.values[3 * (40 * y + 39 - x) + c]
                                                            for y in range(32) for x in range(40) for c in range(3)]))
        (said,) = self.warnings(16, 25)
        self.assertRegex(said, r"camera c3: mirrored: left and right exchanged")


class Memory(ring.TestCase):
    def test_volumes_too_large_are_refused_before_any_work(self):
        before = self.files()
        for resolution, limit, words in (("512", "500M", "A volume of 512 x 512 x 512 voxels needs 5.37 GB"),
                                         ("1500", "1G", "1 to 1024 voxels an axis")):
            result = support.volute("reconstruct", self.path("capture.json"), "-o", self.path("x.npy"), "--resolution",
                                    resolution, "--max-memory", limit)
            self.assertNotEqual(result.code, 0)
            self.assertIn(words, result.message)
        self.assertEqual(self.files(), before)


if __name__ == "__main__":
    support.main()
