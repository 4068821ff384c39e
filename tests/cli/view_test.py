# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""The viewer without a display: its frame as a picture."""
import json
import os

import ring
import support
from support import volute, write_npy


class View(support.TestCase):
    def setUp(self):
        super().setUp()
        if "view" not in volute("help").text:
            self.skipTest("this build has no viewer")
        probe = volute("info", "--gl")
        if probe.code != 0:
            self.skipTest(probe.message.strip())

    def volume(self):
        values = [float(2 <= x + 3 * t < 5 and 2 < y < 7 and 2 < z < 7) for t in range(2) for z in range(10)
                  for y in range(10) for x in range(10)]
        write_npy(self.path("v.npy"), (2, 10, 10, 10), values)
        return self.path("v.npy")

    def frame(self, *arguments):
        self.works("view", *arguments, "--screenshot", self.path("s.png"), "--size", "320x200")
        data = self.path("s.png").read_bytes()
        self.path("s.png").unlink()
        return data

    def test_a_screenshot_shows_the_time(self):
        first = self.frame(self.volume(), "--no-panels")
        later = self.frame(self.volume(), "--no-panels", "--time", "0.04")
        self.assertNotEqual(first, later)
        self.assertEqual(first, self.frame(self.volume(), "--no-panels"))

    def test_json_names_the_picture(self):
        result = self.works("view", self.volume(), "--screenshot", self.path("s.png"), "--size", "320x200", "--json")
        report = json.loads(result.text)
        self.assertEqual((report["output"], report["width"], report["height"]), (str(self.path("s.png")), 320, 200))

    def test_another_file_is_on_the_right(self):
        alone = self.frame(self.volume(), "--no-panels")
        write_npy(self.path("empty.npy"), (2, 10, 10, 10), [0.0] * 2000)
        self.assertNotEqual(alone, self.frame(self.path("v.npy"), "--no-panels", "--compare", self.path("empty.npy")))
        message = self.fails(1, "view", self.path("v.npy"), "--compare", self.path("gone.npy"), "--screenshot", self.path("s.png"))
        self.assertIn("gone.npy", message)

    def test_a_time_past_the_end_is_refused(self):
        message = self.fails(2, "view", self.volume(), "--time", "99", "--screenshot", self.path("s.png"), "--size", "160x100")
        self.assertIn("--time: 99 s is past the end", message)
        self.assertIn("2 frames from 0 to 0.04 s", message)
        self.assertFalse(self.path("s.png").exists())
        self.path("loop.json").write_text(json.dumps({
            "format": "volute-scene-1", "camera": {"eye": [0.5, -2, 0.5], "target": [0.5, 0.5, 0.5], "fov": 40},
            "media": [{"kind": "volume", "file": "v.npy", "time": {"loop": True}}]}))
        self.assertNotEqual(self.frame(self.path("loop.json"), "--no-panels", "--time", "99"), b"")

    def test_a_capture_has_its_own_rate(self):
        self.path("capture.json").write_text(json.dumps(ring.capture() | {"frames_per_second": 10}))
        message = self.fails(2, "view", self.path("capture.json"), "--time", "99", "--screenshot", self.path("s.png"))
        self.assertIn("4 frames from 0 to 0.3 s", message)

    def test_time_0_is_taken_whatever_the_scene_says(self):
        self.volume()
        self.path("late.json").write_text(json.dumps({
            "format": "volute-scene-1", "camera": {"eye": [0.5, -2, 0.5], "target": [0.5, 0.5, 0.5], "fov": 40},
            "media": [{"kind": "volume", "file": "v.npy"}], "view": {"time": 0.04, "exposure": 1}}))
        self.assertNotEqual(self.frame(self.path("late.json"), "--no-panels"),
                            self.frame(self.path("late.json"), "--no-panels", "--time", "0"))
        self.assertEqual(self.frame(self.path("late.json"), "--no-panels"),
                         self.frame(self.path("late.json"), "--no-panels", "--time", "0.04"))

    def test_who_draws_is_chosen(self):
        off = os.environ | {"VOLUTE_CPU_RENDERER": "off"}
        picture = ("--screenshot", self.path("s.png"), "--size", "160x100")
        result = volute("view", self.volume(), "--renderer", "cpu", *picture, env=off)
        self.assertEqual(result.code, 1)
        self.assertIn("VOLUTE_CPU_RENDERER", result.message)
        self.assertFalse(self.path("s.png").exists())
        result = volute("view", self.volume(), "--renderer", "gl", *picture, env=off)
        self.assertEqual(result.code, 0, result.message)
        self.assertTrue(self.path("s.png").exists())
        self.assertIn("--renderer gl", self.fails(2, "view", self.volume(), "--renderer", "cpu", "--smoke-method", "march", *picture))

    def test_options_that_would_change_nothing_are_refused(self):
        picture = ("--screenshot", self.path("s.png"), "--size", "160x100")
        self.assertIn("--quantity is for smoke on meshes; ", self.fails(2, "view", self.volume(), "--quantity", "extinction", *picture))
        self.path("scene.json").write_text(json.dumps({"format": "volute-scene-1"}))
        self.assertIn("--mode is for FDS cases and smoke on meshes; ",
                      self.fails(2, "view", self.path("scene.json"), "--mode", "threshold", *picture))

    def test_panels_are_on_it(self):
        self.assertNotEqual(self.frame(self.volume()), self.frame(self.volume(), "--no-panels"))

    def test_a_volute_file_and_a_scene(self):
        self.frame(self.make_volute())
        self.volume()
        self.path("scene.json").write_text(json.dumps({
            "format": "volute-scene-1", "camera": {"eye": [0.5, -2, 0.5], "target": [0.5, 0.5, 0.5], "fov": 40},
            "background": [0.2, 0.2, 0.4], "media": [{"kind": "volume", "file": "v.npy", "extinction": 2}]}))
        self.frame(self.path("scene.json"))

    def test_a_damaged_file_is_shown_as_far_as_it_is_intact(self):
        whole = self.make_volute(frames=4)
        data = whole.read_bytes()
        self.path("cut.volute").write_bytes(data[:len(data) * 3 // 4])
        self.assertNotEqual(self.frame(self.path("cut.volute")), self.frame(whole))
        for name, words in {
                "media": {"media": [{"kind": "volume", "file": "cut.volute"}]},
                "board": {"billboards": [{"volume": "cut.volute", "position": [0.5, 0.5, 0.5], "size": [1, 1]}]}}.items():
            camera = {"eye": [0.5, -2, 0.5], "target": [0.5, 0.5, 0.5], "fov": 40}
            scene = {"format": "volute-scene-1", "camera": camera, **words}
            self.path(name + ".json").write_text(json.dumps(scene))
            self.frame(self.path(name + ".json"))
        self.path("stub.volute").write_bytes(data[:20])
        self.assertIn("ends at byte 20", self.fails(1, "view", self.path("stub.volute"), "--screenshot", self.path("s.png")))

    def test_a_screenshot_needs_a_file(self):
        self.fails(2, "view", "--screenshot", self.path("s.png"))

    def test_errors_are_sentences(self):
        self.assertIn("missing.npy", self.fails(1, "view", self.path("missing.npy"), "--screenshot", self.path("s.png")))
        self.fails(2, "view", self.volume(), "--screenshot", self.path("s.jpg"))

    def test_without_a_display_a_window_is_an_error(self):
        environment = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
        result = volute("view", self.volume(), env=environment)
        self.assertEqual(result.code, 1)
        self.assertIn("--screenshot", result.message)


if __name__ == "__main__":
    support.main()
