#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""tools/damage.py --bin build/dev/bin/volute: what becomes of damaged files. One harness for every format: a small file is cut
at so many places and has a bit flipped at so many, half of them in its header and half after it; the program reads each and
either refuses it, remarks on it, says the same as of the whole file, or says something else without a word (silent). It must neither crash, nor take longer
than 5 s, nor leave a file behind. Where programs of others are installed (vdb_print, ncdump, ffprobe, exrheader, pngcheck),
they read the same files. Prints a table in Markdown; exits with 1 when something crashed, hung or was left."""
import argparse
import collections
import concurrent.futures
import json
import os
import pathlib
import random
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import zipfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
COUNTS = ("refused", "remarked", "same", "silent", "crash", "hang", "left")

Format = collections.namedtuple("Format", "name file header command make peer", defaults=(None,))


def box_points():
    return [(x, y, z) for z in range(2) for y in range(2) for x in range(3)]


def hexahedron(first):
    return [first, first + 1, first + 4, first + 3, first + 6, first + 7, first + 10, first + 9]


class Samples:
    """Writes a small case of a format into a folder."""

    def __init__(self, volute):
        self.volute = volute
        sys.path.insert(0, str(ROOT / "tests/cli"))
        os.environ["VOLUTE"] = volute

    def run(self, *arguments):
        subprocess.run([self.volute, *map(str, arguments)], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def npy(self, folder, name="a.npy"):
        import support
        support.write_npy(folder / name, *support.plume(2, 12))

    def npz(self, folder):
        self.npy(folder, "density.npy")
        with zipfile.ZipFile(folder / "a.npz", "w", zipfile.ZIP_DEFLATED) as archive:
            archive.write(folder / "density.npy", "density.npy")
        (folder / "density.npy").unlink()

    def converted(self, name):
        def make(folder):
            self.npy(folder, "made.npy")
            self.run("compress", folder / "made.npy", "-o", folder / "made.volute", "--rms", "0.002")
            if name.endswith(".volute"):
                (folder / "made.volute").rename(folder / name)
            else:
                self.run("extract", folder / "made.volute", "-o", folder / name, "--frames", "0:1")
            for file in folder.glob("made.*"):
                file.unlink()
        return make

    def ball(self, folder):
        self.run("synthesize", "ball", "-o", folder / "a.vtu", "--cell", "1.5")

    def series(self, folder):
        import smoke_files
        mesh = smoke_files.box((0, 0, 0), (2, 2, 2), (2, 2, 2))
        for i in range(2):
            smoke_files.write_vtu(folder / f"{i}.vtu", mesh, {"smoke": [1.0 + i + p[0] for p in mesh[0]]})
        smoke_files.write_pvd(folder / "a.pvd", {1: "0.vtu", 2.5: "1.vtu"})

    def legacy(self, folder):
        points = box_points()
        text = "# vtk DataFile Version 3.0\nbox\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 12 float\n"
        text += "".join("%g %g %g\n" % p for p in points) + "CELLS 2 18\n"
        text += "".join("8 " + " ".join(map(str, hexahedron(f))) + "\n" for f in (0, 1)) + "CELL_TYPES 2\n12\n12\n"
        text += "POINT_DATA 12\nSCALARS smoke float 1\nLOOKUP_TABLE default\n" + "".join("%g\n" % (1 + p[0]) for p in points)
        (folder / "a.vtk").write_text(text)

    def ensight(self, folder):
        points = box_points()
        (folder / "a.case").write_text("FORMAT\ntype: ensight gold\n\nGEOMETRY\nmodel: a.geo\n\nVARIABLE\n"
                                       "scalar per node: smoke a.smoke\n")
        text = "box\nof two\nnode id off\nelement id off\npart\n         1\nall\ncoordinates\n        12\n"
        for axis in range(3):
            text += "".join("%12.5e\n" % p[axis] for p in points)
        text += "hexa8\n         2\n" + "".join("".join("%10d" % (i + 1) for i in hexahedron(f)) + "\n" for f in (0, 1))
        (folder / "a.geo").write_text(text)
        (folder / "a.smoke").write_text("smoke\npart\n         1\ncoordinates\n" + "".join("%12.5e\n" % (1 + p[0]) for p in points))

    def exodus(self, folder):
        maker = pathlib.Path(self.volute).with_name("volute_exodus_maker")
        if not maker.exists():
            raise FileNotFoundError("no volute_exodus_maker beside the program")
        subprocess.run([maker, folder / "a.ex2"], check=True, stdout=subprocess.DEVNULL)

    def foam(self, folder):
        def head(kind, name):
            return f"FoamFile\n{{\n version 2.0;\n format ascii;\n class {kind};\n object {name};\n}}\n"
        mesh = folder / "constant/polyMesh"
        mesh.mkdir(parents=True)
        (folder / "system").mkdir()
        (folder / "10").mkdir()
        (folder / "a.foam").write_text("")
        (folder / "system/controlDict").write_text(
            head("dictionary", "controlDict") + "application x;\nstartFrom startTime;\nstartTime 10;\nstopAt endTime;\n"
            "endTime 10;\ndeltaT 10;\nwriteControl timeStep;\nwriteInterval 1;\n")
        (mesh / "points").write_text(head("vectorField", "points") + "12\n(\n"
                                     + "".join("(%g %g %g)\n" % p for p in box_points()) + ")\n")
        (mesh / "faces").write_text(head("faceList", "faces") + "11\n(\n4(1 4 10 7)\n4(0 6 9 3)\n4(2 5 11 8)\n4(0 1 7 6)\n"
                                    "4(1 2 8 7)\n4(3 9 10 4)\n4(4 10 11 5)\n4(0 3 4 1)\n4(1 4 5 2)\n4(6 7 10 9)\n4(7 8 11 10)\n)\n")
        (mesh / "owner").write_text(head("labelList", "owner") + "11\n(\n0\n0\n1\n0\n1\n0\n1\n0\n1\n0\n1\n)\n")
        (mesh / "neighbour").write_text(head("labelList", "neighbour") + "1\n(\n1\n)\n")
        (mesh / "boundary").write_text(head("polyBoundaryMesh", "boundary")
                                       + "1\n(\nwalls\n{\n type wall;\n nFaces 10;\n startFace 1;\n}\n)\n")
        (folder / "10/soot").write_text(head("volScalarField", "soot") + "dimensions [0 -1 0 0 0 0 0];\ninternalField nonuniform "
                                        "List<scalar>\n2\n(\n1\n2\n)\n;\nboundaryField\n{\nwalls\n{\ntype zeroGradient;\n}\n}\n")

    def fds(self, folder):
        import fds_test
        fds_test.write_case(lambda name: folder / name)

    def stored(self, folder):
        import fds_test
        fds_test.add_stored(lambda name: folder / name, fds_test.write_case(lambda name: folder / name))

    def walls(self, folder):
        """The case, and a box of triangles in it."""
        self.looking(self.fds)(folder)
        corners = [c for i in range(8) for c in (0.3 + 0.4 * (i & 1), 0.3 + 0.4 * (i >> 1 & 1), 0.3 * (i >> 2))]
        faces = [1, 5, 7, 1, 7, 3, 2, 4, 8, 2, 8, 6, 1, 2, 6, 1, 6, 5, 3, 7, 8, 3, 8, 4, 1, 3, 4, 1, 4, 2, 5, 6, 8, 5, 8, 7]
        records = [struct.pack("<i", 1), struct.pack("<i", 2), struct.pack("<3i", 0, 0, 1), struct.pack("<f", 0), struct.pack("<3i", 8, 12, 0),
                   struct.pack("<24f", *corners), struct.pack("<36i", *faces), bytes(48), bytes(288), struct.pack("<f", 0), bytes(12)]
        (folder / "case.ge").write_bytes(b"".join(struct.pack("<i", len(r)) + r + struct.pack("<i", len(r)) for r in records))
        with open(folder / "case.smv", "a") as index:
            index.write("GEOM 1\n case.ge\n")

    def scene(self, geometry):
        def make(folder):
            import geometry_test
            (folder / "a.obj").write_text(geometry_test.obj(geometry_test.floor(half=2.0)))
            (folder / "a.glb").write_bytes(geometry_test.glb([(-1, -1, 1), (1, -1, 1), (0, 1, 1)]))
            (folder / "a.json").write_text(json.dumps({
                "format": "volute-scene-1", "background": [9, 9, 9], "geometry": [{"file": geometry}],
                "camera": {"eye": [0, 0, 10], "target": [0, 0, 0], "up": [0, 1, 0], "ortho": 8, "size": [16, 16]}}))
        return make

    def picture(self, name):
        def make(folder):
            import pictures
            picture = pictures.Picture(24, 16, 3, [0.1 + 0.8 * ((7 * i) % 31) / 31 for i in range(24 * 16 * 3)])
            for file in (name, "whole" + name[-4:]):
                (pictures.write_png if name.endswith(".png") else pictures.write_exr)(folder / file, picture)
        return make

    def capture(self, folder):
        import ring
        (folder / "a.json").write_text(json.dumps(ring.capture(), indent=1))
        import support
        support.write_npy(folder / "fire.npy", *support.plume(4, 8, 3))

    def drawing(self, folder):
        """The case, and lines, a polyline with a bulge and a block that is inserted."""
        self.looking(self.fds)(folder)
        def entity(kind, **groups):
            return f"0\n{kind}\n8\nwalls\n" + "".join(f"{code[1:]}\n{value}\n" for code, value in groups.items())
        line = entity("LINE", g10=0.2, g20=0.2, g11=1.6, g21=0.8)
        arc = entity("ARC", g10=1, g20=0.5, g40=0.3, g50=10, g51=200)
        (folder / "a.dxf").write_text(
            "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1015\n9\n$INSUNITS\n70\n6\n0\nENDSEC\n"
            "0\nSECTION\n2\nBLOCKS\n0\nBLOCK\n8\n0\n2\ndoor\n70\n0\n10\n0\n20\n0\n" + arc + "0\nENDBLK\n0\nENDSEC\n"
            "0\nSECTION\n2\nENTITIES\n" + line + entity("LINE", g10=0.1, g20=0.1, g11=1.9, g21=0.1)
            + "0\nLWPOLYLINE\n8\nwalls\n90\n3\n70\n1\n10\n0.5\n20\n0.3\n42\n0.5\n10\n1.2\n20\n0.3\n10\n1.2\n20\n0.7\n"
            + entity("INSERT", g2="door", g10=0.4, g20=0.2, g41=0.5, g42=0.5, g50=30) + "0\nENDSEC\n0\nEOF\n")

    def looking(self, make):
        """The case with a sign and eyes, all within the box of the cases here."""
        def both(folder):
            make(folder)
            (folder / "signs.json").write_text(json.dumps({"signs": [
                {"name": "exit", "position": [1.75, 0.5, 0.5], "normal": [-1, 0, 0], "size": [0.1, 0.1]}]}))
            (folder / "eyes.csv").write_text("x,y,z\n" + "".join(f"{0.2 + 0.15 * i},0.3,0.6\n" for i in range(8)))
        return both

    def signs(self, folder):
        import sight_cases
        sight_cases.write_vtu(folder / "a.vtu", (4, 4, 3), (2, 2, 2), lambda x, y, z: 0.1)
        (folder / "signs.json").write_text(json.dumps({"signs": [
            {"name": "exit", "position": [2, 0.1, 2], "normal": [0, 1, 0], "size": [0.6, 0.3]}]}, indent=1))
        (folder / "eyes.csv").write_text("x,y,z\n" + "".join(f"2,{1 + 0.25 * i},2\n" for i in range(8)))


def formats(samples):
    info = ["info", "FILE", "--values", "--json"]
    render = ["render", "a.json", "-o", "-OUT-.exr", "--renderer", "reference"]
    signs = ["--signs", "signs.json", "--eyes", "eyes.csv", "-o", "-OUT-"]
    sight = ["visibility", "a.vtu", "--quantity", "extinction", *signs]

    def mesh(case):
        return ["visibility", case, "--quantity", "extinction", *signs]

    stored = ["render", "case.smv", "-o", "-OUT-.exr", "--size", "24x18", "--time", "10"]
    lattice = ["compare", "WHOLE", "FILE", "--json"]
    return [
        Format(".volute", "a.volute", 300, lattice, samples.converted("a.volute")),
        Format(".npy", "a.npy", 128, lattice, samples.npy),
        Format(".npz", "a.npz", 60, lattice, samples.npz),
        Format(".vdb", "a_0000.vdb", 2000, lattice, samples.converted("a_%04d.vdb"), ["vdb_print", "-l", "FILE"]),
        Format(".nvdb", "a_0000.nvdb", 2000, lattice, samples.converted("a_%04d.nvdb")),
        Format(".vti", "a_0000.vti", 700, lattice, samples.converted("a_%04d.vti")),
        Format(".vtu, text", "0.vtu", 300, mesh("0.vtu"), samples.looking(samples.series)),
        Format(".vtu, appended", "a.vtu", 600, info, samples.ball),
        Format(".pvd", "a.pvd", 60, mesh("a.pvd"), samples.looking(samples.series)),
        Format("legacy .vtk", "a.vtk", 80, mesh("a.vtk"), samples.looking(samples.legacy)),
        Format("EnSight .case", "a.case", 60, mesh("a.case"), samples.looking(samples.ensight)),
        Format("EnSight geometry", "a.geo", 80, mesh("a.case"), samples.looking(samples.ensight)),
        Format("EnSight field", "a.smoke", 40, mesh("a.case"), samples.looking(samples.ensight)),
        Format("Exodus", "a.ex2", 3000, [*mesh("a.ex2"), "--field", "smoke"], samples.looking(samples.exodus), ["ncdump", "FILE"]),
        Format("OpenFOAM points", "constant/polyMesh/points", 90, mesh("a.foam"), samples.looking(samples.foam)),
        Format("OpenFOAM faces", "constant/polyMesh/faces", 90, mesh("a.foam"), samples.looking(samples.foam)),
        Format("OpenFOAM field", "10/soot", 110, mesh("a.foam"), samples.looking(samples.foam)),
        Format("FDS .smv", "case.smv", 120, ["visibility", "case.smv", *signs], samples.looking(samples.fds)),
        Format("FDS .sf", "case_1.sf", 150, ["visibility", "case.smv", *signs], samples.looking(samples.fds)),
        Format("FDS .ge", "case.ge", 100, ["visibility", "case.smv", *signs], samples.walls),
        Format("FDS .iso", "case_1.iso", 200, [*stored, "--fds-iso", "TEMPERATURE"], samples.stored),
        Format("FDS .prt5", "case_2.prt5", 200, [*stored, "--fds-particles", "all"], samples.stored),
        Format("DXF underlay", "a.dxf", 250, ["visibility", "case.smv", "--signs", "signs.json", "--height", "0.6", "--step", "0.25",
                                              "--maps", "aset", "--underlay", "a.dxf", "-o", "-OUT-"], samples.drawing),
        Format(".obj", "a.obj", 30, render, samples.scene("a.obj")),
        Format(".glb", "a.glb", 500, render, samples.scene("a.glb")),
        Format("scene .json", "a.json", 60, render, samples.scene("a.obj")),
        Format(".png", "a.png", 33, ["compare", "whole.png", "FILE", "--json"], samples.picture("a.png"), ["pngcheck", "FILE"]),
        Format(".exr", "a.exr", 300, ["compare", "whole.exr", "FILE", "--json"], samples.picture("a.exr"), ["exrheader", "FILE"]),
        Format("capture.json", "a.json", 120, ["project", "fire.npy", "a.json", "-o", "-OUT-_{camera}_%04d.exr"], samples.capture),
        Format("signs.json", "signs.json", 40, sight, samples.signs),
        Format("eyes .csv", "eyes.csv", 6, sight, samples.signs),
    ]


def damages(whole, header, cuts, flips, seed):
    """(kind, place, bytes): kind is cut or flip, place header or payload."""
    chance = random.Random(seed)
    header = min(header, len(whole) // 2)
    lengths = list(range(len(whole)))
    for length in sorted(chance.sample(lengths, min(cuts, len(lengths)))):
        yield "cut", "header" if length < header else "payload", whole[:length]
    for i in range(flips):
        place = "header" if i % 2 else "payload"
        at = chance.randrange(header) if i % 2 else chance.randrange(header, len(whole))
        changed = bytearray(whole)
        changed[at] ^= 1 << chance.randrange(8)
        yield "flip", place, bytes(changed)


def listing(folder):
    return {str(path.relative_to(folder)) for path in folder.rglob("*")}


def outcome_of(command, folder, longest):
    """(exit code or None for a hang, its result, names left behind, remarks); what it wrote is removed."""
    before = listing(folder)
    command = [part.replace("-OUT-", "zz_out") for part in command]
    try:
        done = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, stdin=subprocess.DEVNULL,
                              timeout=longest)
        code, said, remarks = done.returncode, done.stdout, done.stderr
    except subprocess.TimeoutExpired:
        code, said, remarks = None, b"", b""
    result = b""
    for name in sorted(listing(folder) - before):
        path = folder / name
        if name.startswith("zz_out") and code == 0:
            if path.is_file() and path.suffix in (".exr", ".csv", ".svg"):
                result += path.read_bytes()
        elif not name.startswith("zz_out"):
            result += b"left " + name.encode()
    left = sorted(name for name in listing(folder) - before if code != 0 or not name.startswith("zz_out"))
    for name in sorted(listing(folder) - before, reverse=True):
        path = folder / name
        path.rmdir() if path.is_dir() else path.unlink()
    # What the command says of itself (times) is no result, and neither are the files' sizes.
    said = re.sub(rb'"bytes": \[[^]]*\]', b"", said)
    return code, result or said, left, remarks


def try_format(volute, form, cuts, flips, seed, longest):
    """{("cut"|"flip", "header"|"payload"): Counter} of ours and of the peer, or why not."""
    with tempfile.TemporaryDirectory(prefix="volute-damage-") as name:
        folder = pathlib.Path(name)
        try:
            form.make(folder)
        except (OSError, subprocess.CalledProcessError) as error:
            return form, None, None, str(error)
        file = folder / form.file
        whole = file.read_bytes()
        reference = folder / ("whole_" + file.name)
        if "WHOLE" in form.command:
            reference.write_bytes(whole)

        def named(command):
            return [part.replace("WHOLE", reference.name).replace("FILE", form.file) for part in command]

        ours = [volute, *named(form.command)]
        peer = named(form.peer) if form.peer and shutil.which(form.peer[0]) else None
        code, right, _, usual = outcome_of(ours, folder, longest)
        if code != 0:
            return form, None, None, f"the whole file is refused ({' '.join(form.command)})"
        peer_right = outcome_of(peer, folder, longest)[1] if peer else None
        counts, peer_counts = collections.defaultdict(collections.Counter), collections.defaultdict(collections.Counter)
        for kind, place, data in damages(whole, form.header, cuts, flips, seed):
            file.unlink()
            file.write_bytes(data)
            for command, truth, count in ((ours, right, counts), (peer, peer_right, peer_counts)):
                if not command:
                    continue
                code, said, left, remarks = outcome_of(command, folder, longest)
                if code is None or code < 0 or code > 2 and command is ours:
                    what = "hang" if code is None else "crash"
                elif code:
                    what = "refused"
                elif said == truth:
                    what = "same"
                else:
                    what = "remarked" if command is ours and remarks != usual else "silent"
                count[kind, place][what] += 1
                if left:
                    count[kind, place]["left"] += 1
        return form, counts, peer_counts if peer else None, ""


KINDS = (("cut", "header"), ("cut", "payload"), ("flip", "header"), ("flip", "payload"))


def row(label, counts):
    """A line of the table: four cells of "refused remarked same silent", then what must not be."""
    cells = [" ".join(str(counts[key][name]) for name in COUNTS[:4]) if counts[key] else "" for key in KINDS]
    faults = [f"{sum(counts[key][name] for key in KINDS)} {name}" for name in COUNTS[4:] if any(counts[key][name] for key in KINDS)]
    return f"| {label} | " + " | ".join(cells) + f" | {', '.join(faults) or 0} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bin", default=str(ROOT / "build/dev/bin/volute"))
    parser.add_argument("--cuts", type=int, default=300)
    parser.add_argument("--flips", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--longest", type=float, default=5.0, help="what takes longer hangs [s]")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("names", nargs="*", help="formats; else all")
    options = parser.parse_args()
    volute = str(pathlib.Path(options.bin).resolve())
    known = formats(Samples(volute))
    unknown = set(options.names) - {form.name for form in known}
    if unknown:
        parser.error(f"no format is named {', '.join(sorted(unknown))}: {', '.join(form.name for form in known)}")
    chosen = [form for form in known if not options.names or form.name in options.names]
    print("| format | " + " | ".join(f"{kind}, {place}" for kind, place in KINDS)
          + " | faults |\n| --- |" + " ---: |" * (len(KINDS) + 1))
    faults = 0
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for form, ours, peer, why in pool.map(
                lambda form: try_format(volute, form, options.cuts, options.flips, options.seed, options.longest), chosen):
            if why:
                print(f"| {form.name} | not tried: {why} |" + " |" * len(KINDS))
                continue
            for label, counts in ((form.name, ours), (f"{form.name}, by {form.peer[0]}" if peer else "", peer)):
                if counts:
                    print(row(label, counts), flush=True)
            faults += sum(ours[key][name] for key in ours for name in ("crash", "hang", "left"))
    print(f"\n{faults} crashes, hangs and files left" if faults else "\nNo crash, no hang, no file left.")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
