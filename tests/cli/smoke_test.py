# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Smoke as a person sees it: what `volute render` makes of meshes, lamps and signs, against closed forms."""
import json
import math

import pictures
import smoke_files
import support

WHITE = {"background": [1, 1, 1]}


class SmokeCase(support.TestCase):
    """A slab of uniform smoke and pictures of it."""

    def slab(self, value, low=(0, -1, -1), high=(10, 1, 1), cells=(5, 2, 2), name="slab.vtu", **more):
        mesh = smoke_files.box(low, high, cells)
        fields = {"smoke": [float(value)] * len(mesh[0])}
        smoke_files.write_vtu(self.path(name), mesh, fields | {key: [float(v)] * len(mesh[0]) for key, v in more.items()})
        return name

    def scene(self, eye, target, case="slab.vtu", size=(8, 8), ortho=None, fov=None, smoke=None, **parts):
        camera = {"eye": eye, "target": target, "size": list(size)} | ({"fov": fov} if fov else {"ortho": ortho or 0.2})
        if abs(target[0] - eye[0]) + abs(target[1] - eye[1]) < 1e-9:
            camera["up"] = [0, 1, 0]
        media = [{"kind": "smoke", "case": case, "field": "smoke", "quantity": "extinction"} | (smoke or {})] if case else []
        self.path("scene.json").write_text(json.dumps(
            {"format": "volute-scene-1", "camera": camera, "media": media} | parts))
        return self.path("scene.json")

    def picture(self, scene, *more):
        self.works("render", scene, "-o", self.path("x.exr"), "--cache", "none", *more)
        return smoke_files.read_exr(self.path("x.exr"))

    def value(self, scene, *more, channel="R"):
        """The middle pixel's."""
        width, height, channels, _ = self.picture(scene, *more)
        return channels[channel][height // 2 * width + width // 2]


class Greys(SmokeCase):
    """A uniform slab gives 255 e^(-K L) within half a level at every distance, direction and cell size."""

    def grey(self, scene, *more):
        return 255 * self.value(scene, *more)

    def test_every_cell_size_distance_and_renderer(self):
        for cells in ((1, 1, 1), (3, 2, 5), (9, 4, 4)):
            self.slab(0.3119, cells=cells)
            for distance in (0.01, 3, 80):
                scene = self.scene([-distance, 0.03, 0.02], [5, 0.03, 0.02], **WHITE)
                for renderer in ("cpu", "reference"):
                    self.assertAlmostEqual(self.grey(scene, "--renderer", renderer), 255 * math.exp(-3.119), delta=0.01)

    def test_fds_smoke_test(self):
        for length, grey in ((0.5, 181), (1, 128), (2, 64), (3, 32), (4, 16), (5, 8)):
            self.slab(7.922e-5, high=(length, 1, 1))
            scene = self.scene([-3, 0.1, 0.2], [5, 0.1, 0.2], smoke={"quantity": "soot-density"}, **WHITE)
            self.assertAlmostEqual(self.grey(scene), 255 * (128 / 255) ** length, delta=0.5)
            self.assertAlmostEqual(self.grey(scene), grey, delta=0.75)  # grey is printed rounded

    def test_fds_beam_detector(self):
        self.slab(0.3119)
        exact = (192.6, 141.0, 103.2, 75.6, 55.3, 40.5, 29.6, 21.7, 15.9)
        for i, grey in enumerate(exact):  # seen from inside, so far from the smoke's end
            scene = self.scene([10 - 0.9 - i, 0.1, 0.2], [20, 0.1, 0.2], fov=1, **WHITE)
            self.assertAlmostEqual(self.grey(scene), grey, delta=0.06)

    def test_oblique_views_of_a_unit_cube(self):
        extinction = math.log(255 / 100)
        for cells in ((1, 1, 1), (4, 4, 4)):
            self.slab(extinction, low=(-0.5, -0.5, -0.5), high=(0.5, 0.5, 0.5), cells=cells)
            for direction, grey in (((1, 0, 0), 100), ((1, 1, 0), 68), ((0, 1, -1), 68), ((1, 1, 1), 50), ((-1, 1, 1), 50)):
                eye = [3 * d + 1e-4 for d in direction]
                length = math.sqrt(sum(d * d for d in direction))
                for how in ({"ortho": 1e-3}, {"fov": 0.01}):
                    seen = self.grey(self.scene(eye, [1e-4] * 3, **how, **WHITE))
                    self.assertAlmostEqual(seen, 255 * math.exp(-extinction * length), delta=0.2)
                    self.assertAlmostEqual(seen, grey, delta=0.5)

    def test_a_ramp_of_extinction(self):
        mesh = smoke_files.box((0, -1, -1), (10, 1, 1), (7, 2, 2))
        smoke_files.write_vtu(self.path("slab.vtu"), mesh, {"smoke": [0.06 * p[0] for p in mesh[0]]})
        self.assertAlmostEqual(self.grey(self.scene([-3, 0, 0], [5, 0, 0], **WHITE)), 255 * math.exp(-3), delta=0.01)


class Quantities(SmokeCase):
    def test_every_spelling_of_one_smoke(self):
        extinction = 0.3
        for value, smoke in (
                (extinction, {"quantity": "extinction"}),
                (extinction / 2, {"quantity": "extinction", "scale": 2}),
                (extinction / math.log(10), {"quantity": "optical-density"}),
                (10 * extinction / math.log(10), {"quantity": "optical-density-db"}),
                (3 / extinction, {"quantity": "visibility", "C": 3}),
                (8 / extinction, {"quantity": "visibility", "C": "jin-emitting"}),
                (extinction / 8700, {"quantity": "soot-density"}),
                (1e3 * extinction / 7600, {"quantity": "soot-density", "unit": "g/m3", "mass_extinction": 7600}),
                (1e6 * extinction / 7600, {"quantity": "soot-density", "unit": "mg/m3", "mass_extinction": 7600}),
                (1e3 * extinction / 760, {"quantity": "products-density", "unit": "g/m3", "mass_extinction": 7600, "soot_yield": 0.1}),
                (10 * extinction / math.log(10) / 4.2, {"quantity": "products-density", "unit": "g/m3", "material": "rigid PU foam",
                                                        "burning": "flaming"}),
                (extinction / 8700 / 1.2, {"quantity": "mass-fraction", "density_field": "rho"})):
            self.slab(value, rho=1.2)
            for mode, expected in ((None, math.exp(-3)), ("photometric", math.exp(-3)), ("threshold", None)):
                look = dict(smoke) | ({"mode": mode} if mode else {})
                c = {"jin-emitting": 8}.get(look.get("C"), look.get("C", 3))
                wanted = expected if expected else 10 ** (-3 / c)
                self.assertAlmostEqual(self.value(self.scene([-3, 0, 0], [5, 0, 0], smoke=look, **WHITE)), wanted, delta=1e-5)

    def test_a_case_on_the_command_line(self):
        self.slab(1e3 * 0.3 / 8700)
        view = ("--eye=-3,0,0", "--target", "5,0,0", "--ortho", "0.2", "--size", "8x8")
        case = ("--field", "smoke", "--quantity", "soot-density", "--unit", "g/m3")
        self.assertAlmostEqual(self.value(self.path("slab.vtu"), *view, *case), math.exp(-3), delta=1e-5)
        self.assertAlmostEqual(self.value(self.path("slab.vtu"), *view, *case, "--mode", "threshold"), 0.1, delta=1e-5)
        self.assertAlmostEqual(self.value(self.path("slab.vtu"), *view, *case, "--mode", "threshold", "--C", "8"), 10 ** (-3 / 8), delta=1e-5)
        self.assertAlmostEqual(self.value(self.path("slab.vtu"), *view, *case, "--background", "0.5,0.5,0.5"), 0.5 * math.exp(-3), delta=1e-5)
        depth = self.value(self.path("slab.vtu"), *view, *case, "--aov", "optical-depth", "--mode", "threshold", channel="Y")
        self.assertAlmostEqual(depth, 3, delta=1e-4)  # whatever the mode
        self.assertAlmostEqual(self.value(self.path("slab.vtu"), *view, *case, "--aov", "transmittance", "--mode", "threshold", channel="Y"),
                               0.1, delta=1e-5)
        self.works("render", self.path("slab.vtu"), "-o", self.path("framed.png"), *case)

    def test_what_is_missing_or_wrong(self):
        self.slab(0.3, other=1)
        smoke_files.write_vtu(self.path("negative.vtu"), smoke_files.box((0, 0, 0), (1, 1, 1), (1, 1, 1)), {"smoke": [0.5] * 7 + [-0.25]})
        smoke_files.write_vtu(self.path("nan.vtu"), smoke_files.box((0, 0, 0), (1, 1, 1), (1, 1, 1)), {"smoke": [0.5] * 3 + [math.nan] * 5})
        view = ("--eye=-3,0,0", "--target", "5,0,0", "--ortho", "0.2", "--size", "8x8")
        out = ("-o", self.path("x.png"))
        for code, words, said in (
                (2, ("slab.vtu", "--field", "smoke"), "--quantity: is missing"),
                (1, ("slab.vtu", "--field", "soot", "--quantity", "extinction"), "'soot'"),
                (1, ("slab.vtu", "--field", "soot", "--quantity", "extinction"), "smoke"),
                (1, ("slab.vtu", "--field", "soot", "--quantity", "extinction"), "other"),
                (1, ("nan.vtu", "--quantity", "extinction"), "nan.vtu: "),
                (2, ("slab.vtu", "--quantity", "extinction"), "choose one with --field"),
                (2, ("slab.vtu", "--field", "smoke", "--quantity", "products-density"), "soot yield"),
                (2, ("slab.vtu", "--field", "smoke", "--quantity", "mass-fraction"), "--density-field"),
                (2, ("slab.vtu", "--field", "smoke", "--quantity", "soot-density", "--material", "chipboard"), "products-density"),
                (2, ("slab.vtu", "--field", "smoke", "--quantity", "extinction", "--mode", "threshold", "--C", "-1"), "--C"),
                (2, ("slab.vtu", "--field", "smoke", "--quantity", "extinction", "--grid", "x"), "--grid"),
                (1, ("negative.vtu", "--quantity", "extinction"), "negative"),
                (1, ("none.vtu", "--quantity", "extinction"), "none.vtu")):
            message = self.fails(code, "render", self.path(words[0]), *words[1:], *view, *out)
            self.assertIn(said, message)
        result = self.works("render", self.path("negative.vtu"), "--quantity", "extinction", "--clamp", *view, *out)
        self.assertIn("1 negative value", result.message)
        self.slab(0)
        self.assertIn("no finite", self.fails(1, "render", self.path("slab.vtu"), "--quantity", "visibility", *view, *out))

    def test_meshes_that_are_none(self):
        points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1), (-1, -1, -1)]
        for name, used, tets, said in (
                ("flat", [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)], [(0, 1, 2, 3)], "no volume"),
                ("three", points, [(0, 1, 2, 3), (1, 2, 3, 4), (1, 2, 3, 5)], "face"),
                ("inverted", points[:5], [(0, 1, 2, 3), (0, 1, 2, 4)], "one is inverted; mend the mesh"),
                ("outside", points[:4], [(0, 1, 2, 9)], "vert")):
            smoke_files.write_vtu(self.path(f"{name}.vtu"), (used, tets), {"smoke": [0.5] * len(used)})
            message = self.fails(1, "render", self.path(f"{name}.vtu"), "--quantity", "extinction", "-o", self.path("x.png"))
            self.assertIn(said, message)
            self.assertIn(name + ".vtu", message)
        # A point that no cell has is as a filter leaves it: it changes nothing.
        smoke_files.write_vtu(self.path("loose.vtu"), (points[:5], [(0, 1, 2, 3)]), {"smoke": [0.5] * 5})
        result = self.works("render", self.path("loose.vtu"), "--quantity", "extinction", "-o", self.path("x.png"))
        self.assertIn("1 points that no cell has are left out", result.message)
        self.path("cut.vtu").write_bytes(self.path("loose.vtu").read_bytes()[:400])
        self.assertIn("cut.vtu", self.fails(1, "render", self.path("cut.vtu"), "--quantity", "extinction", "-o", self.path("x.png")))

    def test_words_that_would_change_nothing(self):
        self.slab(0.3, rho=1.2)
        case, out = ("render", self.path("slab.vtu"), "--field", "smoke"), ("-o", self.path("x.png"))
        for words, said in (
                (("--quantity", "soot-density", "--soot-yield", "0.1"), "--soot-yield: is for products-density, and soot-density is soot alone"),
                (("--quantity", "extinction", "--unit", "g/m3"), "--unit: is for densities, and extinction is in 1/m"),
                (("--quantity", "extinction", "--mass-extinction", "8700"), "--mass-extinction: is of soot"),
                (("--quantity", "products-density", "--material", "chipboard", "--soot-yield", "0.1"), "--soot-yield: the material takes"),
                (("--quantity", "extinction", "--density-field", "rho"), "--density-field: is for mass-fraction"),
                (("--quantity", "extinction", "--C", "8"), "--C: plays no part in a photometric picture"),
                (("--quantity", "extinction", "--mode", "photometric", "--C", "8"), "--C: plays no part"),
                (("--quantity", "extinction", "--slice", "z=0", "--slice-shows", "extinction", "--C", "8"), "--C: plays no part")):
            self.assertIn(said, self.fails(2, *case, *words, *out))
        self.assertFalse(self.path("x.png").exists())
        self.make_volute()
        self.assertIn("--quantity is for smoke", self.fails(2, "render", self.path("in.volute"), "--quantity", "extinction", *out))
        # What a command line may turn into something is a remark in a scene.
        scene = self.scene([-3, 0, 0], [5, 0, 0], smoke={"C": 8})
        self.assertIn("scene.json: /media/0/C: plays no part", self.works("render", scene, *out).message)
        for words in (("--mode", "threshold"), ("--slice", "z=0"), ("--isosurface", "3")):
            self.assertNotIn("plays no part", self.works("render", scene, *words, *out).message)

    def test_clear_air_is_doubted(self):
        self.slab(1e-4)
        case = ("render", self.path("slab.vtu"), "--quantity", "soot-density", "-o", self.path("x.png"))
        self.assertNotIn("clear air", self.works(*case).message)
        message = self.works(*case, "--unit", "mg/m3").message
        self.assertIn("optical depth above 9e-06", message)  # 8.7e-7/m over 10.4 m
        self.assertIn("read as kg/m3 instead of mg/m3 it would be 0.0001 kg/m3 of soot", message)

    def test_verdicts_doubt_clear_air_too(self):
        self.path("signs.json").write_text(json.dumps({"signs": [{"name": "exit", "position": [9, 0, 0], "normal": [-1, 0, 0]}]}))
        self.path("eyes.csv").write_text("x,y,z\n1,0,0\n")
        command = ("visibility", self.path("slab.vtu"), "--signs", self.path("signs.json"), "--eyes", self.path("eyes.csv"),
                   "-o", self.path("out"))
        self.slab(1e-4)
        density = ("--quantity", "soot-density", "--unit")
        self.assertNotIn("clear air", self.works(*command, *density, "kg/m3", "--strict").message)
        self.works(*command, *density, "mg/m3")
        remarks = json.loads((self.path("out") / "visibility.json").read_text())["remarks"]
        self.assertTrue(any("read as kg/m3 instead of mg/m3 it would be 0.0001 kg/m3" in remark for remark in remarks), remarks)
        self.assertIn("clear air", self.fails(1, *command, *density, "mg/m3", "--strict"))
        self.slab(0)
        self.assertIn("is 0 everywhere: there is no smoke", self.fails(1, *command, "--quantity", "extinction", "--strict"))

    def test_units_in_names_and_of_length_are_compared(self):
        case = ("render", self.path("slab.vtu"), "-o", self.path("x.png"), "--size", "8x8", "--strict")
        mesh = smoke_files.box((0, -1, -1), (10, 1, 1), (2, 1, 1))
        smoke_files.write_vtu(self.path("slab.vtu"), mesh, {"soot [mg/m3]": [1.0] * len(mesh[0])})
        density = (*case, "--quantity", "soot-density", "--unit")
        self.assertIn("its name states mg/m3, of which one is 0.001 g/m3, and it is read with a factor of 1", self.fails(1, *density, "g/m3"))
        self.works(*density, "mg/m3")
        smoke_files.write_vtu(self.path("slab.vtu"), mesh, {"K (1/ft)": [1.0] * len(mesh[0])})
        self.assertIn("one is 3.28084 1/m", self.fails(1, *case, "--quantity", "extinction"))
        self.works(*case, "--quantity", "extinction", "--scale", "3.280839895")
        mesh = smoke_files.box((0, 0, 0), (10000, 4000, 3000), (2, 1, 1))
        smoke_files.write_vtu(self.path("slab.vtu"), mesh, {"K": [1.0] * len(mesh[0])})
        self.assertIn("in millimetres it would be 10 x 4 x 3 m", self.works(*case, "--quantity", "extinction").message)
        self.path("signs.json").write_text(json.dumps({"signs": [{"name": "exit", "position": [9, 10, 10], "normal": [-1, 0, 0]}]}))
        self.path("eyes.csv").write_text("x,y,z\n1,10,10\n")
        self.assertIn("in millimetres", self.fails(1, "visibility", self.path("slab.vtu"), "--quantity", "extinction", "--signs",
                                                   self.path("signs.json"), "--eyes", self.path("eyes.csv"), "-o", self.path("out"), "--strict"))

    def test_scenes_name_the_place(self):
        self.slab(0.3)
        for smoke, where in (({"quantity": "soot"}, "/media/0/quantity"), ({"quantity": None}, "/media/0/quantity"),
                             ({"mode": "dark"}, "/media/0/mode"), ({"C": 0}, "/media/0/C"), ({"albedo": [2, 0, 0]}, "/media/0/albedo"),
                             ({"unit": "g"}, "/media/0/unit"), ({"burning": "flaming"}, "/media/0/burning"),
                             ({"walls": 3}, "/media/0/walls"), ({"negatives": 1}, "/media/0/negatives"),
                             ({"unit": "g/m3"}, "/media/0/unit"), ({"mass_extinction": 8700}, "/media/0/mass_extinction"),
                             ({"soot_yield": 0.1}, "/media/0/soot_yield"), ({"smoke_potential": 2}, "/media/0/smoke_potential"),
                             ({"emission": 3}, "/media/0/emission"), ({"case": 3}, "/media/0/case")):
            scene = self.scene([-3, 0, 0], [5, 0, 0], smoke=smoke)
            self.assertIn("scene.json: " + where, self.fails(1, "render", scene, "-o", self.path("x.png")))
        for sign, where in (({"normal": [0, 0, 0]}, "/signs/0/normal"), ({"size": [1]}, "/signs/0/size"), ({"C": "x"}, "/signs/0/C"),
                            ({"emitting": 1}, "/signs/0/emitting"), ({"colour": 1}, "/signs/0/colour")):
            scene = self.scene([-3, 0, 0], [5, 0, 0], signs=[{"position": [1, 0, 0], "normal": [-1, 0, 0]} | sign])
            self.assertIn("scene.json: " + where, self.fails(1, "render", scene, "-o", self.path("x.png")))
        for light, where in (({"kind": "spot", "position": [0, 0, 0]}, "/lights/0/target"),
                             ({"kind": "spot", "position": [0, 0, 0], "target": [0, 0, 0]}, "/lights/0"),
                             ({"kind": "lamp"}, "/lights/0")):
            self.assertIn("scene.json: " + where, self.fails(1, "render", self.scene([-3, 0, 0], [5, 0, 0], lights=[light]), "-o", self.path("x.png")))

    def test_one_picture_has_one_mode(self):
        self.slab(0.3)
        scene = json.loads(self.scene([-3, 0, 0], [5, 0, 0]).read_text())
        scene["media"].append(dict(scene["media"][0], mode="threshold"))
        self.path("scene.json").write_text(json.dumps(scene))
        self.assertIn("one picture has one mode", self.fails(1, "render", self.path("scene.json"), "-o", self.path("x.png")))


class Signs(SmokeCase):
    """An exit sign in a corridor of smoke, K = 0.3/m: 10 m before it and some behind it."""

    RADIANCE = 0.8

    def seen(self, mode, sign, **more):
        self.path("grey.exr").exists() or pictures.write_planes(self.path("grey.exr"), 1, 1, {"Y": [self.RADIANCE]})
        signs = [{"name": "exit", "position": [10, 0, 0], "normal": [-1, 0, 0], "size": [0.6, 0.3], "picture": "grey.exr"} | sign]
        smoke = {"mode": mode} | more.pop("smoke", {})
        return self.scene([0, 0, 0], [10, 0, 0], fov=0.5, smoke=smoke, signs=signs, **more)

    def test_laws(self):
        self.slab(0.3, low=(-5, -1, -1), high=(17, 1, 1), cells=(6, 2, 2))
        for mode, sign, share in (("photometric", {}, math.exp(-3)), ("photometric", {"emitting": True}, math.exp(-3)),
                                  ("photometric", {"C": 2}, math.exp(-3)), ("threshold", {}, 0.1), ("threshold", {"emitting": False}, 0.1),
                                  ("threshold", {"emitting": True}, 10 ** (-3 / 8)), ("threshold", {"C": 8}, 10 ** (-3 / 8)),
                                  ("threshold", {"emitting": True, "C": 3}, 0.1), ("threshold", {"C": "reciprocal-od"}, math.exp(-3))):
            for renderer in ("cpu", "reference"):
                value = self.value(self.seen(mode, sign), "--renderer", renderer)
                self.assertAlmostEqual(value, self.RADIANCE * share, delta=1e-5, msg=f"{mode} {sign} {renderer}")

    def test_the_figures_of_ten_metres(self):
        self.slab(0.3, low=(-5, -1, -1), high=(17, 1, 1))
        for mode, emitting, printed in (("photometric", True, 0.0498), ("threshold", False, 0.1000), ("threshold", True, 0.4217)):
            self.assertAlmostEqual(self.value(self.seen(mode, {"emitting": emitting})) / self.RADIANCE, printed, delta=5.1e-5)

    def test_smoke_keeps_its_own_light(self):
        self.slab(0.3, low=(-5, -1, -1), high=(17, 1, 1))
        light = {"lights": [{"kind": "ambient", "radiance": [0.5, 0.25, 1]}], "smoke": {"albedo": [0.4, 1, 0.5]}}
        for mode, c, factor in (("photometric", 8, 1), ("threshold", 8, math.log(10) / 3), ("threshold", 3, math.log(10) / 3)):
            share = math.exp(-3) if mode == "photometric" else 10 ** (-3 / c)
            for channel, source in (("R", 0.2), ("G", 0.25), ("B", 0.5)):
                expected = source * (1 - math.exp(-3 * factor)) + self.RADIANCE * share
                scene = self.seen(mode, {"C": c}, lights=light["lights"], smoke=dict(light["smoke"]))
                self.assertAlmostEqual(self.value(scene, channel=channel), expected, delta=1e-4)

    def test_thick_smoke_does_not_spoil_an_emitting_sign(self):
        self.slab(2.0, low=(-5, -1, -1), high=(17, 1, 1))  # e^-20: the march would stop at 1e-6
        scene = self.seen("threshold", {"emitting": True}, lights=[{"kind": "ambient", "radiance": [0, 0, 0]}])
        self.assertAlmostEqual(self.value(scene), self.RADIANCE * 10 ** (-20 / 8), delta=1e-4)

    def test_what_a_sign_hides_and_what_hides_it(self):
        self.slab(0.3, low=(-5, -1, -1), high=(17, 1, 1))
        scene = json.loads(self.seen("threshold", {}).read_text()) | WHITE
        near = dict(scene["signs"][0], position=[5, 0, 0], size=[0.01, 0.01])
        scene["signs"].append(near)
        self.path("scene.json").write_text(json.dumps(scene))
        width, height, channels, _ = self.picture(self.path("scene.json"))
        middle, corner = channels["R"][height // 2 * width + width // 2], channels["R"][0]
        self.assertAlmostEqual(middle, self.RADIANCE * 10 ** -0.5, delta=1e-5)
        self.assertAlmostEqual(corner, self.RADIANCE * 0.1, delta=1e-5)
        scene["signs"] = [dict(near, normal=[1, 0, 0])]  # from behind
        self.path("scene.json").write_text(json.dumps(scene))
        self.assertAlmostEqual(self.value(self.path("scene.json")), 10 ** (-0.3 * 17 / 3), delta=1e-5)

    def test_a_sign_without_smoke(self):
        scene = json.loads(self.seen("threshold", {}).read_text())
        scene["media"] = []
        self.path("scene.json").write_text(json.dumps(scene))
        self.assertAlmostEqual(self.value(self.path("scene.json")), self.RADIANCE, delta=1e-6)


class Lights(SmokeCase):
    def test_single_scattering_of_a_far_lamp(self):
        # Nearly the same light everywhere: I / r^2 albedo / (4 pi), thin smoke.
        self.slab(1e-4, low=(0, -0.05, -0.05), high=(0.1, 0.05, 0.05), cells=(1, 1, 1))
        lamp = {"kind": "spot", "position": [0, 0, 100], "target": [0, 0, 0], "angle": 1, "intensity": [4e8, 2e8, 1e8]}
        scene = self.scene([-1, 0, 0], [1, 0, 0], lights=[lamp], smoke={"albedo": [0.5, 0.5, 1]}, ortho=0.01)
        irradiance = 4e8 / 100 ** 2
        expected = 0.5 / (4 * math.pi) * irradiance * (1 - math.exp(-1e-5))
        self.assertAlmostEqual(self.value(scene) / expected, 1, delta=2e-3)
        self.assertAlmostEqual(self.value(scene, channel="B") / expected, 0.5, delta=2e-3)
        lamp["target"] = [5, 0, 0]  # the cone misses
        self.assertEqual(self.value(self.scene([-1, 0, 0], [1, 0, 0], lights=[lamp], ortho=0.01)), 0)

    def test_sun_through_a_slab(self):
        # E(z) = albedo / (4 pi) e^(-K (top - z)), seen along x: E (1 - e^(-K L)).
        self.slab(0.2, cells=(4, 4, 32))
        sun = {"kind": "sun", "direction": [0, 0, -1], "radiance": [10, 10, 10]}
        for z in (-0.75, 0.5):
            scene = self.scene([-3, 0, z], [5, 0, z], lights=[sun], ortho=0.01, smoke={"albedo": [1, 1, 1]})
            expected = 10 / (4 * math.pi) * math.exp(-0.2 * (1 - z)) * (1 - math.exp(-2))
            self.assertAlmostEqual(self.value(scene) / expected, 1, delta=1e-3)

    def test_a_house_of_the_same_plan_keeps_the_light_on_its_side(self):
        """Walls of the mesh that geometry shows, too, some of them off by rounding."""
        house = ((-2, -2, 0), (2, 2, 3))
        self.path("house.mtl").write_text("newmtl black\nKd 0 0 0\n")
        self.slab(0.3, low=house[0], high=house[1], cells=(8, 8, 6))

        def seen(light, off, ground):
            low, high = [x - (off or 0) for x in house[0]], [x + (off or 0) for x in house[1]]
            corners = [(x, y, z) for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])]
            faces = ((1, 2, 4, 3), (5, 6, 8, 7), (1, 2, 6, 5), (3, 4, 8, 7), (1, 3, 7, 5), (2, 4, 8, 6))
            corners += [(-ground, -ground, -9), (ground, -ground, -9), (0, ground, -9)]
            self.path("house.obj").write_text("mtllib house.mtl\nusemtl black\n" + "".join(f"v {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in corners) +
                                              "".join(f"f {' '.join(map(str, face))}\n" for face in (*faces, (9, 10, 11))))
            parts = {"geometry": [{"file": "house.obj"}]} if off is not None else {}
            _, _, channels, _ = self.picture(self.scene([-1.7, -1.6, 1.4], [2, 1.5, 1.6], lights=[light], fov=70, size=(16, 12),
                                                        smoke={"albedo": [0.9] * 3}, **parts))
            return channels["R"]

        sun = {"kind": "sun", "direction": [0.3, 0.2, -1], "radiance": [3, 3, 3]}
        above = {"kind": "spot", "position": [0.3, 0.2, 4.5], "target": [0, 0, 0], "angle": 100, "intensity": [60, 60, 60]}
        inside = {"kind": "spot", "position": [0.3, 0.2, 2.8], "target": [0, 0, 0], "angle": 360, "intensity": [9, 9, 9]}
        alone = seen(inside, None, 0)
        for off, ground in ((0, 1), (2e-5, 1), (-2e-5, 1), (0, 20000)):
            for light in (sun, above):
                self.assertEqual(max(seen(light, off, ground)), 0, (off, ground))
            for value, open_air in zip(seen(inside, off, ground), alone):
                self.assertAlmostEqual(value / open_air, 1, delta=2e-4)

    def room(self, mode="photometric", extinction=0.2, cells=(20, 20, 15), **parts):
        """Looks from 1 m above at (0.3, 0.4) of the floor, below a lamp at 2 m."""
        self.slab(extinction, low=(-2, -2, 0), high=(2, 2, 3), cells=cells)
        lamp = {"kind": "spot", "position": [0, 0, 2], "target": [0, 0, 0], "angle": 360, "intensity": [10, 5, 0], "edge": 0}
        smoke = {"walls": [0.6, 0.3, 1], "albedo": [0, 0, 0], "mode": mode}
        return self.scene([0.3, 0.4, 1], [0.3, 0.4, 0], fov=0.5, lights=[lamp], smoke=smoke, **parts)

    def test_walls_are_lit_through_smoke(self):
        square = 0.3 ** 2 + 0.4 ** 2 + 4
        surface = 0.6 / math.pi * 10 * 2 / square ** 1.5 * math.exp(-0.2 * math.sqrt(square))
        for mode, share in (("photometric", math.exp(-0.2)), ("threshold", 10 ** (-0.2 / 3))):
            _, _, channels, _ = self.picture(self.room(mode))
            middle = {name: values[4 * 8 + 4] for name, values in channels.items()}
            self.assertAlmostEqual(middle["R"] / (surface * share), 1, delta=1e-3)
            self.assertAlmostEqual(middle["G"] / (surface * share / 4), 1, delta=1e-3)
            self.assertEqual(middle["B"], 0)
        depth = self.value(self.room(), "--aov", "optical-depth", channel="Y")
        self.assertAlmostEqual(depth, 0.2, delta=1e-5)  # up to the floor

    def test_signs_on_walls_and_behind(self):
        pictures.write_planes(self.path("grey.exr"), 1, 1, {"Y": [0.8]})
        for mode, c, share in (("threshold", 8, 10 ** (-0.2 / 8)), ("threshold", 3, 10 ** (-0.2 / 3)),
                               ("photometric", 8, math.exp(-0.2)), ("photometric", 3, math.exp(-0.2))):
            sign = {"position": [0.3, 0.4, 0], "normal": [0, 0, 1], "size": [0.2, 0.2], "picture": "grey.exr", "C": c}
            room = {"mode": mode, "cells": (4, 4, 3), "signs": [sign]}
            self.assertAlmostEqual(self.value(self.room(**room), channel="B"), 0.8 * share, delta=1e-4)
            sign["position"][2] = -0.05  # behind the floor
            self.assertEqual(self.value(self.room(**room), channel="B"), 0)

    def test_light_is_computed_once(self):
        self.slab(0.3, name="a.vtu")
        self.slab(0.31, name="b.vtu")
        self.slab(0.3, name="c.vtu", cells=(5, 2, 3))
        lamp = {"kind": "spot", "position": [5, 0, 0.5], "target": [5, 0, 0], "angle": 120, "intensity": [3, 3, 3]}
        sun = {"kind": "sun", "direction": [0, 0, -1], "radiance": [1, 1, 1]}

        def counts(case, lights):
            scene = self.scene([-3, 0, 0], [5, 0, 0], case=case, lights=lights)
            self.works("render", scene, "-o", self.path("x.exr"), "--cache", self.path("kept"), "--stats", self.path("s.json"))
            found = json.loads(self.path("s.json").read_text())["smoke"]
            return found["lights_computed"], found["lights_reused"]

        self.assertEqual(counts("a.vtu", [lamp, sun]), (2, 0))
        first = self.path("x.exr").read_bytes()
        self.assertEqual(counts("a.vtu", [lamp, sun]), (0, 2))
        self.assertEqual(self.path("x.exr").read_bytes(), first)
        self.assertEqual(counts("b.vtu", [lamp, sun]), (2, 0))  # another field
        self.assertEqual(counts("c.vtu", [lamp, sun]), (2, 0))  # another mesh
        self.assertEqual(counts("a.vtu", [dict(lamp, position=[5, 0, 0.6]), sun]), (1, 1))  # another lamp
        self.assertEqual(counts("a.vtu", [dict(lamp, intensity=[9, 9, 9]), sun]), (0, 2))  # its paths are the same
        self.assertGreater(self.value(self.path("scene.json")), 0)
        for kept in self.path("kept").iterdir():
            kept.write_bytes(kept.read_bytes()[:-3])
        self.assertEqual(counts("a.vtu", [lamp, sun]), (2, 0))  # damaged files are not used
        self.assertEqual(self.path("x.exr").read_bytes(), first)


class Time(SmokeCase):
    def setUp(self):
        super().setUp()
        self.slab(0.1, name="0.vtu")
        self.slab(0.3, name="1.vtu")
        self.slab(0.3, name="2.vtu", cells=(2, 2, 2))
        smoke_files.write_pvd(self.path("case.pvd"), {2: "0.vtu", 4: "1.vtu", 8: "2.vtu"})

    def test_linear_between_steps(self):
        scene = self.scene([-3, 0, 0], [5, 0, 0], case="case.pvd", **WHITE)
        for time, depth in ((0, 1), (2, 1), (2.5, 1.5), (3, 2), (4, 3), (6, 3), (8, 3)):
            self.assertAlmostEqual(self.value(scene, "--time", time), math.exp(-depth), delta=1e-5)
        scene = self.scene([-3, 0, 0], [5, 0, 0], case="case.pvd", smoke={"time": {"offset": 2, "rate": 2}}, **WHITE)
        self.assertAlmostEqual(self.value(scene, "--time", 0.5), math.exp(-2), delta=1e-5)

    def test_a_new_mesh_brings_its_own_light(self):
        lamp = {"kind": "spot", "position": [5, 0, 0.5], "target": [5, 0, 0], "angle": 120, "intensity": [3, 3, 3]}
        scene = self.scene([-3, 0, 0], [5, 0, 0], case="case.pvd", lights=[lamp])

        def counts(time):
            self.works("render", scene, "-o", self.path("x.exr"), "--cache", self.path("kept"), "--time", time, "--stats", self.path("s.json"))
            found = json.loads(self.path("s.json").read_text())["smoke"]
            return found["lights_computed"], found["lights_reused"]

        self.assertEqual(counts(4), (1, 0))  # the step that is shown, and not the first
        self.assertEqual(counts(8), (1, 0))  # the same smoke on another mesh
        self.assertEqual(counts(8), (0, 1))

    def test_stills_are_steps_and_films_run_through_time(self):
        view = ("--eye=-3,0,0", "--target", "5,0,0", "--ortho", "0.2", "--size", "16x16", "--quantity", "extinction")
        self.works("render", self.path("case.pvd"), "-o", self.path("s_%02d.exr"), *view)
        self.assertEqual([n for n in self.files() if n.startswith("s_")], ["s_00.exr", "s_01.exr", "s_02.exr"])
        self.assertAlmostEqual(smoke_files.read_exr(self.path("s_01.exr"))[2]["R"][0], math.exp(-3), delta=1e-5)
        self.works("render", self.path("case.pvd"), "-o", self.path("f.mp4"), *view, "--speed", "2", "--stats", self.path("s.json"))
        stats = json.loads(self.path("s.json").read_text())
        self.assertEqual(stats["pictures"], 76)  # 6 s at twice the speed
        self.assertEqual(stats["smoke"]["steps_read"], 3)
        self.assertIn(b"volute.mode: photometric", self.path("f.mp4").read_bytes())
        self.assertIn("frames 0 to 2", self.fails(2, "render", self.path("case.pvd"), "-o", self.path("x.png"), *view, "--frames", "7:9"))

    def test_frames_have_the_numbers_of_their_files(self):
        for number, extinction in ((5, 1.0), (6, 2.0), (8, 4.0)):
            self.slab(extinction, name=f"n_{number:04d}.vtu")
        smoke_files.write_pvd(self.path("n.pvd"), {0: "n_0005.vtu", 1: "n_0006.vtu", 2: "n_0008.vtu"})
        view = ("--eye=-3,0,0", "--target", "5,0,0", "--ortho", "0.2", "--size", "4x4", "--quantity", "extinction")
        self.works("render", self.path("n.pvd"), "-o", self.path("s_%02d.png"), *view, "--frames", "6:9")
        self.assertEqual([n for n in self.files() if n.startswith("s_")], ["s_06.png", "s_08.png"])
        self.assertIn("the input has frames 5 to 8",
                      self.fails(2, "render", self.path("n.pvd"), "-o", self.path("x.png"), *view, "--frames", "0:3"))
        self.assertIn("whatever the step (2)",
                      self.fails(2, "render", self.path("n.pvd"), "-o", self.path("x.mp4"), *view, "--frames", "5:9:2"))
        self.assertIn("n.pvd has 3 frames from 0 to 2 s",
                      self.fails(2, "render", self.path("n.pvd"), "-o", self.path("x.png"), *view, "--time", "3.5"))


class Together(SmokeCase):
    """Smoke, fire and fog on one ray."""

    def test_fire_in_smoke(self):
        self.slab(0.2)
        support.write_npy(self.path("fire.npy"), (1, 2, 2, 2), [1.0] * 8)  # 1 m wide
        fire = {"kind": "volume", "file": "fire.npy", "emission": 2, "transform": [1, 0, 0, 4, 0, 1, 0, -0.5, 0, 0, 1, -0.5, 0, 0, 0, 1]}
        scene = json.loads(self.scene([-3, 0, 0.01], [5, 0, 0.01]).read_text()) | WHITE
        scene["media"].append(fire)
        self.path("scene.json").write_text(json.dumps(scene))
        expected = 2 * (math.exp(-0.8) - math.exp(-1)) / 0.2 + math.exp(-2)
        for renderer in ("cpu", "reference"):
            self.assertAlmostEqual(self.value(self.path("scene.json"), "--renderer", renderer), expected, delta=1e-5)
        factor = math.log(10) / 3
        expected = 2 * (math.exp(-0.8 * factor) - math.exp(-factor)) / (0.2 * factor) + math.exp(-2 * factor)
        self.assertAlmostEqual(self.value(self.path("scene.json"), "--mode", "threshold"), expected, delta=1e-5)
        depth = self.value(self.path("scene.json"), "--aov", "optical-depth", channel="Y")
        self.assertAlmostEqual(depth, 2, delta=1e-4)

    def test_wide_pictures_use_both_ways(self):
        self.slab(0.2)
        support.write_npy(self.path("fire.npy"), (1, 2, 2, 2), [1.0] * 8)
        fire = {"kind": "volume", "file": "fire.npy", "emission": 2, "transform": [1, 0, 0, 4, 0, 1, 0, -0.5, 0, 0, 1, -0.5, 0, 0, 0, 1]}
        scene = json.loads(self.scene([-3, 0.1, 0.01], [5, 0.2, 0.01], size=(40, 30), fov=40,
                                      lights=[{"kind": "ambient", "radiance": [1, 1, 1]}]).read_text())
        scene["media"].append(fire)
        self.path("scene.json").write_text(json.dumps(scene))
        fast = self.picture(self.path("scene.json"))[2]["G"]
        slow = self.picture(self.path("scene.json"), "--renderer", "reference")[2]["G"]
        for a, b in zip(fast, slow):
            self.assertAlmostEqual(a, b, delta=2e-5)

    def test_fog_and_two_smokes(self):
        self.slab(0.2)
        self.slab(0.1, low=(5, -1, -1), high=(15, 1, 1), name="other.vtu")
        scene = json.loads(self.scene([-3, 0, 0], [5, 0, 0]).read_text()) | WHITE
        scene["media"].append({"kind": "smoke", "case": "other.vtu", "quantity": "extinction"})
        self.path("scene.json").write_text(json.dumps(scene))
        self.assertAlmostEqual(self.value(self.path("scene.json")), math.exp(-3), delta=1e-5)
        pictures.write_planes(self.path("fog.exr"), 4, 4, {"Y": [1.0] * 16})
        scene["media"][1] = {"kind": "fog", "map": "fog.exr", "origin": [-100, -100, -100], "cell": 100, "degree": 0, "sigma_max": 0.01,
                             "color": [1, 0, 0], "profile": {"kind": "slab", "bottom": 0, "top": 1000}}
        self.path("scene.json").write_text(json.dumps(scene))
        reference = self.picture(self.path("scene.json"), "--renderer", "reference")[2]
        fast = self.picture(self.path("scene.json"))[2]
        for channel in "RGB":
            self.assertAlmostEqual(fast[channel][0], reference[channel][0], delta=1e-5)
        self.assertLess(fast["G"][0], math.exp(-2) - 0.01)


class Metadata(SmokeCase):
    def test_every_output_names_its_mode(self):
        self.slab(0.3)
        for mode in ("photometric", "threshold"):
            scene = self.scene([-3, 0, 0], [5, 0, 0], smoke={"mode": mode}, **WHITE)
            self.works("render", scene, "-o", self.path("x.png"), "--stats", self.path("s.json"), "--time", 3)
            texts = smoke_files.png_texts(self.path("x.png"))
            self.assertEqual(texts["volute.mode"], mode)
            self.assertEqual(texts.get("volute.C"), "3" if mode == "threshold" else None)
            self.assertEqual(texts["volute.time"], "3 s")
            self.assertEqual(texts["volute.smoke"], "field 'smoke': extinction [1/m]")  # which has no Km
            self.assertEqual(json.loads(self.path("s.json").read_text())["mode"], mode)
            self.assertEqual(self.picture(scene)[3]["volute.mode"], mode)
            self.assertEqual(self.picture(scene, "--aov", "optical-depth")[3]["volute.shows"], "optical depth (natural logarithm)")

    def test_smoke_says_what_plays_a_part(self):
        self.slab(0.3, rho=1.2)
        for smoke, words in (
                ({"quantity": "soot-density", "unit": "g/m3"}, "soot-density [g/m3], Km = 8700 m2/kg"),
                ({"quantity": "soot-density", "scale": 0.5, "mass_extinction": 7600}, "soot-density [kg/m3], scale 0.5, Km = 7600 m2/kg"),
                ({"quantity": "products-density", "unit": "mg/m3", "soot_yield": 0.1},
                 "products-density [mg/m3], Km = 8700 m2/kg, ys = 0.1"),
                ({"quantity": "products-density", "unit": "g/m3", "smoke_potential": 2}, "products-density [g/m3], P = 2 dB m2/g"),
                ({"quantity": "mass-fraction", "density_field": "rho"}, "mass-fraction [kg/kg], Km = 8700 m2/kg"),
                ({"quantity": "optical-density-db"}, "optical-density-db [dB/m]"),
                ({"quantity": "visibility", "C": 8}, "visibility [m], K = C / S, C = 8")):
            scene = self.scene([-3, 0, 0], [5, 0, 0], smoke=smoke)
            for more in ((), ("--slice", "z=0.1"), ("--isosurface", "10")):
                self.works("render", scene, "-o", self.path("x.png"), *more)
                self.assertEqual(smoke_files.png_texts(self.path("x.png"))["volute.smoke"], "field 'smoke': " + words)

    def test_the_legend_is_drawn_into_pictures(self):
        self.slab(0.0)
        scene = self.scene([-3, 0, 0], [5, 0, 0], size=(320, 200), ortho=1, **WHITE)
        self.works("render", scene, "-o", self.path("plain.png"), "--exposure", "1")
        self.works("render", scene, "-o", self.path("legend.png"), "--exposure", "1", "--legend")
        found = self.works("compare", self.path("plain.png"), self.path("legend.png"), "--json").json
        self.assertGreater(found["max_error"], 0.5)
        for more in (("--exposure", "0.3"), ("--tone", "agx"), ("--bloom", "0.8"), ("--samples", "4"), ("--background", "1,0,0")):
            self.assertIn(more[0], self.fails(2, "render", self.path("slab.vtu"), "-o", self.path("x.png"), *Contours.CASE,
                                              "--slice", "z=0.1", *more))
        for more in (("--legend",), ("--bloom", "0.2"), ("--colormap", "viridis")):
            self.assertIn(f"{more[0]} has no effect: a .exr holds light", self.fails(2, "render", scene, "-o", self.path("x.exr"), *more))


class Contours(SmokeCase):
    """--slice and --isosurface, what programs for CFD draw instead of smoke."""

    VIEW = ("--eye", "5,0,9", "--target", "5,0,0", "--up", "0,1,0", "--ortho", "2", "--size", "8x8")
    CASE = ("--field", "smoke", "--quantity", "extinction")

    def middle(self, value, *more):
        self.slab(value)
        self.works("render", self.path("slab.vtu"), "-o", self.path("x.exr"), *self.VIEW, *self.CASE, *more)
        channels = smoke_files.read_exr(self.path("x.exr"))[2]
        return [channels[c][36] for c in "RGB"]

    def assertColor(self, found, display):
        """As it is displayed."""
        for value, expected in zip(found, display):
            self.assertAlmostEqual(1.055 * value ** (1 / 2.4) - 0.055 if value > 0.0031308 else 12.92 * value, expected, delta=0.03)

    def test_a_slice_shows_the_local_visibility(self):
        self.assertColor(self.middle(0.2, "--slice", "z=0.4"), (0.128, 0.567, 0.551))  # 15 of 30 m
        self.assertColor(self.middle(1e-3, "--slice", "z=0.4"), (0.993, 0.906, 0.144))  # 3 km
        self.assertColor(self.middle(0.2, "--slice", "z=0.4", "--mode", "threshold", "--C", "6"), (0.993, 0.906, 0.144))
        self.assertColor(self.middle(0.2, "--slice", "z=0.4", "--slice-shows", "extinction"), (0.993, 0.906, 0.144))

    def test_contours_take_c_in_every_mode(self):
        clear = (0.993, 0.906, 0.144)
        self.assertColor(self.middle(0.2, "--slice", "z=0.4", "--C", "6"), clear)  # 30 m
        self.assertColor(self.middle(0.2, "--slice", "z=0.4", "--C", "3"), (0.128, 0.567, 0.551))
        mesh = smoke_files.box((0, -1, -1), (10, 1, 1), (10, 2, 2))
        smoke_files.write_vtu(self.path("ramp.vtu"), mesh, {"smoke": [0.1 * p[0] for p in mesh[0]]})
        view = ("--eye", "9.9,0,0", "--target", "0,0,0", "--ortho", "1", "--size", "8x8")
        for c, mode in ((3, ()), (8, ()), (8, ("--mode", "threshold"))):
            # K = C / 10 m at x = C; seen from 9.9 - C m away either way, but where C = 12 there is none.
            self.works("render", self.path("ramp.vtu"), "-o", self.path("x.png"), *view, *self.CASE, "--isosurface", 10, "--C", c, *mode)
            texts = smoke_files.png_texts(self.path("x.png"))
            self.assertEqual((texts["volute.C"], texts["volute.visibility"]), (str(c), "10 m"))
        found = []
        for c in (3, 12):
            self.works("render", self.path("ramp.vtu"), "-o", self.path("x.exr"), *view, *self.CASE, "--isosurface", 10, "--C", c)
            found.append(smoke_files.read_exr(self.path("x.exr"))[2]["G"][36])
        self.assertAlmostEqual(found[0], 0.55, delta=1e-3)  # face on
        self.assertAlmostEqual(found[1], 0.12, delta=1e-3)  # the wall

    def test_a_slice_shows_the_concentration(self):
        case = ("--field", "smoke", "--quantity", "soot-density", "--unit", "g/m3")
        mesh = smoke_files.box((0, -1, -1), (10, 1, 1), (10, 2, 2))
        smoke_files.write_vtu(self.path("ramp.vtu"), mesh, {"smoke": [0.02 * p[0] for p in mesh[0]]})
        self.works("render", self.path("ramp.vtu"), "-o", self.path("x.exr"), *self.VIEW, *case, "--slice", "z=0.4",
                   "--slice-shows", "concentration")
        channels = smoke_files.read_exr(self.path("x.exr"))[2]
        self.assertColor([channels[c][36] for c in "RGB"], (0.80, 0.28, 0.47))  # half of 0.2 g/m3: x = 5 m
        self.works("render", self.path("ramp.vtu"), "-o", self.path("x.png"), *self.VIEW, *case, "--slice", "z=0.4",
                   "--slice-shows", "concentration", "--legend")
        texts = smoke_files.png_texts(self.path("x.png"))
        self.assertEqual(texts["volute.mode"], "slice of concentration")
        self.assertEqual(texts["volute.shows"], "slice: concentration of soot [g/m3], at z = 0.4 m")
        self.assertNotIn("volute.C", texts)
        self.slab(0.2)
        for quantity in ("extinction", "visibility"):
            self.assertIn(f"slab.vtu holds {quantity}, which tells no mass per volume",
                          self.fails(2, "render", self.path("slab.vtu"), "-o", self.path("y.png"), "--quantity", quantity, "--slice",
                                     "z=0.4", "--slice-shows", "concentration"))

    def test_pictures_say_what_they_show(self):
        self.slab(0.2)
        out = ("render", self.path("slab.vtu"), "-o", self.path("x.png"), *self.VIEW, *self.CASE, "--legend")
        self.works(*out, "--slice", "z=0.4")
        common = {"volute.C": "3", "volute.smoke": "field 'smoke': extinction [1/m]", "volute.time": "0 s"}
        self.assertLessEqual(common.items() | {
            "volute.mode": "slice of local visibility",
            "volute.shows": "slice: local visibility S = C/K [m], C = 3, the last colour and more, at z = 0.4 m"}.items(),
            smoke_files.png_texts(self.path("x.png")).items())
        self.works(*out, "--isosurface", "10", "--stats", self.path("s.json"))
        self.assertLessEqual(common.items() | {
            "volute.mode": "isosurface of local visibility", "volute.visibility": "10 m",
            "volute.shows": "isosurface: local visibility S = C/K = 10 m, C = 3"}.items(),
            smoke_files.png_texts(self.path("x.png")).items())
        self.assertEqual(json.loads(self.path("s.json").read_text())["mode"], "isosurface of local visibility")
        self.works(*out, "--slice", "z=0.4", "--slice-shows", "extinction")
        texts = smoke_files.png_texts(self.path("x.png"))
        self.assertEqual((texts["volute.mode"], texts.get("volute.C")), ("slice of extinction", None))

    def test_what_is_wrong(self):
        self.slab(0.2)
        out = ("render", self.path("slab.vtu"), "-o", self.path("x.png"), *self.CASE)
        for words in (("--slice", "1.8"), ("--slice", "w=1"), ("--slice", "z=1", "--isosurface", "10"),
                      ("--slice", "z=1", "--aov", "transmittance"), ("--isosurface", "0"), ("--slice-shows", "extinction")):
            self.assertIn(words[0], self.fails(2, *out, *words))
        self.assertFalse(self.path("x.png").exists())
        self.make_volute()
        self.assertIn("--slice: is for media on a mesh", self.fails(2, "render", self.path("in.volute"), "-o", self.path("x.png"), "--slice", "z=0"))


if __name__ == "__main__":
    support.main()
