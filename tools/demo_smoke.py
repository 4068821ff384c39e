# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""The demo's chapter on smoke: a hall that fills, seen from its door, and exit signs in it."""
import copy
import json

NBSP = "\u00a0"
SEED, INTERVAL, STEPS = 1, 5, 33
MOMENTS = (10, 35, 50, 70, 100, 150)
SIGN_MOMENTS = (60, 90, 110, 130)
SPEED = 10
SIZE, FILM = (640, 360), (480, 270)

LAMPS = [{"kind": "spot", "position": [x, 6, 4.9], "target": [x, 6, 0], "angle": 360, "intensity": [28, 26, 23], "radius": 0.25}
         for x in (3.5, 14.5)]
FIRE = {"kind": "spot", "position": [24.3, 6, 0.7], "target": [24.3, 6, 6], "angle": 360, "intensity": [34, 14, 4], "radius": 0.5}
AMBIENT = {"kind": "ambient", "radiance": [0.05, 0.05, 0.055]}


def sign(name, y, emitting):
    return {"name": name, "position": [19.97, y, 3.1], "normal": [-1, 0, 0], "size": [1.0, 0.5], "emitting": emitting}


SCENE = {
    "format": "volute-scene-1",
    "camera": {"eye": [2.3, 6.8, 1.7], "target": [20, 6, 2.5], "fov": 58, "size": list(SIZE)},
    "lights": [*LAMPS, FIRE, AMBIENT],
    "media": [{"kind": "smoke", "case": "hall.pvd", "field": "soot", "quantity": "soot-density", "unit": "g/m3", "mode": "photometric",
               "albedo": [0.5, 0.5, 0.5], "walls": [0.72, 0.70, 0.66]}],
    "signs": [sign("emitting", 6.65, True), sign("reflecting", 5.35, False)]}

BALL = {
    "format": "volute-scene-1",
    "camera": {"eye": [-2.6, -2.8, 2.5], "target": [0.5, 0.4, 1.0], "fov": 58, "size": [480, 360]},
    "lights": [{"kind": "spot", "position": [-1.9, -0.6, 3.8], "target": [0.2, 0.1, 1.2], "angle": 64, "intensity": [30, 29, 27]},
               {"kind": "ambient", "radiance": [0.06, 0.06, 0.07]}],
    "media": [{"kind": "smoke", "case": "ball.vtu", "field": "soot", "quantity": "soot-density", "unit": "g/m3",
               "albedo": [0.9, 0.9, 0.9], "walls": [0.72, 0.70, 0.66]}]}


# Walls are seen from inside alone: from here one looks over the whole building.
OUTSIDE = {"eye": [-3, -22, 15], "target": [13, 5.5, 0.2], "fov": 34, "size": [560, 340]}
PLANE, CONTOUR = ("y", 6), 10  # through the fire, and the visibility of the isosurface [m]


def changed(scene, mode=None, lights=None, camera=None):
    scene = copy.deepcopy(scene)
    if mode:
        scene["media"][0]["mode"] = mode
    if lights is not None:
        scene["lights"] = lights
    scene["camera"].update(camera or {})
    return scene


def make(demo, say):
    """All pictures and films; returns what was counted."""
    say("smoke: a hall on fire")
    demo.run("volute", "synthesize", "hall", "-o", "hall.pvd", "--frames", STEPS, "--interval", INTERVAL, "--seed", SEED)
    demo.run("volute", "synthesize", "ball", "-o", "ball.vtu")
    close = {"eye": [8.9, 6, 1.7], "target": [20, 6, 3.1], "fov": 8, "size": [480, 200]}
    scenes = {"hall": SCENE, "threshold": changed(SCENE, "threshold"), "signs": changed(SCENE, "threshold", camera=close),
              "outside": changed(SCENE, camera=OUTSIDE), "unlit": changed(SCENE, lights=[{"kind": "ambient", "radiance": [0.35, 0.35, 0.35]}]),
              "ball": BALL, "ball_unlit": changed(BALL, lights=[{"kind": "ambient", "radiance": [0.35, 0.35, 0.35]}])}
    for name, scene in scenes.items():
        (demo.out / f"smoke_{name}.json").write_text(json.dumps(scene, indent=1))

    def still(scene, out, time, *more, exposure=1):
        return demo.run("volute", "render", f"smoke_{scene}.json", "-o", out, "--time", time, "--exposure", exposure, "--cache", "light", *more,
                        "--json")

    say("smoke: stills")
    for time in MOMENTS:
        still("hall", f"smoke_{time}.png", time, "--legend")
    for time in SIGN_MOMENTS:
        still("signs", f"smoke_signs_{time}.png", time, "--legend")
    still("threshold", "smoke_threshold.png", MOMENTS[3], "--legend")
    still("unlit", "smoke_unlit.png", MOMENTS[3])
    still("ball", "smoke_ball.png", 0)
    still("ball_unlit", "smoke_ball_unlit.png", 0)
    contours(still)
    depth = still("hall", "smoke_depth.png", MOMENTS[3], "--aov", "optical-depth", "--colormap", "viridis", "--legend", exposure=1 / 8)
    say("smoke: the film")
    film = demo.run("volute", "render", "smoke_hall.json", "-o", "hall.mp4", "--size", f"{FILM[0]}x{FILM[1]}", "--speed", SPEED, "--exposure", 1, "--cache", "light",
                    "--legend", "--json")
    return {"film": film, "depth": depth}


def contours(still):
    """One moment from one place, by four means."""
    plane = f"{PLANE[0]}={PLANE[1]}"
    for name, words in (("volume", ()), ("concentration", ("--slice", plane, "--slice-shows", "concentration")),
                        ("visibility", ("--slice", plane)), ("isosurface", ("--isosurface", CONTOUR))):
        still("outside", f"smoke_by_{name}.png", MOMENTS[3], "--legend", *words)


def sections(result):
    """As Figures 1, 2, 6 and 8 of Staubli et al. 2005."""
    film = result["film"]
    milliseconds = film["milliseconds"]["render"] / film["pictures"]
    look = f"perspective 58°, from 1.7{NBSP}m above the floor; linear light, exposure 1, shown as sRGB"
    first = {"title": "A hall that fills with smoke",
             "text": ["A fire in the room behind the door, made up from a seed on a mesh of 28 × 12 × 6 m: about 190 000 tetrahedra, soot "
                      "density at their corners. `volute render` integrates extinction and scattered light exactly in each "
                      "tetrahedron. Lamps below the ceiling and the fire light the smoke and the walls through the smoke.",
                      f"Extinction is Km times the soot density, Km = 8700{NBSP}m²/kg; {look}."],
             "facts": [{"value": f"{milliseconds:.0f}{NBSP}ms", "label": f"a picture of the film, {FILM[0]} × {FILM[1]}, walls and signs included"},
                       {"value": f"{film['smoke']['lights_reused']} of {film['smoke']['lights_computed'] + film['smoke']['lights_reused']}",
                        "label": "lamps and steps whose light was kept from pictures before"}],
             "figures": [{"file": "hall.mp4", "poster": "smoke_70.png", "label": "From ignition to 160 s",
                          "caption": f"{SPEED} seconds of fire in a second of film; photometric"},
                         {"file": "smoke_depth.png", "label": "Optical depth up to the walls",
                          "caption": f"After {MOMENTS[3]}{NBSP}s; natural logarithm, viridis"}], "columns": 2}
    moments = {"title": "Six moments",
               "text": "As Figure 1 of Staubli et al. 2005: the column, the layer, the flow through the door, and the hall.",
               "figures": [{"file": f"smoke_{t}.png", "label": f"{t}{NBSP}s", "caption": "Photometric: seen through e^-depth"} for t in MOMENTS],
               "columns": 3}
    signs = {"title": "Which sign is still seen",
             "text": "As Figure 8: two signs of one picture, the left one emitting light (C = 8), the right one reflecting it (C = 3), 11 m "
                     "away. In threshold mode a thing has faded to 10 % where the rule S = C/K calls it no longer visible.",
             "figures": [{"file": f"smoke_signs_{t}.png", "label": f"{t}{NBSP}s", "caption": "Left C = 8, right C = 3; threshold"}
                         for t in SIGN_MOMENTS], "columns": 2}
    contrast = {"title": "The same moment by contours",
                "text": ["As Figure 2 of Staubli et al. 2005: what programs for CFD draw, and the smoke itself, at one moment and from one "
                         "place. A slice has the values of one plane and nothing of what lies before and behind it; an isosurface has one "
                         "value and hides the rest. Neither tells what a person sees, which is the sum along each line of sight.",
                         f"The plane {PLANE[0]} = {PLANE[1]}{NBSP}m goes through the fire. Local visibility is S = C/K with C = 3 and the "
                         "extinction K of that point alone."],
                "figures": [{"file": "smoke_by_volume.png", "label": "The smoke itself",
                             "caption": f"After {MOMENTS[3]}{NBSP}s; photometric, under the lamps"},
                            {"file": "smoke_by_concentration.png", "label": "Slice of the concentration",
                             "caption": f"Soot in g/m³ at {PLANE[0]} = {PLANE[1]}{NBSP}m; plasma, the last colour is the plane's most"},
                            {"file": "smoke_by_visibility.png", "label": "Slice of the local visibility",
                             "caption": f"S = C/K in metres at {PLANE[0]} = {PLANE[1]}{NBSP}m, C = 3; viridis, the last colour is 30{NBSP}m and "
                                        "more"},
                            {"file": "smoke_by_isosurface.png", "label": f"Isosurface of a visibility of {CONTOUR}{NBSP}m",
                             "caption": f"Within it S = C/K is less than {CONTOUR}{NBSP}m, C = 3; lit from the eye"}],
                "columns": 2}
    light = {"title": "Light in smoke",
             "text": "As Figure 6. Each corner of the mesh gets what reaches it of every lamp, exactly, through smoke and past walls; "
                     "smoke scatters it once.",
             "figures": [{"file": "smoke_ball.png", "label": "A ball of smoke under a lamp", "caption": "Its shadow falls on floor and walls"},
                         {"file": "smoke_ball_unlit.png", "label": "Without lamps", "caption": "The same light from everywhere"},
                         {"file": "smoke_70.png", "label": "The hall under its lamps", "caption": f"After {MOMENTS[3]}{NBSP}s; photometric"},
                         {"file": "smoke_unlit.png", "label": "Without lamps", "caption": f"After {MOMENTS[3]}{NBSP}s; photometric"},
                         {"file": "smoke_threshold.png", "label": "Threshold mode",
                          "caption": f"After {MOMENTS[3]}{NBSP}s; seen through 10^(-depth / 3), 23 % thinner than the light that passes"}],
             "columns": 2}
    return [first, moments, contrast, signs, light]
