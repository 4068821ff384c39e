# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""The viewer's real window, on an X server without a screen."""
import os
import tempfile
import unittest

import support
import x_display
from support import PROGRAM, volute


def bright(width, height, data):
    """Whether the middle of the screen shows light."""
    row = data[4 * (height // 2) * width:4 * (height // 2 + 1) * width]
    return max(row[4 * (width // 3):4 * (2 * width // 3)]) > 60


class Window(support.TestCase):
    def setUp(self):
        super().setUp()
        if "view" not in volute("help").text:
            self.skipTest("this build has no viewer")
        if x_display.missing():
            self.assertNotIn("VOLUTE_TESTS_NEED_GL", os.environ, x_display.missing())
            self.skipTest(x_display.missing())

    def test_opens_shows_listens_and_closes(self):
        volume = self.make_npy(frames=2, size=16)
        environment = {k: v for k, v in os.environ.items() if k != "WAYLAND_DISPLAY"}
        with tempfile.TemporaryDirectory() as screen, x_display.Display(screen) as display:
            arguments = [PROGRAM, "view", volume, "--size", "640x400"]
            with x_display.running(arguments, display, environment, self.folder) as process:
                window = display.window(b"Volute")
                before = display.wait_for(bright, "no picture appeared")[2]
                display.press(window, "F1")
                display.wait_for(lambda w, h, data: data != before, "F1 changed nothing")
                display.press(window, "F12")
                display.wait_for(lambda *_: self.path("volute_0001.png").exists(), "F12 wrote no picture")
                display.press(window, "F12", control=True)
                page = self.path("volute_0001.html")
                display.wait_for(lambda *_: page.exists(), "Ctrl F12 wrote no report")
                self.assertIn("SHA-256", page.read_text())
                display.resize(window, 320, 240)
                black = lambda w, h, data: not any(data[4 * (300 * w + 400):4 * (300 * w + 500)])
                display.wait_for(black, "the window did not become smaller")
                display.close(window)
                self.assertEqual(process.wait(timeout=120), 0, process.stderr.read())

    def test_a_driver_of_less_than_opengl_4_5_shows_what_the_cpu_draws(self):
        volume = self.make_npy(frames=1, size=16)
        environment = {k: v for k, v in os.environ.items() if k != "WAYLAND_DISPLAY"}
        for driver in ({"LIBGL_ALWAYS_SOFTWARE": "1", "GALLIUM_DRIVER": "softpipe"}, {"MESA_GL_VERSION_OVERRIDE": "3.3"}):  # of OpenGL 3.3
            with self.subTest(driver=driver), tempfile.TemporaryDirectory() as screen, x_display.Display(screen) as display:
                arguments = [PROGRAM, "view", volume, "--size", "640x400"]
                with x_display.running(arguments, display, environment | driver, self.folder) as process:
                    window = display.window(b"Volute")
                    display.wait_for(bright, "no picture appeared")
                    display.close(window)
                    self.assertEqual(process.wait(timeout=120), 0, process.stderr.read())


if __name__ == "__main__":
    support.main()
