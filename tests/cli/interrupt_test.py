# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Ctrl-C: the command stops, says so, and leaves nothing half-written."""
import os
import signal
import subprocess
import time

import support


class Interrupt(support.TestCase):
    def start(self, *arguments):
        before = set(self.files())
        process = subprocess.Popen([support.PROGRAM, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        end = time.monotonic() + 30
        while set(self.files()) == before and process.poll() is None and time.monotonic() < end:
            time.sleep(0.005)
        self.assertIsNone(process.poll(), "ended before it could be stopped")
        return process

    def stopped(self, process, signals):
        for number in signals:
            process.send_signal(number)
        _, message = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 1, message)
        return message.decode()

    def noise(self):
        """Large enough that compressing it takes seconds; noise is the slowest."""
        frame = os.urandom(64 ** 3) * 4
        header = b"{'descr': '<f4', 'fortran_order': False, 'shape': (96, 64, 64, 64)}".ljust(117) + b"\n"
        # With 0x3f and 0x80 in the high bytes, random numbers between 1 and 2.
        values = bytearray(frame)
        values[2::4] = bytes(byte | 0x80 for byte in values[2::4])
        values[3::4] = b"\x3f" * (len(values) // 4)
        with open(self.path("noise.npy"), "wb") as file:
            file.write(b"\x93NUMPY\x01\x00\x76\x00" + header)
            for frame in range(96):
                file.write(values[1024 * frame:] + values[:1024 * frame])  # no two are alike
        return self.path("noise.npy")

    def test_compress_leaves_no_target(self):
        noise = self.noise()
        for number in (signal.SIGINT, signal.SIGTERM):
            process = subprocess.Popen([support.PROGRAM, "compress", noise, "-o", self.path("x.volute"), "--rms", "0.0001"],
                                       stdout=subprocess.PIPE, stderr=subprocess.PIPE)
            time.sleep(0.4)
            self.assertIn("volute compress: stopped", self.stopped(process, [number]))
            self.assertEqual(self.files(), ["noise.npy"])

    def test_synthesize_and_a_second_signal(self):
        process = self.start("synthesize", "fire", "-o", self.path("x.npy"), "--size", "64", "--frames", "10000")
        process.send_signal(signal.SIGINT)
        time.sleep(0.02)
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)
        self.assertEqual(process.returncode, 1)
        self.assertEqual(self.files(), [])

    def test_render_stops(self):
        packed = self.make_volute()
        process = subprocess.Popen([support.PROGRAM, "render", packed, "-o", self.path("x.png"), "--size", "4000x4000", "--renderer", "reference"],
                                   stderr=subprocess.PIPE)
        time.sleep(0.5)
        self.assertIn("stopped", self.stopped(process, [signal.SIGINT]))
        self.assertEqual(self.files(), ["in.volute"])


if __name__ == "__main__":
    support.main()
