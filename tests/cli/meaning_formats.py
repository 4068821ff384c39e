# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""The formats of meaning_test.py: a small right input of each, written here, what reads it, and what it says."""
import base64
import dataclasses
import json
import pathlib
import struct
import zlib

import pictures
import sight_cases
import smoke_files
import support


@dataclasses.dataclass
class Format:
    name: str
    family: str          # whose mutations it has: see meaning_test.py
    base: str            # the folder of files that it stands in
    file: str            # the one that is changed
    command: str         # run in that folder; its result is `result`: a file that it writes, or "" for its standard output
    result: str
    hints: dict = dataclasses.field(default_factory=dict)
    more: list = dataclasses.field(default_factory=list)  # (mutation, label, change, keeps) of this format alone


# --- bases: name -> function that fills a folder ---

def room(folder):
    hall = sight_cases.Mesh("hall", (0, 8, 0, 4, 0, 3), (8, 4, 3))
    sight_cases.FdsCase([hall], [0.0, 10.0, 20.0], lambda t, x, y, z: 0.02 * t + 0.01 * x + 0.03 * y).write(folder, "hall")
    put = lambda name, text: (folder / name).write_text(text)
    index = (folder / "hall.smv").read_text()
    put("hall.smv", index + "INPF\n hall.fds\n\nDEVICE\n T1 % TEMPERATURE\n 4.5 2.5 1.5 0 0 0 0 0 % null\n")
    put("hall.fds", "&HEAD CHID='hall' /\n&MESH IJK=8,4,3, XB=0,8,0,4,0,3 /\n&TIME T_END=20. /\n&TAIL /\n")
    put("hall_devc.csv", 's,C\n"Time","T1"\n0,20\n10,50\n20,90\n')
    put("signs.json", json.dumps({"signs": [{"name": "exit", "position": [7.9, 2, 2], "normal": [-1, 0, 0], "size": [0.6, 0.3]}]}))
    put("eyes.csv", "x,y,z\n2,3,2\n1,1,1.7\n4.5,2.5,1.5\n")
    put("route.csv", "x,y,z\n1,1,1.7\n6,3,1.7\n")
    put("walk.csv", "id,time,x,y\n1,0,1,1\n1,10,6,3\n")
    put("rset.csv", "x,y,rset\n1,1,12\n6,3,8\n")
    put("criteria.json", json.dumps({"criteria": [{"name": "hot", "kind": "temperature", "limit": 60}]}))
    put("study.json", json.dumps({"cases": ["hall.smv"], "options": {"signs": "signs.json", "height": 1.5, "step": 2, "maps": "aset"}}))


def air(folder):
    """A case whose smoke is what its input file says: visibility by a factor of 8."""
    room(folder)
    hall = sight_cases.Mesh("hall", (0, 8, 0, 4, 0, 3), (8, 4, 3))
    case = sight_cases.FdsCase([hall], [0.0, 10.0, 20.0], None)
    case.write_slice(folder / "hall_1_1.sf", hall, ("SOOT VISIBILITY", "short", "m"), lambda t, x, y, z: 8 / (0.3 + 0.02 * t + 0.01 * x))
    index = (folder / "hall.smv").read_text()
    (folder / "hall.smv").write_text(index.replace("SOOT EXTINCTION COEFFICIENT", "SOOT VISIBILITY").replace("\n 1/m\n", "\n m\n"))
    (folder / "hall.fds").write_text("&HEAD CHID='hall' /\n&MISC TMPA=20., VISIBILITY_FACTOR=8. /\n"
                                     "&DEVC ID='T1', QUANTITY='TEMPERATURE', XYZ=4.5,2.5,1.5 /\n&TAIL /\n")


def mesh(folder):
    put = lambda name, text: (folder / name).write_text(text)
    for i in range(3):
        sight_cases.write_vtu(folder / f"r{i}.vtu", (4, 4, 3), (2, 2, 2), lambda x, y, z: 0.05 * (i + 1) + 0.01 * x + 0.02 * y)
    sight_cases.write_pvd(folder / "room.pvd", [(10 * i, f"r{i}.vtu") for i in range(3)])
    put("signs.json", json.dumps({"signs": [{"name": "exit", "position": [3.9, 2, 2], "normal": [-1, 0, 0]}]}))
    put("eyes.csv", "x,y,z\n1,3,2\n1,1,1.7\n")
    points = [(4 * (i & 1), 4 * (i >> 1 & 1), 3 * (i >> 2)) for i in range(8)]
    head = lambda kind, name: f"FoamFile\n{{ version 2.0; format ascii; class {kind}; object {name}; }}\n"
    poly = folder / "constant/polyMesh"
    poly.mkdir(parents=True)
    (poly / "points").write_text(head("vectorField", "points") + f"8\n(\n" + "".join(f"({x} {y} {z})\n" for x, y, z in points) + ")\n")
    faces = ["0 4 6 2", "1 3 7 5", "0 1 5 4", "2 6 7 3", "0 2 3 1", "4 5 7 6"]
    (poly / "faces").write_text(head("faceList", "faces") + "6\n(\n" + "".join(f"4({f})\n" for f in faces) + ")\n")
    (poly / "owner").write_text(head("labelList", "owner") + "6\n(\n" + "0\n" * 6 + ")\n")
    (poly / "neighbour").write_text(head("labelList", "neighbour") + "0\n(\n)\n")
    (poly / "boundary").write_text(head("polyBoundaryMesh", "boundary") + "1\n(\nwalls { type wall; nFaces 6; startFace 0; }\n)\n")
    (folder / "system").mkdir()
    (folder / "system/controlDict").write_text(head("dictionary", "controlDict") + "startTime 0;\nendTime 20;\ndeltaT 10;\nwriteInterval 1;\n")
    for time in (0, 10, 20):
        (folder / str(time)).mkdir()
        (folder / str(time) / "K").write_text(head("volScalarField", "K") + "dimensions [0 -1 0 0 0 0 0];\n"
                                              f"internalField nonuniform List<scalar> 1({0.05 + 0.01 * time});\n"
                                              "boundaryField { walls { type zeroGradient; } }\n")
    put("c.foam", "")
    put("e.case", "FORMAT\ntype: ensight gold\n\nGEOMETRY\nmodel: e.geo\n\nVARIABLE\nscalar per node: 1 K e_****.K\n\nTIME\ntime set: 1\n"
        "number of steps: 3\nfilename start number: 0\nfilename increment: 1\ntime values: 0 10 20\n")
    put("e.geo", "a\nb\nnode id off\nelement id off\npart\n         1\nroom\ncoordinates\n         8\n"
        + "".join(f"{p[axis]:12.5e}\n" for axis in range(3) for p in points)
        + "hexa8\n         1\n" + "".join(f"{n:10d}" for n in (1, 2, 4, 3, 5, 6, 8, 7)) + "\n")
    for i in range(3):
        put(f"e_{i:04d}.K", "K\npart\n         1\ncoordinates\n" + f"{0.05 + 0.1 * i:12.5e}\n" * 8)


def volumes(folder):
    values = [0.5 + 0.001 * i for i in range(3 * 4 * 5 * 6)]
    support.write_npy(folder / "a.npy", (3, 4, 5, 6), values)
    data = (folder / "a.npy").read_bytes()
    name = b"a.npy"
    local = struct.pack("<4s5HIIIHH", b"PK\3\4", 20, 0, 0, 0, 0x21, zlib.crc32(data), len(data), len(data), len(name), 0) + name
    entry = struct.pack("<4s6HIIIHHHHHII", b"PK\1\2", 20, 20, 0, 0, 0, 0x21, zlib.crc32(data), len(data), len(data), len(name), 0, 0, 0, 0, 0, 0)
    (folder / "a.npz").write_bytes(local + data + entry + name
                                   + struct.pack("<4s4HIIH", b"PK\5\6", 0, 0, 1, 1, len(entry + name), len(local + data), 0))
    for i in range(3):
        numbers = " ".join(str(0.5 + i + 0.01 * n) for n in range(24))
        (folder / f"v_{i:04d}.vti").write_text(
            '<?xml version="1.0"?>\n<VTKFile type="ImageData" version="0.1" byte_order="LittleEndian">\n'
            '<ImageData WholeExtent="0 4 0 3 0 2" Origin="0 0 0" Spacing="0.5 0.5 0.5">\n'
            f'<FieldData><DataArray type="Float64" Name="TimeValue" NumberOfTuples="1" format="ascii">{2 * i}</DataArray></FieldData>\n'
            '<Piece Extent="0 4 0 3 0 2"><CellData Scalars="density">'
            f'<DataArray type="Float32" Name="density" format="ascii">{numbers}</DataArray></CellData></Piece></ImageData></VTKFile>\n')
    (folder / "v.pvd").write_text('<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1"><Collection>\n' + "".join(
        f'<DataSet timestep="{2 * i}" part="0" file="v_{i:04d}.vti"/>\n' for i in range(3)) + "</Collection></VTKFile>\n")
    (folder / "a.nc").write_bytes(netcdf())
    support.volute("compress", folder / "a.npy", "-o", folder / "a.volute", "--max-error", "1e-4", "--quiet")
    support.volute("extract", folder / "a.volute", "-o", folder / "d_%04d.vdb", "--quiet")


def netcdf(order="tzyx", sizes=(3, 4, 5, 6), units=None, names=None, attributes=None, change=None, left_out=(), places=None, more=(), kind="f", extra=(), five=False):
    """A classic netCDF file: `soot` of 3 x 4 x 5 x 6 numbers with coordinates; `order` of its dimensions, `units` and `names` of them and of the
    array by letter (s: soot), `change` of its numbers, `places` and `attributes` of coordinates, `extra` attributes of soot; `five`: as CDF-5,
    with counts of 8 bytes."""
    units = {"t": "s", "z": "m", "y": "m", "x": "m", "s": "1/m"} | (units or {})
    names = {"t": "time", "z": "z", "y": "y", "x": "x", "s": "soot"} | (names or {})
    codes = {"c": 2, "h": 3, "i": 4, "f": 5, "d": 6}
    padded = lambda data: data + b"\0" * (-len(data) % 4)
    count = lambda *numbers: b"".join(struct.pack(">q" if five else ">i", number) for number in numbers)
    kind_of = lambda number: struct.pack(">i", number)
    text = lambda value: count(len(value.encode())) + padded(value.encode())
    numbers = lambda code, values: padded(struct.pack(f">{len(values)}{code}", *values))
    size = dict(zip("tzyx", sizes))
    places = {"t": [2.0 * i for i in range(3)], **{axis: [0.25 + 0.5 * i for i in range(size[axis])] for axis in "zyx"}} | (places or {})
    value = lambda at: 0.5 + 0.1 * at["t"] + 0.02 * at["z"] + 0.005 * at["y"] + 0.001 * at["x"]
    values = []

    def fill(at, rest):
        if not rest:
            values.append(value(at))
            return
        for i in range(size[rest[0]]):
            fill(at | {rest[0]: i}, rest[1:])
    fill({}, order)
    values = change(values) if change else values
    arrays = [(names[axis], [axis], {"units": ("c", units[axis])} | (attributes or {}).get(axis, {}), "d", places[axis])
              for axis in "tzyx" if axis not in left_out]
    arrays += [(name, list(order), {}, "f", values) for name in more]
    arrays.append((names["s"], list(order), {"units": ("c", units["s"])} | dict(extra), kind, values))

    def head(begins):
        out = (b"CDF\5" if five else b"CDF\1") + count(0) + kind_of(10) + count(4) + b"".join(text(names[axis]) + count(size[axis]) for axis in "tzyx")
        out += kind_of(0) + count(0) + kind_of(11) + count(len(arrays))
        for (name, axes, said, code, held), begin in zip(arrays, begins):
            said = {key: one for key, one in said.items() if one[1] not in (None, "")}
            out += text(name) + count(len(axes), *("tzyx".index(axis) for axis in axes))
            out += kind_of(12 if said else 0) + count(len(said))
            for key, (its, one) in said.items():
                out += text(key) + kind_of(codes[its]) + (text(one) if its == "c" else count(len(one)) + numbers(its, one))
            out += kind_of(codes[code]) + count(len(numbers(code, held)), begin)
        return out
    begins, at = [], len(head([0] * len(arrays)))
    for *_, code, held in arrays:
        begins.append(at)
        at += len(numbers(code, held))
    return head(begins) + b"".join(numbers(code, held) for *_, code, held in arrays)


def scene(folder):
    put = lambda name, text: (folder / name).write_text(text)
    support.write_npy(folder / "a.npy", *support.plume(2, 8))
    sight_cases.write_vtu(folder / "room.vtu", (4, 4, 3), (2, 2, 2), lambda x, y, z: 0.2 + 0.05 * x)
    pictures.write_rows(folder / "map.png", [[40 * (x + y) % 256 for x in range(6)] for y in range(6)])
    put("wall.obj", "mtllib wall.mtl\nv 0 3 0\nv 3 3 0\nv 3 3 1\nv 1 3 1\nv 1 3 3\nv 0 3 3\nusemtl red\nf 1 2 3 4 5 6\n")
    put("wall.mtl", "newmtl red\nKd 0.8 0.2 0.1\n")
    corners = struct.pack("<9f", 0, 0, 0, 2, 0, 0, 0, 2, 0)
    put("wall.gltf", json.dumps({
        "asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0, "translation": [1.0, 0.5, -2.0], "scale": [1.0, 1.0, 1.0]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.2, 0.1, 1.0]}}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [2, 2, 0]}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": "data:application/octet-stream;base64," + base64.b64encode(corners).decode()}]}))
    put("gltf.json", json.dumps({"format": "volute-scene-2", "background": [0.1, 0.2, 0.4], "geometry": [{"file": "wall.gltf"}], "media": [],
                                 "camera": {"eye": [2.0, -5.0, 2.5], "target": [2.0, 2.0, 1.0], "fov": 50, "size": [24, 16]},
                                 "lights": [{"kind": "sun", "direction": [0.3, 0.5, -1], "radiance": [2, 2, 1.5]}]}))
    put("all.json", json.dumps({
        "format": "volute-scene-2",
        "camera": {"eye": [2.0, -5.0, 2.5], "target": [2.0, 2.0, 1.0], "up": [0, 0, 1], "fov": 50, "size": [24, 16]},
        "background": [0.1, 0.2, 0.4],
        "geometry": [{"file": "wall.obj"}],
        "lights": [{"kind": "sun", "direction": [0.3, 0.5, -1], "radiance": [2, 2, 1.5]}],
        "media": [
            {"kind": "volume", "file": "a.npy", "emission": 1.5, "extinction": 0.5, "bounds": [[0, 0, 0], [2, 2, 2]]},
            {"kind": "fog", "map": "map.png", "origin": [-1, -1, 0], "cell": 1.0, "sigma_max": 0.2, "color": [0.8, 0.8, 0.9],
             "profile": {"kind": "slab", "bottom": 0, "top": 1}},
            {"kind": "smoke", "case": "room.vtu", "field": "smoke", "quantity": "extinction", "albedo": [0.5, 0.4, 0.3]}],
        "signs": [{"name": "exit", "position": [2, 2.5, 2], "normal": [0, -1, 0], "size": [0.6, 0.3]}]}))


def capture(folder):
    put = lambda name, text: (folder / name).write_text(text)
    import ring
    cameras = [camera | {"image": f"{camera['name']}_%04d.png"} for camera in ring.cameras()]
    put("capture.json", json.dumps({"format": "volute-capture-1", "color": "linear", "frames": [0], "volume": {
        "min": [-1, -1, -0.5], "max": [1, 1, 1], "resolution": [8, 8, 6]}, "frames_per_second": 25, "cameras": cameras}))
    for camera in cameras:
        pictures.write_rows(folder / (camera["name"] + "_0000.png"), [[7 * x % 256 for x in range(3 * ring.WIDTH)]] * ring.HEIGHT, channels=3)
    frames, extrinsics, intrinsics = [], [], []
    yaml = "%YAML:1.0\n---\n"
    matrix = lambda name, rows: (f"{name}: !!opencv-matrix\n   rows: {len(rows)}\n   cols: {len(rows[0])}\n   dt: d\n   data: [ "
                                 + ", ".join(str(float(x)) for row in rows for x in row) + " ]\n")
    for number, camera in enumerate(cameras):
        R, t, K, name = camera["R"], camera["t"], camera["K"], camera["name"]
        eye = [-sum(R[r][c] * t[r] for r in range(3)) for c in range(3)]
        pose = [[R[0][c], -R[1][c], -R[2][c], eye[c]] for c in range(3)] + [[0, 0, 0, 1]]
        frames.append({"file_path": f"{name}_0000.png", "transform_matrix": pose, "fl_x": K[0][0], "fl_y": K[1][1], "cx": K[0][2],
                       "cy": K[1][2], "w": ring.WIDTH, "h": ring.HEIGHT, "time": 0})
        intrinsics.append(f"{number + 1} PINHOLE {ring.WIDTH} {ring.HEIGHT} {K[0][0]} {K[1][1]} {K[0][2]} {K[1][2]}\n")
        extrinsics.append(quaternion(R) + t)
        yaml += matrix(f"K_{name}", K) + matrix(f"D_{name}", [[0.01, 0, 0, 0, 0]]) + matrix(f"R_{name}", R) + matrix(f"T_{name}", [[x] for x in t])
    put("transforms.json", json.dumps({"frames": frames}))
    put("cameras.yml", yaml)
    support.write_npy(folder / "a.npy", *support.plume(1, 6))
    (folder / "out").mkdir()
    (folder / "colmap").mkdir()
    (folder / "colmap/cameras.txt").write_text("# cameras\n" + "".join(intrinsics))
    (folder / "colmap/images.txt").write_text("# images\n" + "".join(
        f"{i + 1} {' '.join(map(str, pose))} {i + 1} {cameras[i]['name']}_0000.png\n\n" for i, pose in enumerate(extrinsics)))
    (folder / "colmap/points3D.txt").write_text("# none\n")


def quaternion(R):
    import math
    w = math.sqrt(max(0.0, 1 + R[0][0] + R[1][1] + R[2][2])) / 2
    x, y, z = ((R[b][a] - R[a][b]) for a, b in ((1, 2), (2, 0), (0, 1)))
    if w > 1e-3:
        return [w, x / (4 * w), y / (4 * w), z / (4 * w)]
    x = math.sqrt(max(0.0, 1 + R[0][0] - R[1][1] - R[2][2])) / 2
    return [w, x, (R[0][1] + R[1][0]) / (4 * x), (R[0][2] + R[2][0]) / (4 * x)]


def lines(folder):
    rows = ["x0,y0,z0,x1,y1,z1,transmittance,time\n"]
    for time in (0, 2):
        for i in range(8):
            for j in range(4):
                rows.append(f"-1,{0.2 + 0.2 * i},{0.3 + 0.3 * j},3,{1.8 - 0.2 * i},{0.3 + 0.3 * j},{0.8 - 0.05 * (i % 3) - 0.1 * time / 2:.3f},{time}\n")
    (folder / "lines.csv").write_text("".join(rows))


def stills(folder):
    import random
    noise = random.Random(5)
    rows = [[noise.randrange(20, 230) for _ in range(3 * 12)] for _ in range(8)]
    pictures.write_rows(folder / "a.png", rows, channels=3)
    pictures.write_rows(folder / "b.png", [[v + 5 for v in row] for row in rows], channels=3)
    values = [v / 100 for row in rows for v in row]
    for name, scale in (("a.exr", 1), ("b.exr", 1.1)):
        pictures.write_exr(folder / name, pictures.Picture(12, 8, 3, [v * scale for v in values]))
    pictures.write_rows(folder / "map.png", [[40 * (x + y) % 256 for x in range(6)] for y in range(6)])
    pictures.write_planes(folder / "depth.exr", 12, 8, {"Z": [5.0 + 0.1 * i for i in range(96)]})
    (folder / "camera.json").write_text(json.dumps({"eye": [2, -5, 0.5], "target": [2, 2, 0.5], "up": [0, 0, 1], "fov": 50, "size": [12, 8]}))


BASES = {"room": room, "air": air, "mesh": mesh, "volumes": volumes, "scene": scene, "capture": capture, "lines": lines, "stills": stills}

EYES = "visibility {} --signs signs.json --eyes eyes.csv -o out"
MESH = EYES + " --quantity extinction"
VOLUME = "compress {} -o o.volute --max-error 1e-5 ; extract o.volute -o out.npy ; info o.volute --json"
SCENE = "render all.json -o out.png"
FIT = "reconstruct capture.json -o out.npy --iterations 3 --regularization none --refine never --force"
VIEWS = "project a.npy {} -o out/{{camera}}_%04d.exr --bounds=-1,-1,-1,1,1,1 --images {{camera}}_%04d.png"
FOG = ("fog map.png --color a.exr --depth depth.exr --depth-kind z --camera camera.json --cell 1 --origin=-1,-1,0 --sigma-max 0.2 "
       "--profile slab:0,1 -o out.exr")
