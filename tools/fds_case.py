# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Writes smoke that a formula gives as the output of FDS: a .smv index and slices (.sf). For the demo and for tests."""
import array
import pathlib
import struct


class Mesh:
    """Cells between planes; `values(time, x, y, z)` is the extinction in the middle of a cell."""

    def __init__(self, name, bounds, cells, obstructions=()):
        self.name, self.bounds, self.cells, self.obstructions = name, bounds, cells, list(obstructions)
        self.planes = [[low + (high - low) * i / n for i in range(n + 1)]
                       for (low, high), n in zip(zip(bounds[0::2], bounds[1::2]), cells)]

    def size(self):
        return (self.bounds[1] - self.bounds[0]) / self.cells[0]

    def index(self, axis, x):
        planes = self.planes[axis]
        return min(max(int((x - planes[0]) / (planes[-1] - planes[0]) * self.cells[axis]), 0), self.cells[axis] - 1)

    def middle(self, axis, i):
        return 0.5 * (self.planes[axis][i] + self.planes[axis][i + 1])

    def holds(self, point):
        return all(low <= x <= high for x, low, high in zip(point, self.bounds[0::2], self.bounds[1::2]))


def single(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


class FdsCase:
    """A case with 3D slices of each mesh, SLCC (values of cells): the extinction coefficient, and what `more` says."""

    def __init__(self, meshes, times, extinction, events=(), more=()):
        """`obstructions` of a mesh are boxes x0 x1 y0 y1 z0 z1; events: (mesh, obstruction, time, shown); more: quantity and
        unit as FDS has them, and a formula as the extinction's."""
        self.meshes, self.times, self.extinction, self.events, self.more = meshes, times, extinction, events, list(more)

    def value(self, mesh, time, cell, formula=None):
        return single((formula or self.extinction)(time, *(mesh.middle(axis, cell[axis]) for axis in range(3))))

    def write(self, folder, name="case"):
        lines = ["TITLE", f" {name}", "", "FDSVERSION", "FDS 6.7.9", "FDS6.7.9-0", "", "CHID", f" {name}", "",
                 "NMESHES", f"  {len(self.meshes)}", ""]
        for mesh in self.meshes:
            lines += ["OFFSET", " 0 0 0", "", f"GRID  {mesh.name}", " {} {} {} 0".format(*mesh.cells), "",
                      "PDIM", " " + " ".join(f"{x:.5f}" for x in mesh.bounds) + " 0 0 0", ""]
            for axis, letter in enumerate("XYZ"):
                lines += [f"TRN{letter}", " 0"] + [f" {i} {x:.5f}" for i, x in enumerate(mesh.planes[axis])] + [""]
            lines += ["OBST", f" {len(mesh.obstructions)}"]
            for i, box in enumerate(mesh.obstructions):
                lines.append(" " + " ".join(f"{x:.5f}" for x in box) + f" {i + 1} 0 0 0 0 0 0")
            for box in mesh.obstructions:
                nodes = [round((x - mesh.planes[k // 2][0]) / (mesh.planes[k // 2][1] - mesh.planes[k // 2][0]))
                         for k, x in enumerate(box)]
                lines.append(" " + " ".join(str(i) for i in nodes) + " -1 -1")
            lines += ["", "VENT", " 0 0", ""]
        quantities = [("SOOT EXTINCTION COEFFICIENT", "1/m", self.extinction)] + self.more
        for q, (quantity, unit, formula) in enumerate(quantities):
            for i, mesh in enumerate(self.meshes):
                file = f"{name}_{i + 1}_{q + 1}.sf"
                nx, ny, nz = mesh.cells
                lines += [f"SLCC     {i + 1} # STRUCTURED & 0 {nx} 0 {ny} 0 {nz} ! {q + 1} 1", f" {file}", f" {quantity}",
                          " short", f" {unit}"]
                self.write_slice(pathlib.Path(folder) / file, mesh, (quantity, "short", unit), formula)
        for mesh, obstruction, time, shown in self.events:
            lines += ["SHOW_OBST" + f" {mesh + 1}" if shown else f"HIDE_OBST {mesh + 1}", f" {obstruction + 1} {time:.2f}"]
        path = pathlib.Path(folder) / f"{name}.smv"
        path.write_text("\n".join(lines) + "\n")
        return path

    def write_slice(self, path, mesh, labels, formula):
        def record(data):
            return struct.pack("<i", len(data)) + data + struct.pack("<i", len(data))

        nx, ny, nz = mesh.cells
        with open(path, "wb") as file:
            for label in labels:
                file.write(record(label[:30].ljust(30).encode()))
            file.write(record(struct.pack("<6i", 0, nx, 0, ny, 0, nz)))
            for time in self.times:
                values = array.array("f")
                for k in range(nz + 1):
                    for j in range(ny + 1):
                        for i in range(nx + 1):  # index 0 is a ghost
                            inside = i > 0 and j > 0 and k > 0
                            values.append(self.value(mesh, time, (i - 1, j - 1, k - 1), formula) if inside else 7.0)
                file.write(record(struct.pack("<f", time)) + record(values.tobytes()))
