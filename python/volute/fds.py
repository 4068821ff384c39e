# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Results of the Fire Dynamics Simulator."""
import threading

import numpy as np

from . import _core
from ._arrays import corners, number, whole
from ._errors import about
from ._volume import Frames, _Closed, file_name, size_of


class Case(Frames):
    """The smoke of an FDS case as voxels of its finest cell size: a lazy array of shape (t, z, y, x) at the stored times.

    Values are the extinction [1/m] at voxel centres, or the requested quantity; 0 in obstructions and outside all
    meshes. volute.compress() accepts it directly."""

    def __init__(self, path, *, quantity="", source="", mass_extinction=0.0, mesh=None, bounds=None, max_memory=4 << 30):
        mass_extinction = number("mass_extinction", mass_extinction)
        mesh = None if mesh is None else whole("mesh", mesh)
        bounds = corners(bounds, region=True)
        with about(file_name(path)):
            self._case = _core.Fds(file_name(path), quantity, source, mass_extinction, mesh, bounds, size_of("max_memory", max_memory))
        self._options = {"quantity": quantity, "source": source, "mass_extinction": mass_extinction, "mesh": mesh, "bounds": bounds}
        super().__init__(file_name(path), self._case.info)
        self._lock = threading.Lock()

    @property
    def remarks(self):
        """Remarks on the data: missing or truncated files, capped values."""
        return self._case.remarks

    @property
    def sources(self):
        """The sources of the case, best first: {name: description}."""
        return dict(self._case.sources)

    @property
    def source(self):
        """The name of the source in use."""
        return self._case.source

    def close(self):
        """Closes its files; what is read then is a ValueError. `with` calls it."""
        self._case = _Closed(self.path)

    def __enter__(self):
        return self

    def __exit__(self, *what):
        self.close()

    def __iter__(self):
        self._case.info  # says that it is closed
        return (self[i] for i in range(len(self)))

    def _as_members(self):
        """What makes a scene read the same."""
        lost = [key for key in ("quantity", "mesh", "bounds") if self._options[key] not in (None, "")]
        if lost:
            raise ValueError(f"{self.path}: a scene reads the whole case's smoke, and this one was opened with {' and '.join(lost)}; compress it first: "
                             "volute.compress(case, \"part.volute\").open(), or leave that out")
        return {key: self._options[own] for key, own in (("field", "source"), ("mass_extinction", "mass_extinction")) if self._options[own]}

    def _read(self, t, z, y, x):
        values = np.empty((len(t), len(z), len(y), len(x), 1), np.float32)
        for place, index in enumerate(t):
            values[place, ..., 0] = self._case.frame(int(index))[np.ix_(z, y, x)]
        return values


def open(path, *, quantity="", source="", mass_extinction=0.0, mesh=None, bounds=None, max_memory=4 << 30):
    """Opens an FDS case (its .smv) as a lazy array of extinction [1/m] (`Case`).

    quantity: another stored quantity, by FDS's name ("TEMPERATURE"). source: one of `Case.sources`; default the best that
    fills meshes. mass_extinction: Km [m2/kg] for densities of soot; default the case's, else FDS's default.
    mesh: a single mesh, from 0. bounds: ((x0,y0,z0),(x1,y1,z1)) [m], the region to read, with infinities where it has no end."""
    return Case(path, quantity=quantity, source=source, mass_extinction=mass_extinction, mesh=mesh, bounds=bounds, max_memory=max_memory)
