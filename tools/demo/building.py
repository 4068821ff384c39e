# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""A hall with rooms whose east end burns, as FDS would write it; the smoke is a formula."""
import heapq
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import fds_case

SIZE = (24.0, 10.0, 3.0)  # [m]
WALLS = [(6, 6.25, 0, 3.5), (6, 6.25, 6.5, 10), (11, 11.25, 3, 7), (16, 16.25, 0, 4), (16, 16.25, 7, 10),
         (18, 21, 4.5, 4.75)]  # boxes x0 x1 y0 y1
FIRE = (20.5, 8.0)


def spread(cell):
    """Metres that smoke travels from the fire to each square of the plan, through doors: {(i, j): m}."""
    nx, ny = (round(s / cell) for s in SIZE[:2])
    solid = {(i, j) for i in range(nx) for j in range(ny)
             if any(x0 < (i + .5) * cell < x1 and y0 < (j + .5) * cell < y1 for x0, x1, y0, y1 in WALLS)}
    steps = [(di, dj, cell * math.hypot(di, dj)) for di in (-2, -1, 0, 1, 2) for dj in (-2, -1, 0, 1, 2)
             if math.gcd(di, dj) == 1]
    start = (int(FIRE[0] / cell), int(FIRE[1] / cell))
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


def make(folder, out, cell, times):
    """Writes building.smv into the folder `out`: smoke that spreads below the ceiling at 0.35 m/s and thickens and sinks behind its front."""
    far = spread(cell)

    def extinction(time, x, y, z):
        distance = far.get((int(x / cell), int(y / cell)))
        if distance is None:
            return 0.0
        age = time - distance / 0.35
        if age <= 0:
            return 0.0
        layer = 3.0 - 2.2 * (1 - math.exp(-age / 90)) + 0.15 * math.sin(1.7 * x + 0.05 * time) * math.cos(1.3 * y)
        thick = 0.9 * (1 - math.exp(-age / 120)) * (0.35 + math.exp(-distance / 12))
        return thick / (1 + math.exp((layer - z) / 0.15))

    mesh = fds_case.Mesh("building", [v for s in SIZE for v in (0, s)], [round(s / cell) for s in SIZE],
                         [box + (0, SIZE[2]) for box in WALLS])
    fds_case.FdsCase([mesh], times, extinction).write(folder / out, "building")
