# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""How far pictures and volumes are from each other, and pictures of differences, with the standard library alone."""
import array
import ast
import json
import math
import pathlib
import struct
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tests" / "cli"))
from pictures import Picture, encode_srgb, read_exr, write_png

# Viridis at eighths, sRGB.
VIRIDIS = ((68, 1, 84), (71, 45, 123), (59, 82, 139), (44, 114, 142), (33, 145, 140), (40, 174, 128), (94, 201, 98),
           (173, 220, 48), (253, 231, 37))


def relative_l2(truth, other):
    return math.sqrt(math.fsum((a - b) ** 2 for a, b in zip(truth, other)) / math.fsum(a * a for a in truth))


def viridis(value):
    """Stored sRGB in 0..1 of a value in 0..1."""
    at = min(max(value, 0.0), 1.0) * (len(VIRIDIS) - 1)
    i = min(int(at), len(VIRIDIS) - 2)
    return [(a + (at - i) * (b - a)) / 255 for a, b in zip(VIRIDIS[i], VIRIDIS[i + 1])]


def difference(folder, truth_exr, other_exr, difference_png):
    """Writes the length of the RGB difference of each pixel as viridis, the largest yellow. Returns the relative L2
    of the pictures, and the largest difference as a share of the truth's brightest channel."""
    truth, other = read_exr(folder / truth_exr), read_exr(folder / other_exr)
    a, b, n = truth.values, other.values, truth.channels
    lengths = [math.dist(a[i:i + n], b[i:i + n]) for i in range(0, len(a), n)]
    largest = max(lengths)
    colours = [c for length in lengths for c in viridis(length / largest if largest else 0)]
    write_png(folder / difference_png, Picture(truth.width, truth.height, 3, colours), encode=lambda stored: stored)
    return {"relative_l2": relative_l2(a, b), "largest": largest / max(a)}


def level(value):
    """What an 8-bit sRGB picture stores of a linear value."""
    return round(255 * encode_srgb(value))


def lit(truth, other, exposure):
    """Of the truth's black pixels, which an 8-bit sRGB picture of this exposure stores as 0 in all channels: the share that
    is not black in the other, and the brightest level among them."""
    limit = 0.5 / (255 * 12.92 * exposure)
    n = truth.channels
    black = [i for i in range(0, len(truth.values), n) if max(truth.values[i:i + n]) < limit]
    seen = [max(other.values[i:i + n]) for i in black]
    return {"share": sum(value >= limit for value in seen) / max(1, len(black)), "brightest": level(exposure * max(seen, default=0))}


def haze(folder, truth_exr, others, exposure, out):
    """{picture: share of black pixels that it lights, and how brightly}, as a file too."""
    truth = read_exr(folder / truth_exr)
    result = {"exposure": exposure, "lit": {other: lit(truth, read_exr(folder / other), exposure) for other in others}}
    (folder / out).write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    return result


def read_frame(path, frame):
    """((z, y, x, channels), values) of one frame of a float32 .npy of shape (t, z, y, x, c)."""
    with open(path, "rb") as file:
        (length,) = struct.unpack("<H", file.read(10)[8:])
        _, *shape = ast.literal_eval(file.read(length).decode())["shape"]
        values = array.array("f")
        file.seek(10 + length + 4 * frame * math.prod(shape))
        values.fromfile(file, math.prod(shape))
    return shape, values


def halved(shape, values):
    """Means of cubes of 2^3 voxels."""
    depth, height, width, n = shape
    out = []
    for z in range(0, depth, 2):
        for y in range(0, height, 2):
            rows = [values[((z + dz) * height + y + dy) * width * n:][:width * n] for dz in (0, 1) for dy in (0, 1)]
            sums = [math.fsum(column) for column in zip(*rows)]
            out += [(sums[x + c] + sums[x + n + c]) / 8 for x in range(0, width * n, 2 * n) for c in range(n)]
    return out


def volume_error(folder, truth_npy, other_npy, out):
    """Relative L2 of the other's first frame to the truth's means over the other's voxels, twice as wide."""
    shape, truth = read_frame(folder / truth_npy, 0)
    half, other = read_frame(folder / other_npy, 0)
    if [2 * n for n in half[:3]] != list(shape[:3]):
        raise ValueError(f"{other_npy}: {half} voxels; expected half of {shape} on each side")
    result = {"relative_l2": relative_l2(halved(shape, truth), other)}
    (folder / out).write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    return result


def sheet(folder, exrs, columns, exposure, out):
    """Pictures of one size side by side, in rows, as sRGB."""
    pictures = [read_exr(folder / exr) for exr in exrs]
    width, height, gap = pictures[0].width, pictures[0].height, 4
    rows = -(-len(pictures) // columns)
    whole = Picture(columns * width + (columns - 1) * gap, rows * height + (rows - 1) * gap, 3)
    whole.values = [0.25] * len(whole.values)
    for i, picture in enumerate(pictures):
        x, y = i % columns * (width + gap), i // columns * (height + gap)
        for line in range(height):
            at = ((y + line) * whole.width + x) * 3
            whole.values[at:at + 3 * width] = [exposure * v for v in picture.values[3 * line * width:3 * (line + 1) * width]]
    write_png(folder / out, whole)
