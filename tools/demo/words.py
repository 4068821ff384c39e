# SPDX-License-Identifier: Apache-2.0
# SPDX-FileCopyrightText: The Volute authors
"""Figures as the page writes them."""
import math

NBSP = "\u00a0"
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def bytes_of(count):
    for unit, size in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if count >= size:
            return f"{count / size:.3g}{NBSP}{unit}"
    return f"{count}{NBSP}bytes"


def ratio(results, original, compressed):
    """Bytes on disk to bytes on disk."""
    return f"{results.size(original) / results.size(compressed):.0f}{NBSP}:{NBSP}1"


def digits(value, count=2):
    """So many digits that count; small values by their power of ten, so never a row of zeros."""
    if value == 0:
        return "0"
    power = math.floor(math.log10(abs(value)))
    if power < -3:
        return f"{value / 10.0 ** power:.{count - 1}f}·10" + str(power).translate(SUPERSCRIPTS)
    return f"{value:.{max(0, count - 1 - power)}f}"


def percent(share):
    """To two digits."""
    return f"{digits(100 * share)}{NBSP}%"
