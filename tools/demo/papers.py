# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""The figures of the three papers, on synthetic data."""
import dataclasses

from effects import put_fog
from descriptions import json_file
from plan import Build, Chapter, Choice, Drawn, Picture, Section, Step, Wipe
from safety import HALL, HALL_SCENE, SHOWN, changed, still
from words import NBSP, bytes_of, digits, percent

# The bit rates of Ahrenberg et al. 2005, Figure 9, except 0.305 for smoke, which is more than all coefficients take here.
SEQUENCES = {"fire": {"rates": (0.066, 0.051, 0.019), "extinction": 0, "mode": "emission only"},
             "smoke": {"rates": (0.106, 0.019), "extinction": 1.5, "mode": f"emission and absorption, 1.5{NBSP}/m per unit"}}
CRUDE = 0.019


# Ahrenberg et al. 2005

def npy(name):
    return f"papers/{name}.npy"


def strip(name):
    return f"papers/strip_{name}/"


def crude(name):
    return f"papers/{name}_{CRUDE}.volute"


def raw_bytes(scale):
    voxels, frames = scale.pick((64, 32), (32, 16))
    return frames * voxels ** 3 * 3 * 4


def tree_steps(scale):
    voxels, frames = scale.pick((64, 32), (32, 16))
    steps = []
    for name, look in SEQUENCES.items():
        steps += [
            Step((npy(name),), f"volute synthesize {name} -o {npy(name)} --size {voxels} --frames {frames}"),
            Step((crude(name),), f"volute compress {npy(name)} -o {crude(name)} --size {int(CRUDE * raw_bytes(scale))} --fast", reads=(npy(name),)),
            Step((f"papers/{name}_{CRUDE}.png",), f"volute render {crude(name)} -o papers/{name}_{CRUDE}.png --time {frames / 2 / 25:g} --ortho 1 "
                 f"--eye 0.5,-1.5,0.5 --target 0.5,0.5,0.5 --size 384x384 --measured --extinction {look['extinction']}", reads=(crude(name),))]
    steps.append(Build("volute-paper-figures", 20))
    for name, look in SEQUENCES.items():
        rates = ",".join(map(str, look["rates"]))
        steps.append(Step((strip(name),), f"volute-paper-figures {npy(name)} --rates {rates} --strip {strip(name)}paper --extinction "
                                          f"{look['extinction']}",
                          reads=(npy(name),)))
    return steps


def rate_distortion(results):
    series = []
    for color, name in enumerate(SEQUENCES):
        rows = results.report(strip(name))["rate_distortion"]
        for kind, label, dash, marker in (("paper", "paper's layout", False, "circle"), ("compact", "compact tree", True, "square")):
            series.append({"name": f"{name}, {label}", "color": color, "dash": dash, "marker": marker,
                           "x": [row[kind]["rate"] for row in rows], "y": [row[kind]["rms"] for row in rows]})
        series.append({"name": f"{name}, file", "color": color, "marker": "diamond",
                       "x": [results.size(crude(name)) / results.report(strip(name))["raw_bytes"]], "y": [results.report(crude(name))["relative_rms"]]})
    return {"title": "RMS error against bit rate", "series": series, "x_log": True, "y_log": True, "x_label": "bit rate [share of raw]",
            "y_label": "RMS error [share of the value range]",
            "caption": f"A diamond is a .volute file on disk, at most {CRUDE} of raw, the paper's lowest rate."}


def frame_rate(name):
    names = (("traversal", "traversal", 0, False), ("traversal_boxes", "traversal, boxes", 0, True), ("slices", "slices", 1, False),
             ("slices_boxes", "slices, boxes", 1, True))

    def draw(results):
        report = results.report(strip(name))
        rows = report["frame_rates"]
        return {"title": f"Frame rate, {name}", "y_log": True, "x_label": "bit rate of the paper's layout [share of raw]", "y_label": "pictures per second",
                "caption": f"Measured in this run with {report['threads']} threads.",
                "series": [{"name": label, "color": color, "dash": dash, "x": [row["rate"] for row in rows], "y": [row[key] for row in rows]}
                           for key, label, color, dash in names]}
    return draw


def zlib_table(results):
    rows = []
    for name in SEQUENCES:
        for row in results.report(strip(name))["rate_distortion"]:
            paper = row["paper"]
            rows.append([name, digits(paper["rms"], 3), digits(paper["rate"], 3), f"{paper['bytes'] / 1e6:.2f}", f"{paper['zlib_bytes'] / 1e6:.2f}",
                         percent(1 - paper["zlib_bytes"] / paper["bytes"])])
    return {"caption": "The paper's layout in memory and compressed with zlib, as it is stored. The paper reports gains of 25 to 30 %.",
            "columns": ["sequence", "relative RMS", "bit rate", "in memory [MB]", "with zlib [MB]", "gain"], "rows": rows}


def strip_caption(name, scale):
    def say(results):
        rows = results.report(strip(name))["strip"][1:]
        errors = ", ".join(f"{digits(row['rms'])} at {row['rate']:.3f}" for row in rows)
        ours = results.report(crude(name))
        return (f"The paper's bit rates and Haar tree: relative RMS {errors}. Volute's codec reaches a relative RMS of {digits(ours['relative_rms'])} "
                f"with {bytes_of(results.size(crude(name)))} on disk, no more than the paper's tree takes at {CRUDE}. Orthographic, "
                f"voxels drawn as boxes, {SEQUENCES[name]['mode']}")
    return say


def tree_sections(scale):
    strips = []
    for name, look in SEQUENCES.items():
        files = ((f"{strip(name)}paper_original.png", "original"), *((f"{strip(name)}paper_{rate:.3f}.png", f"paper, {rate}") for rate in look["rates"]),
                 (f"papers/{name}_{CRUDE}.png", f"Volute, {CRUDE}"))
        strips.append(Choice(files, f"{name.capitalize()} at the paper's bit rates", strip_caption(name, scale), start=len(files) - 2))
    both = tuple(strip(name) for name in SEQUENCES)
    return (
        Section("4D trees: pictures at given bit rates",
                "Ahrenberg et al. 2005, Figure 9. A bit rate is the size of the tree in memory as a share of raw float32. At the lowest "
                "rate, the blocks of the Haar basis are visible; the "
                "slider's last picture is from Volute's codec at the same size.", tuple(strips)),
        Section("4D trees: error and speed against bit rate",
                "Figures 7 and 8. Both trees hold the same Haar coefficients. The paper's nodes have positions, float coefficients and "
                "child offsets; the compact ones have neither positions nor offsets, and one byte per coefficient. Traversal is the paper's "
                "algorithm (Figure 6): each of 64³ voxels of the view volume walks the tree from its root. Slices are how Volute renders: one "
                "frame is extracted from the compact tree and integrated exactly. Pictures have 64 × 64 pixels.",
                (Drawn("plot", rate_distortion, (*both, *map(crude, SEQUENCES))), *(Drawn("plot", frame_rate(name), (strip(name),)) for name in SEQUENCES),
                 Drawn("table", zlib_table, both))))


# Giroud and Biri 2010

KINDS = {0: "degree 0, Haar", 1: "degree 1, linear", 2: "degree 2, quadratic"}
MUS = (1, 0.7, 0.4, 0)


def fog_steps():
    return [
        Step(("papers/coarse/",), "volute synthesize valley -o papers/coarse --pixels 16x9 --size 32"),
        *(coarse_fog(degree) for degree in KINDS),
        *(put_fog(f"papers/fog_level_{n}.png", f"--levels {n} --mu 0", degree=1) for n in range(4)),
        # All details, and none of three levels.
        *(dataclasses.replace(put_fog(f"papers/fog_mu_{mu}.png", f"--levels 3 --mu {mu}", degree=1),
                              like=("papers/fog_level_0.png", "papers/fog_level_3.png")) for mu in MUS)]


def coarse_fog(degree):
    """The frame of the valley with a map of half its resolution, which lets splines be told apart."""
    step = put_fog(f"papers/fog_degree_{degree}.png", degree=degree, cell=16, reads=("papers/coarse/",))
    return Step(step.makes, step.command.replace("effects/valley/fogmap.png", "papers/coarse/fogmap.png"), reads=step.reads)


def fog_section():
    return Section(
        "Fog as B-splines",
        "Giroud and Biri 2010, Figures 3, 6 and 7, on the valley of the first chapter.",
        (Choice(tuple((f"papers/fog_degree_{d}.png", name) for d, name in KINDS.items()), "Splines of the fog",
                f"One map, 32 × 32 pixels of 16{NBSP}m. Haar shows its cells; linear fog is continuous; quadratic fog is smooth"),
         Choice(tuple((f"papers/fog_level_{n}.png", f"{n} removed, cells {8 * 2 ** n} m") for n in range(4)), "Levels of details removed",
                "Only the coarsest level, linear. The mass of the fog is preserved, and no level becomes negative", start=3),
         Choice(tuple((f"papers/fog_mu_{mu}.png", f"mu = {mu}") for mu in MUS), "Details by distance",
                "Three levels: level L from the finest ends at mu^(3 - L) of the distance to the surface. They are merged into one walk, so "
                "mu = 1 costs no extra time",
                start=len(MUS) - 1)), columns=3)


# Staubli et al. 2005

OUTSIDE = {"eye": [-3, -22, 15], "target": [13, 5.5, 0.2], "fov": 34, "size": [560, 340]}  # walls are seen from inside alone
PLANE, CONTOUR = ("y", 6), 10  # through the fire; the visibility of the isosurface [m]
UNLIT = [{"kind": "ambient", "radiance": [0.35, 0.35, 0.35]}]
BALL = "papers/ball.vtu"
BALL_SCENE = {
    "format": "volute-scene-1",
    "camera": {"eye": [-2.6, -2.8, 2.5], "target": [0.5, 0.4, 1.0], "fov": 58, "size": [480, 360]},
    "lights": [{"kind": "spot", "position": [-1.9, -0.6, 3.8], "target": [0.2, 0.1, 1.2], "angle": 64, "intensity": [30, 29, 27]},
               {"kind": "ambient", "radiance": [0.06, 0.06, 0.07]}],
    "media": [{"kind": "smoke", "case": "ball.vtu", "field": "soot", "quantity": "soot-density", "unit": "g/m3",
               "albedo": [0.9, 0.9, 0.9], "walls": [0.72, 0.70, 0.66]}]}
MEANS = (("volume", "the smoke itself", ""), ("concentration", "slice: soot", f"--slice {PLANE[0]}={PLANE[1]} --slice-shows concentration"),
         ("visibility", "slice: S = C/K", f"--slice {PLANE[0]}={PLANE[1]}"), ("isosurface", f"surface of S = {CONTOUR} m", f"--isosurface {CONTOUR}"))


def hall_scene(name, **what):
    scene = changed(HALL_SCENE, **what)
    scene["media"][0]["case"] = "../" + HALL + "hall.pvd"
    return json_file(f"papers/hall_{name}.json", scene)


def smoke_steps():
    return [
        Step((BALL,), f"volute synthesize ball -o {BALL}"),
        hall_scene("outside", camera=OUTSIDE), hall_scene("unlit", lights=UNLIT), hall_scene("threshold", mode="threshold"), hall_scene("lit"),
        json_file("papers/ball.json", BALL_SCENE), json_file("papers/ball_unlit.json", {**BALL_SCENE, "lights": UNLIT}),
        *(still("papers/hall_outside.json", f"papers/by_{name}.png", SHOWN, "--legend", *filter(None, (words,))) for name, _, words in MEANS),
        *(still("papers/hall_lit.json" if name == "lit" else f"papers/hall_{name}.json", f"papers/hall_{name}.png", SHOWN)
          for name in ("lit", "unlit", "threshold")),
        still("papers/hall_lit.json", "papers/depth.png", SHOWN, "--aov optical-depth --colormap viridis --legend", exposure=1 / 8),
        *(still(f"papers/{name}.json", f"papers/{name}.png", 0, reads=(BALL,)) for name in ("ball", "ball_unlit"))]


def smoke_section():
    after = f"after {SHOWN}{NBSP}s"
    return Section(
        "Smoke on tetrahedra",
        f"Staubli et al. 2005, Figures 2 and 6, in the hall of the previous chapter, {after}; Figures 1 and 8 are in that chapter. A slice shows "
        "the values on one plane and nothing in front of or behind it; an isosurface shows one value and hides the rest. Neither shows what a "
        "person sees, which is the sum along each line of sight.",
        (Choice(tuple((f"papers/by_{name}.png", words) for name, words, _ in MEANS), "One time, shown in four ways",
                f"Soot in g/m³ and visibility S = C/K in metres on the plane {PLANE[0]} = {PLANE[1]}{NBSP}m through the fire, C = 3 and K "
                "of that point only; plasma and viridis"),
         Picture("papers/depth.png", "Optical depth up to the walls", "Natural logarithm, viridis"),
         Wipe(("papers/ball_unlit.png", "no lamp"), ("papers/ball.png", "lamp"), "A ball of smoke under a lamp",
              "The light of each lamp at every vertex of the mesh is computed exactly, through smoke and past walls; smoke scatters it once. "
              "Without a lamp, the same light comes from all directions"),
         Choice((("papers/hall_lit.png", "photometric"), ("papers/hall_threshold.png", "threshold mode"), ("papers/hall_unlit.png", "without lamps")), "The hall in different light",
                "Photometric: attenuated by exp(-depth). Threshold: by 10^(-depth / 3), 23 % thinner, so that 10 % is left at the limit of "
                "visibility, S = C/K. Without lamps: the same light from all directions")))


def chapter(scale):
    return Chapter("papers", "The papers' figures", "Figures of Ahrenberg et al. 2005, Giroud and Biri 2010 and Staubli et al. 2005, "
                                                    "reproduced with the data of this page.",
                   (*fog_steps(), *smoke_steps(), *tree_steps(scale), Build("volute-view", 120)), (*tree_sections(scale), fog_section(), smoke_section()))
