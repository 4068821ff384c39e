#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Draws a mesh in pieces by ranks that hold a share each, and compares with the picture of one that holds all.

    bench/mesh_in_pieces.py build/release/bin/volute --cubes 150 --pieces 8 --ranks 4        20 million tetrahedra

Cubes are cut into six tetrahedra each; pieces are slabs, and neighbours have the points between them in common. Says the memory of
the ranks, their readers' processes not counted, and the greatest difference of the optical depths.
"""
import argparse
import array
import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile

from ranks import stats_of

# Of a cube's corners 0..7 (x + 2 y + 4 z): around the diagonal from 0 to 7.
TETRAHEDRA = ((0, 1, 3, 7), (0, 3, 2, 7), (0, 2, 6, 7), (0, 6, 4, 7), (0, 4, 5, 7), (0, 5, 1, 7))


def write_piece(path, cubes, first, end):
    """The cubes first <= z < end of cubes^3 in a hall of 10 m, with soot; its number of tetrahedra."""
    side = cubes + 1
    along = [10 * i / cubes for i in range(side)]
    points, values = array.array("f"), array.array("f")
    for z in range(first, end + 1):
        for y in range(side):
            for x in range(side):
                points.extend((along[x], along[y], along[z]))
            base = 1e-5 * (2 + math.sin(0.9 * along[y]) + math.cos(1.3 * along[z]))
            values.extend(base * (1 + 0.5 * math.sin(1.1 * x)) for x in along)
    corners = [(c & 1) + side * (c >> 1 & 1) + side * side * (c >> 2) for c in range(8)]
    row = [x + corners[c] for x in range(cubes) for tet in TETRAHEDRA for c in tet]
    cells = array.array("i")
    for z in range(end - first):
        for y in range(cubes):
            start = side * (y + side * z)
            cells.extend([start + c for c in row])
    count = len(cells) // 4
    arrays = [("Points", '<DataArray type="Float32" Name="Points" NumberOfComponents="3"', points.tobytes()),
              ("PointData", '<DataArray type="Float32" Name="soot"', values.tobytes()),
              ("Cells", '<DataArray type="Int32" Name="connectivity"', cells.tobytes()),
              ("Cells", '<DataArray type="Int32" Name="offsets"', array.array("i", range(4, 4 * count + 1, 4)).tobytes()),
              ("Cells", '<DataArray type="UInt8" Name="types"', bytes((10,)) * count)]
    parts, offset = {}, 0
    for section, tag, data in arrays:
        parts[section] = parts.get(section, "") + f'{tag} format="appended" offset="{offset}"/>\n'
        offset += 8 + len(data)
    order = "LittleEndian" if sys.byteorder == "little" else "BigEndian"
    with open(path, "wb") as file:
        file.write(f'<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="1.0" byte_order="{order}" header_type="UInt64">\n'
                   f'<UnstructuredGrid>\n<Piece NumberOfPoints="{len(values)}" NumberOfCells="{count}">\n'.encode())
        for section in ("PointData", "Points", "Cells"):
            file.write(f"<{section}>\n{parts[section]}</{section}>\n".encode())
        file.write(b'</Piece>\n</UnstructuredGrid>\n<AppendedData encoding="raw">\n_')
        for _, _, data in arrays:
            file.write(struct.pack("=Q", len(data)) + data)
        file.write(b"\n</AppendedData>\n</VTKFile>\n")
    return count


def write_mesh(folder, cubes, pieces):
    """FOLDER/mesh.pvtu and its number of tetrahedra."""
    count = 0
    for piece in range(pieces):
        count += write_piece(folder / f"piece_{piece}.vtu", cubes, cubes * piece // pieces, cubes * (piece + 1) // pieces)
    names = "".join(f'<Piece Source="piece_{piece}.vtu"/>\n' for piece in range(pieces))
    (folder / "mesh.pvtu").write_text(
        '<?xml version="1.0"?>\n<VTKFile type="PUnstructuredGrid" version="1.0">\n<PUnstructuredGrid GhostLevel="0">\n'
        '<PPointData><PDataArray type="Float32" Name="soot"/></PPointData>\n'
        f'<PPoints><PDataArray type="Float32" NumberOfComponents="3"/></PPoints>\n{names}</PUnstructuredGrid>\n</VTKFile>\n')
    return folder / "mesh.pvtu", count


def draw(program, mesh, target, ranks, options=()):
    """What --stats says."""
    pieces = ["--by-pieces"] if ranks > 1 else []
    return stats_of(ranks, [program, "render", mesh, "-o", target, "--threads", "1", *options, *pieces], target.with_suffix(".json"))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path, help="the volute command")
    parser.add_argument("--cubes", type=int, default=150, help="along each axis")
    parser.add_argument("--pieces", type=int, default=8)
    parser.add_argument("--ranks", type=int, default=4)
    parser.add_argument("--max-memory", default="16G")
    parser.add_argument("--folder", type=pathlib.Path, help="for the mesh")
    options = parser.parse_args()
    program = options.program.resolve()
    with tempfile.TemporaryDirectory(dir=options.folder) as name:
        folder = pathlib.Path(name)
        mesh, count = write_mesh(folder, options.cubes, options.pieces)
        print(f"{count / 1e6:.2f} million tetrahedra in {options.pieces} pieces", flush=True)
        view = ("--eye", "-8,3,-7", "--target", "5,5,5", "--fov", "50", "--size", "400x300", "--quantity", "soot-density", "--unit", "kg/m3",
                "--aov", "optical-depth", "--max-memory", options.max_memory)
        for ranks in (1, options.ranks):
            stats = draw(program, mesh, folder / f"by{ranks}.exr", ranks, view)
            memory = ", ".join(f"{rank['peak_memory_bytes'] / 1e6:.0f}" for rank in stats["ranks"])
            print(f"{ranks} rank{'' if ranks == 1 else 's'}: {memory} MB, {sum(rank['cpu_seconds'] for rank in stats['ranks']):.0f} s CPU", flush=True)
        compared = subprocess.run([program, "compare", folder / "by1.exr", folder / f"by{options.ranks}.exr", "--json"], stdout=subprocess.PIPE, check=True)
        print(json.loads(compared.stdout))
    return 0


if __name__ == "__main__":
    sys.exit(main())
