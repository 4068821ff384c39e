# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Reconstruction end to end: what comes out, its report, runs that are interrupted or split, and joining."""
import json
import math
import os
import signal
import subprocess
import time

import ring
import support
from pictures import Picture, read_exr, write_exr
from support import read_npy


def means(shape, values, factor):
    """Averages of cubes of factor^3 voxels."""
    frames, z, y, x, channels = shape
    out = []
    for t in range(frames):
        for k in range(0, z, factor):
            for j in range(0, y, factor):
                for i in range(0, x, factor):
                    for c in range(channels):
                        out.append(sum(values[(((t * z + k + dk) * y + j + dj) * x + i + di) * channels + c]
                                       for dk in range(factor) for dj in range(factor) for di in range(factor)) / factor ** 3)
    return out


def relative(a, b):
    return math.sqrt(math.fsum((x - y) ** 2 for x, y in zip(a, b)) / math.fsum(x * x for x in a))


class Reconstruct(ring.TestCase):
    def test_finds_the_volume(self):
        self.reconstruct("--frames", "11:13")
        shape, values = read_npy(self.path("out.npy").read_bytes())
        self.assertEqual(shape, (2, 16, 16, 16, 3))
        self.assertGreaterEqual(min(values), 0)
        whole, truth = read_npy(self.path("truth.npy").read_bytes())
        size = len(truth) // whole[0]
        coarse = means((2,) + whole[1:], truth[size:3 * size], 2)
        self.assertLess(relative(coarse, values), 0.5)
        # The light is all there, whatever five views can tell of its place.
        self.assertAlmostEqual(math.fsum(values), math.fsum(coarse), delta=0.03 * math.fsum(coarse))

    def test_volute_keeps_frames_basis_and_place(self):
        self.reconstruct(output="out.volute")
        info = self.works("info", self.path("out.volute"), "--json").json
        self.assertEqual((info["frame_numbers"], info["size"], info["channels"]), ([10, 13], [16, 16, 16], 3))
        self.assertEqual((info["basis"], info["grid"], info["bounds"]), ("trilinear", "emission", [-1, -1, -1, 1, 1, 1]))
        self.assertLessEqual(info["reached"]["relative_rms"] if "reached" in info else info["relative_rms"], 1e-3)

    def test_the_compressed_file_is_compared_with_the_pictures(self):
        fine = self.reconstruct("--frames", "10:12", "--json", output="fine.volute")
        self.assertNotIn("warning", fine.message)
        self.assertLess(fine.json["file_residual"], 1.1 * fine.json["residual"] + 2e-3)
        rough = self.reconstruct("--frames", "10:12", "--json", "--rms", "0.3", output="rough.volute")
        self.assertRegex(rough.message, r"warning: the compressed file leaves \S+ % of the pictures unexplained, the volumes before")
        self.assertGreater(rough.json["file_residual"], 1.1 * rough.json["residual"])
        self.assertNotIn("file_residual", self.reconstruct("--frames", "10", "--json").json)

    def test_report_and_page(self):
        result = self.reconstruct("--hold-out", "c1", "--hold-out", "c3", "--report", self.path("r.json"), "--json")
        report = json.loads(self.path("r.json").read_text())
        self.assertEqual([camera["held_out"] for camera in report["cameras"]], [False, True, False, True, False])
        self.assertEqual(result.json["held_out_psnr"], report["held_out_psnr"])
        self.assertGreater(report["held_out_psnr"], 25)
        self.assertEqual([frame["frame"] for frame in report["frames"]], [10, 11, 12, 13])
        frame = report["frames"][2]
        self.assertEqual((frame["iterations"], frame["stopped_by"], frame["regularization"]), (25, "iterations", "none"))
        self.assertTrue(0 < frame["hull_share"] < 1)
        for camera in frame["cameras"]:
            self.assertTrue(0 < camera["residual"] < 1, camera)
            self.assertEqual(camera["saturated_share"], 0)
        self.assertEqual(len(report["angles"]), 10)
        self.assertAlmostEqual(report["angles"][0]["degrees"], 36, delta=1)
        page = self.path("r.html").read_text()
        self.assertEqual(page.count("data:image/png;base64,"), 3 * 3 * 5)  # frames, pictures, cameras
        self.assertEqual(page.count("<svg"), 4)
        self.assertIn("c3 (held out): given", page)

    def test_cameras_are_left_out_in_turn(self):
        result = self.reconstruct("--frames", "10:12", "--hold-out", "auto", "--report", self.path("r.json"), "--json")
        report = json.loads(self.path("r.json").read_text())
        turns = report["held_out_in_turn"]
        self.assertEqual([turn["name"] for turn in turns], list(ring.NAMES))
        self.assertAlmostEqual(report["held_out_psnr"], sum(turn["psnr"] for turn in turns) / 5, delta=1e-3)
        self.assertEqual(result.json["held_out_psnr"], report["held_out_psnr"])
        self.assertTrue(all(turn["residual"] > report["residual"] for turn in turns), turns)
        self.assertRegex(report["verdict"], r"^a new view comes out with \d+\.\d dB .* worst \w+ with \d+\.\d\)")
        self.assertEqual([name for name in self.files() if ".work" in name], [])
        # What one camera alone says is that of a run that leaves it out.
        alone = self.reconstruct("--frames", "10:12", "--hold-out", "c2", "--json", output="alone.npy")
        self.assertAlmostEqual(alone.json["held_out_psnr"], next(t["psnr"] for t in turns if t["name"] == "c2"), delta=1e-3)

    def test_leaving_out_in_turn_is_refused_where_it_makes_no_sense(self):
        source = self.path("capture.json")
        self.assertIn("name no other", self.fails(2, "reconstruct", source, "-o", self.path("x.npy"), "--hold-out", "auto",
                                                  "--hold-out", "c2"))

    def test_error_bars_are_a_grid_beside_the_values(self):
        result = self.reconstruct("--frames", "10:12", "--error-bars", "--report", self.path("r.json"), "--json", output="out_{grid}.npy")
        shape, values = read_npy(self.path("out_emission.npy").read_bytes())
        self.assertEqual(shape, (2, 16, 16, 16, 3))
        shape, sigma = read_npy(self.path("out_emission_sigma.npy").read_bytes())
        self.assertEqual(shape, (2, 16, 16, 16, 3))
        self.assertGreaterEqual(min(sigma), 0)
        report = json.loads(self.path("r.json").read_text())
        # What is expected is about what is: the truth on voxels twice as long.
        whole, truth = read_npy(self.path("truth.npy").read_bytes())
        size = len(truth) // whole[0]
        coarse = means((2,) + whole[1:], truth[:2 * size], 2)
        self.assertTrue(0.4 < report["uncertainty"]["expected_error"] / relative(coarse, values) < 2.5)
        for frame in report["frames"]:
            known = frame["uncertainty"]
            self.assertEqual(len(known["predicted_cameras"]), 2)
            self.assertTrue(0 < known["prior_share"] < 1)
        self.assertEqual(result.json["prior_share"], report["uncertainty"]["prior_share"])
        self.assertIn("standard deviation there", self.path("r.html").read_text())
        self.assertEqual([name for name in self.files() if ".work" in name], [])
        self.reconstruct("--frames", "10", "--error-bars", output="both.volute")
        grids = self.works("info", self.path("both.volute"), "--json").json["grids"]
        self.assertEqual([grid["name"] for grid in grids], ["emission", "emission_sigma"])

    def test_temperatures_of_a_flame(self):
        source = self.path("capture.json")
        self.assertIn("spectrum", self.fails(2, "reconstruct", source, "-o", self.path("x_{grid}.npy"), "--temperature"))
        self.json["spectrum"] = {"wavelengths": [620, 540, 460], "black_body": {"temperature": 1600, "radiance": [2, 1, 0.3]}}
        self.write_capture()
        self.assertIn("{grid}", self.fails(2, "reconstruct", source, "-o", self.path("x.npy"), "--temperature"))
        result = self.reconstruct("--frames", "10", "--temperature", "--error-bars", "--report", self.path("r.json"), "--json",
                                  output="out_{grid}.npy")
        grids = {name: read_npy(self.path(f"out_{name}.npy").read_bytes())
                 for name in ("temperature", "extinction", "temperature_sigma", "extinction_sigma")}
        for name, (shape, values) in grids.items():
            self.assertEqual(shape, (1, 16, 16, 16), name)
            self.assertGreaterEqual(min(values), 0)
        lit = [value for value in grids["temperature"][1] if value > 0]
        self.assertTrue(lit and 700 <= min(lit) and max(lit) <= 4000)
        self.assertEqual(result.json["mean_temperature"], json.loads(self.path("r.json").read_text())["soot"]["mean_temperature"])
        self.json["spectrum"]["black_body"]["radiance"] = [2e-4, 1e-4, 3e-5]  # pictures are divided by their exposure, and this is not
        self.write_capture()
        deep = self.reconstruct("--frames", "10", "--temperature", "--json", output="deep_{grid}.npy")
        self.assertIn("the soot's optical depth is", deep.message)
        self.assertTrue(any("optical depth" in text for text in deep.json["warnings"]), deep.json["warnings"])

    def test_error_bars_need_a_place(self):
        source = self.path("capture.json")
        self.assertIn("{grid}", self.fails(2, "reconstruct", source, "-o", self.path("x.npy"), "--error-bars"))

    def test_residual_is_what_project_and_compare_say(self):
        residuals = self.reconstruct("--frames", "12", "--json").json["residuals"]
        self.works("project", self.path("out.npy"), self.path("capture.json"), "-o", self.path("seen_{camera}.exr"))
        for name in ring.NAMES:
            given, seen = read_exr(self.path(f"{name}_0012.exr")), read_exr(self.path(f"seen_{name}.exr"))
            self.assertAlmostEqual(relative(given.values, seen.values), residuals[name], delta=1e-4)

    def test_grey_pictures_give_one_channel(self):
        for name in ring.NAMES:
            picture = read_exr(self.path(f"{name}_0010.exr"))
            write_exr(self.path(f"g_{name}_0010.exr"), Picture(40, 32, 1, picture.values[0::3]))
        self.reconstruct("--frames", "10", "--images", self.path("g_{camera}_%04d.exr"))
        shape, grey = read_npy(self.path("out.npy").read_bytes())
        self.assertEqual(shape, (1, 16, 16, 16))
        self.reconstruct("--frames", "10", output="colour.npy")
        colour = read_npy(self.path("colour.npy").read_bytes())[1]
        self.assertLess(relative(colour[0::3], grey), 0.05)
        # A grey first frame does not make the others grey.
        for name in ring.NAMES:
            write_exr(self.path(f"g_{name}_0011.exr"), read_exr(self.path(f"{name}_0011.exr")))
        self.reconstruct("--frames", "10:12", "--images", self.path("g_{camera}_%04d.exr"), output="both.npy")
        shape, both = read_npy(self.path("both.npy").read_bytes())
        self.assertEqual(shape, (2, 16, 16, 16, 3))
        second = both[len(both) // 2:]
        self.assertGreater(relative(second[0::3], second[2::3]), 0.2)

    def test_a_grey_camera_among_others_is_fitted_to_the_mean_of_their_colours(self):
        residuals = []
        for channels, told in ((1, "one channel, while others have three"), (3, "three equal channels, while others see colours")):
            for name in ring.NAMES:
                picture = read_exr(self.path(f"{name}_0010.exr"))
                if name == "c2":
                    mean = [sum(picture.values[i:i + 3]) / 3 for i in range(0, len(picture.values), 3)]
                    picture = Picture(ring.WIDTH, ring.HEIGHT, channels, [value for value in mean for _ in range(channels)])
                write_exr(self.path(f"m_{name}_0010.exr"), picture)
            result = self.reconstruct("--frames", "10", "--json", "--images", self.path("m_{camera}_%04d.exr"))
            self.assertIn(f"camera c2, frame 10: {told}: it is taken as the mean of theirs", result.message)
            self.assertNotIn("does not fit", result.message)
            residuals.append(result.json["residual"])
        self.assertAlmostEqual(*residuals, delta=1e-3)

    def test_standard_output(self):
        self.reconstruct("--frames", "10")
        result = self.works("reconstruct", self.path("capture.json"), "-o", "-", "--iterations", 25, "--regularization",
                            "none", "--frames", "10")
        self.assertEqual(result.out, self.path("out.npy").read_bytes())
        self.assertIn("residual", result.message)

    def test_other_solvers_and_options(self):
        for options in (["--solver", "mlem"], ["--solver", "sirt"], ["--solver", "cgls"], ["--basis", "box"], ["--no-hull"],
                        ["--rays-per-pixel", 1], ["--coarse-to-fine"], ["--resolution", "12,10,8"], ["--no-warm-start"]):
            result = self.reconstruct("--frames", "10:12", "--json", *options)
            self.assertLess(result.json["residual"], 0.8, options)
        self.assertEqual(read_npy(self.path("out.npy").read_bytes())[0][0], 2)

    def test_wrong_usage(self):
        source = self.path("capture.json")
        self.assertIn("no camera 'c9'; the capture has north",
                      self.fails(2, "reconstruct", source, "-o", self.path("x.npy"), "--hold-out", "c9"))
        self.assertIn("--resolution", self.fails(2, "reconstruct", source, "-o", self.path("x.npy"), "--resolution", "8,8"))
        self.assertIn("--rms", self.fails(2, "reconstruct", source, "-o", self.path("x.npy"), "--rms", "0.1"))
        self.assertIn("frames 10 to 13", self.fails(2, "reconstruct", source, "-o", self.path("x.npy"), "--frames", "40:50"))
        self.assertIn("--report", self.fails(2, "reconstruct", source, "-o", self.path("x.npy"), "--report",
                                             self.path("r.txt")))
        self.assertIn("x.xyz", self.fails(2, "reconstruct", source, "-o", self.path("x.xyz"), "--iterations", 1))
        for words, said in ((("--regularization", "none", "--lambda", ".5"), "--lambda: has no effect with the regularization none"),
                            (("--regularization", "smooth", "--sparsity", "50"), "--sparsity: has no effect with the regularization smooth"),
                            (("--solver", "mlem", "--lambda", ".5"), "--lambda: has no effect with the solver mlem"),
                            (("--solver", "mlem", "--temporal", "1"), "--temporal: has no effect with the solver mlem"),
                            (("--temporal", "1", "--lighting", "single-scattering"), "--temporal: has no effect on a medium that lamps light"),
                            (("--temporal", "1", "--frames", "10"), "--temporal: has no effect on 1 frame: it needs")):
            self.assertIn(said, self.fails(2, "reconstruct", source, "-o", self.path("x.npy"), *words))


class Interrupted(ring.TestCase):
    OPTIONS = ["--iterations", "2000", "--regularization", "none"]

    def command(self, *more):
        return ["reconstruct", self.path("capture.json"), "-o", self.path("out.npy"), *self.OPTIONS, *more]

    def interrupt(self, *more):
        """Stops the program once it has finished a frame."""
        process = subprocess.Popen([support.PROGRAM, *map(str, self.command(*more))], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE)
        end = time.monotonic() + 60
        while not list(self.path("out.npy.work").glob("frame_000011.*.json")) and time.monotonic() < end:
            self.assertIsNone(process.poll(), "ended before it could be stopped")
            time.sleep(0.002)
        process.send_signal(signal.SIGINT)
        message = process.communicate(timeout=60)[1].decode()
        self.assertEqual(process.returncode, -signal.SIGINT, message)
        self.assertIn("finished frames are kept in", message)
        self.assertFalse(self.path("out.npy").exists())

    def test_goes_on_where_it_was(self):
        self.works(*self.command())
        whole = self.path("out.npy").read_bytes()
        self.path("out.npy").unlink()
        self.assertFalse(self.path("out.npy.work").exists())
        self.interrupt()
        result = self.works(*self.command())
        self.assertRegex(result.message, r"an earlier run finished [23] of 4 frames")
        self.assertEqual(self.path("out.npy").read_bytes(), whole)
        self.assertFalse(self.path("out.npy.work").exists())

    def test_damaged_frames_are_solved_again(self):
        command = ["reconstruct", self.path("capture.json"), "-o", self.path("out.volute"), "--iterations", 20, "--regularization", "none",
                   "--frames", "10:13", "--error-bars", "--velocity"]
        self.works(*command)
        whole = self.path("out.volute").read_bytes()
        self.path("r.html").mkdir()
        key = "?" * 16
        for folder, name, lost in (("", key + ".json", 1), ("", key + ".values", 1), ("", "*-sigma.values", 1), ("", "*-sigma.json", 1),
                                   (".velocity", "*.json", 0), (".velocity", "*.values", 0)):
            with self.subTest(folder + name):
                self.assertEqual(support.volute(*command, "--report", self.path("r.json")).code, 1)  # at its end
                damaged, = self.path(f"out.volute{folder}.work").glob("frame_000011." + name)
                damaged.write_bytes(bytes(damaged.stat().st_size))
                message = self.works(*command).message
                self.assertIn(f"finished {3 - lost} of 3 frames", message)
                self.assertEqual("frame 11 is damaged, and solved again" in message, lost == 1, message)
                self.assertEqual(self.path("out.volute").read_bytes(), whole)
                self.assertEqual([name for name in self.files() if ".work" in name], [])

    def test_other_options_or_pictures_begin_anew(self):
        self.interrupt()
        other = ["reconstruct", self.path("capture.json"), "-o", self.path("out.npy"), "--iterations", 3]
        self.assertIn("finished 0 of 4 frames", self.works(*other, "--regularization", "none").message)
        self.path("out.npy").unlink()
        self.interrupt()
        self.change("c1", 11, lambda picture: None)  # the same values, but another file
        self.assertIn("finished 1 of 4 frames", self.works(*self.command()).message)


class Memory(ring.TestCase):
    SIDE = 48  # 1.3 MB a frame

    def held(self, frames, output):
        """The most memory that the program held [MB]."""
        code, message, peak = self.peak("reconstruct", self.path("capture.json"), "-o", self.path(output),
                                        "--frames", f"10:{10 + frames}", "--resolution", self.SIDE, "--iterations", 5,
                                        "--regularization", "none", "--threads", 1)
        self.assertEqual(code, 0, message)
        return peak / (1 << 20)

    def test_does_not_grow_with_the_sequence(self):
        for frame in range(14, 23):
            for name in ring.NAMES:
                os.link(self.path(f"{name}_{10 + frame % 4:04d}.exr"), self.path(f"{name}_{frame:04d}.exr"))
        self.json["frames"] = list(range(10, 23))
        self.write_capture()
        few, many = self.held(3, "few.npy"), self.held(13, "many.npy")
        self.assertLess(many, few + 4 * 3 * self.SIDE ** 3 * 4 / 1e6, "less than four frames more")


    def test_refinement_keeps_to_max_memory(self):
        for camera in self.json["cameras"][1::2]:  # so that there is something to refine
            camera["K"][0][2] += 1.5
        self.write_capture()
        limit = 96 << 20
        code, message, peak = self.peak("reconstruct", self.path("capture.json"), "-o", self.path("out.npy"), "--frames", "11:12",
                                        "--resolution", 80, "--iterations", 3, "--regularization", "none", "--refine", "always",
                                        "--threads", 1, "--max-memory", "96M")
        self.assertEqual(code, 0, message)
        self.assertIn("calibration refined with the volume", message)
        self.assertLess(peak, limit + (80 << 20), message)  # the program and its libraries


class Lighting(ring.TestCase):
    LAMPS = [{"kind": "sun", "direction": [1, 0, 0], "radiance": [9, 9, 9]},
             {"kind": "point", "position": [0, 0, 4], "intensity": 20}]

    def test_gives_extinction(self):
        self.json.update(lamps=self.LAMPS, albedo=0.8)
        self.write_capture()
        self.reconstruct("--frames", "11:12", "--lighting", "single-scattering", "--report", self.path("r.json"),
                         output="out.volute")
        info = self.works("info", self.path("out.volute"), "--json").json
        self.assertEqual((info["grid"], info["channels"]), ("extinction", 1))
        report = json.loads(self.path("r.json").read_text())
        self.assertEqual(report["options"]["lighting"], "single-scattering")

    def test_needs_lamps(self):
        message = self.fails(2, "reconstruct", self.path("capture.json"), "-o", self.path("out.npy"), "--lighting",
                             "single-scattering")
        self.assertIn("states no lamps", message)


class Parts(ring.TestCase):
    def test_parts_of_a_sequence_join(self):
        for name, frames in (("a", "10:12"), ("b", "12:14"), ("whole", "10:14")):
            self.reconstruct("--frames", frames, "--no-warm-start", output=f"{name}.volute")
        said = self.works("join", self.path("b.volute"), self.path("a.volute"), "-o", self.path("c.volute"), "--json").json
        self.assertEqual((said["frames"], said["exact"]), (4, False))
        whole = self.works("info", self.path("whole.volute"), "--json").json
        joined = self.works("info", self.path("c.volute"), "--json").json
        for key in ("frames", "frame_numbers", "times", "size", "bounds", "channels", "grid", "basis"):
            self.assertEqual(joined[key], whole[key], key)
        self.assertLessEqual(said["relative_rms"], 2.2e-3)
        far = self.works("compare", self.path("whole.volute"), self.path("c.volute"), "--json").json
        self.assertLessEqual(far["relative_rms"], said["relative_rms"] + 1e-3)
        self.works("extract", self.path("c.volute"), "-o", self.path("x.npy"), "--frames", "11:13")
        self.assertEqual(read_npy(self.path("x.npy").read_bytes())[0], (2, 16, 16, 16, 3))

    def test_whole_blocks_are_copied(self):
        shape, values = support.plume(16, 8)
        support.write_npy(self.path("p.npy"), (32,) + shape[1:], list(values) * 2)
        for name, frames in (("a", "0:16"), ("b", "16:32")):
            self.works("compress", self.path("p.npy"), "-o", self.path(f"{name}.volute"), "--rms", "0.002", "--frames", frames)
            self.works("extract", self.path(f"{name}.volute"), "-o", self.path(f"{name}.npy"))
        said = self.works("join", self.path("a.volute"), self.path("b.volute"), "-o", self.path("c.volute"), "--json").json
        self.assertEqual((said["exact"], said["relative_rms_to_parts"]), (True, 0))
        self.works("extract", self.path("c.volute"), "-o", self.path("c.npy"))
        self.assertEqual(list(read_npy(self.path("c.npy").read_bytes())[1]),
                         [value for name in "ab" for value in read_npy(self.path(f"{name}.npy").read_bytes())[1]])

    def test_refuses_what_does_not_fit(self):
        a, b = self.make_volute("a.volute", frames=2), self.make_volute("b.volute", frames=2, size=8)
        self.assertIn("do not fit together", self.fails(1, "join", a, b, "-o", self.path("c.volute")))
        before = a.read_bytes()
        self.assertIn("is read and would be replaced", self.fails(2, "join", a, b, "-o", a))
        self.assertEqual(a.read_bytes(), before)
        self.assertIn("do not overlap", self.fails(1, "join", a, a, "-o", self.path("c.volute")))
        self.assertIn(".volute", self.fails(2, "join", a, self.path("truth.npy"), "-o", self.path("c.volute")))


if __name__ == "__main__":
    support.main()
