#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Pictures of the window for docs/pictures/window: window_pictures.py VOLUTE [--out FOLDER].

Makes the files of the three tutorials with VOLUTE, opens each one in a headless window of two sizes at 100 and 200 %, and writes what
the window shows with 256 colours, so that the files stay small: 12 pictures, below 2 MB together."""
import argparse
import pathlib
import subprocess
import tempfile

from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parent.parent
SIZES = [(1280, 800), (950, 570)]  # in points
SCALES = [1, 2]


def made(volute, folder):
    """The files that the tutorials open, by the tutorial's name."""
    def run(*words):
        subprocess.run([volute, *map(str, words)], cwd=folder, check=True, stdout=subprocess.DEVNULL)

    run("synthesize", "smoke", "-o", "cache_%04d.vdb", "--size", 32, "--frames", 8)
    run("compress", "cache_%04d.vdb", "-o", "cache.volute")
    run("synthesize", "hall", "-o", "hall.smv", "--cell", 0.8, "--frames", 25)
    run("synthesize", "fire", "-o", "truth.npy", "--size", 32, "--frames", 2)
    return {"effects": "cache.volute", "fire-safety": "hall.smv", "cameras": "truth.npy"}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("volute")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "docs/pictures/window")
    options = parser.parse_args()
    volute = str(pathlib.Path(options.volute).resolve())
    options.out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        for name, file in made(volute, folder).items():
            for width, height in SIZES:
                for scale in SCALES:
                    shot = pathlib.Path(folder) / "shot.png"
                    subprocess.run([volute, "view", file, "--screenshot", shot, "--interface-scale", str(scale),
                                    "--size", f"{width * scale}x{height * scale}"], cwd=folder, check=True)
                    target = options.out / f"{name}-{width}x{height}-{100 * scale}.png"
                    picture = Image.open(shot).convert("RGB")
                    palette = picture.quantize(256, method=Image.Quantize.MEDIANCUT)  # undithered: flames would have contours
                    picture.quantize(palette=palette, dither=Image.Dither.FLOYDSTEINBERG).save(target, optimize=True)
                    print(target.name, target.stat().st_size)


if __name__ == "__main__":
    main()
