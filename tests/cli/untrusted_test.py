# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Files of strangers, and what killed runs leave: nothing of them steers a terminal, reads elsewhere or is taken for ours."""
import csv
import json
import os
import re
import signal
import stat
import subprocess

import sight_cases
import smoke_files
import support
from support import volute

EVIL = "\x1b]0;owned\x07\x1b[31mdensity\x9b2J\u202egnp"


class Terminal(support.TestCase):
    def quiet(self, result):
        """No control character but line ends, nothing that turns the direction, on either stream."""
        for text in (result.out.decode(), result.err.decode()):
            for c in text:
                self.assertTrue(c == "\n" or (ord(c) >= 0x20 and not 0x7f <= ord(c) < 0xa0 and c != "\u202e"), repr(text))

    def test_names_of_files(self):
        self.make_npy("in.npy").rename(self.path(EVIL + ".npy"))
        self.quiet(self.works("info", self.path(EVIL + ".npy")))
        self.quiet(self.works("info", self.path(EVIL + ".npy"), "--json"))
        self.quiet(volute("info", self.path(EVIL + "missing.npy")))
        self.quiet(volute(EVIL))
        self.quiet(volute("info", "--" + EVIL))

    def test_names_of_fields(self):
        mesh = smoke_files.box((0, 0, 0), (1, 1, 1), (1, 1, 1))
        name = "a&#x9b;31m&#x7f;"  # what XML lets through
        smoke_files.write_vtu(self.path("a.vtu"), mesh, {name: [1.0] * len(mesh[0]), "soot": [2.0] * len(mesh[0])})
        for options in ([], ["--json"]):
            result = self.works("info", self.path("a.vtu"), *options)
            self.quiet(result)
            self.assertIn("31m", result.text)
        self.quiet(volute("render", self.path("a.vtu"), "-o", self.path("x.png"), "--quantity", "extinction", "--field", EVIL))

    def test_names_in_json(self):
        self.path("scene.json").write_text(json.dumps({"format": "volute-scene-1", EVIL: 1}))
        result = volute("render", self.path("scene.json"), "-o", self.path("x.png"))
        self.assertEqual(result.code, 1)
        self.assertIn("owned", result.message)
        self.quiet(result)

    def test_a_name_is_no_entry(self):
        self.path("a.vti").write_text(
            '<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian"><ImageData WholeExtent="0 1 0 1 0 1" Origin="0 0 0" '
            'Spacing="1 1 1"><Piece Extent="0 1 0 1 0 1"><CellData><DataArray type="Float32" Name="a&#10;integrity  fine" format="ascii">3'
            '</DataArray></CellData></Piece></ImageData></VTKFile>\n')
        self.assertRegex(self.works("info", self.path("a.vti")).text, "\n  +integrity  fine\n")

    def test_a_name_is_no_message(self):
        name = "a\nvolute: all is well.npy"
        result = volute("info", self.path(name))
        self.assertIn("\n    volute: all is well", result.message)


class Tables(support.TestCase):
    def test_names_of_signs_are_no_formulas(self):
        names = ["=1+1", "+x", "-x", "@x", "=HYPERLINK(\"http://x\",\"y\")", "exit, north"]
        sight_cases.write_vtu(self.path("a.vtu"), (4, 4, 3), (2, 2, 2), lambda x, y, z: 0.1)
        self.path("signs.json").write_text(json.dumps({"signs": [
            {"name": name, "position": [2, 0.1 + 0.1 * i, 2], "normal": [0, 1, 0]} for i, name in enumerate(names)]}))
        self.path("eyes.csv").write_text("x,y,z\n2,3,2\n")
        self.works("visibility", self.path("a.vtu"), "--quantity", "extinction", "--signs", self.path("signs.json"), "--eyes",
                   self.path("eyes.csv"), "-o", self.path("out"))
        with open(self.path("out") / "sight.csv", newline="") as file:
            read = [row["sign"] for row in csv.DictReader(file)]
        self.assertEqual(read, ["'" + name if name[0] in "=+-@" else name for name in names])

    def test_names_in_other_tables_are_no_formulas(self):
        """Of devices in curves.csv, of signs and runs in study.csv; numbers stay numbers."""
        evil = "-1+cmd|' /C calc'!A0"
        hall = sight_cases.Mesh("hall", (0, 8, 0, 4, 0, 3), (8, 4, 3))
        case = sight_cases.FdsCase([hall], [0.0, 10.0, 20.0], lambda t, *_: 0.1 * t).write(self.folder, "hall")
        with open(case, "a") as file:
            file.write(f"DEVICE\n {evil} % TEMPERATURE\n 1.0 1.0 1.0 0.0 0.0 -1.0 0 0\n")
        self.path("hall_devc.csv").write_text(f's,C\n"Time","{evil}"\n0,-5\n10,40\n20,60\n')
        self.path("signs.json").write_text(json.dumps({"signs": [{"name": evil, "position": [7.9, 2, 2], "normal": [-1, 0, 0]}]}))
        self.path("study.json").write_text(json.dumps({"cases": ["hall.smv"], "variants": [{"name": "v"}],
                                                       "options": {"signs": "signs.json", "height": 1.5, "step": 2, "maps": "aset"}}))
        self.works("sweep", self.path("study.json"), "-o", self.path("study"))
        with open(self.path("study") / "study.csv", newline="") as file:
            (row,) = csv.DictReader(file)
        self.assertEqual(row["first sign lost"], "'" + evil)
        with open(self.path("study") / "hall_v/curves.csv", newline="") as file:
            rows = [row for row in csv.DictReader(file) if row["figure"] == "devices"]
        self.assertEqual({row["name"] for row in rows}, {"'" + evil})
        self.assertEqual([float(row["value"]) for row in rows], [-5, 40, 60])


class Untrusted(support.TestCase):
    def scene(self, file):
        self.path("in").mkdir(exist_ok=True)
        scene = {"format": "volute-scene-1", "camera": {"eye": [3, 0, 1], "target": [0, 0, 0], "fov": 40},
                 "media": [{"kind": "volume", "file": str(file)}]}
        self.path("in/scene.json").write_text(json.dumps(scene))
        return self.path("in/scene.json")

    def test_files_outside_of_the_folder(self):
        volume = self.make_volute("a.volute")
        (self.path("in")).mkdir()
        os.symlink(volume, self.path("in/link.volute"))
        for file in (volume, "../a.volute", "link.volute"):
            scene = self.scene(file)
            result = self.works("render", scene, "-o", self.path("x.png"), "--size", "4x4")
            self.assertIn("outside of its folder", result.message)
            self.path("x.png").unlink()
            said = self.fails(1, "render", scene, "-o", self.path("x.png"), "--size", "4x4", "--untrusted")
            self.assertIn("--untrusted refuses that", said)

    def test_names_in_collections_and_cases(self):
        self.path("in/cs").mkdir(parents=True)
        self.path("in/a.pvd").write_text('<VTKFile type="Collection"><Collection><DataSet timestep="0" file="../secret/q.vtu"/></Collection></VTKFile>')
        self.path("in/cs/case.smv").write_text("TITLE\n x\nSLCF 1\n  ..\\..\\secret\\c_1.sf\n soot\n")
        self.path("in/own.pvd").write_text('<VTKFile type="Collection"><Collection><DataSet timestep="0" file="sub/q.vtu"/></Collection></VTKFile>')
        scene = self.path("in/scene.json")
        scene.write_text(json.dumps({"format": "volute-scene-2", "media": [{"kind": "smoke", "case": "cs/case.smv"}]}))
        for file, name in ((self.path("in/a.pvd"), "../secret/q.vtu"), (self.path("in/cs/case.smv"), "../../secret/c_1.sf"), (scene, "../../secret/c_1.sf")):
            said = self.fails(1, "info", file, "--untrusted")
            self.assertIn(f"names '{name}', outside of its folder; --untrusted refuses that", said)
        self.assertNotIn("outside of its folder", self.fails(1, "info", self.path("in/own.pvd"), "--untrusted"))

    def test_names_in_inputs_of_fds(self):
        self.path("in").mkdir()
        hall = sight_cases.Mesh("hall", (0, 8, 0, 4, 0, 3), (8, 4, 3))
        case = sight_cases.FdsCase([hall], [0.0, 10.0], lambda t, *_: 0.1 * t).write(self.path("in"), "hall")
        with open(case, "a") as file:
            file.write("INPF\n hall.fds\n")
        self.path("optics.fds").write_text("&MISC VISIBILITY_FACTOR=5 /\n")
        for name in ("../optics.fds", "..\\optics.fds", str(self.path("optics.fds"))):
            self.path("in/hall.fds").write_text(f"&HEAD CHID='hall' /\n&CATF OTHER_FILES='{name}' /\n")
            said = self.fails(1, "info", case, "--untrusted")
            self.assertIn("outside of its folder; --untrusted refuses that", said)
            self.assertIn("outside of its folder (--untrusted refuses that)", self.works("info", case).message)
        self.path("optics.fds").rename(self.path("in/optics.fds"))
        self.path("in/hall.fds").write_text("&HEAD CHID='hall' /\n&CATF OTHER_FILES='optics.fds' /\n")
        self.works("info", case, "--untrusted")

    def test_captures(self):
        self.path("in").mkdir()
        self.path("secret_0000.exr").write_bytes(b"not for strangers")
        camera = {"name": "c", "image": "../secret_%04d.exr", "width": 4, "height": 4, "K": [[9, 0, 2], [0, 9, 2], [0, 0, 1]],
                  "R": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "t": [0, 0, 4]}
        capture = {"format": "volute-capture-1", "color": "linear", "pixel_centre": 0.5, "frames": [0], "cameras": [camera],
                   "volume": {"min": [-1, -1, -1], "max": [1, 1, 1], "resolution": [4, 4, 4]}}
        self.path("in/capture.json").write_text(json.dumps(capture))
        for words in (["reconstruct", self.path("in/capture.json"), "-o", self.path("x.npy")],
                      ["project", self.make_npy(size=4, frames=1), self.path("in/capture.json"), "-o", self.path("{camera}_%04d.exr")]):
            said = self.fails(1, *words, "--untrusted")
            self.assertIn("names '../secret_%04d.exr', outside of its folder; --untrusted refuses that", said)
        self.assertIn("outside of its folder (--untrusted refuses that)", volute("info", self.path("in/capture.json")).message)

    def test_files_within(self):
        self.path("in").mkdir()
        self.make_volute("in/a.volute")
        result = self.works("render", self.scene("a.volute"), "-o", self.path("x.png"), "--size", "4x4", "--untrusted")
        self.assertNotIn("outside", result.message)


class Outputs(support.TestCase):
    def test_no_two_have_one_name(self):
        volume = self.make_volute()
        self.path("sub").mkdir()
        for stats in ("x.npy", "./x.npy", "sub/../x.npy"):
            said = self.fails(2, "extract", volume, "-o", self.path("x.npy"), "--stats", f"{self.folder}/{stats}")
            self.assertIn("two outputs have the name", said)
        self.fails(2, "extract", volume, "-o", self.path("x_%04d.vti"), "--stats", self.path("x_0001.vti"))
        self.works("extract", volume, "-o", self.path("x.npy"), "--stats", self.path("x.json"))

    def test_links_lead_to_one_file(self):
        volume = self.make_volute()
        self.path("s.json").symlink_to("x.npy")
        for _ in range(2):  # before there is an x.npy, and with it
            self.assertIn("two outputs have the name", self.fails(2, "extract", volume, "-o", self.path("x.npy"), "--stats", self.path("s.json")))
            self.works("extract", volume, "-o", self.path("x.npy"))

    def test_names_by_default_count(self):
        volume = self.make_volute("a.volute")
        self.works("extract", volume, "-o", self.path("b.npy"))
        for words in (("render", "a.volute", "--size", "4x4", "--stats", "a.png"), ("compress", "b.npy", "--stats", "b.volute")):
            done = subprocess.run([support.PROGRAM, *words], cwd=self.folder, capture_output=True, text=True)
            self.assertEqual((done.returncode, self.path(words[-1]).exists()), (2, False), words)
            self.assertIn(f"two outputs have the name {words[-1]}", done.stderr)

    def test_statistics_are_no_file_of_a_run(self):
        self.path("study.json").write_text(json.dumps({"cases": ["no.smv"], "options": {"signs": "signs.json"}}))
        for name in ("out/study.csv", "out/new.json"):
            said = self.fails(2, "sweep", self.path("study.json"), "-o", self.path("out"), "--stats", self.path(name))
            self.assertIn("give another name", said)

    def test_no_frame_that_is_read_is_replaced(self):
        volume = self.make_volute()
        self.path("in").mkdir()
        frame = self.path("in/a_0001.npy")
        self.works("extract", volume, "-o", frame)
        before = frame.read_bytes()
        for name in (self.path("in/a_%04d.npy"), self.path("in")):
            self.assertIn("would be replaced", self.fails(2, "compress", name, "-o", self.path("y.volute"), "--stats", frame))
            self.assertEqual(frame.read_bytes(), before)

    def test_names_of_grids_lead_nowhere(self):
        self.path("res/x").mkdir(parents=True)
        self.path("victim").mkdir()
        self.path("victim/data.npy").write_text("precious")
        self.path("a.vti").write_text(
            '<VTKFile type="ImageData" version="1.0" byte_order="LittleEndian"><ImageData WholeExtent="0 1 0 1 0 1" Origin="0 0 0" '
            'Spacing="1 1 1"><Piece Extent="0 1 0 1 0 1"><CellData><DataArray type="Float32" Name="../victim/data" format="ascii">3'
            '</DataArray></CellData></Piece></ImageData></VTKFile>\n')
        self.works("compress", self.path("a.vti"), "-o", self.path("a.volute"))
        said = self.fails(1, "extract", self.path("a.volute"), "-o", self.path("res/{grid}.npy"))
        self.assertIn("a grid is called '../victim/data'", said)
        self.assertEqual(self.path("victim/data.npy").read_text(), "precious")
        self.works("extract", self.path("a.volute"), "-o", self.path("res/x.npy"))

    def test_a_study_names_no_files_to_write(self):
        sight_cases.write_vtu(self.path("a.vtu"), (4, 4, 3), (2, 2, 2), lambda x, y, z: 0.1)
        self.path("signs.json").write_text('{"signs": [{"name": "s", "position": [2, 0.1, 2], "normal": [0, 1, 0]}]}')
        self.path("notes.txt").write_text("mine")
        options = {"signs": "signs.json", "height": 1.5, "step": 1, "quantity": "extinction"}
        study = {"cases": [{"case": "a.vtu", "options": {"stats": str(self.path("notes.txt"))}}], "options": options}
        self.path("study.json").write_text(json.dumps(study))
        said = self.fails(1, "sweep", self.path("study.json"), "-o", self.path("out"))
        self.assertIn("the option 'stats' writes a file", said)
        self.assertEqual(self.path("notes.txt").read_text(), "mine")


class Streams(support.TestCase):
    def scene(self):
        sight_cases.write_vtu(self.path("a.vtu"), (4, 4, 3), (2, 2, 2), lambda x, y, z: 0.1)
        self.path("eyes.csv").write_text("x,y,z\n2,3,2\n")
        return '{"signs": [{"name": "s", "position": [2, 0.1, 2], "normal": [0, 1, 0]}]}'

    def test_pipes_are_read_where_a_file_is(self):
        signs = self.scene()
        command = [support.PROGRAM, "visibility", self.path("a.vtu"), "--quantity", "extinction", "--eyes", self.path("eyes.csv"), "-o"]
        for i, name in enumerate(("-", "/dev/stdin", "/dev/fd/0")):
            done = subprocess.run([*command, self.path(f"out{i}"), "--signs", name], input=signs.encode(), stderr=subprocess.PIPE)
            self.assertEqual(done.returncode, 0, done.stderr)
        shell = " ".join(f"'{word}'" for word in command)
        done = subprocess.run(["bash", "-c", f"{shell} '{self.path('out9')}' --signs <(echo '{signs}')"], stderr=subprocess.PIPE)
        self.assertEqual(done.returncode, 0, done.stderr)

    def piped(self, shell):
        done = subprocess.run(["bash", "-c", re.sub(r"(?<![.\w])volute ", f"'{support.PROGRAM}' ", shell)], cwd=self.folder, capture_output=True, text=True,
                              env=os.environ | {"TMPDIR": str(self.path("tmp"))})
        self.assertEqual(self.path("tmp").exists() and list(self.path("tmp").iterdir()), [], "what came through the pipe is still there")
        return done

    def test_volumes_come_through_pipes(self):
        self.path("tmp").mkdir()
        volume = self.make_volute()
        self.works("extract", volume, "-o", self.path("v.npy"))
        self.works("extract", volume, "-o", self.path("v_%04d.vdb"))
        self.works("render", self.path("v.npy"), "-o", self.path("file.png"), "--size", "24x18")
        sight_cases.write_vtu(self.path("a.vtu"), (4, 4, 3), (2, 2, 2), lambda x, y, z: 0.1 + x)
        for name in (volume.name, "v.npy", "v_0000.vdb", "a.vtu", "file.png"):
            plain, piped = self.piped(f"volute info --json {name}"), self.piped(f"cat {name} | volute info --json -")
            if "this build" in plain.stderr:
                continue
            self.assertEqual(piped.returncode, 0, piped.stderr)
            said = [json.loads(done.stdout) for done in (plain, piped)]
            for one in said:
                one.pop("file"), one.pop("remarks", 0)
            self.assertEqual(*said)
            self.assertRegex(piped.stderr, "standard input: .* of .*, kept in .*/tmp/volute-")
        for words in ("cat v.npy | volute render -", "volute render /dev/stdin < v.npy", "volute render <(cat v.npy)", "cat v.npy | volute render /proc/self/fd/0"):
            done = self.piped(f"{words} -o pipe.png --size 24x18 --quiet")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertEqual(self.path("pipe.png").read_bytes(), self.path("file.png").read_bytes())
        self.assertEqual(self.piped(f"volute compare - v.npy < {volume.name} --quiet").returncode, 0)
        self.assertEqual(self.piped(f"volute compare <(cat {volume.name}) <(cat v.npy) --quiet").returncode, 0)
        self.assertEqual(self.piped("cat v.npy | volute compress - -o a.volute --quiet").returncode, 0)
        # A scene finds its files when it is redirected, and not through a pipe.
        self.path("scene.json").write_text(json.dumps({"format": "volute-scene-2", "media": [{"kind": "volume", "file": "v.npy"}]}))
        self.assertEqual(self.piped("volute render - -o b.png --size 24x18 --quiet < scene.json").returncode, 0)
        for shell, said in (("cat scene.json | volute render - -o b.png", "is JSON, which names files beside it"),
                            ("true | volute info -", "is empty"), ("echo hello | volute info -", "of no kind that is known"),
                            ("cat v.npy | volute compare - -", "named twice"), ("volute info - < /dev/null", "a terminal or a device"),
                            ("head -c 300 v.npy | volute info -", "fewer than its header says"), ("volute info - <&-", "a terminal or a device|cannot be read")):
            done = self.piped(shell)
            self.assertIn(done.returncode, (1, 2), shell)
            self.assertRegex(done.stderr, said)

    def test_closed_streams(self):
        volume = self.make_volute()
        render = f"'{support.PROGRAM}' render '{volume}' -o '{self.path('x.png')}' --size 8x8"
        self.assertEqual(subprocess.run(["bash", "-c", f"{render} 2>&-"]).returncode, 0)
        self.assertTrue(self.path("x.png").exists())
        done = subprocess.run(["bash", "-c", f"'{support.PROGRAM}' info '{volume}' >&-"], stderr=subprocess.PIPE)
        self.assertEqual(done.returncode, 1)
        self.assertIn(b"standard output: cannot write", done.stderr)

    def test_help_into_head(self):
        read, write = os.pipe()
        os.close(read)  # as head does when it has seen enough
        for words in (("help", "render"), ("man",), ("info", "--json", self.make_npy())):
            done = subprocess.run([support.PROGRAM, *words], stdout=write, stderr=subprocess.PIPE)
            self.assertEqual((done.returncode, done.stderr), (-signal.SIGPIPE, b""), words)
        os.close(write)

    def test_few_descriptors(self):
        self.scene()
        info = f"'{support.PROGRAM}' info '{self.path('a.vtu')}'"
        done = subprocess.run(["bash", "-c", f"ulimit -n 64; {info}"], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertEqual(done.returncode, 0, done.stderr)


class Targets(support.TestCase):
    def test_modes_and_links_stay(self):
        volume = self.make_volute()
        self.path("there").mkdir()
        real = self.path("there/x.npy")
        real.write_text("old")
        real.chmod(0o640)
        os.symlink("there/x.npy", self.path("x.npy"))
        self.works("extract", volume, "-o", self.path("x.npy"))
        self.assertTrue(self.path("x.npy").is_symlink())
        self.assertEqual(real.read_bytes()[:6], b"\x93NUMPY")
        self.assertEqual(stat.S_IMODE(real.stat().st_mode), 0o640)

    def test_parts_of_killed_runs_are_named(self):
        volume = self.make_volute()
        dead = subprocess.Popen(["true"])
        dead.wait()
        part = self.path(f".x.{dead.pid}.0.part.npy")
        mine = self.path(f".x.{os.getpid()}.0.part.npy")
        part.write_text("half")
        mine.write_text("half")
        result = self.works("extract", volume, "-o", self.path("x.npy"))
        self.assertIn(f"{part}: left by runs that were killed", result.message)
        self.assertIn("rm -r", result.message)
        self.assertNotIn(mine.name, result.message)
        self.assertTrue(part.exists() and mine.exists())
        part.unlink()
        self.assertEqual(self.works("extract", volume, "-o", self.path("x.npy")).message, "")


if __name__ == "__main__":
    support.main()
