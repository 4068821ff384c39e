# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Scenes with opaque geometry: lit surfaces, media that end at them, shadows in fog, billboards."""
import json
import math
import struct

import support
from pictures import Picture, read_exr, write_planes, write_png
from support import write_npy


def obj(*quads):
    """Quadrilaterals of four corners each."""
    lines = [f"v {x} {y} {z}" for quad in quads for x, y, z in quad]
    lines += [f"f {4 * i + 1} {4 * i + 2} {4 * i + 3} {4 * i + 4}" for i in range(len(quads))]
    return "\n".join(lines) + "\n"


def floor(z=0.0, half=50.0):
    return [(-half, -half, z), (half, -half, z), (half, half, z), (-half, half, z)]


def glb(points, material=None):
    """A triangle that glows green."""
    return glb_of(b"".join(struct.pack("<3f", *point) for point in points), material=material)


def glb_of(binary, view=None, accessor=None, scale=1, material=None):
    size = len(binary)
    quantized = {"extensionsRequired": ["KHR_mesh_quantization"]} if accessor else {}
    text = json.dumps(quantized | {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "scale": [scale] * 3}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "materials": [material or {"emissiveFactor": [0, 1, 0]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"} | (accessor or {})],
        "bufferViews": [{"buffer": 0, "byteLength": size} | (view or {})], "buffers": [{"byteLength": size}]}).encode()
    text += b" " * (-len(text) % 4)
    padded = binary + b"\0" * (-size % 4)
    return (struct.pack("<4sIIII", b"glTF", 2, 28 + len(text) + len(padded), len(text), 0x4E4F534A) + text +
            struct.pack("<II", len(padded), 0x004E4942) + padded)


class Geometry(support.TestCase):
    def setUp(self):
        super().setUp()
        self.path("floor.obj").write_text(obj(floor()))
        self.scene = {"format": "volute-scene-1", "background": [9, 9, 9],
                      "camera": {"eye": [0, 0, 10], "target": [0, 0, 0], "up": [0, 1, 0], "ortho": 8, "size": [8, 8]},
                      "geometry": [{"file": "floor.obj"}]}

    def render(self, *more, name="x.exr"):
        self.path("scene.json").write_text(json.dumps(self.scene))
        self.works("render", self.path("scene.json"), "-o", self.path(name), *more)
        return read_exr(self.path(name))

    def wrong(self, where, **change):
        self.path("scene.json").write_text(json.dumps(self.scene | change))
        message = self.fails(1, "render", self.path("scene.json"), "-o", self.path("y.png"))
        self.assertIn(where, message)

    def fog(self, sigma, top, **more):
        write_png(self.path("map.png"), Picture(60, 60, 1, [1.0] * 3600))
        return {"kind": "fog", "map": "map.png", "origin": [-30, -30, 0], "cell": 1, "sigma_max": sigma, "degree": 0,
                "profile": {"kind": "slab", "bottom": 0, "top": top}, "color": [0, 0, 0]} | more

    def test_sun_and_ambient_light_by_lambert(self):
        self.scene["lights"] = [{"kind": "sun", "direction": [0, 1, -1], "radiance": [2, 4, 6]},
                                {"kind": "ambient", "radiance": [0.5, 0, 0]}]
        picture = self.render()
        light = math.sqrt(0.5) / math.pi
        for c, expected in enumerate((2 * light + 0.5, 4 * light, 6 * light)):
            self.assertAlmostEqual(picture.at(3, 3, c), 0.8 * expected, places=6)

    def test_spots_shine_down(self):
        self.scene["lights"] = [{"kind": "spot", "position": [0, 0, 4], "target": [0, 0, 0], "angle": 60,
                                 "intensity": [16, 16, 16]}]
        picture = self.render("--size", "9x9")
        self.assertAlmostEqual(picture.at(4, 4), 0.8 / math.pi, places=6)
        self.assertEqual(picture.at(0, 0), 0)

    def test_surfaces_cast_shadows(self):
        self.path("roof.obj").write_text(obj([(0, -50, 3), (50, -50, 3), (50, 50, 3), (0, 50, 3)]))
        self.scene["geometry"].append({"file": "roof.obj"})
        self.scene["camera"] = {"eye": [0, 0, 2], "target": [0, 0, 0], "up": [0, 1, 0], "fov": 90, "size": [8, 8]}
        self.scene["lights"] = [{"kind": "sun", "direction": [0, 0, -1], "radiance": [1, 1, 1]}]
        picture = self.render()
        for x in range(8):
            self.assertAlmostEqual(picture.at(x, 4), 0.8 / math.pi if x < 4 else 0, places=6)

    def test_transforms_move_geometry_and_mirrors_keep_it(self):
        self.path("tri.glb").write_bytes(glb([(1, 0, 0), (3, 0, 0), (1, 2, 0)]))
        self.scene["geometry"] = [{"file": "tri.glb"}]
        picture = self.render()
        self.assertEqual((picture.at(5, 3, 0), picture.at(5, 3, 1)), (0, 1))
        self.assertEqual(picture.at(2, 3), 9)
        self.scene["geometry"][0]["transform"] = [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
        picture = self.render()
        self.assertEqual(picture.at(5, 3), 9)
        self.assertEqual(picture.at(2, 3, 1), 1)

    def test_unlit_materials_have_their_colour_in_any_light(self):
        self.path("tri.glb").write_bytes(glb([(-9, -9, 0), (9, -9, 0), (0, 9, 0)], material={
            "pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.4, 0.2, 1]}, "emissiveFactor": [1, 1, 1],
            "extensions": {"KHR_materials_unlit": {}}}))
        self.scene |= {"geometry": [{"file": "tri.glb"}], "lights": [{"kind": "ambient", "radiance": [0.1, 0.1, 0.1]}]}
        picture = self.render()
        for c, expected in enumerate((0.8, 0.4, 0.2)):
            self.assertAlmostEqual(picture.at(4, 4, c), expected, places=6)

    def test_quantized_positions_are_read(self):
        triangle = [(-1, 0, 0), (1, 0, 0), (0, 1, 0)]
        for kind, form, largest, normalized in ((5122, "h", 32767, True), (5120, "b", 127, True), (5122, "h", 200, False)):
            binary = b"".join(struct.pack(f"<4{form}", *(round(largest * x) for x in point), 0) for point in triangle)
            self.path("small.glb").write_bytes(glb_of(binary, {"byteStride": len(binary) // 3}, {"componentType": kind, "normalized": normalized},
                                                      scale=4 / (1 if normalized else largest)))
            self.path("tri.glb").write_bytes(glb([(-4, 0, 0), (4, 0, 0), (0, 4, 0)]))
            seen = []
            for name in ("small.glb", "tri.glb"):
                self.scene["geometry"] = [{"file": name}]
                seen.append(self.render().values)
            self.assertEqual(*seen)
            self.assertGreater(len(set(seen[0])), 1)

    def test_up_y_turns_the_file(self):
        # Upright in a file whose y is up: seen from above it is a line, from the front a triangle.
        self.path("tri.glb").write_bytes(glb([(-2, 0, 0), (2, 0, 0), (0, 4, 0)]))
        self.scene["geometry"] = [{"file": "tri.glb", "up": "y"}]
        self.scene["camera"] = {"eye": [0, -9, 2], "target": [0, 0, 2], "ortho": 8, "size": [8, 8]}
        picture = self.render()
        self.assertEqual(picture.at(4, 4, 0), 0)
        self.assertEqual(picture.at(4, 0, 0), 9)

    def test_materials_are_in_a_file_with_blanks_in_its_name(self):
        self.path("my floor.mtl").write_text("newmtl red\nKd 0.8 0.1 0.1\n")
        for library in ("my floor.mtl", "of another.mtl"):
            self.path("floor.obj").write_text(f"mtllib {library}\nusemtl red\n" + obj(floor()))
            self.path("scene.json").write_text(json.dumps(self.scene))
            result = self.works("render", self.path("scene.json"), "-o", self.path("o.exr"))
            self.assertEqual("the material 'red' is in" in result.message, library != "my floor.mtl", result.message)

    def test_geometry_alone_is_no_volume(self):
        for command in (("info",), ("render", "-o", self.path("o.exr"))):
            self.assertIn('is geometry, not a volume; expected it in a scene, as its "geometry"',
                          self.fails(1, command[0], self.path("floor.obj"), *command[1:]))

    def test_gltf_has_y_upwards(self):
        self.path("tri.glb").write_bytes(glb([(-2, 0, 0), (2, 0, 0), (0, 4, 0)]))
        self.scene["camera"] = {"eye": [0, -9, 2], "target": [0, 0, 2], "ortho": 8, "size": [8, 8]}
        for version, upright in ((2, True), (1, False)):
            self.scene["format"] = f"volute-scene-{version}"
            for up, seen in ((None, upright), ("y", True), ("z", False), ("format", True)):
                self.scene["geometry"] = [{"file": "tri.glb"} | ({"up": up} if up else {})]
                self.assertEqual(self.render().at(4, 4, 0), 0 if seen else 9, (version, up))

    def test_geometry_that_shadows_no_fog_is_remarked_upon(self):
        write_png(self.path("map.png"), Picture(60, 60, 1, [1.0] * 3600))
        write_planes(self.path("color.exr"), 8, 6, {name: [0.2] * 48 for name in "RGB"})
        write_planes(self.path("depth.exr"), 8, 6, {"Z": [1e10] * 48})
        self.path("camera.json").write_text(json.dumps({"eye": [0, -80, 5], "target": [0, 0, 5], "fov": 40}))
        self.path("wall.glb").write_bytes(glb([(-20, 0, 0), (20, 0, 0), (0, 40, 0)]))
        words = ("fog", self.path("map.png"), "--color", self.path("color.exr"), "--depth", self.path("depth.exr"), "--camera",
                 self.path("camera.json"), "--origin=-30,-30,0", "--profile", "slab:0,20", "--sun=-0.5,0.5,-0.7", "--depth-kind", "z",
                 "-o", self.path("x.exr"), "--geometry", self.path("wall.glb"))
        self.assertNotIn("shadows none", self.works(*words).message)
        upright = read_exr(self.path("x.exr")).values
        self.assertNotIn("shadows none", self.works(*words, "--geometry-up", "y").message)
        self.assertEqual(read_exr(self.path("x.exr")).values, upright)
        self.assertIn("wall.glb: shadows none of the fog", self.works(*words, "--geometry-up", "z").message)
        self.assertNotEqual(read_exr(self.path("x.exr")).values, upright)
        self.scene["media"] = [self.fog(0.1, 20)]
        self.scene["lights"] = [{"kind": "sun", "direction": [0, 0, -1], "radiance": [1, 1, 1]}]
        self.path("scene.json").write_text(json.dumps(self.scene))
        said = self.works("render", self.path("scene.json"), "-o", self.path("x.exr")).message
        self.assertIn("geometry shadows none of this fog", said)  # it lies on the ground

    def test_media_end_at_surfaces_and_take_from_the_light(self):
        self.scene["media"] = [self.fog(0.1, 4)]
        self.scene["lights"] = [{"kind": "sun", "direction": [0, 0, -1], "radiance": [1, 1, 1]}]
        self.scene["media"][0]["albedo"] = [0, 0, 0]
        self.path("scene.json").write_text(json.dumps(self.scene))
        depth = self.render("--aov", "optical-depth", name="depth.exr")
        self.assertAlmostEqual(depth.at(4, 4), 0.4, places=5)
        # Down through the fog and back up.
        self.assertAlmostEqual(self.render().at(4, 4), 0.8 / math.pi * math.exp(-0.8), places=5)
        self.scene["geometry"] = [{"file": "floor.obj", "transform": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 3, 0, 0, 0, 1]}]
        self.assertAlmostEqual(self.render("--aov", "optical-depth").at(4, 4), 0.1, places=5)
        self.assertAlmostEqual(self.render("--aov", "transmittance").at(4, 4), math.exp(-0.1), places=5)

    def test_a_clip_leaves_shadows_as_they_are(self):
        # The sun comes through all of the fog; what is clipped is not seen on the way back.
        self.scene |= {"format": "volute-scene-2", "media": [self.fog(0.1, 4, albedo=[0, 0, 0])],
                       "lights": [{"kind": "sun", "direction": [0, 0, -1], "radiance": [1, 1, 1]}]}
        for clip, shown in (([], 0.4), ([{"kind": "plane", "point": [0, 0, 1], "normal": [0, 0, 1]}], 0.1),
                            ([{"kind": "box", "min": [40, 40, 5], "max": [41, 41, 6]}], 0)):
            self.scene["clip"] = clip
            for renderer in ("cpu", "reference"):
                picture = self.render("--renderer", renderer)
                self.assertAlmostEqual(picture.at(4, 4), 0.8 / math.pi * math.exp(-0.4 - shown), places=5)

    def test_a_roof_shades_a_volume_on_any_ground(self):
        write_npy(self.path("block.npy"), (1, 4, 4, 4), [1.0] * 64)
        self.scene |= {"format": "volute-scene-2", "background": [0, 0, 0],
                       "lights": [{"kind": "spot", "position": [0, 0, 2], "target": [0, 0, 0], "angle": 60, "intensity": [9, 9, 9]}]}
        for half, place in ((5, (0, 0)), (20000, (0, 0)), (5, (500000, 5700000))):
            self.path("floor.obj").write_text(obj(floor(-0.5, half), [(-1, -1, 1.9), (1, -1, 1.9), (1, 1, 1.9), (-1, 1, 1.9)]))
            moved = [1, 0, 0, place[0], 0, 1, 0, place[1], 0, 0, 1, 0, 0, 0, 0, 1]
            self.scene |= {"camera": {"eye": [place[0], place[1] - 9, 0.5], "target": [*place, 0.5], "ortho": 0.5, "size": [4, 4]},
                           "media": [{"kind": "volume", "file": "block.npy", "bounds": [[-0.5, -0.5, 0], [0.5, 0.5, 1]],
                                      "extinction": 1, "emission": 0, "albedo": [1, 1, 1], "transform": moved}]}
            self.scene["lights"][0] |= {"position": [*place, 2], "target": [*place, 0]}
            for roof in (True, False):
                self.scene["geometry"] = [{"file": "floor.obj", "transform": moved}] if roof else []
                picture = self.render("--renderer", "cpu")
                self.assertEqual(max(picture.values) > 0, not roof, (half, place))

    def test_geometry_shadows_the_sun_in_the_fog(self):
        """A roof over half of thin fog, seen from the side: lit and dark parts of a ray, in closed form."""
        self.path("roof.obj").write_text(obj([(0, -50, 8), (50, -50, 8), (50, 50, 8), (0, 50, 8)]))
        self.scene |= {"geometry": [{"file": "roof.obj"}], "background": [0, 0, 0],
                       "lights": [{"kind": "sun", "direction": [0, 0, -1], "radiance": [1, 1, 1]}],
                       "camera": {"eye": [-20, 0, 1], "target": [0, 0, 1], "ortho": 0.5, "size": [2, 2]},
                       "media": [self.fog(0.05, 2)]}
        # Along x from -30 to 30 at heights 0.875 and 1.125; dark from x = 0 on.
        picture = self.render()
        for row, height in ((0, 1.125), (1, 0.875)):
            expected = (1 - math.exp(-0.05 * 30)) * math.exp(-0.05 * (2 - height)) / (4 * math.pi)
            self.assertAlmostEqual(picture.at(0, row) / expected, 1, places=3)
        reference = self.render("--renderer", "reference")
        self.assertAlmostEqual(reference.at(0, 0) / picture.at(0, 0), 1, places=3)

    def test_volumes_turn(self):
        # Brighter along x: two voxels of 0.5 m.
        write_npy(self.path("two.npy"), (1, 1, 1, 2), [1.0, 3.0])
        self.scene |= {"geometry": [], "background": [0, 0, 0],
                       "media": [{"kind": "volume", "file": "two.npy",
                                  "transform": [0, -1, 0, 0.25, 1, 0, 0, -0.5, 0, 0, 1, 0, 0, 0, 0, 1]}],
                       "camera": {"eye": [0, -5, 0.25], "target": [0, 0, 0.25], "ortho": 0.1, "size": [1, 1]}}
        # Seen along +y, which was x: 0.5 m of 1 and 0.5 m of 3.
        self.assertAlmostEqual(self.render("--basis", "box").at(0, 0), 2, places=5)
        self.scene["media"][0]["transform"] = [1, 0, 0.5, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
        self.wrong("/media/0/transform: shears")

    def test_billboards_show_the_volume(self):
        write_npy(self.path("block.npy"), (1, 4, 4, 4), [0.25] * 64)
        self.scene |= {"geometry": [], "background": [0, 0, 0],
                       "billboards": [{"volume": "block.npy", "position": [5, 30, 2], "size": [3, 3]}],
                       "camera": {"eye": [5, 0, 2], "target": [5, 30, 2], "fov": 2, "size": [3, 3]}}
        self.assertAlmostEqual(self.render().at(1, 1), 0.25, places=5)
        self.scene["geometry"] = [{"file": "floor.obj", "transform": [1, 0, 0, 0, 0, 0, 1, 20, 0, 1, 0, 0, 0, 0, 0, 1]}]
        self.assertEqual(self.render().at(1, 1), 0)  # a black wall before it

    def test_stats_count_surfaces(self):
        self.scene["lights"] = [{"kind": "sun", "direction": [0, 0, -1], "radiance": [1, 1, 1]}]
        self.render("--stats", self.path("stats.json"))
        stats = json.loads(self.path("stats.json").read_text())
        self.assertEqual(stats["geometry"], {"triangles": 2, "surface_pixels": 64, "shadow_rays": 64})
        self.assertIn("surfaces", stats["milliseconds"])

    def test_errors_name_the_place(self):
        self.wrong("/geometry: expected a list", geometry={})
        self.wrong("/geometry/0/file", geometry=[{}])
        self.wrong("'" + str(self.path("a.fbx")), geometry=[{"file": "a.fbx"}])
        self.wrong("none.obj", geometry=[{"file": "none.obj"}])
        self.wrong("did you mean 'transform'", geometry=[{"file": "floor.obj", "transfrom": []}])
        self.wrong("/geometry/0/transform: expected 16", geometry=[{"file": "floor.obj", "transform": [1]}])
        self.wrong("/geometry/0/transform: makes everything flat",
                   geometry=[{"file": "floor.obj", "transform": [0] * 15 + [1]}])
        self.wrong("did you mean 'geometry'", geometri=[])
        self.wrong("/billboards/0/size", billboards=[{"volume": "x.npy", "position": [0, 0, 0], "size": [1]}])
        self.path("bad.glb").write_bytes(b"glTF\2\0\0\0")
        self.wrong("bad.glb: not a whole glTF", geometry=[{"file": "bad.glb"}])


if __name__ == "__main__":
    support.main()
