# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Small cases of smoke for tests: FDS output and .vtu meshes, written here, and what a sight line through cells sees."""
import array
import math
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
    """A case with one 3D slice a mesh, SLCC (values of cells) of the extinction coefficient."""

    def __init__(self, meshes, times, extinction, events=()):
        """`obstructions` of a mesh are boxes x0 x1 y0 y1 z0 z1; events: (mesh, obstruction, time, shown)."""
        self.meshes, self.times, self.extinction, self.events = meshes, times, extinction, events

    def value(self, mesh, time, cell):
        return single(self.extinction(time, *(mesh.middle(axis, cell[axis]) for axis in range(3))))

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
        for i, mesh in enumerate(self.meshes):
            file = f"{name}_{i + 1}_1.sf"
            nx, ny, nz = mesh.cells
            lines += [f"SLCC     {i + 1} # STRUCTURED & 0 {nx} 0 {ny} 0 {nz} ! 1 1", f" {file}",
                      " SOOT EXTINCTION COEFFICIENT", " ext_coef", " 1/m"]
            self.write_slice(pathlib.Path(folder) / file, mesh)
        for mesh, obstruction, time, shown in self.events:
            lines += ["SHOW_OBST" + f" {mesh + 1}" if shown else f"HIDE_OBST {mesh + 1}", f" {obstruction + 1} {time:.2f}"]
        path = pathlib.Path(folder) / f"{name}.smv"
        path.write_text("\n".join(lines) + "\n")
        return path

    def write_slice(self, path, mesh):
        def record(data):
            return struct.pack("<i", len(data)) + data + struct.pack("<i", len(data))

        nx, ny, nz = mesh.cells
        with open(path, "wb") as file:
            for label in ("SOOT EXTINCTION COEFFICIENT", "ext_coef", "1/m"):
                file.write(record(label.ljust(30).encode()))
            file.write(record(struct.pack("<6i", 0, nx, 0, ny, 0, nz)))
            for time in self.times:
                values = array.array("f")
                for k in range(nz + 1):
                    for j in range(ny + 1):
                        for i in range(nx + 1):  # index 0 is a ghost
                            inside = i > 0 and j > 0 and k > 0
                            values.append(self.value(mesh, time, (i - 1, j - 1, k - 1)) if inside else 7.0)
                file.write(record(struct.pack("<f", time)) + record(values.tobytes()))

    def solid(self, point, time):
        for m, mesh in enumerate(self.meshes):
            for o, box in enumerate(mesh.obstructions):
                shown = True
                for em, eo, when, state in self.events:
                    if (em, eo) == (m, o):
                        shown = state if time >= when else (shown if when > 0 else shown)
                if shown and all(low < x < high for x, low, high in zip(point, box[0::2], box[1::2])):
                    return True
        return False

    def sight(self, eye, target, time):
        """(optical depth, blocked): cut at every face, look what is in the middle of each stretch; in double."""
        length = math.dist(eye, target)
        direction = [(b - a) / length for a, b in zip(eye, target)]
        cuts = [0.0, length]
        for mesh in self.meshes:
            for axis in range(3):
                if direction[axis] != 0:
                    cuts += [(face - eye[axis]) / direction[axis] for face in mesh.planes[axis]]
        cuts = sorted(s for s in cuts if 0 <= s <= length)
        depth, blocked = 0.0, False
        for begin, end in zip(cuts, cuts[1:]):
            point = [x + 0.5 * (begin + end) * d for x, d in zip(eye, direction)]
            if self.solid(point, time):
                blocked |= end - begin > 2e-3
                continue
            mesh = min((m for m in self.meshes if m.holds(point)), key=Mesh.size, default=None)
            if mesh:
                cell = tuple(mesh.index(axis, point[axis]) for axis in range(3))
                depth += (end - begin) * self.value(mesh, time, cell)
        return depth, blocked


def write_vtu(path, size, cells, value, field="smoke"):
    """A box of hexahedra with the values of a function at its points, as text."""
    nx, ny, nz = cells
    points = [(size[0] * i / nx, size[1] * j / ny, size[2] * k / nz)
              for k in range(nz + 1) for j in range(ny + 1) for i in range(nx + 1)]

    def at(i, j, k):
        return (k * (ny + 1) + j) * (nx + 1) + i

    hexahedra = [(at(i, j, k), at(i + 1, j, k), at(i + 1, j + 1, k), at(i, j + 1, k),
                  at(i, j, k + 1), at(i + 1, j, k + 1), at(i + 1, j + 1, k + 1), at(i, j + 1, k + 1))
                 for k in range(nz) for j in range(ny) for i in range(nx)]

    def data(kind, name, values, components=1):
        return (f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{components}" format="ascii">'
                + " ".join(str(v) for v in values) + "</DataArray>\n")

    path.write_text(
        '<?xml version="1.0"?>\n<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian">\n'
        f'<UnstructuredGrid><Piece NumberOfPoints="{len(points)}" NumberOfCells="{len(hexahedra)}">\n'
        '<PointData Scalars="smoke">\n' + data("Float32", field, [value(*p) for p in points]) + "</PointData>\n<Points>\n"
        + data("Float64", "Points", [x for p in points for x in p], 3) + "</Points>\n<Cells>\n"
        + data("Int64", "connectivity", [v for h in hexahedra for v in h])
        + data("Int64", "offsets", [8 * (i + 1) for i in range(len(hexahedra))])
        + data("UInt8", "types", [12] * len(hexahedra)) + "</Cells>\n</Piece></UnstructuredGrid></VTKFile>\n")


def write_pvd(path, files):
    path.write_text('<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1"><Collection>\n'
                    + "".join(f'<DataSet timestep="{t}" part="0" file="{f}"/>\n' for t, f in files)
                    + "</Collection></VTKFile>\n")
