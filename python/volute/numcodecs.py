# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Chunks of zarr arrays (format 2), compressed with a stated error.

    import volute.numcodecs
    zarr.open("smoke.zarr", "w", shape=(240, 128, 128, 128), chunks=(16, 64, 64, 64), dtype="f4",
              compressor=volute.numcodecs.Volute(max_error=1e-3))

Readers need `import volute.numcodecs`, or the installed package. Chunks of 16 frames and 32 voxels or more a side compress best; their
last four axes are t, z, y, x, and axes before them are put in a row with t. A chunk is a whole .volute file. Values are float32; those of
float64 and of large integers that do not fit the error asked for, and values that are not finite, are refused."""
import json

import numpy as np
from numcodecs.abc import Codec
from numcodecs.compat import ensure_contiguous_ndarray, ndarray_copy
from numcodecs.registry import register_codec

import volute


class Volute(Codec):
    """Lossy, with one of the targets of volute.compress(); default: quality="look". Arrays are compressed chunk by chunk, so that
    max_error, an absolute error, means the same in all of them."""

    codec_id = "volute"

    def __init__(self, max_error=None, rms=None, quality=None, effort=5):
        self.max_error, self.rms, self.quality, self.effort = max_error, rms, quality, effort

    def _before_rounding(self, values):
        """The maximum error before values are rounded to the array's type again, which adds up to half of what is between two numbers."""
        most = self.max_error
        if most and values.dtype.kind in "iub":
            return min(most, np.floor(most) + 0.499)
        if most and values.dtype == np.float16:
            apart = float(np.spacing(np.abs(values[np.isfinite(values)]).max(initial=np.float16(0))))
            return max(most / 2, most - apart / 2)
        return most

    def encode(self, buf):
        values = np.asanyarray(buf)
        if values.dtype.kind == "V" or values.ndim == 0:
            raise TypeError(f"values of type {values.dtype} and shape {values.shape}; expected an array of numbers")
        sides = (1,) * max(0, 4 - values.ndim) + values.shape
        frames = values.reshape((-1,) + sides[-3:])
        said = json.dumps({"shape": values.shape, "dtype": values.dtype.str, "order": "C" if values.flags.c_contiguous else "F"})
        return volute.to_bytes(frames, max_error=self._before_rounding(values), rms=self.rms, quality=self.quality, effort=self.effort, provenance=said)

    def decode(self, buf, out=None):
        with volute.open(bytes(ensure_contiguous_ndarray(buf))) as opened:
            said = json.loads(opened.provenance)
            values = opened[...].reshape(said["shape"])
        kind = np.dtype(said["dtype"])
        if kind.kind in "iub":
            values = np.rint(values)
        return ndarray_copy(values.astype(kind, order=said["order"]), out)


register_codec(Volute)
