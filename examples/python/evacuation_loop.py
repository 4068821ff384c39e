#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""evacuation_loop.py CASE.smv SIGNS.json [WALKS.txt]: how an evacuation program asks Volute who sees which sign.

Without WALKS.txt people stand two metres apart and walk towards the nearest exit sign that they see, as fast as the smoke lets them;
with it (JuPedSim's text format, or id,time,x,y) they go where that says. Each takes in what is in the air."""
import sys

import numpy as np
import volute

STEP = 0.5  # [s]
SPEED = 1.2  # [m/s], in clear air


class Walkers:
    """What a program of its own would be here."""

    def __init__(self, engine, bounds):
        (x0, y0, z0), (x1, y1, z1) = bounds
        x, y = np.meshgrid(np.arange(x0 + 1, x1, 2.0), np.arange(y0 + 1, y1, 2.0))
        self.eyes = np.stack([x.ravel(), y.ravel(), np.full(x.size, z0 + min(1.7, 0.7 * (z1 - z0)))], axis=1)
        self.ids = np.arange(len(self.eyes))
        self.signs = engine.sign_places

    def step(self, seen, speed):
        """seen: shape (agent, sign), speed: [m/s], shape (agent,)"""
        ways = self.signs[None] - self.eyes[:, None]
        ways[..., 2] = 0
        far = np.where(seen, np.linalg.norm(ways, axis=2), np.inf)
        goal = far.argmin(axis=1)
        distance = far.min(axis=1)
        reach = STEP * speed
        goes = np.isfinite(distance) & (distance > 0)
        share = np.zeros(len(self.eyes))
        share[goes] = np.minimum(reach[goes] / distance[goes], 1)
        self.eyes = self.eyes + share[:, None] * ways[np.arange(len(goal)), goal]
        left = distance > np.maximum(reach, 0.5)
        self.eyes, self.ids = self.eyes[left], self.ids[left]


def main(case, signs, walks=None):
    engine = volute.Engine(case, signs)
    for criterion, why in engine.missing.items():
        print(f"not assessed: {criterion} ({why})")
    people = volute.Trajectories(walks) if walks else None
    walkers = None if people else Walkers(engine, volute.Sight(case).bounds)
    time = 0.0
    while time <= engine.times[-1]:
        ids, eyes = people.at(time) if people else (walkers.ids, walkers.eyes)
        if len(ids) == 0 and not people:
            break
        seen = engine.sees(eyes, time)
        doses = engine.dose(ids, eyes, time)
        sees = np.stack([seen[name] == engine.SEEN for name in engine.signs], axis=1)
        if time % 5 == 0:
            fed = [np.nanmax(np.append(doses[name], 0)) for name in engine.criteria if name.startswith("fed")]
            print(f"{time:6.1f} s: {len(ids)} people, {(~sees.any(axis=1)).sum()} see no sign, the largest dose is {max(fed, default=0):.4f}")
        if walkers:
            walkers.step(sees, np.nan_to_num(engine.walking_speed(eyes, time, SPEED), nan=SPEED))  # nan: the smoke is not known
        time += STEP
    print(f"{len(walkers.ids)} people are left" if walkers else f"{len(people.ids)} people walked")


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    main(*sys.argv[1:])
