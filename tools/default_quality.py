#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Which error of `volute compress` nobody sees.

    tools/default_quality.py VOLUTE FILE... [--quality look,draft] [--rms 0.003,0.001] [--over support|all] [--frame N]

Compresses each file with each error and draws one frame of it from eight sides, 512 x 512, as emission and (one channel)
as lit smoke, without tone curve or dithering, one ray a pixel: where more are cast at edges, a pixel that is only just one changes by what
no error of a volume explains. At an exposure that makes the brightest thousandth of the original white, and
three stops above it, it counts the pixels that differ from the original's by more than 2 of 255 levels in a channel, and
finds the largest difference. What passes: at most .1 % of the pixels, none by more than 8. Wants NumPy."""
import argparse
import json
import math
import pathlib
import re
import subprocess
import sys
import tempfile
import zlib

import numpy as np

SIZE = 512
SEEN, TOO_MUCH, SHARE = 2, 8, 1e-3


def run(*arguments):
    done = subprocess.run([str(a) for a in arguments], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, arguments))}\n{done.stderr}")
    return done


def read_exr(path):
    """(height, width, 3) of a single-part file of scan lines, as the command writes it."""
    data = pathlib.Path(path).read_bytes()
    at, header = 8, {}
    while data[at]:
        end = data.index(b"\0", at)
        name, at = data[at:end].decode(), end + 1
        at = data.index(b"\0", at) + 1
        size = int.from_bytes(data[at:at + 4], "little")
        header[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    x0, y0, x1, y1 = np.frombuffer(header["dataWindow"], "<i4")
    width, height = int(x1 - x0 + 1), int(y1 - y0 + 1)
    lines_a_chunk = {0: 1, 2: 1, 3: 16}[header["compression"][0]]
    chunks = -(-height // lines_a_chunk)
    at += 1 + 8 * chunks
    rows = b""
    for chunk in range(chunks):
        size = int.from_bytes(data[at + 4:at + 8], "little")
        part = data[at + 8:at + 8 + size]
        at += 8 + size
        whole = 12 * width * min(lines_a_chunk, height - chunk * lines_a_chunk)
        if size < whole:
            steps = np.frombuffer(zlib.decompress(part), np.uint8).astype(np.int64)
            steps[1:] -= 128
            halves = np.cumsum(steps).astype(np.uint8)
            both = np.empty(whole, np.uint8)
            both[::2], both[1::2] = halves[:(whole + 1) // 2], halves[(whole + 1) // 2:]
            part = both.tobytes()
        rows += part
    planes = np.frombuffer(rows, "<f4").reshape(height, 3, width)  # B, G, R
    return planes[:, ::-1].transpose(0, 2, 1)


def levels(picture, exposure):
    x = np.clip(picture * exposure, 0, 1)
    return 255 * np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def views(volute, file, looks, bounds, frame, folder, sides):
    """Pictures of one file, (sides, height, width, 3)."""
    low, high = np.array(bounds[0]), np.array(bounds[1])
    centre, reach = (low + high) / 2, np.linalg.norm(high - low)
    drawn = []
    for side in range(sides):
        around, up = 2 * math.pi * side / sides, 0.5 * math.sin(1 + 2.4 * side)
        eye = centre + 1.3 * reach * np.array([math.cos(around), math.sin(around), up])
        scene = {"format": "volute-scene-2",
                 "camera": {"eye": eye.tolist(), "target": centre.tolist(), "up": [0, 0, 1], "fov": 36, "size": [SIZE, SIZE]},
                 "lights": [{"kind": "sun", "direction": [0.5, 0.6, -0.6], "radiance": [3, 3, 3]}],
                 "media": [{"kind": "volume", "file": str(file), **looks}]}
        (folder / "scene.json").write_text(json.dumps(scene))
        run(volute, "render", folder / "scene.json", "-o", folder / "view.exr", "--frames", f"{frame}:{frame + 1}", "--samples", "1", "--quiet")
        drawn.append(read_exr(folder / "view.exr"))
    return np.array(drawn)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("volute", type=pathlib.Path)
    parser.add_argument("files", nargs="+", type=pathlib.Path)
    parser.add_argument("--quality", default="look,draft")
    parser.add_argument("--rms", default="")
    parser.add_argument("--over", default="support")
    parser.add_argument("--frame", type=int)
    parser.add_argument("--sides", type=int, default=8)
    asked = parser.parse_args()
    print("| set | look | quality or RMS | bytes | over 2 of 255 [%] | largest | at +3 stops [%] | largest |\n|---|---|---|--:|--:|--:|--:|--:|")
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        for file in asked.files:
            info = json.loads(run(asked.volute, "info", file, "--json").stdout)
            numbers = info["frame_numbers"]
            frame = asked.frame if asked.frame is not None else (numbers[0] + numbers[-1]) // 2
            bounds = np.reshape(info["bounds"], (2, 3))
            looks = {"emission": {"emission": 1, "extinction": 0}}
            if info["channels"] == 1:
                said = run(asked.volute, "render", file, "-o", folder / "look.png", "--size", "16x16", "--preset", "smoke",
                           "--frames", f"{frame}:{frame + 1}").stderr
                dense = float(re.search(r"extinction ([\d.e+]+)", said)[1])
                looks["lit"] = {"emission": 0, "extinction": dense, "albedo": [0.9] * 3, "asymmetry": 0.3}
            originals = {look: views(asked.volute, file.resolve(), said, bounds, frame, folder, asked.sides) for look, said in looks.items()}
            settings = [(word, ("--quality", word)) for word in asked.quality.split(",") if word]
            settings += [(rms, ("--rms", rms, "--rms-over", asked.over)) for rms in asked.rms.split(",") if rms]
            for rms, options in settings:
                packed = folder / "packed.volute"
                run(asked.volute, "compress", file, "-o", packed, *options, "--quiet")
                for look, original in originals.items():
                    bright = original.max(axis=3)
                    white = 1 / np.quantile(bright[bright > 0], 0.999)
                    restored = views(asked.volute, packed, looks[look], bounds, frame, folder, asked.sides)
                    cells = []
                    for stops in (0, 3):
                        apart = np.abs(levels(original, white * 2 ** stops) - levels(restored, white * 2 ** stops)).max(axis=3)
                        cells += [f"{100 * np.mean(apart > SEEN):.3f}", f"{apart.max():.1f}"]
                    print(f"| {file.stem} | {look} | {rms} | {packed.stat().st_size:,} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
