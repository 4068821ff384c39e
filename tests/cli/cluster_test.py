# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Several processes that mpirun starts give the bytes of one, and end together when one of them cannot go on."""
import array
import filecmp
import html
import json
import math
import os
import pathlib
import random
import re
import shutil
import signal
import struct
import subprocess
import sys
import time
import unittest

import ring
import sight_cases
import support

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "bench"))
import large_volume
import mesh_in_pieces

PROGRAM = pathlib.Path(support.PROGRAM).resolve()
PLUGINS = PROGRAM.parent.parent / "lib" / "volute"
HAS_MPI = shutil.which("mpirun") and (PLUGINS / "volute_mpi.so").exists() and "VOLUTE_TESTS_WITHOUT_MPI" not in os.environ
RANKS = (1, 2, 3, 4, 8)


def limit():
    """Seconds, of what takes one to six where nobody else works: ranks share the cores with all that runs besides."""
    return 60 * support.slower()


def mpirun(ranks, *words, environment=None):
    """The command line, and the environment for it."""
    command = ["mpirun", "--oversubscribe", "-n", str(ranks), *map(str, words)]
    return command, os.environ | {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"} | (environment or {})


def start(ranks, *arguments, environment=None):
    command, environment = mpirun(ranks, PROGRAM, *arguments, "--threads", "1", environment=environment)
    return subprocess.Popen(command, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def ranks_of(launcher):
    """Process numbers of the ranks that mpirun `launcher` started and that have not ended, without their readers' helpers."""
    children = subprocess.run(["ps", "-o", "pid=,stat=,comm=", "--ppid", str(launcher)], stdout=subprocess.PIPE).stdout.decode()
    words = [line.split() for line in children.splitlines()]
    return [int(pid) for pid, state, name, *_ in words if name == "volute" and not state.startswith("Z")]


def kill(rank):
    """False where it has just ended by itself."""
    try:
        os.kill(rank, signal.SIGKILL)
    except ProcessLookupError:
        return False
    return True


def finish(process):
    """What it said. Debian's mpirun may wait for itself for ever after its ranks have died (PMIx 4.2, in PMIx_server_finalize): it is ended then."""
    end, alone = time.monotonic() + limit(), 0
    while True:
        try:
            return process.communicate(timeout=5)
        except subprocess.TimeoutExpired:
            alone = 0 if ranks_of(process.pid) else alone + 1
            if alone == 3:
                process.kill()
            elif time.monotonic() > end:
                raise


class Cluster(support.TestCase):
    def runs(self, ranks, *arguments, **options):
        process = start(ranks, *arguments, **options)
        out, message = finish(process)
        return process.returncode, out.decode("latin1"), message.decode()

    def others_end(self, process, seconds):
        end = time.monotonic() + seconds * limit() / 60
        while ranks_of(process.pid):
            self.assertLess(time.monotonic(), end)
            time.sleep(0.05)

    def spools(self, rank):
        """It compresses: it has a file that has no name any more, which it opens when MPI has begun."""
        try:
            links = [os.readlink(link) for link in pathlib.Path(f"/proc/{rank}/fd").iterdir()]
        except OSError:
            return False
        return any(link.startswith(str(self.folder)) and link.endswith(" (deleted)") for link in links)

    def succeeds(self, ranks, *arguments, **options):
        code, out, message = self.runs(ranks, *arguments, **options)
        self.assertEqual(code, 0, message)
        return out, message

    def says(self, ranks, *arguments, code=1, **options):
        """What rank 0 says when all end with an error: one sentence, beside mpirun's own lines."""
        before = self.files()
        found, out, message = self.runs(ranks, *arguments, **options)
        self.assertEqual(found, code, message)
        self.assertEqual(self.files(), before)
        ours = [line for line in message.splitlines() if line.startswith("volute")]
        ours = [line for line in ours if "no times are stated" not in line]
        self.assertEqual(len([line for line in ours if "lists the commands" not in line]), 1, message)
        return ours[0]

    def check_units(self, stats, stage, count, ranks):
        """Each unit once."""
        each = json.loads(stats.read_text())["ranks"]
        self.assertEqual([entry["rank"] for entry in each], list(range(ranks)))
        self.assertEqual(sorted(unit for entry in each for unit in entry["units"].get(stage, [])), list(range(count)))

    def shared(self, stats, stage):
        """Whether no rank does more than twice its share, by the CPU time that its units took."""
        work = [entry["stages"][stage]["cpu_seconds"] for entry in json.loads(stats.read_text())["ranks"]]
        return max(work) <= 2 * sum(work) / len(work)

    def hall(self, name="hall", smoke=0.02):
        mesh = sight_cases.Mesh(name, (0, 7, 0, 3, 0, 2.4), (14, 6, 4), [])
        return sight_cases.FdsCase([mesh], [0.0, 1.0, 2.5], lambda time, x, y, z: smoke * (1 + time) * (1 + 0.1 * x)).write(self.folder)

    def study(self):
        signs = self.path("signs.json")
        signs.write_text(json.dumps({"signs": [{"name": "east", "position": [7, 1.5, 1.1], "normal": [-1, 0, 0]}]}))
        variants = [{"name": f"v{i}", "options": {"extinction-limit": 0.05 * i}} for i in range(1, 6)]
        variants.append({"name": "wrong", "options": {"height": 77}})
        study = {"cases": [str(self.hall())], "options": {"signs": "signs.json", "height": 1.2, "step": 0.5}, "variants": variants}
        self.path("study.json").write_text(json.dumps(study))
        return self.path("study.json")

    def same_folders(self, one, other):
        names = sorted(str(path.relative_to(one)) for path in one.rglob("*") if path.is_file())
        self.assertEqual(names, sorted(str(path.relative_to(other)) for path in other.rglob("*") if path.is_file()))
        _, different, wrong = filecmp.cmpfiles(one, other, names, shallow=False)
        self.assertEqual((different, wrong), ([], []))
        return names


@unittest.skipUnless(HAS_MPI, "no mpirun, or Volute was built without MPI")
class SameBytes(Cluster):
    def test_stills(self):
        packed = self.make_volute(frames=9, size=16)
        alone = self.path("alone")
        alone.mkdir()
        self.works("render", packed, "-o", alone / "f_%02d.png", "--measured", "--size", "40x30")
        for ranks in RANKS:
            folder = self.path(f"by{ranks}")
            folder.mkdir()
            self.succeeds(ranks, "render", packed, "-o", folder / "f_%02d.png", "--measured", "--size", "40x30", "--stats", self.path("stats.json"))
            self.check_units(self.path("stats.json"), "rendering", 9, ranks)
            self.assertEqual(len(self.same_folders(alone, folder)), 9)
            self.assertEqual(json.loads(self.path("stats.json").read_text())["rays"], 9 * 40 * 30)

    def test_units_are_shared_out(self):
        """20 units a rank and more."""
        packed = self.make_volute(frames=100, size=16)
        for ranks in (3, 4):
            for _ in range(5):  # a core that others use gives a rank less to do
                self.succeeds(ranks, "render", packed, "-o", self.path("x_%03d.png"), "--size", "160x120", "--renderer", "cpu", "--stats",
                              self.path("stats.json"))
                self.check_units(self.path("stats.json"), "rendering", 100, ranks)
                if self.shared(self.path("stats.json"), "rendering"):
                    break
            else:
                self.fail("a rank did more than twice its share each time")

    def test_many_stills(self):
        """128 for each rank and more are taken in rows of 16."""
        packed = self.make_volute(frames=262, size=6)
        for name in ("alone", "ours"):
            self.path(name).mkdir()
        options = ("--measured", "--size", "12x8", "--renderer", "cpu")
        self.works("render", packed, "-o", self.path("alone") / "f_%03d.exr", *options)
        self.succeeds(2, "render", packed, "-o", self.path("ours") / "f_%03d.exr", *options, "--stats", self.path("stats.json"))
        self.check_units(self.path("stats.json"), "rendering", 17, 2)
        self.assertEqual(len(self.same_folders(self.path("alone"), self.path("ours"))), 262)

    def test_compress(self):
        source = self.make_npy(frames=34, size=20)
        for options in (("--rms", "0.003"), ("--ratio", "60", "--fast")):
            self.works("compress", source, "-o", self.path("alone.volute"), *options)
            for ranks in RANKS if "--fast" not in options else (3,):
                self.succeeds(ranks, "compress", source, "-o", self.path("ours.volute"), *options, "--stats", self.path("stats.json"))
                self.assertEqual(self.path("ours.volute").read_bytes(), self.path("alone.volute").read_bytes(), (ranks, options))
                # Of one rank a unit has all layers of blocks, of several those that keep a rank's threads busy: here all as well.
                self.check_compressed(3, ranks)

    def check_compressed(self, count, ranks):
        """The way through the units that is kept chooses modes at the same time, or is one more."""
        stages = {stage for entry in json.loads(self.path("stats.json").read_text())["ranks"] for stage in entry["units"]}
        self.check_units(self.path("stats.json"), "compressing" if "compressing" in stages else "choosing modes", count, ranks)

    @staticmethod
    def reads(name):
        plugin = {".vdb": "volute_io_vdb.so", ".vti": "volute_io_vtk.so"}.get(pathlib.Path(name).suffix)
        return plugin is None or (PLUGINS / plugin).exists()

    def test_compress_files_of_which_units_read_their_layers(self):
        """As much memory as a layer of blocks needs: 18 frames of 40^3 are 2 x 3 units."""
        shape, values = support.plume(18, 40)
        support.write_npy(self.path("in.npy"), shape, values)
        swapped = array.array("d", array.array("f", values))  # what float32 holds
        if sys.byteorder == "little":
            swapped.byteswap()
        self.path("in.raw").write_bytes(b"header" + swapped.tobytes())
        self.works("compress", self.path("in.npy"), "-o", self.path("in.volute"), "--rms", "0.003", "--fast")
        for name in ("vdb_%04d.vdb", "vti_%04d.vti"):
            if self.reads(name):
                self.works("extract", self.path("in.volute"), "-o", self.path(name))
        raw = ("--raw-size", "40,40,40", "--raw-type", "float64", "--raw-order", "big", "--raw-offset", "6")
        for source, options in (("in.npy", ()), ("in.raw", raw), ("vdb_%04d.vdb", ()), ("vti_%04d.vti", ())):
            if not self.reads(source):
                continue
            arguments = ("compress", self.path(source), "--rms", "0.01", "--fast", *options)
            self.works(*arguments, "-o", self.path("alone.volute"))
            self.succeeds(3, *arguments, "-o", self.path("ours.volute"), "--max-memory", "24M", "--stats", self.path("stats.json"))
            self.assertEqual(self.path("ours.volute").read_bytes(), self.path("alone.volute").read_bytes(), source)
            # A .vdb has no box but that of its active voxels.
            depth = self.works("info", self.path("ours.volute"), "--json").json["size"][2]
            self.assertEqual(depth > 32, not source.endswith(".vdb"), source)
            self.check_compressed(2 * -(-depth // 16), 3)
        self.works("compress", self.path("in.npy"), "-o", self.path("npy.volute"), "--rms", "0.01")
        self.works("compress", self.path("in.raw"), "-o", self.path("raw.volute"), "--rms", "0.01", *raw)
        self.works("extract", self.path("npy.volute"), "-o", self.path("npy.npy"))
        self.works("extract", self.path("raw.volute"), "-o", self.path("raw.npy"))
        self.assertEqual(self.path("npy.npy").read_bytes(), self.path("raw.npy").read_bytes())

    def test_memory_does_not_grow_with_the_sequence(self):
        side, peaks = 96, []
        for frames in (16, 64):
            large_volume.write_plume(self.path("plume.raw"), side, frames)
            stats = large_volume.compress_on_ranks(PROGRAM, self.path("plume.raw"), side, 2, ("--rms", "0.01", "--fast", "--threads", "1"))
            peaks.append(max(rank["peak_memory_bytes"] for rank in stats["ranks"]))
        self.assertLess(peaks[1], peaks[0] + 4 * side ** 3 * 8, peaks)  # 48 frames more, and no 8 of them in memory

    @unittest.skipUnless((PLUGINS / "volute_io_video.so").exists(), "built without films")
    def test_film(self):
        packed = self.make_volute(frames=20, size=12)
        self.works("render", packed, "-o", self.path("alone.mp4"), "--size", "64x48", "--threads", "1")
        for ranks in RANKS:
            self.succeeds(ranks, "render", packed, "-o", self.path("ours.mp4"), "--size", "64x48")
            self.assertEqual(self.path("ours.mp4").read_bytes(), self.path("alone.mp4").read_bytes())

    def test_extract(self):
        packed = self.make_volute(frames=40, size=18)
        for name, options in (("x.npy", ()), ("y.npy", ("--level", "1", "--frames", "3:39:5"))):
            self.works("extract", packed, "-o", self.path("alone.npy"), *options)
            for ranks in (2, 4):
                out, _ = self.succeeds(ranks, "extract", packed, "-o", self.path(name), *options, "--stats", self.path("stats.json"))
                self.assertEqual(self.path(name).read_bytes(), self.path("alone.npy").read_bytes())
                self.check_units(self.path("stats.json"), "extracting", 3, ranks)
        alone = self.works("extract", packed, "-o", "-").out
        self.assertEqual(self.succeeds(3, "extract", packed, "-o", "-")[0].encode("latin1"), alone)

    def test_reconstruct(self):
        capture = self.path("capture.json")
        capture.write_text(json.dumps(ring.capture() | {"frames": list(range(10, 28))}))
        self.works("synthesize", "fire", "-o", self.path("truth.npy"), "--size", "16", "--frames", "18")
        self.works("project", self.path("truth.npy"), capture, "-o", self.path("{camera}_%04d.exr"))
        arguments = ("reconstruct", capture, "--resolution", "10", "--iterations", "4", "--regularization", "none", "--force")
        self.works(*arguments, "-o", self.path("alone.volute"), "--velocity")
        for ranks in RANKS:
            self.succeeds(ranks, *arguments, "-o", self.path("ours.volute"), "--velocity", "--stats", self.path("stats.json"))
            self.assertEqual(self.path("ours.volute").read_bytes(), self.path("alone.volute").read_bytes(), ranks)
            self.check_units(self.path("stats.json"), "reconstructing", 3, ranks)  # frames 10-15, 16-23, 24-27
            self.check_units(self.path("stats.json"), "velocities", 17, ranks)
            self.assertEqual([name for name in self.files() if ".work" in name], [])
        # Parts that begin with a chain are those of the whole.
        self.works(*arguments, "-o", self.path("whole.npy"))
        self.works(*arguments, "-o", self.path("part.npy"), "--frames", "16:24")
        (_, whole), (_, part) = (support.read_npy(self.path(name).read_bytes()) for name in ("whole.npy", "part.npy"))
        self.assertEqual(list(part), list(whole[6 * len(whole) // 18:14 * len(whole) // 18]))

    def test_visibility(self):
        mesh = sight_cases.Mesh("hall", (0, 7, 0, 3, 0, 2.4), (14, 6, 4), [(2, 2.5, 0, 1.5, 0, 2.4)])
        case = sight_cases.FdsCase([mesh], [0.0, 1.0, 2.5, 4.0, 5.0], lambda time, x, y, z: 0.02 * (1 + time) * (1 + 0.1 * x)).write(self.folder)
        signs = self.path("signs.json")
        signs.write_text(json.dumps({"signs": [{"name": "east", "position": [7, 1.5, 1.1], "normal": [-1, 0, 0]},
                                               {"name": "west", "position": [0, 2, 1.3], "normal": [1, 0, 0], "emitting": True}]}))
        arguments = ("visibility", case, "--signs", signs, "--height", "1.2", "--step", "0.5", "--extinction-limit", "0.2")
        self.works(*arguments, "-o", self.path("alone"))
        for ranks in RANKS:
            self.succeeds(ranks, *arguments, "-o", self.path("ours"), "--stats", self.path("stats.json"))
            times = len(json.loads((self.path("alone") / "visibility.json").read_text())["times"])
            self.check_units(self.path("stats.json"), "looking", times, ranks)
            self.assertIn("sight.csv", self.same_folders(self.path("alone"), self.path("ours")))

    def test_visibility_with_many_sight_lines(self):
        """Ranks compress the rows of their times; times with few rows are compressed together."""
        mesh = sight_cases.Mesh("hall", (0, 7, 0, 3, 0, 2.4), (14, 6, 4), [(2, 2.5, 0, 1.5, 0, 2.4)])
        case = sight_cases.FdsCase([mesh], [0.0, 1.0, 2.5, 4.0], lambda time, x, y, z: 0.02 * (1 + time) * (1 + 0.1 * x)).write(self.folder)
        signs = self.path("signs.json")
        signs.write_text(json.dumps({"signs": [{"name": "east", "position": [7, 1.5, 1.1], "normal": [-1, 0, 0]},
                                               {"name": "west", "position": [0, 2, 1.3], "normal": [1, 0, 0], "emitting": True}]}))
        arguments = ("visibility", case, "--signs", signs, "--height", "1.2", "--maps", "aset", "--criteria", "none")
        for step, kind in (("0.03", "auto"), ("0.03", "csv"), ("0.1", "csv.zst")):
            options = (*arguments, "--step", step, "--sight", kind)
            self.works(*options, "-o", self.path("alone"), "--threads", "3")
            for ranks in (2, 3):
                self.succeeds(ranks, *options, "-o", self.path("ours"))
                names = self.same_folders(self.path("alone"), self.path("ours"))
                self.assertIn("sight.csv" if kind == "csv" else "sight.csv.zst", names)
            if step == "0.03":
                shutil.copytree(self.path("alone"), self.path(kind))
        if shutil.which("zstd"):
            text = subprocess.run(["zstd", "-dc", self.path("auto") / "sight.csv.zst"], check=True, stdout=subprocess.PIPE).stdout
            self.assertTrue(text == (self.path("csv") / "sight.csv").read_bytes())

    def test_visibility_of_several_storeys(self):
        mesh = sight_cases.Mesh("hall", (0, 7, 0, 3, 0, 2.4), (14, 6, 4), [])
        case = sight_cases.FdsCase([mesh], [0.0, 1.0, 2.5], lambda time, x, y, z: 0.2 * (1 + time) * (1 + z)).write(self.folder)
        signs = self.path("signs.json")
        signs.write_text(json.dumps({"signs": [{"name": "east", "position": [7, 1.5, 1.1], "normal": [-1, 0, 0]}]}))
        arguments = ("visibility", case, "--signs", signs, "--height", "0.9,1.5", "--step", "0.5", "--extinction-limit", "0.7")
        self.works(*arguments, "-o", self.path("alone"))
        self.succeeds(3, *arguments, "-o", self.path("ours"))
        names = self.same_folders(self.path("alone"), self.path("ours"))
        self.assertTrue({"report.html", "z_0.9/sight.csv", "z_1.5/aset.png"} <= set(names), names)
        report = json.loads((self.path("alone") / "visibility.json").read_text())
        storeys = [json.loads((self.path("alone") / name / "visibility.json").read_text()) for name in ("z_0.9", "z_1.5")]
        self.assertEqual([one["verdict"] for one in report["heights"]], [one["verdict"] for one in storeys])
        page = (self.path("alone") / "report.html").read_text()
        for name, storey in zip(("0.9", "1.5"), storeys):
            self.assertTrue(f"<h1>Eyes at z = {name} m</h1>" in page)
            for verdict in storey["verdict"]:
                self.assertTrue(html.escape(verdict["sentence"]).replace("&#x27;", "&#39;") in page, verdict)
        for one in report["verdict"]:
            times = [v["time"] for storey in storeys for v in storey["verdict"] if v["criterion"] == one["criterion"] and v["time"] is not None]
            self.assertEqual(one["time"], min(times) if times else None)


    def test_sweep(self):
        study = self.study()
        self.works("sweep", study, "-o", self.path("alone"))
        for ranks in RANKS:
            _, message = self.succeeds(ranks, "sweep", study, "-o", self.path(f"by{ranks}"), "--stats", self.path("stats.json"))
            self.check_units(self.path("stats.json"), "runs", 6, ranks)
            self.assertIn("run 'case_wrong': ", message)  # whichever rank had it
            names = self.same_folders(self.path("alone"), self.path(f"by{ranks}"))
            self.assertTrue({"study.csv", "case_v3/visibility.json", "compared/spread.vti"} <= set(names), names)

    def test_a_sweep_with_a_rank_killed_goes_on(self):
        study = self.study()
        self.works("sweep", study, "-o", self.path("alone"))
        process = start(2, "sweep", study, "-o", self.path("ours"))
        end = time.monotonic() + limit()
        while not list(self.folder.glob("ours/keys/*")) and process.poll() is None and time.monotonic() < end:
            time.sleep(0.005)
        for rank in ranks_of(process.pid)[-1:]:
            kill(rank)
        finish(process)
        self.succeeds(3, "sweep", study, "-o", self.path("ours"))
        table = [(self.path(name) / "study.csv").read_bytes() for name in ("alone", "ours")]
        self.assertEqual(table[0], table[1])


@unittest.skipUnless(HAS_MPI and (PLUGINS / "volute_io_vtk.so").exists(), "no mpirun, or Volute was built without MPI or VTK")
class MeshInPieces(Cluster):
    VIEW = ("--eye", "-8,3,-7", "--target", "5,5,5", "--fov", "50", "--size", "60x40")
    SOOT = ("--quantity", "soot-density", "--unit", "kg/m3")

    def setUp(self):
        super().setUp()
        self.mesh, self.tetrahedra = mesh_in_pieces.write_mesh(self.folder, 10, 5)

    def difference(self, one, other):
        return self.works("compare", self.path(one), self.path(other), "--json").json["max_error"]

    def test_ranks_with_a_share_each_draw_what_one_does(self):
        self.assertEqual(self.tetrahedra, 6000)
        for options in (("--aov", "optical-depth"), ("--measured",)):
            arguments = ("render", self.mesh, *self.VIEW, *self.SOOT, *options)
            self.works(*arguments, "-o", self.path("alone.exr"))
            for ranks in (2, 3, 5):
                self.succeeds(ranks, *arguments, "-o", self.path("ours.exr"), "--by-pieces")
                self.assertLessEqual(self.difference("alone.exr", "ours.exr"), 1e-5, (ranks, options))

    def test_rays_in_the_plane_between_pieces(self):
        """Pieces meet at z = 2, 4, 6 and 8; the middle row and column of pixels look along such planes."""
        scene = {"format": "volute-scene-1", "background": [0.2, 0.3, 0.4], "lights": [{"kind": "ambient", "radiance": [1, 0.7, 0.4]}],
                 "camera": {"eye": [-8, 5, 4], "target": [5, 5, 4], "up": [0, 0, 1], "fov": 50, "size": [61, 41]},
                 "media": [{"kind": "smoke", "case": "mesh.pvtu", "field": "soot", "quantity": "soot-density", "unit": "kg/m3"}]}
        self.path("scene.json").write_text(json.dumps(scene))
        for options in (("--aov", "optical-depth"), ("--measured",)):
            self.works("render", self.path("scene.json"), *options, "-o", self.path("alone.exr"))
            self.succeeds(5, "render", self.path("scene.json"), *options, "-o", self.path("ours.exr"), "--by-pieces")
            self.assertLessEqual(self.difference("alone.exr", "ours.exr"), 1e-5, options)

    def test_light_that_smoke_scatters_is_composed_in_order(self):
        scene = {"format": "volute-scene-1", "background": [0.2, 0.3, 0.4], "lights": [{"kind": "ambient", "radiance": [1, 0.7, 0.4]}],
                 "camera": {"eye": [-8, 3, -7], "target": [5, 5, 5], "up": [0, 0, 1], "fov": 50, "size": [60, 40]},
                 "media": [{"kind": "smoke", "case": "mesh.pvtu", "field": "soot", "quantity": "soot-density", "unit": "kg/m3"}]}
        self.path("scene.json").write_text(json.dumps(scene))
        arguments = ("render", self.path("scene.json"), "--measured")
        self.works(*arguments, "-o", self.path("alone.exr"))
        for ranks in (2, 4):
            self.succeeds(ranks, *arguments, "-o", self.path("ours.exr"), "--by-pieces")
            self.assertLessEqual(self.difference("alone.exr", "ours.exr"), 1e-5, ranks)
        self.works(*arguments, "-o", self.path("alone.png"))
        self.succeeds(3, *arguments, "-o", self.path("ours.png"), "--by-pieces")
        # Suns, and a lamp in the plane between two pieces.
        scene["lights"] += [{"kind": "sun", "direction": [0, -1, -0.2], "radiance": [1, 1, 1]},
                            {"kind": "sun", "direction": [0.3, 0.2, -1], "radiance": [1, 0.5, 0.2]},
                            {"kind": "spot", "position": [5, 5, 4], "target": [5, 5, 0], "angle": 120, "intensity": [0.3, 0.2, 0.1]}]
        self.path("scene.json").write_text(json.dumps(scene))
        self.works(*arguments, "-o", self.path("alone.exr"), "--cache", "none")
        for ranks in (2, 5):
            self.succeeds(ranks, *arguments, "-o", self.path("ours.exr"), "--by-pieces")
            self.assertLessEqual(self.difference("alone.exr", "ours.exr"), 1e-5, ranks)

    def test_what_ranks_cannot_share(self):
        arguments = ("render", self.mesh, *self.VIEW, *self.SOOT, "-o", self.path("x.exr"), "--by-pieces")
        self.assertIn("is in 5 pieces, and 6 ranks cannot hold one each", self.says(6, *arguments))
        self.assertIn("has no slices", self.says(2, *arguments, "--slice", "x=5", "--quiet"))
        self.assertIn("is one piece", self.says(2, "render", self.path("piece_0.vtu"), *arguments[2:]))
        self.path("piece_3.vtu").write_bytes(self.path("piece_3.vtu").read_bytes()[:-2000])
        self.assertIn("piece_3.vtu", self.says(3, *arguments))


@unittest.skipUnless(HAS_MPI, "no mpirun, or Volute was built without MPI")
class FdsInShares(Cluster):
    """Ranks that hold some meshes of a case each draw what one process does."""
    VIEW = ("--eye", "-4,-6,5", "--target", "5,2,1", "--fov", "40", "--size", "60x40")
    WALL = (1.0, 1.5, 0.5, 3.0, 0.0, 2.0)

    @staticmethod
    def smoke(time, x, y, z):
        return 0.1 * (1 + time) * (1.2 + math.sin(x) * math.cos(y)) * (0.2 + z)

    @staticmethod
    def heat(time, x, y, z):
        return 900.0 if (x - 5) ** 2 + (y - 2) ** 2 < 2 and z < 1.5 else 0.0

    def case(self, fire=False, overlapping=False):
        meshes = [sight_cases.Mesh("west", (0, 4, 0, 4, 0, 2.4), (16, 16, 8), [self.WALL]),
                  sight_cases.Mesh("low", (4, 7, 0, 4, 0, 1.2), (6, 8, 4), []),
                  sight_cases.Mesh("high", (4, 7, 0, 4, 1.2, 2.4), (6, 8, 4), []),
                  sight_cases.Mesh("east", (7, 10, 0, 4, 0, 2.4), (12, 16, 8), [])]
        if overlapping:
            meshes[1:3] = [sight_cases.Mesh("middle", (4, 7, 0, 4, 0, 2.4), (6, 8, 8), []),
                           sight_cases.Mesh("fine", (5, 6, 1, 2, 0, 1.2), (8, 8, 8), [])]
        more = [("HRRPUV", "kW/m3", self.heat)] if fire else []
        return sight_cases.FdsCase(meshes, [0.0, 1.0, 2.5], self.smoke, more=more).write(self.folder)

    def add_plots(self, case):
        """PLOT3D files of the extinction, of all meshes at two times."""
        with case.open("a") as index:
            for time in (0.0, 2.0):
                for number, (bounds, cells) in enumerate([((0, 4, 0, 4, 0, 2.4), (16, 16, 8)), ((4, 7, 0, 4, 0, 1.2), (6, 8, 4)),
                                                          ((4, 7, 0, 4, 1.2, 2.4), (6, 8, 4)), ((7, 10, 0, 4, 0, 2.4), (12, 16, 8))], 1):
                    mesh = sight_cases.Mesh("", bounds, cells)
                    values = array.array("f", (self.smoke(time, x, y, z) for z in mesh.planes[2] for y in mesh.planes[1] for x in mesh.planes[0]))
                    name = f"plot_{number}_{time:.0f}.q"
                    with self.path(name).open("wb") as file:
                        for data in (struct.pack("<3i", *(c + 1 for c in cells)), struct.pack("<4f", 0, 0, 0, 0), 5 * values.tobytes()):
                            file.write(struct.pack("<i", len(data)) + data + struct.pack("<i", len(data)))
                    index.write(f"PL3D {time:11.2f}{number:6}\n {name}\n" + " TEMPERATURE\n temp\n C\n"
                                " SOOT EXTINCTION COEFFICIENT\n ext\n 1/m\n" + " TEMPERATURE\n temp\n C\n" * 3)

    def check_same(self, *arguments, ranks=(2, 4), suffix=".exr", within=1e-5):
        self.works(*arguments, "-o", self.path("alone" + suffix))
        for count in ranks:
            self.succeeds(count, *arguments, "-o", self.path("ours" + suffix), "--by-pieces")
            difference = self.works("compare", self.path("alone" + suffix), self.path("ours" + suffix), "--json").json["max_error"]
            self.assertLessEqual(difference, within, (count, arguments))

    def scene(self, case, lights, **members):
        scene = {"format": "volute-scene-1", "background": [0.2, 0.3, 0.4], "lights": lights,
                 "camera": {"eye": [-4, -6, 5], "target": [5, 2, 1], "up": [0, 0, 1], "fov": 40, "size": [60, 40]},
                 "media": [{"kind": "smoke", "case": case.name, "albedo": [0.8, 0.7, 0.6], "building": "open"} | members]}
        self.path("scene.json").write_text(json.dumps(scene))
        return self.path("scene.json")

    def test_smoke(self):
        case = self.case()
        self.check_same("render", case, *self.VIEW, "--aov", "optical-depth", ranks=(2, 3, 4))
        self.check_same("render", case, *self.VIEW, "--measured", "--time", "1.7")
        self.check_same("render", case, *self.VIEW, "--mode", "threshold", "--scale", "0.5", "--measured", ranks=(2,))
        # As a person would, without anything said: the same time, view and caption, to one level of what a display shows.
        self.check_same("render", case, ranks=(3,), suffix=".png", within=2.28 / 255)

    def test_overlapping_meshes(self):
        self.check_same("render", self.case(overlapping=True), *self.VIEW, "--measured", ranks=(2, 4))

    def test_plot3d(self):
        case = self.case()
        self.add_plots(case)
        self.check_same("render", case, *self.VIEW, "--field", "plot3d-extinction", "--aov", "optical-depth", "--time", "1")
        self.check_same("render", case, *self.VIEW, "--field", "plot3d-extinction", "--measured", "--time", "2", ranks=(3,))

    def test_lamps_light_smoke_and_walls(self):
        lights = [{"kind": "ambient", "radiance": [0.3, 0.3, 0.4]}, {"kind": "sun", "direction": [0.5, 0.3, -1], "radiance": [1, 0.9, 0.8]},
                  {"kind": "spot", "position": [3, 2, 2.2], "target": [6, 2, 0], "angle": 100, "intensity": [3, 2, 1]}]
        for members in ({}, {"scale": 2.0}):  # one process goes in steps, ranks by exact pieces: both are within their bound
            self.check_same("render", self.scene(self.case(), lights, **members), "--measured", "--time", "1", ranks=(2, 4),
                            within=5e-4)

    def test_fire_and_signs(self):
        scene = self.scene(self.case(fire=True), [{"kind": "ambient", "radiance": [1, 1, 1]}])
        text = json.loads(scene.read_text())
        text["signs"] = [{"position": [9.9, 2, 1.8], "normal": [-1, 0, 0], "size": [0.6, 0.3], "emitting": True}]
        scene.write_text(json.dumps(text))
        self.check_same("render", scene, "--measured", "--time", "2.5", ranks=(2, 4))
        self.check_same("render", scene, "--measured", "--time", "1", ranks=(3,))

    def test_what_ranks_cannot_share(self):
        case = self.case(fire=True, overlapping=True)
        arguments = ("render", case, *self.VIEW, "-o", self.path("x.exr"), "--by-pieces", "--quiet")
        self.assertIn("has 4 meshes, and 5 ranks cannot hold one each", self.says(5, *arguments))
        self.assertIn("overlap, so two ranks cannot hold one each where there is fire", self.says(4, *arguments))
        self.succeeds(4, *arguments, "--fire", "0")
        self.path("x.exr").unlink()
        self.assertIn("no iso-surfaces", self.says(2, *arguments, "--fire", "0", "--fds-iso", "SOOT EXTINCTION COEFFICIENT=0.2"))
        self.path("case_3_1.sf").unlink()
        self.assertIn("case_3_1.sf", self.says(2, *arguments))


class Slurm(Cluster):
    """The example scripts, with what a scheduler gives them."""

    def runs_script(self, name, *arguments, task=1):
        tools = self.path("tools")
        tools.mkdir(exist_ok=True)
        if not (tools / "volute").exists():
            (tools / "volute").symlink_to(PROGRAM)
            # Takes the place of srun: its own options are left out.
            (tools / "srun").write_text('#!/bin/sh\nwhile [ "${1#-}" != "$1" ]; do shift; done\nexec mpirun --oversubscribe -n 2 "$@"\n')
            (tools / "srun").chmod(0o755)
        script = pathlib.Path(__file__).resolve().parents[2] / "examples" / "slurm" / name
        environment = mpirun(1)[1] | {"PATH": f"{tools}:{os.environ['PATH']}", "SLURM_ARRAY_TASK_ID": str(task), "SLURM_CPUS_PER_TASK": "2"}
        done = subprocess.run(["sh", script, *map(str, arguments)], env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, timeout=limit())
        self.assertEqual(done.returncode, 0, done.stderr.decode())

    @unittest.skipUnless(HAS_MPI, "no mpirun, or Volute was built without MPI")
    def test_one_job(self):
        source = self.make_npy(frames=20, size=12)
        self.runs_script("one_job.sh", source, self.path("out.volute"))
        self.works("compress", source, "-o", self.path("alone.volute"), "--rms", "0.003")
        self.assertEqual(self.path("out.volute").read_bytes(), self.path("alone.volute").read_bytes())
        self.assertEqual(len(json.loads(self.path("out.json").read_text())["ranks"]), 2)

    def test_array_of_cases(self):
        study = self.study()
        case = json.loads(study.read_text())["cases"][0]
        self.path("cases.txt").write_text(f"elsewhere.smv\n{case}\n")
        for _ in range(2):  # again: what is there is left out
            self.runs_script("array_of_cases.sh", self.path("cases.txt"), self.path("signs.json"), self.path("results"), task=2)
            report = self.path("results/0002/visibility.json")
            self.assertTrue(report.exists())
        self.works("synthesize", "hall", "-o", self.path("mesh.pvd"), "--cell", "0.5", "--frames", 2)
        self.path("meshes.txt").write_text(f"{self.path('mesh.pvd')}\n")
        self.runs_script("array_of_cases.sh", self.path("meshes.txt"), self.path("signs.json"), self.path("meshes"), "--quantity", "soot-density",
                         "--field", "soot", "--unit", "g/m3")
        self.assertTrue(self.path("meshes/0001/visibility.json").exists())

    def test_study(self):
        study = self.study()
        runs = self.works("sweep", study, "--list").text.splitlines()
        self.assertEqual(len(runs), 6)
        for task in range(1, 6):
            self.runs_script("study.sh", study, self.path("out"), task=task)
        self.works("sweep", study, "-o", self.path("out"))
        self.assertIn("1 of 6 runs failed: ", self.works("sweep", study, "-o", self.path("alone")).message)
        self.assertEqual((self.path("out") / "study.csv").read_bytes(), (self.path("alone") / "study.csv").read_bytes())


@unittest.skipUnless(HAS_MPI, "no mpirun, or Volute was built without MPI")
class BadInput(Cluster):
    def test_verbs_of_one_process(self):
        packed = self.make_volute()
        self.assertIn("'info' is done by one process", self.says(2, "info", packed, code=2))

    def test_a_file_that_nobody_sees(self):
        self.assertIn("nothing.volute: cannot open", self.says(3, "render", self.path("nothing.volute"), "-o", self.path("x.png")))

    def test_a_file_that_one_rank_does_not_see(self):
        packed = self.make_volute()
        script = self.path("ranks.sh")
        # As on a machine that lacks the folder: rank 1 gets another one under the same name.
        script.write_text('#!/bin/sh\ncd "$1/$OMPI_COMM_WORLD_RANK"; shift; exec "$@"\n')
        script.chmod(0o755)
        for rank in range(3):
            self.path(str(rank)).mkdir()
        for rank in (0, 2):
            shutil.copy(packed, self.path(str(rank)) / "in.volute")
        command, environment = mpirun(3, script, self.folder, PROGRAM, "render", "in.volute", "-o", self.path("x_%d.png"))
        done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=limit())
        self.assertEqual(done.returncode, 1)
        self.assertIn("volute render: rank 1: in.volute: cannot open", done.stderr.decode())
        # And a folder for results that is not shared.
        shutil.copy(packed, self.path("1") / "in.volute")
        command[-1] = "x_%d.png"
        done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=limit())
        self.assertEqual(done.returncode, 1)
        self.assertIn("is another folder than that of rank 0", done.stderr.decode())
        self.assertEqual(list(self.folder.glob("*/x_*")), [])

    def test_other_arguments(self):
        packed = self.make_volute()
        command, environment = mpirun(1, PROGRAM, "render", packed, "-o", self.path("x.png"), "--max-memory", "1G",
                                      ":", "-n", "1", PROGRAM, "render", packed, "-o", self.path("x.png"), "--max-memory", "2G")
        done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=limit())
        self.assertEqual(done.returncode, 1)
        self.assertIn("expected the same arguments everywhere", done.stderr.decode())

    def test_another_version(self):
        packed = self.make_volute()
        other = self.path("other")
        (other / "lib" / "volute").mkdir(parents=True)
        (other / "bin").mkdir()
        program = PROGRAM.read_bytes()
        version = re.search(rb"volute (\d+\.\d+\.\d+)", subprocess.run([PROGRAM, "--version"], stdout=subprocess.PIPE).stdout).group(1)
        later = version[:-1] + (b"8" if version[-1:] != b"8" else b"7")
        changed = program.replace(version + b"\0", later + b"\0")
        self.assertNotEqual(changed, program)
        (other / "bin" / "volute").write_bytes(changed)
        (other / "bin" / "volute").chmod(0o755)
        plugin = (PLUGINS / "volute_mpi.so").read_bytes().replace(version + b"\0", later + b"\0")
        (other / "lib" / "volute" / "volute_mpi.so").write_bytes(plugin)
        arguments = ["render", packed, "-o", self.path("x.png")]
        command, environment = mpirun(1, PROGRAM, *arguments, ":", "-n", "1", other / "bin" / "volute", *arguments)
        done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=limit())
        self.assertEqual(done.returncode, 1)
        self.assertIn("expected one version everywhere", done.stderr.decode())

    def test_more_ranks_than_units(self):
        packed = self.make_volute(frames=2)
        self.succeeds(8, "render", packed, "-o", self.path("x_%d.png"), "--size", "16x16")
        self.assertEqual([name for name in self.files() if name.endswith(".png")], ["x_0.png", "x_1.png"])
        self.succeeds(6, "extract", packed, "-o", self.path("x.npy"))
        self.works("extract", packed, "-o", self.path("y.npy"))
        self.assertEqual(self.path("x.npy").read_bytes(), self.path("y.npy").read_bytes())
        self.succeeds(6, "compress", self.path("x.npy"), "-o", self.path("x.volute"))
        self.works("compress", self.path("x.npy"), "-o", self.path("y.volute"))
        self.assertEqual(self.path("x.volute").read_bytes(), self.path("y.volute").read_bytes())

    def test_folders_that_are_not_shared(self):
        """Of each command whose ranks write by themselves: each rank has a folder of its own under one name."""
        script = self.path("ranks.sh")
        script.write_text('#!/bin/sh\ncd "$1/$OMPI_COMM_WORLD_RANK"; shift; exec "$@"\n')
        script.chmod(0o755)
        for rank in range(2):
            self.path(str(rank)).mkdir()
        capture = self.path("capture.json")
        capture.write_text(json.dumps(ring.capture() | {"frames": [0, 1]}))
        self.works("synthesize", "fire", "-o", self.path("truth.npy"), "--size", "16", "--frames", "2")
        self.works("project", self.path("truth.npy"), capture, "-o", self.path("{camera}_%04d.exr"))
        study = self.study()
        case = json.loads(study.read_text())["cases"][0]
        for arguments in (("sweep", study, "-o", "out"),
                          ("visibility", case, "--signs", self.path("signs.json"), "-o", "out", "--height", "1.2", "--step", "0.5"),
                          ("compress", self.path("truth.npy"), "-o", self.path("x.volute"), "--work", "work"),
                          ("reconstruct", capture, "-o", "out.volute", "--resolution", "8", "--iterations", "2", "--force")):
            command, environment = mpirun(2, script, self.folder, PROGRAM, *arguments)
            done = subprocess.run(command, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                  timeout=limit())
            said = [line for line in done.stderr.decode().splitlines() if line.startswith("volute")]
            self.assertEqual((done.returncode, len(said)), (1, 1), (arguments[0], done.stderr.decode()))
            self.assertIn("is another folder than that of rank 0", said[0])
            self.assertEqual([path for rank in range(2) for path in self.path(str(rank)).rglob("*") if path.is_file()], [], arguments[0])
            self.assertFalse(self.path("x.volute").exists())

    def test_without_the_plug_in(self):
        packed = self.make_volute()
        (self.path("alone") / "bin").mkdir(parents=True)
        shutil.copy(PROGRAM, self.path("alone") / "bin" / "volute")
        program = self.path("alone") / "bin" / "volute"
        arguments = ["render", packed, "-o", self.path("x.png"), "--size", "16x16"]
        command, environment = mpirun(2, program, *arguments, environment={"VOLUTE_PLUGIN_FOLDER": str(self.path("alone"))})
        done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=limit())
        self.assertEqual(done.returncode, 1)
        said = [line for line in done.stderr.decode().splitlines() if line.startswith("volute")]
        self.assertEqual(len(said), 1, said)
        self.assertIn("the part of Volute that uses MPI cannot be loaded", said[0])
        self.assertEqual(subprocess.run([program, *arguments], stderr=subprocess.PIPE).returncode, 0)

    def test_a_broken_mpi(self):
        """The plug-in is cut off, or MPI itself cannot start: a word of ours or of MPI's, and an end."""
        packed = self.make_volute()
        arguments = ("render", packed, "-o", self.path("x.png"), "--size", "16x16")
        for folder in ("bin", "lib/volute"):
            (self.path("other") / folder).mkdir(parents=True)
        shutil.copy(PROGRAM, self.path("other/bin/volute"))
        plugin = (PLUGINS / "volute_mpi.so").read_bytes()
        for kept in (0, 100, 5000, len(plugin) - 1):
            self.path("other/lib/volute/volute_mpi.so").write_bytes(plugin[:kept])
            command, environment = mpirun(2, self.path("other/bin/volute"), *arguments)
            done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=limit())
            said = [line for line in done.stderr.decode().splitlines() if line.startswith("volute")]
            self.assertEqual((done.returncode, len(said)), (1, 1), (kept, done.stderr.decode()))
            self.assertIn("volute_mpi.so is cut off; install it again", said[0])
        shutil.rmtree(self.path("other"))
        before = self.files()
        code, _, message = self.runs(2, *arguments, environment={"OMPI_MCA_pml": "nothing"})
        self.assertEqual((code, self.files()), (1, before), message)
        self.assertRegex(message, "pml|MPI_INIT|ORTE_ERROR_LOG")  # what a launcher passes on of it is cut off at times

    def test_a_launcher_of_another_mpi(self):
        """Processes that do not find each other would all do all of the work."""
        packed = self.make_volute()
        done = support.volute("render", packed, "-o", self.path("x.png"), env=os.environ | {"PMI_RANK": "0", "PMI_SIZE": "4"})
        self.assertEqual(done.code, 1)
        self.assertIn("the launcher belongs to another MPI", done.message)

    def test_a_killed_rank_ends_all(self):
        packed = self.make_volute(frames=12, size=16)
        for victim in (0, 1, 2):
            process = start(3, "render", packed, "-o", self.path("x_%02d.exr"), "--size", "900x900", "--renderer", "reference")
            end = time.monotonic() + limit()
            while len(ranks_of(process.pid)) < 3 and time.monotonic() < end:
                time.sleep(0.02)
            time.sleep(0.5)
            self.assertTrue(kill(sorted(ranks_of(process.pid))[victim]))
            self.others_end(process, 10)
            _, message = finish(process)
            self.assertNotEqual(process.returncode, 0)
            self.assertIn("signal 9", message.decode())
            whole = [name for name in self.files() if name.startswith("x_")]
            for name in whole:  # each picture is there whole or not at all
                self.works("compare", self.path(name), self.path(name))
                self.path(name).unlink()
            for name in self.files():
                if ".part" in name:  # of the rank that was killed
                    self.path(name).unlink()

    def test_ranks_end_where_the_launcher_does_not_see_a_death(self):
        """A launcher that stands still cannot end the others, which wait for the one that was killed."""
        source, noise = self.path("in.npy"), random.Random(1)  # far from packed when a rank is killed
        support.write_npy(source, (60, 48, 48, 48), [noise.random() for _ in range(60 * 48**3)])
        for victim in (0, 2):
            process = start(3, "compress", source, "-o", self.path("x.volute"), "--rms", "0.0001")
            end = time.monotonic() + limit()
            while len(ranks_of(process.pid)) < 3 and time.monotonic() < end:
                time.sleep(0.02)
            while not all(map(self.spools, ranks_of(process.pid))) and time.monotonic() < end:
                time.sleep(0.02)
            time.sleep(0.3)
            there = sorted(ranks_of(process.pid))
            self.assertEqual(len(there), 3)
            process.send_signal(signal.SIGSTOP)
            try:
                self.assertTrue(kill(there[victim]))
                killed = time.monotonic()
                while ranks_of(process.pid) and time.monotonic() - killed < limit():
                    time.sleep(0.05)
                took = time.monotonic() - killed
                self.assertEqual(ranks_of(process.pid), [])
            finally:
                process.send_signal(signal.SIGCONT)
            _, message = finish(process)
            self.assertLess(took, 10 * limit() / 60)
            self.assertNotEqual(process.returncode, 0)
            if victim != 0:
                self.assertIn("rank 2 ", message.decode())
                self.assertIn("has ended without a word", message.decode())
            self.assertFalse(self.path("x.volute").exists())
            for name in self.files():
                if ".part" in name:  # of the rank that was killed
                    self.path(name).unlink()

    def test_a_rank_killed_while_it_compresses(self):
        source = self.make_npy(frames=70, size=24)
        killed_runs = 0
        for wait in (0.0, 0.3, 0.8, 1.5):
            process = start(3, "compress", source, "-o", self.path("x.volute"), "--rms", "0.0005")
            end = time.monotonic() + limit()
            while len(ranks_of(process.pid)) < 3 and time.monotonic() < end:
                time.sleep(0.02)
            time.sleep(wait)
            there = ranks_of(process.pid)
            if len(there) < 3:  # a fast machine is done by then
                finish(process)
                self.path("x.volute").unlink()
                continue
            kill(there[-1])
            self.others_end(process, 10)
            _, message = finish(process)
            if process.returncode == 0:  # it had nothing left to do
                self.works("compare", source, self.path("x.volute"))
                self.path("x.volute").unlink()
                continue
            self.assertIn("signal 9", message.decode())
            left = [name for name in self.files() if name != "in.npy"]
            if left:  # it was done, and whole, when the rank died
                self.assertEqual(left, ["x.volute"])
                self.works("compare", source, self.path("x.volute"))
                self.path("x.volute").unlink()
            killed_runs += 1
        self.assertGreater(killed_runs, 0)

    def test_an_interrupted_run_goes_on(self):
        source = self.make_npy(frames=70, size=24)
        arguments = ("compress", source, "-o", self.path("x.volute"), "--rms", "0.0005")
        self.works(*arguments)
        expected = self.path("x.volute").read_bytes()
        self.path("x.volute").unlink()
        work = self.path("work")
        for ranks, wait in ((2, 0.6), (4, 1.0), (1, 0.4), (3, None)):
            process = start(ranks, *arguments, "--work", work)
            if wait:
                end = time.monotonic() + limit()
                while not (work.exists() and any(work.iterdir())) and process.poll() is None and time.monotonic() < end:
                    time.sleep(0.02)
                time.sleep(wait)
                for rank in ranks_of(process.pid)[-1:]:
                    kill(rank)
            _, message = finish(process)
            if process.returncode == 0:
                break
            self.assertIsNotNone(wait, message.decode())
            if self.path("x.volute").exists():  # killed after it was written
                self.assertEqual(self.path("x.volute").read_bytes(), expected)
                self.path("x.volute").unlink()
        self.assertEqual(self.path("x.volute").read_bytes(), expected)
        self.assertFalse(work.exists())

    def test_a_full_disk_on_one_rank(self):
        """Rank 1 has a folder of one page in the target's place; what it compresses goes there."""
        if subprocess.run(["unshare", "-rm", "true"], stderr=subprocess.DEVNULL).returncode != 0:
            self.skipTest("file systems cannot be mounted here")
        shape, values = support.plume(40, 12)
        draw = random.Random(1)
        support.write_npy(self.path("in.npy"), shape, [value + draw.random() for value in values])
        self.path("out").mkdir()
        script = self.path("ranks.sh")
        script.write_text('#!/bin/sh\n[ "$OMPI_COMM_WORLD_RANK" = 1 ] || exec "$@"\n'
                          f'exec unshare -rm sh -c \'mount -t tmpfs -o size=4k none {self.path("out")} && exec "$@"\' - "$@"\n')
        script.chmod(0o755)
        command, environment = mpirun(3, script, PROGRAM, "compress", self.path("in.npy"), "-o", self.path("out/x.volute"), "--rms", "0.0001",
                                      "--bounds", "0,0,0,1,1,1")
        done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=limit())
        said = [line for line in done.stderr.decode().splitlines() if line.startswith("volute") and "no times are stated" not in line]
        self.assertEqual(done.returncode, 1, said)
        self.assertEqual(len(said), 1, said)
        self.assertRegex(said[0], "rank 1: .*No space left on device")
        self.assertEqual(list(self.path("out").iterdir()), [])

    def test_not_a_number_in_one_unit(self):
        shape, values = support.plume(40, 12)
        values[30 * 12 ** 3 + 5] = float("nan")
        support.write_npy(self.path("in.npy"), shape, values)
        self.assertIn("frame 30: the value at voxel (5, 0, 0)", self.says(3, "compress", self.path("in.npy"), "-o", self.path("x.volute"), "--rms", "0.01", "--fps", "25",
                                                                              "--bounds", "0,0,0,1,1,1"))

    def test_ctrl_c(self):
        packed = self.make_volute(frames=12, size=16)
        process = start(3, "render", packed, "-o", self.path("x_%02d.exr"), "--size", "900x900", "--renderer", "reference")
        end = time.monotonic() + limit()
        while len(ranks_of(process.pid)) < 3 and process.poll() is None and time.monotonic() < end:
            time.sleep(0.02)
        time.sleep(1)
        process.send_signal(signal.SIGINT)
        _, message = finish(process)
        self.assertNotEqual(process.returncode, 0)
        self.assertEqual([name for name in self.files() if ".part" in name], [])


if __name__ == "__main__":
    support.main()
