# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Chunks of HDF5 datasets, compressed with a stated error, by HDF5's own filters.

    import h5py, volute.hdf5
    file.create_dataset("soot", data=array, chunks=(16, 64, 64, 64), **volute.hdf5.Volute(max_error=1e-3))

Whoever reads such a file needs the filter: this import, or the folder volute.hdf5.FOLDER in the variable HDF5_PLUGIN_PATH (h5dump and
other programs); the command volute has it. Chunks of 16 frames and 32 voxels or more a side compress best; axes before the last three are put in a row. A chunk is a
whole .volute file. Floats of 32 and 64 bits and integers of up to 32 bits are taken; chunks with values that are not finite, and of float64 that
do not fit the error asked for, are kept as they are, without loss. The filter's number, 473, is of those that HDF5 leaves to everybody."""
import collections.abc
import os
import struct

import h5py

import volute  # finds the plug-ins

NUMBER = 473
#: where the filter is
FOLDER = os.path.join(os.environ.get("VOLUTE_PLUGIN_FOLDER", ""), "hdf5")

if os.path.isdir(FOLDER):
    h5py.h5pl.prepend(os.fsencode(FOLDER))


class Volute(collections.abc.Mapping):
    """Arguments of create_dataset(). max_error: absolute, of every value; default: as pictures need it."""

    def __init__(self, max_error=None):
        if not h5py.h5z.filter_avail(NUMBER):
            raise ImportError(f"HDF5 finds no filter of Volute's in {FOLDER}; install volute-vtk, or set VOLUTE_PLUGIN_FOLDER")
        if max_error is not None and not 0 < float(max_error) < float("inf"):
            raise ValueError(f"max_error={max_error!r}: expected a number above 0")
        halves = () if max_error is None else struct.unpack("=2I", struct.pack("=d", float(max_error)))
        self._said = {"compression": NUMBER, "compression_opts": halves}

    def __getitem__(self, key):
        return self._said[key]

    def __iter__(self):
        return iter(self._said)

    def __len__(self):
        return len(self._said)
