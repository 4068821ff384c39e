# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""volute visibility: doses, limits and margins in cases written here; volute sweep: many of them."""
import csv
import hashlib
import json
import math
import os
import pathlib
import re
import resource
import struct
import subprocess

import support
from sight_cases import FdsCase, Mesh, write_pvd, write_vtu

TIMES = [10.0 * i for i in range(13)]
# pyFDS-Evac's worked example reaches FED 1 at 981.7 s in this air.
EXAMPLE = [("CARBON MONOXIDE VOLUME FRACTION", "mol/mol", lambda *_: 0.001),
           ("CARBON DIOXIDE VOLUME FRACTION", "mol/mol", lambda *_: 0.02),
           ("OXYGEN VOLUME FRACTION", "mol/mol", lambda *_: 0.15)]


class Cases(support.TestCase):
    def case(self, name="case", more=None, times=TIMES, smoke=lambda t, *_: 0.001 * t, folder=None):
        mesh = Mesh("hall", (0, 20, 0, 4, 0, 3), (20, 4, 3))
        hot = [("TEMPERATURE", "C", lambda t, x, *_: 20 + t * (20 - x) / 20)]
        folder = self.path(folder) if folder else self.folder
        folder.mkdir(exist_ok=True, parents=True)
        return FdsCase([mesh], list(times), smoke, more=hot + EXAMPLE if more is None else more).write(folder, name)

    def signs(self):
        self.path("signs.json").write_text(json.dumps({"signs": [
            {"name": "exit", "position": [20, 2, 2], "normal": [-1, 0, 0]},
            {"name": "back", "position": [0, 2, 2], "normal": [1, 0, 0], "emitting": True}]}))
        return self.path("signs.json")

    def criteria(self, *criteria):
        self.path("criteria.json").write_text(json.dumps({"criteria": list(criteria)}))
        return self.path("criteria.json")

    def report(self, folder):
        return json.loads((self.path(folder) / "visibility.json").read_text())


class Tenability(Cases):
    HOT = {"name": "hot", "kind": "temperature", "limit": 60}
    FED = {"name": "fed", "kind": "fed-gas", "model": "fds", "limit": 0.05}

    def test_a_case_in_a_scene_answers_as_it_does_alone(self):
        """Its temperature, the times between the stored ones, what comes and goes; and a wall of the scene besides."""
        mesh = Mesh("hall", (0, 20, 0, 4, 0, 3), (20, 4, 3), [(12, 13, 0, 4, 0, 3)])
        case = FdsCase([mesh], [0.0, 60.0, 120.0], lambda t, *_: 0.001 * t, events=[(0, 0, 0, False), (0, 0, 75, True)],
                       more=[("TEMPERATURE", "C", lambda t, x, *_: 20 + t * (20 - x) / 20)]).write(self.folder)
        scene = {"format": "volute-scene-1", "media": [{"kind": "smoke", "case": case.name}]}
        self.path("bare.json").write_text(json.dumps(scene))
        self.path("wall.obj").write_text("v 17 0 0\nv 17 4 0\nv 17 4 3\nv 17 0 3\nf 1 2 3 4\n")
        self.path("walled.json").write_text(json.dumps(scene | {"geometry": [{"file": "wall.obj"}]}))
        criteria = self.criteria(self.HOT)
        reports = []
        for name in (case.name, "bare.json", "walled.json"):
            self.works("visibility", self.path(name), "--signs", self.signs(), "--criteria", criteria, "--height", 1.5, "--step", 1,
                       "-o", self.path("out_" + name))
            reports.append(self.report("out_" + name))
        alone, bare, walled = reports
        self.assertAlmostEqual(alone["tenability"]["criteria"][0]["rows_interpolated"][1][3], 800 / 16.5, 4)
        self.assertEqual(alone["aset"][0]["rows_interpolated"][1][12], 75)
        for report in (bare, walled):
            self.assertEqual(report["tenability"]["criteria"], alone["tenability"]["criteria"])
        self.assertEqual((bare["aset"], bare["summary"]), (alone["aset"], alone["summary"]))
        first, wall = alone["summary"][0]["signs"], walled["summary"][0]["signs"]
        self.assertEqual((first["exit"], first["back"]), (1, 1))
        self.assertAlmostEqual(wall["exit"], 3 / 20)
        self.assertAlmostEqual(wall["back"], 17 / 20)

    def test_a_plan_has_times_and_doses_of_each_criterion(self):
        criteria = self.criteria(self.HOT, self.FED, {"name": "iso", "kind": "fed-gas", "limit": 1},
                                 {"name": "acid", "kind": "fec", "limit": 0.3})
        self.works("visibility", self.case(), "--signs", self.signs(), "--criteria", criteria, "--height", 1.5, "--step", 1,
                   "--rset", 45, "-o", self.path("out"))
        report = self.report("out")
        hot, fed, iso, acid = report["tenability"]["criteria"]
        rate = (2.764e-5 * 1000 ** 1.036 * math.exp(0.1903 * 2 + 2.0004) / 7.1 + math.exp(0.54 * 5.9 - 8.13)) / 60
        self.assertLess(abs(1 / rate - 981.7), 0.05)
        for x in range(20):
            # 20 + t (19.5 - x) / 20 = 60 in the middle of a cell.
            reached = 800 / (19.5 - x)
            found = hot["rows_interpolated"][1][x]
            if reached > 120:
                self.assertIsNone(found)
                continue
            self.assertAlmostEqual(found, reached, 3)
            self.assertEqual(hot["rows"][1][x], 10 * math.floor(reached / 10))
            self.assertEqual(hot["rows_up"][1][x], 10 * math.ceil(reached / 10))
        for row in fed["dose_at_the_end"]:
            for dose in row:
                self.assertLess(abs(dose - 120 * rate), 1e-6 * dose + 1e-7)
        self.assertAlmostEqual(fed["rows_interpolated"][0][0], 0.05 / rate, 3)
        self.assertAlmostEqual(iso["dose_at_the_end"][2][3], 120 / 60 * 1000 / 35000 * math.exp(0.4), 5)
        self.assertIn("hydrogen-cyanide", iso["counted_as_in_clean_air"])
        self.assertIn("HYDROGEN CHLORIDE", acid["not_assessed"])
        aset = report["tenability"]["aset"]
        self.assertEqual(aset["rows_of_the_first_criterion"][1][0], "hot")
        self.assertEqual(aset["rows_of_the_first_criterion"][1][15], "fed")
        self.assertEqual(aset["rows"][1][0], 40)
        margin = report["tenability"]["margin"]
        self.assertEqual(margin["least"]["value"], -5)
        self.assertEqual(margin["rows"][1][15], aset["rows"][1][15] - 45)
        self.assertGreater(margin["points_too_late"], 0)
        page = (self.path("out") / "report.html").read_text()
        self.assertLess(page.index("ASET of all criteria: 40 s"), page.index("computed by"))
        self.assertEqual([one["criterion"] for one in report["verdict"][:2]], ["all", "margin"])
        self.assertIn("not assessed", page)
        for name in ("aset_all.png", "tenability_first.png", "margin.png", "tenability_hot.png"):
            self.assertEqual((self.path("out") / name).read_bytes()[:8], b"\x89PNG\r\n\x1a\n")

    def test_points_routes_and_people_take_in_what_the_closed_form_says(self):
        case, signs, criteria = self.case(), self.signs(), self.criteria(self.HOT, self.FED)
        rate = 1 / 981.690
        self.path("eyes.csv").write_text("x,y,z\n0.5,2,1.5\n")
        self.works("visibility", case, "--signs", signs, "--criteria", criteria, "--eyes", self.path("eyes.csv"), "-o",
                   self.path("points"))
        hot, fed = self.report("points")["tenability"]["criteria"]
        self.assertAlmostEqual(hot["times_interpolated"][0], 800 / 19.5, 3)
        self.assertAlmostEqual(fed["dose_at_the_end"][0], 120 * rate, 5)
        with open(self.path("points") / "tenability.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), len(TIMES))
        self.assertAlmostEqual(float(rows[-1]["fed"]), 120 * rate, 5)
        # 1 m/s from 10 s on, 15 m.
        self.path("route.csv").write_text("x,y\n2,2\n17,2\n")
        self.works("visibility", case, "--signs", signs, "--criteria", criteria, "--route", self.path("route.csv"), "--height", 1.5,
                   "--speed", 1, "--start", 10, "-o", self.path("route"))
        (route,) = self.report("route")["routes"]
        dose = {one["name"]: one for one in route["exposure"]}
        self.assertLess(abs(dose["fed"]["dose"] - 15 * rate), 0.3 * rate)
        self.assertEqual(route["arrival"], 25)
        self.assertIn("arrives at 25 s", self.report("route")["verdict"][0]["sentence"])
        self.path("walk.csv").write_text("id,time,x,y\n4,0,1,1\n4,60,19,1\n7,30,5,1\n7,50,5,1\n")
        self.works("visibility", case, "--signs", signs, "--criteria", criteria, "--trajectories", self.path("walk.csv"),
                   "--height", 1.5, "-o", self.path("walk"))
        report = self.report("walk")["tenability"]
        self.assertEqual(report["ids"], [4, 7])
        for found, seconds in zip(report["criteria"][1]["dose_at_the_end"], (60, 20)):
            self.assertLess(abs(found - seconds * rate), 0.6 * rate)

    def test_points_and_people_have_a_verdict(self):
        """The first of them, by what and where; what nobody reaches, with the worst; what is not known comes first."""
        case, signs, criteria = self.case(), self.signs(), self.criteria(self.HOT, self.FED | {"limit": 0.3})
        self.path("walk.csv").write_text("id,time,x,y\n4,0,1,1\n4,60,19,1\n7,30,5,1\n7,60,5,1\n")

        def look(*options):
            result = self.works("visibility", case, "--signs", signs, "--criteria", criteria, *options, "-o", self.path("out"))
            report = self.report("out")
            self.assertIn(report["verdict"][0]["sentence"], result.text)
            return report["verdict"]

        first, sight, hot, fed = look("--trajectories", self.path("walk.csv"), "--height", 1.5)
        self.assertRegex(first["sentence"], r"^ASET of all criteria, 2 people: 50 s \(between 50 and 60 s, interpolated 55.2 s\), by hot, "
                                            r"of person 7, at x = 5, y = 1, z = 1.5 m; 50 % of them reach one by 120 s\.$")
        self.assertEqual((sight["criterion"], sight["time"], sight["known"]), ("sight of signs", None, True))
        self.assertIn("lost by none of those with one in sight without smoke (2 of 2 people) until 120 s", sight["sentence"])
        self.assertEqual((first["time"], first["first"], first["position"], first["known"]), (50, "person 7", [5, 1, 1.5], True))
        self.assertIn("by 120 s by 50 % of the people", hot["sentence"])
        self.assertRegex(fed["sentence"], r"^fed-gas \(fds\) >= 0.3 is reached by none of 2 people until 120 s; the worst is 0.06.*, of person 4\. Not stored, counted as in clean air: hydrogen-cyanide")
        page = (self.path("out") / "report.html").read_text()
        self.assertIn("of person 7", page)
        self.assertIn("<h2>Criteria of tenability</h2>", page)
        self.assertIn("slice3d-temperature-cells", page)
        self.path("eyes.csv").write_text("x,y,z\n15,2,1.5\n0.5,2,1.5\n")
        first = look("--eyes", self.path("eyes.csv"))[0]
        self.assertIn("2 points: 40 s (between 40 and 50 s, interpolated 41 s), by hot, of point 2, at x = 0.5", first["sentence"])
        self.cut(case, 2, 4)
        first, *_ = look("--eyes", self.path("eyes.csv"))
        self.assertEqual((first["time"], first["known"]), (None, 30))
        self.assertIn("2 points: not reached by 30 s, and not known after that at 100 % of the points, because of hot", first["sentence"])
        (self.folder / "case_1_2.sf").unlink()
        self.assertIn("not known at 100 % of the points, because of hot.", look("--eyes", self.path("eyes.csv"))[0]["sentence"])

    def test_devices_stand_in_for_slices(self):
        case = self.case(more=[])
        names = ["T", "CO", "CO2", "O2, left"]
        quantities = ["TEMPERATURE"] + [quantity for quantity, *_ in EXAMPLE]
        with case.open("a") as file:
            for name, quantity in zip(names, quantities):
                file.write(f"DEVICE\n {name} % {quantity}\n 5.0 2.0 1.5 0 0 -1 0 0 % null\n")
        values = [[t, 20 + t, 0.001, 0.02, 0.15] for t in TIMES]
        self.path("case_devc.csv").write_text("s,C,mol/mol,mol/mol,mol/mol\nTime," + ",".join(f'"{name}"' for name in names) + "\n"
                                              + "".join(",".join(f"{x:.7E}" for x in row) + "\n" for row in values))
        self.path("eyes.csv").write_text("x,y,z\n5,2,1.4\n9,2,1.5\n")
        self.works("visibility", case, "--signs", self.signs(), "--criteria", self.criteria(self.HOT, self.FED), "--eyes",
                   self.path("eyes.csv"), "-o", self.path("out"))
        hot, fed = self.report("out")["tenability"]["criteria"]
        self.assertIn("1 devices, within 0.3 m of each", hot["from"][0])
        self.assertAlmostEqual(hot["times_interpolated"][0], 40, 5)
        self.assertIsNone(hot["times_interpolated"][1])
        self.assertAlmostEqual(fed["dose_at_the_end"][0], 120 / 981.690, 5)
        self.assertIsNone(fed["dose_at_the_end"][1])
        # On a plan what is not near a device is not known.
        self.works("visibility", case, "--signs", self.signs(), "--criteria", self.path("criteria.json"), "--height", 1.5, "--step", 1,
                   "-o", self.path("out"))
        report = self.report("out")
        self.assertEqual(report["tenability"]["criteria"][0]["points_without_data"], report["eyes"]["walkable"])
        self.assertIn("is not known at 100 % of the floor", json.dumps(report["verdict"]))
        self.assertIn("hot (not stored at this height)", report["verdict"][0]["sentence"])
        self.assertEqual(report["verdict"][0]["not_assessed"], ["hot", "fed"])

    def cut(self, case, number, frames):
        """Leaves the first frames of one of a case's slices: three labels, a box of indices, then records of time and values."""
        path = case.with_name(f"{case.stem}_1_{number}.sf")
        data, header = path.read_bytes(), 3 * 38 + 32
        path.write_bytes(data[:header + frames * (len(data) - header) // len(TIMES)])

    def test_the_net_flux_of_a_wall_is_not_what_people_receive(self):
        hall = Mesh("hall", (0, 8, 0, 4, 0, 3), (8, 4, 3))
        case = FdsCase([hall], [0.0, 10.0, 20.0], lambda t, *_: 0.02 * t).write(self.folder, "hall")
        with open(case, "a") as file:
            file.write("INPF\n hall.fds\n\nDEVICE\n R % RADIATIVE HEAT FLUX\n 4.5 2.5 1.5 0 0 -1 0 0 % null\n")
        self.path("hall_devc.csv").write_text('s,kW/m2\n"Time","R"\n0,0\n10,5\n20,5\n')
        self.path("criteria.json").write_text('{"criteria": [{"name": "radiation", "kind": "radiant-flux", "limit": 2.5}]}')
        self.path("signs.json").write_text(json.dumps({"signs": [{"name": "s", "position": [7.9, 2, 2], "normal": [-1, 0, 0]}]}))
        self.path("eyes.csv").write_text("x,y,z\n4.5,2.5,1.5\n")
        for quantity, reached in (("RADIATIVE HEAT FLUX', IOR=1", False), ("RADIATIVE HEAT FLUX GAS'", True)):
            self.path("hall.fds").write_text(f"&HEAD CHID='hall' /\n&DEVC ID='R', QUANTITY='{quantity}, XYZ=4.5,2.5,1.5 /\n")
            done = self.works("visibility", case, "--signs", self.path("signs.json"), "--eyes", self.path("eyes.csv"), "--criteria",
                              self.path("criteria.json"), "-o", self.path("out"))
            self.assertEqual("first reached at" in done.text, reached, done.text)
            self.assertEqual("the net flux of a wall" in done.message + done.text, not reached, done.message)

    def test_what_ends_earlier_than_the_smoke_is_not_known_after(self):
        case, signs, criteria = self.case(), self.signs(), self.criteria(self.HOT, self.FED)
        self.cut(case, 2, 4)  # the temperature: 0 to 30 s
        result = self.works("visibility", case, "--signs", signs, "--criteria", criteria, "--height", 1.5, "--step", 1, "--rset", 45,
                            "-o", self.path("out"))
        self.assertIn("ASET of all criteria: not reached by 30 s, and not known after that", result.text)
        report = self.report("out")
        first = report["verdict"][0]
        self.assertEqual((first["time"], first["known"]), (None, 30))
        hot, fed = report["tenability"]["criteria"]
        for x in range(20):
            self.assertEqual((hot["rows"][1][x], hot["rows_up"][1][x], hot["rows_known"][1][x]), (None, None, 30))
        self.assertIsNone(hot["worst_value"][1][3])
        self.assertIs(fed["rows_known"][1][3], True)
        self.assertIn("temperature is stored from 0 to 30 s by slice3d-temperature-cells", json.dumps(report["verdict"]))
        self.assertIn("where it burns is not known", json.dumps(report["verdict"]))
        margin = report["tenability"]["margin"]
        self.assertFalse(margin["known"])
        self.assertNotIn("least", margin)
        self.assertEqual(margin["points_not_known"], margin["points_needed"])
        source = next(one for one in report["sources"] if one["quantity"] == "temperature")
        self.assertEqual((source["stored_until"], source["served_until"]), (30, 30))
        with open(self.path("out") / "maps.csv", newline="") as file:
            row = next(csv.DictReader(file))
        self.assertEqual((row["aset_hot"], row["known_until_hot"], row["known_until_fed"]), ("", "30", "inf"))
        self.path("eyes.csv").write_text("x,y,z\n0.5,2,1.5\n")
        self.works("visibility", case, "--signs", signs, "--criteria", criteria, "--eyes", self.path("eyes.csv"), "-o",
                   self.path("points"))
        with open(self.path("points") / "tenability.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertAlmostEqual(float(rows[3]["hot"]), 20 + 30 * 19.5 / 20, 3)
        self.assertEqual(rows[4]["hot"], "")
        # A gas that is stored, but not any more, does not count as in clean air.
        self.cut(case, 4, 4)
        self.works("visibility", case, "--signs", signs, "--criteria", criteria, "--eyes", self.path("eyes.csv"), "-o",
                   self.path("points"))
        hot, fed = self.report("points")["tenability"]["criteria"]
        self.assertEqual(fed["times_known"], [30])
        self.assertEqual((fed["times"], fed["dose_at_the_end"]), ([None], [None]))

    def test_places_of_a_case_in_national_coordinates_can_be_told_apart(self):
        x, y = 500000, 5700000
        mesh = Mesh("hall", (x, x + 20, y, y + 4, 0, 3), (20, 4, 3))
        case = FdsCase([mesh], TIMES, lambda t, *_: 0.001 * t, more=[("TEMPERATURE", "C", lambda t, *_: 20 + t)]).write(self.folder, "utm")
        self.path("signs.json").write_text(json.dumps({"signs": [{"name": "exit", "position": [x + 20, y + 2, 2], "normal": [-1, 0, 0]}]}))
        self.path("eyes.csv").write_text(f"x,y,z,name\n{x + 0.25},{y + 2.75},1.5,\"door, left\"\n{x + 0.75},{y + 2.5},9,\n")
        result = self.works("visibility", case, "--signs", self.path("signs.json"), "--criteria", self.criteria(self.HOT), "--eyes",
                            self.path("eyes.csv"), "-o", self.path("out"))
        self.assertIn("eye 2 at 500000.75, 5700002.5, 9 m is where the case has no smoke", result.message)
        with open(self.path("out") / "tenability.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(list(rows[0]), ["time", "x", "y", "z", "hot", "name"])
        self.assertEqual([(row["x"], row["y"], row["z"], row["name"]) for row in rows[:2]],
                         [("500000.25", "5700002.75", "1.5", "door, left"), ("500000.75", "5700002.5", "9", "")])
        message = self.fails(2, "visibility", case, "--signs", self.path("signs.json"), "--height", 1.5, "--fire-at", f"{x + 60.25},{y},1",
                             "-o", self.path("x"))
        self.assertIn("1 m of 500060.25, 5700000 m; the plan reaches from 500000, 5700000 to 500020, 5700004 m", message)

    def test_with_the_fires_own_place_nothing_is_later(self):
        """Smoke is there later than elsewhere, or before."""
        criteria = self.criteria({"kind": "extinction", "limit": 0.3, "source": "here"})
        for name, growth, told in (("later", (0.01, 0.005), False), ("before", (0.01, 0.02), True)):
            case = self.case(name, smoke=lambda t, x, *_, growth=growth: t * growth[x > 14])
            self.works("visibility", case, "--signs", self.signs(), "--criteria", criteria, "--height", 1.5, "--step", 1, "--fire-at",
                       "17,2,3.5", "-o", self.path("out"))
            sentence = self.report("out")["verdict"][0]["sentence"]
            self.assertIn("This leaves out", sentence)
            self.assertEqual("With them it is" in sentence, told, sentence)

    def test_a_dose_has_the_ends_of_a_way(self):
        case, signs, criteria = self.case(), self.signs(), self.criteria(self.FED)
        self.path("walk.csv").write_text("id,time,x,y\n4,0,1,1\n4,60,19,1\n7,30.1,5,1\n7,33.3,6,1\n9,40.1,5,1\n9,40.2,6,1\n")
        self.works("visibility", case, "--signs", signs, "--criteria", criteria, "--trajectories", self.path("walk.csv"), "--height", 1.5,
                   "-o", self.path("walk"))
        (fed,) = self.report("walk")["tenability"]["criteria"]
        for dose, seconds in zip(fed["dose_at_the_end"], (60, 3.2, 0.1), strict=True):
            self.assertAlmostEqual(dose * 981.690, seconds, 3)

    def test_people_have_no_dose_where_the_smoke_has_ended(self):
        case, signs, criteria = self.case(), self.signs(), self.criteria(self.HOT, self.FED)
        self.path("walk.csv").write_text("id,time,x,y\n4,0,1,1\n4,60,19,1\n7,30,5,1\n7,410,5,1\n")
        result = self.works("visibility", case, "--signs", signs, "--criteria", criteria, "--trajectories", self.path("walk.csv"),
                            "--height", 1.5, "-o", self.path("walk"))
        self.assertIn("1 of 2 people are on their way before 0 s or after 120 s", result.message)
        fed = self.report("walk")["tenability"]["criteria"][1]
        self.assertEqual(fed["times_known"], [True, True])  # reached before
        self.assertIsNotNone(fed["dose_at_the_end"][0])
        self.assertIsNone(fed["dose_at_the_end"][1])
        self.path("route.csv").write_text("x,y\n2,2\n17,2\n")
        self.works("visibility", case, "--signs", signs, "--criteria", criteria, "--route", self.path("route.csv"), "--height", 1.5,
                   "--speed", 1, "--start", 110, "-o", self.path("route"))
        report = self.report("route")
        hot, fed = report["routes"][0]["exposure"]
        self.assertEqual((fed["dose"], fed["time"], fed["known"]), (None, None, 120))
        self.assertIn("not known on the whole way: fed (not after 120 s)", report["verdict"][0]["sentence"])

    def test_nothing_is_reached_before_the_walk_starts(self):
        case = self.case(smoke=lambda *_: 1.0)
        self.path("route.csv").write_text("x,y\n2,2\n17,2\n")
        for start in (30, 33):
            self.works("visibility", case, "--signs", self.signs(), "--route", self.path("route.csv"), "--height", 1.5, "--start", start,
                       "-o", self.path("out"))
            (route,) = self.report("out")["routes"]
            times = {one["name"]: one["time"] for one in route["exposure"]}
            self.assertGreaterEqual(times["visibility"], start)
            self.assertLess(times["visibility"], start + 0.3)

    def test_the_verdict_is_of_places_where_people_are(self):
        """On the hot side nothing is below the eyes but the floor of a lower storey."""
        mesh = Mesh("hall", (0, 20, 0, 4, 0, 8), (20, 4, 8), [(10, 20, 0, 4, 0, 4)])
        case = FdsCase([mesh], TIMES, lambda *_: 0.0, more=[("TEMPERATURE", "C", lambda t, x, *_: 20 + t * (20 - x) / 20)]).write(self.folder)
        self.path("high.json").write_text(json.dumps({"signs": [{"name": "exit", "position": [20, 2, 5.5], "normal": [-1, 0, 0]}]}))
        options = ("--signs", self.path("high.json"), "--criteria", self.criteria(self.HOT), "--height", 5.5, "--step", 1, "-o", self.path("out"))

        def first(*more):
            self.works("visibility", case, *options, *more)
            report = self.report("out")
            return report, report["verdict"][0]

        report, verdict = first("--everywhere")
        self.assertEqual(verdict["position"][0], 0.5)
        report, verdict = first()
        self.assertEqual(verdict["position"][0], 10.5)
        self.assertEqual(report["plan_use"][1], "v" * 10 + "p" * 10)
        self.assertIn("50 % of the points, which have no floor within 2.5 m", json.dumps(report["verdict"]))
        report, verdict = first("--fire-at", "10.5,1.5,1.2")
        self.assertEqual(report["plan_use"][1], "v" * 9 + "fff" + "p" * 8)
        self.assertIn("The fire's own place (as stated) is not counted", json.dumps(report["verdict"]))
        self.assertEqual(verdict["share"], sum(1 for row in report["plan_use"] for x, c in enumerate(row) if c == "p" and 800 / (19.5 - x) <= 120)
                         / sum(row.count("p") for row in report["plan_use"]))
        self.assertIn("--fire-at: '3,4'", self.fails(2, "visibility", case, *options, "--fire-at", "3,4"))

    def test_a_fire_that_no_file_states_is_where_smoke_rises_from_the_floor(self):
        """A column that widens from the floor up, and a layer that is down at 1.8 m after 30 s."""
        def smoke(t):
            return lambda x, y, z: (5 * math.exp(-((x - 6) ** 2 + (y - 4) ** 2) / (0.4 + 0.2 * z) ** 2) if t > 0 else 0) + (
                1 / (1 + math.exp(min(50, (3 - t / 25 - z) / 0.1))))
        for t in range(0, 50, 10):
            write_vtu(self.path(f"hall_{t}.vtu"), (12, 8, 3), (24, 16, 6), smoke(t))
        write_pvd(self.path("hall.pvd"), [(t, f"hall_{t}.vtu") for t in range(0, 50, 10)])
        self.path("exits.json").write_text(json.dumps({"signs": [{"name": "exit", "position": [12, 4, 2], "normal": [-1, 0, 0]}]}))
        options = ("--field", "smoke", "--quantity", "extinction", "--signs", self.path("exits.json"), "--height", 1.8, "--step", 0.5,
                   "--criteria", self.criteria({"kind": "extinction", "limit": 0.3, "source": "here"}), "-o", self.path("out"))
        result = self.works("visibility", self.path("hall.pvd"), *options)
        self.assertIn("the case does not state where it burns: smoke rises from the floor around x = 5.9, y = 3.9 m", result.message)
        self.assertIn("--everywhere counts them, or --fire-at states where it burns", result.message)
        report = self.report("out")
        first, own = report["verdict"][0], next(v for v in report["verdict"] if v["criterion"] == "the fire's own place")
        for i, row in enumerate(report["plan_use"]):
            for k, use in enumerate(row):
                away = math.hypot(0.25 + 0.5 * k - 6, 0.25 + 0.5 * i - 4)
                self.assertEqual(use, "f" if away < 1.7 else "p" if away > 2.6 else use, (away, use))
        visibility = next(v for v in report["verdict"] if v["criterion"] == "extinction")
        self.assertEqual((visibility["time"], visibility["time_up"]), (20, 30))
        self.assertEqual((own["time"], own["time_up"]), (0, 10))
        self.assertRegex(first["sentence"], "This leaves out 17 % of the points, taken for the fire's own place, .* With them it is 0 s\\.")
        self.works("visibility", self.path("hall.pvd"), *options, "--everywhere")
        self.assertEqual(self.report("out")["verdict"][0]["time"], 0)
        result = self.works("visibility", self.path("hall.pvd"), *options, "--fire-at", "6,4,0.5")
        self.assertNotIn("does not state where it burns", result.message)
        self.assertEqual(self.report("out")["verdict"][0]["time"], 0)

    def test_heights_of_the_eyes_are_compared_in_a_table(self):
        case = self.case(smoke=lambda t, x, y, z: (0.011 if z > 2 else 0.006) * t, more=[])
        self.works("visibility", case, "--signs", self.signs(), "--criteria", self.criteria({"kind": "extinction", "limit": 0.3, "source": "here"}),
                   "--height", "1.5,2.5", "--step", 1, "--maps", "aset", "--everywhere", "-o", self.path("out"))
        page = (self.path("out") / "report.html").read_text()
        table = re.sub(r"<[^>]*>", " ", page[page.index("By the height of the eyes"):][:1500])
        storeys = json.loads((self.path("out") / "visibility.json").read_text())["heights"]
        for storey in storeys:
            first = storey["verdict"][0]
            self.assertRegex(table, rf"\s{storey['height']:g}\s+{first['time']:g}\s+{first['time_interpolated']:.4g}\s+{first['by']}\s".replace(" ", r"\s"))
        self.assertLess(storeys[1]["verdict"][0]["time"], storeys[0]["verdict"][0]["time"])
        self.assertIn("The height of the eyes is not varied here", page)

    def test_heights_that_differ_little_have_folders_of_their_own(self):
        self.works("visibility", self.case(more=[]), "--signs", self.signs(), "--criteria", "none", "--height", "1.500001,1.500002,2.5",
                   "--step", 2, "--maps", "aset", "-o", self.path("out"))
        storeys = json.loads((self.path("out") / "visibility.json").read_text())["heights"]
        self.assertEqual([one["folder"] for one in storeys], ["z_1.500001", "z_1.500002", "z_2.5"])
        self.assertEqual([self.report(f"out/{one['folder']}")["eyes"]["height"] for one in storeys], [1.500001, 1.500002, 2.5])

    def test_meshes_have_air_too(self):
        def room(name, *fields):
            for i, t in enumerate((0, 10, 20)):
                write_vtu(self.path(f"{name}_{i}.vtu"), (4, 4, 3), (4, 4, 3), lambda *_: 0.01,
                          more=[(field, lambda *p, value=value, t=t: value(t)) for field, value in fields])
            write_pvd(self.path(name + ".pvd"), [(10 * i, f"{name}_{i}.vtu") for i in range(3)])
            return self.path(name + ".pvd")

        hot = {"name": "hot", "kind": "temperature", "limit": 60}
        fed = {"name": "fed", "kind": "fed-gas", "model": "fds", "limit": 0.001}
        self.path("eyes.csv").write_text("x,y,z\n1.5,2,1.5\n")

        def answers(case, *more):
            self.path("one.json").write_text(json.dumps({"signs": [{"name": "exit", "position": [4, 2, 2], "normal": [-1, 0, 0]}]}))
            self.works("visibility", case, "--field", "smoke", "--quantity", "extinction", "--signs", self.path("one.json"),
                       "--criteria", self.criteria(hot, fed), "--eyes", self.path("eyes.csv"), "-o", self.path("out"), *more)
            return self.report("out")["tenability"]["criteria"]

        usual = room("usual", ("T", lambda t: 293.15 + 5 * t), ("CO", lambda t: 0.001), ("CO2", lambda t: 0.02), ("O2", lambda t: 0.15))
        found, dose = answers(usual)
        self.assertEqual(found["from"], ["temperature (field 'T' in K)"])
        self.assertAlmostEqual(found["times_interpolated"][0], 8, 4)
        self.assertAlmostEqual(dose["dose_at_the_end"][0], 20 / 981.690, 5)
        named = room("named", ("gas", lambda t: 20 + 5 * t), ("ppmco", lambda t: 1000), ("dioxide", lambda t: 2), ("left", lambda t: 15))
        found, dose = answers(named, "--air-fields", "temperature=gas:C,carbon-monoxide=ppmco:ppm,carbon-dioxide=dioxide:%,oxygen=left:%")
        self.assertAlmostEqual(found["times_interpolated"][0], 8, 4)
        self.assertAlmostEqual(dose["dose_at_the_end"][0], 20 / 981.690, 5)
        self.assertIn("no field with a usual name of temperature", answers(named)[0]["not_assessed"])
        # Units that cannot be.
        for case, said, told in ((usual, "temperature=T:C", "field 'T' is 293.1 and more, read in C; expected what air has: is it temperature=T:K?"),
                                 (named, "temperature=gas:K", "field 'gas' is 20 and less, read in K; expected what air has: is it temperature=gas:C?"),
                                 (usual, "oxygen=O2:%", "field 'O2' is 0.15 and less, read in %; expected what air has: is it oxygen=O2:mol/mol?"),
                                 (usual, "carbon-monoxide=CO:ppm", "field 'CO' is at most 0.001, read in ppm: is it carbon-monoxide=CO:mol/mol?")):
            answers(case, "--air-fields", said)
            self.assertIn(told, (self.path("out") / "visibility.json").read_text())
        for bad, word in (("temprature=gas", "did you mean 'temperature'"), ("temperature=gas:F", "expected K or C"),
                          ("temperature", "QUANTITY=FIELD:UNIT")):
            self.assertIn(word, self.fails(2, "visibility", named, "--field", "smoke", "--quantity", "extinction", "--signs",
                                           self.path("one.json"), "--air-fields", bad, "-o", self.path("x")))

    def test_a_gas_of_a_mesh_that_is_stored_later_is_not_known_before(self):
        for i, gas in enumerate(([], [("CO", lambda *_: 0.02)], [("CO", lambda *_: 0.02)])):
            write_vtu(self.path(f"late_{i}.vtu"), (4, 4, 3), (4, 4, 3), lambda *_: 0.01, more=gas)
        write_pvd(self.path("late.pvd"), [(60 * i, f"late_{i}.vtu") for i in range(3)])
        self.path("eyes.csv").write_text("x,y,z\n1.5,2,1.5\n")
        self.path("one.json").write_text(json.dumps({"signs": [{"name": "exit", "position": [4, 2, 2], "normal": [-1, 0, 0]}]}))
        command = ("visibility", self.path("late.pvd"), "--field", "smoke", "--quantity", "extinction", "--signs", self.path("one.json"),
                   "--eyes", self.path("eyes.csv"), "-o", self.path("out"))
        self.works(*command)
        dose = next(one for one in self.report("out")["tenability"]["criteria"] if one["name"] == "fed-gas-sfpe")
        self.assertNotIn("not_assessed", dose)
        self.assertEqual(dose["times"], [None])
        self.assertIn("not known", self.report("out")["verdict"][0]["sentence"])

    def test_a_gas_of_more_than_all_air_is_refused(self):
        write_vtu(self.path("much.vtu"), (4, 4, 3), (4, 4, 3), lambda *_: 0.01, more=[("O2", lambda *_: 20.9), ("CO", lambda *_: -0.01)])
        self.path("eyes.csv").write_text("x,y,z\n1.5,2,1.5\n")
        self.path("one.json").write_text(json.dumps({"signs": [{"name": "exit", "position": [4, 2, 2], "normal": [-1, 0, 0]}]}))
        command = ("visibility", self.path("much.vtu"), "--field", "smoke", "--quantity", "extinction", "--signs", self.path("one.json"),
                   "--eyes", self.path("eyes.csv"), "-o", self.path("out"))
        self.assertIn("field 'CO' is -0.01 at 0 s, read in mol/mol; expected none or more of a gas", self.fails(1, *command))
        write_vtu(self.path("much.vtu"), (4, 4, 3), (4, 4, 3), lambda *_: 0.01, more=[("O2", lambda *_: 20.9), ("CO", lambda *_: -1e-6)])
        self.assertIn("field 'O2' is 20.9 at 0 s, read in mol/mol; expected no more than all of the air: state its unit, as oxygen=O2:%",
                      self.fails(1, *command))
        self.works(*command, "--air-fields", "oxygen=O2:%")
        write_vtu(self.path("much.vtu"), (4, 4, 3), (4, 4, 3), lambda *_: 0.01, more=[("CO", lambda *_: 1)])
        self.works(*command, "--air-fields", "carbon-monoxide=CO:kg/kg")

    def test_people_and_routes_outside_are_said(self):
        case, signs = self.case(), self.signs()
        self.path("walk.csv").write_text("id,time,x,y\n4,0,1,1\n4,60,19,1\n7,30,5,50\n7,50,5,50\n")
        self.works("visibility", case, "--signs", signs, "--trajectories", self.path("walk.csv"), "--height", 1.5, "-o",
                   self.path("out"))
        self.assertTrue(any("1 of 2 people" in remark for remark in self.report("out")["remarks"]))
        mesh = Mesh("hall", (0, 20, 0, 4, 0, 3), (20, 4, 3), [(10, 11, 0, 4, 0, 3)])
        path = FdsCase([mesh], [0.0, 10.0], lambda *_: 0.1).write(self.folder, "walled")
        self.path("route.csv").write_text("x,y\n2,2\n17,2\n")
        self.works("visibility", path, "--signs", signs, "--route", self.path("route.csv"), "--height", 1.5, "--step", 0.5, "-o",
                   self.path("out"))
        self.assertTrue(any("'route' leads through something solid" in remark for remark in self.report("out")["remarks"]))

    def test_means_of_visibility_are_bounded(self):
        """A layer of smoke comes down through a slice at the nodes of z = 2 m, as FDS writes it: means of C / K over the cells around."""
        mesh = Mesh("hall", (0, 8, 0, 4, 0, 3), (16, 8, 6))
        case = FdsCase([mesh], [4.0 * i for i in range(16)],
                       lambda t, x, y, z: 0.01 + 1.5 / (1 + math.exp((3.2 - 0.03 * t + 0.1 * math.sin(x + y) - z) / 0.15)))
        index = case.write(self.folder)

        class Means(FdsCase):
            def value(self, mesh, time, cell, formula=None):
                around = [tuple(min(max(cell[a] + 1 - (n >> a & 1), 0), mesh.cells[a] - 1) for a in range(3)) for n in range(8)]
                return sum(formula(case.value(mesh, time, one)) for one in around) / 8

        def of_layer(name, quantity, unit, formula):
            """The values of index (i, j, 4) of the file that value() makes for cell (i - 1, j - 1, 3)."""
            Means([mesh], case.times, None).write_slice(self.path("all.sf"), mesh, (quantity, "short", unit), formula)
            data, size = self.path("all.sf").read_bytes(), 17 * 9 * 7 * 4
            head = data[:114] + struct.pack("<8i", 24, 1, 15, 1, 7, 4, 4, 24)
            frames = data[146:]
            for n in range(len(case.times)):
                frame = frames[n * (20 + size):]
                values = [frame[16 + 4 * ((4 * 9 + j) * 17 + i):][:4] for j in range(1, 8) for i in range(1, 16)]
                head += frame[:12] + struct.pack("<i", 4 * len(values)) + b"".join(values) + struct.pack("<i", 4 * len(values))
            self.path(f"{name}.sf").write_bytes(head)
            text = index.read_text()
            self.path(f"{name}.smv").write_text(
                text[:text.index("SLCC")] + f"SLCF     1 # STRUCTURED & 1 15 1 7 4 4 ! 1 1\n {name}.sf\n {quantity}\n short\n {unit}\n")
            self.path("in.json").write_text(json.dumps({"signs": [{"name": "in", "position": [7.2, 2, 2], "normal": [-1, 0, 0]}]}))
            self.works("visibility", self.path(f"{name}.smv"), "--signs", self.path("in.json"), "--height", "2", "--step", "0.5",
                       "--maps", "aset", "--everywhere", "-o", self.path(name))
            report = self.report(name)
            return report, next(c for c in report["tenability"]["criteria"] if c["name"] == "visibility")

        _, truth = of_layer("k", "SOOT EXTINCTION COEFFICIENT", "1/m", lambda k: k)
        report, means = of_layer("v", "SOOT VISIBILITY", "m", lambda k: min(3 / k, 30))
        rows = [[v for row in one[key] for v in row if v is not None]
                for one, key in ((truth, "rows"), (means, "rows"), (means, "rows_latest"))]
        self.assertGreater(len(rows[0]), 50)
        self.assertEqual({len(row) for row in rows}, {len(rows[0])})
        self.assertTrue(all(early <= k <= late for k, early, late in zip(*rows)))
        self.assertTrue(any(late > k for k, _, late in zip(*rows)), "the means alone are too late")
        verdict = next(v for v in report["verdict"] if v["criterion"] == "visibility")
        self.assertIn("by the least it is first reached at", verdict["sentence"])
        self.assertGreater(verdict["time_latest"], verdict["time"])
        self.assertEqual(verdict["known"], True)

    def test_bytes_of_temperature_serve_where_nothing_else_does(self):
        """8-bit temperature (.s3d) by the most that a byte may stand for; slices of the same times come first."""
        def s3d(path, warm=range(20)):
            """As FDS: each node has the mean of its eight cells, of which those of walls keep 20 degrees."""
            sides = [1, 2, 2, 2, 1], [1, 2, 2, 1]
            count = [sum(x in warm for x in (node - 1, node) if 0 <= x < 20) * y * z for z in sides[1] for y in sides[0] for node in range(21)]
            data = struct.pack("<i8ii", 32, 1, 0, 0, 20, 0, 4, 0, 3, 32)
            for time in TIMES:
                run = bytes(int(254 * time * of / 8 / 1980) for of in count)
                for record in (struct.pack("<f", time), struct.pack("<2i", len(count), len(run)), run):
                    data += struct.pack("<i", len(record)) + record + struct.pack("<i", len(record))
            path.write_bytes(data)

        def hot(case):
            self.works("visibility", case, "--signs", self.signs(), "--criteria", self.criteria(self.HOT), "--height", 1.5, "--step", 2,
                       "--everywhere", "-o", self.path("out"))
            (one,) = self.report("out")["tenability"]["criteria"]
            return one, self.report("out")["verdict"][0]

        s3d(self.path("t.s3d"))
        for name, more in (("bytes", []), ("both", None)):
            index = self.case(name, more=more)
            index.write_text(index.read_text() + "SMOKG3D     1\n t.s3d\n TEMPERATURE\n temp\n C\n")
        one, verdict = hot(self.path("bytes.smv"))
        # 20 + t: byte 5 at 40 s, which is 59 to 66.8 degrees; byte 3 at 30 s, 43.4 to 51.2.
        self.assertEqual({v for row in one["rows"] for v in row}, {30})
        self.assertEqual(one["from"], ["temperature (s3d-temperature)"])
        self.assertEqual((verdict["time"], verdict["known"]), (30, True))
        self.assertGreaterEqual(min(v for row in one["rows_latest"] for v in row), 40, "by the least that they may stand for")
        # Of a warm half, what touches it is as warm.
        s3d(self.path("t.s3d"), range(11, 20))
        one, _ = hot(self.path("bytes.smv"))
        self.assertEqual(one["rows"][0][4:7], [None, 30, 30], "at 11 m one cell is cold and one is warm")
        one, _ = hot(self.path("both.smv"))
        self.assertIn("slice3d-temperature-cells), else temperature (s3d-temperature", one["from"][0])
        self.assertGreater(len({v for row in one["rows"] for v in row}), 1, "as the slices have it")

    def test_nobody_stands_where_a_curtain_comes_down(self):
        """From then on its place does not count; before, it does."""
        mesh = Mesh("hall", (0, 20, 0, 4, 0, 3), (20, 4, 3), [(12, 13, 0, 4, 0, 3)])
        for first, when in (("12", 75), ("3", 15)):
            case = FdsCase([mesh], TIMES, lambda t, *_: 0.001 * t, events=[(0, 0, 0, False), (0, 0, when, True)],
                           more=[("TEMPERATURE", "C", lambda t, x, *_: 20 + t + (10 if 12 < x < 13 else 0))]).write(self.folder, f"c{first}")
            self.works("visibility", case, "--signs", self.signs(), "--criteria", self.criteria(self.HOT), "--height", 1.5, "--step", 1,
                       "--everywhere", "-o", self.path("out"))
            (hot,) = self.report("out")["tenability"]["criteria"]
            self.assertEqual({str(v) for row in hot["rows_known"] for v in row}, {"True"})
            self.assertEqual(hot["rows"][1][12], 20 if when == 75 else None)
            self.assertEqual(hot["rows"][1][3], 30)
            self.assertEqual(self.report("out")["verdict"][0]["known"], True)

    def test_floors_that_are_higher_lift_the_eyes(self):
        """A deck of a metre under smoke that ends above the heads of those who stand beside it."""
        mesh = Mesh("hall", (0, 20, 0, 4, 0, 6), (20, 4, 12), [(6, 20, 0, 4, 0, 1)])
        FdsCase([mesh], TIMES, lambda t, x, y, z: 0.02 * t * (z > 2.5)).write(self.folder, "deck")
        for more, reached in (((), 10), (("--everywhere",), None)):
            self.works("visibility", self.path("deck.smv"), "--signs", self.signs(), "--height", 1.8, "--step", 1, "-o", self.path("out"),
                       *more)
            (verdict,) = [one for one in self.report("out")["verdict"] if one["criterion"] == "visibility"]
            self.assertEqual(verdict["time"], reached)
        self.works("visibility", self.path("deck.smv"), "--signs", self.signs(), "--height", 1.8, "--step", 1, "-o", self.path("out"),
                   "--rset", 50)
        report = self.report("out")
        (verdict,) = [one for one in report["verdict"] if one["criterion"] == "visibility"]
        self.assertAlmostEqual(verdict["position"][2], 2.8)
        self.assertGreater(verdict["position"][0], 6)
        self.assertEqual(report["tenability"]["margin"]["least"]["value"], -40)
        self.assertTrue(any("up to 1 m higher" in remark for remark in report["remarks"]))
        self.path("route.csv").write_text("x,y\n2,2\n17,2\n")
        self.works("visibility", self.path("deck.smv"), "--signs", self.signs(), "--route", self.path("route.csv"), "--height", 1.8,
                   "--speed", 1, "--start", 100, "-o", self.path("route"))
        (route,) = self.report("route")["routes"]
        reached = {one["name"]: one["time_interpolated"] for one in route["exposure"]}["visibility"]
        self.assertTrue(103 <= reached <= 105, reached)

    def test_people_are_where_it_burns_later(self):
        """The second fire is on a place that people used until then."""
        mesh = Mesh("hall", (0, 20, 0, 4, 0, 3), (20, 4, 3))
        case = FdsCase([mesh], TIMES, lambda t, x, *_: 0.001 * t * x,
                       more=[("HRRPUV", "kW/m3", lambda t, x, *_: 500.0 * (0 < t and (x < 4 or (x > 16 and t > 60))))])
        self.works("visibility", case.write(self.folder, "case"), "--signs", self.signs(), "--height", 1.5, "--step", 1, "-o",
                   self.path("out"))
        report = self.report("out")
        self.assertEqual(report["plan_use"][1], "ffff" + 16 * "p")
        self.assertGreater(report["verdict"][0]["position"][0], 19)

    def test_meshes_without_smoke_are_not_known_unless_another_source_serves(self):
        halves = [Mesh("west", (0, 10, 0, 4, 0, 3), (10, 4, 3)), Mesh("east", (10, 20, 0, 4, 0, 3), (10, 4, 3))]
        smoke = ("MASS", "1/m", lambda t, x, *_: 0.001 * t * (20 - x))
        path = FdsCase(halves, TIMES, smoke[2]).write(self.folder, "case")
        lines = path.read_text().split("\n")
        west = next(i for i, line in enumerate(lines) if line.startswith("SLCC     1"))
        path.write_text("\n".join(lines[:west] + lines[west + 5:]))
        words = ("visibility", path, "--signs", self.signs(), "--height", 1.5, "--step", 1, "-o", self.path("out"))
        self.works(*words)
        report = self.report("out")
        whole = report["verdict"][0]
        self.assertEqual((whole["time"], whole["known"]), (None, False))
        self.assertEqual(report["aset"][0]["rows_known"][1][3], False)
        self.assertTrue(any("no smoke is stored for 1 of 2 meshes" in remark for remark in report["remarks"]))
        self.path("route.csv").write_text("x,y\n2,2\n17,2\n")
        self.works("visibility", path, "--signs", self.signs(), "--route", self.path("route.csv"), "--height", 1.5, "--slowed", "fridolf",
                   "-o", self.path("route"))
        report = self.report("route")
        self.assertEqual(report["routes"][0]["arrival_known"], False)
        self.assertIn("if there is no smoke where it is not known", report["verdict"][0]["sentence"])

    def test_people_meet_smoke_between_stored_times(self):
        """A curtain of smoke that somebody has passed by the next stored time."""
        mesh = Mesh("hall", (0, 20, 0, 4, 0, 3), (20, 4, 3))
        case = FdsCase([mesh], [0.0, 10.0, 20.0], lambda t, x, *_: 1.0 * (9 < x < 12)).write(self.folder, "case")
        self.path("walks.csv").write_text("id,time,x,y,z\n1,0,2,2,1.5\n1,10,18,2,1.5\n2,0,2,2,1.5\n2,10,7,2,1.5\n")
        self.works("visibility", case, "--signs", self.signs(), "--trajectories", self.path("walks.csv"), "-o", self.path("out"))
        (thick,) = [one for one in self.report("out")["tenability"]["criteria"] if one["name"] == "visibility"]
        self.assertEqual(thick["times"], [0, None])
        self.assertTrue(4 <= thick["times_interpolated"][0] <= 5, thick)

    def test_walkers_wait_for_smoke_or_hear_of_it(self):
        case = self.case(smoke=lambda t, x, *_: 0.001 * t * (x < 10))
        self.path("routes.csv").write_text("route,x,y\nwest,2,1\nwest,17,1\neast,15,3\neast,18,3\n")
        words = ("visibility", case, "--signs", self.signs(), "--route", self.path("routes.csv"), "--height", 1.5, "--speed", 1, "-o",
                 self.path("out"), "--start")
        self.works(*words, "smoke:0.05,5")
        report = self.report("out")
        west, east = report["routes"]
        self.assertAlmostEqual(west["start"], 55, 4)
        self.assertAlmostEqual(west["arrival"], 70, 4)
        self.assertEqual((east["start"], east["arrival"]), (None, None))
        self.assertIn("waits for an extinction of 0.05 1/m", report["verdict"][1]["sentence"])
        self.works(*words, "heard:0.05")
        west, east = self.report("out")["routes"]
        self.assertAlmostEqual(east["start"], 50, 4)
        self.assertAlmostEqual(east["arrival"], 53, 4)
        self.assertIn("expected seconds, smoke:K", self.fails(2, *words, "smoke:0"))

    def test_signs_are_of_routes_and_ahead(self):
        case = self.case(smoke=lambda *_: 0.001)
        self.path("routes.csv").write_text("route,x,y\nout,2,2\nout,17,2\nback,17,1\nback,2,1\n")
        words = ("visibility", case, "--route", self.path("routes.csv"), "--height", 1.5, "-o", self.path("out"), "--signs")
        self.works(*words, self.signs())
        for route, sign in zip(self.report("out")["routes"], ("exit", "back")):
            self.assertEqual({tuple(one["seen"]) for one in route["walk"]}, {(sign,)})
        signs = json.loads(self.path("signs.json").read_text())
        signs["signs"][0]["routes"] = "back"
        self.path("signs.json").write_text(json.dumps(signs))
        self.works(*words, self.path("signs.json"))
        out, back = self.report("out")["routes"]
        self.assertEqual((out["walk_share_with_a_sign"], back["walk_share_with_a_sign"]), (0, 1))
        self.assertEqual(list(out["coverage"][0]["signs"]), ["back"])
        signs["signs"][0]["routes"] = ["elsewhere"]
        self.path("signs.json").write_text(json.dumps(signs))
        self.assertIn("expected one of 'out', 'back'", self.fails(2, *words, self.path("signs.json")))

    def test_options_that_change_nothing_are_told(self):
        self.works("visibility", self.case(), "--signs", self.signs(), "--height", 1.5, "--step", 2, "-o", self.path("out"), "--C", 8,
                   "--mass-extinction", 7600)
        told = [remark for remark in self.report("out")["remarks"] if "has no effect" in remark]
        self.assertEqual(len(told), 2, told)

    def test_people_of_fds_evac(self):
        def record(data):
            return struct.pack("<i", len(data)) + data + struct.pack("<i", len(data))

        frames = b"".join(
            record(struct.pack("<f", t)) + record(struct.pack("<i", 1))
            + record(struct.pack("<7f", 2 + t / 10, 2, 1, 0, 0.5, 0.3, 1.8)) + record(struct.pack("<i", 4))
            for t in range(0, 121, 10))
        self.path("people.prt5").write_bytes(b"".join(record(struct.pack("<i", n)) for n in (1, 670, 1)) + record(struct.pack("<2i", 0, 0))
                                             + frames)
        case = self.case(smoke=lambda t, x, *_: 0.01 * t)
        for more in (("--trajectories", self.path("people.prt5")), ("--height", 1.8, "--step", 1, "--rset", self.path("people.prt5"))):
            self.works("visibility", case, "--signs", self.signs(), "-o", self.path("out"), *more)
            report = self.report("out")
            if "--rset" in more:
                self.assertLess(report["tenability"]["margin"]["least"]["value"], 0)
                continue
            self.assertEqual(report["tenability"]["ids"], [4])
            (thick,) = [one for one in report["tenability"]["criteria"] if one["name"] == "visibility"]
            self.assertAlmostEqual(thick["times_interpolated"][0], 30, 3)
            self.assertTrue(any("eyes are 1.8 m above it" in remark for remark in report["remarks"]))
        self.assertIn("names no people", self.fails(1, "visibility", case, "--signs", self.signs(), "-o", self.path("out"), "--trajectories",
                                                    case))

    def test_smoke_slows_walkers_down(self):
        case = self.case(smoke=lambda *_: 2.0)
        self.path("route.csv").write_text("x,y\n2,2\n17,2\n")
        self.works("visibility", case, "--signs", self.signs(), "--route", self.path("route.csv"), "--height", 1.5, "--slowed",
                   "fridolf", "-o", self.path("out"))
        (route,) = self.report("out")["routes"]
        self.assertAlmostEqual(route["arrival"], 15 / (1.2 - 0.34 * 1.5), 2)
        words = ("visibility", case, "--signs", self.signs(), "--route", self.path("route.csv"), "--height", 1.5, "-o", self.path("out"), "--slowed")
        self.works(*words, "fridolf:0.2,2,0.3")
        (route,) = self.report("out")["routes"]
        self.assertAlmostEqual(route["arrival"], 15 / (1.2 - 0.2 * 0.5), 2)
        self.assertEqual(self.report("out")["walk"]["slowed_by_smoke"]["coefficients"]["at least [m/s]"], 0.3)
        self.assertIn("expected three coefficients behind the colon", self.fails(2, *words, "fridolf:0.2"))

    def test_what_is_not_stored_is_said_and_the_rest_goes_on(self):
        self.works("visibility", self.case(more=[]), "--signs", self.signs(), "--height", 1.5, "--step", 2, "-o", self.path("out"))
        criteria = {one["name"]: one for one in self.report("out")["tenability"]["criteria"]}
        self.assertIn("rows", criteria["visibility"])
        self.assertIn("CARBON MONOXIDE", criteria["fed-gas-iso"]["not_assessed"])

    def test_what_is_stored_and_cannot_be_read_is_not_known(self):
        """A slice of the temperature that is cut off, missing, or damaged; one of CO2, which would count as in clean air; points and routes too."""
        whole = self.case("whole")
        where = ("--height", 1.5, "--step", 2)
        self.works("visibility", whole, "--signs", self.signs(), *where, "-o", self.path("out"))
        self.assertEqual(self.report("out")["verdict"][0]["known"], True)
        self.path("eyes.csv").write_text("x,y,z\n3,2,1.5\n")
        self.path("route.csv").write_text("x,y,z\n3,2,1.5\n9,2,1.5\n")

        def cut(path):
            path.write_bytes(path.read_bytes()[:60])

        def damage(path):
            path.write_bytes(b"\x07" * 4 + path.read_bytes()[4:])

        for number, (wrong, file, name) in enumerate([
                (cut, 2, "temperature"), (pathlib.Path.unlink, 2, "temperature"), (damage, 2, "temperature"), (damage, 4, "fed-gas-iso")]):
            case = self.case(f"bad{number}")
            wrong(self.path(f"bad{number}_1_{file}.sf"))
            for more in (where, ("--eyes", self.path("eyes.csv")), ("--route", self.path("route.csv"))):
                self.works("visibility", case, "--signs", self.signs(), *more, "-o", self.path("out"))
                report = self.report("out")
                verdict = report["verdict"][0]
                self.assertEqual((verdict["time"], verdict["known"] is True), (None, False), verdict)
                self.assertIn(name, verdict["sentence"])
                if more[0] == "--route":
                    continue
                (of_it,) = (one for one in report["verdict"] if one["criterion"] == name)
                self.assertIn(f"bad{number}_1_{file}.sf", of_it["sentence"])
                (criterion,) = (one for one in report["tenability"]["criteria"] if one["name"] == name)
                known = criterion["rows_known" if more is where else "times_known"]
                self.assertEqual({str(one) for row in known for one in (row if more is where else [row])} - {"None"}, {"False"})

    def test_criteria_and_rset_are_checked(self):
        case, signs = self.case(), self.signs()

        def refused(criteria, *words):
            self.path("bad.json").write_text(json.dumps(criteria))
            message = self.fails(1, "visibility", case, "--signs", signs, "--criteria", self.path("bad.json"), "-o", self.path("x"))
            for word in words:
                self.assertIn(word, message)

        refused({}, "/criteria", "expected a list")
        refused({"criteria": [{"kind": "temprature", "limit": 1}]}, "/criteria/0/kind", "temprature")
        refused({"criteria": [{"kind": "temperature"}]}, "/criteria/0/limit", "missing")
        refused({"criteria": [{"kind": "fed-gas", "model": "purser", "limit": 1}]}, "iso-13571, sfpe")
        refused({"criteria": [{"kind": "fed-gas", "limt": 1}]}, "did you mean 'limit'")
        for kind, member, value, said in (
                ("temperature", "C", 8, "temperature"), ("temperature", "model", "fds", "temperature"), ("oxygen", "clothing", "clothed", "oxygen"),
                ("fed-gas", "activity", "heavy", "fed-gas by iso-13571"), ("fed-gas", "C", 3, "fed-gas"), ("fec", "burns", "pain", "fec by iso-13571")):
            refused({"criteria": [{"kind": kind, "limit": 0.3, member: value}]}, f"/criteria/0/{member}: has no effect on {said}; leave it out")
        self.path("rset.csv").write_text("what\n")
        self.assertIn("x,y,rset", self.fails(1, "visibility", case, "--signs", signs, "--rset", self.path("rset.csv"), "-o",
                                             self.path("x")))
        self.assertIn("--rset", self.fails(2, "visibility", case, "--signs", signs, "--rset", "-5", "-o", self.path("x")))

    def test_large_tables_are_compressed(self):
        case, signs = self.case(), self.signs()
        for kind, names in (("csv", {"sight.csv"}), ("csv.zst", {"sight.csv.zst"}), ("none", set())):
            self.works("visibility", case, "--signs", signs, "--height", 1.5, "--step", 0.5, "--maps", "aset", "--sight", kind, "-o",
                       self.path("out"))
            self.assertEqual({p.name for p in self.path("out").glob("sight*")}, names)
        self.works("visibility", case, "--signs", signs, "--height", 1.5, "--step", 0.08, "--maps", "aset", "-o", self.path("out"))
        packed = (self.path("out") / "sight.csv.zst").read_bytes()
        self.assertEqual(packed[:4], b"\x28\xb5\x2f\xfd")
        self.assertEqual(self.report("out")["sight_file"], "sight.csv.zst")


class Areas(Cases):
    """Two rooms of a hall, x = 0 to 10 and 10 to 20, with a door of 1 m; it is hot in the first one."""

    def rooms(self):
        mesh = Mesh("hall", (0, 20, 0, 4, 0, 3), (80, 16, 12), [(10, 10.25, 0, 1.5, 0, 3), (10, 10.25, 2.5, 4, 0, 3)])
        hot = ("TEMPERATURE", "C", lambda t, x, *_: 20 + (t if x < 10 else t / 4))
        return FdsCase([mesh], [0.0, 30.0, 60.0, 90.0], lambda t, *_: 1e-4 * t, more=[hot]).write(self.folder)

    def look(self, areas=None, *more, out="out", case=None, height=1.5):
        words = []
        if areas is not None:
            self.path("areas.json").write_text(json.dumps(areas))
            words = ["--areas", self.path("areas.json")]
        self.works("visibility", case or self.rooms(), "--signs", self.signs(), "--criteria",
                   self.criteria({"name": "hot", "kind": "temperature", "limit": 60}), "--height", height, "--step", 0.5, "--maps", "aset",
                   *words, *more, "-o", self.path(out))
        return self.report(out)

    def test_rooms_are_found_with_their_doors_and_have_verdicts(self):
        report = self.look(None, "--rset", 50)
        first, second = report["areas"]
        self.assertEqual((first["name"], second["name"]), ("room 1", "room 2"))
        self.assertAlmostEqual(first["floor_area"], 40, delta=2)
        self.assertEqual((first["aset"]["time"], first["aset"]["by"]), (30, "hot"))
        self.assertIsNone(second["aset"]["time"])
        self.assertIs(second["aset"]["known"], True)
        self.assertEqual((first["margin"]["value"], second["margin"]["points_too_late"]), (-20, 0))
        (door,) = report["doors"]
        self.assertEqual(door["between"], ["room 1", "room 2"])
        self.assertAlmostEqual(door["position"][1], 2, delta=0.3)
        self.assertAlmostEqual(door["width"], 1, delta=0.25)
        self.assertEqual(report["area_rows"][1][3], "room 1")
        sentences = [one["sentence"] for one in report["verdict"]]
        self.assertTrue([one for one in sentences if one.startswith("Of 2 rooms the first is 'room 1': ASET 30 s")], sentences)
        with open(self.path("out") / "areas.csv", newline="") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual([(row["name"], row["aset"], row["aset_known"], row["margin"]) for row in rows],
                         [("room 1", "30.0", "yes", "-20.0"), ("room 2", "", "yes", "")])
        self.assertIn("Rooms and areas", (self.path("out") / "report.html").read_text())
        self.assertTrue((self.path("out") / "areas.png").exists())

    def test_named_areas_routes_and_exits_win_and_have_their_own_times(self):
        """An area that is not for people takes its points out of the verdict of all; each has its RSET."""
        areas = {"areas": [{"name": "hot half", "polygon": [[0, 0], [5, 0], [5, 4], [0, 4]], "people": False},
                           {"name": "the rest", "polygon": [[5, 0], [9.9, 0], [9.9, 4], [5, 4]], "rset": 40}],
                 "exits": [{"name": "east", "line": [[20, 1], [20, 3]]}],
                 "routes": [{"name": "out", "line": [[6, 2], [20, 2]]}, {"name": "by names", "areas": ["east"]}]}
        report = self.look(areas)
        found = {one["name"]: one for one in report["areas"]}
        self.assertEqual(list(found), ["hot half", "the rest", "east", "out", "by names", "room 2"])
        self.assertEqual(found["hot half"]["aset"]["time"], 30)
        self.assertAlmostEqual(found["the rest"]["floor_area"], 19.6)
        self.assertEqual(found["the rest"]["margin"]["value"], -10)
        self.assertEqual(found["out"]["aset"]["time"], 30)
        self.assertIsNone(found["east"]["aset"]["time"])
        self.assertEqual(found["by names"]["points"], found["east"]["points"])
        self.assertTrue(report["plan_use"][1].startswith("n" * 10 + "p"))
        self.assertTrue([one for one in report["verdict"] if "named as not for people (hot half)" in one["sentence"]])
        self.assertTrue([one for one in report["verdict"] if one["criterion"] == "area the rest" and "ASET - RSET is -10 s" in
                         one["sentence"]])

    def test_the_rset_of_an_area_whose_margin_is_not_known_is_told(self):
        """The data end at 90 s; of a route the longest RSET counts, and what is known of it is a bound."""
        areas = {"areas": [{"name": "west", "polygon": [[0, 0], [9.9, 0], [9.9, 4], [0, 4]], "rset": 40},
                           {"name": "east", "polygon": [[10.3, 0], [20, 0], [20, 4], [10.3, 4]], "rset": 200}],
                 "routes": [{"name": "way", "line": [[6, 2], [19, 2]]}]}
        report = self.look(areas)
        found = {one["name"]: one["margin"] for one in report["areas"]}
        self.assertEqual([(found[name]["rset"], found[name]["value"], found[name]["known"], found[name].get("at_most"))
                          for name in ("west", "east", "way")],
                         [(40, -10, True, None), (200, None, False, None), (200, None, False, -10)])
        with open(self.path("out") / "areas.csv", newline="") as file:
            rows = {row["name"]: row for row in csv.DictReader(file)}
        self.assertEqual([tuple(rows[name][key] for key in ("rset", "margin", "margin_known", "margin_at_most"))
                          for name in ("west", "east", "way")],
                         [("40.0", "-10.0", "yes", ""), ("200.0", "", "no", ""), ("200.0", "", "no", "-10.0")])
        page = (self.path("out") / "report.html").read_text()
        self.assertIn("<b>not known</b>, at most -10", page)
        (sentence,) = (one["sentence"] for one in report["verdict"] if one["criterion"] == "route way")
        self.assertRegex(sentence, "its margin is not known at .* of the points in use, and -10 s at others: too late")

    def test_required_times_of_rooms_by_name(self):
        self.path("rset.csv").write_text("room;rset [min]\nroom 1;1\nroom 2;0.5\n")
        report = self.look(None, "--rset", self.path("rset.csv"))
        self.assertEqual([one["margin"]["value"] for one in report["areas"]], [-30, None])
        self.assertEqual(report["tenability"]["rset"]["rows"][1][3], 60)
        self.path("rset.csv").write_text("area,rset\nhall,60\n")
        words = ("visibility", self.rooms(), "--signs", self.signs(), "--rset", self.path("rset.csv"), "-o", self.path("x"))
        self.assertIn("no room or area of the plan at z = 2 m is named 'hall'; expected some of room 1, room 2", self.fails(2, *words))
        for lines, saying in (("room 1,5\nroom 1,6\n", "line 3: 'room 1' is there twice"), ("room 1,-5\n", "line 2: rset is -5 s")):
            self.path("rset.csv").write_text("area,rset\n" + lines)
            self.assertIn(saying, self.fails(1, *words))

    def test_two_required_times_of_one_area_are_refused(self):
        self.path("rset.csv").write_text("area,rset\nwest,60\n")
        area = {"name": "west", "polygon": [[0, 0], [9.9, 0], [9.9, 4], [0, 4]]}
        self.assertEqual(self.look({"areas": [area | {"rset": 60}]}, "--rset", self.path("rset.csv"))["areas"][0]["margin"]["value"], -30)
        self.path("areas.json").write_text(json.dumps({"areas": [area | {"rset": 40}]}))
        self.assertIn("--rset: 'west' has 60 s in the table and 40 s of its own",
                      self.fails(2, "visibility", self.rooms(), "--signs", self.signs(), "--areas", self.path("areas.json"), "--rset",
                                 self.path("rset.csv"), "-o", self.path("x")))

    def test_people_of_no_storey_and_times_that_go_back_are_told(self):
        self.path("walk.csv").write_text("id,time,x,y,z\n1,10,5,1,1.5\n1,0,5,1,1.5\n2,0,5,1,9\n")
        result = self.works("visibility", self.rooms(), "--signs", self.signs(), "--rset", self.path("walk.csv"), "--height", 1.5,
                            "--step", 1, "--maps", "aset", "-o", self.path("out"))
        self.assertIn("1 of 2 people are always on no storey whose eyes are at z = 1.5 m", result.message)
        self.assertIn("line 3: time goes back there", result.message)

    def test_criteria_by_name_depend_on_the_rooms_size(self):
        """K rises by .005 1/m a second: 10 m of sight at 60 s, 5 m at 120 s; the rooms have 50 and 68 m2, the hall 120 m2."""
        mesh = Mesh("hall", (0, 24, 0, 5, 0, 3), (48, 10, 6), [(10, 10.5, 0, 2, 0, 3), (10, 10.5, 3, 5, 0, 3)])
        rooms = FdsCase([mesh], TIMES, lambda t, *_: 0.005 * t).write(self.folder, "rooms")
        hall = FdsCase([Mesh("hall", (0, 24, 0, 5, 0, 3), (48, 10, 6))], TIMES, lambda t, *_: 0.005 * t).write(self.folder, "hall")
        times = {}
        for case in (rooms, hall):
            self.works("visibility", case, "--signs", self.signs(), "--criteria", "nz-c4.3", "--height", 2, "--step", 0.5, "--maps", "aset",
                       "-o", self.path("out"))
            report = self.report("out")
            self.assertEqual(report["criteria_profile"]["name"], "nz-c4.3")
            sentences = " ".join(one["sentence"] for one in report["verdict"])
            other = ("0.3 1/m (rooms of 100 m2 and more)", "0.6 1/m (rooms below 100 m2)")[case == hall]
            self.assertIn(f"extinction >= {other} applies nowhere: people are in no such room.", sentences)
            self.assertNotIn("extinction >= 0.3 1/m is not reached", sentences)
            for area in report["areas"]:
                times[case.stem, area["name"]] = {one["criterion"]: one["time_interpolated"] for one in area["criteria"]
                                                  if one["applies"] and one["time"] is not None}
        self.assertAlmostEqual(times["hall", "room 1"]["visibility-10-m"], 60, 3)
        self.assertNotIn("visibility-5-m", times["hall", "room 1"])
        for name in ("room 1", "room 2"):
            self.assertAlmostEqual(times["rooms", name]["visibility-5-m"], 120, 3)
            self.assertNotIn("visibility-10-m", times["rooms", name])
        page = (self.path("out") / "report.html").read_text()
        self.assertIn("New Zealand Building Code", page)
        message = self.fails(2, "visibility", hall, "--signs", self.signs(), "--criteria", "nz-c4.5", "-o", self.path("x"))
        self.assertIn("expected none, usual, iso-13571, nz-c4.3, nz-c4.4 or a file", message)

    def test_obscuration_and_optical_density_are_criteria(self):
        """K = .001 t 1/m: 3.24 %/m, at which FDS's smoke detectors alarm, is K = .0329 1/m; D = .04 1/m is K = .0921 1/m."""
        criteria = self.criteria({"name": "alarm", "kind": "obscuration", "limit": 3.24}, {"name": "od", "kind": "optical-density",
                                                                                        "limit": 0.04})
        self.works("visibility", self.case(), "--signs", self.signs(), "--criteria", criteria, "--height", 1.5, "--step", 1, "--maps", "aset",
                   "-o", self.path("out"))
        alarm, density = self.report("out")["tenability"]["criteria"]
        self.assertAlmostEqual(alarm["rows_interpolated"][1][1], -1000 * math.log(1 - 0.0324), 3)
        self.assertAlmostEqual(density["rows_interpolated"][1][1], 1000 * 0.04 * math.log(10), 3)

    def test_points_know_no_rooms(self):
        self.path("eyes.csv").write_text("x,y\n1,1\n")
        self.works("visibility", self.rooms(), "--signs", self.signs(), "--criteria", "nz-c4.3", "--eyes", self.path("eyes.csv"),
                   "--height", 1.5, "-o", self.path("out"))
        names = {one["name"]: one.get("not_assessed") for one in self.report("out")["tenability"]["criteria"]}
        self.assertIsNone(names["visibility-10-m"])
        self.assertIn("rooms below 100 m2", names["visibility-5-m"])

    def test_how_the_aset_depends_on_what_is_uncertain(self):
        """K = .005 t everywhere, 10 m of sight: twice the smoke would halve the time."""
        hall = FdsCase([Mesh("hall", (0, 20, 0, 4, 0, 3), (20, 4, 3))], TIMES, lambda t, *_: 0.005 * t).write(self.folder)
        self.path("near.json").write_text(json.dumps({"signs": [{"name": "near", "position": [20, 2, 2], "normal": [1, 0, 0]}]}))
        self.works("visibility", hall, "--signs", self.path("near.json"), "--criteria", self.criteria({"kind": "visibility", "limit": 10}),
                   "--height", 1.5, "--step", 1, "--maps", "aset", "-o", self.path("out"))
        found = self.report("out")["sensitivity_of_aset"]
        self.assertAlmostEqual(found["base"]["time"], 60, 3)
        rows = {row["name"]: (row["first"]["time"], row["second"]["time"]) for row in found["rows"]}
        for name, first, second in (("soot yield, 25 % assumed", 48, 80), ("mass extinction, 8700 \u00b1 1100 m2/kg", 60 * 8700 / 9800,
                                                                          60 * 8700 / 7600), ("C of the signs", 60, 60)):
            self.assertAlmostEqual(rows[name][0], first, 2)
            self.assertAlmostEqual(rows[name][1], second, 2)
        self.assertEqual(found["rows"][0]["name"], "soot yield, 25 % assumed")
        self.assertTrue((self.path("out") / "tornado.png").exists())
        self.assertIn("Sensitivity of the ASET", (self.path("out") / "report.html").read_text())

    def test_a_report_names_its_author_and_its_inputs(self):
        self.look(None, "--title", "Hall <A>", "--project", "Museum", "--author", "A. Engineer", "--date", "2026-11-26")
        document = self.report("out")["document"]
        self.assertEqual((document["title"], document["project"], document["author"]), ("Hall <A>", "Museum", "A. Engineer"))
        sums = {pathlib.Path(one["file"]).name: one["sha256"] for one in document["inputs"]}
        for name in ("signs.json", "criteria.json"):
            self.assertEqual(sums[name], hashlib.sha256(self.path(name).read_bytes()).hexdigest())
        page = (self.path("out") / "report.html").read_text()
        self.assertIn("<h1>Hall &lt;A&gt;</h1>", page)
        self.assertIn(sums["signs.json"], page)
        order = [page.index(f"<h2>{title}</h2>") for title in (
            "Verdict", "The study", "Signs and criteria of sight", "Criteria of tenability", "Sources", "Rooms and areas", "Tenability",
            "Available safe egress time by visibility", "Sensitivity of the ASET", "Limits of validity", "Input files", "Signatures")]
        self.assertEqual(order, sorted(order))

    def test_nobody_stands_on_furniture_or_under_low_ceilings(self):
        """A desk of 2 x 1 x .75 m; a platform of .25 m before it; a duct at 1.5 m above another platform of 1 m."""
        mesh = Mesh("hall", (0, 20, 0, 4, 0, 3), (80, 16, 12),
                    [(2, 4, 1, 2, 0, 0.75), (5, 6, 1, 3, 0, 0.25), (10, 18, 0, 4, 0, 1), (15, 18, 0, 4, 2.5, 3)])
        case = FdsCase([mesh], [0.0, 10.0], lambda t, *_: 1e-3 * t).write(self.folder)
        report = self.look(case=case)
        row = report["plan_use"][2]
        self.assertEqual(row[4:8], "uuuu")
        self.assertEqual(row[10:12], "pp")
        self.assertEqual(row[20:30], "p" * 10)
        self.assertEqual(row[30:36], "l" * 6)
        places = [one["sentence"] for one in report["verdict"] if one["criterion"] == "places"]
        self.assertIn("less than 1.8 m of head room", places[0])
        self.assertIn("on top of things", places[0])

    def test_areas_are_closed_lines_of_a_drawing(self):
        case = self.rooms()
        body = "0 SECTION 2 HEADER 9 $INSUNITS 70 4 0 ENDSEC 0 SECTION 2 TABLES 0 LAYER 2 areas 70 0 62 -7 0 ENDSEC 0 SECTION 2 ENTITIES "
        for layer, left, right in (("walls", 0, 20000), ("areas", 0, 2000), ("areas", 2000, 4000)):
            body += f"0 LWPOLYLINE 8 {layer} 70 1 10 {left} 20 0 10 {right} 20 0 10 {right} 20 4000 10 {left} 20 4000 "
        body += "0 TEXT 8 areas 10 100 20 100 1 office 0 ENDSEC 0 EOF"
        self.path("plan.dxf").write_text(body.replace(" ", "\n") + "\n")
        words = ("visibility", case, "--signs", self.signs(), "--step", 0.5, "--maps", "aset", "--underlay", self.path("plan.dxf"))
        self.works(*words, "--area-layer", "AREAS", "-o", self.path("out"))
        areas = {one["name"]: one for one in self.report("out")["areas"]}
        self.assertEqual([areas[name]["kind"] for name in ("office", "AREAS 2")], ["area", "area"])
        self.assertEqual(areas["office"]["points"], areas["AREAS 2"]["points"])
        self.assertGreater(areas["office"]["points"], 10)
        self.assertIn("has no layer 'rooms'", self.fails(1, *words, "--area-layer", "rooms", "-o", self.path("no")))
        self.path("areas.json").write_text(json.dumps({"areas": [{"name": "mine", "polygon": [[0, 0], [1, 0], [1, 1]]}]}))
        self.assertIn("overlaps area 'mine'", self.fails(1, *words, "--area-layer", "areas", "--areas", self.path("areas.json"), "-o", self.path("no")))

    def test_areas_are_closed_lines_of_a_layer_of_an_svg(self):
        """Its picture is made by another program, here by one that always makes the same."""
        case = self.rooms()
        (self.path("bin")).mkdir()
        subprocess.run([support.PROGRAM, "synthesize", "flame", "-o", self.path("f.npy"), "--size", "16", "--frames", "1", "-q"], check=True)
        subprocess.run([support.PROGRAM, "render", self.path("f.npy"), "-o", self.path("bin/plan.png"), "--size", "20x4", "-q"], check=True)
        converter = self.path("bin/rsvg-convert")
        converter.write_text('#!/bin/sh\nexec cat "${0%/*}/plan.png"\n')
        converter.chmod(0o755)
        self.path("plan.svg").write_text(
            "<svg viewBox='0 0 200 40'><g inkscape:label='Rooms' transform='scale(10)'>"
            "<path inkscape:label='office' d='M0 0h2v4H0z'/><rect x='2' y='0' width='2' height='4'/><circle r='1'/></g></svg>")
        words = ("visibility", case, "--signs", self.signs(), "--step", 0.5, "--maps", "aset", "--underlay", self.path("plan.svg"),
                 "--underlay-bounds", "0,0,20,4")
        path = os.environ | {"PATH": f"{self.path('bin')}:{os.environ['PATH']}"}
        result = self.works(*words, "--area-layer", "rooms", "-o", self.path("out"), env=path)
        self.assertIn("1 lines of the layer 'rooms' are curves: they are no areas", result.message)
        areas = {one["name"]: one for one in self.report("out")["areas"]}
        self.assertEqual(areas["office"]["points"], areas["rooms 2"]["points"])
        self.assertGreater(areas["office"]["points"], 10)
        self.assertIn("no group is labelled 'walls'; it has 'Rooms'",
                      self.fails(1, *words, "--area-layer", "walls", "-o", self.path("no"), env=path))

    def test_a_storey_without_a_floor_is_told(self):
        """Eyes 5 m above the only floor."""
        case = FdsCase([Mesh("hall", (0, 20, 0, 4, 0, 8), (20, 4, 8))], TIMES, lambda t, *_: 0.001 * t).write(self.folder)
        result = self.works("visibility", case, "--signs", self.signs(), "--height", 5.5, "--step", 1, "-o", self.path("out"))
        self.assertIn("no point of the plan at z = 5.5 m has a floor within 2.5 m below it: all points count", result.message)

    def test_quantities_in_units_of_something_else_are_not_used(self):
        case = self.case(more=[("TEMPERATURE", "K", lambda t, *_: 293.15 + t), ("CARBON MONOXIDE VOLUME FRACTION", "kg/kg", lambda *_: 0.001)])
        self.works("visibility", case, "--signs", self.signs(), "--height", 1.5, "--step", 1, "-o", self.path("out"))
        report = self.report("out")
        (hot,) = (one for one in report["tenability"]["criteria"] if one["name"] == "temperature")
        self.assertEqual(hot["rows"][1][3], 40)  # 20 + t
        gaps = {one["name"]: one.get("not_assessed", "") for one in report["tenability"]["criteria"]}
        self.assertIn("slice3d-carbon-monoxide-volume-fraction-cells is in 'kg/kg'; expected mol/mol", gaps["fed-gas-iso"])

    def test_areas_elsewhere_are_refused(self):
        case = self.rooms()
        self.path("areas.json").write_text(json.dumps({"areas": [{"name": "far", "polygon": [[50, 0], [60, 0], [60, 9]]}]}))
        words = ("visibility", case, "--signs", self.signs(), "--areas", self.path("areas.json"), "-o", self.path("out"))
        self.assertIn("area 'far' holds no point of the plan at z = 2 m", self.fails(2, *words))
        self.path("eyes.csv").write_text("x,y\n1,1\n")
        self.assertIn("--areas: areas are of plans; --eyes has none", self.fails(2, *words, "--eyes", self.path("eyes.csv")))
        self.path("areas.json").write_text(json.dumps({"storeys": [{"name": "up", "z": [3, 6]}], "areas": [
            {"name": "far", "storey": "up", "polygon": [[0, 0], [9, 0], [9, 9]]}]}))
        self.assertIn("'far' is on the storey 'up', z = 3 to 6 m, and no plan is made there", self.fails(1, *words))


class Memory(Cases):
    def test_is_refused_before_it_is_taken(self):
        signs, case = self.signs(), self.case("a", smoke=lambda t, *_: 0.01 * t)
        said = self.fails(1, "visibility", case, "--signs", signs, "--height", 1.5, "--step", 0.005, "--maps", "aset", "--max-memory", "256M",
                          "-o", self.path("out"))
        self.assertIn("more than the 256 MiB allowed", said)

    def test_of_a_large_plan_is_what_is_allowed(self):
        """The report, too: its rows are not kept as a tree of numbers."""
        case = self.case("a", smoke=lambda t, *_: 0.01 * t)
        sign = {"normal": [1, 0, 0], "C": 3}
        self.path("many.json").write_text(json.dumps({"signs": [{"name": f"s{i}", "position": [0.01, 0.1 + 0.05 * i, 1.5], **sign}
                                                               for i in range(20)]}))
        self.works("visibility", case, "--signs", self.path("many.json"), "--height", 1.5, "--step", 0.05, "--maps", "aset", "--max-memory",
                   "192M", "-o", self.path("out"))
        used = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
        self.assertLess(used, 192 + 128)
        report = self.report("out")
        self.assertEqual(len(report["aset"]), 21)
        self.assertEqual(len(report["aset"][3]["rows"][5]), report["eyes"]["nx"])


class Sweep(Cases):
    def study(self, **more):
        self.signs()
        for name, smoke in (("a", 0.01), ("b", 0.02)):
            self.case(name, smoke=lambda t, *_, smoke=smoke: smoke * t, folder="cases")
        study = {"cases": ["cases"], "options": {"signs": "signs.json", "height": 1.5, "step": 1, "maps": "aset"},
                 "variants": [{"name": "plain"}, {"name": "up", "options": {"round": "up"}}]} | more
        self.path("study.json").write_text(json.dumps(study))
        return self.path("study.json")

    def rows(self):
        with open(self.path("study") / "study.csv", newline="") as file:
            return {row["run"]: row for row in csv.DictReader(file)}

    def sweep(self, study, *options):
        result = self.works("sweep", study, "-o", self.path("study"), "--json", *options)
        return result.json, result.message

    def test_each_case_with_each_variant_is_a_row(self):
        study = self.study()
        self.assertEqual(self.works("sweep", study, "--list").out, b"1 a_plain\n2 a_up\n3 b_plain\n4 b_up\n")
        self.assertEqual(self.sweep(study)[0]["done"], 4)
        rows = self.rows()
        self.assertEqual(sorted(rows), ["a_plain", "a_up", "b_plain", "b_up"])
        for row in rows.values():
            self.assertEqual(row["done"], "1")
            self.assertEqual(row["first sign lost"], "exit")
        # K d = 3 from the farthest place.
        time = 3 / 0.01 / math.dist((0.5, 0.5, 1.5), (20, 2, 2))
        self.assertAlmostEqual(float(rows["a_plain"]["sign lost first, interpolated [s]"]), time, 2)
        self.assertEqual(float(rows["a_plain"]["sign lost first [s]"]), 10)
        self.assertEqual(float(rows["a_up"]["sign lost first [s]"]), 20)
        self.assertTrue((self.path("study") / "compared/b_plain_difference.png").exists())
        self.assertTrue((self.path("study") / "compared/spread.vti").exists())

    def test_what_is_not_known_counts_as_unsafe(self):
        study = self.study(variants=[{"name": "plain"}])
        path = self.path("cases") / "a_1_2.sf"
        path.write_bytes(path.read_bytes()[:3 * 38 + 32 + 2 * (len(path.read_bytes()) - 3 * 38 - 32) // len(TIMES)])
        self.sweep(study)
        rows = self.rows()
        self.assertEqual((rows["a_plain"]["all [s]"], rows["a_plain"]["all, known"], rows["a_plain"]["all, not before [s]"]),
                         ("", "until 10.0", "10.0"))
        self.assertEqual(rows["b_plain"]["all, known"], "yes")
        self.assertEqual(rows["b_plain"]["all, not before [s]"], rows["b_plain"]["all [s]"])

    def test_each_storey_is_compared_with_its_own(self):
        """A run of two heights is what two runs of one height are."""
        def values(study, name):
            return (self.path(study) / "compared" / name).read_bytes().split(b"\n_", 1)[1]

        options = {"signs": "signs.json", "step": 1, "maps": "aset"}
        for study, height in (("study", "1.5,2.5"), ("low", 1.5), ("high", 2.5)):
            self.works("sweep", self.study(options=options | {"height": height}), "-o", self.path(study))
        names = sorted(path.name for path in (self.path("study") / "compared").iterdir())
        runs = ("a_up", "b_plain", "b_up")
        self.assertEqual(names, sorted([f"{run}_z_{z}_difference.{kind}" for run in runs for z in (1.5, 2.5) for kind in ("png", "vti")] +
                                       ["spread_z_1.5.vti", "spread_z_2.5.vti"]))
        for study, z in (("low", 1.5), ("high", 2.5)):
            for run in runs:
                self.assertEqual(values("study", f"{run}_z_{z}_difference.vti"), values(study, f"{run}_difference.vti"))
            self.assertEqual(values("study", f"spread_z_{z}.vti"), values(study, "spread.vti"))
        # The lower storey is farther from the sign, which hangs at 2 m.
        row = self.rows()["b_plain"]
        self.assertEqual(row["sign lost first, height [m]"], "1.5")

    def test_it_goes_on_where_it_was_stopped(self):
        study = self.study()
        self.sweep(study, "--part", "1/2")
        self.assertEqual(sorted(row["done"] for row in self.rows().values()), ["0", "0", "1", "1"])
        before = (self.path("study") / "a_plain/visibility.json").stat().st_mtime_ns
        out = self.sweep(study)[0]
        self.assertEqual((out["done"], out["kept"]), (2, 2))
        self.assertEqual((self.path("study") / "a_plain/visibility.json").stat().st_mtime_ns, before)
        # Other signs are another study.
        text = self.path("signs.json").read_text().replace("[20, 2, 2]", "[20, 2, 1.5]")
        self.path("signs.json").write_text(text)
        self.assertEqual(self.sweep(study)[0]["done"], 4)
        # So is what a case consists of.
        path = self.path("cases") / "a_1_2.sf"
        data = bytearray(path.read_bytes())
        data[-10] ^= 1
        path.write_bytes(data)
        out = self.sweep(study)[0]
        self.assertEqual((out["done"], out["kept"]), (2, 2))
        self.assertEqual(self.sweep(study)[0]["kept"], 4)

    def test_a_run_that_fails_has_a_sentence_and_the_others_go_on(self):
        study = self.study(cases=["cases", "nowhere.smv", {"case": "cases/a.smv", "name": "coarse", "options": {"step": 2}}],
                           variants=[{"name": "v"}])
        out, said = self.sweep(study)
        self.assertEqual((out["done"], out["failed"]), (3, 1))
        self.assertIn("nowhere.smv", self.rows()["nowhere_v"]["why"])
        self.assertIn("'coarse_v' has another plan", said)
        # With the option that it is about.
        write_vtu(self.path("a.vtu"), (4, 4, 3), (4, 4, 3), lambda *_: 0.1)
        soot = {"field": "smoke", "quantity": "extinction", "mass-extinction": 7600}
        _, said = self.sweep(self.study(cases=["cases", {"case": "a.vtu", "options": soot}], variants=[{"name": "v"}]))
        self.assertTrue(self.rows()["a_v_2"]["why"].startswith("mass-extinction: is of soot"))
        self.assertIn("run 'a_v_2': mass-extinction: is of soot", said)

    def test_runs_by_their_numbers(self):
        """As an array of jobs does them, and the table when all are done."""
        study = self.study()
        listed = self.works("sweep", study, "--list", "--json").json["runs"]
        self.assertEqual([(run["number"], run["name"]) for run in listed], [(1, "a_plain"), (2, "a_up"), (3, "b_plain"), (4, "b_up")])
        for number in (4, 1, 3, 2):
            self.assertEqual(self.sweep(study, "--only", number)[0]["done"], 1)
            self.assertFalse((self.path("study") / "study.csv").exists())
        self.assertIn("2 a_up: done", self.works("sweep", study, "--list", "-o", self.path("study")).text)
        self.assertEqual(self.sweep(study)[0]["kept"], 4)
        by_number = (self.path("study") / "study.csv").read_bytes()
        self.works("sweep", study, "-o", self.path("other"))
        self.assertEqual((self.path("other") / "study.csv").read_bytes(), by_number)
        self.assertIn("--only: 5 of a study of 4", self.fails(2, "sweep", study, "-o", self.path("study"), "--only", 5))
        self.assertIn("--output is missing", self.fails(2, "sweep", study))

    def test_a_run_by_its_number_that_fails(self):
        study = self.study(cases=["nowhere.smv"], variants=[{"name": "v"}])
        done = support.volute("sweep", study, "-o", self.path("study"), "--only", 1)
        self.assertEqual(done.code, 1)
        self.assertIn("nowhere.smv", done.message)
        self.assertIn("nowhere.smv", self.works("sweep", study, "--list", "-o", self.path("study")).text)

    def test_studies_are_checked(self):
        for more, word in (({"cases": []}, "/cases"), ({"variant": []}, "did you mean 'variants'"),
                           ({"options": {"output": "x"}}, "/options/output"), ({"baseline": "z"}, "/baseline"),
                           ({"options": {"height": {}}}, "/options/height")):
            self.assertIn(word, self.fails(1, "sweep", self.study(**more), "-o", self.path("study")))
        self.assertIn("--part", self.fails(2, "sweep", self.study(), "-o", self.path("study"), "--part", "3/2"))


if __name__ == "__main__":
    support.main()
