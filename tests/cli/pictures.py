# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""OpenEXR and PNG pictures with the standard library alone: what the tests read and write."""
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
    """Scan lines of floats or halves, uncompressed or ZIP(S); channels R, G, B, or Y, and A last."""
    data = pathlib.Path(path).read_bytes()
    assert data[:5] == MAGIC[:5] and not data[5] & ~4, path  # one part of scan lines; long names are no matter
    header, at = attributes(data)
    entries = list(split_channels(header["channels"]))
    names = [entry.split(b"\0")[0].decode() for entry in entries]
    halves = entries[0][-16] == 1  # all of them, or none
    kind, size_of = ("e", 2) if halves else ("f", 4)
    x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    rows = {0: 1, 2: 1, 3: 16}[header["compression"][0]]
    picture = Picture(width, height, len(names))
    order = [names.index(name) for name in ("R", "G", "B", "A") if name in names] if len(names) >= 3 else [0]
    count = (height + rows - 1) // rows
    for (offset,) in struct.iter_unpack("<Q", data[at:at + 8 * count]):
        y, size = struct.unpack_from("<ii", data, offset)
        lines = min(rows, height - (y - y0))
        block = data[offset + 8:offset + 8 + size]
        if header["compression"][0] and size < lines * size_of * width * len(names):
            block = unpredicted(zlib.decompress(block))
        values = struct.unpack(f"<{len(block) // size_of}{kind}", block)
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


def exr_attribute(name, kind, data):
    return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(data)) + data


class Part:
    """Channels {"Y": values} of one size, row 0 at the top, with the header of an OpenEXR part. Windows are left, top, right and bottom,
    all of them inside."""

    def __init__(self, width, height, planes, name="", half=(), data=None, display=None, aspect=1.0, more=b""):
        self.width, self.height, self.planes, self.name, self.half = width, height, planes, name, half
        self.data = data or (0, 0, width - 1, height - 1)
        self.display, self.aspect, self.more = display or self.data, aspect, more
        self.names = sorted(planes)

    def header(self, several):
        listed = b"".join(name.encode() + b"\0" + struct.pack("<iIii", 1 if name in self.half else 2, 0, 1, 1) for name in self.names)
        header = exr_attribute("channels", "chlist", listed + b"\0") + exr_attribute("compression", "compression", b"\0")
        header += exr_attribute("dataWindow", "box2i", struct.pack("<4i", *self.data))
        header += exr_attribute("displayWindow", "box2i", struct.pack("<4i", *self.display))
        header += exr_attribute("lineOrder", "lineOrder", b"\0")
        header += exr_attribute("pixelAspectRatio", "float", struct.pack("<f", self.aspect))
        header += exr_attribute("screenWindowCenter", "v2f", bytes(8)) + exr_attribute("screenWindowWidth", "float", struct.pack("<f", 1))
        if several:
            header += exr_attribute("name", "string", self.name.encode()) + exr_attribute("type", "string", b"scanlineimage")
            header += exr_attribute("chunkCount", "int", struct.pack("<i", self.height))
        return header + self.more + b"\0"

    def rows(self):
        for y in range(self.height):
            row = b"".join(struct.pack(f"<{self.width}{'e' if name in self.half else 'f'}",
                                       *self.planes[name][y * self.width:(y + 1) * self.width]) for name in self.names)
            yield struct.pack("<ii", self.data[1] + y, len(row)) + row


def write_parts(path, parts):
    """OpenEXR without compression, of one part or several."""
    several = len(parts) > 1
    header = MAGIC[:5] + bytes([0x10 if several else 0, 0, 0]) + b"".join(part.header(several) for part in parts) + several * b"\0"
    chunks = [(struct.pack("<i", i) if several else b"") + row for i, part in enumerate(parts) for row in part.rows()]
    at, table = len(header) + 8 * len(chunks), []
    for chunk in chunks:
        table.append(struct.pack("<Q", at))
        at += len(chunk)
    pathlib.Path(path).write_bytes(header + b"".join(table) + b"".join(chunks))


def write_planes(path, width, height, planes):
    """OpenEXR without compression; planes: {"Y": values} or {"R": .., "G": .., "B": ..}, row 0 at the top."""
    write_parts(path, [Part(width, height, planes)])


def write_exr(path, picture, alpha=None):
    """As write_planes; `alpha` adds a channel A of that value."""
    names = "RGB" if picture.channels == 3 else "Y"
    planes = {name: picture.values[c::picture.channels] for c, name in enumerate(names)}
    if alpha is not None:
        planes["A"] = [alpha] * (picture.width * picture.height)
    write_planes(path, picture.width, picture.height, planes)


def encode_srgb(value):
    value = min(max(value, 0.0), 1.0)
    return 12.92 * value if value <= 0.0031308 else 1.055 * value ** (1 / 2.4) - 0.055


def write_rows(path, rows, bits=8, channels=1):
    """PNG of whole numbers, stored as they are; channels interleaved: 2 are grey and alpha, 4 with colours."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", len(rows[0]) // channels, len(rows), bits, {1: 0, 2: 4, 3: 2, 4: 6}[channels], 0, 0, 0)
    kind = "B" if bits == 8 else "H"
    raw = b"".join(b"\0" + struct.pack(f">{len(row)}{kind}", *row) for row in rows)
    pathlib.Path(path).write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(raw)) +
                                   chunk(b"IEND", b""))


def write_png(path, picture, bits=8, encode=encode_srgb):
    """8 or 16 bits; `encode` makes stored values of linear ones."""
    top = (1 << bits) - 1
    stored = [round(top * encode(value)) for value in picture.values]
    length = picture.width * picture.channels
    write_rows(path, [stored[y * length:(y + 1) * length] for y in range(picture.height)], bits, picture.channels)
