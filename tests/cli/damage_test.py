# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""A .volute that is cut or has a flipped bit: refused without --partial, described as far as it is intact."""
import random

import support
from support import read_npy, volute


class Damage(support.TestCase):
    def setUp(self):
        super().setUp()
        self.whole = self.make_volute("whole.volute", frames=4, size=18).read_bytes()
        self.bad = self.path("bad.volute")

    def refused(self):
        self.assertIn("bad.volute", self.fails(1, "extract", self.bad, "-o", self.path("x.npy")))
        self.fails(1, "compress", self.bad, "-o", self.path("x.volute"), "--rms", "0.1")
        self.fails(1, "render", self.bad, "-o", self.path("x.png"), "--size", "4x4")

    def test_truncations(self):
        for length in {0, 4, 20, 36, 100, len(self.whole) // 2, len(self.whole) - 1}:
            with self.subTest(length=length):
                self.bad.write_bytes(self.whole[:length])
                self.refused()
                self.assertEqual(volute("info", self.bad).code, 1)

    def test_longer_than_it_says(self):
        self.bad.write_bytes(self.whole + b"x")
        self.assertEqual(volute("info", self.bad).code, 1)

    def test_flipped_bits_are_found(self):
        chance = random.Random(1)
        for _ in range(40):
            place = chance.randrange(len(self.whole))
            damaged = bytearray(self.whole)
            damaged[place] ^= 1 << chance.randrange(8)
            self.bad.write_bytes(damaged)
            with self.subTest(byte=place):
                result = volute("info", self.bad)
                self.assertEqual(result.code, 1, result.message)
                self.assertIn("volute info:", result.message)
                self.fails(1, "extract", self.bad, "-o", self.path("x.npy"))

    def test_the_intact_part_is_shown_when_asked_for(self):
        self.bad.write_bytes(self.whole[:len(self.whole) - 1])
        said = volute("info", self.bad, "--json")
        self.assertEqual(said.code, 1)
        self.assertFalse(said.json["complete"])
        self.assertLess(said.json["integrity"]["intact_segments"], said.json["integrity"]["segments"])
        result = self.works("extract", self.bad, "-o", self.path("x.npy"), "--partial")
        self.assertIn("damaged", result.message)
        self.assertEqual(read_npy(self.path("x.npy").read_bytes())[0], (4, 18, 18, 18))
        self.works("render", self.bad, "-o", self.path("x.png"), "--size", "4x4", "--partial")
        self.works("compress", self.bad, "-o", self.path("again.volute"), "--partial", "--rms", "0.1")
        self.assertIn("bad.volute; damaged: ", self.works("info", self.path("again.volute"), "--json").json["provenance"])


if __name__ == "__main__":
    support.main()
