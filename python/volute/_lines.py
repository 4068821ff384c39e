# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Optical depths that were measured along straight lines."""
import numpy as np

from ._arrays import seconds, unmasked


def _numbers(what, values, shape):
    values = np.ascontiguousarray(unmasked(values, what), np.float64)
    if values.shape != shape:
        raise ValueError(f"{what}: shape {values.shape}; expected {shape}")
    wrong = np.flatnonzero(~np.isfinite(values).reshape(len(values), -1).all(axis=1))
    if len(wrong):
        raise ValueError(f"{what}: row {wrong[0]} is {values[wrong[0]]}; expected finite numbers")
    return values


class Lines:
    """Optical depths along straight lines, as reconstruct() takes them: what lamps and their receivers, lasers or cameras with lit
    backgrounds measure.

    begin, end: the ends of each line, shape (n, 3) [m]. depth: natural logarithm, shape (n,). sigma: standard deviations of the depths,
    shape (n,); default: all lines weigh alike. time: [s] of each line, shape (n,); lines of one time are one frame; default: one frame."""

    def __init__(self, begin, end, depth, *, sigma=None, time=None):
        depth = np.atleast_1d(np.asarray(unmasked(depth, "depth"), np.float64))
        count = len(depth)
        self.begin, self.end = _numbers("begin", begin, (count, 3)), _numbers("end", end, (count, 3))
        self.depth = _numbers("depth", depth, (count,))
        self.sigma = None if sigma is None else _numbers("sigma", np.broadcast_to(np.asarray(unmasked(sigma, "sigma"), float), count), (count,))
        time = _numbers("time", np.zeros(count) if time is None else seconds("time", time), (count,))
        #: [s] of each frame, ascending; and each line's frame
        self.times, self.frame = np.unique(time, return_inverse=True)
        flat = np.flatnonzero((self.begin == self.end).all(axis=1))
        if len(flat):
            raise ValueError(f"line {flat[0]} ends where it begins, at {self.begin[flat[0]]}")
        if self.sigma is not None and not (self.sigma > 0).all():
            raise ValueError(f"sigma: row {np.flatnonzero(self.sigma <= 0)[0]} is not above 0")
        if not count:
            raise ValueError("there are no lines")

    def __len__(self):
        return len(self.depth)

    def _said(self):
        return np.hstack([self.begin, self.end]), self.depth, self.sigma, self.frame.tolist(), self.times.tolist()

    def __repr__(self):
        return f"<volute.Lines: {len(self)} lines, {len(self.times)} times>"
