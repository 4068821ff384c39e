# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Volumes in files as lazy arrays."""
import base64
import bisect
import collections
import contextlib
import html
import os
import struct
import tempfile
import threading
import zlib

import numpy as np

from . import _core
from ._errors import Cancelled, Error, about
from ._progress import Listener

BLOCK = _core.block


def file_name(path, what="path"):
    """The name of a file as a text."""
    name = os.fsdecode(path)
    if "\0" in name:
        raise ValueError(f"{what}={name!r}: names of files have no NUL character")
    return name


def size_of(what, value):
    """A number of bytes."""
    count = np.asarray(value).item() if np.ndim(value) == 0 else None
    count = float(count) if isinstance(count, np.longdouble) else count
    if isinstance(count, bool) or not isinstance(count, (int, float)) or np.asarray(value).dtype.kind not in "iufO":
        raise TypeError(f"{what}={value!r}: expected a number of bytes, a whole one")
    if not 0 <= count < 1 << 64:
        raise ValueError(f"{what}={value!r}: expected 0 to {(1 << 64) - 1} bytes")
    if count != int(count):
        raise TypeError(f"{what}={value!r}: expected a number of bytes, a whole one")
    return int(count)


_GIB = 1 << 30


def _bytes(count):
    for unit in ("bytes", "KB", "MB", "GB"):
        if count < 1000 or unit == "GB":
            return f"{count:.3g} {unit}" if unit != "bytes" else f"{count} bytes"
        count /= 1000


def _png(picture):
    """A PNG of an array (height, width) or (height, width, 3) of 0..255."""
    height, width = picture.shape[:2]
    colour = 2 if picture.ndim == 3 else 0
    rows = b"".join(b"\0" + row.tobytes() for row in picture.astype(np.uint8))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, colour, 0, 0, 0)) + \
        chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


class Frames:
    """A sequence of volumes read frame by frame: the common interface of .volute files and FDS cases.

    Axes are (t, z, y, x), and (t, z, y, x, c) with three channels. Values are float32; those far from zero, of a file that was made of float64, float64."""

    dtype = np.dtype(np.float32)

    def __init__(self, path, info):
        self.path = os.fspath(path)
        shape = info["shape"]
        #: (t, z, y, x), or (t, z, y, x, 3) for linear RGB
        self.shape = shape if shape[4] != 1 else shape[:4]
        #: what the values are, and their unit ("" when unknown)
        self.name, self.unit = info["name"], info["unit"]
        #: ((x0, y0, z0), (x1, y1, z1)): the outer voxel faces [m], or a box around voxels that do not lie along the axes
        self.bounds = info["bounds"]
        #: (x, y, z) [m], along the voxels' own edges
        self.voxel_size = info["voxel_size"]
        #: None, or of voxels that are turned, sheared or mirrored, or move by parts of a voxel: shape (t, 3, 4), from (x, y, z), counted
        #: in voxels, to the centre of a voxel in the world [m]
        self.matrices = info["matrices"]
        #: the axis that points upwards, "x", "y" or "z"; "" when unknown
        self.up = info["up"]
        #: when each frame is shown [s], shape (t,), ascending
        self.times = info["times"]
        self.times.flags.writeable = False
        #: what the input called each frame, shape (t,)
        self.frame_numbers = info["frame_numbers"]
        self.frame_numbers.flags.writeable = False
        #: "box": values are constant in voxels; "trilinear": interpolated between their centres;
        #: "cubic": B-splines of degree 3 there
        self.basis = info["basis"]

    @property
    def ndim(self):
        return len(self.shape)

    @property
    def size(self):
        return int(np.prod(self.shape, dtype=np.int64))

    @property
    def nbytes(self):
        """Bytes of all values as float32."""
        return 4 * self.size

    @property
    def channels(self):
        return self.shape[4] if self.ndim == 5 else 1

    def __len__(self):
        return self.shape[0]

    def frame_at(self, time):
        """The index of the frame shown at `time` [s]: each is shown until the next one, the first before its own, the last after it."""
        if np.ndim(time) or np.asarray(time).dtype.kind not in "iuf" or np.isnan(time):
            raise TypeError(f"time={time!r}: expected a number of seconds")
        return max(0, bisect.bisect_right(self.times, time) - 1)

    def at(self, time):
        """The frame shown at `time` [s], shape (z, y, x[, c]). The last is shown as long as the one before it, a lone one always: what is
        beyond that, or before the first time and 0, is a ValueError."""
        at, times = self.frame_at(time), self.times
        end = 2 * times[-1] - times[-2] if len(times) > 1 else np.inf
        begin = min(times[0], 0)
        if not begin - 1e-9 * (1 + abs(begin)) <= time <= end + 1e-9 * (1 + abs(end)):
            raise ValueError(f"{time:g} s is {'past the end' if time > begin else 'before the begin'}: {self.path} has {len(times)} frames from "
                             f"{times[0]:g} to {times[-1]:g} s")
        return self[at]

    def __array__(self, dtype=None, copy=None):
        if copy is False:
            raise ValueError("values are decoded into a new array; copy=False is not possible")
        values = self[...]
        return values if dtype is None else values.astype(dtype, copy=False)

    def __dlpack__(self, **options):
        return self[...].__dlpack__(**options)

    def __dlpack_device__(self):
        return 1, 0  # the CPU's memory

    def _keys(self, key):
        """For each axis: (indices >= 0, whether the axis goes away)."""
        key = key if isinstance(key, tuple) else (key,)
        dots = [i for i, one in enumerate(key) if one is Ellipsis]
        if len(dots) > 1:
            raise IndexError("an index can only have a single ellipsis ('...')")
        missing = self.ndim - (len(key) - len(dots))
        if missing < 0:
            raise IndexError(f"too many indices: there are {self.ndim} axes, {len(key) - len(dots)} were given")
        place = dots[0] if dots else len(key)
        key = key[:place] + (slice(None),) * missing + key[place + len(dots):]
        if sum(np.ndim(one) > 0 for one in key if not isinstance(one, slice)) > 1:
            raise IndexError("a list of indices may stand on one axis alone; take the parts one after the other")
        return [self._indices(axis, one) for axis, one in enumerate(key)]

    def _indices(self, axis, one):
        side = self.shape[axis]
        if isinstance(one, slice):
            return np.arange(side)[one], False
        array = np.asarray(one)
        if array.ndim == 1 and array.dtype == bool and len(array) == side:
            return np.flatnonzero(array), False
        if array.ndim > 1 or (array.size and array.dtype.kind not in "iu"):
            raise IndexError(f"axis {axis} ('{'tzyxc'[axis]}'): expected a whole number, a slice, or a list of numbers or of {side} "
                             f"truth values, not {one!r}")
        indices = np.atleast_1d(array).astype(np.int64)
        wrong = indices[(indices < -side) | (indices >= side)]
        if wrong.size:
            raise IndexError(f"index {wrong[0]} is out of bounds for axis {axis} ('{'tzyxc'[axis]}') with size {side}")
        return indices % side, array.ndim == 0

    def __getitem__(self, key):
        """Numbers, slices and `...` as NumPy has them; a list of numbers or a mask may stand on one axis, which stays in its place."""
        keys = self._keys(key)
        values = self._read(*(indices for indices, _ in keys[:4]))  # (t, z, y, x, c)
        if self.ndim == 4:
            values = values[..., 0]
        elif len(keys[4][0]) != 3 or keys[4][0][0] != 0:
            values = values[..., keys[4][0]]
        gone = [axis for axis, (_, goes) in enumerate(keys) if goes]
        values = values.reshape([n for axis, n in enumerate(values.shape) if axis not in gone])
        return values if values.ndim else values[()]

    def __repr__(self):
        return f"<{self._says()}>"

    def _says(self):
        z, y, x = self.shape[1:4]
        times = f"{self.times[0]:g} to {self.times[-1]:g} s" if len(self) > 1 else f"{self.times[0]:g} s"
        colour = ", linear RGB" if self.channels == 3 else ""
        unit = f" [{self.unit}]" if self.unit else ""
        low, high = (", ".join(f"{v:.4g}" for v in point) for point in self.bounds)
        return (f"volute.{type(self).__name__} {os.path.basename(self.path)}: {self.name}{unit}, {len(self)} frame{'s' * (len(self) != 1)} "
                f"of {x} x {y} x {z} voxels{colour}, {times}, ({low}) to ({high}) m")


Bricks = collections.namedtuple("Bricks", "positions values active tile_positions tile_sides tile_values tile_active background")
Bricks.__doc__ = "What a frame holds, as Volume.bricks() gives it."


class Volume(Frames):
    """A .volute file as a lazy array: `v[t]`, `v[10:20, ::2, z0:z1]`, `np.asarray(v)`.

    Slicing decodes only the blocks needed, of 16 frames (or fewer) x 16 x 16 x 16 voxels each, on all cores; other blocks are not
    read. Results are NumPy arrays of `dtype` (buffer protocol and DLPack without copies). Frames read in order
    are decoded together, those of a block, as long as these fit in `cache` bytes. Threads may share one.

    In a file with several grids it is one of them; `grids` lists them, and `v.grid("velocity")` opens another."""

    def __init__(self, path, *, grid=None, partial=False, max_memory=4 * _GIB, cache=_GIB // 2):
        """grid: the name of one of several; without it "density", else the first that is not empty.
        partial: of a damaged file the intact, coarser part is shown; it is checked as by verify(), and `damage` says what is missing."""
        max_memory, cache = size_of("max_memory", max_memory), size_of("cache", cache)
        if grid is not None and not isinstance(grid, str):
            raise TypeError(f"grid={grid!r}: expected a name")
        self._memory = _InMemory(path) if isinstance(path, (bytes, bytearray, memoryview)) or hasattr(path, "read") else None
        path = self._memory.path if self._memory else file_name(path)
        with about(path):
            self._file = _core.File(path, partial, max_memory, grid or "")
        self._block = self._file.block_frames
        self._options = {"partial": partial, "max_memory": max_memory, "cache": cache}
        super().__init__(path, self._file.info)
        self._cache = cache
        self._lock = threading.Lock()
        self._row = (-1, None)
        self._last = -2
        header = self._file.header
        #: relative RMS error over all voxels that was reached: RMS / (max - min) of the original
        self.rms = header["rms"]
        #: no value differs more from the original
        self.max_error = header["max_error"]
        #: (minimum, maximum) of the original
        self.value_range = header["value_range"]
        #: what was asked of the compression: ("look", 0.0007), ("support-rms", 0.003), ("rms", 0.003) over all voxels, ..
        self.target = header["target"]
        #: None, or of a damaged file that is shown in part a sentence that says so: rms and max_error are not known then (NaN)
        self.damage = None
        if partial:
            self._identity = _identity_of(path, self._memory and self._memory.data)
            self.damage = self._damage_of(self.name, self._file)
            if self.damage:
                self.rms = self.max_error = np.nan
                if _told_once(self._identity, self.name):
                    Listener().remark(self.damage, "damaged", path)
        if header["offset"]:
            self.dtype = np.dtype(np.float64)
        self.provenance, self.written_by = header["provenance"], header["written_by"]

    def _damage_of(self, name, file=None):
        """A sentence on a grid's damage, or None. A grid of a file is read for it once."""
        known = _damages.setdefault(self._identity, {})
        if name not in known:
            try:
                with Listener() as listener:
                    fault, parts, intact = (file or _core.File(self.path, True, self._options["max_memory"], name)).verify(listener)
                fault = fault.replace(self.path + ": ", "")  # the same bytes may have another name
                known[name] = fault and (f"{intact} of {parts} parts of '{name}' are intact ({fault}); the others are taken as 0 or coarser, "
                                         "and how far values are off is not known")
            except Cancelled:
                raise
            except Error as error:  # nothing of it is left
                known[name] = str(error).replace(self.path + ": ", "")
        while len(_damages) > 100:
            _damages.pop(next(iter(_damages)))
        return f"{self.path}: {known[name]}" if known[name] else None

    @property
    def grids(self):
        """The grids of the file by name: dicts with shape, half, grid_class ("fog volume", "staggered", ...),
        rms, max_error, value_range, file_bytes, and empty (no values; cannot be opened)."""
        all_grids = {one.pop("name"): one for one in self._file.grids}
        for one in all_grids.values():
            one["shape"] = one["shape"] if one["shape"][4] != 1 else one["shape"][:4]
        if self._options["partial"]:
            for name, one in all_grids.items():
                if not one["empty"] and self._damage_of(name):
                    one["rms"] = one["max_error"] = np.nan
        return all_grids

    def grid(self, name):
        """Another grid of the same file, opened with the same options."""
        return Volume(self._memory.data if self._memory else self.path, grid=name, **self._options)

    @property
    def chunks(self):
        """Sides of the blocks that are decoded together, in the order of `shape`; for dask.array.from_array(v, v.chunks)."""
        return tuple(min(block, side) for block, side in zip((self._block, BLOCK, BLOCK, BLOCK), self.shape)) + self.shape[4:]

    @property
    def file_bytes(self):
        return os.path.getsize(self.path)

    @property
    def blocks_decoded(self):
        """Number of blocks decoded since the file was opened."""
        return self._file.blocks_decoded

    @property
    def bytes_read(self):
        """Number of bytes read since the file was opened."""
        return self._file.bytes_read

    def preview(self, key=..., levels=3):
        """As v[key], from only the coarsest `levels` levels of each block: fast, but blurred."""
        coarse = object.__new__(Frames)
        coarse.shape, coarse.dtype = self.shape, self.dtype
        coarse._read = lambda t, z, y, x: self._file.read(t, z, y, x, levels)
        return coarse[key]

    def close(self):
        """Closes the file, and forgets decoded frames. What was read stays; to read more is a ValueError. `with` calls it."""
        with self._lock:
            self._file, self._row, self._memory = _Closed(self.path), (-1, None), None

    def __enter__(self):
        return self

    def __exit__(self, *what):
        self.close()

    def verify(self, progress=None):
        """Reads the whole file; raises an error if a checksum is wrong. `progress`: as for compress()."""
        from ._errors import InvalidData
        with Listener(progress) as listener:
            fault, _, _ = self._file.verify(listener)
        if fault:
            raise InvalidData(fault)

    def to_dask(self):
        """A dask array of the whole, with one task for every few blocks."""
        import dask.array
        sides = (self._block,) + tuple(min(4 * BLOCK, side) for side in self.shape[1:4]) + self.shape[4:]
        return dask.array.from_array(self, chunks=sides, name=False, asarray=False)

    def __iter__(self):
        """Frames, shape (z, y, x[, c]); each block is decoded once where its frames fit in the cache."""
        self._file.info  # says that it is closed
        return self._frames()

    def _frames(self):
        block = self._block
        for first in range(0, len(self), block):
            if self.dtype.itemsize * block * (self.size // len(self)) <= self._cache:
                values = self._decode_row(first // block)
                yield from values if self.ndim == 5 else values[..., 0]
            else:
                yield from (self[i] for i in range(first, min(first + block, len(self))))

    def bricks(self, frame):
        """What a frame holds, as large as that: a Bricks with
        positions (n, 3), the first voxel (z, y, x) of each leaf of 8^3 voxels, which may lie beyond the volume's faces;
        values (n, 8, 8, 8[, c]) and active (n, 8, 8, 8) of their voxels;
        tile_positions, tile_sides, tile_values[, c] and tile_active of cubes of equal voxels; and the background everywhere else."""
        index = int(frame)
        index += len(self) * (index < 0)
        held = self._file.bricks(index)
        if self.ndim == 4:
            held["values"], held["tile_values"] = held["values"][..., 0], held["tile_values"][..., 0]
            held["background"] = held["background"][0]
        else:
            held["background"] = tuple(held["background"])
        return Bricks(**held)

    def masked(self, frame):
        """A frame, shape (z, y, x[, c]), as a masked array of NumPy's: masked where the file has inactive voxels, which are 0 (or the
        background) in v[frame]. Of an array without a mask these are the voxels that were 0; there are none in files that do not keep which
        voxels are active, made with psnr or rms_over="all"."""
        index = int(frame)
        index += len(self) * (index < 0)
        values = self[index]
        inactive = ~self._file.active(index)
        return np.ma.MaskedArray(values, np.broadcast_to(inactive[..., np.newaxis] if values.ndim == 4 else inactive, values.shape))

    def _note_read(self):
        """What this thread writes meanwhile is not to replace it: reads_noted()."""
        noted = getattr(_thread, "reads", None)
        for one in _of_all_threads if noted is None else (noted,):
            one.add(self.path)

    def _refuse_too_large(self, indices):
        """Before anything is decoded."""
        from ._errors import TooLarge
        needed = self.dtype.itemsize * self.channels * int(np.prod([len(one) for one in indices], dtype=np.float64))
        most = max(self._options["max_memory"], os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
        if needed <= most:
            return
        low, high = self._file.fitting(indices[0], max(most // (self.dtype.itemsize * self.channels * len(indices[0])), 1))
        part = ", ".join(f"{a}:{b}" for a, b in zip(low, high))
        raise TooLarge(f"{self.path}: {' x '.join(str(len(one)) for one in indices)} voxels as an array need {needed:,} bytes, and there are "
                       f"{most:,}; v[:, {part}] fits, and v.bricks(frame) is as large as what is in a frame")

    def _read(self, t, z, y, x):
        self._note_read()
        self._refuse_too_large((t, z, y, x))
        if len(t) == 1 and all(len(one) == side and (np.diff(one) == 1).all() for one, side in zip((z, y, x), self.shape[1:4])):
            values = self._from_row(int(t[0]))
            if values is not None:
                return values
        return self._file.read(t, z, y, x)

    def _from_row(self, index):
        """A copy of a whole frame, where it follows the one that was read last: these are decoded together. Else None."""
        row, place = divmod(index, self._block)
        with self._lock:
            if self._row[0] != row:
                follows = place > 0 and self._last == index - 1
                self._last = index
                if not follows or self.dtype.itemsize * self._block * (self.size // len(self)) > self._cache:
                    return None
                self._row = (row, self._decode_row(row))
            return self._row[1][place:place + 1].copy()

    def _decode_row(self, row):
        self._note_read()
        frames = np.arange(row * self._block, min((row + 1) * self._block, len(self)))
        return self._file.read(frames, *(np.arange(side) for side in self.shape[1:4]))

    def __reduce__(self):
        return _open, (self._memory.data if self._memory else os.path.abspath(self.path), self.name, self._options)

    def _stored(self):
        """(its bytes in the file as a text, how many times fewer these are than those of float32)."""
        grids = self._file.grids
        own = next((one["file_bytes"] for one in grids if one["name"] == self.name and not one["empty"]), 0) if len(grids) > 1 else self.file_bytes
        return _bytes(own) + (f" of {_bytes(self.file_bytes)}" if len(grids) > 1 else ""), self.nbytes / max(own, 1)

    def _says(self):
        if isinstance(self._file, _Closed):
            return f"{super()._says()}; closed"
        size, ratio = self._stored()
        error = "damaged, errors not known" if self.damage else f"relative RMS error {self.rms:.2g}"
        return f"{super()._says()}; {size}, 1/{ratio:.3g} of float32, {error}"

    def _picture(self):
        """The middle frame from the side, its brightest values along y, or along z where that shows more."""
        frame = self.preview(len(self) // 2, levels=4)
        if frame.ndim == 4:
            frame = frame.mean(axis=3)
        sides = [frame.max(axis=1)[::-1], frame.max(axis=0)[::-1]]
        picture = max(sides, key=lambda side: side.size)
        low, high = float(picture.min()), float(picture.max())
        if high <= low:
            return None
        picture = np.sqrt((picture - low) / (high - low)) * 255
        enlarge = max(1, 160 // max(picture.shape))
        return _png(picture.repeat(enlarge, 0).repeat(enlarge, 1))

    def _repr_html_(self):
        try:
            picture = self._picture()
        except Exception:  # a damaged file is still described
            picture = None
        image = f'<img alt="" src="data:image/png;base64,{base64.b64encode(picture).decode()}">' if picture else ""
        low, high = (", ".join(f"{v:.4g}" for v in point) for point in self.bounds)
        size, ratio = self._stored()
        rows = [("shape", f"{self.shape} ({'t, z, y, x, c' if self.ndim == 5 else 't, z, y, x'})"),
                ("times", f"{self.times[0]:g} to {self.times[-1]:g} s"), ("bounds", f"({low}) to ({high}) m"),
                ("values", f"{self.name}{' [' + self.unit + ']' if self.unit else ''}, {self.value_range[0]:.4g} to {self.value_range[1]:.4g}"),
                ("file", "{} for {} of float32 (1/{:.3g})".format(size, _bytes(self.nbytes), ratio)),
                ("error", "damaged, not known" if self.damage else f"relative RMS {self.rms:.3g}, at most {self.max_error:.3g}")]
        cells = "".join(f"<tr><th style='text-align:left'>{name}</th><td style='text-align:left'>{html.escape(text)}</td></tr>" for name, text in rows)
        return (f"<div><b>{html.escape(os.path.basename(self.path))}</b><div style='display:flex;gap:1em;align-items:center'>{image}"
                f"<table>{cells}</table></div></div>")


_thread = threading.local()
#: sets of reads_noted() of arrays that other threads compute
_of_all_threads = []


@contextlib.contextmanager
def reads_noted(array=None):
    """A set, to which the names of files are added that volumes are read from in this thread; of an array of dask's, in others, too, but for
    those that note their own."""
    before, _thread.reads = getattr(_thread, "reads", None), set()
    graph = getattr(array, "__dask_graph__", None)
    others = [_thread.reads] if callable(graph) and graph() is not None else []
    _of_all_threads.extend(others)
    try:
        yield _thread.reads
    finally:
        for one in others:
            _of_all_threads[:] = [other for other in _of_all_threads if other is not one]
        if before is not None:
            before |= _thread.reads
        _thread.reads = before


#: of a file's identity: what is known of the damage of each grid, and which of them were told
_damages, _told = {}, set()


def _identity_of(path, data):
    """What is the same for a file, or its bytes, as long as these do not change."""
    if data:
        return hash(data), len(data)
    found = os.stat(path)
    return os.path.realpath(path), found.st_size, found.st_mtime_ns


def _told_once(identity, name):
    """Whether it is told now: the first time in this process."""
    if len(_told) > 10000:
        _told.clear()
    before = len(_told)
    _told.add((identity, name))
    return len(_told) > before


def _open(path, grid=None, options=None):
    return Volume(path, grid=grid, **(options or {}))


class _InMemory:
    """The bytes of a file, which has a name as long as this is kept."""

    def __init__(self, given):
        self.data = bytes(given.read() if hasattr(given, "read") else given)
        self._file = tempfile.NamedTemporaryFile(prefix="memory-", suffix=".volute")
        self._file.write(self.data)
        self._file.flush()
        self.path = self._file.name


class _Closed:
    """In the place of what was closed."""

    def __init__(self, path):
        self._path = path

    def __getattr__(self, name):
        raise ValueError(f"{self._path} is closed")


def open(path, *, grid=None, partial=False, max_memory=4 * _GIB, cache=_GIB // 2):
    """Opens a .volute file as a lazy array (`Volume`) of shape (t, z, y, x) or (t, z, y, x, 3).

    path: its name; or its bytes, or a file object that is read to its end (from an archive, a web server).
    grid: one of several; default "density", else the first non-empty grid.
    partial: decode the intact part of a damaged or truncated file, coarser, whose `damage` says what is missing; else damage is an error.
    max_memory: bytes allowed for the file's index. cache: bytes for frames read in order."""
    return Volume(path, grid=grid, partial=partial, max_memory=max_memory, cache=cache)
