#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Runs the whole story on data that it makes from a seed, and writes one page: `demo.py --bin FOLDER --out demo`.

Every figure on the page is measured by the programs it calls, in this run.
"""
import argparse
import json
import math
import os
import pathlib
import platform
import shutil
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import demo_errors
import demo_page
import demo_smoke
import demo_visibility

NBSP = "\u00a0"
SEQUENCES = {
    # The bit rates of Ahrenberg et al. 2005, Figure 9.
    "fire": {"rates": (0.066, 0.051, 0.019), "extinction": 0, "mode": "emission only"},
    "smoke": {"rates": (0.305, 0.106, 0.019), "extinction": 1.5,
              "mode": f"emission and absorption, extinction 1.5{NBSP}/m per unit"},
}

CAMERAS = {"count": 8, "pixels": 144, "focal": 300, "distance": 5.0, "frame": 32}

FOG = {"sigma": 0.05, "profile": "exponential:2,9", "mus": (1, 0.7, 0.4, 0), "frames": 100, "rate": 20}


def say(text):
    print(f"demo: {text}", file=sys.stderr, flush=True)


class Demo:
    def __init__(self, binaries, out, size, frames):
        self.binaries, self.out, self.size, self.frames = binaries, out, size, frames
        self.seconds = {}

    def run(self, program, *words):
        """Runs one of our programs; its standard output as JSON, or None."""
        begin = time.monotonic()
        done = subprocess.run([self.binaries / program, *map(str, words)], stdout=subprocess.PIPE, cwd=self.out)
        if done.returncode != 0:
            sys.exit(f"demo: {program} {' '.join(map(str, words))}: exit {done.returncode}")
        key = program if program != "volute" else f"volute {words[0]}"
        self.seconds[key] = self.seconds.get(key, 0) + time.monotonic() - begin
        return json.loads(done.stdout) if done.stdout.strip().startswith(b"{") else None

    def sequence(self, name):
        """Makes, compresses, films and measures one sequence."""
        look = SEQUENCES[name]
        say(f"{name}: making {self.frames} frames of {self.size}^3 voxels")
        self.run("volute", "synthesize", name, "-o", f"{name}.npy", "--size", self.size, "--frames", self.frames)
        say(f"{name}: compressing")
        report = self.run("volute", "compress", f"{name}.npy", "-o", f"{name}.volute", "--rms", "2e-4", "--fast",
                          "--bounds=-1,-1,0,1,1,2", "--json")
        say(f"{name}: rendering the film from the tree")
        view = ("--eye", "0,-4.2,1.25", "--target", "0,0,1", "--fov", "30", "--size", "512x512",
                "--extinction", look["extinction"], "--basis", "trilinear")
        film = self.run("volute", "render", f"{name}.volute", "-o", f"{name}.mp4", *view, "--json")
        self.run("volute", "render", f"{name}.volute", "-o", f"{name}.png", *view, "--time", self.frames / 2 / 25, "--json")
        say(f"{name}: the paper's figures")
        figures = self.run("volute-paper-figures", f"{name}.npy", "--rates", ",".join(map(str, look["rates"])),
                           "--strip", f"strip_{name}", "--extinction", look["extinction"])
        return {"report": report, "film": film, "figures": figures}


    def cameras(self):
        """Films the fire with some cameras, reconstructs a frame and looks at it from another side."""
        say(f"cameras: {CAMERAS['count']} of them film the fire")
        size, frame = self.size // 2, CAMERAS["frame"]
        rig = [ring_camera(i) for i in range(CAMERAS["count"])]
        (self.out / "capture.json").write_text(json.dumps(
            {"format": "volute-capture-1", "color": "linear", "pixel_centre": 0.5, "frames": [frame],
             "volume": {"min": [-1, -1, 0], "max": [1, 1, 2], "resolution": [size] * 3},
             "cameras": [camera for camera, _ in rig]}))
        shutil.rmtree(self.out / "views", ignore_errors=True)  # of an earlier run
        (self.out / "views").mkdir()
        bounds = "--bounds=-1,-1,0,1,1,2"
        self.run("volute", "project", "fire.npy", "capture.json", "-o", "views/{camera}_%04d.exr", "--frames",
                 f"{frame}:{frame + 1}", "--basis", "box", bounds, "--json")
        say("cameras: reconstructing")
        report = self.run("volute", "reconstruct", "capture.json", "-o", "reconstructed.volute", "--rms", "2e-4",
                          "--report", "reconstruction.json", "--json")
        view = {"new": (3.4, -3.4, 2.6), "seen": rig[3][1]}
        for name, file, eye, basis in (("truth", "fire.npy", "new", "box"), ("reconstructed", "reconstructed.volute", "new", "trilinear"),
                                       ("seen", "fire.npy", "seen", "box")):
            where = ("--eye", ",".join(f"{v:.6f}" for v in view[eye]), "--target", "0,0,1", "--fov", "27", "--size", "320x320",
                     "--basis", basis, "--time", frame / 25 if file == "fire.npy" else 0)
            source = (file, bounds) if file == "fire.npy" else (file,)
            self.run("volute", "render", *source, "-o", f"cameras_{name}.exr", *where, "--json")
            self.run("volute", "render", *source, "-o", f"cameras_{name}.png", *where, "--exposure", 0.8, "--json")
        compared = self.run("volute", "compare", "cameras_truth.exr", "cameras_reconstructed.exr", "--json")
        return {"report": report, "compared": compared, "size": self.size, "errors": self.camera_errors()}

    def camera_errors(self):
        """How far the compressed reconstruction is from the truth, in the new view and as a volume."""
        self.run("volute", "extract", "reconstructed.volute", "-o", "reconstructed.npy", "--json")
        view = demo_errors.compare_views(self.out / "cameras_truth.exr", self.out / "cameras_reconstructed.exr",
                                         self.out / "cameras_difference.png")
        volume = demo_errors.volume_error(self.out / "fire.npy", CAMERAS["frame"], self.out / "reconstructed.npy")
        return {"view": view, "volume": volume}

    def fog(self, out, degree, *more, source="valley", cell=8):
        """One frame of the valley behind fog; splines of every degree peak where the map's pixels are."""
        origin = -degree * cell / 2
        return self.run("volute", "fog", f"{source}/fogmap.png", "--color", "valley/color.exr", "--depth", "valley/depth.exr",
                        "--camera", "valley/camera.json", "-o", out, "--degree", degree, f"--origin={origin},{origin},0", "--cell", cell, "--sigma-max", FOG["sigma"],
                        "--profile", FOG["profile"], *more, "--json")

    def valley(self):
        """A frame of a made-up valley, fog of several kinds on it, and a flight."""
        say("valley: the frame without fog")
        self.run("volute", "synthesize", "valley", "-o", "valley", "--pixels", "640x360", "--size", 64, "--geometry")
        self.run("volute", "synthesize", "valley", "-o", "coarse", "--pixels", "16x9", "--size", 32)
        say("valley: fog of every kind")
        for degree in (0, 1, 2):
            self.fog(f"fog_degree_{degree}.png", degree, source="coarse", cell=16)
        for levels in range(4):
            self.fog(f"fog_level_{levels}.png", 1, "--levels", levels, "--mu", 0)
        for mu in FOG["mus"]:
            self.fog(f"fog_mu_{mu}.png", 1, "--levels", 3, "--mu", mu)
        self.run("volute", "fog", "valley/fogmap.png", "--color", "valley/color.exr", "--depth", "valley/depth.exr",
                 "--camera", "valley/camera.json", "-o", "fog_none.png", "--sigma-max", 0, "--json")
        lit = self.fog("fog_sun.png", 2, "--sun=-0.45,-0.85,-0.42", "--sun-radiance", "3,2.3,1.5", "--asymmetry",
                       0.6, "--fog-color", "0.28,0.33,0.40", "--geometry", "valley/valley.glb")
        (self.out / "valley/valley.glb").unlink()
        say(f"valley: a flight of {FOG['frames']} frames")
        self.run("volute", "synthesize", "valley", "-o", "flight", "--pixels", "640x360", "--size", 64, "--frames", FOG["frames"])
        flight = self.run("volute", "fog", "flight/fogmap.png", "--color", "flight/color_%04d.png", "--depth",
                          "flight/depth_%04d.exr", "--camera", "flight/camera_%04d.json", "-o", "flight.mp4", "--degree", 2,
                          "--origin=-8,-8,0", "--cell", 8, "--sigma-max", FOG["sigma"], "--profile", FOG["profile"], "--wind", "3,-1,0",
                          "--rate", FOG["rate"], "--json")
        shutil.rmtree(self.out / "flight")
        shutil.rmtree(self.out / "coarse")
        return {"lit": lit, "flight": flight}


def ring_camera(i):
    """One of the cameras on a half arc around the fire, at two heights; x right, y down, z forward."""
    count, pixels, focal = CAMERAS["count"], CAMERAS["pixels"], CAMERAS["focal"]
    angle = math.radians(-180 + 180 * (i + 0.5) / count)
    eye = (CAMERAS["distance"] * math.cos(angle), CAMERAS["distance"] * math.sin(angle), 1.9 if i % 2 else 0.9)

    def unit(vector):
        length = math.sqrt(sum(v * v for v in vector))
        return [v / length for v in vector]

    forward = unit([t - e for t, e in zip((0, 0, 1), eye)])
    right = unit([forward[1], -forward[0], 0])
    down = [forward[1] * right[2] - forward[2] * right[1], forward[2] * right[0] - forward[0] * right[2],
            forward[0] * right[1] - forward[1] * right[0]]
    rotation = [right, down, forward]
    return {"name": f"c{i}", "image": f"views/c{i}_%04d.exr", "width": pixels, "height": pixels,
            "K": [[focal, 0, pixels / 2], [0, focal, pixels / 2], [0, 0, 1]], "R": rotation,
            "t": [-sum(a * b for a, b in zip(row, eye)) for row in rotation]}, eye


def cameras_section(result):
    error = result["compared"]
    report, errors = result["report"], result["errors"]
    look = f"perspective 27°, linear light, one exposure, sRGB; frame {CAMERAS['frame']}"
    return {"title": "Fire from eight cameras",
            "text": [f"The synthetic fire, {result['size']}³ voxels that are boxes of constant light, is filmed by {CAMERAS['count']} cameras "
                     f"on a half arc at two heights, {CAMERAS['pixels']} × {CAMERAS['pixels']} pixels each. `volute reconstruct` fits a volume of half "
                     "that resolution in another basis, trilinear, with values of at least zero inside the visual hull. "
                     "Below, both from a side where no camera stood.",
                     "What each camera saw, what the reconstruction would show it and the difference are in reconstruction.html, "
                     "beside this page."],
            "facts": [{"value": f"{error['psnr']:.1f}{NBSP}dB", "label": "PSNR of the new view"},
                      {"value": f"{errors['view']['relative_l2']:.3f}", "label": "relative L2 error of the new view"},
                      {"value": f"{errors['volume']:.3f}", "label": "relative L2 error of the volume, to means of 2³ voxels"},
                      {"value": f"{report['seconds_per_frame']:.1f}{NBSP}s", "label": "to reconstruct the frame"},
                      {"value": f"{100 * report['hull_share']:.0f}{NBSP}%", "label": "of the voxels are in the visual hull"}],
            "figures": [{"file": "cameras_truth.png", "label": "The fire", "caption": f"{result['size']}³, box basis; {look}"},
                        {"file": "cameras_reconstructed.png", "label": "Reconstructed and compressed",
                         "caption": f"{result['size'] // 2}³, trilinear; from a file of {report['bytes'] / 1e3:.1f}{NBSP}kB; {look}"},
                        {"file": "cameras_difference.png", "label": "Their difference",
                         "caption": "Length of the RGB difference, linear light; viridis from 0 (violet) to "
                                    f"{100 * errors['view']['largest']:.0f}{NBSP}% of the fire's brightest channel (yellow)"},
                        {"file": "cameras_seen.png", "label": "From the place of camera c3", "caption": f"Box basis; {look}"}], "columns": 4}


def fog_sections(result):
    """As Figures 3, 6 and 7 of Giroud and Biri 2010, on one frame of the valley."""
    look = (f"extinction up to {FOG['sigma']}{NBSP}/m, thinning by e every 9{NBSP}m above 2{NBSP}m; perspective 50°, linear light, "
            "shown as sRGB")
    size = 8 * 64
    kinds = {0: "Haar (degree 0)", 1: "Linear (degree 1)", 2: "Quadratic (degree 2)"}
    first = {"title": "Fog over a valley",
             "text": ["A painted map says how thick the fog is at each place, a profile how it thins with height. The valley is a "
                      "picture with depths, as any renderer would give it; `volute fog` integrates the fog from the eye to each "
                      "pixel's depth, exactly in every cell of the map.",
                      f"The map has 64 × 64 pixels of 8{NBSP}m; {look}."],
             "facts": [{"value": f"{result['flight']['milliseconds'] / FOG['frames']:.0f}{NBSP}ms",
                        "label": "a frame of the flight, 640 × 360, reading and encoding included"}],
             "figures": [
                 {"file": "flight.mp4", "poster": "fog_sun.png", "label": "A flight",
                  "caption": f"{FOG['frames']} frames at {FOG['rate']} a second, degree 2, fog colour constant; a wind of 3{NBSP}m/s"},
                 {"file": "fog_sun.png", "label": "A low sun",
                  "caption": "Degree 2; the sun's light is scattered once and shadowed by the fog itself and, exactly, by the hills, trees and houses "
                             "(asymmetry 0.6)"},
                 {"file": "fog_none.png", "label": "Without fog", "caption": "The frame that the fog is put on"},
                 {"file": "valley/fogmap.png", "label": "The painted map",
                  "caption": f"{size}{NBSP}m wide, north up; white is {FOG['sigma']}{NBSP}/m"}], "columns": 2}
    degrees = {"title": "Splines of the fog",
               "text": "As Figure 3 of Giroud and Biri 2010: one map, here of 32 × 32 pixels of 16 m, read as splines of three "
                       "degrees. Haar shows its cells; linear fog is continuous; quadratic fog is smooth.",
               "figures": [{"file": f"fog_degree_{d}.png", "label": name, "caption": f"Cells of 16{NBSP}m"}
                           for d, name in kinds.items()], "columns": 3}
    levels = {"title": "Details removed",
              "text": "As Figure 6: the coarsest level alone, after halving the map so many times. The mass of the fog stays, "
                      "and no level becomes negative.",
              "figures": [{"file": f"fog_level_{n}.png", "label": f"{n} levels removed" if n != 1 else "1 level removed",
                           "caption": f"Linear, cells of {8 * 2 ** n}{NBSP}m"} for n in range(4)], "columns": 2}
    mus = {"title": "Details by distance",
           "text": "As Figure 7: three levels of details, level L from the finest ends at mu^(3 - L) of the distance to the "
                   "surface. All levels are merged into one walk, so mu = 1 costs nothing.",
           "figures": [{"file": f"fog_mu_{mu}.png", "label": f"mu = {mu}", "caption": "Linear, 3 levels, finest cells of 8\u00a0m"}
                       for mu in FOG["mus"]], "columns": 2}
    return [first, degrees, levels, mus]


def films_section(results, frames, size):
    figures, facts = [], []
    for name, result in results.items():
        report = result["report"]
        figures.append({
            "file": f"{name}.mp4", "poster": f"{name}.png", "label": name.capitalize(),
            "caption": f"{SEQUENCES[name]['mode'].capitalize()}; trilinear basis, perspective 30°, the view is 2.25{NBSP}m high; exposure "
                       f"set once, sRGB. Rendered from {name}.volute ({report['bytes'] / 1e6:.2f}{NBSP}MB, relative RMS error "
                       f"{report['relative_rms']:.4f})."})
        facts.append({"value": f"{report['ratio']:.0f} : 1", "label": f"{name}, raw to file"})
    return {"title": "Films from the tree",
            "text": f"Each sequence has {frames} frames of {size}³ voxels, RGB, 25 frames a second, in a cube of 2{NBSP}m. "
                    "The renderer reads the hexadeca-tree and takes out one instant at a time; the four-dimensional "
                    "volume is never unpacked.",
            "facts": facts, "figures": figures, "columns": 2}


def rate_distortion_section(results):
    series = []
    for color, (name, result) in enumerate(results.items()):
        rows = result["figures"]["rate_distortion"]
        for kind, label, dash, marker in (("paper", "paper's layout", False, "circle"), ("compact", "compact tree", True, "square")):
            series.append({"name": f"{name}, {label}", "color": color, "dash": dash, "marker": marker,
                           "x": [row[kind]["rate"] for row in rows], "y": [row[kind]["rms"] for row in rows]})
        series.append({"name": f"{name}, file", "color": color, "marker": "diamond",
                       "x": [result["report"]["bytes"] / result["figures"]["raw_bytes"]],
                       "y": [result["report"]["relative_rms"]]})
    return {"title": "Error against bit rate",
            "text": "As in Figure 7 of Ahrenberg et al. 2005. The bit rate is the size of the tree in memory, as a share of "
                    "the raw float32 data. Both trees hold the same Haar coefficients: the paper's nodes with positions, "
                    "float coefficients and child offsets; the compact one with neither, and one byte a coefficient. A "
                    "diamond is the file on disk.",
            "plots": [{"title": "RMS error against bit rate", "series": series, "x_log": True, "y_log": True,
                       "x_label": "bit rate [share of raw]", "y_label": "RMS error [share of the value range]"}]}


def frame_rate_section(results, threads):
    plots = []
    names = (("traversal", "traversal", 0, False), ("traversal_boxes", "traversal, boxes", 0, True),
             ("slices", "slices", 1, False), ("slices_boxes", "slices, boxes", 1, True))
    for name, result in results.items():
        rows = result["figures"]["frame_rates"]
        plots.append({"title": f"Frame rate, {name}", "y_log": True,
                      "x_label": "bit rate of the paper's layout [share of raw]", "y_label": "frames a second",
                      "series": [{"name": label, "color": color, "dash": dash, "x": [row["rate"] for row in rows],
                                  "y": [row[key] for row in rows]} for key, label, color, dash in names]})
    return {"title": "Frame rate against bit rate",
            "text": "As in Figure 8: pictures of 64 × 64 pixels, orthographic, emission only, with an equal error at an "
                    "equal place on the axis. Traversal is the paper's algorithm (Figure 6): every one of 64³ voxels of "
                    "the view volume walks the tree from its root. Slices are how Volute renders: one instant is taken "
                    f"out of the compact tree and marched exactly. Measured in this run with {threads} threads.",
            "plots": plots}


def strip_section(results):
    sections = []
    for name, result in results.items():
        figures = []
        for row in result["figures"]["strip"]:
            label = "original" if row["rate"] == 1 else f"bit rate {row['rate']:.3f}"
            error = "uncompressed" if row["rate"] == 1 else f"relative RMS {row['rms']:.4f}"
            figures.append({"file": row["file"], "label": f"{name.capitalize()}, {label}",
                            "caption": f"{error}; frame {row['frame']}, {SEQUENCES[name]['mode']}, orthographic, 2{NBSP}m high"})
        sections.append({"title": f"At the paper's bit rates: {name}", "figures": figures, "columns": 4})
    sections[0]["text"] = ("As in Figure 9, in the paper's layout. Where a rate of the paper's is more than all coefficients take, "
                           "nearly all of them are kept. At the lowest rates Haar's blocks show; in the compact "
                           "layout the same coefficients take about a third of the memory.")
    return sections


def zlib_section(results):
    rows = []
    for name, result in results.items():
        for row in result["figures"]["rate_distortion"]:
            paper = row["paper"]
            rows.append([name, f"{paper['rms']:.4f}", f"{paper['rate']:.4f}", f"{paper['bytes'] / 1e6:.2f}",
                         f"{paper['zlib_bytes'] / 1e6:.2f}", f"{100 * (1 - paper['zlib_bytes'] / paper['bytes']):.0f}{NBSP}%"])
    return {"title": "What zlib gains",
            "text": "The paper stores its trees on disk through zlib and reports files that are 25 to 30\u00a0% smaller than the "
                    "tree in memory.",
            "tables": [{"caption": "The paper's layout in memory and through zlib (level 6)",
                        "columns": ["sequence", "relative RMS", "bit rate", "in memory [MB]", "through zlib [MB]", "gain"],
                        "rows": rows}]}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bin", type=pathlib.Path, required=True, help="the folder of the built programs")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("demo"))
    parser.add_argument("--size", type=int, default=64, help="voxels on a side")
    parser.add_argument("--frames", type=int, default=64)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    demo = Demo(options.bin.resolve(), options.out.resolve(), options.size, options.frames)
    begin = time.monotonic()
    results = {name: demo.sequence(name) for name in SEQUENCES}
    cameras = demo.cameras()
    valley = demo.valley()
    smoke = demo_smoke.make(demo, say)
    say("a building: from where its exit signs are seen")
    signs = demo_visibility.chapter(demo)
    threads = results["fire"]["figures"]["threads"]
    page = {"title": "Volute",
            "subtitle": "Fire and smoke in 4D wavelet trees, fog painted on a map, and smoke as a person in it sees it",
            "intro": "Everything on this page was made by `./dev demo` on this machine, from a seed.",
            "footer": f"Made in {time.monotonic() - begin:.0f}{NBSP}s with {threads} threads on {platform.machine()}, "
                      f"{time.strftime('%Y-%m-%d')}.",
            "sections": [films_section(results, options.frames, options.size), rate_distortion_section(results),
                         frame_rate_section(results, threads), *strip_section(results), zlib_section(results),
                         cameras_section(cameras), *fog_sections(valley),
                         *demo_smoke.sections(smoke), signs]}
    (options.out / "results.json").write_text(json.dumps(page, indent=1))
    done = demo_page.main([str(options.out)])
    if done:
        sys.exit(done)
    for key, seconds in demo.seconds.items():
        say(f"{key}: {seconds:.0f} s")
    print(f"Look at {os.path.relpath(options.out / 'index.html')}")


if __name__ == "__main__":
    main()
