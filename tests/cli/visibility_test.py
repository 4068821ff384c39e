# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""volute visibility: from where signs are seen, in cases written here."""
import csv
import json
import math
import random
import re
import sqlite3
import struct
import subprocess
import sys

import sight_cases
import support
from meaning_formats import netcdf
from sight_cases import FdsCase, Mesh

COLUMNS = ("time,eye_x,eye_y,eye_z,sign,distance,angle,blocked,optical_depth,optical_depth_low,optical_depth_high,"
           "mean_extinction,visibility,visible,seen").split(",")


def uneven(time, x, y, z):
    """Extinction that differs from cell to cell and grows."""
    return (0.02 + 0.01 * time) * (2 + math.sin(7 * x + 3 * y) + math.cos(5 * z + x * y))


class Visibility(support.TestCase):
    def signs(self, *signs, name="signs.json"):
        self.path(name).write_text(json.dumps({"signs": list(signs)}))
        return self.path(name)

    def east(self, **more):
        return {"name": "east", "position": [7, 1.5, 1.1], "normal": [-1, 0, 0], "size": [0.6, 0.3]} | more

    def west(self, **more):
        return {"name": "west", "position": [0, 2, 1.3], "normal": [1, 0, 0], "emitting": True} | more

    def look(self, case, signs, *options, output="out"):
        self.works("visibility", case, "--signs", signs, "-o", self.path(output), *options)
        return self.rows(output)

    def rows(self, output="out"):
        with open(self.path(output) / "sight.csv", newline="") as file:
            reader = csv.DictReader(file)
            self.assertEqual(reader.fieldnames, COLUMNS)
            return [{k: v if k in ("sign", "seen") else float(v) for k, v in row.items()} for row in reader]

    def report(self, output="out"):
        return json.loads((self.path(output) / "visibility.json").read_text())

    def eyes(self, points, name="eyes.csv"):
        self.path(name).write_text("x,y,z\n" + "".join("{},{},{}\n".format(*p) for p in points))
        return self.path(name)

    def two_meshes(self, times=(0.0, 10.0), events=()):
        left = Mesh("left", (0, 4, 0, 3, 0, 2.4), (16, 12, 8), [(2, 2.5, 0, 1.5, 0, 2.4)])
        right = Mesh("right", (4, 7, 0, 3, 0, 2.4), (6, 6, 4), [(5, 5.5, 2, 3, 0, 2.4)])
        return FdsCase([left, right], times, uneven, events)


class Fds(Visibility):
    def test_any_line_equals_the_exact_sum_over_cells(self):
        case = self.two_meshes()
        draw = random.Random(4)
        points = []
        while len(points) < 150:
            point = [round(draw.uniform(0.01, high), 4) for high in (6.99, 2.99, 2.39)]
            if not case.solid(point, 0):
                points.append(point)
        rows = self.look(case.write(self.folder), self.signs(self.east(), self.west()), "--eyes", self.eyes(points))
        self.assertEqual(len(rows), 2 * 2 * len(points))
        self.assertFalse((self.path("out") / "report.html").exists())
        blocked = 0
        for row in rows:
            eye = [row["eye_x"], row["eye_y"], row["eye_z"]]
            target, normal, c = (([7, 1.5, 1.1], -1, 3) if row["sign"] == "east" else ([0, 2, 1.3], 1, 8))
            depth, hidden = case.sight(eye, target, row["time"])
            distance = math.dist(eye, target)
            self.assertLess(abs(row["optical_depth"] - depth), 1e-5 * depth + 1e-9)
            self.assertLess(abs(row["mean_extinction"] - depth / distance), 1e-5 * depth / distance)
            self.assertEqual(row["blocked"], hidden)
            self.assertAlmostEqual(row["distance"], distance, 5)
            cosine = normal * (eye[0] - target[0]) / distance
            self.assertAlmostEqual(row["angle"], math.degrees(math.acos(cosine)), 3)
            self.assertLess(abs(row["visibility"] - c * distance / depth), 2e-5 * row["visibility"])
            if abs(depth / c - 1) > 1e-4:
                self.assertEqual(row["visible"], depth < c and not hidden)
            self.assertLessEqual(row["optical_depth_low"], row["optical_depth"])
            self.assertGreaterEqual(row["optical_depth_high"], row["optical_depth"])
            blocked += row["blocked"]
        self.assertTrue(50 < blocked < len(rows) - 50)
        self.assertEqual(self.report()["signs"][1]["C"], 8)
        # A single time looks along each line itself; several work the lines out once.
        once = self.look(self.path("case.smv"), self.path("signs.json"), "--eyes", self.path("eyes.csv"), "--frames", "1:2",
                         output="once")
        for one, row in zip(once, rows[len(rows) // 2:], strict=True):
            self.assertLess(abs(one["optical_depth"] - row["optical_depth"]), 1e-6 * row["optical_depth"])

    def test_signs_that_nobody_sees_are_told(self):
        """Of one that faces its wall "no sign is lost" was all that was said; where something opens later, nothing is."""
        case = self.two_meshes((0.0, 10.0, 20.0), [(0, 0, 8.0, False), (1, 0, 15.0, False)]).write(self.folder)
        plan = ("--height", 1.1, "--step", 0.5, "-o", self.path("out"))
        result = self.works("visibility", case, "--signs", self.signs(self.east(normal=[1, 0, 0])), *plan)
        self.assertIn("sign 'east' is in sight from no point of the plan, smoke or not", result.message)
        self.assertIn("From 100 % of the points no sign is in sight, smoke or not.", result.text)
        self.fails(1, "visibility", case, "--signs", self.path("signs.json"), "--strict", *plan)
        result = self.works("visibility", case, "--signs", self.signs(self.east()), *plan)
        self.assertRegex(result.message, r"from \d+ % of the points a sign comes into sight after 0 s, where something opens")
        self.assertNotIn("in sight from no point", result.message)

    def test_an_obstruction_that_goes_opens_the_view(self):
        case = self.two_meshes((0.0, 10.0, 20.0), [(0, 0, 8.0, False), (1, 0, 15.0, False)])
        rows = self.look(case.write(self.folder), self.signs(self.east()),
                         "--eyes", self.eyes([(1, 1, 1), (3, 2.9, 1), (4.5, 1, 1)]))
        self.assertEqual([row["blocked"] for row in rows], [1, 1, 0, 0, 1, 0, 0, 0, 0])

    def test_a_reports_figures_are_tables_too(self):
        self.look(self.two_meshes((0.0, 10.0, 60.0)).write(self.folder), self.signs(self.east()), "--height", 1.5, "--step", 0.5,
                  "--maps", "aset")
        report = self.report()
        aset = report["aset"][0]["rows"]
        self.assertTrue(any(value == 10 for row in aset for value in row))
        with open(self.path("out") / "maps.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), report["eyes"]["walkable"])
        x0, y0 = report["eyes"]["origin"]
        for row in rows:
            stated = aset[round((float(row["y"]) - y0) / 0.5)][round((float(row["x"]) - x0) / 0.5)]
            self.assertEqual(float(row["aset"]), math.inf if stated is None else stated)
        with open(self.path("out") / "curves.csv", newline="") as file:
            curve = [float(row["value"]) for row in csv.DictReader(file) if row["name"] == "any sign"]
        self.assertEqual(curve, [record["any"] for record in report["summary"]])

    def test_pictures_show_the_building_and_the_smoke(self):
        case = self.two_meshes()
        self.look(case.write(self.folder), self.signs(self.east()), "--height", 1.5, "--step", 1, "--maps", "aset",
                  "--picture", "4.5,1,1")
        pictures = self.report()["pictures"]
        self.assertEqual({p["mode"] for p in pictures}, {"photometric", "threshold"})
        seen = {(self.path("out") / p["file"]).read_bytes() for p in pictures}
        self.assertEqual(len(seen), len(pictures))
        self.works("render", self.path("out") / "views/view_1.json", "-o", self.path("again.png"), "--size", "64x40")

    def test_memory_does_not_grow_with_time(self):
        self.measures_memory()
        most = []
        for count in (4, 60):
            mesh = Mesh("room", (0, 7, 0, 3, 0, 2.4), (70, 30, 24))
            case = FdsCase([mesh], [0.0], lambda *_: 0.1)
            path = case.write(self.folder, f"long{count}")
            slice_file = self.path(f"long{count}_1_1.sf")
            frame = slice_file.read_bytes()
            head = 3 * 38 + 32
            with open(slice_file, "wb") as file:
                file.write(frame[:head])
                for t in range(count):
                    file.write(struct.pack("<ifi", 4, t, 4) + frame[head + 12:])
            code = ("import resource, subprocess, sys; subprocess.run(sys.argv[1:], check=True, stdout=-3); "
                    "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)")
            out = subprocess.run([sys.executable, "-c", code, support.PROGRAM, "visibility", path, "--quiet", "--signs",
                                  self.signs(self.east()), "-o", self.path(f"out{count}"), "--height", "1.2", "--step",
                                  "0.5", "--maps", "aset"], check=True, stdout=subprocess.PIPE)
            most.append(int(out.stdout))
        self.assertEqual(len(self.report("out60")["times"]), 60)
        # 56 more frames are 12 MB.
        self.assertLess(most[1] - most[0], 4000)


class Plan(Visibility):
    def case(self, times=range(0, 60, 10)):
        """Uniform smoke, K = 0.02 t."""
        mesh = Mesh("hall", (0, 20, 0, 8, 0, 4), (40, 16, 8), [(10, 10.5, 3, 8, 0, 4)])
        return FdsCase([mesh], [float(t) for t in times], lambda t, *_: 0.02 * t).write(self.folder)

    def signs_of_hall(self):
        return self.signs({"name": "exit A/1", "position": [20, 2, 2], "normal": [-1, 0, 0]},
                          {"name": "lit", "position": [0, 4, 2], "normal": [1, 0, 0], "emitting": True})

    def test_loss_times_follow_the_closed_form(self):
        self.look(self.case(), self.signs_of_hall(), "--height", 2, "--step", 0.5, "--set", "lit")
        report = self.report()
        self.assertEqual([entry["set"] for entry in report["aset"]], ["all signs", "exit A/1", "lit", "lit"])
        lit = report["aset"][2]
        checked = 0
        for y, row in enumerate(report["plan"]):
            for x, walkable in enumerate(row):
                point = (0.25 + 0.5 * x, 0.25 + 0.5 * y)
                solid = 10 < point[0] < 10.5 and point[1] > 3
                self.assertEqual(walkable, "0" if solid else "1")
                found = lit["rows"][y][x]
                if solid:
                    self.assertIsNone(found)
                    continue
                # Seen round the end of the wall at x = 10 .. 10.5, y > 3?
                share = [(wall - 0) / point[0] for wall in (10, 10.5)]
                behind = point[0] > 10.5 and max(4 + s * (point[1] - 4) for s in share) > 3
                distance = math.dist(point, (0, 4))
                exact = 0 if behind else 8 / 0.02 / distance
                lost = next((t for t in range(0, 60, 10) if behind or 0.02 * t * distance > 8 * (1 + 1e-6)), None)
                self.assertEqual(lit["rows_up"][y][x], lost, (point, distance))
                if lost is None:
                    self.assertIsNone(found)
                    continue
                # On the safe side: the last stored time at which it is seen.
                self.assertEqual(found, max(0, lost - 10), (point, distance))
                self.assertEqual(lit["rows_down"][y][x], found)
                self.assertAlmostEqual(lit["rows_interpolated"][y][x], exact, 4)
                checked += lost > 0
        self.assertGreater(checked, 50)
        self.assertEqual(report["aset"][3]["rows"], lit["rows"])

    def test_a_door_closes_at_its_own_time(self):
        """Between two stored times; nobody on a route sees through it afterwards."""
        mesh = Mesh("hall", (0, 20, 0, 4, 0, 3), (40, 8, 6), [(10, 10.5, 0, 4, 0, 3)])
        case = FdsCase([mesh], [0.0, 10.0, 20.0], lambda t, *_: 0.001 * t, [(0, 0, 0.0, False), (0, 0, 13.7, True)])
        path = case.write(self.folder)
        signs = self.signs({"name": "exit", "position": [20, 2, 2], "normal": [-1, 0, 0]})
        self.look(path, signs, "--eyes", self.eyes([(2, 2, 2), (15, 2, 2)]))
        for key in ("times", "times_interpolated", "times_up"):
            self.assertEqual(self.report()["aset"][0][key], [13.7, None])
        self.path("route.csv").write_text("x,y\n1,2\n9,2\n")
        self.look(path, signs, "--route", self.path("route.csv"), "--height", 2, "--step", 0.1, "--speed", 0.5)
        (route,) = self.report()["routes"]
        for place in route["walk"]:
            self.assertEqual(place["seen"], ["exit"] if place["time"] < 13.7 else [], place)

    def test_of_many_times_some_are_drawn_and_all_written(self):
        case, signs = self.case(range(0, 28)), self.signs({"name": "exit", "position": [20, 2, 2], "normal": [-1, 0, 0]})

        def numbers(kind):
            return sorted(int(path.stem[-4:]) for path in (self.path("out") / "maps").glob(f"*.{kind}"))
        looked = self.look(case, signs, "--height", 2, "--step", 2)
        drawn = numbers("png")
        self.assertEqual((len(drawn), drawn[0], drawn[-1]), (25, 0, 27))
        self.assertLessEqual(max(b - a for a, b in zip(drawn, drawn[1:])), 2)
        self.assertEqual(numbers("vti"), list(range(28)))
        self.assertIn("exit at 27 s", (self.path("out") / "report.html").read_text())
        self.assertTrue(looked)
        self.look(case, signs, "--height", 2, "--step", 2, "--maps", "all")
        self.assertEqual(numbers("png"), list(range(28)))
        self.look(case, signs, "--height", 2, "--step", 2, "--maps", "aset")
        self.assertEqual((numbers("png"), numbers("vti")), ([], []))

    def test_every_map_is_there_and_says_its_units(self):
        self.look(self.case([0, 30]), self.signs_of_hall(), "--height", 2, "--step", 0.5, "--extinction-limit", 0.3)
        names = sorted(p.name for p in (self.path("out") / "maps").iterdir())
        maps = [f"{sign}_{t:04d}.{kind}" for sign in ("1_exit_A_1", "2_lit") for t in (0, 1) for kind in ("png", "vti")]
        self.assertEqual(names, sorted(maps + ["1_exit_A_1.pvd", "2_lit.pvd"]))
        vti = (self.path("out") / "maps/2_lit_0001.vti").read_bytes()
        head = vti[:vti.index(b"<AppendedData")].decode()
        arrays = re.findall(r'Name="(\w+)" format="appended" offset="(\d+)"', head)
        self.assertIn('WholeExtent="0 40 0 16 0 0"', head)
        base = vti.index(b"_", vti.index(b"<AppendedData")) + 1
        offset = base + int(dict(arrays)["visibility"])
        (size,) = struct.unpack_from("<Q", vti, offset)
        self.assertEqual(size, 4 * 40 * 16)
        values = struct.unpack_from(f"<{size // 4}f", vti, offset + 8)
        self.assertAlmostEqual(values[0], 8 / 0.6, 4)
        self.assertTrue(math.isnan(values[8 * 40 + 20]))
        page = (self.path("out") / "report.html").read_text()
        self.assertIn("jin-emitting", page)
        self.assertNotIn("http", re.sub("base64,[^']*", "", page))
        self.assertEqual(set(re.findall(r"src='(data:image/png;base64,|[^']{0,20})", page)), {"data:image/png;base64,"})
        report = self.report()
        self.assertEqual({v for row in report["aset_local"]["rows"] for v in row}, {0.0, None})
        self.assertEqual({v and round(v, 4) for row in report["aset_local"]["rows_interpolated"] for v in row}, {15.0, None})
        self.assertEqual((self.path("out") / "aset.png").read_bytes()[:8], b"\x89PNG\r\n\x1a\n")

    def test_a_drawing_lies_over_maps(self):
        case = self.two_meshes().write(self.folder)
        signs = self.signs(self.east())
        body = "0 SECTION 2 ENTITIES 0 LINE 10 500 20 500 11 6500 21 500 0 TEXT 1 hall 0 ENDSEC 0 EOF"
        self.path("plan.dxf").write_text("0 SECTION 2 HEADER 9 $INSUNITS 70 4 0 ENDSEC ".replace(" ", "\n") + body.replace(" ", "\n") + "\n")
        message = self.works("visibility", case, "--signs", signs, "-o", self.path("out"), "--step", "0.5", "--underlay",
                             self.path("plan.dxf")).message
        self.assertIn("plan.dxf: not drawn: 1 TEXT", message)
        self.works("visibility", case, "--signs", signs, "-o", self.path("bare"), "--step", "0.5")
        drawn, bare = ((self.path(name) / "aset.svg").read_text().count("<line") for name in ("out", "bare"))
        self.assertEqual(drawn, bare + 1)
        self.path("plan.dxf").write_text("0\nSECTION\n")
        cut = self.fails(1, "visibility", case, "--signs", signs, "-o", self.path("cut"), "--underlay", self.path("plan.dxf"))
        self.assertIn("cut off", cut)

    def test_a_rule_that_nobody_looked_up_says_so(self):
        for name, checked, extinction in (("large-room", False, 0.3), ("aset-rset-maps", True, 0.23)):
            self.look(self.case(range(0, 30, 2)), self.signs_of_hall(), "--height", 2, "--step", 2, "--maps", "aset",
                      "--sight-limit", name, "--round", "up", "--criteria", "none", output=name)
            report = self.report(name)
            self.assertEqual(any("not checked" in remark for remark in report["remarks"]), not checked)
            self.assertEqual("not checked" in (self.path(name) / "report.html").read_text(), not checked)
            self.assertAlmostEqual(report["aset_local"]["extinction"], extinction, 6)
            first = 2 * math.ceil(extinction / 0.04 - 1e-9)
            self.assertEqual({v for row in report["aset_local"]["rows"] for v in row}, {float(first)})

    def test_a_route_is_covered_less_and_less(self):
        self.path("route.csv").write_text("x,y\n2,2\n9,2\n19,2\n")
        rows = self.look(self.case(), self.signs({"name": "exit", "position": [20, 2, 2], "normal": [-1, 0, 0]}),
                         "--route", self.path("route.csv"), "--height", 2, "--step", 0.1, "--speed", 1, "--start", 5)
        (route,) = self.report()["routes"]
        self.assertAlmostEqual(route["length"], 17)
        for moment in route["coverage"]:
            seen = min(17, max(0, 3 / (0.02 * moment["time"]) - 1)) / 17 if moment["time"] else 1
            self.assertLess(abs(moment["any"] - seen), 0.012)
        for place in route["walk"]:
            # 1 m/s from 5 s on: at x = 2 + t - 5 there is K = 0.02 t.
            t = place["time"]
            self.assertAlmostEqual(place["position"][0], 2 + t - 5, 6)
            depth = 0.02 * t * (20 - place["position"][0])
            if abs(depth - 3) > 1e-3:
                self.assertEqual(place["seen"], ["exit"] if depth < 3 else [])
        self.assertTrue((self.path("out") / "report.html").exists())
        self.assertEqual(len(rows), 6 * len(route["walk"]))

    def test_people_look_where_they_are(self):
        self.path("walk.txt").write_text("#framerate: 2.00\n#ID frame x/m y/m z/m\n" + "".join(
            f"3 {f} {1 + 0.5 * f:.2f} 2.00 0.00\n" for f in range(30)))
        rows = self.look(self.case([0, 1, 14, 20]), self.signs_of_hall(), "--trajectories", self.path("walk.txt"),
                         "--height", 1.8)
        self.assertEqual([(row["time"], row["eye_x"], row["eye_z"]) for row in rows if row["sign"] == "lit"],
                         [(0, 1, 1.8), (1, 2, 1.8), (14, 15, 1.8)])
        self.assertEqual([m["people"] for m in self.report()["people"]], [1, 1, 1, 0])

    def test_people_lose_signs_that_smoke_hides(self):
        """Who stands at x = 4 with K = .02 t loses the sign of C = 3 at x = 20 at t = 3 / (.02 * 16); a wall hides none from who walks behind it."""
        mesh = Mesh("hall", (0, 20, 0, 4, 0, 3), (40, 8, 6), [(10, 10.5, 0, 2, 0, 3)])
        case = FdsCase([mesh], [float(t) for t in range(0, 21, 2)], lambda t, *_: 0.02 * t).write(self.folder)
        signs = self.signs({"name": "exit", "position": [20, 1, 2], "normal": [-1, 0, 0]})
        self.path("walk.csv").write_text("id,time,x,y,z\n1,0,4,3.5,2\n1,20,4,3.5,2\n2,0,9,1,2\n2,20,9,1,2\n3,0,2,1,2\n3,2,14,1,2\n3,4,18,1,2\n")
        told = self.look(case, signs, "--trajectories", self.path("walk.csv"))
        self.assertTrue(told)
        report = self.report()
        (sight,) = report["aset"]
        exact = 3 / (0.02 * (16**2 + 2.5**2)**.5)
        self.assertEqual((sight["ids"], sight["in_sight"], sight["times"]), ([1, 2, 3], [True, False, True], [2 * (exact // 2), None, None]))
        self.assertAlmostEqual(sight["times_interpolated"][0], exact, 4)
        (verdict,) = [one for one in report["verdict"] if one["criterion"] == "sight of signs"]
        self.assertIn("by person 1, at x = 4", verdict["sentence"])
        self.assertIn("(2 of 3 people)", verdict["sentence"])
        self.assertNotIn("sight of signs", report["verdict"][0]["not_assessed"])
        # A sign that faces its wall is lost by nobody, which is no verdict.
        away = self.signs({"name": "exit", "position": [20, 1, 2], "normal": [1, 0, 0]})
        self.look(case, away, "--trajectories", self.path("walk.csv"))
        report = self.report()
        self.assertIn("sight of signs", report["verdict"][0]["not_assessed"])
        self.assertNotIn("sight of signs", [one["criterion"] for one in report["verdict"]])

    def test_a_shutter_that_opens_begins_a_loss(self):
        mesh = Mesh("hall", (0, 20, 0, 4, 0, 3), (40, 8, 6), [(10, 10.5, 0, 4, 0, 3)])
        case = FdsCase([mesh], [0.0, 10.0, 20.0], lambda t, *_: 0.02 * t, [(0, 0, 0.0, True), (0, 0, 5.0, False)]).write(self.folder)
        signs = self.signs({"name": "exit", "position": [20, 2, 2], "normal": [-1, 0, 0]})
        eyes = self.eyes([(2, 2, 2), (15, 2, 2), (5, 1, 2)])
        self.look(case, signs, "--eyes", eyes)
        (loss,) = self.report()["aset"]
        self.assertEqual(loss["in_sight"], [True] * 3)
        self.assertIsNone(loss["times_interpolated"][1])
        for found, distance, across in ((loss["times_interpolated"][0], 18, 0.5),
                                        (loss["times_interpolated"][2], 226**.5, 0.5 / 15 * 226**.5)):
            opened, later = 0.1 * distance + 0.1 * across, 0.2 * distance  # where the shutter was, smoke is known from 10 s on
            self.assertAlmostEqual(found, 5 + 5 * (3 - opened) / (later - opened), 4)
        self.assertEqual(loss["times"][0], 5)
        run = self.works("visibility", case, "--signs", signs, "--height", 2, "--step", 1, "--output", self.path("plan"))
        self.assertIn("a sign comes into sight after 0 s, where something opens", run.message)

    def test_people_of_evacuation_programs(self):
        """Pathfinder's table and JuPedSim's database of the same walk are the same, at eyes above the floor."""
        self.path("occupants.csv").write_text(
            '"t","id","name","active","x","y","z","v","distance","location"\n"s","","","","m","m","m","m/s","m",""\n' + "".join(
                f'{t},3,"00003",1,{1 + t},2,0,1,{t},"Floor 0.0 m"\n' for t in range(20)) + '20,3,"00003",0,0,0,0,0,0,""\n')
        # As jupedsim/sqlite_serialization.py writes them: from version 3 on without where people face.
        for name, version, facing in (("people.sqlite", 2, ", ori_x REAL NOT NULL, ori_y REAL NOT NULL"), ("newer.sqlite", 3, "")):
            database = sqlite3.connect(self.path(name))
            database.execute("PRAGMA page_size = 512")  # a tree of several levels
            database.execute("CREATE TABLE trajectory_data (frame INTEGER NOT NULL, id INTEGER NOT NULL, pos_x REAL NOT NULL, "
                             f"pos_y REAL NOT NULL{facing})")
            database.execute("CREATE TABLE metadata (key TEXT NOT NULL UNIQUE PRIMARY KEY, value TEXT NOT NULL)")
            database.execute("INSERT INTO metadata VALUES ('version', ?), ('fps', ?)", (version, 1 / 0.0025 / 4))
            database.execute("CREATE TABLE geometry (hash INTEGER NOT NULL, wkt TEXT NOT NULL)")
            database.execute("CREATE UNIQUE INDEX geometry_hash ON geometry (hash)")
            database.execute("INSERT INTO geometry VALUES (1, ?)", ("POLYGON " * 1000,))
            database.execute("CREATE TABLE frame_data (frame INTEGER NOT NULL, geometry_hash INTEGER NOT NULL)")
            database.execute("CREATE INDEX frame_id_idx ON trajectory_data (frame, id)")
            database.executemany(f"INSERT INTO trajectory_data VALUES (?, 3, ?, 2{', 1, 0' * (version < 3)})",
                                 [(f / 1, 1 + f / 100) for f in range(1901)])
            database.executemany("INSERT INTO frame_data VALUES (?, 1)", [(f / 1,) for f in range(1901)])
            database.commit()
            database.close()
        seen = []
        for name in ("occupants.csv", "people.sqlite", "newer.sqlite"):
            rows = self.look(self.case([0, 1, 14, 20]), self.signs_of_hall(), "--trajectories", self.path(name), "--eye-height", 1.6)
            seen.append(rows)
            self.assertEqual([(row["time"], row["eye_x"], row["eye_z"]) for row in rows if row["sign"] == "lit"],
                             [(0, 1, 1.6), (1, 2, 1.6), (14, 15, 1.6)])
            self.assertTrue(any("eyes are 1.6 m above it" in remark for remark in self.report()["remarks"]))
        self.assertEqual(seen[0], seen[1])
        self.assertEqual(seen[1], seen[2])
        whole = self.path("people.sqlite").read_bytes()
        self.path("people.sqlite").write_bytes(whole[:len(whole) // 2])
        self.assertIn("pages: copy the file again",
                      self.fails(1, "visibility", self.path("case.smv"), "--signs", self.path("signs.json"), "--trajectories",
                                 self.path("people.sqlite"), "-o", self.path("cut")))


class Tetrahedra(Visibility):
    def test_soot_in_grammes_and_what_it_means(self):
        sight_cases.write_vtu(self.path("hall.vtu"), (10, 4, 3), (5, 2, 2), lambda x, y, z: 0.01 + 0.002 * x)
        signs = self.signs({"name": "s", "position": [10, 2, 2], "normal": [-1, 0, 0]})
        eyes = self.eyes([(1, 1, 1.5), (9, 3, 2)])
        rows = self.look(self.path("hall.vtu"), signs, "--eyes", eyes, "--quantity", "soot-density", "--unit", "g/m3",
                         "--mass-extinction", 7600, "--scale", 2)
        for row in rows:
            mean = 2 * 7.6 * (0.01 + 0.002 * 0.5 * (10 + row["eye_x"]))
            self.assertLess(abs(row["mean_extinction"] - mean), 1e-5 * mean)
        rows = self.look(self.path("hall.vtu"), signs, "--eyes", eyes, "--quantity", "products-density", "--unit",
                         "g/m3", "--soot-yield", 0.1, output="b")
        self.assertLess(abs(rows[0]["mean_extinction"] - 0.87 * 0.021), 1e-5)
        rows = self.look(self.path("hall.vtu"), signs, "--eyes", eyes, "--quantity", "extinction", output="c")
        self.assertLess(abs(rows[0]["mean_extinction"] - 0.021), 1e-6)
        # Without a quantity nobody knows what the numbers are.
        self.assertIn("--quantity: is missing", self.fails(2, "visibility", self.path("hall.vtu"), "--signs", signs,
                                                          "--eyes", eyes, "-o", self.path("d")))

    def test_a_series_over_time(self):
        for t in (0, 10):
            sight_cases.write_vtu(self.path(f"s{t}.vtu"), (10, 4, 3), (4, 2, 2), lambda x, y, z: 0.03 * t)
        sight_cases.write_pvd(self.path("s.pvd"), [(0, "s0.vtu"), (10, "s10.vtu")])
        self.look(self.path("s.pvd"), self.signs({"name": "s", "position": [10, 2, 2], "normal": [-1, 0, 0], "C": 1.2}),
                  "--quantity", "extinction", "--height", 1.5, "--step", 1)
        aset = self.report()["aset"][0]
        self.assertEqual([aset[rows][1][0] for rows in ("rows", "rows_up")], [0, 10])
        self.assertAlmostEqual(aset["rows_interpolated"][1][0], 1.2 / 0.03 / math.dist((0.5, 1.5, 1.5), (10, 2, 2)) * 10 / 10, 4)
        self.assertIsNone(aset["rows"][1][9])
        self.assertEqual(self.report()["signs"][0]["law"], "custom")


    def test_pictures_of_what_is_seen(self):
        sight_cases.write_vtu(self.path("hall.vtu"), (10, 4, 3), (5, 2, 2), lambda x, y, z: 0.05 * z)
        self.look(self.path("hall.vtu"), self.signs({"name": "s", "position": [10, 2, 2], "normal": [-1, 0, 0]}),
                  "--quantity", "extinction", "--height", 1.5, "--step", 1, "--maps", "aset", "--picture", "1,2,1.7")
        report = self.report()
        self.assertEqual([(p["mode"], p["sign"]) for p in report["pictures"]], [("photometric", "s"), ("threshold", "s")])
        first, second = ((self.path("out") / p["file"]).read_bytes() for p in report["pictures"])
        self.assertEqual(struct.unpack(">II", first[16:24]), (640, 400))
        self.assertNotEqual(first, second)
        # The scene is there to be rendered again.
        self.works("render", self.path("out") / "views/view_1.json", "-o", self.path("again.png"), "--size", "64x40",
                   "--cache", "none")


class Scenes(Visibility):
    def test_lines_go_through_all_media_and_end_at_surfaces(self):
        """Two blocks of 1 m on the way, one over the other's sign, and a wall."""
        support.write_npy(self.path("block.npy"), (1, 4, 4, 4), [1.0] * 64)
        self.path("wall.obj").write_text("v 5 -9 -9\nv 5 9 -9\nv 5 9 -1\nv 5 -9 -1\nf 1 2 3 4\n")
        block = {"kind": "volume", "file": "block.npy", "extinction": 0.5, "basis": "box"}
        media = [block, block | {"transform": [1, 0, 0, 2, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]}]
        self.path("scene.json").write_text(json.dumps({
            "format": "volute-scene-1", "camera": {"eye": [0, -9, 0], "target": [0, 0, 0], "fov": 40}, "media": media,
            "geometry": [{"file": "wall.obj"}]}))
        signs = self.signs({"name": "open", "position": [8, 0.5, 0.5], "normal": [-1, 0, 0]},
                           {"name": "hidden", "position": [8, 0.5, -4], "normal": [-1, 0, 0]})
        rows = {row["sign"]: row for row in self.look(self.path("scene.json"), signs, "--eyes", self.eyes([(-1, 0.5, 0.5)]))}
        self.assertAlmostEqual(rows["open"]["optical_depth"], 1, places=6)
        self.assertEqual((rows["open"]["blocked"], rows["open"]["visible"]), (0, 1))
        self.assertEqual((rows["hidden"]["blocked"], rows["hidden"]["visible"]), (1, 0))


class Damage(Visibility):
    def setUp(self):
        super().setUp()
        mesh = Mesh("room", (0, 7, 0, 3, 0, 2.4), (7, 3, 3))
        self.case = FdsCase([mesh], [0.0, 1.0], lambda *_: 0.1).write(self.folder)
        self.points = self.eyes([(1, 1, 1)])

    def refused(self, signs, *options, code=1):
        self.path("signs.json").write_text(signs if isinstance(signs, str) else json.dumps(signs))
        return self.fails(code, "visibility", self.case, "--signs", self.path("signs.json"), "-o", self.path("out"),
                          *(options or ("--eyes", self.points)))

    def test_signs_are_checked_one_by_one(self):
        def sign(**more):
            return {"signs": [self.east(), self.east(name="b") | more]}

        def without(key):
            broken = sign()
            del broken["signs"][1][key]
            return broken

        for broken, expected in (
                ({}, "/signs: expected a list"), ({"signs": []}, "/signs: 0 signs"), ("{", "line 1"),
                ({"signs": [3]}, "/signs/0: expected an object"),
                (without("position"), "/signs/1/position: is missing"), (without("normal"), "/signs/1/normal: is missing"),
                (sign(position=[1, 2]), "/signs/1/position"), (sign(position=[1, 2, "x"]), "/signs/1/position"),
                (sign(normal=[0, 0, 0]), "/signs/1/normal: is zero"), (sign(size=[1, -1]), "/signs/1/size"),
                (sign(size=[600, 300]), "/signs/1/size: 600 is out of range; expected [width, height] in metres"),
                (sign(emitting=True, C=3), "/signs/1/emitting: has no effect beside C"),
                (sign(C=0), "/signs/1/C"), (sign(C="jin"), "/signs/1/C"), (sign(emitting=1), "/signs/1/emitting"),
                (sign(angle_law="sine"), "/signs/1/angle_law"), (sign(angle_law={"limit": 270}), "/signs/1/angle_law"),
                (sign(name="east"), "/signs/1/name: 'east' is another"), (sign(emiting=True), "did you mean 'emitting'"),
                (sign(position=[50, 1, 1]), "sign 'b' at 50, 1, 1 m has no gas")):
            message = self.refused(broken, code=2 if "has no gas" in expected else 1)
            self.assertIn(expected, message)

    def test_eyes_and_folders_are_checked(self):
        good = {"signs": [self.east()]}
        self.path("eyes.csv").write_text("x,y,z\n1,1,1\n1,oops,1\n")
        self.assertIn("eyes.csv: line 3: y is 'oops'", self.refused(good))
        self.path("eyes.csv").write_text("x,y\n1,1\n")
        self.assertIn("state the height of the eyes", self.refused(good))
        self.assertIn("nobody can look from z = 9", self.refused(good, "--height", 9, code=2))
        self.assertIn("--quantity is for smoke on meshes; ", self.refused(good, "--quantity", "extinction", code=2))
        self.assertIn("no sign is named 'west'", self.refused(good, "--set", "east,west", code=2))
        self.assertIn("the input has frames 0 to 1", self.refused(good, "--frames", "5:9", code=2))
        self.path("out").mkdir()
        (self.path("out") / "thesis.txt").write_text("x")
        self.path("eyes.csv").write_text("1,1,1\n")
        self.assertIn("holds files of something else", self.refused(good))
        self.assertEqual((self.path("out") / "thesis.txt").read_text(), "x")

    def test_no_file_of_the_case_is_replaced(self):
        signs = self.signs(self.east())
        slice_file = next(iter(sorted(self.path(".").glob("*.sf"))))
        before = slice_file.read_bytes()
        result = support.volute("visibility", self.case, "--signs", signs, "--eyes", self.points, "-o", self.path("out"),
                                "--stats", slice_file)
        self.assertEqual(result.code, 2)
        self.assertIn("is read by this run and would be replaced; give another name", result.message)
        self.assertEqual(slice_file.read_bytes(), before)
        message = self.fails(2, "visibility", self.case, "--signs", signs, "--eyes", self.points, "-o", self.path("out"),
                             "--stats", self.path("out") / "visibility.json")
        self.assertIn("is in the folder that --output makes anew", message)

    def test_what_is_lost_before_anybody_looks_is_not_known(self):
        room = FdsCase([Mesh("room", (0, 7, 0, 3, 0, 2.4), (7, 3, 3))], [0.0, 10.0, 20.0], lambda t, x, y, z: 0.05 * t)
        case = room.write(self.path("."), "late")
        signs = self.signs(self.east(), name="one.json")
        plan = ("visibility", case, "--signs", signs, "--height", 1, "--step", 1, "--maps", "aset", "-o", self.path("out"))
        self.assertIn("ASET of all criteria: 0 s", self.works(*plan).text)
        late = self.works(*plan, "--frames", "1:3")
        self.assertIn("the smoke is looked at from 10 s on, and the case begins before", late.message)
        self.assertIn("ASET of all criteria: not known at 100 % of the floor", late.text)
        self.assertIn("at the latest 10 s", late.text)
        verdict = self.report()["verdict"][0]
        self.assertEqual((verdict["time"], verdict["known"], verdict["at_the_latest"]), (None, False, 10))
        room.times = [20.0]
        late = self.works("visibility", room.write(self.path("."), "once"), *plan[2:])
        self.assertIn("not known at 100 % of the floor", late.text)

    def test_places_for_nobody_leave_no_verdict_of_nothing(self):
        everywhere = [[-1, -1], [8, -1], [8, 4], [-1, 4]]
        self.path("areas.json").write_text(json.dumps({"areas": [{"name": "all", "people": False, "polygon": everywhere}]}))
        result = self.works("visibility", self.case, "--signs", self.signs(self.east()), "--height", 1, "--step", 1, "--maps", "aset",
                            "--areas", self.path("areas.json"), "-o", self.path("out"))
        self.assertIn("no point of the plan is for people: all points count", result.message)
        self.assertNotIn("none is reached", result.text.split("\n")[0])

    def test_what_walkers_see_is_known_as_long_as_the_smoke(self):
        self.path("route.csv").write_text("x,y,z\n1,1,1\n1,2,1\n")
        walk = ("visibility", self.case, "--signs", self.signs(self.east()), "--route", self.path("route.csv"), "-o", self.path("out"))
        self.assertIn("whether a sign is in view is not known on the way", self.works(*walk, "--start", 900).text)
        self.assertIn("% is known", self.works(*walk, "--speed", 0.05).text)
        self.assertIn("--speed has no effect without --route",
                      self.fails(2, *walk[:4], "--height", 1, "--speed", 2, "-o", self.path("out")))

    def test_names_of_eyes_are_kept(self):
        self.path("named.csv").write_text("x,y,z,name\n1,1,1,desk\n1,-3,1,yard\n2,1,1,\n")
        said = self.works("visibility", self.case, "--signs", self.signs(self.east()), "--eyes", self.path("named.csv"), "-o", self.path("out"))
        self.assertEqual(self.report()["eyes"]["names"], ["desk", "yard", ""])
        self.assertIn("eye 2 (yard) at 1, -3, 1 m is where", said.message)

    def test_routes_of_signs_are_of_walkers(self):
        look = ("visibility", self.case, "-o", self.path("out"), "--eyes", self.points, "--signs")
        self.assertIn("routes of signs are not used without --route: 'east' is for everybody",
                      self.works(*look, self.signs(self.east(routes=["north"]), self.west())).message)
        self.assertNotIn("routes of signs", self.works(*look, self.signs(self.east())).message)

    def test_options_without_effect_are_refused(self):
        """What is of plans alone beside other eyes, and heights that a file says itself."""
        self.path("flat.csv").write_text("x,y\n1,1\n1,2\n")
        self.path("high.csv").write_text("x,y,z\n1,1,1\n1,2,1\n")
        self.path("walk.csv").write_text("id,time,x,y,z\n1,0,1,1,1\n1,10,1,2,1\n")
        self.path("floor.csv").write_text("id,time,x,y,floor\n1,0,1,1,0\n1,10,1,2,0\n")

        def said(*options):
            return self.fails(2, "visibility", self.case, "--signs", self.signs(self.east()), "-o", self.path("out"), *options)

        of_plans = (("--rset", 60), ("--everywhere",), ("--fire-at", "1,1,1"), ("--maps", "aset"), ("--underlay", self.path("plan.dxf")),
                    ("--extinction-limit", 0.2), ("--sight-limit", "small-room"))
        for kind, file in (("--route", "high.csv"), ("--eyes", "high.csv"), ("--trajectories", "walk.csv")):
            eyes = (kind, self.path(file))
            for option in of_plans if kind == "--route" else (*of_plans, ("--step", 0.5)):
                self.assertIn(f"{option[0]} has no effect beside {kind}; omit one", said(*eyes, *option))
        for kind in ("--route", "--eyes"):
            self.assertIn("--height has no effect: " + str(self.path("high.csv")) + " has z", said(kind, self.path("high.csv"), "--height", 1))
        self.assertIn("--eye-height has no effect: ", said("--trajectories", self.path("walk.csv"), "--eye-height", 1))
        self.assertIn("--eye-height has no effect beside --height",
                      said("--trajectories", self.path("floor.csv"), "--eye-height", 1, "--height", 1))
        self.assertIn("--fire-at has no effect beside --everywhere", said("--height", 1, "--everywhere", "--fire-at", "1,1,1"))
        self.works("visibility", self.case, "--signs", self.signs(self.east()), "-o", self.path("out"), "--trajectories",
                   self.path("floor.csv"), "--eye-height", 1)
        self.works("visibility", self.case, "--signs", self.signs(self.east()), "-o", self.path("out"), "--route", self.path("flat.csv"),
                   "--height", 1, "--step", 0.5)

    def test_two_authors_and_a_drawing_elsewhere_are_refused(self):
        plan = ("visibility", self.case, "--signs", self.signs(self.east()), "-o", self.path("out"), "--height", 1, "--step", 1)
        self.assertIn("2 of --author, --by are given", self.fails(2, *plan, "--author", "A", "--by", "B"))
        self.path("plan.dxf").write_text("0\nSECTION\n2\nENTITIES\n0\nLINE\n10\n0\n20\n0\n11\n7\n21\n3\n0\nENDSEC\n0\nEOF\n")
        self.assertIn("--underlay-bounds: 100,100,101,101 is apart from the case, which reaches from 0, 0 to 7, 3 m",
                      self.fails(2, *plan, "--underlay", self.path("plan.dxf"), "--underlay-bounds", "100,100,101,101"))

    def test_a_fire_beside_the_plan_is_refused(self):
        plan = ("visibility", self.case, "--signs", self.signs(self.east()), "-o", self.path("out"), "--height", 1, "--step", 1, "--maps", "aset")
        for place in ("500,500,1", "1,1,0.1"):
            self.assertIn("--fire-at: no point of the plan is within ", self.fails(2, *plan, "--fire-at", place))
        self.works(*plan, "--fire-at", "1,1,0.8")

    def test_members_and_limits_that_mean_nothing_are_refused(self):
        self.path("cm.json").write_text(json.dumps({"unit": "cm", "signs": [self.east()]}))
        look = ("visibility", self.case, "--eyes", self.points, "-o", self.path("out"), "--signs")
        self.assertIn("cm.json: /unit: this name is unknown; expected signs", self.fails(1, *look, self.path("cm.json")))
        self.path("ppm.json").write_text(json.dumps({"criteria": [{"kind": "carbon-monoxide", "limit": 1400}]}))
        self.assertIn("/criteria/0/limit: is 1400; a fraction in mol/mol is at most 1: 1400 % are 14, 1400 ppm are 0.0014",
                      self.fails(1, *look, self.signs(self.east()), "--criteria", self.path("ppm.json")))
        self.path("big.json").write_text('{"signs": [{"name": "a",\n"position": [1e999, 2, 2], "normal": [-1, 0, 0]}]}')
        self.assertIn("big.json: line 2: 1e999 is beyond the numbers of 64 bits", self.fails(1, *look, self.path("big.json")))

    def test_people_on_the_floor(self):
        self.path("walk.csv").write_text("id,time,x,y,z\n1,0,1,1,0\n1,10,1,2,0\n")
        walk = ("visibility", self.case, "--signs", self.signs(self.east()), "-o", self.path("out"), "--trajectories")
        self.assertIn("all people's eyes are less than 0.3 m above a floor", self.works(*walk, self.path("walk.csv")).message)
        self.path("walk.csv").write_text("id,time,x,y,floor\n1,0,1,1,0\n1,10,1,2,0\n")
        self.assertNotIn("eyes are less than", self.works(*walk, self.path("walk.csv")).message)
        database = sqlite3.connect(self.path("two.sqlite"))
        database.execute("CREATE TABLE metadata(key TEXT, value TEXT)")
        database.execute("CREATE TABLE trajectory_data(frame INTEGER, id INTEGER, pos_x REAL, pos_y REAL)")
        database.executemany("INSERT INTO metadata VALUES('fps', ?)", [("2",), ("8",)])
        database.execute("INSERT INTO trajectory_data VALUES(0, 1, 1, 1)")
        database.commit()
        database.close()
        self.assertIn("two.sqlite: a second frame rate, 8 after 2: which?", self.fails(1, *walk, self.path("two.sqlite")))

    def test_a_series_from_windows(self):
        sight_cases.write_vtu(self.path("Mesh_0.vtu"), (4, 4, 3), (2, 2, 2), lambda x, y, z: 0.1)
        sight_cases.write_pvd(self.path("a.pvd"), [(0, ".\\mesh_0.vtu")])
        self.works("info", self.path("a.pvd"))

    def test_a_result_is_replaced_whole(self):
        signs = self.signs(self.east())
        self.look(self.case, signs, "--height", 1, "--step", 0.5)
        self.assertTrue((self.path("out") / "aset.png").exists())
        before = self.files()
        self.look(self.case, signs, "--eyes", self.points)
        self.assertEqual(sorted(p.name for p in self.path("out").iterdir()), [".files", "sight.csv", "tenability.csv", "visibility.json"])
        self.assertEqual(self.files(), before)
        self.path("out/notes.txt").write_text("mine")
        self.look(self.case, signs, "--eyes", self.points)
        self.assertEqual(self.path("out/notes.txt").read_text(), "mine")

    def test_a_volume_says_what_it_takes_away(self):
        """What has no extinction hid nothing, and every sign was seen."""
        support.write_npy(self.path("smoke.npy"), (1, 4, 4, 4), [1.0] * 64)
        look = ["--signs", self.signs(self.east()), "--eyes", self.eyes([(0.5, 0.5, 0.5)]), "-o", self.path("out")]
        self.assertIn("smoke.npy: 'density' is without a unit, which does not say how much light it takes away: it would hide nothing; "
                      "give --extinction", self.fails(2, "visibility", self.path("smoke.npy"), *look))
        self.works("visibility", self.path("smoke.npy"), "--extinction", 2, *look)
        self.assertGreater(self.rows()[0]["optical_depth"], 0.9)
        support.write_npy(self.path("wrong.npy"), (1, 4, 4, 4), [-1.0] * 32 + [1.0] * 32)
        self.assertIn("values go from -1 to 1; expected an extinction", self.fails(1, "visibility", self.path("wrong.npy"), "--extinction", 2, *look))
        scene = {"format": "volute-scene-2", "media": [{"kind": "volume", "file": "smoke.npy"}]}
        self.path("scene.json").write_text(json.dumps(scene))
        self.assertIn("/media/0 takes no light away and hides nothing", self.works("visibility", self.path("scene.json"), *look).message)

    def test_a_volume_of_a_scene_is_what_its_unit_says(self):
        """What a look makes of it is for pictures."""
        self.path("a.nc").write_bytes(netcdf(units={"s": "1/cm"}, change=lambda values: [0.01] * len(values)))
        look = ["--signs", self.signs(self.east(position=[4, 1.25, 1])), "--eyes", self.eyes([(-1, 1.25, 1)]), "-o", self.path("out"), "--criteria", "none"]
        for entry in ({}, {"preset": "smoke"}, {"preset": "auto"}):
            self.path("scene.json").write_text(json.dumps({"format": "volute-scene-2", "media": [{"kind": "volume", "file": "a.nc", **entry}]}))
            message = self.works("visibility", self.path("scene.json"), *look).message
            self.assertAlmostEqual(self.rows()[0]["optical_depth"], 3, delta=1e-4)
            self.assertIn("'soot' is in 1/cm and is taken as the extinction", message)
            self.assertNotIn("hides nothing", message)
        self.path("a.nc").write_bytes(netcdf(units={"s": "kg/m3"}))
        self.path("scene.json").write_text(json.dumps({"format": "volute-scene-2", "media": [{"kind": "volume", "file": "a.nc"}]}))
        self.assertIn("/media/0 takes no light away and hides nothing", self.works("visibility", self.path("scene.json"), *look).message)

    def test_unknown_air_is_not_clear_air(self):
        result = self.works("visibility", self.case, "--signs", self.signs(self.east()), "--eyes",
                            self.eyes([(1, 1, 1), (1, -3, 1)]), "-o", self.path("out"))
        self.assertIn("eye 2 at 1, -3, 1 m is where the case has no smoke", result.message)
        rows = self.rows()
        self.assertTrue(math.isnan(rows[1]["optical_depth"]) and math.isinf(rows[1]["optical_depth_high"]))
        self.assertEqual([row["visible"] for row in rows], [1, 0, 1, 0])
        self.assertEqual(self.report()["summary"][0]["uncovered"], 1)


if __name__ == "__main__":
    support.main()
