# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""What is wrong with a picture that was made: it shows nothing, or the same as another."""
import hashlib
import struct
import zlib

CHANNELS = {0: 1, 2: 3, 4: 2, 6: 4}  # by PNG's type of colour


def pixels_of(path):
    """Bytes from one row to the next, bytes of a pixel, and the rows, each with its filter before it, as a PNG file holds them."""
    data = path.read_bytes()
    at, packed = 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        body = data[at + 8:at + 8 + length]
        if kind == b"IHDR":
            width, _, depth, colour = struct.unpack(">IIBB", body[:10])
        elif kind == b"IDAT":
            packed += body
        at += length + 12
    pixel = max(1, CHANNELS.get(colour, 1) * depth // 8)
    return 1 + (width * CHANNELS.get(colour, 1) * depth + 7) // 8, pixel, zlib.decompress(packed)


def digest(path):
    """Of what it shows, whatever else is written in the file."""
    stride, _, rows = pixels_of(path)
    return hashlib.sha256(b"%d " % stride + rows).hexdigest()


def is_flat(path):
    """Whether it has one colour alone. Filters of rows leave zeros where a pixel is as its neighbours."""
    stride, pixel, rows = pixels_of(path)
    for begin in range(0, len(rows), stride):
        row = rows[begin + 1:begin + stride]
        if row[pixel:] != row[:-pixel] if rows[begin] == 0 else any(row[pixel:]):
            return False
    return True
