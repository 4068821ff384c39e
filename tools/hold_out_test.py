#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Tests of hold_out.py: `python3 tools/hold_out_test.py`."""
import math
import pathlib
import sys
import tempfile
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parent))
import hold_out

BLOBS = [((0.1, 0.0, -0.1), 0.08), ((-0.2, 0.15, 0.1), 0.1), ((0.15, -0.2, 0.2), 0.06), ((-0.1, -0.15, -0.2), 0.07)]


def seen_by(camera):
    """Gaussian blobs, each drawn as a Gaussian of its size in the picture: enough of a picture to fit a camera to."""
    x, y = np.meshgrid(np.arange(camera["width"]) + 0.5, np.arange(camera["height"]) + 0.5)
    picture = np.zeros(x.shape)
    for place, radius in BLOBS:
        at = np.array(camera["R"]) @ np.array(place) + np.array(camera["t"])
        middle = np.array(camera["K"]) @ at / at[2]
        size = camera["K"][0][0] * radius / at[2]
        picture += 0.5 * np.exp(-((x - middle[0]) ** 2 + (y - middle[1]) ** 2) / (2 * size * size))
    return np.repeat(picture[None, :, :, None], 3, 3)


class Registration(unittest.TestCase):
    CAMERA = {"name": "c", "image": "c.png", "width": 72, "height": 96, "K": [[150.0, 0, 36], [0, 150.0, 48], [0, 0, 1]],
              "R": np.eye(3).tolist(), "t": [0.0, 0.0, 1.5]}

    def test_a_camera_that_moved_is_found(self):
        change = np.array([0.02, -0.015, 0.01, 0.01, -0.02, 0.03, 0.02])
        truth = hold_out.changed(self.CAMERA, change, np.zeros(3))
        taken = 0.9 * seen_by(truth)
        fitted, gain, _ = hold_out.register(lambda cameras, frames: [seen_by(c) for c in cameras], self.CAMERA, taken, [0], np.zeros(3), 20)
        self.assertLess(np.abs(gain * seen_by(fitted) - taken).max(), 2e-3)
        self.assertAlmostEqual(gain, 0.9, places=2)
        moved = [np.linalg.norm(hold_out.moved_pixels(truth, fitted, np.array(place))) for place, _ in BLOBS]
        self.assertLess(max(moved), 0.05)

    def test_a_camera_that_is_right_stays(self):
        fitted, gain, change = hold_out.register(lambda cameras, frames: [seen_by(c) for c in cameras], self.CAMERA, seen_by(self.CAMERA), [0],
                                                 np.zeros(3))
        self.assertLess(np.abs(change).max(), 1e-9)
        self.assertAlmostEqual(gain, 1)
        self.assertEqual(fitted["K"], self.CAMERA["K"])

    def test_what_noise_leaves_open_stays(self):
        noise = np.random.default_rng(1).normal(0, 0.02, (1, 96, 72, 3))
        _, _, change = hold_out.register(lambda cameras, frames: [seen_by(c) for c in cameras], self.CAMERA, seen_by(self.CAMERA) + noise, [0], np.zeros(3))
        self.assertLess(np.abs(change).max(), 0.02)

    def test_turning_keeps_the_middle_of_the_volume(self):
        middle = np.array([0.3, -0.2, 0.1])
        turned = hold_out.changed(self.CAMERA, np.array([0.1, 0.2, -0.1, 0, 0, 0, 0]), middle)
        self.assertLess(np.linalg.norm(hold_out.moved_pixels(self.CAMERA, turned, middle)), 1e-9)
        rotation = np.array(turned["R"])
        self.assertLess(np.abs(rotation @ rotation.T - np.eye(3)).max(), 1e-12)


class Pictures(unittest.TestCase):
    def test_psnr_is_against_the_full_scale(self):
        self.assertAlmostEqual(hold_out.psnr(np.full((4, 4, 3), 0.6), np.full((4, 4, 3), 0.5)), 20)
        self.assertEqual(hold_out.psnr(np.full((4, 4, 3), 1.5), np.ones((4, 4, 3))), math.inf)     # what is above it is limited

    def test_png_has_its_pixels(self):
        values = np.zeros((3, 5, 3))
        values[1, 2] = (1, 0.5, 0.25)
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "x.png"
            hold_out.write_png(path, values)
            data = path.read_bytes()
        self.assertTrue(data.startswith(b"\x89PNG\r\n\x1a\n") and data.endswith(b"IEND\xaeB`\x82"))
        self.assertEqual((int.from_bytes(data[16:20], "big"), int.from_bytes(data[20:24], "big")), (5, 3))

    def test_names_of_pictures(self):
        self.assertEqual(hold_out.file_of("cam_%04d.png", 7), "cam_0007.png")
        self.assertEqual(hold_out.file_of("cam_####.png", 123), "cam_0123.png")
        self.assertEqual(hold_out.file_of("one.png", 3), "one.png")

    def test_runs_of_frames(self):
        self.assertEqual(hold_out.runs_of([1, 2, 3, 7, 9, 10]), [[1, 3], [7, 7], [9, 10]])


if __name__ == "__main__":
    unittest.main()
