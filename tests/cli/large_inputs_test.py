#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Inputs ten times as large as --max-memory: each command does its work or refuses it with a sentence, and all its processes together hold at
most what is allowed and 128 MB of libraries. `python3 tests/cli/large_inputs_test.py --list [WORD ..]` tells what each of them holds."""
import array
import json
import math
import pathlib
import struct
import sys
import tempfile
import zlib

import memory_test
import sight_cases
import support

ALLOWED = 48  # MB
SIDE, FRAMES = 112, 86  # 483 MB of floats
WHOLE = 496  # the same in one frame
VIEW = "--size 64x48"
TARGET = "--rms 1e-2 --fast"
SEE = "--quantity extinction --signs signs.json"


def header(shape, code="<f4"):
    text = f"{{'descr': '{code}', 'fortran_order': False, 'shape': {tuple(shape)}, }}".ljust(117) + "\n"
    return b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text.encode()


def layers(side):
    """The layers of a ball, all values different."""
    line = [math.exp(-4 * (2 * i / (side - 1) - 1) ** 2) for i in range(side)]
    rough = [1 + 0.01 * math.sin(7.3 * i) for i in range(side)]
    rows = [array.array("f", (v * w * r for v, r in zip(line, rough))) for w in line]
    square = array.array("f", b"".join(row.tobytes() for row in rows))
    for weight in line:
        yield array.array("f", (weight * v for v in square)).tobytes()


def frames(count=FRAMES, side=SIDE):
    data = b"".join(layers(side))
    for i in range(count):
        at = 4 * side * i
        yield data[at:] + data[:at]


def write_npy(path):
    with open(path, "wb") as file:
        file.write(header((FRAMES, SIDE, SIDE, SIDE)))
        for frame in frames():
            file.write(frame)


def write_doubles(path):
    count = FRAMES // 2
    with open(path, "wb") as file:
        file.write(header((count, SIDE, SIDE, SIDE), "<f8"))
        for frame in frames(count):
            file.write(array.array("d", array.array("f", frame)).tobytes())


def write_whole(path):
    with open(path, "wb") as file:
        file.write(header((1, WHOLE, WHOLE, WHOLE)))
        for layer in layers(WHOLE):
            file.write(layer)


def write_npz(path):
    import zipfile
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive, archive.open("soot.npy", "w", force_zip64=True) as file:
        file.write(header((FRAMES, SIDE, SIDE, SIDE)))
        for frame in frames():
            file.write(frame)


def write_netcdf(path):
    """Classic, 64-bit offsets, one variable of records."""
    text = lambda value: struct.pack(">i", len(value)) + value + b"\0" * (-len(value) % 4)
    size = 4 * SIDE ** 3
    head = b"CDF\2" + struct.pack(">iii", FRAMES, 10, 4) + text(b"t") + struct.pack(">i", 0)
    head += b"".join(text(axis) + struct.pack(">i", SIDE) for axis in (b"z", b"y", b"x")) + struct.pack(">iiii", 0, 0, 11, 1)
    head += text(b"soot") + struct.pack(">5iii", 4, 0, 1, 2, 3, 0, 0) + struct.pack(">ii", 5, size)
    with open(path, "wb") as file:
        file.write(head + struct.pack(">q", len(head) + 8))
        for frame in frames():
            values = array.array("f", frame)
            values.byteswap()
            file.write(values.tobytes())


def write_png(path, side=12000, bits=8):
    row = b"\0" + (bytes(range(256)) * (3 * side * bits // 8 // 256 + 1))[:3 * side * bits // 8]
    squeezed = zlib.compressobj(1)
    data = b"".join(squeezed.compress(row) for _ in range(side)) + squeezed.flush()
    chunk = lambda kind, body: struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", side, side, bits, 2, 0, 0, 0)) + chunk(b"IDAT", data)
                     + chunk(b"IEND", b""))


def write_mesh(path, side=120):
    """Hexahedra of 10^6 points: some 500 MB as tets."""
    points = array.array("d", (0.05 * v for k in range(side) for j in range(side) for i in range(side) for v in (i, j, k)))
    at = lambda i, j, k: (k * side + j) * side + i
    corners = array.array("q", (v for k in range(side - 1) for j in range(side - 1) for i in range(side - 1)
                                for v in (at(i, j, k), at(i + 1, j, k), at(i + 1, j + 1, k), at(i, j + 1, k), at(i, j, k + 1), at(i + 1, j, k + 1),
                                          at(i + 1, j + 1, k + 1), at(i, j + 1, k + 1))))
    cells = (side - 1) ** 3
    arrays = [array.array("f", (0.1 + 0.001 * (i % 97) for i in range(side ** 3))), points, corners, array.array("q", range(8, 8 * cells + 1, 8)),
              array.array("B", [12]) * cells]
    begins, place = [], 0
    for one in arrays:
        begins.append(place)
        place += 8 + len(one) * one.itemsize
    data = lambda kind, name, which, more="": f'<DataArray type="{kind}" Name="{name}" {more} format="appended" offset="{begins[which]}"/>'
    with open(path, "wb") as file:
        file.write(('<?xml version="1.0"?><VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">'
                    f'<UnstructuredGrid><Piece NumberOfPoints="{side ** 3}" NumberOfCells="{cells}"><PointData>{data("Float32", "smoke", 0)}</PointData>'
                    f'<Points>{data("Float64", "Points", 1, "NumberOfComponents=" + chr(34) + "3" + chr(34))}</Points><Cells>'
                    f'{data("Int64", "connectivity", 2)}{data("Int64", "offsets", 3)}{data("UInt8", "types", 4)}</Cells></Piece></UnstructuredGrid>'
                    '<AppendedData encoding="raw">_').encode())
        for one in arrays:
            file.write(struct.pack("<Q", len(one) * one.itemsize) + one.tobytes())
        file.write(b"</AppendedData></VTKFile>")


def write_obj(path, side=1600):
    with open(path, "w") as file:
        for y in range(side):
            file.write("".join(f"v {0.01 * x:.2f} {0.01 * y:.2f} {0.01 * (x * y % 17):.2f}\n" for x in range(side)))
        for y in range(side - 1):
            file.write("".join(f"f {y * side + x + 1} {y * side + x + 2} {y * side + side + x + 2}\n" for x in range(side - 1)))
    path.with_suffix(".json").write_text(json.dumps({"format": "volute-scene-2", "camera": {"eye": [8, -20, 9], "target": [8, 8, 0], "fov": 40},
                                                     "geometry": [{"file": path.name}]}))


def write_table(path, rows=15_000_000):
    with open(path, "w") as file:
        file.write("x,y,z\n")
        for begin in range(0, rows, 100_000):
            file.write("".join(f"{1 + i % 400 / 100:.2f},{1 + i % 300 / 100:.2f},1.5\n" for i in range(begin, begin + 100_000)))


def write_walks(path, people=30_000, times=400):
    with open(path, "w") as file:
        file.write("time,id,x,y\n")
        for time in range(times):
            file.write("".join(f"{time},{i},{1 + (i + time) % 400 / 100:.2f},3\n" for i in range(people)))


def repeated(path, head, block, size=10 * ALLOWED * 1_000_000, tail=""):
    """A text of that size."""
    block = block.encode()
    with open(path, "wb") as file:
        file.write(head.encode())
        for _ in range(size // len(block)):
            file.write(block)
        file.write(tail.encode())


def write_raw(path):
    with open(path, "wb") as file:
        for frame in frames():
            file.write(frame)


def write_exr(path, width=12000, height=7000):
    """Three channels of half floats, not packed."""
    text = lambda name, kind, value: name + b"\0" + kind + b"\0" + struct.pack("<i", len(value)) + value
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    channels = b"".join(name + b"\0" + struct.pack("<iiii", 1, 0, 1, 1) for name in (b"B", b"G", b"R")) + b"\0"
    head = (struct.pack("<ii", 20000630, 2) + text(b"channels", b"chlist", channels) + text(b"compression", b"compression", b"\0")
            + text(b"dataWindow", b"box2i", window) + text(b"displayWindow", b"box2i", window) + text(b"lineOrder", b"lineOrder", b"\0")
            + text(b"pixelAspectRatio", b"float", struct.pack("<f", 1)) + text(b"screenWindowCenter", b"v2f", struct.pack("<2f", 0, 0))
            + text(b"screenWindowWidth", b"float", struct.pack("<f", 1)) + b"\0")
    line = struct.pack("<e", 0.5) * (3 * width)
    begin = len(head) + 8 * height
    with open(path, "wb") as file:
        file.write(head + struct.pack(f"<{height}Q", *(begin + y * (8 + len(line)) for y in range(height))))
        for y in range(height):
            file.write(struct.pack("<ii", y, len(line)) + line)


def write_glb(path, triangles=40_000_000):
    """Triangles of three corners, again and again."""
    points, indices = struct.pack("<9f", 0, 0, 0, 2, 0, 0, 0, 2, 1), struct.pack("<3I", 0, 1, 2)
    root = {"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [2, 2, 1]},
                          {"bufferView": 1, "componentType": 5125, "count": 3 * triangles, "type": "SCALAR"}],
            "bufferViews": [{"buffer": 0, "byteLength": 36}, {"buffer": 0, "byteOffset": 36, "byteLength": 12 * triangles}],
            "buffers": [{"byteLength": 36 + 12 * triangles}]}
    text = json.dumps(root).encode()
    text += b" " * (-len(text) % 4)
    size = 36 + 12 * triangles
    with open(path, "wb") as file:
        file.write(b"glTF" + struct.pack("<II", 2, 28 + len(text) + size) + struct.pack("<I", len(text)) + b"JSON" + text)
        file.write(struct.pack("<I", size) + b"BIN\0" + points)
        for _ in range(40):
            file.write(indices * (triangles // 40))
    (path.parent / "glb.json").write_text(json.dumps({"format": "volute-scene-2", "camera": {"eye": [1, -9, 4], "target": [1, 1, 0], "fov": 40},
                                                     "geometry": [{"file": path.name}]}))


def write_lines(path):
    repeated(path, "x0,y0,z0,x1,y1,z1,transmittance\n", "".join(
        f"-1,{0.2 + i % 160 / 100:.3f},{0.3 + i % 77 / 100:.3f},3,{1.8 - i % 91 / 100:.3f},{0.3 + i % 50 / 100:.3f},0.{700 + i % 100}\n" for i in range(9000)))


def write_colmap(folder):
    folder.mkdir()
    (folder / "cameras.txt").write_text("1 PINHOLE 40 32 42 42 20 16\n")
    (folder / "points3D.txt").write_text("")
    with open(folder / "images.txt", "w") as file:
        for begin in range(0, 9_000_000, 100_000):
            file.write("".join(f"{i + 1} 0.5 0.5 0.5 -0.5 0 0 4 1 picture_{i:010}.png\n\n" for i in range(begin, begin + 100_000)))


def write_index(folder):
    """An index of FDS with as many obstructions."""
    hall = sight_cases.Mesh("room", (0, 6, 0, 5, 0, 3), (6, 5, 3))
    sight_cases.FdsCase([hall], [0.0], lambda t, *_: 0.02).write(folder, "room")
    text = (folder / "room.smv").read_text()
    count = 5_300_000
    boxes = "".join(f" 1.0 2.0 1.0 {2 + i % 100 / 100:.2f} 1.0 2.0 1 0 0 0 0 0 0\n" for i in range(100)) * (count // 100)
    cells = " 1 2 1 3 1 2 -1 -1\n" * count
    (folder / "room.smv").write_text(text.replace("OBST\n 0\n", f"OBST\n {count}\n{boxes}{cells}"))


def write_case(folder):
    """FDS's slices in space, 500 MB in all."""
    hall = sight_cases.Mesh("hall", (0, 6, 0, 5, 0, 3), (60, 50, 30))
    case = sight_cases.FdsCase([hall], [0.0], lambda t, *_: 0.02)
    case.write(folder, "hall")
    slice_file, = folder.glob("hall*.sf")
    data = slice_file.read_bytes()
    record = struct.unpack_from("<i", data, len(data) - 4)[0] + 8
    first = len(data) - record - 12
    with open(slice_file, "wb") as file:
        file.write(data[:first])
        for i in range(1400):
            file.write(struct.pack("<ifi", 4, i * 0.5, 4) + data[first + 12:])


def write_capture(folder):
    """Pictures of 12 million pixels by four cameras."""
    side = 3500
    write_png(folder / "still.png", side)
    cameras = []
    for i in range(4):
        angle = 0.4 + 0.7 * i
        back = [-math.cos(angle), -math.sin(angle), 0]
        rows = [[back[1], -back[0], 0], [0, 0, -1], back]
        cameras.append({"name": f"c{i}", "image": "still.png", "width": side, "height": side, "K": [[4000, 0, side / 2], [0, 4000, side / 2], [0, 0, 1]],
                        "R": rows, "t": [0, 0, 4]})
        (folder / f"c{i}_0000.png").write_bytes((folder / "still.png").read_bytes())
        cameras[-1]["image"] = f"c{i}_%04d.png"
    (folder / "capture.json").write_text(json.dumps({"format": "volute-capture-1", "color": "linear", "frames": [0], "volume": {
        "min": [-1, -1, -1], "max": [1, 1, 1], "resolution": [24, 24, 24]}, "cameras": cameras}))


INPUTS = {
    "a.npy": write_npy, "d.npy": write_doubles, "one.npy": write_whole, "a.npz": write_npz, "a.nc": write_netcdf, "big.png": write_png,
    "deep.png": lambda path: write_png(path, 9000, 16), "m.vtu": write_mesh, "g.obj": write_obj, "eyes.csv": write_table, "walks.csv": write_walks,
    "a.raw": write_raw, "big.exr": write_exr, "g.glb": write_glb, "lines.csv": write_lines, "colmap": write_colmap,
    "room.smv": lambda path: write_index(path.parent),
    "hall.smv": lambda path: write_case(path.parent), "capture.json": lambda path: write_capture(path.parent),
    "a.volute": ("compress a.npy -o a.volute " + TARGET, "a.npy"), "one.volute": ("compress one.npy -o one.volute " + TARGET, "one.npy"),
    "a_0000.vdb": ("extract a.volute -o a_%04d.vdb", "a.volute"), "one_0000.vdb": ("extract one.volute -o one_%04d.vdb", "one.volute"),
    "one_0000.vti": ("extract one.volute -o one_%04d.vti", "one.volute"),
}
VOLUMES = ["a.npy", "d.npy", "one.npy", "a.npz", "a.nc", "a_%04d.vdb", "one_0000.vdb", "one_0000.vti", "a.volute", "one.volute"]
COMMANDS = ([f"compress {name} -o o.volute {TARGET}" for name in VOLUMES] + [f"info {name}" for name in VOLUMES + ["big.png", "m.vtu", "hall.smv"]]
            + [f"render {name} -o o.png {VIEW}" for name in VOLUMES + ["big.png", "g.json", "hall.smv", "m.vtu --quantity extinction"]]
            + [f"extract {name} -o {to}" for name in ("a.volute", "one.volute") for to in ("o.npy", "o_%04d.vdb", "o_%04d.vti")]
            + ["compare a.volute a.npy", "compare one.volute one.npy", "compare one_0000.vdb one.npy", "compare big.png big.png", "compare deep.png deep.png",
               "resample a.volute -o o.npy --voxel-size 0.02", "resample one.volute -o o.npy --voxel-size 0.004", "join a.volute -o o.volute",
               f"visibility m.vtu {SEE} --eyes eyes.csv -o out", f"visibility m.vtu {SEE} --height 1.5 --step 0.5 -o out",
               "visibility hall.smv --signs signs.json --height 1.5 --step 0.5 -o out", "visibility hall.smv --signs signs.json --eyes eyes.csv -o out",
               "visibility hall.smv --signs signs.json --trajectories walks.csv --height 1.7 -o out", "sweep study.json -o out",
               "visibility a.npy --extinction 1 --signs signs.json --height 0.5 --step 0.2 -o out",
               "visibility room.smv --signs signs.json --eyes few.csv -o out", "info room.smv", "info colmap",
               f"compress a.raw --raw-size {SIDE},{SIDE},{SIDE} -o o.volute {TARGET}", "compare big.exr big.exr", "info big.exr",
               f"render glb.json -o o.png {VIEW}",
               "project a.npy colmap -o {camera}_%04d.exr --images {camera}_%04d.png",
               "reconstruct lines.csv -o o.npy --bounds=0,0,0,2,2,2 --resolution 4,4,4",
               "reconstruct capture.json -o o.npy --iterations 2 --regularization none --refine never --force"])


class Inputs:
    """Made where a command names them."""

    def __init__(self, folder):
        self.folder = folder
        (folder / "signs.json").write_text(json.dumps({"signs": [{"name": "exit", "position": [5.9, 3, 2], "normal": [-1, 0, 0]}]}))
        (folder / "few.csv").write_text("x,y,z\n2.5,3,1.5\n")
        (folder / "study.json").write_text(json.dumps({"cases": ["hall.smv"], "options": {"signs": "signs.json", "height": 1.5, "step": 0.5}}))

    def make(self, name):
        path = self.folder / name
        if path.exists() or name not in INPUTS:
            return
        how = INPUTS[name]
        if callable(how):
            how(path)
            return
        self.make(how[1])
        done = support.volute(*how[0].split(), "--quiet", cwd=self.folder, timeout=600)
        assert done.code == 0 or "this build has no" in done.message, done.message

    def of(self, command):
        for word in command.split():
            self.make({"a_%04d.vdb": "a_0000.vdb", "g.json": "g.obj", "glb.json": "g.glb", "study.json": "hall.smv"}.get(word, word))


class LargeInputs(memory_test.Held):
    def test_within_what_is_allowed(self):
        inputs = Inputs(self.folder)
        for command in COMMANDS:
            with self.subTest(command=command):
                inputs.of(command)
                code, message, most = self.run_in(self.folder, command)
                if "this build has no" in message:
                    continue
                self.assertIn(code, (0, 1), message)
                self.assertLess(most, (ALLOWED << 20) + self.OWN, message)
                if code:
                    self.assertRegex(message, "[MG]i?B|expected a volume", message)  # of another kind, said before it is read

    def run_in(self, folder, command):
        return self.held(*command.split(), "--max-memory", f"{ALLOWED}M", "--quiet", cwd=folder)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--list"]:
        with tempfile.TemporaryDirectory() as name:
            inputs, test = Inputs(pathlib.Path(name)), LargeInputs()
            for line in COMMANDS:
                if all(word in line for word in sys.argv[2:]):
                    inputs.of(line)
                    its_code, its_message, its_most = test.run_in(inputs.folder, line)
                    print(f"{its_most / 1e6:6.0f} MB  {its_code}  {line}  {its_message.strip() if its_code else ''}", flush=True)
    else:
        support.main()
