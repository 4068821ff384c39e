# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""What the program says of smoke on a mesh: `volute info`, and wrong requests."""
import json

import smoke_files
import support


class MeshCase(support.TestCase):
    def slab(self, name, value=1.0, **more):
        mesh = smoke_files.box((0, -1, -1), (10, 1, 2), (5, 2, 2))
        fields = {"smoke": [value * point[0] for point in mesh[0]]}
        smoke_files.write_vtu(self.path(name), mesh, fields | {key: [v] * len(mesh[0]) for key, v in more.items()})

    def series(self):
        self.slab("a.vtu", 1.0, heat=20.0)
        self.slab("b.vtu", 3.0, heat=80.0)
        smoke_files.write_pvd(self.path("hall.pvd"), {4: "a.vtu", 6.5: "b.vtu"})
        return self.path("hall.pvd")


class Info(MeshCase):
    def test_a_series(self):
        path = self.series()
        said = self.works("info", path, "--json").json
        self.assertEqual(said["kind"], "mesh")
        self.assertEqual(said["times"], [4, 6.5])
        self.assertEqual((said["points"], said["cells"], said["tetrahedra"]), (54, 120, 120))
        self.assertEqual(said["bounds"], [0, -1, -1, 10, 1, 2])
        self.assertAlmostEqual(said["volume"], 60)
        self.assertEqual((said["parts"], said["convex"], said["usable"]), (1, True, True))
        smoke, heat = said["fields"]
        self.assertEqual((smoke["name"], smoke["of"], smoke["components"]), ("smoke", "points", 1))
        self.assertEqual((smoke["minimum"], smoke["maximum"], smoke["not_finite"]), (0, 10, 0))
        self.assertEqual((heat["minimum"], heat["maximum"]), (20, 20))
        smoke, heat = self.works("info", path, "--json", "--values").json["fields"]
        self.assertEqual((smoke["maximum"], heat["maximum"]), (30, 80))
        text = self.works("info", path).text
        for words in ("4 to 6.5 s", "120: 120 tetrahedra", "smoke: scalar of points, 0 to 10"):
            self.assertIn(words, text)

    def test_a_file_of_the_series_is_missing(self):
        path = self.series()
        self.path("b.vtu").unlink()
        done = support.volute("info", path)
        self.assertEqual(done.code, 1)
        self.assertIn("b.vtu (of 6.5 s)", done.text)

    def test_a_mesh_that_cannot_be_used(self):
        points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1), (-1, -1, -1)]
        smoke_files.write_vtu(self.path("a.vtu"), (points, [(0, 1, 2, 3), (1, 2, 3, 4), (1, 2, 3, 5)]), {"smoke": [1.0] * 6})
        done = support.volute("info", self.path("a.vtu"))
        self.assertEqual(done.code, 1)
        self.assertIn("cannot be used", done.text)
        self.assertIn("face", done.text)
        self.assertIn("smoke: scalar of points", done.text)


class Memory(support.TestCase):
    def test_it_is_held_or_the_mesh_is_refused(self):
        """By the program's peak of resident memory; beyond it are the program and its libraries."""
        own = 80 << 20
        self.works("synthesize", "hall", "-o", self.path("hall.pvd"), "--cell", "0.25", "--frames", 1)
        self.path("signs.json").write_text(json.dumps({"signs": [{"name": "e", "position": [14, 1, 2], "normal": [0, 1, 0]}]}))
        self.path("eyes.csv").write_text("x,y,z\n14,6,2\n")
        soot = ["--quantity", "soot-density", "--unit", "g/m3"]
        verbs = {
            "info": [],
            "visibility": [*soot, "--signs", self.path("signs.json"), "--eyes", self.path("eyes.csv"), "-o", self.path("out")],
            "render": [*soot, "-o", self.path("x.png"), "--size", "32x24", "--eye", "1,1,2", "--target", "14,6,2", "--fov", 60]}
        for verb, options in verbs.items():
            codes = []
            for allowed in (96, 192, 384):
                code, message, peak = self.peak(verb, self.path("hall.pvd"), *options, "--max-memory", f"{allowed}M")
                codes.append(code)
                with self.subTest(verb=verb, allowed=allowed):
                    self.assertLess(peak, (allowed << 20) + own, message)
                    if code != 0:
                        self.assertIn("--max-memory", message)
            self.assertEqual((codes[0], codes[-1]), (1, 0), verb)


class WrongRequests(MeshCase):
    def test_a_slice_beside_the_mesh(self):
        self.slab("a.vtu")
        for plane, bounds in (("z=50", "-1 to 2 m along z"), ("x=-0.1", "0 to 10 m along x")):
            message = self.fails(2, "render", self.path("a.vtu"), "-o", self.path("x.png"), "--slice", plane,
                                 "--field", "smoke", "--quantity", "extinction")
            self.assertIn(f"--slice: {plane} misses the mesh, which reaches from {bounds}", message)


if __name__ == "__main__":
    support.main()
