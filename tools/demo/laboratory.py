# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""For those who measure: eight cameras around a fire, and the volume that explains what they saw."""
import math

import errors
from descriptions import json_file
from plan import Chapter, Command, Fact, Picture, Section, Step, Wipe
from words import NBSP, bytes_of, digits, percent

COUNT, FOCAL, DISTANCE = 8, 300, 5.0
BOUNDS = "--bounds=-1,-1,0,1,1,2"
LOOK = "--eye 3.4,-3.4,2.6 --target 0,0,1 --fov 27 --size 384x384"
EXPOSURE = 0.8
TRUTH, CAPTURE, FOUND = "laboratory/fire.npy", "laboratory/capture.json", "laboratory/fire.volute"


def ring_camera(i, pixels):
    """One of the cameras on a half arc around the fire, at two heights; x right, y down, z forward."""
    angle = math.radians(-180 + 180 * (i + 0.5) / COUNT)
    eye = (DISTANCE * math.cos(angle), DISTANCE * math.sin(angle), 1.9 if i % 2 else 0.9)

    def unit(vector):
        length = math.sqrt(sum(v * v for v in vector))
        return [v / length for v in vector]

    forward = unit([t - e for t, e in zip((0, 0, 1), eye)])
    right = unit([forward[1], -forward[0], 0])
    down = [forward[1] * right[2] - forward[2] * right[1], forward[2] * right[0] - forward[0] * right[2],
            forward[0] * right[1] - forward[1] * right[0]]
    rotation = [right, down, forward]
    focal = FOCAL * pixels / 144
    return {"name": f"c{i}", "image": f"views/c{i}_%04d.exr", "width": pixels, "height": pixels,
            "K": [[focal, 0, pixels / 2], [0, focal, pixels / 2], [0, 0, 1]], "R": rotation,
            "t": [-sum(a * b for a, b in zip(row, eye)) for row in rotation]}


def steps(voxels, pixels):
    capture = {"format": "volute-capture-1", "color": "linear", "pixel_centre": 0.5, "frames": [0],
               "volume": {"min": [-1, -1, 0], "max": [1, 1, 2], "resolution": [voxels // 2] * 3},
               "cameras": [ring_camera(i, pixels) for i in range(COUNT)]}
    views = tuple(f"laboratory/views/c{i}_0000.exr" for i in range(COUNT))

    def picture(source, read, name, basis):
        return [Step((f"laboratory/{name}.{kind}",), f"volute render {source} -o laboratory/{name}.{kind} {LOOK} --basis {basis}{shown}",
                     reads=(read,)) for kind, shown in (("png", f" --exposure {EXPOSURE} --measured"), ("exr", " --measured"))]

    return (
        Step((TRUTH,), f"volute synthesize fire -o {TRUTH} --size {voxels} --frames 1 --seed 3"),
        json_file(CAPTURE, capture),
        Step(("laboratory/views/",), f"volute project {TRUTH} {CAPTURE} -o laboratory/views/{{camera}}_%04d.exr --basis box {BOUNDS}",
             reads=(TRUTH, CAPTURE)),
        Step(("laboratory/views.png",), work=errors.sheet, arguments=(views, 4, EXPOSURE, "laboratory/views.png"),
             reads=("laboratory/views/",)),
        Step((FOUND, "laboratory/report.json", "laboratory/report.html"),
             f"volute reconstruct {CAPTURE} -o {FOUND} --rms 2e-4 --report laboratory/report.json", reads=(CAPTURE, "laboratory/views/")),
        *picture(f"{TRUTH} {BOUNDS}", TRUTH, "truth", "box"),
        *picture(FOUND, FOUND, "found", "trilinear"),
        Step(("laboratory/difference.png",), work=errors.difference,
             arguments=("laboratory/truth.exr", "laboratory/found.exr", "laboratory/difference.png"),
             reads=("laboratory/truth.exr", "laboratory/found.exr")),
        Step(("laboratory/found.npy",), f"volute extract {FOUND} -o laboratory/found.npy", reads=(FOUND,)),
        Step(("laboratory/volume_error.json",), work=errors.volume_error, arguments=(TRUTH, "laboratory/found.npy", "laboratory/volume_error.json"),
             reads=(TRUTH, "laboratory/found.npy")))


def chapter(scale):
    voxels, pixels = scale.pick((64, 144), (48, 108))
    look = f"perspective 27°, linear light, exposure {EXPOSURE}, sRGB"
    seen = Section(
        "The measurement",
        (f"A synthetic fire of {voxels}³ voxels, each with constant emission, and {COUNT} calibrated cameras on a half circle around it, at two "
         f"heights. [capture.json]({CAPTURE}) holds their calibration. With real cameras, start here with your own pictures.",),
        (Picture("laboratory/views.png", f"The {COUNT} views", f"{pixels} × {pixels} pixels each, linear light, exposure {EXPOSURE}, sRGB"),
         Command("laboratory/views/", "Simulates the cameras; the pictures are linear EXR")), columns=1)
    found = Section(
        "The reconstruction",
        ("`volute reconstruct` solves for the emission whose line integrals are those pictures: non-negative everywhere, and zero where a "
         "camera sees nothing. "
         f"It uses half of the fire's resolution, {voxels // 2}³, and another basis (trilinear), so it cannot reproduce the original exactly.",
         "Both are shown from a direction without a camera. [The report](laboratory/report.html) shows each camera's picture beside that of "
         "the volume."),
        (Fact(lambda r: percent(r.report("laboratory/difference.png")["relative_l2"]), "relative L2 error of the new view", ("laboratory/difference.png",)),
         Fact(lambda r: percent(r.report("laboratory/volume_error.json")["relative_l2"]), "relative L2 error of the volume, compared with "
                                                                                          "means over 2³ voxels of the fire",
              ("laboratory/volume_error.json",)),
         Fact(lambda r: f"{digits(r.report(FOUND)['seconds_per_frame'])}{NBSP}s", "to reconstruct a frame", (FOUND,)),
         Fact(lambda r: percent(r.report(FOUND)["hull_share"]), "of the voxels are in the visual hull", (FOUND,)),
         Wipe(("laboratory/truth.png", "fire"), ("laboratory/found.png", "reconstructed"), "From a new direction", look),
         Picture("laboratory/difference.png", "The error",
                 lambda r: "Length of the RGB difference in linear light; viridis, from violet (0) to yellow "
                           f"({percent(r.report('laboratory/difference.png')['largest'])} of the fire's brightest channel)"),
         Command(FOUND, lambda r: f"The reconstruction, {bytes_of(r.size(FOUND))}")))
    return Chapter("laboratory", "Laboratory", "Eight calibrated cameras film a fire: the volume reconstructed from their pictures, and its "
                                               "error.",
                   steps(voxels, pixels), (seen, found), door=("laboratory/found.png", "laboratory/truth.png", "laboratory/views.png"))
