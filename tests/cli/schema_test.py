# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""docs/scene.schema.json says what the reader of scenes takes. Scenes that other tests render are checked where they are
rendered (support.py)."""
import json
import re

import schema
import support

SOURCES = ("scene_file", "scene_lights", "scene_look", "scene_geometry", "scene_smoke", "fds_look", "scene_signs", "fog_file", "clock",
           "volume_kind", "billboard_file")


def objects(node, name="scene"):
    """(name, its members) of every object of the schema that takes no others."""
    if isinstance(node, dict):
        if node.get("additionalProperties") is False:
            yield name, frozenset(node["properties"])
        for key, child in node.items():
            yield from objects(child, key)
    elif isinstance(node, list):
        for child in node:
            yield from objects(child, name)


class Schema(support.TestCase):
    def test_it_names_the_members_that_the_reader_names(self):
        read = set()
        for source in SOURCES:
            text = next((schema.ROOT / "src/volute").rglob(f"{source}.cpp")).read_text()
            for names in re.findall(r"kNames\[\] = \{(.*?)\};", text, re.S):
                read.add(frozenset(re.findall(r'"(\w+)"', names)))
        written = dict(objects(schema.SCENE))
        self.assertGreater(len(read), 10)
        self.assertEqual({tuple(sorted(names)) for names in read}, {tuple(sorted(names)) for names in written.values()})

    def test_members_of_the_camera_are_those_that_are_read(self):
        text = (schema.ROOT / "src/volute/media/camera_file.cpp").read_text()
        read = set(re.findall(r'json\["(\w+)"\]', text)) - {"camera"}
        self.assertEqual(read, set(schema.SCENE["$defs"]["camera"]["properties"]))

    def test_scenes_of_the_documentation_are_valid(self):
        scenes = 0
        for page in sorted((schema.ROOT / "docs").glob("*.md")) + [schema.ROOT / "README.md"]:
            for block in re.findall(r"(?:^    .*\n)+", page.read_text(), re.M):
                if '"format": "volute-scene-1"' not in block:
                    continue
                scenes += 1
                self.assertEqual(schema.faults(json.loads(block)), [], page)
        self.assertGreaterEqual(scenes, 1)

    def test_it_finds_faults(self):
        camera = {"eye": [0, 0, 1], "target": [0, 0, 0], "fov": 50}
        good = {"format": "volute-scene-1", "camera": camera}
        self.assertEqual(schema.faults(good), [])
        for change in ({"format": "volute-scene-2"}, {"camera": camera | {"ortho": 1}}, {"camera": {"eye": [0, 0, 0]}},
                       {"medium": []}, {"media": [{"kind": "volume"}]}, {"media": [{"kind": "water", "file": "x"}]},
                       {"lights": [{"kind": "sun", "direction": [0, 0]}]}, {"background": [0, 0, True]},
                       {"media": [{"kind": "fog", "map": "x.png", "degree": 4}]},
                       {"geometry": [{"file": "a.obj", "transform": [1] * 15}]}):
            self.assertNotEqual(schema.faults(good | change), [], change)


if __name__ == "__main__":
    support.main()
