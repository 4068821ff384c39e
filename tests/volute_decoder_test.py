#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Files that earlier versions wrote decode to the same floats for ever, by the command and by a decoder written from docs/format.md
alone: `volute_decoder_test.py VOLUTE DATA_DIR`."""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest
import zlib

import numpy as np

import volute_decoder

# CRC-32 of the decoded floats: (file, grid), what it has that the others do not.
FROZEN = {
    ("version1_codec2.volute", None): 0x49A091AC,  # three colours, several modes, partly filled blocks
    ("haar_corrected.volute", None): 0xABEA4FFE,  # a maximum error, Haar on a support
    ("rgb_97.volute", None): 0x3074FF78,  # CDF 9/7 on a support
    ("joined.volute", None): 0x61BBF2F2,  # parts with parameters and ranges of their own, values below 0
    ("cache.volute", "density"): 0xD7E791C8,
    ("cache.volute", "velocity"): 0x0873EC49,
    ("cache.volute", "temperature"): 0xF1122D44,
    ("cache.volute", "solid"): 0x417714C0,  # a level set
    ("codec3_topology.volute", None): 0x2093CCA1,  # a background, tiles, values of inactive voxels, an outlier
    ("codec3_inactive_rgb.volute", None): 0x10B88569,  # one value of inactive voxels, a maximum error
    ("codec3_dense.volute", None): 0x9A6A84A2,  # all voxels active or not by their values
    ("codec3_cache.volute", "density"): 0xBD24EE3B,  # joined from two parts, tiles in the second
    ("codec3_cache.volute", "temperature"): 0x95B1822D,
    ("codec3_symbols.volute", None): 0xDCB87C60,  # symbols in one lane and in four, escapes, no topology
    ("codec3_symbols_rgb.volute", None): 0x6DAD8EF3,  # symbols on supports, a maximum error
    ("codec3_frames.volute", None): 0xDEC7F7E6,  # blocks of 4 frames, means in the index
    ("codec3_symbols_bent.volute", None): 0xFB31BE9F,  # symbols of bent values, with topology
    ("codec3_offset.volute", None): 0x5BD36B20,  # differences from an offset, as float64
}


# CRC-32 of the bytes of a kept grid in each frame.
KEPT = {("codec3_kept.volute", "id"): [0xB06F47E0, 0x2D07785E]}


class Frozen(unittest.TestCase):
    def test_second_decoder(self):
        for (file, grid), crc in FROZEN.items():
            with self.subTest(file=file, grid=grid):
                self.assertEqual(zlib.crc32(volute_decoder.read(DATA / file, grid).tobytes()), crc)

    def test_files_without_values(self):
        for (file, grid), crcs in KEPT.items():
            self.assertEqual([zlib.crc32(piece) for piece in volute_decoder.read(DATA / file, grid)], crcs)
        for file, grids, kept in (("codec3_empty.volute", ["density", "velocity", "surface"], []), ("codec3_kept.volute", [], ["id"])):
            nothing = volute_decoder.read(DATA / file)
            self.assertEqual((nothing.shape, nothing.any()), ((2, 1, 1, 1), False))
            said = json.loads(subprocess.run([VOLUTE, "info", DATA / file, "--json"], check=True, stdout=subprocess.PIPE).stdout)
            self.assertEqual(([one["name"] for one in said["grids"] if one["empty"]], [one["name"] for one in said.get("kept", [])]), (grids, kept))
            self.assertEqual((said["frame_numbers"], said["times"], said["complete"]), ([3, 4], [0.5, 1], True))

    def test_command(self):
        with tempfile.TemporaryDirectory() as folder:
            for (file, grid), crc in FROZEN.items():
                with self.subTest(file=file, grid=grid):
                    out = pathlib.Path(folder) / f"{file}_{grid}.npy"
                    field = ["--field", grid] if grid else []
                    subprocess.run([VOLUTE, "extract", DATA / file, *field, "-o", out], check=True, stdout=subprocess.DEVNULL)
                    self.assertEqual(zlib.crc32(np.load(out).tobytes()), crc)

    def test_bent_values(self):
        rng = np.random.default_rng(3)
        for channels in (1, 3):
            z, y, x = np.mgrid[:20, :18, :21] / 20.0
            ball = np.maximum(0, 0.3 - (z - 0.5)**2 - (y - 0.4)**2 - (x - 0.5)**2)[None, ..., None] * np.arange(1, 4)[:, None, None, None, None]
            values = (ball**3 * rng.choice([-30, 40], channels) + 0.01 * ball * rng.random((3, 20, 18, 21, channels))).astype(np.float32)
            with self.subTest(channels=channels), tempfile.TemporaryDirectory() as folder:
                source, packed, out = (pathlib.Path(folder) / name for name in ("a.npy", "a.volute", "b.npy"))
                np.save(source, values)
                subprocess.run([VOLUTE, "compress", source, "-o", packed, "--quiet"], check=True, stdout=subprocess.DEVNULL)
                subprocess.run([VOLUTE, "extract", packed, "-o", out], check=True, stdout=subprocess.DEVNULL)
                np.testing.assert_array_equal(volute_decoder.read(packed).reshape(values.shape), np.load(out).reshape(values.shape))

    def test_damage_is_found(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "damaged.volute"
            for name in ("haar_corrected.volute", "codec3_topology.volute"):
                whole = (DATA / name).read_bytes()
                head = int.from_bytes(whole[16:24], "little")  # pages of codec 3 follow it
                for place in (20, 40, head + 1, head + 70, len(whole) // 2, len(whole) - 1):
                    damaged = bytearray(whole)
                    damaged[place] ^= 4
                    path.write_bytes(damaged)
                    with self.subTest(name=name, place=place), self.assertRaises(SystemExit):
                        volute_decoder.read(path)


if __name__ == "__main__":
    VOLUTE, DATA = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1])
