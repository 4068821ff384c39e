#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A second decoder of .volute files, written from docs/format.md alone: small and slow, so that the page is known to suffice.

    volute_decoder.py FILE.volute OUT.npy [GRID]     OUT: float32 (float64 with an offset), (t, z, y, x[, c])

Numbers in comments are sections of docs/format.md. It checks every checksum that it meets and refuses what it does not know.
"""
import bisect
import ctypes
import functools
import itertools
import math
import struct
import sys
import zlib

import numpy as np

f32 = np.float32

def check(condition, message):
    if not condition:
        raise SystemExit(message)

# Numbers of a payload, from its first byte on.
class Reader:
    def __init__(self, data):
        self.data, self.at = data, 0
    def take(self, count):
        check(self.at + count <= len(self.data), "a payload is too short")
        self.at += count
        return self.data[self.at - count:self.at]
    def unpack(self, form):
        values = struct.unpack("<" + form, self.take(struct.calcsize("<" + form)))
        return values if len(values) > 1 else values[0]
    def floats(self, count):
        return struct.unpack(f"<{count}f", self.take(4 * count))
    def varint(self):
        value = 0
        for shift in range(0, 70, 7):
            byte = self.take(1)[0]
            value |= (byte & 127) << shift
            if byte < 128:
                return value
        raise SystemExit("a varint is longer than ten bytes")
    def zigzag(self):
        value = self.varint()
        return value // 2 if value % 2 == 0 else -(value + 1) // 2
    def bytes(self):
        return self.take(self.varint())
    def string(self):
        return self.bytes().decode()

# A packed payload (3).
def unpacked(payload):
    if payload[0] == 0:
        return payload[1:]
    check(payload[0] == 1, "a payload is packed in an unknown way")
    decompress, frame, content = ctypes.CDLL("libzstd.so.1").ZSTD_decompress, bytes(payload[1:]), ctypes.create_string_buffer(1 << 26)
    decompress.restype = ctypes.c_size_t
    size = decompress(content, ctypes.c_size_t(len(content)), frame, ctypes.c_size_t(len(frame)))
    check(size <= len(content), "a zstd frame is damaged, or of more than 64 MiB")
    return ctypes.string_at(content, size)

# ---- 8.2, 8.3: bits and contexts ---------------------------------------------------------------

LIMITS = {"S": [0, 1, 2, 4, 6, 9, 14, 22, 40], "Z": [0, 1, 2, 4, 9],
          "W": [0, 1, 2, 4, 6, 9, 14, 22, 32, 46, 66, 94, 134, 190]}
S, Z, W = ([sum(n > limit for limit in LIMITS[name]) for n in range(20000)] for name in "SZW")

SHAPES = {"shaped": (1,), "wavelet": (2,), "time": (3,), "end": (1,), "line": (2,), "support": (4096,), "scaling": (32,),
          "cell": (4, 10, 6, 4), "zero": (4, 5, 10, 6, 6), "size": (4, 5, 15, 16), "long": (15, 32), "corrected": (3,),
          "correction": (32,), "full": (1,), "coded": (1,), "other": (1,), "other voxel": (3, 3, 3, 3), "outliers": (4,)}
FIRST = dict(zip(SHAPES, itertools.accumulate([0] + [math.prod(shape) for shape in SHAPES.values()])))
CONTEXTS = sum(math.prod(shape) for shape in SHAPES.values())

def context(name, *index):
    return FIRST[name] + functools.reduce(lambda place, next: place * next[0] + next[1], zip(SHAPES[name], index), 0)

# S of a context of cell or zero; None for other ones.
def sum_class(number):
    for name in ("cell", "zero"):
        inner = math.prod(SHAPES[name][-2:])
        if 0 <= number - FIRST[name] < math.prod(SHAPES[name]):
            return (number - FIRST[name]) // inner % 10

# The bits of a segment.
class Bits:
    def __init__(self, data, contexts, shared=False):
        self.data, self.contexts, self.shared = data, contexts, shared
        self.range, self.code, self.at = 2**64 - 1, int.from_bytes(data[:8].ljust(8, b"\0"), "big"), 8
        self.evens = 0
    def bit(self, number):
        return self.coded(self.contexts[number])
    def coded(self, state):
        p, n = state
        bound = (self.range >> 16) * p
        if self.code < bound:
            bit, self.range = 1, bound
        else:
            bit, self.range, self.code = 0, self.range - bound, self.code - bound
        if self.range < 2**32:
            self.range <<= 32
            self.code = self.code << 32 | int.from_bytes(self.data[self.at:self.at + 4].ljust(4, b"\0"), "big")
            self.at += 4
        p += (65535 * bit - p) * (327680 // (10 * n + 16)) // 32768
        state[0], state[1] = min(max(p, 64), 65472), min(n + 1, 250)
        return bit
    def even(self):
        if self.shared:
            return self.coded([32768, 0])
        byte = self.data[-1 - self.evens // 8]
        self.evens += 1
        return byte >> ((self.evens - 1) % 8) & 1
    # A number of so many bits, whose first is 1.
    def below_first(self, bits):
        return functools.reduce(lambda value, _: 2 * value + self.even(), range(bits - 1), 1)
    # A number as the scaling coefficients have (8.6).
    def signed(self, contexts):
        bits = 0
        while bits < 30 and self.bit(contexts + bits):
            bits += 1
        if not bits:
            return 0
        value = self.below_first(bits)
        return -value if self.even() else value

# Probabilities in tables.
def probability(index):
    return min(max(32 * index**2 if index <= 32 else 65536 - 32 * (64 - index)**2, 64), 65472)

# A difference of indices: negative, longer are contexts.
def difference(bits, negative, longer):
    down, size = bits.bit(negative), 1
    while size < 63 and bits.bit(longer + min(size, 8) - 1):
        size += 1
    return -size if down else size

# The contexts of the file (8.3).
def context_table(data):
    if not data:
        return [[2000 + 4500 * s, 2] if s is not None else [32768, 0] for s in map(sum_class, range(CONTEXTS))]
    present, zero, negative, longer = 0, 2, 3, 4
    bits = Bits(data, [[32768, 0] for _ in range(12)])
    last, before, contexts = 32, 0, []
    for _ in range(CONTEXTS):
        before = bits.bit(present + before)
        if before and not bits.bit(zero):
            last = min(max(last + difference(bits, negative, longer), 1), 63)
        contexts.append([probability(last), 40 if before else 2])
    return contexts

# ---- 10.4: symbols -----------------------------------------------------------------------------

CELLS, COEFFICIENTS = 4 * 10 * 6 * 4, 4 * 7 * 16 * 4 * 2
LENGTH, LONGER = CELLS + COEFFICIENTS, CELLS + COEFFICIENTS + 16
ORDER = [1, 2, 4, 8, 3, 5, 6, 9, 10, 12, 7, 11, 13, 14, 15]

# Where symbols begin among 2^15 places, for each context.
def symbol_table(data):
    def guess(context):
        if context < CELLS:
            return [8 + 5 * (context // 24 % 10)] + 14 * [24]
        if context < LENGTH:
            near, siblings = (context - CELLS) // 8 % 16, (context - CELLS) // 2 % 4
            return [min(63, 10 + 3 * near + 3 * siblings)] + 14 * [16 + 2 * near]
        return 15 * [24]
    bits, before, last, tables = Bits(data, [[32768, 0] for _ in range(2 + 3 * 4 + 32)]), 0, None, []
    present, more, zero, negative, longer = 0, 2, 6, 10, 14
    for context in range(LONGER + 1):
        if not data or context in (0, CELLS, LENGTH):
            last = guess(context)
        symbols = 2 if context < CELLS else 16
        before = bits.bit(present + before) if data else 0
        for s in range(symbols - 1) if before else ():
            kind = min(s, 3)
            if s and not bits.bit(more + kind):
                break
            if not bits.bit(zero + kind):
                last[s] = min(max(last[s] + difference(bits, negative + kind, longer + 8 * kind), 1), 63)
        left, begins = 2**15 - symbols, [0]
        for s in range(symbols - 1):
            greater = left * probability(last[s]) >> 16
            begins.append(begins[-1] + left - greater + 1)
            left = greater
        tables.append(begins + [2**15])
    return tables

# The symbols of a segment, from its end backwards.
class Symbols:
    def __init__(self, data, tables):
        self.data, self.at, self.tables, self.lanes = data, len(data), tables, []
        head = self.byte()
        e = head >> 1 & 15
        self.lanes.append(2**(16 + e) + (head >> 5) + sum(self.byte() << (3 + 8 * i) for i in range((20 + e) // 8)))
        check(self.lanes[0] < 2**(17 + e), "a string of symbols is malformed")
        for _ in range(3 if head & 1 else 0):
            e = self.bits(4, 0)
            low = self.bits(16, 0)
            self.lanes.append(2**(16 + e) + (self.bits(e, 0) << 16) + low)
    def byte(self):
        self.at -= 1
        check(self.at >= 0, "a string of symbols is too short")
        return self.data[self.at]
    def settle(self, lane, x):
        self.lanes[lane] = x << 16 | self.byte() << 8 | self.byte() if x < 2**16 else x
    def bits(self, count, lane):
        lane %= len(self.lanes)
        x = self.lanes[lane]
        self.settle(lane, x >> count)
        return x & ((1 << count) - 1)
    def symbol(self, context, lane):
        lane %= len(self.lanes)
        x, begins = self.lanes[lane], self.tables[context]
        place = x & (2**15 - 1)
        s = bisect.bisect_right(begins, place) - 1
        self.settle(lane, (begins[s + 1] - begins[s]) * (x >> 15) + place - begins[s])
        return s
    # What follows the last symbol.
    def signs(self, count):
        check(all(x >> 16 == 1 for x in self.lanes), "a string of symbols is malformed")
        bits = sum((x & 0xFFFF) << 16 * i for i, x in enumerate(self.lanes))
        for have in range(16 * len(self.lanes), count, 8):
            bits |= self.byte() << have
        check(bits >> count == 0, "a string of symbols is malformed")
        return [bits >> i & 1 for i in range(count)]

NEAR = [sum(n > limit for limit in (0, 1, 2, 4, 6, 10, 15, 22, 34, 51, 76, 115, 172, 258, 387)) for n in range(389)]

# The coefficients `places` of a cell that is not empty: fills q and mags.
def cell_by_symbols(symbols, j, q, mags, places, around, above):
    seen = [0] * 16
    for i, k in enumerate(ORDER):
        if k not in places:
            continue
        near = NEAR[min(388, around[k] + above[k] // 2)]
        beside = sum(seen[k & ~b] for b in (1, 2, 4, 8) if k & b and k & ~b)
        siblings = sum(beside > limit for limit in (0, 2, 7))
        orientation = bin(k & 7).count("1") + (k >> 3) * 4 - 1
        s = symbols.symbol(CELLS + (((j * 7 + orientation) * 16 + near) * 4 + siblings) * 2 + (above[k] > 0), i)
        seen[k], m = s, s
        if s == 15:
            length = symbols.symbol(LENGTH + near, i)
            if length == 15:
                length += symbols.symbol(LONGER, i)
            check(length < 30, "a coefficient is too great")
            high = symbols.bits(length - 15, i) if length > 15 else 0
            m = 14 + (1 << length) + (high << 15) + symbols.bits(min(length, 15), i)
        mags[k] = min(m, 255)
        q[places[k]] = m

# ---- 8.6: the transform ------------------------------------------------------------------------

LIFTING = {"5/3": [-0.5, 0.25], "9/7": [-1.586134342059924, -0.052980118572961, 0.882911075530934, 0.443506852043971]}
SCALE = {"5/3": math.sqrt(2), "9/7": 1.149604398860241}
NORMS = {"5/3": ([1, .866025404, .829156198, .819679816, .817293552], [1, 1.198957881, .960143218, .890487928, .872205359]),
         "9/7": ([1, .991440194, 1.015185928, 1.025715858, 1.028821294], [1, 1.020017629, .983471304, 1.019621394, 1.036880210]),
         "haar": ([1] * 5, [1] * 5)}

# Undoes one halving of the last axis, in place.
def unlift(x, mask, wavelet):
    n = x.shape[-1]
    even = np.arange(n) % 2 == 0
    if wavelet == "haar":
        pairs = n // 2
        a, b = x[..., 0:2 * pairs:2].copy(), x[..., 1:2 * pairs:2].copy()
        in_a, in_b = mask[..., 0:2 * pairs:2], mask[..., 1:2 * pairs:2]
        both, half = in_a & in_b, f32(math.sqrt(0.5))
        x[..., 0:2 * pairs:2] = np.where(both, (a + b) * half, np.where(in_a, a * half, a))
        x[..., 1:2 * pairs:2] = np.where(both, (a - b) * half, b)
        if n % 2:
            x[..., n - 1] = np.where(mask[..., n - 1], x[..., n - 1] * half, x[..., n - 1])
        return
    none = np.zeros_like(mask[..., :1])
    left = np.concatenate([none, mask[..., :-1]], -1)
    right = np.concatenate([mask[..., 1:], none], -1)
    lone = ~left & ~right
    k = SCALE[wavelet]
    x[...] = np.where(mask, x * np.where(lone, np.where(even, f32(math.sqrt(0.5)), f32(1)), np.where(even, f32(1 / k), f32(k))), x)
    for step, factor in reversed(list(enumerate(LIFTING[wavelet]))):
        zero = np.zeros_like(x[..., :1])
        before, after = np.concatenate([zero, x[..., :-1]], -1), np.concatenate([x[..., 1:], zero], -1)
        total = np.where(left, before, after) + np.where(right, after, before)
        place = (even if step % 2 else ~even) & mask & ~lone
        x[...] = np.where(place, x - f32(factor) * total, x)

# The synthesis norm of each coefficient of a block (t, z, y, x).
def norms(shape, halved, wavelet):
    lows, highs = NORMS[wavelet]
    norm = np.full(shape, math.prod(lows[h] for h in halved))
    for j in reversed(range(max(halved))):
        for k in range(1, 16):
            if any(k & (8 >> a) and j >= halved[a] for a in range(4)):
                continue
            place, value = [], 1.0
            for a, h in enumerate(halved):
                high, after = bool(k & (8 >> a)), min(j + 1, h)
                place.append(slice(2**j if high else 0, None, 2**after))
                value *= highs[j + 1] if high else lows[after]
            norm[tuple(place)] = value
    return norm

# Undoes all halvings of a component (t, z, y, x); `halved`: how often each axis was.
def inverse(values, mask, wavelet, halved):
    for j in reversed(range(max(halved))):
        for axis in range(4):
            if j >= halved[axis]:
                continue
            grid = tuple(slice(None, None, 2**min(j, h)) for h in halved)
            unlift(np.moveaxis(values[grid], axis, -1), np.moveaxis(mask[grid], axis, -1), wavelet)

# ---- 8.4 to 8.7: a block -----------------------------------------------------------------------

# Parameters of the codec (8.1, 10.1).
class Codec:
    def __init__(self, number, data, channels):
        r = Reader(data)
        self.topology, self.by_symbols, self.background, self.inactive, self.bent, self.offset = False, False, np.zeros(channels, f32), None, None, 0
        self.frames, self.means = 16, False
        if number == 3:
            flags = r.unpack("B")
            more = r.unpack("B") if flags & 16 else 0
            check(flags < 32 and more & 7 <= 4 and more < 32, "parameters of another version")
            self.by_symbols, self.topology = flags & 4, not flags & 8
            self.frames, self.means = 16 >> (more & 7), more & 8
            self.offset = r.unpack("d") if more & 16 else 0
            self.background = np.array(r.floats(channels), f32)
            self.inactive = np.array(r.floats(channels), f32) if flags & 1 else None
            self.bent = r.unpack("2d") if flags & 2 else None
        self.unit, self.step, self.max_error = f32(2.0**r.zigzag()), r.unpack("d"), r.unpack("d")
        self.one, self.more = r.varint(), r.zigzag()
        self.color = np.array(r.unpack("9f"), f32).reshape(3, 3) if channels == 3 else np.ones((1, 1), f32)
        self.contexts = context_table(r.bytes() if self.by_symbols else data[r.at:])
        self.tables = symbol_table(data[r.at:]) if self.by_symbols else None

def halvings(n):
    return (n - 1).bit_length()

# 8.5, as booleans (t, z, y, x).
def support(bits, shape):
    nt, nz, ny, nx = shape
    # One line of nothing around, on both sides of z and y and before t; columns -1 and nx are nothing too.
    s = np.zeros((nt + 1, nz + 2, ny + 2, nx + 2), np.int64)
    for t, z, y in itertools.product(range(1, nt + 1), range(1, nz + 1), range(1, ny + 1)):
        line = s[t, z, y]
        y1, z1, t1 = s[t, z, y - 1], s[t, z - 1, y], s[t - 1, z, y]
        zy, zy1, ty, tz = s[t, z - 1, y + 1], s[t, z - 1, y - 1], s[t - 1, z, y + 1], s[t - 1, z + 1, y]
        if not any(other.any() for other in (y1, z1, t1, zy, zy1, ty, tz)):
            if bits.bit(context("line", 0)):
                continue
        elif all(other[1:-1].all() for other in (y1, z1, t1)) and bits.bit(context("line", 1)):
            line[1:-1] = 1
            continue
        for x in range(1, nx + 1):
            near = (line[x - 1], y1[x], z1[x], t1[x], y1[x + 1], z1[x + 1], zy[x], t1[x + 1], ty[x], tz[x], y1[x - 1], zy1[x])
            line[x] = bits.bit(context("support", sum(int(b) << i for i, b in enumerate(near))))
    return s[1:, 1:-1, 1:-1, 1:-1].astype(bool)

# 10.2: 0 where a voxel is empty, 1 where it is active, 2 where it has a value and is not.
def topology(bits, shape):
    states = np.ones(shape, np.int64)
    if bits.bit(context("full")):
        return states
    states[...] = support(bits, shape)
    if bits.bit(context("other")):
        for place in np.ndindex(*shape):
            if not states[place]:
                before = [states[place[:a] + (place[a] - 1,) + place[a + 1:]] if place[a] else 0 for a in range(4)]
                states[place] = 2 * bits.bit(context("other voxel", *before))
    return states

# 10.2, as places and values.
def outliers(bits, shape, channels):
    found = []
    if bits.bit(context("outliers", 0)):
        for line in np.ndindex(*shape[:3]):
            before = 0
            for x in range(shape[3]) if bits.bit(context("outliers", 1)) else ():
                before = bits.bit(context("outliers", 2 + before))
                if before:
                    words = [functools.reduce(lambda w, _: 2 * w + bits.even(), range(32), 0) for _ in range(channels)]
                    found.append(((*line, x), np.array(words, np.uint32).view(f32)))
    return found

# Spacing and number of the cells of stride 2^j on each axis.
def cell_grid(j, halved, shape):
    spacing = [2**(j + 1) if j < h else 2**h for h in halved]
    return spacing, [-(-n // s) for n, s in zip(shape, spacing)]

BACK = [(2, tuple(-(i == a) for i in range(4))) for a in range(4)] + [
    (1, tuple(-1 if i == a else d if i == b else 0 for i in range(4)))
    for a in range(4) for b in range(a + 1, 4) for d in (-1, 1)]

# One component of one stride: fills q (t, z, y, x) and mags (cells and 16).
def decode_cells(bits, j, q, mags, coarse, mask, halved, symbols, found):
    shape = q.shape
    spacing, count = cell_grid(j, halved, shape)
    high = [k for k in range(1, 16) if all(j < halved[a] for a in range(4) if k & (8 >> a))]
    for cell in itertools.product(*map(range, count)):
        places = {}
        for k in high:
            place = tuple(c * s + (2**j if k & (8 >> a) else 0) for a, (c, s) in enumerate(zip(cell, spacing)))
            if all(p < n for p, n in zip(place, shape)) and mask[place]:
                places[k] = place
        if not places:
            continue
        around, sums = [0] * 16, 0
        for weight, offset in BACK:
            other = tuple(c + o for c, o in zip(cell, offset))
            if all(0 <= c < n for c, n in zip(other, count)):
                for k, m in enumerate(mags[other]):
                    around[k] += weight * int(m)
                sums += weight * min(255, int(mags[other].sum()))
        above = [0] * 16
        if coarse is not None:
            above = [int(m) for m in coarse[tuple(c // 2 if j + 1 < halved[a] else c for a, c in enumerate(cell))]]
        total = len(places)
        members = sum(total > limit for limit in (3, 7, 14))
        if symbols:
            parents = Z[(min(255, sum(above)) + 1) // 2]
            if symbols.symbol(((j * 10 + S[(sums + 2) // 4]) * 6 + parents) * 4 + members, cell[3]):
                cell_by_symbols(symbols, j, q, mags[cell], places, around, above)
                found += [places[k] for k in ORDER if k in places and q[places[k]]]
            continue
        if not bits.bit(context("cell", j, S[(sum(around) + 2) // 4], Z[(sum(above) + 1) // 2], members)):
            continue
        any_before = False
        for at, k in enumerate(sorted(places)):
            siblings = sum(int(mags[cell][k & ~b]) for b in (1, 2, 4, 8) if k & b and k & ~b)
            highs, parent = bin(k).count("1"), 2 * above[k]
            every = W[(around[k] + parent + 2 * siblings + 1) // 2]
            if any_before or at + 1 < total:
                if not bits.bit(context("zero", j, highs, S[(around[k] + 1) // 2], Z[parent], Z[siblings])):
                    continue
            any_before, m = True, 1
            while m <= 15 and bits.bit(context("size", j, highs, every, m)):
                m += 1
            if m > 15:
                more = 0
                while more < 29 and bits.bit(context("long", every, more)):
                    more += 1
                m = 15 + bits.below_first(more + 1)
            mags[cell][k] = min(m, 255)
            q[places[k]] = -m if bits.even() else m

# Puts in what no coefficients say (10.2).
def known(codec, values, states, coded):
    values[states == 0] = codec.background
    if codec.inactive is not None:
        values[(states == 2) & ~coded] = codec.inactive
    return values

# A block (t, z, y, x, c) of `shape` from its three tiers.
def decode_block(codec, segments, shape, channels, low, high):
    nothing = np.clip(np.zeros((*shape, channels), f32), low, high)
    if not segments[0]:
        return nothing
    contexts = [list(c) for c in codec.contexts]
    bits = Bits(segments[0], contexts, codec.by_symbols)
    coded, apart = np.ones(shape, bool), []
    if codec.topology:
        states = topology(bits, shape)
        coded = (states == 1) | (states == 2) & (codec.inactive is None)
        if not bits.bit(context("coded")):
            return known(codec, nothing, states, coded)
        apart = outliers(bits, shape, channels)
    shaped = 0 if codec.topology and coded.all() else bits.bit(context("shaped"))
    wavelet = "9/7" if not bits.bit(context("wavelet", 0)) else "haar" if bits.bit(context("wavelet", 1)) else "5/3"
    m = bits.bit(context("time", 0))
    time = [[0, 1], [2, 4]][m][bits.bit(context("time", 1 + m))]
    mask = np.ones(shape, bool) if not shaped else coded if codec.topology else support(bits, shape)
    space = halvings(max(shape[1:]))
    halved = [min(time, halvings(shape[0]))] + 3 * [space]
    q = np.zeros((channels, *shape), np.int64)
    for c in range(channels):
        for place in itertools.product(*(range(0, n, 2**h) for n, h in zip(shape, halved))):
            if mask[place]:
                q[(c, *place)] = bits.signed(FIRST["scaling"])
    levels = 1 + halvings(max(shape))
    coarse = [None] * channels
    for tier, tier_levels in enumerate([(1, 2), (3,), (4,)]):
        if tier:
            if not segments[tier]:
                coarse = None
                continue
            bits = Bits(segments[tier], contexts, codec.by_symbols)
        symbols, order = Symbols(segments[tier], codec.tables) if codec.by_symbols else None, []
        for level in tier_levels:
            j = levels - 1 - level
            if not 0 <= j < max(halved):
                continue
            count = cell_grid(j, halved, shape)[1]
            mags = [np.zeros((*count, 16), np.int64) for _ in range(channels)]
            for c in range(channels):
                found = []
                decode_cells(bits, j, q[c], mags[c], coarse[c] if coarse else None, mask, halved, symbols, found)
                order += [(c, *place) for place in found]
            coarse = mags
        for place, negative in zip(order, symbols.signs(len(order)) if symbols else ()):
            q[place] *= 1 - 2 * negative
    sized = np.where(abs(q) > 1, abs(q) + codec.more / 256, abs(q) * (codec.one / 256)) * np.sign(q)
    coefficients = (sized * (codec.step / norms(shape, halved, wavelet))).astype(f32)
    for c in range(channels):
        inverse(coefficients[c], mask, wavelet, halved)
    values = np.stack([np.where(mask, functools.reduce(np.add, codec.color[:, c, None, None, None, None] * coefficients) * codec.unit, f32(0))
                       for c in range(channels)], -1)
    if codec.bent:
        t = codec.bent[0] * abs(values.astype(np.float64))
        values = np.copysign(t * (t + codec.bent[1]), values).astype(f32)
    values = values.clip(low, high)
    if codec.topology:
        known(codec, values, states, coded)
    for place, value in apart:
        values[place] = value.clip(low, high)
    if codec.max_error and segments[2] and bits.bit(context("end")):
        unit = 2 * (1 - 1 / 128) * codec.max_error
        for place in itertools.product(*map(range, shape[:3])):
            if not bits.bit(context("corrected", 0)):
                continue
            before, line = 0, values[place].reshape(-1)
            for i in range(line.size):
                before = bits.bit(context("corrected", 1 + before))
                if before:
                    number = bits.signed(FIRST["correction"])
                    line[i] = np.clip(f32(float(line[i]) + (number if number > 0 else number + 1) * unit), low, high)
    return values

# ---- 2 to 6: the container ---------------------------------------------------------------------

# INFO (4) and what follows it for one grid.
class Grid:
    def __init__(self, codec, data):
        r, self.codec = Reader(data), codec
        self.name = r.string()
        [r.string() for _ in range(3)]
        self.frames, *self.size, self.channels = [r.varint() for _ in range(5)]
        r.unpack("6dB")
        [r.zigzag() for _ in range(self.frames)]
        r.unpack("2d" if r.unpack("B") == 0 else f"{self.frames}d")
        r.unpack("Bd")
        _, _, self.low, self.high = r.unpack("4d")
        self.tiers = [r.varint() for _ in range(r.varint())]
        self.parameters, self.parts = r.bytes(), []
        check(self.tiers == [3, 1, 1], "tiers of another codec")
        first = Codec(codec, self.parameters, self.channels)
        self.means, self.sides = first.means, (first.frames, 16, 16, 16)
        self.blocks = [-(-n // side) for n, side in zip((self.frames, *self.size), self.sides)]
    def read_parts(self, data):
        r, row = Reader(data), 0
        for _ in range(r.varint()):
            row += r.varint()
            self.parts.append((row, *r.unpack("2f"), r.bytes()))
    def read_index(self, data):
        r, self.numbers = Reader(data), range(math.prod(self.blocks))
        if self.codec == 3:
            self.tile_pages = [(r.varint(), r.varint(), r.unpack("I")) for _ in range(r.varint())]
            self.pages = [(r.varint(), r.varint(), r.varint(), r.unpack("I"), [r.varint() for _ in self.tiers])
                          for _ in range(r.varint())]
        else:
            self.sizes = [[r.varint() for _ in self.numbers] for _ in self.tiers]
            self.crcs = [[r.unpack("I") if size else 0 for size in tier] for tier in self.sizes]
        check(r.at == len(data), "INDX is too long")
    # 6.1, 10.3; where they end.
    def read_pages(self, data, at):
        def page(size, crc):
            nonlocal at
            at += size
            check(zlib.crc32(data[at - size:at]) == crc, "a page's checksum is wrong")
            return Reader(unpacked(data[at - size:at]))
        self.tiles, self.numbers, self.sizes, first = [[] for _ in range(self.frames)], [], [[] for _ in self.tiers], 0
        starts = list(itertools.accumulate(step for step, _, _ in self.tile_pages)) + [self.blocks[0]]
        for i, (_, size, crc) in enumerate(self.tile_pages):
            r = page(size, crc)
            for frame in range(self.sides[0] * starts[i], min(self.sides[0] * starts[i + 1], self.frames)):
                origin, value = [0, 0, 0], [0.0] * self.channels
                for _ in range(r.varint()):
                    what = r.unpack("B")
                    origin = [o + r.zigzag() for o in origin]
                    value = value if what & 1 else r.floats(self.channels)
                    self.tiles[frame].append((origin, 1 << (what >> 2), value))
            check(r.at == len(r.data), "a page of tiles is too long")
        for step, count, size, crc, totals in self.pages:
            r, first = page(size, crc), first + step
            self.numbers += itertools.accumulate([first] + [r.varint() for _ in range(count - 1)])
            for tier, total in zip(self.sizes, totals):
                tier += [r.varint() for _ in range(count)]
                check(sum(tier[-count:]) == total, "a page's sizes do not add up")
            [r.zigzag() for _ in range(count * self.channels if self.means else 0)]
            check(r.at == len(r.data), "a page is too long")
        return at
    def segment(self, data, tier, i):
        if self.codec == 3 and data:
            check(zlib.crc32(data[:-4]) == struct.unpack("<I", data[-4:])[0], "a segment's checksum is wrong")
            return data[:-4]
        check(not data or zlib.crc32(data) == self.crcs[tier][i], "a segment's checksum is wrong")
        return data
    def decode(self, data, offsets):
        parts = self.parts or [(0, self.low, self.high, b"")]
        codecs = [Codec(self.codec, parameters or self.parameters, self.channels) for *_, parameters in parts]
        values = np.empty((self.frames, *self.size, self.channels), f32)
        for codec, (row, *_) in zip(codecs, parts):
            values[self.sides[0] * row:] = codec.background
        ends = list(offsets)
        for i, number in enumerate(self.numbers):
            t, z, y, x = np.unravel_index(number, self.blocks)
            part = max(p for p, (row, *_) in enumerate(parts) if row <= t)
            codec, (_, low, high, _) = codecs[part], parts[part]
            segments = []
            for tier in range(len(self.tiers)):
                ends[tier] += self.sizes[tier][i]
                segments.append(self.segment(data[ends[tier] - self.sizes[tier][i]:ends[tier]], tier, i))
            corner = [side * int(n) for side, n in zip(self.sides, (t, z, y, x))]
            shape = tuple(min(side, n - c) for side, n, c in zip(self.sides, (self.frames, *self.size), corner))
            place = tuple(slice(c, c + n) for c, n in zip(corner, shape))
            values[place] = decode_block(codec, segments, shape, self.channels, f32(low), f32(high))
        for frame, tiles in enumerate(self.tiles if self.codec == 3 else ()):
            for origin, side, value in tiles:
                values[(frame, *(slice(max(o, 0), max(o + side, 0)) for o in reversed(origin)))] = value
        values = values.astype(np.float64) + codecs[0].offset if codecs[0].offset else values
        return values if self.channels > 1 else values[..., 0]

# KEEP (4.5): grids that are not coded, a piece of each frame.
class Kept:
    def __init__(self, data):
        r, self.grids = Reader(data), {}
        for _ in range(r.varint()):
            name, _, _ = r.string(), r.string(), r.varint()
            self.grids[name] = [r.varint() - 1 for _ in range(r.varint())]
        self.pieces = [r.varint() for _ in range(r.varint())]
        self.parts = [[(r.varint(), r.unpack("I")) for _ in range(-(-piece >> 24))] for piece in self.pieces]
        self.total = sum(size for piece in self.parts for size, _ in piece)
    def read(self, data, name):
        at, pieces = len(data) - self.total, []
        for piece, length in zip(self.parts, self.pieces):
            whole = b""
            for size, crc in piece:
                check(zlib.crc32(data[at:at + size]) == crc, "a kept part's checksum is wrong")
                whole, at = whole + unpacked(data[at:at + size]), at + size
            check(len(whole) == length, "a kept piece has another length")
            pieces.append(whole)
        return [pieces[i] if i >= 0 else None for i in self.grids[name]]

# The values of a grid, of the first one with values without a name (of a stand-in where none has any); the bytes of each frame of one that is kept.
def read(path, name=None):
    with open(path, "rb") as file:
        data = file.read()
    check(data[:8] == b"\x89VLT\r\n\x1a\n", "no .volute file")
    major, _, codec, head, total, crc = struct.unpack_from("<HHIQQI", data, 8)
    check(major == 1 and codec in (2, 3), "another version")
    check(zlib.crc32(data[:32]) == crc and total == len(data), "the prologue is wrong, or the file was cut")
    at, grids, kept = 36, [], None
    while at < head:
        kind, flags, size, crc = struct.unpack_from("<4sIQI", data, at)
        payload = data[at + 20:at + 20 + size]
        check(zlib.crc32(data[at:at + 16]) == crc, "a chunk's checksum is wrong")
        check(zlib.crc32(payload) == struct.unpack_from("<I", data, at + 20 + size)[0], "a payload's checksum is wrong")
        at += 24 + size
        if kind == b"INFO":
            grids.append(Grid(codec, unpacked(payload)))
        elif kind == b"PART":
            grids[-1].read_parts(unpacked(payload))
        elif kind == b"INDX":
            grids[-1].read_index(unpacked(payload))
        elif kind == b"KEEP":
            kept = Kept(unpacked(payload))
        else:
            check(flags & 1 or kind == b"GRDS", "an unknown chunk")
    check(at == head, "the last chunk does not end at headBytes")
    offsets, end = {grid.name: [] for grid in grids}, head
    for grid in grids if codec == 3 else ():
        end = grid.read_pages(data, end)
    for tier in range(3):
        for grid in grids:
            offsets[grid.name].append(end)
            end += sum(grid.sizes[tier])
    check(end + (kept.total if kept else 0) == total, "the segments do not fill the file")
    if kept and name in kept.grids:
        return kept.read(data, name)
    grid = next((g for g in grids if name in (None, g.name)), None)
    check(grid, f"no grid with values has the name {name}")
    return grid.decode(data, offsets[grid.name])

if __name__ == "__main__":
    decoded = read(sys.argv[1], *sys.argv[3:])
    np.save(sys.argv[2], decoded)
