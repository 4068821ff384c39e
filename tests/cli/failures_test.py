# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Wrong inputs: one sentence with what, where and what was expected; and never a target."""
import math
import os
import pathlib
import re
import resource
import shutil
import signal
import socket
import subprocess
import unittest

import support
from support import volute, write_npy


class Failures(support.TestCase):
    def compress_fails(self, source, *more, **options):
        return self.fails(1, "compress", source, "-o", self.path("x.volute"), "--rms", "0.01", *more, **options)

    def test_missing_input_names_it(self):
        for command in (["info", self.path("no.npy")], ["info", self.path("no.volute")],
                        ["extract", self.path("no.volute"), "-o", self.path("x.npy")],
                        ["render", self.path("no.volute"), "-o", self.path("x.png")],
                        ["compare", self.path("no.npy"), self.path("no.npy")]):
            self.assertIn("no.", self.fails(1, *command))
        self.assertIn("no.npy", self.compress_fails(self.path("no.npy")))

    def test_a_plug_in_of_another_build_is_said_to_be_one(self):
        build = pathlib.Path(support.PROGRAM).resolve().parent.parent
        header, plugin = build / "generated/volute/io/plugin_interface.hpp", build / "lib/volute/volute_io_vdb.so"
        if not header.exists() or not plugin.exists():
            self.skipTest("an installed program, or none with OpenVDB")
        self.works("synthesize", "flame", "-o", self.path("s.vdb"), "--size", "16", "--frames", "1")
        stamp = re.search(r'kPluginInterface\[\] = "(\w+)"', header.read_text()).group(1).encode() + b"\0"
        whole = plugin.read_bytes()
        self.assertIn(stamp, whole)
        for folder in ("bin", "lib/volute"):
            self.path(folder).mkdir(parents=True)
        shutil.copy2(support.PROGRAM, self.path("bin/volute"))  # plug-ins are looked for beside it
        self.path("lib/volute/volute_io_vdb.so").write_bytes(whole.replace(stamp, b"0123456789ab\0"))
        done = subprocess.run([self.path("bin/volute"), "info", self.path("s.vdb")], capture_output=True, text=True)
        self.assertEqual(done.returncode, 1)
        self.assertIn("built with another Volute", done.stderr)
        self.assertNotIn("damaged", done.stderr)

    def test_not_finite_values_are_named_by_frame_and_voxel(self):
        for bad in (math.nan, math.inf, -math.inf):
            values = [0.0] * 48
            values[24 + 3 * 4 + 1 * 4 + 2] = bad  # frame 1; shape (2, 2, 3, 4): z 1, y 1, x 2
            write_npy(self.path("bad.npy"), (2, 2, 3, 4), values)
            message = self.compress_fails(self.path("bad.npy"))
            self.assertIn("frame 1", message)
            self.assertRegex(message, r"2, (y )?1, (z )?1|x = 2, y = 1, z = 1")

    def test_empty_sequences(self):
        write_npy(self.path("empty.npy"), (0, 4, 4, 4), [])
        self.assertIn("empty.npy", self.compress_fails(self.path("empty.npy")))
        self.path("folder").mkdir()
        self.assertIn("folder", self.compress_fails(self.path("folder")))
        self.assertIn("s_%04d.vdb", self.compress_fails(self.path("s_%04d.vdb")))
        message = self.fails(2, "compress", self.make_npy(), "-o", self.path("x.volute"), "--rms", "1", "--frames", "7:9")
        self.assertIn("frames 0 to 2", message)

    def test_damaged_npy(self):
        whole = self.make_npy(frames=2, size=4).read_bytes()
        for length in (0, 5, 9, 60, len(whole) - 1):
            self.path("cut.npy").write_bytes(whole[:length])
            self.assertIn("cut.npy", self.compress_fails(self.path("cut.npy")))
        self.path("long.npy").write_bytes(whole + b"x")
        self.compress_fails(self.path("long.npy"))
        for old, new in ((b"<f4", b"<c8"), (b"<f4", b"|O4"), (b"<f4", b"<U4"), (b"(2, 4,", b"(9, 9,"), (b"(2, 4,", b"(-2,4,")):
            self.path("odd.npy").write_bytes(whole.replace(old, new, 1))
            self.assertIn("odd.npy", self.compress_fails(self.path("odd.npy")))

    def test_sizes_that_do_not_match(self):
        self.make_npy("a.npy", size=6)
        self.make_npy("b.npy", size=7)
        message = self.fails(1, "compare", self.path("a.npy"), self.path("b.npy"))
        self.assertIn("6 x 6 x 6", message)
        self.assertIn("7 x 7 x 7", message)

    def test_frames_of_different_sizes(self):
        for number, size in enumerate((16, 24)):
            made = volute("synthesize", "flame", "-o", self.path(f"s_000{number}.vti"), "--size", size, "--frames", "1")
            if "this build has no" in made.message:
                self.skipTest(made.message)
            self.assertEqual(made.code, 0, made.message)
        self.works("compress", self.path("s_%04d.vti"), "-o", self.path("x.volute"), "--rms", "0.01")  # each frame in its place
        self.assertEqual(self.works("info", self.path("x.volute"), "--json").json["size"], [24, 24, 24])
        self.assertIn("expected whole .vdb files", self.fails(1, "extract", self.path("x.volute"), "-o", self.path("y_%04d.vti")))

    def test_wrong_grid_lists_those_there_are(self):
        made = volute("synthesize", "flame", "-o", self.path("s.vdb"), "--size", "16", "--frames", "1")
        if "this build has no" in made.message:
            self.skipTest(made.message)
        self.assertEqual(made.code, 0, made.message)
        grid = self.works("info", self.path("s.vdb"), "--json").json["grid"]
        self.assertIn(f"it has {grid}", self.compress_fails(self.path("s.vdb"), "--grid", "nothing"))
        self.assertIn("nothing", self.fails(1, "compress", self.make_volute(), "-o", self.path("x.volute"), "--rms", "1",
                                            "--grid", "nothing"))

    def test_too_little_memory(self):
        self.assertIn("memory", self.compress_fails(self.make_npy(size=16), "--max-memory", "1K"))
        packed = self.make_volute(size=16)
        self.assertNotIn("so does .vdb", self.fails(1, "extract", packed, "-o", self.path("x.npy"), "--max-memory", "1K"))
        text = self.fails(1, "extract", packed, "-o", self.path("x.vdb"), "--frames", 0, "--max-memory", "20K")
        self.assertIn("the voxels of a frame need", text)
        self.assertNotIn("--region", text)
        self.fails(1, "render", packed, "-o", self.path("x.png"), "--max-memory", "1K")
        self.assertIn("pixels", self.fails(1, "render", packed, "-o", self.path("x.png"), "--size", "20000x20000"))

    def test_targets_that_cannot_be_written(self):
        source, packed = self.make_npy(), self.make_volute()
        self.path("folder.volute").mkdir()
        for target in (self.path("missing/x.volute"), self.path("folder.volute"), "/proc/x.volute"):
            message = self.fails(1, "compress", source, "-o", target, "--rms", "0.01")
            self.assertIn(str(target), message)
        self.assertIn("/dev/null", self.fails(1, "extract", packed, "-o", "/dev/null"))
        self.fails(1, "render", packed, "-o", self.path("missing/x.png"))

    @unittest.skipIf(os.geteuid() == 0, "root may write anywhere")
    def test_folder_without_permission(self):
        source, packed = self.make_npy(), self.make_volute()
        locked = self.path("locked")
        locked.mkdir(mode=0o555)
        self.fails(1, "compress", source, "-o", locked / "x.volute", "--rms", "0.01")
        self.fails(1, "extract", packed, "-o", locked / "x.npy")
        self.assertEqual(list(locked.iterdir()), [])

    def test_full_disk(self):
        source, packed = self.make_npy(frames=16, size=16), self.make_volute(frames=16, size=16)

        def small_files():  # as a full disk does, it lets a write fail half-way
            resource.setrlimit(resource.RLIMIT_FSIZE, (512, 512))

        self.fails(1, "compress", source, "-o", self.path("x.volute"), "--max-error", "0.001", preexec_fn=small_files)
        self.fails(1, "extract", packed, "-o", self.path("x.npy"), preexec_fn=small_files)
        self.fails(1, "render", packed, "-o", self.path("x.png"), preexec_fn=small_files)
        self.fails(1, "render", packed, "-o", self.path("x.exr"), preexec_fn=small_files)
        for end in ("nc", "h5"):
            said = self.fails(1, "extract", packed, "-o", self.path(f"x.{end}"), preexec_fn=small_files)
            self.assertRegex(said, "File too large|this build has no")

    def test_a_limit_on_files_is_no_lack_of_memory(self):
        """What a reading process hands over is memory that is shared as a file."""
        self.works("synthesize", "hall", "-o", self.path("hall.pvd"), "--cell", "0.5", "--frames", 1)

        def small_files():
            resource.setrlimit(resource.RLIMIT_FSIZE, (512, 512))

        said = self.fails(1, "info", self.path("hall.pvd"), "--values", preexec_fn=small_files)
        self.assertIn("MiB of values: the limit on the size of files (ulimit -f) holds for the memory that two processes share, too", said)

    def test_meshes_of_other_formats_are_told_as_such(self):
        for name in ("x.cgns", "mb.vtm"):
            self.path(name).write_text("<VTKFile/>")
            for words in (("info",), ("render", "-o", self.path("x.png")), ("render", "-o", self.path("x.png"), "--quantity", "extinction"),
                          ("compress", "-o", self.path("x.volute"))):
                said = self.fails(1, words[0], self.path(name), *words[1:])
                self.assertIn(f"{name}: is a mesh in a format that is not read; expected .vtu, .pvtu", said)

    def test_targets_out_of_reach(self):
        source = self.make_npy()
        for target in (["--size", "10"], ["--ratio", "1e9"], ["--rms", "1e-12"]):
            self.assertIn("x.volute", self.fails(1, "compress", source, "-o", self.path("x.volute"), *target))

    def test_an_old_target_survives_a_failure(self):
        self.path("x.volute").write_bytes(b"old")
        write_npy(self.path("bad.npy"), (1, 1, 1, 1), [math.nan])
        self.compress_fails(self.path("bad.npy"))
        self.assertEqual(self.path("x.volute").read_bytes(), b"old")

    def test_pipes_sockets_and_devices_are_refused_at_once(self):
        foam = self.path("hall")
        for folder in ("constant/polyMesh", "system", "0"):
            (foam / folder).mkdir(parents=True)
        (foam / "hall.foam").touch()
        os.mkfifo(foam / "system/controlDict")
        names = ["a.npy", "a.vdb", "a.vti", "a.pvd", "a.volute", "a.smv", "a.vtu", "a.pvtu", "a.vtk", "a.case", "a.e", "a.png",
                 "a.exr", "a.json"]
        for name in names:
            os.mkfifo(self.path(name))
        listening = socket.socket(socket.AF_UNIX)
        self.addCleanup(listening.close)
        listening.bind(str(self.path("s.vtu")))
        self.path("zero.npy").symlink_to("/dev/zero")
        self.path("zero.json").symlink_to("/dev/zero")
        out = ("-o", self.path("x.png"), "--size", "4x4")
        meshes = ["a.vtu", "a.pvtu", "a.vtk", "a.case", "a.e", "s.vtu"]
        commands = [["info", self.path(name)] for name in names + ["s.vtu", "zero.npy"]]
        commands += [["render", self.path(name), *out, *(["--quantity", "extinction"] if name in meshes else [])]
                     for name in names + ["s.vtu", "zero.npy", "zero.json"] if name not in ("a.png", "a.exr")]
        commands += [["info", foam / "hall.foam"]]
        commands += [["visibility", self.path(name), "--signs", self.path("a.json"), "-o", self.path("out")]
                     for name in ("a.smv", "a.vtu")]
        commands += [["compress", self.path(name), "-o", self.path("x.volute"), "--rms", "0.1"]
                     for name in ("a.npy", "a.vdb", "a.vti", "a.pvd", "a.volute", "zero.npy")]
        commands += [["render", self.make_npy(), *out, "--camera", self.path("a.json")],
                     ["compare", self.path("a.npy"), self.path("a.npy")], ["compare", self.path("a.png"), self.path("a.png")],
                     ["reconstruct", self.path("a.json"), "-o", self.path("y.volute")]]
        for words in commands:
            with self.subTest(words=[str(word) for word in words]):
                done = volute(*words, timeout=60)
                self.assertIn(done.code, (1, 2), done.message)
                self.assertRegex(done.message + done.text, "a pipe|a socket|a device|pipe; expected|no known|not a known")

    def test_json_of_any_depth_is_refused(self):
        for brackets in ("[" * 25000, "[" * 25000 + "]" * 25000, '{"a":' * 25000 + "1" + "}" * 25000):
            self.path("deep.json").write_text('{"format": "volute-scene-1", "media": ' + brackets + "}")
            for words in (["render", self.path("deep.json"), "-o", self.path("x.png")],
                          ["reconstruct", self.path("deep.json"), "-o", self.path("x.npy")],
                          ["render", self.make_npy(), "-o", self.path("x.png"), "--camera", self.path("deep.json")]):
                self.assertIn("more than 64 deep", self.fails(1, *words))
        for name, data in (("deep.gltf", b'{"asset": {"version": "2.0"}, "extras": ' + b"[" * 25000 + b"]" * 25000 + b"}"),):
            self.path(name).write_bytes(data)
            self.path("scene.json").write_text(
                '{"format": "volute-scene-1", "camera": {"eye": [0, -3, 0], "target": [0, 0, 0], "fov": 40}, '
                '"geometry": [{"file": "deep.gltf"}]}')
            self.assertRegex(self.fails(1, "render", self.path("scene.json"), "-o", self.path("x.png")),
                             "more than 64 deep|this build has no")

    def write_vti(self, name, *arrays):
        cells = "".join(f'<DataArray type="Float32" Name="{array}" format="ascii">1 2 3 4 5 6 7 8</DataArray>' for array in arrays)
        self.path(name).write_text(
            '<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian"><ImageData WholeExtent="0 2 0 2 0 2" '
            'Origin="0 0 0" Spacing="1 1 1"><Piece Extent="0 2 0 2 0 2"><CellData>' + cells +
            "</CellData></Piece></ImageData></VTKFile>\n")
        made = volute("info", self.path(name))
        if "this build has no" in made.message:
            self.skipTest(made.message)
        return self.path(name)

    def test_gaps_in_numbered_frames_are_told(self):
        for number in (0, 1, 2, 4, 5, 8, 9):
            self.write_vti(f"s_{number:04d}.vti", "density")
        words = "3 of the frames 0 to 9 are missing: 3, 6 to 7"
        said = self.works("info", self.path("s_%04d.vti"), "--json").json
        self.assertEqual(said["missing_frames"], [[3, 3], [6, 7]])
        self.assertIn(words, self.works("info", self.path("s_%04d.vti")).text)
        self.assertIn(words, self.works("compress", self.path("s_%04d.vti"), "-o", self.path("x.volute"), "--rms", "0.1").message)
        self.assertIn(words, self.works("render", self.path("s_%04d.vti"), "-o", self.path("x.png"), "--size", "4x4").message)

    def test_the_grid_that_is_taken_is_named(self):
        source = self.write_vti("three.vti", "heat", "density", "fuel")
        made = self.works("compress", source, "-o", self.path("x.volute"), "--rms", "0.1")
        self.assertIn("the grid 'density' is read; it also has heat, fuel; choose one with --field", made.message)
        chosen = self.works("compress", source, "-o", self.path("x.volute"), "--rms", "0.1", "--grid", "heat")
        self.assertNotIn("also has", chosen.message)

    def test_a_closed_pipe_is_no_crash(self):
        packed = self.make_volute()
        reader, writer = os.pipe()
        os.close(reader)
        result = volute("extract", packed, "-o", "-", stdout=writer)
        os.close(writer)
        self.assertNotEqual(result.code, -signal.SIGPIPE)
        self.assertEqual(result.code, 1)


if __name__ == "__main__":
    support.main()
