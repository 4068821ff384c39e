# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""docs/scene.schema.json is made of the tables that the reader of scenes has. Scenes that other tests render are checked where they are
rendered (support.py)."""
import json
import re

import schema
import support

class Schema(support.TestCase):
    def test_it_is_what_the_program_writes(self):
        stale = "docs/scene.schema.json is stale; run tests/cli/docs_test.py --update"
        self.assertEqual(json.dumps(schema.SCENE, indent=1), json.dumps(json.loads(support.volute("man", "--schema").text), indent=1), stale)

    def test_scenes_of_the_documentation_are_valid(self):
        scenes = 0
        pages = sorted((schema.ROOT / "docs").glob("*.md")) + [schema.ROOT / "README.md"]
        for page in (page for page in pages if page.name != "own-media.md"):  # whose kinds no schema knows
            for block in re.findall(r"(?:^    .*\n)+", page.read_text(), re.M):
                if '"format": "volute-scene-' not in block:
                    continue
                scenes += 1
                self.assertEqual(schema.faults(json.loads(block)), [], page)
        self.assertGreaterEqual(scenes, 1)

    def test_it_finds_faults(self):
        camera = {"eye": [0, 0, 1], "target": [0, 0, 0], "fov": 50}
        good = {"format": "volute-scene-1", "camera": camera}
        self.assertEqual(schema.faults(good), [])
        for change in ({"format": "volute-scene-3"}, {"camera": camera | {"ortho": 1}}, {"camera": {"eye": [0, 0, 0]}},
                       {"medium": []}, {"media": [{"kind": "volume"}]}, {"media": [{"kind": "water", "file": "x"}]},
                       {"lights": [{"kind": "sun", "direction": [0, 0]}]}, {"background": [0, 0, True]},
                       {"media": [{"kind": "fog", "map": "x.png", "degree": 4}]},
                       {"media": [{"kind": "smoke", "case": "a.smv", "quantity": "extinction"}]},
                       {"media": [{"kind": "smoke", "case": "a.pvd", "quantity": "extinction", "fire": False}]},
                       {"geometry": [{"file": "a.obj", "transform": [1] * 15}]}):
            self.assertNotEqual(schema.faults(good | change), [], change)


if __name__ == "__main__":
    support.main()
