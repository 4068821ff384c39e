#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Velocities of reconstructed frames, and frames between them that are drawn along these velocities."""
import json
import math

import ring
import support
from pictures import read_exr
from support import read_npy, write_npy

SIDE, FRAMES, FIRST = 24, 5, 10
STEP = 1.2  # voxels along x in a frame
SPEED = STEP * 2 / SIDE * 20  # [m/s] of a volume of 2 m at 20 frames a second


def puffs(time):
    """Four puffs that move along x; values of a frame."""
    values = []
    centres = [(7, 12, 9, 3.5), (10, 8, 12, 2.5), (6, 14, 13, 2.5), (9, 13, 6, 2.5)]
    for z in range(SIDE):
        for y in range(SIDE):
            for x in range(SIDE):
                value = 0
                for cx, cy, cz, radius in centres:
                    square = ((x - cx - STEP * time) ** 2 + (y - cy) ** 2 + (z - cz) ** 2) / radius ** 2
                    value += max(0.0, 1 - square) ** 2
                values.append(value)
    return values


class Motion(ring.TestCase):
    def setUp(self):
        super().setUp()
        values = []
        for frame in range(FRAMES):
            values.extend(puffs(frame))
        write_npy(self.path("moving.npy"), (FRAMES, SIDE, SIDE, SIDE), values)
        self.json["frames"] = list(range(FIRST, FIRST + FRAMES))
        self.json["frames_per_second"] = 20
        self.json["volume"]["resolution"] = [SIDE] * 3
        for camera in self.json["cameras"]:
            camera["image"] = camera["name"] + "_m%04d.exr"
        self.write_capture()
        self.works("project", self.path("moving.npy"), self.path("capture.json"), "-o", self.path("{camera}_m%04d.exr"))

    def reconstruct(self, *options, output):
        return self.works("reconstruct", self.path("capture.json"), "-o", self.path(output), "--iterations", 60, *options)

    def check_velocity(self, velocity, light):
        """The mean over the light."""
        sums, weight = [0, 0, 0], 0
        for i, value in enumerate(light):
            weight += value
            for axis in range(3):
                sums[axis] += value * velocity[3 * i + axis]
        self.assertAlmostEqual(sums[0] / weight, SPEED, delta=0.05 * SPEED)
        self.assertAlmostEqual(sums[1] / weight, 0, delta=0.05 * SPEED)
        self.assertAlmostEqual(sums[2] / weight, 0, delta=0.05 * SPEED)

    def test_velocity_is_a_grid_of_its_own(self):
        result = self.reconstruct("--velocity", "--report", self.path("r.json"), "--json", output="out.volute")
        self.assertAlmostEqual(result.json["mean_speed"], SPEED, delta=0.06 * SPEED)
        report = json.loads(self.path("r.json").read_text())
        self.assertEqual([pair["frames"] for pair in report["velocity"]["pairs"]],
                         [[FIRST + i, FIRST + i + 1] for i in range(FRAMES - 1)])
        grids = {grid["name"]: grid for grid in self.works("info", self.path("out.volute"), "--json").json["grids"]}
        self.assertEqual(sorted(grids), ["emission", "velocity"])
        self.works("extract", self.path("out.volute"), "-o", self.path("x_{grid}.npy"))
        (_, light), (shape, velocity) = (read_npy(self.path(f"x_{name}.npy").read_bytes()) for name in ("emission", "velocity"))
        self.assertEqual(shape, (FRAMES, SIDE, SIDE, SIDE, 3))
        light = light[0::len(light) // (FRAMES * SIDE ** 3)]
        self.check_velocity(velocity, light)
        self.assertEqual([name for name in self.files() if ".work" in name], [])

    def test_frames_between_are_drawn_along_it(self):
        self.reconstruct("--velocity", output="out.volute")
        # Without frame 12, 1.2 voxels each way, as a frame between 11 and 13 it is drawn from them.
        self.reconstruct("--velocity", "--frames", "11:14:2", output="gap.volute")
        view = ("--eye", "0,-5,0", "--target", "0,0,0", "--fov", 26, "--size", "64x64", "--light", "additive")
        seen = {}
        for name, source, options in (("truth", "out", ()), ("velocity", "gap", ("--interpolate", "velocity")),
                                      ("linear", "gap", ("--interpolate", "linear")), ("held", "gap", ())):
            time = "0.1" if source == "out" else "0.1"
            self.works("render", self.path(f"{source}.volute"), "-o", self.path(f"{name}.exr"), "--time", time, *view[:-2], *options)
            seen[name] = read_exr(self.path(f"{name}.exr")).values
        off = {name: math.sqrt(sum((a - b) ** 2 for a, b in zip(values, seen["truth"])) / sum(b * b for b in seen["truth"]))
               for name, values in seen.items()}
        self.assertLess(off["velocity"], 0.5 * off["linear"], off)
        self.assertLess(off["velocity"], 0.3 * off["held"], off)

    def test_files_of_other_kinds(self):
        self.reconstruct("--velocity", "--frames", "10:12", output="x_{grid}.npy")
        (_, light), (shape, velocity) = (read_npy(self.path(f"x_{name}.npy").read_bytes()) for name in ("emission", "velocity"))
        self.assertEqual(shape, (2, SIDE, SIDE, SIDE, 3))
        self.check_velocity(velocity, light[0::len(light) // (2 * SIDE ** 3)])
        source = self.path("capture.json")
        self.assertIn("{grid}", self.fails(2, "reconstruct", source, "-o", self.path("y.npy"), "--velocity"))
        self.assertIn("two frames", self.fails(2, "reconstruct", source, "-o", self.path("y.volute"), "--velocity", "--frames", "10"))
        self.assertEqual([name for name in self.files() if name.startswith("y")], [])

    def test_a_temporal_prior_holds_frames_together(self):
        def unrest(output):
            """How much the light of all voxels changes from frame to frame."""
            _, values = read_npy(self.path(output).read_bytes())
            size = len(values) // FRAMES
            return sum(abs(a - b) for a, b in zip(values[size:], values[:-size]))
        self.reconstruct("--regularization", "none", output="free.npy")
        self.reconstruct("--regularization", "none", "--temporal", "0.3", output="held.npy")
        self.assertLess(unrest("held.npy"), unrest("free.npy"))


if __name__ == "__main__":
    support.main()
