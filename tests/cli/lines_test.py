#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Volumes from optical depths along lines."""
import json
import math
import random

import support
from support import read_npy

HEAD = "x0,y0,z0,x1,y1,z1,optical_depth,sigma,frame\n"


def layer(z, frame):
    """Extinction [1/m] of smoke under a ceiling 2 m high, that comes down."""
    return 0.5 if z > 1.5 - 0.25 * frame else 0.0


def line(frame, chance):
    """A row: from wall to wall of a room of 4 x 3 x 2 m."""
    a = [chance.uniform(0, 4), 0, chance.uniform(0, 2)]
    b = [chance.uniform(0, 4), 3, chance.uniform(0, 2)]
    length = math.dist(a, b)
    steps = 400
    depth = sum(layer(a[2] + (i + 0.5) / steps * (b[2] - a[2]), frame) for i in range(steps)) * length / steps
    return ",".join(f"{x:.4f}" for x in [*a, *b, depth + chance.gauss(0, 0.01)]) + f",0.01,{frame}\n"


class Lines(support.TestCase):
    def write(self, count=150):
        chance = random.Random(2)
        self.path("lamps.csv").write_text(HEAD + "".join(line(frame, chance) for frame in (3, 4) for _ in range(count)))

    def test_extinction_comes_out(self):
        self.write()
        result = self.works("reconstruct", self.path("lamps.csv"), "-o", self.path("smoke.volute"), "--bounds", "0,0,0,4,3,2",
                            "--resolution", 16, "--report", self.path("r.json"), "--stats", self.path("s.json"), "--json")
        self.assertEqual(json.loads(self.path("s.json").read_text())["residual"], result.json["residual"])
        self.assertEqual((result.json["grid"], result.json["size"]), ("extinction", [16, 12, 8]))
        self.assertLess(result.json["left_out"], 0.15)
        info = self.works("info", self.path("smoke.volute"), "--json").json
        self.assertEqual((info["frame_numbers"], info["grid"]), ([3, 4], "extinction"))
        self.works("extract", self.path("smoke.volute"), "-o", self.path("smoke.npy"))
        shape, values = read_npy(self.path("smoke.npy").read_bytes())
        self.assertEqual(shape, (2, 8, 12, 16))
        for frame in range(2):
            layers = [sum(values[((frame * 8 + z) * 12) * 16:((frame * 8 + z + 1) * 12) * 16]) / 192 for z in range(8)]
            for z, found in enumerate(layers):
                truth = layer(0.25 * z + 0.125, frame + 3)
                self.assertAlmostEqual(found, truth, delta=0.2, msg=(frame, layers))
        report = json.loads(self.path("r.json").read_text())
        self.assertEqual([one["lines"] for one in report["lines"]], [150, 150])
        self.assertTrue(all(0 < one["spread"] < 3 for one in report["lines"]), report["lines"])

    def test_a_stated_strength_leaves_nothing_out(self):
        self.write(60)
        result = self.works("reconstruct", self.path("lamps.csv"), "-o", self.path("one.npy"), "--lambda", 0.01, "--resolution", 8,
                            "--report", self.path("r.json"), "--json")
        self.assertIsNone(result.json["left_out"])
        self.assertIn("25 frames a second are assumed", result.message)
        self.assertEqual([one["left_out"] for one in json.loads(self.path("r.json").read_text())["lines"]], [None, None])

    def test_usual_volume_and_one_frame(self):
        self.write(60)
        result = self.works("reconstruct", self.path("lamps.csv"), "-o", self.path("one.npy"), "--frames", "4")
        self.assertIn("the box around the lines' ends", result.message)
        self.assertEqual(read_npy(self.path("one.npy").read_bytes())[0][0], 1)

    def test_refusals(self):
        self.write(20)
        lamps, out = self.path("lamps.csv"), self.path("x.npy")
        self.assertIn("is for cameras", self.fails(2, "reconstruct", lamps, "-o", out, "--hold-out", "a"))
        message = self.fails(2, "reconstruct", lamps, "-o", out, "--bounds", "0,0,0,400,300,0.2")
        self.assertRegex(message, r"frame 3: row \d+: the line misses the volume .* do \d+ of 20 lines; check the bounds and the unit")
        forced = self.works("reconstruct", lamps, "-o", out, "--bounds", "0,0,1,4,3,2", "--resolution", 8, "--force")
        self.assertRegex(forced.message, r"\d+ of 20 lines of frame 3 miss the volume and are left out")
        self.path("wrong.csv").write_text("x,y,z,dx,dy,optical_depth\n0,0,0,1,0,0.5\n")
        self.assertIn("expected columns with the ends of lines", self.fails(1, "reconstruct", self.path("wrong.csv"), "-o", out))
        self.path("wrong.csv").write_text(HEAD + "0,0,0,1,1,x,0.5,0.1,3\n")
        self.assertIn("line 2: z1 is 'x'; expected a number", self.fails(1, "reconstruct", self.path("wrong.csv"), "-o", out))
        self.path("wrong.csv").write_text("x,y,z,dx,dy,dz,value\n0,0,0,1,0,0,1\n0,0,1,1,0,0,1\n")
        self.assertIn("--bounds", self.fails(2, "reconstruct", self.path("wrong.csv"), "-o", out))

    def transmittances(self, value):
        """Lines from wall to wall whose transmittances are all `value`."""
        chance = random.Random(3)
        rows = [[chance.uniform(0, 4), 0, chance.uniform(0, 2), chance.uniform(0, 4), 3, chance.uniform(0, 2), value] for _ in range(60)]
        self.path("t.csv").write_text("x0,y0,z0,x1,y1,z1,transmittance\n" + "".join(",".join(f"{x:.4f}" for x in row) + "\n" for row in rows))
        return ["reconstruct", self.path("t.csv"), "-o", self.path("t.npy"), "--bounds", "0,0,0,4,3,2", "--resolution", 8]

    def test_what_explains_nothing_is_told(self):
        said = self.works(*self.transmittances(1.03)).message
        self.assertIn("60 of 60 optical depths are negative: more light with smoke than without", said)
        self.assertIn("the volume explains next to nothing of what was measured", said)
        said = self.works(*self.transmittances(0.5)).message
        self.assertNotIn("explains next to nothing", said)
        self.assertNotIn("are negative", said)
        self.assertIn("state the least that the instrument can tell from dark, as 0.001", self.fails(1, *self.transmittances(0)))


if __name__ == "__main__":
    support.main()
