# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""The demo's chapter on exit signs: a hall with smoke, made here, and from where its signs are seen."""
import heapq
import json
import math

import fds_case

NBSP = "\u00a0"
SIZE, CELL, HEIGHT = (24.0, 10.0, 3.0), 0.25, 1.75
TIMES = [10.0 * t for t in range(19)]
# Walls of a hall: boxes x0 x1 y0 y1.
WALLS = [(6, 6.25, 0, 3.5), (6, 6.25, 6.5, 10), (11, 11.25, 3, 7), (16, 16.25, 0, 4), (16, 16.25, 7, 10),
         (18, 21, 4.5, 4.75)]
FIRE = (20.5, 8.0)
SIGNS = [{"name": "west exit", "position": [0, 5, 2.25], "normal": [1, 0, 0], "size": [0.6, 0.3], "emitting": True},
         {"name": "north exit", "position": [13.5, 10, 2.25], "normal": [0, -1, 0], "size": [0.6, 0.3]}]
ROUTE = "x,y\n22,2\n17.5,3\n15.5,5.5\n12.5,8\n8,8\n5,5\n0.5,5\n"


def spread():
    """Metres that smoke travels from the fire to each square of the plan, through doors: {(i, j): m}."""
    nx, ny = (round(s / CELL) for s in SIZE[:2])
    solid = {(i, j) for i in range(nx) for j in range(ny)
             if any(x0 < (i + .5) * CELL < x1 and y0 < (j + .5) * CELL < y1 for x0, x1, y0, y1 in WALLS)}
    steps = [(di, dj, CELL * math.hypot(di, dj)) for di in (-2, -1, 0, 1, 2) for dj in (-2, -1, 0, 1, 2)
             if math.gcd(di, dj) == 1]
    start = (int(FIRE[0] / CELL), int(FIRE[1] / CELL))
    far, queue = {start: 0.0}, [(0.0, start)]
    while queue:
        distance, (i, j) = heapq.heappop(queue)
        if distance > far[i, j]:
            continue
        for di, dj, length in steps:
            place = (i + di, j + dj)
            between = {(i + (di + s) // 2, j + (dj + s) // 2) for s in (0, 1)}
            inside = 0 <= place[0] < nx and 0 <= place[1] < ny
            if inside and place not in solid and not between & solid and distance + length < far.get(place, 1e9):
                far[place] = distance + length
                heapq.heappush(queue, (distance + length, place))
    return far


def make_building(folder):
    """Writes building.smv: smoke that spreads below the ceiling at 0.35 m/s and thickens and sinks behind its front."""
    far = spread()

    def extinction(time, x, y, z):
        distance = far.get((int(x / CELL), int(y / CELL)))
        if distance is None:
            return 0.0
        age = time - distance / 0.35
        if age <= 0:
            return 0.0
        layer = 3.0 - 2.2 * (1 - math.exp(-age / 90)) + 0.15 * math.sin(1.7 * x + 0.05 * time) * math.cos(1.3 * y)
        thick = 0.9 * (1 - math.exp(-age / 120)) * (0.35 + math.exp(-distance / 12))
        return thick / (1 + math.exp((layer - z) / 0.15))

    mesh = fds_case.Mesh("building", [v for s in SIZE for v in (0, s)], [round(s / CELL) for s in SIZE],
                         [box + (0, SIZE[2]) for box in WALLS])
    return fds_case.FdsCase([mesh], TIMES, extinction).write(folder, "building")


def chapter(demo):
    """Looks at the signs, and returns the section of the page."""
    folder = demo.out / "building"
    folder.mkdir(exist_ok=True)
    make_building(folder)
    (folder / "signs.json").write_text(json.dumps({"signs": SIGNS}, indent=1))
    (folder / "route.csv").write_text(ROUTE)
    look = ("visibility", "building/building.smv", "--signs", "building/signs.json", "--height", HEIGHT)
    demo.run("volute", *look, "-o", "signs", "--step", 0.125, "--json")
    demo.run("volute", *look, "-o", "route", "--route", "building/route.csv", "--step", 0.25, "--start", 60, "--json")
    plan = json.loads((demo.out / "signs" / "visibility.json").read_text())
    (route,) = json.loads((demo.out / "route" / "visibility.json").read_text())["routes"]
    shown = 12
    series = [{"name": "any sign", "x": TIMES, "y": [m["any"] for m in plan["summary"]]}]
    series += [{"name": sign["name"], "x": TIMES, "y": [m["signs"][sign["name"]] for m in plan["summary"]]}
               for sign in SIGNS]
    kept = plan["aset"][0]["kept_to_the_end"] / plan["eyes"]["walkable"]
    at = f"seen from {HEIGHT}{NBSP}m above the floor; points {plan['eyes']['step']}{NBSP}m apart"
    return {
        "title": "Where exit signs are seen",
        "text": ["A hall of 24 × 10 m with a fire in its east, written as the output of FDS. `volute visibility` "
                 "looks from every point of the plan to both signs at every stored time: the optical depth of each sight line is "
                 "integrated exactly through the cells, and a sign is seen while it is at most C, 8 for the lit one in the west "
                 "and 3 for the reflecting one in the north (Jin's rule; docs/visibility.md says what it leaves out)."],
        "facts": [{"value": f"{100 * kept:.0f}{NBSP}%", "label": f"of the plan still sees a sign after {TIMES[-1]:.0f} s"},
                  {"value": f"{100 * route['walk_share_with_a_sign']:.0f}{NBSP}%",
                   "label": "of the way from the east end to the west exit has a sign in view, for one who leaves at 60 s"}],
        "figures": [
            {"file": "signs/aset.png", "label": "When the last sign is lost",
             "caption": f"First stored time at which no sign is seen [s]; {at}"},
            {"file": f"signs/maps/1_west_exit_{shown:04d}.png", "label": f"The lit sign at {TIMES[shown]:.0f} s",
             "caption": f"Visibility S = C / mean extinction [m]; grey where the sign is not seen; {at}"},
            {"file": f"signs/maps/2_north_exit_{shown:04d}.png", "label": f"The reflecting sign at {TIMES[shown]:.0f} s",
             "caption": f"The same for C = 3; {at}"},
            {"file": "route/routes.png", "label": "A way out", "caption": "From the east end to the west exit"}],
        "columns": 2,
        "plots": [{"title": "Share of the plan from which a sign is seen", "series": series, "x_label": "time [s]",
                   "y_label": "share of the points"}]}
