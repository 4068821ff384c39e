# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""A scene of everything at once: the valley's surfaces at dusk, painted fog, and the compressed fire standing in it."""
import json
import math

from errors import read_exr

FIRE_PIXEL = (0.47, 0.66)  # where the fire stands, as shares of the picture's width and height
FIRE_METRES = 16  # its height


def seen_point(camera, depth, at):
    """The point that a pixel of a frame shows; `camera` is a scene's, depth along the view axis."""
    def minus(a, b):
        return [p - q for p, q in zip(a, b)]

    def unit(v):
        length = math.sqrt(sum(p * p for p in v))
        return [p / length for p in v]

    def cross(a, b):
        return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]

    forward = unit(minus(camera["target"], camera["eye"]))
    right = unit(cross(forward, camera["up"]))
    up = cross(right, forward)
    column, row = int(at[0] * depth.width), int(at[1] * depth.height)
    half = math.tan(math.radians(camera["fov"]) / 2)
    y = half * (1 - 2 * (row + 0.5) / depth.height)
    x = half * (2 * (column + 0.5) - depth.width) / depth.height
    z = depth.at(column, row)
    return [e + z * (f + x * r + y * u) for e, f, r, u in zip(camera["eye"], forward, right, up)]


def write_scene(folder, valley, fire, out, pixels, sigma):
    """`valley` is the folder of `volute synthesize valley --geometry`, `fire` a .volute 2 m high around x = y = 0."""
    camera = json.loads((folder / valley / "camera.json").read_text(encoding="utf-8"))
    place = seen_point(camera, read_exr(folder / valley / "depth.exr"), FIRE_PIXEL)
    scale = FIRE_METRES / 2
    x, y, z = place
    base = "../" * out.count("/")
    scene = {
        "format": "volute-scene-2",
        "camera": {**camera, "size": list(pixels)},
        "background": [0.05, 0.07, 0.11],
        "geometry": [{"file": f"{base}{valley}valley.glb"}],
        "lights": [{"kind": "sun", "direction": [-0.45, -0.85, -0.42], "radiance": [0.35, 0.3, 0.28]},
                   {"kind": "ambient", "radiance": [0.05, 0.06, 0.09]},
                   {"kind": "spot", "position": [x, y, z + 0.5 * FIRE_METRES], "target": [x, y, z], "angle": 360, "intensity": [900, 380, 90], "radius": 4}],
        "media": [
            {"kind": "volume", "file": f"{base}{fire}", "emission": 0.5, "transform": [scale, 0, 0, x, 0, scale, 0, y, 0, 0, scale, z - 0.5, 0, 0, 0, 1]},
            {"kind": "fog", "map": f"{base}{valley}fogmap.png", "cell": 8, "degree": 2, "sigma_max": sigma,
             "profile": {"kind": "exponential", "bottom": 2, "height": 9}, "color": [0.07, 0.09, 0.13], "asymmetry": 0.6}]}
    (folder / out).write_text(json.dumps(scene, indent=1) + "\n", encoding="utf-8")
