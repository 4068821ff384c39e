# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""A small capture made up of a synthesized fire: five cameras on half a ring, seen through `volute project` at another
basis and twice the resolution of what is reconstructed."""
import json
import math
import os
import pathlib
import shutil
import tempfile
import unittest

import support
from pictures import read_exr, write_exr

NAMES = ["north", "c1", "c2", "c3", "south"]
WIDTH, HEIGHT, FRAMES, SIDE = 40, 32, 4, 16


def normalised(v):
    length = math.sqrt(sum(x * x for x in v))
    return [x / length for x in v]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def pose(eye):
    """R and t of a camera at `eye` that looks at the origin, z up; x right, y down, z forward."""
    forward = normalised([-x for x in eye])
    right = normalised(cross(forward, [0, 0, 1]))
    rows = [right, cross(forward, right), forward]
    return rows, [-sum(r * e for r, e in zip(row, eye)) for row in rows]


def cameras():
    for i, name in enumerate(NAMES):
        angle = math.pi * (i + 0.3) / len(NAMES)
        R, t = pose([4 * math.cos(angle), 4 * math.sin(angle), 0.3 * i - 0.5])
        yield {"name": name, "image": f"{name}_%04d.exr", "width": WIDTH, "height": HEIGHT,
               "K": [[42 + i, 0, 20.5], [0, 42 + i, 16 - 0.25 * i], [0, 0, 1]], "R": R, "t": t}


def capture():
    """The capture.json as an object."""
    return {"format": "volute-capture-1", "color": "linear", "pixel_centre": 0.5, "frames": list(range(10, 10 + FRAMES)),
            "volume": {"min": [-1, -1, -1], "max": [1, 1, 1], "resolution": [SIDE] * 3}, "cameras": list(cameras())}


def made(folder=[]):
    """A folder with the capture and the truth at full resolution, made once for the program."""
    if not folder:
        folder.append(pathlib.Path(tempfile.mkdtemp(prefix="volute-ring-")))
        path = folder[0]
        (path / "capture.json").write_text(json.dumps(capture()))
        for command in (["synthesize", "fire", "-o", path / "truth.npy", "--size", 2 * SIDE, "--frames", FRAMES],
                        ["project", path / "truth.npy", path / "capture.json", "-o", path / "{camera}_%04d.exr", "--basis",
                         "box"]):
            done = support.volute(*command)
            if "this build has no OpenEXR" in done.message:
                raise unittest.SkipTest(done.message)
            assert done.code == 0, done.message
    return folder[0]


def clean_up():
    folder = made.__defaults__[0]
    if folder:
        shutil.rmtree(folder[0])


class TestCase(support.TestCase):
    """Each test works on a copy of the capture."""

    @classmethod
    def tearDownClass(cls):
        clean_up()
        made.__defaults__[0].clear()

    def setUp(self):
        super().setUp()
        for file in made().iterdir():
            os.link(file, self.path(file.name))
        self.json = capture()

    def write_capture(self):
        self.path("capture.json").unlink()
        self.path("capture.json").write_text(json.dumps(self.json))

    def camera(self, name):
        return next(camera for camera in self.json["cameras"] if camera["name"] == name)

    def change(self, camera, frame, how):
        """Lets `how` change a picture."""
        path = self.path(f"{camera}_{frame:04d}.exr")
        picture = read_exr(path)
        path.unlink()
        write_exr(path, how(picture) or picture)

    def reconstruct(self, *options, output="out.npy"):
        """What ends well; few iterations."""
        return self.works("reconstruct", self.path("capture.json"), "-o", self.path(output), "--iterations", 25,
                          "--regularization", "none", *options)

    def refused(self, *options):
        """The message of a capture that is refused; nothing is left behind but frames that were finished before."""
        self.write_capture()
        before = self.files()
        result = support.volute("reconstruct", self.path("capture.json"), "-o", self.path("out.npy"), "--iterations", 5,
                                "--regularization", "none", *options)
        self.assertEqual(result.code, 1, result.message)
        finished = [name for name in self.files() if name.endswith(".work")]
        self.assertEqual([name for name in self.files() if name not in finished], before)
        self.assertEqual(bool(finished), "finished frames are kept" in result.message)
        return result.message
