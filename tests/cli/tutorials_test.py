# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Every command of docs/tutorials runs as it stands, in the order of its page, in an empty folder."""
import json
import os
import pathlib
import re
import subprocess
import unittest

import support

PAGES = pathlib.Path(__file__).parents[2] / "docs/tutorials"


class Tutorials(support.TestCase):
    def follow(self, name, *left):
        """Runs a page's blocks; each of `left` is a file that must be there after them."""
        blocks = re.findall(r"^```sh\n(.*?)^```", (PAGES / f"{name}.md").read_text(), re.M | re.S)
        self.assertGreater(len(blocks), 3)
        folder = self.path("somewhere")
        folder.mkdir()
        # Under its own name: the page says `volute`.
        (self.path("bin")).mkdir()
        (self.path("bin") / "volute").symlink_to(pathlib.Path(support.PROGRAM).resolve())
        environment = os.environ | {"PATH": f"{self.path('bin')}:{os.environ['PATH']}"}
        for block in blocks:
            done = subprocess.run(["bash", "-euc", block], cwd=folder, env=environment, capture_output=True, text=True,
                                  timeout=240)
            if re.search(r"this build has no \w+", done.stderr):
                raise unittest.SkipTest(done.stderr)
            self.assertEqual(done.returncode, 0, f"{block}\n{done.stdout}\n{done.stderr}")
        for file in left:
            self.assertGreater((folder / file).stat().st_size, 0, file)
        return folder

    def test_effects(self):
        self.follow("effects", "cache.png", "cache.volute", "cache.mp4", "scene.png", "middle_0004.vdb")

    def test_fire_safety(self):
        folder = self.follow("fire-safety", "hall.png", "seen/report.html", "seen/visibility.json", "signed/areas.csv",
                             "people/visibility.json", "margin/margin.png", "walked/report.html", "of_the_mesh/report.html")
        results = {name: json.loads((folder / name / "visibility.json").read_text()) for name in ("seen", "margin", "walked", "people")}
        # The room on fire is lost first: after the beginning, beside the fire, before the hall.
        first = results["seen"]["verdict"][0]
        self.assertTrue(first["known"])
        self.assertEqual(first["time"], 20)
        self.assertGreater(first["position"][0], 20.6)
        self.assertIn("ASET - RSET: the smallest margin is 9", " ".join(one["sentence"] for one in results["margin"]["verdict"]))
        # Nobody loses anything before the start.
        self.assertIn("starts at 30 s", results["walked"]["verdict"][0]["sentence"])
        self.assertIn("reached on the way: visibility at 30 s", results["walked"]["verdict"][0]["sentence"])
        self.assertEqual([one["people"] for one in results["people"]["people"]][:8], [0, 0, 1, 1, 1, 1, 1, 1])

    def test_cameras(self):
        self.follow("cameras", "capture.volute", "report.html", "new.png", "new.mp4", "fire.npy")

    def test_no_page_is_left_out(self):
        self.assertEqual(sorted(p.stem for p in PAGES.glob("*.md")), ["cameras", "effects", "fire-safety"])


if __name__ == "__main__":
    unittest.main()
