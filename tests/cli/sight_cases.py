# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Small cases of smoke for tests: FDS output and .vtu meshes, written here, and what a sight line through cells sees."""
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tools"))
import fds_case
from fds_case import Mesh


class FdsCase(fds_case.FdsCase):
    """A case, and what sight lines through it see."""

    def solid(self, point, time):
        for m, mesh in enumerate(self.meshes):
            for o, box in enumerate(mesh.obstructions):
                shown = True
                for event_mesh, obstruction, when, state in self.events:
                    if (event_mesh, obstruction) == (m, o) and time >= when:
                        shown = state
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


def write_vtu(path, size, cells, value, field="smoke", more=()):
    """A box of hexahedra with the values of a function at its points, as text; `more` are names and functions of other fields."""
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
        '<PointData Scalars="smoke">\n' + data("Float32", field, [value(*p) for p in points])
        + "".join(data("Float32", name, [other(*p) for p in points]) for name, other in more) + "</PointData>\n<Points>\n"
        + data("Float64", "Points", [x for p in points for x in p], 3) + "</Points>\n<Cells>\n"
        + data("Int64", "connectivity", [v for h in hexahedra for v in h])
        + data("Int64", "offsets", [8 * (i + 1) for i in range(len(hexahedra))])
        + data("UInt8", "types", [12] * len(hexahedra)) + "</Cells>\n</Piece></UnstructuredGrid></VTKFile>\n")


def write_pvd(path, files):
    path.write_text('<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1"><Collection>\n'
                    + "".join(f'<DataSet timestep="{t}" part="0" file="{f}"/>\n' for t, f in files)
                    + "</Collection></VTKFile>\n")
