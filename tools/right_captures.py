#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Does `volute reconstruct` warn of captures in which nothing is wrong? Renders a small capture for each seed and counts its alarms.

    right_captures.py OUT --seeds 0:100

A seed decides what burns (fire, flame, smoke, filaments, billows), how many cameras see it (4 to 8, on an arc or a ring, at several heights),
whether pictures are stored as sRGB or linearly (8 bits), and their noise. The volume is rendered with twice the voxels of the reconstruction.
Writes OUT/alarms.json, and keeps the captures that caused an alarm; the exit code is then 1.
"""
import argparse
import json
import math
import os
import pathlib
import shutil
import subprocess
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "tests" / "cli"))
from hold_out import write_png  # noqa: E402
from pictures import read_exr  # noqa: E402

KINDS = ("fire", "smoke", "filaments", "flame", "billows")
SIDE = 48  # of the truth


def volute(*arguments):
    done = subprocess.run([os.environ.get("VOLUTE", "volute"), *map(str, arguments)], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"right_captures: {' '.join(map(str, arguments))}\n{done.stderr.strip()}")
    return done


def kernels(centres, radii, lights):
    """Gaussian kernels as a volume of the cube from -1 to 1."""
    at = (np.arange(SIDE) + 0.5) * 2 / SIDE - 1
    volume = np.zeros((SIDE,) * 3)
    for (x, y, z), radius, light in zip(centres, radii, lights):
        one = [np.exp(-0.5 * ((at - c) / radius) ** 2) for c in (z, y, x)]
        volume += light * one[0][:, None, None] * one[1][None, :, None] * one[2][None, None, :]
    volume[volume < 1e-3 * volume.max()] = 0
    return (volume[None, ..., None] * (1, 0.65, 0.3)).astype("<f4")


def filaments(random):
    centres, radii, lights = [], [], []
    for _ in range(6):
        at, along = np.array([*(0.2 * random.normal(size=2)), -0.85]), np.array([0.0, 0, 1])
        for step in range(50):
            along = along + 0.3 * random.normal(size=3)
            along[2] = abs(along[2]) + 0.3
            at = at + 0.033 * along / np.linalg.norm(along)
            centres.append(np.clip(at, -0.8, 0.8))
            radii.append(0.05 + 0.03 * random.random())
            lights.append((1 - step / 70) * random.random())
    return kernels(centres, radii, lights)


def billows(random):
    height, angle = random.random(60), 2 * math.pi * random.random(60)
    away = (0.14 + 0.36 * height) * np.sqrt(random.random(60))
    centres = np.stack([away * np.cos(angle), away * np.sin(angle), 1.4 * height - 0.7], 1)
    return kernels(centres, 0.07 + 0.08 * random.random(60), 0.4 + 0.6 * random.random(60))


def truth(kind, seed, random, folder):
    path = folder / "truth.npy"
    if kind in ("filaments", "billows"):
        np.save(path, globals()[kind](random))
        return path
    volute("synthesize", kind, "-o", path, "--size", SIDE, "--frames", 24, "--seed", seed + 1, "-q")
    np.save(path, np.load(path)[20:21])
    return path


def pose(eye, target):
    forward = np.subtract(target, eye) / np.linalg.norm(np.subtract(target, eye))
    right = np.cross(forward, (0, 0, 1))
    right /= np.linalg.norm(right)
    R = np.stack([right, np.cross(forward, right), forward])
    return R, -R @ eye


def capture(count, color, random):
    """Cameras on an arc of 150 degrees or on a ring, none opposite to another."""
    ring = random.random() < 0.5
    width, height = 88, 80
    cameras = []
    for i in range(count):
        angle = 2 * math.pi * (i + 0.3 * random.random()) / count if ring else math.radians(150) * (i + 0.3 * random.random()) / count
        eye = np.array([4 * math.cos(angle), 4 * math.sin(angle), 1.2 * random.random() - 0.4])
        R, t = pose(eye, 0.1 * random.normal(size=3))
        focal = 84 * (0.95 + 0.1 * random.random())
        cameras.append({"name": f"c{i}", "image": f"c{i}_%04d.png", "width": width, "height": height,
                        "K": [[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]], "R": R.tolist(), "t": t.tolist()})
    return {"format": "volute-capture-1", "color": color, "frames": [0],
            "volume": {"min": [-1] * 3, "max": [1] * 3, "resolution": [SIDE // 2] * 3}, "cameras": cameras}


def encode(values):
    return np.where(values <= 0.0031308, 12.92 * values, 1.055 * np.maximum(values, 1e-9) ** (1 / 2.4) - 0.055)


def take(folder, seed):
    """Renders the capture of a seed; what it is, in words."""
    random = np.random.default_rng(seed)
    kind, count, color = KINDS[seed % 5], 4 + seed // 5 % 5, ("srgb", "linear")[seed % 2]
    noise = 0.3 + 1.7 * random.random()
    scene = capture(count, color, random)
    (folder / "capture.json").write_text(json.dumps(scene))
    volute("project", truth(kind, seed, random, folder), folder / "capture.json", "-o", folder / "{camera}_%04d.exr", "-q")
    taken = {}
    for camera in scene["cameras"]:
        path = folder / f"{camera['name']}_0000.exr"
        picture = read_exr(path)
        taken[camera["name"]] = np.reshape(picture.values, (picture.height, picture.width, -1)) * np.ones(3)
        path.unlink()
    scale = 0.9 / max(values.max() for values in taken.values())
    for name, values in taken.items():
        stored = encode(scale * values) if color == "srgb" else scale * values
        write_png(folder / f"{name}_0000.png", stored + noise / 255 * random.normal(size=stored.shape))
    return f"{kind}, {count} cameras, {color}, noise {noise:.1f}/255"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--seeds", default="0:100")
    arguments = parser.parse_args()
    found = []
    for seed in range(*map(int, arguments.seeds.split(":"))):
        folder = arguments.out / f"{seed:04d}"
        folder.mkdir(parents=True, exist_ok=True)
        what = take(folder, seed)
        done = volute("reconstruct", folder / "capture.json", "-o", folder / "out.npy", "--json")
        alarms = [line for line in done.stderr.splitlines() if "warning" in line]
        refined = "calibration refined" in done.stderr
        found.append({"seed": seed, "what": what, "alarms": alarms, "refined": refined, "residual": json.loads(done.stdout)["residual"]})
        print(seed, what, f"residual {found[-1]['residual']:.3f}", "refined" if refined else "", *alarms, sep="; ", flush=True)
        if not alarms and not refined:
            shutil.rmtree(folder)
        (arguments.out / "alarms.json").write_text(json.dumps(found, indent=1))
    wrong, refined = (sum(1 for one in found if one[key]) for key in ("alarms", "refined"))
    print(f"{wrong} of {len(found)} right captures caused an alarm; the calibration of {refined} was refined")
    sys.exit(1 if wrong or refined else 0)


if __name__ == "__main__":
    main()
