#!/usr/bin/env -S python3 -S -B
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Stands in for `volute` and `volute-paper-figures` in demo_test.py: makes small files of the right kinds in no time.

FAKE_LOG names a file that gets a line for each call; the call whose output FAKE_SLOW names takes its time; the one that
FAKE_FAIL names fails. The picture that FAKE_BLACK names is black; those that FAKE_SAME names, one or two with a colon between,
look the same.
"""
import array
import json
import os
import pathlib
import random
import sys
import time
import zlib

sys.path.insert(0, os.environ["FAKE_PICTURES"])
import pictures

SIDE = 8


def picture(seed):
    values = random.Random(seed)
    return pictures.Picture(SIDE, SIDE, 3, [values.random() if i % 15 > 5 else 0.0 for i in range(SIDE * SIDE * 3)])


def make(path, seed):
    path = pathlib.Path(path)
    seed = 0 if str(path) in os.environ.get("FAKE_SAME", "").split(":") else seed + zlib.crc32(str(path).encode())
    if "%04d" in path.name:
        for frame in range(2):
            make(path.with_name(path.name.replace("%04d", f"{frame:04d}").replace("{camera}", f"c{frame}")), seed + frame)
    elif path.suffix == ".png":
        black = pictures.Picture(SIDE, SIDE, 3, [0.0] * (SIDE * SIDE * 3))
        pictures.write_png(path, black if str(path) == os.environ.get("FAKE_BLACK") else picture(seed))
    elif path.suffix == ".exr":
        pictures.write_exr(path, picture(seed))
    elif path.suffix == ".npy":
        side = 4 if "found" in path.name else SIDE
        header = str({"descr": "<f4", "fortran_order": False, "shape": (1, side, side, side, 3)}).encode().ljust(118) + b"\n"
        values = array.array("f", [(i % 7) / 7 for i in range(3 * side ** 3)])
        path.write_bytes(b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header + values.tobytes())
    elif path.suffix:
        path.write_bytes(b"x" * (1000 if path.suffix == ".vdb" else 400))
    else:
        path.mkdir(exist_ok=True)


def project(words):
    for camera in range(8):
        make(words["-o"].replace("{camera}", f"c{camera}").replace("%04d", "0000"), camera)


def visibility(words):
    folder = pathlib.Path(words["-o"])
    (folder / "maps").mkdir(parents=True)
    (folder / "report.html").write_text("<p>A report</p>")
    (folder / "sight.csv").write_text("eye,sign\n")
    for name in ("aset.png", "routes.png", *(f"maps/{sign}_{i:04d}.png" for sign in ("1_west_exit", "2_north_exit") for i in range(19))):
        make(folder / name, 3)
    times = [{"any": 0.5, "signs": {"west exit": 0.4, "north exit": 0.3}}] * (10 if "0.25" == words["--step"] else 19)
    (folder / "visibility.json").write_text(json.dumps({"summary": times, "aset": [{"kept_to_the_end": 5}], "eyes": {"walkable": 9},
                                                        "routes": [{"walk_share_with_a_sign": 0.5}]}))


def paper_figures(words):
    rates = [float(rate) for rate in words["--rates"].split(",")]
    make(words["--strip"] + "_original.png", 1)
    for rate in rates:
        make(f"{words['--strip']}_{rate:.3f}.png", 2)
    row = {"paper": {"rate": 0.1, "rms": 0.00002, "bytes": 3000, "zlib_bytes": 2000}, "compact": {"rate": 0.05, "rms": 0.001}}
    speed = {"rate": 0.1, "traversal": 1, "traversal_boxes": 2, "slices": 100, "slices_boxes": 200}
    return {"threads": 2, "raw_bytes": 40000, "rate_distortion": [row], "frame_rates": [speed, {**speed, "rate": 0.2}],
            "strip": [{"rate": 1, "rms": 0}, *({"rate": rate, "rms": 0.00003} for rate in rates)]}


def main(arguments):
    program = pathlib.Path(sys.argv[0]).name
    words = {arguments[i]: arguments[i + 1] for i in range(len(arguments) - 1)}
    out = words.get("-o") or words["--strip"]
    with open(os.environ["FAKE_LOG"], "a", encoding="utf-8") as log:
        log.write(f"{program} {' '.join(arguments)}\n")
    if os.environ.get("FAKE_FAIL") == out:
        sys.exit("fake: it cannot")
    if os.environ.get("FAKE_SLOW") == out:
        pathlib.Path(out).write_bytes(b"half")
        time.sleep(60)
    report = {"seconds_per_frame": 1.5, "hull_share": 0.2, "relative_rms": 0.00004, "milliseconds": {"render": 50.0}, "pictures": 10}
    if program == "volute-paper-figures":
        report = paper_figures(words)
    elif arguments[0] == "project":
        project(words)
    elif arguments[0] == "visibility":
        visibility(words)
    else:
        pathlib.Path(out).mkdir(exist_ok=True) if not pathlib.Path(out).suffix else None
        make(out, len(out))
        if arguments[1] == "valley":
            for name in ("fogmap.png", "valley.glb", "depth.exr"):
                make(pathlib.Path(out) / name, 5)
            (pathlib.Path(out) / "camera.json").write_text('{"eye": [0, 0, 2], "target": [0, 9, 2], "up": [0, 0, 1], "fov": 50}')
        if arguments[0] == "fog" and out.endswith(".mp4"):
            report["milliseconds"] = 120.0
        if "--report" in words:
            for path in (pathlib.Path(words["--report"]), pathlib.Path(words["--report"]).with_suffix(".html")):
                path.write_text("<p>A report</p>")
    print(json.dumps(report))


if __name__ == "__main__":
    main(sys.argv[1:])
