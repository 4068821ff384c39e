# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Pictures written by other means than the program's: PNG of any depth, EXR without compression."""
import array
import pathlib
import struct
import sys
import zlib


def write_png(path, rows, bits=8, channels=1):
    """rows: lists of whole numbers, channels interleaved."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    size = struct.pack(">IIBBBBB", len(rows[0]) // channels, len(rows), bits, 0 if channels == 1 else 2, 0, 0, 0)
    kind = "B" if bits == 8 else "H"
    raw = b"".join(b"\0" + struct.pack(f">{len(row)}{kind}", *row) for row in rows)
    pathlib.Path(path).write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", size) + chunk(b"IDAT", zlib.compress(raw)) +
                                   chunk(b"IEND", b""))


def write_exr(path, width, height, channels):
    """channels: {"Y": values} or {"R": .., "G": .., "B": ..}, row 0 on top."""
    names = sorted(channels)
    box = struct.pack("<4i", 0, 0, width - 1, height - 1)

    def attribute(name, kind, data):
        return name + b"\0" + kind + b"\0" + struct.pack("<i", len(data)) + data

    listed = b"".join(name.encode() + b"\0" + struct.pack("<i4B2i", 2, 0, 0, 0, 0, 1, 1) for name in names) + b"\0"
    header = b"v/1\x01" + struct.pack("<i", 2)
    header += attribute(b"channels", b"chlist", listed) + attribute(b"compression", b"compression", b"\0")
    header += attribute(b"dataWindow", b"box2i", box) + attribute(b"displayWindow", b"box2i", box)
    header += attribute(b"lineOrder", b"lineOrder", b"\0") + attribute(b"pixelAspectRatio", b"float", struct.pack("<f", 1))
    header += attribute(b"screenWindowCenter", b"v2f", bytes(8)) + attribute(b"screenWindowWidth", b"float", struct.pack("<f", 1))
    header += b"\0"
    header = b"\x76\x2f\x31\x01" + header[4:]
    lines = []
    for y in range(height):
        line = b""
        for name in names:
            values = array.array("f", channels[name][y * width:(y + 1) * width])
            if sys.byteorder == "big":
                values.byteswap()
            line += values.tobytes()
        lines.append(struct.pack("<ii", y, len(line)) + line)
    offset, table = len(header) + 8 * height, b""
    for line in lines:
        table += struct.pack("<Q", offset)
        offset += len(line)
    pathlib.Path(path).write_bytes(header + table + b"".join(lines))
