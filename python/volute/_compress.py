# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Writing .volute files."""
import dataclasses
import os
import tempfile

import numpy as np

from . import _core
from ._progress import Listener
from ._volume import Frames, _bytes, open as _open


@dataclasses.dataclass
class Compressed:
    """The result of a compression."""
    path: str
    raw_bytes: int  #: of the values as float32
    file_bytes: int
    rms: float  #: relative RMS error that was reached, measured on what was written
    max_error: float  #: no value differs more
    value_range: tuple  #: (minimum, maximum) of the original
    seconds: float

    @property
    def ratio(self):
        return self.raw_bytes / self.file_bytes

    def open(self):
        """The file as a lazy array."""
        return _open(self.path)

    def __repr__(self):
        return (f"<{self.path}: {_bytes(self.file_bytes)}, 1/{self.ratio:.4g} of float32, relative RMS error {self.rms:.3g}, "
                f"at most {self.max_error:.3g}; {self.seconds:.2f} s>")


def _shape(shape):
    """(t, z, y, x, c) of what an array has: (z,y,x), (t,z,y,x) or (t,z,y,x,c)."""
    shape = tuple(int(n) for n in shape)
    if len(shape) == 3:
        shape = (1,) + shape
    if len(shape) == 4:
        shape += (1,)
    if len(shape) != 5 or shape[4] not in (1, 3) or 0 in shape:
        raise ValueError(f"the array has shape {tuple(shape)}; expected (z, y, x), (t, z, y, x) or (t, z, y, x, c) with 1 or 3 channels, "
                         "none of them empty")
    return shape


def _float(values):
    values = np.asarray(values)
    if values.dtype.kind not in "fiub":
        raise TypeError(f"values of type {values.dtype}; expected numbers")
    return np.ascontiguousarray(values, np.float32)


def _spool(frames, folder):
    """Frames of an iterator in a file without a name: they are asked for more than once."""
    count, shape = 0, None
    with tempfile.TemporaryFile(dir=folder) as file:
        for frame in frames:
            frame = _float(frame)
            if frame.ndim not in (3, 4):
                raise ValueError(f"frame {count} has shape {frame.shape}; expected (z, y, x) or (z, y, x, c)")
            if shape is None:
                shape = frame.shape
            if frame.shape != shape:
                raise ValueError(f"frame {count} has shape {frame.shape}; those before it have {shape}")
            frame.tofile(file)
            count += 1
        if not count:
            raise ValueError("there are no frames")
        file.flush()
        return np.memmap(file, np.float32, "r", shape=(count,) + shape)


def compress(frames, path, *, rms=None, psnr=None, ratio=None, size=None, max_error=None, bounds=None, times=None,
             frame_numbers=None, name=None, unit=None, basis=None, wavelet="auto", fast=False, provenance="",
             max_memory=4 << 30, progress=None):
    """Compresses a sequence of volumes into the .volute file `path`, which appears only when complete.

    frames: an array of shape (z,y,x), (t,z,y,x) or (t,z,y,x,c), c 1 or 3; NumPy's, or anything with `shape` and `[i]` (dask, zarr,
        h5py, a volute.Volume), read one frame at a time; or an iterator of frames (z,y,x[,c]). Values become float32;
        NaN and infinities are refused.
    One of:
        rms: relative RMS error at most this, of (max - min) of the whole [default 0.003]
        psnr: at least [dB]; ratio: float32 bytes / file bytes at least; size: at most [bytes];
        max_error: absolute error of every value at most [unit of the values]
    bounds: ((x0, y0, z0), (x1, y1, z1)), the outer voxel faces [m]; default: cubic voxels, the longest side 1 m
    times: when each frame is shown [s], ascending; default: 25 per second from 0
    frame_numbers: number of each frame, ascending; default: 0, 1, ..
    name, unit: of the values ("density", "1/m"). basis: "box" (constant in voxels), "trilinear" or "cubic" (B-splines).
        Defaults are taken from `frames` if that is a Volume or an FDS case.
    wavelet: auto, haar, cdf53 or cdf97. fast: choose from fewer transforms. provenance: a text stored in the file.
    progress: a function (stage, done, total), or True for a bar. An exception raised in it, or Ctrl-C, stops the work; no file is left behind.

    The file has the same bytes as from `volute compress`, except for the provenance, on any number of cores."""
    path = os.fspath(path)
    if not path.endswith(".volute"):
        raise ValueError(f"'{path}' does not end in .volute")
    targets = {key: value for key, value in dict(rms=rms, psnr=psnr, ratio=ratio, size=size, max_error=max_error).items()
               if value is not None}
    if len(targets) > 1:
        raise ValueError(f"{' and '.join(targets)} exclude each other; give one of them")
    (target, value), = (targets or {"rms": 3e-3}).items()
    if not (value > 0 and np.isfinite(value)):
        raise ValueError(f"{target}={value!r}: expected a number above 0")
    if basis not in (None, "box", "trilinear", "cubic"):
        raise ValueError(f"basis={basis!r}: expected 'box', 'trilinear' or 'cubic'")
    if wavelet not in ("auto", "haar", "cdf53", "cdf97"):
        raise ValueError(f"wavelet={wavelet!r}: expected auto, haar, cdf53 or cdf97")
    if isinstance(frames, Frames):
        own = lambda given, ours: ours if given is None else given  # noqa: E731
        bounds, times, frame_numbers = own(bounds, frames.bounds), own(times, frames.times), own(frame_numbers, frames.frame_numbers)
        name, unit, basis = own(name, frames.name), own(unit, frames.unit), own(basis, frames.basis)
    elif not hasattr(frames, "shape") or not hasattr(frames, "__getitem__"):
        frames = _spool(frames, os.path.dirname(path) or ".")
    shape = _shape(frames.shape)
    frame = (lambda index: _float(frames)) if len(frames.shape) == 3 else (lambda index: _float(frames[index]))
    for what, given in (("times", times), ("frame_numbers", frame_numbers)):
        if given is not None and len(given) != shape[0]:
            raise ValueError(f"{what}: {len(given)} of them for {shape[0]} frames")
    if bounds is not None:
        bounds = np.asarray(bounds, float).reshape(2, 3).tolist()
    with Listener(progress) as listener:
        report = _core.compress(frame, shape, path, target, float(value), bounds, None if times is None else [float(t) for t in times],
                                None if frame_numbers is None else [int(n) for n in frame_numbers], name or "", unit or "",
                                basis or "box", wavelet, bool(fast), provenance, int(max_memory), listener)
    return Compressed(path, **report)
