# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""OpenEXR and PNG pictures with the standard library alone: what the tests of captures read and change."""
import array
import pathlib
import struct
import zlib

MAGIC = b"\x76\x2f\x31\x01\x02\x00\x00\x00"


class Picture:
    """Linear floats, shape (height, width, channels), row 0 at the top."""

    def __init__(self, width, height, channels, values=None):
        self.width, self.height, self.channels = width, height, channels
        self.values = values or [0.0] * (width * height * channels)

    def at(self, x, y, c=0):
        return self.values[(y * self.width + x) * self.channels + c]

    def set(self, x, y, value):
        for c in range(self.channels):
            self.values[(y * self.width + x) * self.channels + c] = value


def attributes(data):
    """({name: bytes}, where the header ends)."""
    at, found = len(MAGIC), {}
    while data[at]:
        name, _, rest = data[at:].partition(b"\0")
        kind, _, rest = rest.partition(b"\0")
        (size,) = struct.unpack_from("<i", rest)
        found[name.decode()] = rest[4:4 + size]
        at += len(name) + len(kind) + 2 + 4 + size
    return found, at + 1


def unpredicted(data):
    """Undoes the difference of neighbours and the split of odd and even bytes of ZIP blocks."""
    data = bytearray(data)
    for i in range(1, len(data)):
        data[i] = (data[i - 1] + data[i] - 128) & 255
    half = (len(data) + 1) // 2
    out = bytearray(len(data))
    out[0::2], out[1::2] = data[:half], data[half:]
    return bytes(out)


def read_exr(path):
    """Scan lines of 32-bit floats, uncompressed or ZIP(S); channels R, G, B, or Y."""
    data = pathlib.Path(path).read_bytes()
    assert data[:8] == MAGIC, path
    header, at = attributes(data)
    names = [entry.split(b"\0")[0].decode() for entry in split_channels(header["channels"])]
    x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    rows = {0: 1, 2: 1, 3: 16}[header["compression"][0]]
    picture = Picture(width, height, len(names))
    order = [names.index(name) for name in ("R", "G", "B")] if len(names) == 3 else [0]
    count = (height + rows - 1) // rows
    for (offset,) in struct.iter_unpack("<Q", data[at:at + 8 * count]):
        y, size = struct.unpack_from("<ii", data, offset)
        lines = min(rows, height - (y - y0))
        block = data[offset + 8:offset + 8 + size]
        if header["compression"][0] and size < lines * 4 * width * len(names):
            block = unpredicted(zlib.decompress(block))
        values = array.array("f", block)
        for line in range(lines):
            for c, stored in enumerate(order):
                begin = (line * len(names) + stored) * width
                to = (y - y0 + line) * width * len(names) + c
                picture.values[to:to + width * len(names):len(names)] = values[begin:begin + width]
    return picture


def split_channels(data):
    at = 0
    while data[at]:
        end = data.index(b"\0", at)
        yield data[at:end + 17]
        at = end + 17


def write_exr(path, picture, alpha=None):
    """Uncompressed; `alpha` adds a channel A of that value."""
    names = ["B", "G", "R"] if picture.channels == 3 else ["Y"]
    planes = {"B": 2, "G": 1, "R": 0, "Y": 0}
    names = (["A"] if alpha is not None else []) + names
    channels = b"".join(name.encode() + b"\0" + struct.pack("<iIii", 2, 0, 1, 1) for name in names) + b"\0"
    window = struct.pack("<4i", 0, 0, picture.width - 1, picture.height - 1)
    header = MAGIC
    for name, kind, value in (("channels", "chlist", channels), ("compression", "compression", b"\0"),
                              ("dataWindow", "box2i", window), ("displayWindow", "box2i", window),
                              ("lineOrder", "lineOrder", b"\0"), ("pixelAspectRatio", "float", struct.pack("<f", 1)),
                              ("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)),
                              ("screenWindowWidth", "float", struct.pack("<f", 1))):
        header += name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value
    header += b"\0"
    size = 4 * picture.width * len(names)
    first = len(header) + 8 * picture.height
    table = b"".join(struct.pack("<Q", first + y * (size + 8)) for y in range(picture.height))
    body = []
    for y in range(picture.height):
        row = picture.values[y * picture.width * picture.channels:(y + 1) * picture.width * picture.channels]
        line = struct.pack("<ii", y, size)
        for name in names:
            plane = [alpha] * picture.width if name == "A" else row[planes[name]::picture.channels]
            line += array.array("f", plane).tobytes()
        body.append(line)
    pathlib.Path(path).write_bytes(header + table + b"".join(body))


def encode_srgb(value):
    value = min(max(value, 0.0), 1.0)
    return 12.92 * value if value <= 0.0031308 else 1.055 * value ** (1 / 2.4) - 0.055


def write_png(path, picture, bits=8, encode=encode_srgb):
    """8 or 16 bits; `encode` makes stored values of linear ones."""
    top = (1 << bits) - 1
    stored = [round(top * encode(value)) for value in picture.values]
    raw = b""
    length = picture.width * picture.channels
    for y in range(picture.height):
        row = stored[y * length:(y + 1) * length]
        raw += b"\0" + (bytes(row) if bits == 8 else struct.pack(f">{length}H", *row))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    kind = 2 if picture.channels == 3 else 0
    head = struct.pack(">IIBBBBB", picture.width, picture.height, bits, kind, 0, 0, 0)
    pathlib.Path(path).write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(raw)) +
                                   chunk(b"IEND", b""))
