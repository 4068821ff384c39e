# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""volute visibility on random cases of several sources: less that is stored never makes a verdict safer, unless it is said to be unknown."""
import csv
import itertools
import json
import math
import os
import random
import shutil
import struct

import support
from sight_cases import FdsCase, Mesh

NEVER = math.inf
CRITERIA = [{"name": "visibility", "kind": "visibility", "limit": 10}, {"name": "hot", "kind": "temperature", "limit": 60},
            {"name": "fed", "kind": "fed-gas", "model": "fds", "limit": 0.002}, {"name": "heat", "kind": "fed-heat", "limit": 0.3}]


def record(data):
    return struct.pack("<i", len(data)) + data + struct.pack("<i", len(data))


class World:
    """A layer of hot smoke that comes down through a hall, on one mesh or two; from cell to cell it changes by less than three times, as
    is assumed where means at nodes are all that is stored."""

    def __init__(self, seed):
        self.random = random.Random(seed)
        draw = self.random.uniform
        self.cell, self.length = 0.5, self.random.choice([4.0, 6.0])
        cut = self.length / 2 if self.random.random() < 0.4 else self.length
        spans = [(0, cut)] + [(cut, self.length)] * (cut < self.length)
        self.meshes = [Mesh(f"m{i}", (a, b, 0, 2, 0, 3), (round((b - a) / self.cell), 4, 6)) for i, (a, b) in enumerate(spans)]
        self.end = self.random.choice([30.0, 60.0])
        self.height = self.random.choice([1.5, 1.75])  # of eyes: at nodes, or in the middle of cells
        speed, tilt, width, thick, hot, gas = draw(.03, .1), draw(-.05, .05), draw(.45, .6), draw(.3, 2), draw(50, 300), draw(1e-4, 4e-3)

        def layer(t, x, y, z):
            return 1 / (1 + math.exp(min(50, (3.1 - speed * t + tilt * x - z) / width)))

        self.smoke = lambda *at: 0.005 + thick * layer(*at)
        self.heat = lambda *at: 20 + hot * layer(*at)
        self.gas = lambda *at: gas * layer(*at)

    def sources(self):
        def times():
            step, end = self.random.choice([1, 2, 3, 5]), self.end * (1 if self.random.random() < 0.75 else self.random.uniform(.4, .9))
            return [float(i * step) for i in range(int(end / step) + 1)]

        smoke = [("nodes", "SOOT VISIBILITY", "m", self.smoke), ("bytes", "SOOT DENSITY", "kg/m3", self.smoke),
                 ("layer", "SOOT VISIBILITY", "m", self.smoke) if self.height == 1.5 else
                 ("cells", "SOOT EXTINCTION COEFFICIENT", "1/m", self.smoke)]
        chosen = self.random.sample(smoke, self.random.randint(1, 3))
        kinds = ["cells", "nodes"] + ["layer"] * (self.height == 1.5)
        for one in (("TEMPERATURE", "C", self.heat), ("CARBON MONOXIDE VOLUME FRACTION", "mol/mol", self.gas)):
            chosen += [(self.random.choice(kinds),) + one for _ in range(self.random.randint(1, 3))]
        return [one + (times(),) for one in chosen]


def at_nodes(mesh, formula):
    """The mean over the cells around a node, as FDS has it."""
    values = {c: formula(*(mesh.middle(axis, c[axis]) for axis in range(3))) for c in itertools.product(*map(range, mesh.cells))}
    around = list(itertools.product((0, 1), repeat=3))
    return lambda node: sum(values[tuple(min(max(n - d, 0), m - 1) for n, d, m in zip(node, one, mesh.cells))] for one in around) / 8


def write_bytes(path, world, mesh, formula, times):
    """.s3d: opacity over a cell, of runs."""
    nx, ny, nz = mesh.cells
    data = record(struct.pack("<8i", 1, 0, 0, nx, 0, ny, 0, nz))
    for time in times:
        value = at_nodes(mesh, lambda *at, time=time: formula(time, *at))
        opacity = [round(254 * (1 - math.exp(-world.cell * value((i, j, k)))))
                   for k in range(nz + 1) for j in range(ny + 1) for i in range(nx + 1)]
        runs = b"".join(b"\xff" + bytes([byte, n]) if n > 3 else bytes([byte] * n) for byte, n in run_lengths(opacity))
        data += record(struct.pack("<f", time)) + record(struct.pack("<2i", len(opacity), len(runs))) + record(runs)
    path.write_bytes(data)


def run_lengths(values):
    for byte, same in itertools.groupby(values):
        left = len(list(same))
        while left > 0:
            yield byte, min(left, 250)
            left -= 250


def write_slice(path, box, labels, values_at, times):
    i0, i1, j0, j1, k0, k1 = box
    data = b"".join(record(text[:30].ljust(30).encode()) for text in labels) + record(struct.pack("<6i", *box))
    for time in times:
        value = values_at(time)
        values = [value((i, j, k)) for k in range(k0, k1 + 1) for j in range(j0, j1 + 1) for i in range(i0, i1 + 1)]
        data += record(struct.pack("<f", time)) + record(struct.pack(f"<{len(values)}f", *values))
    path.write_bytes(data)


class Sources(support.TestCase):
    def write(self, world, sources):
        """The case; files by source."""
        shutil.rmtree(self.path("case"), ignore_errors=True)
        folder = self.path("case")
        folder.mkdir()
        index = FdsCase(world.meshes, [0.0], lambda *_: 0.0).write(folder)
        lines, files = [index.read_text().split("SLCC")[0]], []
        for n, (kind, quantity, unit, formula, times) in enumerate(sources):
            files.append([])
            for m, mesh in enumerate(world.meshes):
                path = folder / f"s{n}_{m}.{'s3d' if kind == 'bytes' else 'sf'}"
                files[-1].append(path)
                if kind == "bytes":
                    write_bytes(path, world, mesh, formula, times)
                    lines.append(f"SMOKF3D     {m + 1}  8700.\n {path.name}\n {quantity}\n rho\n {unit}\n")
                    continue
                nx, ny, nz = mesh.cells
                box = (0, nx, 0, ny, 0, nz) if kind != "layer" else (0, nx, 0, ny, 3, 3)

                def values_at(time, mesh=mesh, kind=kind, formula=formula, sees=quantity == "SOOT VISIBILITY"):
                    if kind == "cells":
                        return lambda node: formula(time, *(mesh.middle(axis, max(node[axis] - 1, 0)) for axis in range(3)))
                    return at_nodes(mesh, lambda *at: min(3 / formula(time, *at), 30) if sees else formula(time, *at))

                write_slice(path, box, (quantity, "short", unit), values_at, times)
                lines.append(f"{'SLCC' if kind == 'cells' else 'SLCF'}     {m + 1} # STRUCTURED & {' '.join(map(str, box))} ! {n + 1} 1\n"
                             f" {path.name}\n {quantity}\n short\n {unit}\n")
        index.write_text("".join(lines))
        return index, files

    def answers(self, case, plan=False, people=False):
        """{criterion: [(not before, at the latest)]} of each place, or None where the case is refused; and the report."""
        where = ("--height", "1.6", "--step", "1", "--everywhere", "--maps", "aset") if plan else ("--eyes", self.path("eyes.csv"))
        out = self.path("walked" if people else "out")
        if people:
            where = ("--trajectories", self.path("people.csv"))
        result = support.volute("visibility", case, "--signs", self.path("signs.json"), "--criteria", self.path("criteria.json"), *where,
                                "-o", out)
        if result.code != 0:
            return None
        report = json.loads((out / "visibility.json").read_text())

        def span(known, first, *last):
            """Of rounding down; what is not known is infinitely late."""
            if first is None:
                first = min(report["end"], -NEVER if known is False else NEVER if known is True else known)
            return first, max(NEVER if time is None else time for time in last)

        def flat(rows):
            return [v for row in rows for v in row] if plan else rows

        key = "rows" if plan else "times"
        said = {one["name"]: list(itertools.starmap(span, zip(*(flat(one[key + part]) for part in ("_known", "", "_up", "_latest")
                                                                if key + part in one))))
                for one in report["tenability"]["criteria"] if key in one}
        for one in report["verdict"]:
            if one["criterion"] == "all" and not one["not_assessed"]:
                least = min((last for times in said.values() for _, last in times), default=0)  # by the least of what means leave open
                said["all"] = [span(one["known"], one["time"], one.get("time_up"), one.get("time_latest", least if least < NEVER else 0))]
        return said, report

    def test_less_is_never_safer(self):
        """Without a source, without one of its files, with one that is cut, with every second or third time of one: what is reached until
        some time by all that is stored is not denied until later by a part of that. Away from walls, where
        values of cells, of nodes and of layers mean the same but for some percent (means of a layer are thicker than its middle): 2 s."""
        self.path("criteria.json").write_text(json.dumps({"criteria": CRITERIA}))
        later = 0
        for seed in range(int(os.environ.get("VOLUTE_WORLDS", "4"))):
            world = World(seed)
            sources = world.sources()
            self.path("signs.json").write_text(json.dumps({"signs": [
                {"name": "exit", "position": [world.length, 1, 1.6], "normal": [-1, 0, 0]}]}))
            self.path("eyes.csv").write_text("x,y,z\n" + "".join(f"{x},1.25,{world.height}\n" for x in (0.75, 1.75, world.length - 0.75)))
            whole, _ = self.answers(self.write(world, sources)[0])
            for n, one in enumerate(sources):
                thin = world.random.choice([2, 3])
                share, mesh = world.random.uniform(0.1, 0.95), world.random.randrange(len(world.meshes))
                for what in ("removed", "missing", "cut", "thinned"):
                    left = list(sources)
                    if what == "removed":
                        left.pop(n)
                    if what == "thinned":
                        left[n] = one[:4] + (one[4][::thin],)
                        if len(left[n][4]) < 2:
                            continue
                    case, files = self.write(world, left)
                    if what == "missing":
                        files[n][mesh].unlink()
                    if what == "cut":
                        data = files[n][mesh].read_bytes()
                        files[n][mesh].write_bytes(data[:int(share * len(data))])
                    found = self.answers(case)
                    if found is None:
                        continue
                    for name, times in found[0].items():
                        for before, now in zip(whole.get(name, []), times):
                            self.assertLessEqual(now[0], before[1] + 2,
                                                 f"world {seed}, {name}: {what} {n} of {[(*s[:2], s[4][1], s[4][-1]) for s in sources]}")
                            later += now[0] > before[0]
        self.assertGreater(later, 0, "nothing was ever lost: these worlds are too easy")

    def test_cells_are_within_what_their_means_leave_open(self):
        """A sharp layer whose cells reach 60 degrees at 21 s and 0.3 % of carbon monoxide at 23 s: by the nodes between them and the cool
        ones below they do later, by the bounds of the nodes not."""
        def layer(t, x, y, z):
            return 1 / (1 + math.exp(min(50, (3.05 - 0.058 * t - z) / .46)))

        mesh = Mesh("hall", (0, 4, 0, 2, 0, 3), (8, 4, 6))
        world = World(0)
        world.meshes = [mesh]
        times = [float(t) for t in range(41)]
        air = [("TEMPERATURE", "C", lambda *at: 20 + 200 * layer(*at)), ("CARBON MONOXIDE VOLUME FRACTION", "mol/mol", lambda *at: .004 * layer(*at))]
        self.path("signs.json").write_text(json.dumps({"signs": [{"name": "exit", "position": [4, 1, 1.6], "normal": [-1, 0, 0]}]}))
        self.path("criteria.json").write_text(json.dumps({"criteria": [
            {"name": "hot", "kind": "temperature", "limit": 60}, {"name": "gas", "kind": "carbon-monoxide", "limit": .001}]}))
        self.path("eyes.csv").write_text("x,y,z\n1.75,1.25,1.5\n")
        self.path("people.csv").write_text("id,time,x,y,z\n1,0,1.75,1.25,1.5\n1,40,1.75,1.25,1.5\n")
        smoke = ("bytes", "SOOT DENSITY", "kg/m3", lambda t, x, y, z: 0.01, times)
        found, walks, tables = {}, {}, {}
        for kind in ("cells", "nodes", "layer"):
            case, _ = self.write(world, [smoke] + [(kind,) + one + (times,) for one in air])
            found[kind] = self.answers(case)
            walks[kind] = self.answers(case, people=True)
            tables[kind] = list(csv.DictReader(self.path("out/tenability.csv").read_text().splitlines()))
        for name in ("hot", "gas"):
            (cells,) = found["cells"][0][name]
            self.assertLess(cells[1], 40)
            for kind in ("nodes", "layer"):
                said, report = found[kind]
                (first, last), = said[name]
                self.assertLessEqual(first, cells[0], (name, kind))
                self.assertGreaterEqual(last, cells[1], (name, kind))
                (one,) = [one for one in report["tenability"]["criteria"] if one["name"] == name]
                self.assertGreater(one["worst_value_at_most"][0], one["worst_value"][0])
                (verdict,) = [one for one in report["verdict"] if one["criterion"] == name]
                self.assertIn("This is by the worst air that rounding, caps and means at nodes allow", verdict["sentence"])
                self.assertGreaterEqual(verdict["time_latest"] or NEVER, last - 1)
                # A person who stands is a point; the first of all criteria is between both ends, too.
                _, walked = walks[kind]
                (there,) = [one for one in walked["tenability"]["criteria"] if one["name"] == name]
                for key in ("times", "times_latest", "worst_value_at_most"):
                    self.assertEqual(there[key], one[key], (name, kind, key))
                for everything in (report["verdict"][0], walked["verdict"][0]):
                    self.assertEqual(everything["criterion"], "all")
                    self.assertGreater(everything["time_latest"] or NEVER, everything["time"])
                for row in tables[kind][1:]:
                    self.assertGreater(float(row[name + "_at_worst"]), float(row[name]))
                self.assertNotIn(name + "_at_worst", tables["cells"][0])
            (one,) = [one for one in found["cells"][1]["tenability"]["criteria"] if one["name"] == name]
            self.assertNotIn("worst_value_at_most", one)
            self.assertNotIn("times_latest", one)

    def test_one_mesh_whose_file_is_cut_or_missing(self):
        """The other mesh keeps its times; in this one nothing is known then: of points, plans, people and lines through it."""
        meshes = [Mesh("west", (0, 10, 0, 4, 0, 3), (10, 4, 3)), Mesh("east", (10, 20, 0, 4, 0, 3), (10, 4, 3))]
        times = [10.0 * i for i in range(13)]
        self.path("signs.json").write_text(json.dumps({"signs": [{"name": "west", "position": [0, 2, 1.6], "normal": [1, 0, 0]},
                                                                 {"name": "east", "position": [20, 2, 1.6], "normal": [-1, 0, 0]}]}))
        self.path("criteria.json").write_text(json.dumps({"criteria": [CRITERIA[0] | {"limit": 3}, CRITERIA[1], CRITERIA[3]]}))
        self.path("eyes.csv").write_text("x,y,z\n5.5,2.5,1.6\n19.5,2.5,1.6\n")
        self.path("walk.csv").write_text("id,time,x,y,z\n1,0,1,2,1.6\n1,120,2,2,1.6\n2,0,18,2,1.6\n2,120,19,2,1.6\n")
        for damage in ("smoke cut", "heat cut", "heat missing", "smoke missing"):
            shutil.rmtree(self.path("case"), ignore_errors=True)
            self.path("case").mkdir()
            case = FdsCase(meshes, times, lambda t, *_: 0.0045 * t,
                           more=[("TEMPERATURE", "C", lambda t, x, *_: 20 + t * (0.75 if x < 10 else 0.6))]).write(self.path("case"))
            heat, until = "heat" in damage, 30 if "cut" in damage else False
            file = self.path(f"case/case_2_{2 if heat else 1}.sf")
            data = file.read_bytes()
            header = 3 * 38 + 32
            if until:
                file.write_bytes(data[:header + 4 * (len(data) - header) // len(times)])
            else:
                file.unlink()
            for plan in (False, True):
                said, report = self.answers(case, plan)
                self.assertEqual(report["end"], 120, damage)
                self.assertIn(file.name, json.dumps([report["remarks"], report["sources"]]), damage)

                def known(one):
                    return [one["rows_known"][2][x] for x in (5, -1)] if plan else one["times_known"]

                criteria = {one["name"]: known(one) for one in report["tenability"]["criteria"]}
                signs = {one["set"]: known(one) for one in report["aset"]}
                self.assertEqual(criteria["hot"], [True, until if heat else True], damage)
                self.assertEqual(criteria["heat"], [True, until if heat else True], damage)
                self.assertEqual(criteria["visibility"], [True, True if heat else until], damage)
                self.assertEqual(signs["west"], [True, True if heat else until], damage)
                self.assertEqual(signs["east"], [True, True] if heat else [until, until], damage)
                verdicts = {one["criterion"]: one for one in report["verdict"]}
                self.assertEqual(verdicts["hot"]["known"], until if heat else True, damage)
                self.assertEqual(verdicts["visibility"]["known"], True if heat else until, damage)
                self.assertEqual(verdicts["all"]["known"], until, damage)
                self.assertEqual(verdicts["hot"]["at_the_latest" if heat else "time"], 60 if heat else 50, damage)
            self.works("visibility", case, "--signs", self.path("signs.json"), "--criteria", self.path("criteria.json"), "--trajectories",
                       self.path("walk.csv"), "-o", self.path("walk"))
            report = json.loads((self.path("walk") / "visibility.json").read_text())
            known = {one["name"]: one["times_known"] for one in report["tenability"]["criteria"]}
            self.assertEqual(known["hot"], [True, until if heat else True], damage)
            self.assertEqual(known["visibility"], [True, True if heat else until], damage)
            if heat:
                continue
            # A picture shows what all files have, or nothing: what is not known looks like clear air.
            drawn = support.volute("render", case, "--time", "20", "--size", "32x24", "-o", self.path("x.png"))
            self.assertEqual(drawn.code, 0 if until else 1, drawn.message)
            self.assertIn("9 of 13 stored times are left out (40 to 120 s)" if until else "copy it beside that file", drawn.message)

    def test_smoke_that_ends_before_the_case(self):
        """The rest goes on: what is hot later is, and whether a sign is seen is not known."""
        mesh = Mesh("hall", (0, 20, 0, 4, 0, 3), (20, 4, 3))
        times = [10.0 * i for i in range(13)]
        case = FdsCase([mesh], times, lambda t, *_: 0.001 * t,
                       more=[("TEMPERATURE", "C", lambda t, x, *_: 20 + t * (20 - x) / 20)]).write(self.folder)
        data = self.path("case_1_1.sf").read_bytes()
        header = 3 * 38 + 32
        self.path("case_1_1.sf").write_bytes(data[:header + 4 * (len(data) - header) // len(times)])
        self.path("signs.json").write_text(json.dumps({"signs": [{"name": "exit", "position": [20, 2, 1.6], "normal": [-1, 0, 0]}]}))
        self.path("criteria.json").write_text(json.dumps({"criteria": CRITERIA[:2]}))
        self.path("eyes.csv").write_text("x,y,z\n0.5,2,1.6\n")
        for plan in (False, True):
            said, report = self.answers(case, plan)
            self.assertEqual((report["times"][-1], report["end"]), (30, 120))
            self.assertIn("the smoke is stored until 30 s, and the case goes on until 120 s", json.dumps(report["remarks"]))
            self.assertEqual((said["hot"][0][0], said["visibility"][0][0]), (40, 30))
            first = report["verdict"][0]
            self.assertEqual((first["time"], first["known"], first["at_the_latest"]), (None, 30, 50))
            self.assertIn("not reached by 30 s, and not known after that", first["sentence"])
            (signs,) = report["aset"]
            self.assertEqual({v for row in (signs["rows_known"] if plan else [signs["times_known"]]) for v in row}, {30})
        # Somebody who asks for these times alone wants to know no more.
        self.works("visibility", case, "--signs", self.path("signs.json"), "--criteria", self.path("criteria.json"), "--eyes",
                   self.path("eyes.csv"), "--frames", "0:3", "-o", self.path("few"))
        report = json.loads((self.path("few") / "visibility.json").read_text())
        self.assertEqual((report["end"], report["verdict"][0]["known"]), (20, True))


if __name__ == "__main__":
    support.main()
