# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Small files for ./dev soak: a film of voxels as .volute, whole and cut off, scenes of painted fog and of lit smoke, a
capture of five cameras and an FDS case of two meshes."""
import argparse
import array
import json
import math
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import zlib

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "tests" / "cli"))


def write_npy(path, shape, values):
    header = repr({"descr": "<f4", "fortran_order": False, "shape": shape}).encode()
    header += b" " * (-(len(header) + 11) % 64) + b"\n"
    path.write_bytes(b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header + array.array("f", values).tobytes())


def write_png(path, width, height, value):
    rows = b"".join(b"\0" + bytes(int(value(x, y)) for x in range(width)) for y in range(height))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def blob(t, z, y, x, size):
    square = (x - (0.3 + 0.01 * t) * size) ** 2 + (y - 0.5 * size) ** 2 + (z - 0.5 * size) ** 2
    return max(0.0, 1 - square / (0.08 * size * size))


def write_examples(arguments):
    """What the tests of the command make for themselves."""
    os.environ["VOLUTE"] = str(arguments.bin)
    import fds_test
    import ring

    case = fds_test.write_case(lambda name: arguments.out / name)
    fds_test.add_slice(lambda name: arguments.out / name, case, 2, (0, 4) * 3, 500.0, ("HRRPUV", "hrrpuv", "kW/m3"))
    folder = ring.made()
    for path in folder.iterdir():
        shutil.copy(path, arguments.out / path.name)
    ring.clean_up()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--bin", required=True)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    arguments = parser.parse_args()
    frames, size = 32, 24
    values = [blob(t, z, y, x, size) for t in range(frames) for z in range(size) for y in range(size) for x in range(size)]
    write_npy(arguments.out / "film.npy", (frames, size, size, size), values)
    subprocess.run([arguments.bin, "compress", arguments.out / "film.npy", "-o", arguments.out / "film.volute", "--rms", "0.003", "--quiet"],
                   check=True)
    write_png(arguments.out / "map.png", 48, 32, lambda x, y: 200 * math.exp(-((x - 20) ** 2 + (y - 16) ** 2) / 60))
    scene = {"format": "volute-scene-1", "camera": {"eye": [-25, -30, 30], "target": [24, 16, 0], "fov": 45},
             "background": [0.15, 0.25, 0.4],
             "media": [{"kind": "fog", "map": "map.png", "sigma_max": 0.2, "degree": 2, "levels": 2, "mu": 0.9,
                        "profile": {"kind": "slab", "bottom": 0, "top": 6}}]}
    (arguments.out / "fog.json").write_text(json.dumps(scene))
    film = (arguments.out / "film.volute").read_bytes()
    (arguments.out / "torn.volute").write_bytes(film[:2 * len(film) // 3])
    subprocess.run([arguments.bin, "synthesize", "hall", "-o", arguments.out / "hall.pvd", "--cell", "1.5", "--frames", "4", "--quiet"],
                   check=True)
    scene = {"format": "volute-scene-1", "camera": {"eye": [2, 6, 1.7], "target": [20, 6, 2], "fov": 60}, "background": [0.1, 0.1, 0.12],
             "lights": [{"kind": "ambient", "radiance": [0.2, 0.2, 0.2]},
                        {"kind": "spot", "position": [10, 6, 5], "target": [12, 6, 0], "angle": 110, "intensity": [30, 28, 25]}],
             "media": [{"kind": "smoke", "case": "hall.pvd", "quantity": "soot-density", "unit": "g/m3", "walls": True}],
             "signs": [{"name": "exit", "position": [27.9, 6, 2.5], "normal": [-1, 0, 0], "size": [1.2, 0.6], "emitting": True}]}
    (arguments.out / "smoke.json").write_text(json.dumps(scene))
    write_examples(arguments)


if __name__ == "__main__":
    main()
