# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Fire safety: a burning building in FDS's format, from where and how long its exit signs are visible; a hall as a person in it sees it."""
import json

import building
from descriptions import json_file, text_file
from plan import Chapter, Choice, Drawn, Fact, Picture, Section, Step
from words import NBSP, percent

# A hall with rooms, as FDS would write it
HEIGHT = 1.75  # of eyes above the floor [m]
SIGNS = [{"name": "west exit", "position": [0, 5, 2.25], "normal": [1, 0, 0], "size": [0.6, 0.3], "emitting": True},
         {"name": "north exit", "position": [13.5, 10, 2.25], "normal": [0, -1, 0], "size": [0.6, 0.3]}]
ROUTE = "x,y\n22,2\n17.5,3\n15.5,5.5\n12.5,8\n8,8\n5,5\n0.5,5\n"
CASE, SIGNS_FILE = "safety/building/building.smv", "safety/signs.json"
BUILDING = "safety/building/"

# The same seen from above: FDS's walls and smoke, the signs, and a floor with the two far walls.
SHELL, OVERVIEW, OVERVIEW_TIMES = "safety/shell.obj", "safety/overview.json", (20, 60, 120, 180)
SHELL_OBJ = """v 0 0 -0.02
v 24 0 -0.02
v 24 10.02 -0.02
v -0.02 10.02 -0.02
v -0.02 0 -0.02
v -0.02 0 3
v -0.02 10.02 3
v 24 10.02 3
f 5 2 3 4
f 5 4 7 6
f 4 3 8 7
"""
OVERVIEW_SCENE = {
    "format": "volute-scene-1",
    "camera": {"eye": [31, -13, 15], "target": [12.7, 4.6, 0.3], "fov": 31, "size": [640, 360]},
    "background": [0.01, 0.011, 0.013],
    "geometry": [{"file": "shell.obj"}],
    "lights": [{"kind": "ambient", "radiance": [0.35, 0.35, 0.37]}, {"kind": "sun", "direction": [-0.5, 0.7, -1], "radiance": [1.6, 1.5, 1.4]}],
    "media": [{"kind": "smoke", "case": "building/building.smv", "albedo": [0.3, 0.3, 0.3]}],
    # Twice as large as those that are looked for, to be seen from here, and 1 cm before their walls.
    "signs": [{**sign, "size": [1.2, 0.6], "position": [p + 0.01 * n for p, n in zip(sign["position"], sign["normal"])]} for sign in SIGNS]}


def overview(time):
    return f"safety/overview_{time}.png"


# A hall of tetrahedra beside a room on fire

HALL_SIZE = (640, 360)
LAMPS = [{"kind": "spot", "position": [x, 6, 4.9], "target": [x, 6, 0], "angle": 360, "intensity": [28, 26, 23], "radius": 0.25}
         for x in (3.5, 14.5)]
FIRE_LIGHT = {"kind": "spot", "position": [24.3, 6, 0.7], "target": [24.3, 6, 6], "angle": 360, "intensity": [34, 14, 4], "radius": 0.5}
AMBIENT = {"kind": "ambient", "radiance": [0.05, 0.05, 0.055]}


def hall_sign(name, y, emitting):
    return {"name": name, "position": [19.97, y, 3.1], "normal": [-1, 0, 0], "size": [1.0, 0.5], "emitting": emitting}


HALL_SCENE = {
    "format": "volute-scene-1",
    "camera": {"eye": [2.3, 6.8, 1.7], "target": [20, 6, 2.5], "fov": 58, "size": list(HALL_SIZE)},
    "lights": [*LAMPS, FIRE_LIGHT, AMBIENT],
    "media": [{"kind": "smoke", "case": "hall/hall.pvd", "field": "soot", "quantity": "soot-density", "unit": "g/m3", "mode": "photometric",
               "albedo": [0.5, 0.5, 0.5], "walls": [0.72, 0.70, 0.66]}],
    "signs": [hall_sign("emitting", 6.65, True), hall_sign("reflecting", 5.35, False)]}
HALL = "safety/hall/"
TIMES, SHOWN = (10, 35, 50, 70, 100, 150), 70
SIGN_TIMES = (60, 90, 110, 130)


def changed(scene, **what):
    """The scene with another mode, lights or camera."""
    scene = json.loads(json.dumps(scene))
    if "mode" in what:
        scene["media"][0]["mode"] = what["mode"]
    if "lights" in what:
        scene["lights"] = what["lights"]
    scene["camera"].update(what.get("camera", {}))
    return scene


def still(scene, out, time, *more, exposure=1, reads=(HALL,)):
    words = (f"volute render {scene} -o {out} --time {time} --exposure {exposure:g} --cache light", *more)
    return Step((out,), " ".join(words), reads=(scene, *reads))


CLOSE = {"eye": [8.9, 6, 1.7], "target": [20, 6, 3.1], "fov": 8, "size": [480, 200]}


def hall_steps(scale):
    steps, cell, film, speed = scale.pick((21, 0.4, "400x224", 25), (9, 0.7, "240x134", 40))
    interval = 160 / (steps - 1)
    return [
        Step((HALL,), f"volute synthesize hall -o safety/hall/hall.pvd --frames {steps} --interval {interval:g} --cell {cell} --seed 1"),
        json_file("safety/hall.json", HALL_SCENE),
        json_file("safety/signs_close.json", changed(HALL_SCENE, mode="threshold", camera=CLOSE)),
        *(still("safety/hall.json", f"safety/hall_{time}.png", time, "--legend") for time in TIMES),
        *(still("safety/signs_close.json", f"safety/signs_{time}.png", time, "--legend") for time in SIGN_TIMES),
        Step(("safety/hall.mp4",), f"volute render safety/hall.json -o safety/hall.mp4 --size {film} --speed {speed} --exposure 1 --cache "
                                   "light --legend",
             reads=("safety/hall.json", HALL))]


def building_steps(scale):
    cell, interval = scale.pick((0.25, 10.0), (0.25, 20.0))
    times = tuple(interval * i for i in range(round(180 / interval) + 1))
    return times, [
        Step((BUILDING,), work=building.make, arguments=(BUILDING, cell, times)),
        json_file(SIGNS_FILE, {"signs": SIGNS}),
        text_file("safety/route.csv", ROUTE),
        Step(("safety/plan/",), f"volute visibility {CASE} --signs {SIGNS_FILE} --height {HEIGHT} --step {scale.pick(0.125, 0.25)} -o safety/plan",
             reads=(BUILDING, SIGNS_FILE)),
        Step(("safety/route/",), f"volute visibility {CASE} --signs {SIGNS_FILE} --height {HEIGHT} --route safety/route.csv --step 0.25 "
                                 "--start 60 -o safety/route",
             reads=(BUILDING, SIGNS_FILE, "safety/route.csv")),
        text_file(SHELL, SHELL_OBJ),
        json_file(OVERVIEW, OVERVIEW_SCENE),
        *(Step((overview(time),), f"volute render {OVERVIEW} -o {overview(time)} --time {time} --exposure 1", reads=(OVERVIEW, SHELL, BUILDING))
          for time in OVERVIEW_TIMES)]


def plan_results(results):
    return json.loads((results.out / "safety/plan/visibility.json").read_text(encoding="utf-8"))


def building_section(scale, times):
    step = scale.pick(0.125, 0.25)
    every = 20
    at = f"seen from {HEIGHT}{NBSP}m above the floor; points {step}{NBSP}m apart"
    shown = [t for t in times if t % every == 0 and t > 0]

    def series(results):
        summary = plan_results(results)["summary"]
        lines = [{"name": "any sign", "x": list(times), "y": [row["any"] for row in summary]}]
        lines += [{"name": sign["name"], "x": list(times), "y": [row["signs"][sign["name"]] for row in summary]} for sign in SIGNS]
        return {"title": "Share of the plan from which a sign is visible", "series": lines, "x_label": "time [s]", "y_label": "share of the points"}

    def kept(results):
        plan = plan_results(results)
        return percent(plan["aset"][0]["kept_to_the_end"] / plan["eyes"]["walkable"])

    def way(results):
        (route,) = json.loads((results.out / "safety/route/visibility.json").read_text(encoding="utf-8"))["routes"]
        return percent(route["walk_share_with_a_sign"])

    def maps(number, name):
        return tuple((f"safety/plan/maps/{number}_{name}_{times.index(t):04d}.png", f"{t:.0f} s") for t in shown)

    needs = ("safety/plan/",)
    return Section(
        "A burning building: from where are the signs visible, and how long?",
        ("24 × 10 m with a fire in the east, in the file formats of the Fire Dynamics Simulator. `volute visibility` looks from every "
         "point of the plan to both signs at every stored time. The optical depth of each sight line is integrated exactly through the cells; a "
         "sign is visible while it is at most C, 8 for the light-emitting one in the west and 3 for the reflecting one in the north (Jin's rule; "
         "docs/visibility.md explains what it leaves out).",
         "[report.html](safety/plan/report.html) is what a fire engineer files: all maps, all times, both signs; "
         "beside it, in [safety/plan/](safety/plan/), a table has a row for each eye, sign and time."),
        (Fact(kept, f"of the plan still has a sign in view after {times[-1]:.0f} s", needs),
         Fact(way, "of the way out has a sign in view, for a person who leaves at 60 s", ("safety/route/",)),
         Choice(tuple((overview(time), f"{time} s") for time in OVERVIEW_TIMES), "From above, without the roof",
                "Walls and smoke of FDS, lit and integrated exactly in every cell; the signs are drawn twice as large", start=2),
         Picture("safety/plan/aset.png", "When the last sign is lost (ASET)", f"First stored time at which no sign is visible [s]; {at}"),
         Picture("safety/route/routes.png", "A way out", "From the east end to the west exit at 1.2 m/s, starting at 60 s"),
         Choice(maps(2, "north_exit"), "The reflecting sign in the north",
                f"Visibility S = C / mean extinction [m], C = 3; grey where the sign is not visible; {at}", start=len(shown) // 2),
         Drawn("plot", series, needs)))


def hall_section(scale):
    cells = scale.pick("about 180 000", "about 36 000")
    return Section(
        "What a person sees",
        (f"A hall of 28 × 12 × 6 m beside a room on fire: synthetic soot on {cells} tetrahedra. `volute render` integrates extinction and "
         "scattered light exactly in each of them; lamps below the ceiling and the fire light the smoke, and the walls through it. Extinction is "
         f"Km times the soot density, Km = 8700{NBSP}m²/kg.",),
        (Fact(lambda r: f"{r.report('safety/hall.mp4')['milliseconds']['render'] / r.report('safety/hall.mp4')['pictures']:.0f}{NBSP}ms",
              "per picture of the film, including walls and signs", ("safety/hall.mp4",)),
         Picture("safety/hall.mp4", f"160 s in {160 / scale.pick(25, 40):.0f} s", "Photometric: attenuated by exp(-optical depth); "
                                                                                "linear light, exposure 1, sRGB",
                 poster=f"safety/hall_{SHOWN}.png"),
         Choice(tuple((f"safety/hall_{time}.png", f"{time} s") for time in TIMES), "Six times of the same fire",
                "The column, the layer, the flow through the door, and the hall", start=TIMES.index(SHOWN)),
         Choice(tuple((f"safety/signs_{time}.png", f"{time} s") for time in SIGN_TIMES), "Two signs, 11 m away",
                "The left one emits light (C = 8), the right one reflects it (C = 3). Threshold mode: at the limit of visibility, S = C/K, a "
                "sign has faded to 10 %",
                start=1)))


def chapter(scale):
    times, hall_with_rooms = building_steps(scale)
    return Chapter("safety", "Fire safety", "A burning building: from where, and for how long, are its exit signs visible, and what does "
                                            "a person in the smoke see?",
                   (*hall_with_rooms, *hall_steps(scale)), (building_section(scale, times), hall_section(scale)), door=(overview(120), "safety/plan/aset.png"))
