#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""How well does `volute reconstruct` predict a camera that it has not seen? Holds out each camera of a capture in turn and writes a page.

    hold_out.py capture.json OUT                     a capture of your own (volute-capture-1; pictures, not films)
    hold_out.py FOLDER OUT --frames 40:120           the films of a published plume: a folder with info.json and train00.mp4 ..,
                                                     or a git repository that has them in data/ScalarReal (needs ffmpeg)

Protocol, so that other programs can be compared:
* A run sees all cameras but one, with the calibration as given and default options. The held-out camera's pictures and calibration are in no
  file that the run reads.
* The volume is projected into the held-out camera (linear, 4 rays a pixel), limited to 0 .. 1 and compared with the picture over all its pixels and
  channels. PSNR is against 1, the full scale of the picture.
* "registered" is the same volume seen by a camera whose pose, focal length and gain were fitted to its pictures afterwards, one fit for all
  frames. It tells what of an error is the held-out camera's own calibration, and is no prediction.
* CPU time is that of reconstruct and its children, user and system; memory is the largest resident set.

Writes OUT/index.html, OUT/record.json, and pictures of each prediction beside the one that was taken.
"""
import argparse
import html
import json
import math
import os
import pathlib
import resource
import shutil
import subprocess
import sys
import time
import zlib

import numpy as np

FITTED = ("turn x", "turn y", "turn z", "move x", "move y", "move z", "focal length")


def fail(sentence):
    sys.exit(f"hold_out: {sentence}")


def run(command, **options):
    result = subprocess.run([str(c) for c in command], capture_output=True, **options)
    if result.returncode:
        fail(f"{' '.join(map(str, command))}\n{result.stderr.decode(errors='replace').strip()}")
    return result.stdout


# ---------------------------------------------------------------------------------------------------------------- pictures


def read_picture(path, width, height):
    """Linear values (height, width, 3) of an EXR as they are, of a PNG as shares of its full scale."""
    exr = path.suffix.lower() == ".exr"
    raw = run(["ffmpeg", "-v", "error", "-i", path, "-f", "rawvideo", "-pix_fmt", "gbrpf32le" if exr else "rgb48le", "-"])
    if exr:
        planes = np.frombuffer(raw, "<f4")
    else:
        planes = np.frombuffer(raw, "<u2").astype(np.float32) / 65535
    if planes.size != 3 * width * height:
        fail(f"{path} has not the {width} x {height} pixels of its camera")
    if exr:
        return planes.reshape(3, height, width)[[2, 0, 1]].transpose(1, 2, 0)
    return planes.reshape(height, width, 3)


def write_png(path, values):
    """values 0 .. 1, (height, width, 3), 8 bits, as they are."""
    rows = (np.clip(values, 0, 1) * 255 + 0.5).astype(np.uint8)
    height, width, _ = rows.shape
    data = zlib.compress(b"".join(b"\0" + row.tobytes() for row in rows), 6)

    def chunk(kind, content):
        return len(content).to_bytes(4, "big") + kind + content + zlib.crc32(kind + content).to_bytes(4, "big")

    header = width.to_bytes(4, "big") + height.to_bytes(4, "big") + bytes((8, 2, 0, 0, 0))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", data) + chunk(b"IEND", b""))


def psnr(predicted, taken):
    error = float(np.mean((np.clip(predicted, 0, 1) - taken) ** 2))
    return math.inf if error == 0 else -10 * math.log10(error)


def file_of(pattern, number):
    """The picture of a frame: %d, %04d or #### in the pattern."""
    if "#" in pattern:
        count = pattern.count("#")
        return pattern.replace("#" * count, str(number).zfill(count))
    return pattern % number if "%" in pattern else pattern


# ------------------------------------------------------------------------------------------------------ the published plume


def plume_capture(source, folder, frames, height):
    """The capture.json of the films that info.json describes: phones on their side, values taken as linear, black background. The focal
    length of info.json is horizontal and taken for both axes."""
    width = height * 9 // 16
    git = not (source / "info.json").is_file()

    def read(name):
        if git:
            return run(["git", "-C", source, "show", f"HEAD:data/ScalarReal/{name}"])
        return (source / name).read_bytes()

    info = json.loads(read("info.json"))
    films = [film for kind in ("train_videos", "test_videos") for film in info[kind]]
    cameras = []
    for film in sorted(films, key=lambda film: film["file_name"]):
        name = f"cam{int(''.join(c for c in pathlib.Path(film['file_name']).stem if c.isdigit()))}"
        pose = np.array(film["transform_matrix"], float)
        forward = -pose[:3, 2] / np.linalg.norm(pose[:3, 2])
        right = pose[:3, 0] - forward * (pose[:3, 0] @ forward)
        right /= np.linalg.norm(right)
        rotation = np.array([right, np.cross(forward, right), forward])
        focal = 0.5 * width / math.tan(0.5 * film["camera_angle_x"])
        path = folder / film["file_name"]
        path.write_bytes(read(film["file_name"]))
        run(["ffmpeg", "-v", "error", "-y", "-i", path, "-vf",
             f"select=between(n\\,{frames[0]}\\,{frames[-1]}),scale={width}:{height}:flags=area", "-vsync", "0",
             "-start_number", str(frames[0]), folder / f"{name}_%04d.png"])
        cameras.append({"name": name, "image": f"{name}_%04d.png", "width": width, "height": height,
                        "K": [[focal, 0, width / 2], [0, focal, height / 2], [0, 0, 1]], "R": rotation.tolist(),
                        "t": (-rotation @ pose[:3, 3]).tolist()})
    matrix, scale = np.array(info["voxel_matrix"], float), np.array(info["voxel_scale"], float)
    corners = [(matrix @ np.append(np.array((x, y, z)) * scale, 1))[:3] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    volume = {"min": np.min(corners, 0).tolist(), "max": np.max(corners, 0).tolist(), "resolution": [64, 96, 64]}
    return {"format": "volute-capture-1", "color": "linear", "frames": frames, "volume": volume, "cameras": cameras}


# ------------------------------------------------------------------------------------------------------ a camera afterwards


def turned(angles):
    """The rotation by |angles| about their direction (Rodrigues)."""
    angle = np.linalg.norm(angles)
    x, y, z = angles / angle if angle else (0, 0, 0)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross


def changed(camera, change, middle):
    """camera with its view turned about the middle of the volume, moved, and its focal length times exp(change[6])."""
    rotation = turned(change[:3]) @ np.array(camera["R"], float)
    before = np.array(camera["R"], float) @ middle + np.array(camera["t"], float)
    intrinsics = np.array(camera["K"], float)
    intrinsics[0, 0] *= math.exp(change[6])
    intrinsics[1, 1] *= math.exp(change[6])
    return {**camera, "K": intrinsics.tolist(), "R": rotation.tolist(),
            "t": (before + change[3:6] - rotation @ middle).tolist()}


class Projector:
    """Pictures of one volume by cameras that are like a capture's."""

    def __init__(self, volute, capture, volume, folder):
        self.volute, self.capture, self.volume, self.folder = volute, capture, volume, folder

    def __call__(self, cameras, frames):
        """A list of arrays (frame, height, width, 3), one a camera."""
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir(parents=True)
        named = [{**camera, "name": f"c{i}"} for i, camera in enumerate(cameras)]
        for camera in named:
            for key in ("background", "mask"):
                camera.pop(key, None)
        description = {key: value for key, value in self.capture.items() if key != "empty_frames"}
        (self.folder / "cameras.json").write_text(json.dumps({**description, "cameras": named}))
        pictures = []
        for first, last in runs_of(frames):
            run([self.volute, "project", self.volume, self.folder / "cameras.json", "-o", self.folder / "{camera}_%04d.exr",
                 "--frames", f"{first}:{last + 1}", "--quiet"])
        for camera in named:
            pictures.append(np.array([read_picture(self.folder / f"{camera['name']}_{frame:04d}.exr", camera["width"], camera["height"])
                                      for frame in frames]))
        return pictures


def runs_of(frames):
    """(first, last) of frames that follow each other without a gap."""
    runs = []
    for frame in frames:
        if runs and frame == runs[-1][1] + 1:
            runs[-1][1] = frame
        else:
            runs.append([frame, frame])
    return runs


def register(project, camera, taken, frames, middle, steps=8):
    """Pose, focal length and gain with which the volume looks most like the pictures: least squares by Gauss and Newton with Levenberg's
    damping, derivatives by differences. Returns the camera, its gain, and the change."""
    distance = np.linalg.norm(np.array(camera["R"]) @ middle + np.array(camera["t"]))
    step = np.array([2e-3] * 3 + [2e-3 * distance] * 3 + [2e-3])
    plausible = np.array([0.05] * 3 + [0.05 * distance] * 3 + [0.1])      # of one standard deviation: keeps what nothing tells where it is
    change = np.zeros(7)
    damping = 1e-3

    def fitted_gain(picture):
        return float(np.sum(picture * taken) / max(np.sum(picture * picture), 1e-30))

    def cost_of(picture):
        return float(np.mean((fitted_gain(picture) * picture - taken) ** 2))

    best = cost_of(project([changed(camera, change, middle)], frames)[0])
    for _ in range(steps):
        tries = [changed(camera, change, middle)] + [changed(camera, change + step * (np.arange(7) == k), middle) for k in range(7)]
        pictures = project(tries, frames)
        gain = fitted_gain(pictures[0])
        columns = [gain * (picture - pictures[0]).ravel() / step[k] for k, picture in enumerate(pictures[1:])] + [pictures[0].ravel()]
        slopes = np.array(columns, np.float64)
        residual = (taken - gain * pictures[0]).ravel().astype(np.float64)
        normal, right = slopes @ slopes.T, slopes @ residual
        prior = np.append(np.mean(residual ** 2) / plausible ** 2, 0)
        right -= prior * np.append(change, 0)
        improved = False
        for _ in range(4):
            solved = np.linalg.solve(normal + np.diag(prior + damping * np.diag(normal)), right)[:7]
            cost = cost_of(project([changed(camera, change + solved, middle)], frames)[0])
            if cost < best:
                change, improved, damping = change + solved, True, damping / 4
                break
            damping *= 8
        if not improved or best - cost < 1e-4 * best:
            best = min(best, cost)
            break
        best = cost
    final = changed(camera, change, middle)
    return final, fitted_gain(project([final], frames)[0]), change


# ------------------------------------------------------------------------------------------------------------------ the run


def hold_out(arguments, capture, base, name, frames):
    """Reconstructs without a camera and scores the volume in it."""
    folder = arguments.out / name
    folder.mkdir(parents=True, exist_ok=True)
    camera = next(c for c in capture["cameras"] if c["name"] == name)
    seen = {**capture, "frames": frames, "cameras": [absolute(c, base) for c in capture["cameras"] if c["name"] != name]}
    (folder / "seen.json").write_text(json.dumps(seen, indent=1))
    volume = folder / "volume.npy"
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    run([arguments.volute, "reconstruct", folder / "seen.json", "-o", volume, "--refined", folder / "refined.json",
         "--report", folder / "report.json", "--stats", folder / "stats.json", "--quiet", *arguments.options])
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    scored = frames[::max(1, len(frames) // arguments.scored)] if arguments.scored else frames
    taken = np.array([read_picture(base / file_of(camera["image"], frame + camera.get("frame_shift", 0)), camera["width"], camera["height"])
                      for frame in scored])
    project = Projector(arguments.volute, {**capture, "frames": frames}, volume, folder / "projected")
    given = project([camera], scored)[0] / camera.get("gain", 1)
    box = capture["volume"]
    middle = 0.5 * (np.array(box["min"], float) + np.array(box["max"], float))
    chosen = list(range(0, len(scored), max(1, len(scored) // 4)))
    fitted, gain, change = register(project, camera, taken[chosen], [scored[i] for i in chosen], middle)
    registered = gain * project([fitted], scored)[0]
    shutil.rmtree(folder / "projected")
    volume.unlink()

    shown = sorted({scored[0], scored[len(scored) // 2], scored[-1]})
    for frame in shown:
        i = scored.index(frame)
        for kind, picture in (("taken", taken[i]), ("predicted", given[i]), ("registered", registered[i])):
            write_png(folder / f"{kind}_{frame:04d}.png", picture)
    corner = max(np.linalg.norm(moved_pixels(camera, fitted, np.array(p))) for p in corners_of(box))
    refined = json.loads((folder / "refined.json").read_text())
    return {"camera": name, "frames": scored, "as_given": [psnr(p, t) for p, t in zip(given, taken)],
            "registered": [psnr(p, t) for p, t in zip(registered, taken)], "shown": shown,
            "fit": {**dict(zip(FITTED, change.tolist())), "gain": gain, "largest_move": float(corner)},
            "refined": {c["name"]: refinement(old, c) for old, c in
                        zip([c for c in capture["cameras"] if c["name"] != name], refined["cameras"])},
            "cpu_seconds": cpu, "cpu_seconds_a_frame": cpu / len(frames), "wall_seconds": time.monotonic() - start,
            "peak_memory": json.loads((folder / "stats.json").read_text()).get("peak_memory", after.ru_maxrss * 1024)}


def absolute(camera, base):
    return {key: str(base / value) if key in ("image", "background", "mask", "video") and isinstance(value, str) else value
            for key, value in camera.items()}


def corners_of(box):
    return [[box[end][axis] for axis, end in enumerate(ends)] for ends in
            ((a, b, c) for a in ("min", "max") for b in ("min", "max") for c in ("min", "max"))]


def moved_pixels(before, after, point):
    """By how many pixels a point moves in the picture."""
    def seen(camera):
        place = np.array(camera["K"]) @ (np.array(camera["R"]) @ point + np.array(camera["t"]))
        return place[:2] / place[2]
    return seen(after) - seen(before)


def refinement(old, new):
    return {"focal_length": [old["K"][0][0], new["K"][0][0]], "gain": [old.get("gain", 1), new.get("gain", 1)]}


# ----------------------------------------------------------------------------------------------------------------- the page

STYLE = """body{font:16px/1.5 system-ui,sans-serif;max-width:1100px;margin:2em auto;padding:0 1em;color:#222}table{border-collapse:collapse;margin:1em 0}
td,th{padding:.2em .8em;text-align:right;border-bottom:1px solid #ddd}td:first-child,th:first-child{text-align:left}figure{display:inline-block;margin:0 1em 1em 0}
figure img{width:220px;background:#000}figcaption{font-size:14px;color:#555}"""


def mean(values):
    return sum(values) / len(values)


def page(record, arguments):
    rows = "".join(
        f"<tr><td>{html.escape(r['camera'])}</td><td>{mean(r['as_given']):.2f}</td><td>{min(r['as_given']):.2f}</td>"
        f"<td>{mean(r['registered']):.2f}</td><td>{r['fit']['largest_move']:.1f}</td><td>{r['fit']['gain']:.3f}</td>"
        f"<td>{r['cpu_seconds_a_frame']:.2f}</td><td>{r['peak_memory'] / 2**20:.0f}</td></tr>" for r in record["cameras"])
    sections = []
    for r in record["cameras"]:
        name = html.escape(r["camera"])
        figures = "".join(f'<figure><img src="{name}/{kind}_{frame:04d}.png" alt="{kind}"><figcaption>{kind}, frame {frame}</figcaption></figure>'
                          for frame in r["shown"] for kind in ("taken", "predicted", "registered"))
        values = "".join(f"<tr><td>{frame}</td><td>{a:.2f}</td><td>{b:.2f}</td></tr>" for frame, a, b in zip(r["frames"], r["as_given"], r["registered"]))
        refined = "".join(f"<tr><td>{html.escape(c)}</td><td>{v['focal_length'][0]:.1f}</td><td>{v['focal_length'][1]:.1f}</td><td>{v['gain'][1]:.3f}</td></tr>"
                          for c, v in r["refined"].items())
        sections.append(f"<h2>{name} held out</h2>{figures}<table><tr><th>frame</th><th>as given [dB]</th><th>registered [dB]</th></tr>{values}</table>"
                        f"<table><tr><th>refined camera</th><th>focal length, given [pixels]</th><th>refined</th><th>gain</th></tr>{refined}</table>")
    protocol = html.escape(__doc__.split("Protocol, so that other programs can be compared:")[1].split("Writes OUT")[0]).replace("\n* ", "<li>")
    return (f"<!doctype html><meta charset='utf-8'><title>Cameras held out</title><style>{STYLE}</style><h1>Cameras held out</h1>"
            f"<p>{html.escape(str(arguments.capture))}, frames {record['frames'][0]} to {record['frames'][-1]}, {html.escape(record['version'])}, "
            f"{time.strftime('%Y-%m-%d')}.</p><table><tr><th>held out</th><th>as given, mean [dB]</th><th>least</th><th>registered, mean [dB]</th>"
            f"<th>registered by [pixels]</th><th>gain</th><th>CPU time a frame [s]</th><th>memory [MiB]</th></tr>{rows}</table>"
            f"<h2>Protocol</h2><ul>{protocol}</ul>{''.join(sections)}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("capture", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--volute", type=pathlib.Path, default=pathlib.Path(__file__).parent.parent / "build/release/bin/volute")
    parser.add_argument("--frames", help="A:B[:S], half-open; default all")
    parser.add_argument("--cameras", help="names to hold out, by commas; default each in turn")
    parser.add_argument("--scored", type=int, default=0, metavar="N", help="score about N frames instead of all")
    parser.add_argument("--height", type=int, default=480, help="of the plume's pictures [pixels]")
    parser.add_argument("options", nargs="*", help="after --: options for reconstruct, for comparison; the record is without")
    arguments = parser.parse_args()
    if not shutil.which("ffmpeg"):
        fail("ffmpeg is needed to read pictures: apt-get install ffmpeg")
    if not os.access(arguments.volute, os.X_OK):
        fail(f"there is no {arguments.volute}: ./dev build makes it, --volute names another")
    arguments.volute = arguments.volute.resolve()
    arguments.out.mkdir(parents=True, exist_ok=True)
    arguments.out = arguments.out.resolve()
    wanted = list(range(*map(int, arguments.frames.split(":")))) if arguments.frames else None
    if arguments.capture.is_dir():
        base = arguments.out / "pictures"
        base.mkdir(exist_ok=True)
        span = wanted or list(range(120))
        capture = plume_capture(arguments.capture, base, list(range(span[0], span[-1] + 1)), arguments.height)
    else:
        base = arguments.capture.resolve().parent
        capture = json.loads(arguments.capture.read_text())
        if any("image" not in camera for camera in capture["cameras"]):
            fail(f"{arguments.capture}: a camera without `image`; take its film apart into pictures first")
    frames = wanted or [int(frame) for frame in capture["frames"]]
    names = [camera["name"] for camera in capture["cameras"]]
    held = arguments.cameras.split(",") if arguments.cameras else names
    if unknown := [name for name in held if name not in names]:
        fail(f"{arguments.capture} has no camera {', '.join(unknown)}; it has {', '.join(names)}")
    version = run([arguments.volute, "--version"]).decode().splitlines()[0]
    record = {"capture": str(arguments.capture), "version": version, "options": arguments.options, "frames": frames, "cameras": []}
    for name in held:
        result = hold_out(arguments, capture, base, name, frames)
        record["cameras"].append(result)
        print(f"{name}: as given {mean(result['as_given']):.2f} dB, registered {mean(result['registered']):.2f} dB, "
              f"{result['cpu_seconds_a_frame']:.2f} s of CPU a frame", flush=True)
        (arguments.out / "record.json").write_text(json.dumps(record, indent=1))
        (arguments.out / "index.html").write_text(page(record, arguments))
    print(arguments.out / "index.html")


if __name__ == "__main__":
    main()
