#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""corpus.py pack FOLDER FILE | unpack FILE FOLDER: the inputs of a fuzz target as one file, for each its length (4 bytes,
little endian) and its bytes, the shortest first. fuzz/replay.cpp reads it."""
import hashlib
import pathlib
import struct
import sys


def pack(folder, file):
    inputs = sorted({path.read_bytes() for path in folder.iterdir()}, key=lambda data: (len(data), data))
    file.write_bytes(b"".join(struct.pack("<I", len(data)) + data for data in inputs))
    return len(inputs)


def unpack(file, folder):
    data, at, count = file.read_bytes(), 0, 0
    folder.mkdir(parents=True, exist_ok=True)
    while at < len(data):
        length, = struct.unpack_from("<I", data, at)
        one = data[at + 4:at + 4 + length]
        if len(one) != length:
            sys.exit(f"{file}: cut off at byte {at}")
        (folder / hashlib.sha1(one).hexdigest()).write_bytes(one)
        at += 4 + length
        count += 1
    return count


if __name__ == "__main__":
    if len(sys.argv) != 4 or sys.argv[1] not in ("pack", "unpack"):
        sys.exit(__doc__)
    print({"pack": pack, "unpack": unpack}[sys.argv[1]](*map(pathlib.Path, sys.argv[2:])), "inputs")
